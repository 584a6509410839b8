//! Questionnaires: a strict subset of SurveyJS JSON. In: a file, or a shipped questionnaire (`assets/questionnaires/`); answers. Out:
//! visible questions, missing answers, scores.
//!
//! Elements: `radiogroup`, `checkbox`, `rating`, `boolean`, `matrix`, `text`, `comment`, `html`. Their keys: `name`, `title`,
//! `description`, `isRequired`, `visibleIf`, `choices`, `rateMin`, `rateMax`, `rateStep`, `minRateDescription`, `maxRateDescription`,
//! `columns`, `rows`, `html`, `inputType` (`number`, of a `text`) with `min` and `max`. `visibleIf` compares `{name}` with a word or number
//! by `=`, `<>`, `<`, `<=`, `>`, `>=` or `contains`, joined by `and` or `or` (`and` binds stronger); the type must be that of the answers.
//! One key is an extension: `scores`, weighted sums and means of answers.

pub use super::{
    answer_condition::VisibilityCondition,
    scores::{ScoreDefinition, ScoreMethod},
};

use super::{StudyError, question_fault::QuestionFault};
use crate::{
    analysis::data::person_answers::number_in,
    data_folders,
    file::{SETTINGS_BYTES, read_text},
    toml_text,
};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::Value;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Answers by name of the question; by `name.row` for a matrix.
pub type Answers = BTreeMap<String, Value>;

/// Questionnaire with its scores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Questionnaire {
    /// JSON Schema of the file, for editors.
    #[serde(rename = "$schema", default, skip_serializing)]
    #[schemars(with = "String")]
    schema: de::IgnoredAny,
    /// Title, shown above the questions.
    pub title: String,
    /// Source and licence, for the data set.
    #[serde(default)]
    pub description: String,
    /// Pages in the order of presentation.
    pub pages: Vec<QuestionnairePage>,
    /// Scores computed from the answers.
    #[serde(default)]
    pub scores: Vec<ScoreDefinition>,
}

/// Page: the elements shown together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
pub struct QuestionnairePage {
    /// Name of the page, an identifier.
    #[serde(default)]
    pub name: String,
    /// Title, shown above the page.
    #[serde(default)]
    pub title: String,
    /// Condition under which the page is shown.
    #[serde(default)]
    pub visible_if: Option<VisibilityCondition>,
    /// Questions and texts of the page.
    pub elements: Vec<QuestionElement>,
}

/// Question, or a text between questions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
pub struct QuestionElement {
    /// Kind of the question.
    #[serde(rename = "type")]
    pub kind: ElementKind,
    /// Name in the data.
    pub name: String,
    /// Text of the question.
    #[serde(default)]
    pub title: String,
    /// Explanation of the question.
    #[serde(default)]
    pub description: String,
    /// True if the question must be answered.
    #[serde(default)]
    pub is_required: bool,
    /// Condition under which the question is shown.
    #[serde(default)]
    pub visible_if: Option<VisibilityCondition>,
    /// Options to choose from (radiogroup, checkbox).
    #[serde(default)]
    pub choices: Vec<AnswerChoice>,
    /// Lowest value of a rating.
    #[serde(default = "one")]
    pub rate_min: f64,
    /// Highest value of a rating.
    #[serde(default = "five")]
    pub rate_max: f64,
    /// Step between the values of a rating.
    #[serde(default = "one")]
    pub rate_step: f64,
    /// Label of the lowest value of a rating.
    #[serde(default)]
    pub min_rate_description: String,
    /// Label of the highest value of a rating.
    #[serde(default)]
    pub max_rate_description: String,
    /// Options of a matrix, the same for each row.
    #[serde(default)]
    pub columns: Vec<AnswerChoice>,
    /// Questions of a matrix, one per row.
    #[serde(default)]
    pub rows: Vec<AnswerChoice>,
    /// Text of an html element, shown verbatim and without tags.
    #[serde(default)]
    pub html: String,
    /// Answers that a text allows.
    #[serde(default)]
    pub input_type: InputType,
    /// Lowest number of a text that asks for a number.
    #[serde(default)]
    pub min: f64,
    /// Highest number of a text that asks for a number.
    #[serde(default)]
    pub max: f64,
}

/// Answers that a text allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum InputType {
    /// Any text, without a check.
    #[default]
    Text,
    /// A number from `min` to `max`, possibly with a unit behind it.
    Number,
}

pub(super) fn one() -> f64 {
    1.0
}

fn five() -> f64 {
    5.0
}

/// Kind of a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ElementKind {
    /// One of several options.
    Radiogroup,
    /// Any number of several options.
    Checkbox,
    /// A number on a scale.
    Rating,
    /// Yes or no, stored as a boolean.
    Boolean,
    /// One of several options for each row.
    Matrix,
    /// One line of text.
    Text,
    /// Several lines of text.
    Comment,
    /// A text without a question.
    Html,
}

/// Option to choose, with its value in the data.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(with = "WrittenChoice")]
pub struct AnswerChoice {
    /// Value in the data.
    pub value: Value,
    /// Text on the screen.
    pub text: String,
}

/// Option as a file has it.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "only its schema is used")]
enum WrittenChoice {
    Word(String),
    Number(f64),
    Both(ValueAndText),
}

/// Value in the data, and the text on the screen.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ValueAndText {
    value: Value,
    text: String,
}

impl<'de> Deserialize<'de> for AnswerChoice {
    /// Accepts a word, a number, or both as `{ "value": 3, "text": "severe" }`.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        match &value {
            Value::String(word) => Ok(Self { text: word.clone(), value }),
            Value::Number(number) => Ok(Self { text: number.to_string(), value }),
            Value::Object(_) => {
                let both: ValueAndText = serde_json::from_value(value).map_err(de::Error::custom)?;
                Ok(Self { value: both.value, text: both.text })
            }
            other => {
                Err(de::Error::custom(format!("a choice is {other}; allowed: a word, a number or value and text")))
            }
        }
    }
}

impl QuestionElement {
    /// Returns the names of the question's answers in the data.
    pub fn answer_names(&self) -> Vec<String> {
        match self.kind {
            ElementKind::Html => Vec::new(),
            ElementKind::Matrix => self.rows.iter().map(|row| format!("{}.{}", self.name, word(&row.value))).collect(),
            _ => vec![self.name.clone()],
        }
    }

    /// Returns the values of a rating, lowest first.
    pub fn rates(&self) -> Vec<f64> {
        let n = ((self.rate_max - self.rate_min) / self.rate_step).round() as usize;
        (0..=n).map(|i| self.rate_min + self.rate_step * i as f64).collect()
    }

    /// Checks whether the kind of question allows this answer.
    pub fn accepts(&self, answer: &Value) -> bool {
        let one_of = |choices: &[AnswerChoice], value: &Value| choices.iter().any(|choice| choice.value == *value);
        match self.kind {
            ElementKind::Radiogroup => one_of(&self.choices, answer),
            ElementKind::Checkbox => answer.as_array().is_some_and(|l| l.iter().all(|v| one_of(&self.choices, v))),
            ElementKind::Rating => answer.as_f64().is_some_and(|v| self.rates().iter().any(|r| (r - v).abs() < 1e-9)),
            ElementKind::Boolean => answer.is_boolean(),
            ElementKind::Matrix => one_of(&self.columns, answer),
            ElementKind::Text if self.input_type == InputType::Number => {
                answer.is_string() && number(answer).is_some_and(|number| (self.min..=self.max).contains(&number))
            }
            ElementKind::Text | ElementKind::Comment => answer.is_string(),
            ElementKind::Html => false,
        }
    }

    fn check(&self) -> Result<(), QuestionFault> {
        let needs = |list: &[AnswerChoice], what: &'static str| {
            if list.is_empty() { Err(QuestionFault::Empty { name: self.name.clone(), what }) } else { Ok(()) }
        };
        match self.kind {
            ElementKind::Radiogroup | ElementKind::Checkbox => needs(&self.choices, "choices"),
            ElementKind::Matrix => needs(&self.columns, "columns").and_then(|()| needs(&self.rows, "rows")),
            ElementKind::Rating => {
                let steps = (self.rate_max - self.rate_min) / self.rate_step;
                let whole = (steps - steps.round()).abs() < 1e-9;
                if self.rate_step > 0.0 && whole && (1.0..=100.0).contains(&steps) {
                    return Ok(());
                }
                let (from, to, by) = (self.rate_min, self.rate_max, self.rate_step);
                Err(QuestionFault::Scale { name: self.name.clone(), from, to, by })
            }
            ElementKind::Text if self.input_type == InputType::Number && self.min >= self.max => {
                Err(QuestionFault::Bounds { name: self.name.clone(), min: self.min, max: self.max })
            }
            _ => Ok(()),
        }
    }
}

/// Returns the number of an answer; a typed number may have a sign, commas between thousands and a unit behind it.
pub(super) fn number(answer: &Value) -> Option<f64> {
    let typed = |text: &str| match text.trim().strip_prefix('-') {
        Some(digits) => number_in(digits).map(|number| -number),
        None => number_in(text),
    };
    answer.as_f64().or_else(|| answer.as_str().and_then(typed))
}

/// Converts a value to a part of a name.
pub(super) fn word(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// Folder of the shipped questionnaires, below the project's root.
const SHIPPED: &str = "assets/questionnaires";

impl Questionnaire {
    /// Loads a questionnaire by its file name beside the study, or by the name of a shipped one.
    ///
    /// # Errors
    /// The questionnaire does not exist or has an error; the message says where, and what to do.
    pub fn find(name: &str, beside: &Path) -> Result<Self, StudyError> {
        let own = beside.join(name);
        let shipped = data_folders::root().join(SHIPPED);
        let path = if name.ends_with(".json") { own } else { shipped.join(format!("{name}.json")) };
        if !path.exists() {
            let known = words(&shipped);
            let near = if name.ends_with(".json") {
                toml_text::did_you_mean_file(&path)
            } else {
                toml_text::did_you_mean(name, &known)
            };
            return Err(StudyError(format!(
                "{}: there is no such questionnaire{near}; allowed: a .json file beside the study, or one of {}",
                path.display(),
                known.join(", ")
            )));
        }
        let text = read_text(&path, SETTINGS_BYTES)
            .map_err(|e| StudyError(format!("{}: cannot be read: {e}", path.display())))?;
        Self::checked(&text, &path.display().to_string())
    }

    /// Parses JSON text, and refuses conditions that compare unlike types. `name` is the file's name in messages.
    pub(super) fn checked(text: &str, name: &str) -> Result<Self, StudyError> {
        let found = Self::parse(text, name)?;
        let of_elements = found.pages.iter().flat_map(|page| &page.elements).filter_map(|e| e.visible_if.as_ref());
        let conditions = found.pages.iter().filter_map(|page| page.visible_if.as_ref()).chain(of_elements);
        match conditions.filter_map(|condition| found.unlike(condition)).next() {
            Some(fault) => Err(fault.located(text, name)),
            None => Ok(found),
        }
    }

    /// Parses JSON text; `name` is the file's name in messages.
    ///
    /// # Errors
    /// The text is not a valid questionnaire; the message has line and column if the JSON itself is at fault.
    pub fn parse(text: &str, name: &str) -> Result<Self, StudyError> {
        let found: Self = serde_json::from_str(text).map_err(|e| {
            let message = e.to_string();
            let message = toml_text::in_words(message.split(" at line ").next().unwrap_or_default());
            StudyError(format!("{name}:{}:{}: {message}", e.line(), e.column()))
        })?;
        found.check().map_err(|fault| fault.located(text, name))?;
        Ok(found)
    }

    fn check(&self) -> Result<(), QuestionFault> {
        let mut seen: Vec<&str> = Vec::new();
        let mut answers: Vec<String> = Vec::new();
        for page in &self.pages {
            let conditions = page.visible_if.iter().chain(page.elements.iter().flat_map(|e| &e.visible_if));
            for element in &page.elements {
                element.check()?;
                if seen.contains(&element.name.as_str()) {
                    return Err(QuestionFault::Twice(element.name.clone()));
                }
                seen.push(&element.name);
                answers.extend(element.answer_names());
            }
            for condition in conditions {
                if let Some(name) = condition.names().find(|name| !answers.iter().any(|answer| answer == name)) {
                    let near = toml_text::did_you_mean(name, &answers);
                    return Err(QuestionFault::UnknownCondition { name: name.into(), near });
                }
            }
        }
        self.check_scores()
    }

    /// Returns the names of all answers, in order.
    pub fn answer_names(&self) -> Vec<String> {
        self.pages.iter().flat_map(|page| &page.elements).flat_map(QuestionElement::answer_names).collect()
    }

    /// Returns true if there is a boolean question of this name that is required and always visible.
    pub(super) fn asks_agreement(&self, name: &str) -> bool {
        let pages = self.pages.iter().filter(|page| page.visible_if.is_none());
        pages.flat_map(|page| &page.elements).any(|element| {
            element.name == name
                && element.kind == ElementKind::Boolean
                && element.is_required
                && element.visible_if.is_none()
        })
    }

    /// Returns the pages visible with these answers.
    pub fn visible_pages<'a>(&'a self, answers: &'a Answers) -> impl Iterator<Item = &'a QuestionnairePage> {
        self.pages.iter().filter(move |page| {
            page.visible_if.as_ref().is_none_or(|c| c.holds(answers)) && page.visible_elements(answers).next().is_some()
        })
    }
}

impl QuestionnairePage {
    /// Returns the page's elements visible with these answers.
    pub fn visible_elements<'a>(&'a self, answers: &'a Answers) -> impl Iterator<Item = &'a QuestionElement> {
        self.elements.iter().filter(move |e| e.visible_if.as_ref().is_none_or(|condition| condition.holds(answers)))
    }

    /// Returns the names of required answers that are missing, and of answers that are no number where one is asked for.
    pub fn missing(&self, answers: &Answers) -> Vec<String> {
        let is_missing = |element: &QuestionElement, name: &String| match answers.get(name) {
            None => element.is_required,
            Some(answer) => element.input_type == InputType::Number && !element.accepts(answer),
        };
        let all = self.visible_elements(answers).flat_map(|e| e.answer_names().into_iter().map(move |name| (e, name)));
        all.filter(|(element, name)| is_missing(element, name)).map(|(_, name)| name).collect()
    }
}

/// Returns the names of the questionnaires in a folder, sorted.
fn words(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let files =
        entries.map(|entry| PathBuf::from(entry.file_name())).filter(|f| f.extension().is_some_and(|e| e == "json"));
    let mut names: Vec<String> = files.filter_map(|f| Some(f.file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names
}

#[cfg(test)]
#[path = "questions_tests.rs"]
mod tests;
