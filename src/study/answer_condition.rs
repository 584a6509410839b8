//! Conditions on answers: `{name} = 'word' and {other} > 3`. In: the text of a condition; the questions that it names; answers. Out: whether
//! it holds; or the comparison that no answer can satisfy, because the question's answers are of another type.

use super::{
    question_fault::QuestionFault,
    questions::{AnswerChoice, Answers, ElementKind, InputType, QuestionElement, Questionnaire, number, word},
};
use crate::toml_text;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::Value;

/// Condition on answers: `{name} = 'word' and {other} > 3`.
#[derive(Clone, Debug, PartialEq, JsonSchema)]
#[schemars(with = "String")]
pub struct VisibilityCondition {
    text: String,
    /// Alternatives, each a list of comparisons that must all hold.
    any: Vec<Vec<AnswerComparison>>,
}

#[derive(Clone, Debug, PartialEq)]
struct AnswerComparison {
    /// Text of the comparison, for messages.
    text: String,
    name: String,
    by: &'static str,
    with: Value,
}

impl Serialize for VisibilityCondition {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text)
    }
}

impl<'de> Deserialize<'de> for VisibilityCondition {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::parse(&String::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

fn comparison(text: &str) -> Result<AnswerComparison, QuestionFault> {
    let fault = || QuestionFault::Comparison(text.trim().into());
    let (name, rest) = text.trim().strip_prefix('{').and_then(|rest| rest.split_once('}')).ok_or_else(fault)?;
    let rest = rest.trim();
    let by =
        ["<>", "<=", ">=", "=", "<", ">", "contains"].into_iter().find(|by| rest.starts_with(by)).ok_or_else(fault)?;
    let with = rest[by.len()..].trim();
    let value = if let Some(word) = with.strip_prefix('\'').and_then(|w| w.strip_suffix('\'')) {
        Value::from(word)
    } else {
        match with {
            "true" => Value::from(true),
            "false" => Value::from(false),
            number => number.parse::<f64>().map(Value::from).map_err(|_| fault())?,
        }
    };
    Ok(AnswerComparison { text: text.trim().into(), name: name.into(), by, with: value })
}

/// Splits a text at a word outside of quotes.
fn split_outside_quotes<'a>(text: &'a str, at: &str) -> Vec<&'a str> {
    let (mut parts, mut begin, mut is_quoted) = (Vec::new(), 0, false);
    for (k, c) in text.char_indices() {
        is_quoted ^= c == '\'';
        if !is_quoted && k >= begin && text[k..].starts_with(at) {
            parts.push(&text[begin..k]);
            begin = k + at.len();
        }
    }
    parts.push(&text[begin..]);
    parts
}

impl VisibilityCondition {
    /// Parses the text of a condition.
    ///
    /// # Errors
    /// A part of the text is not a comparison.
    pub fn parse(text: &str) -> Result<Self, QuestionFault> {
        let all = |part| split_outside_quotes(part, " and ").into_iter().map(comparison).collect();
        let any = split_outside_quotes(text, " or ").into_iter().map(all);
        Ok(Self { text: text.into(), any: any.collect::<Result<_, _>>()? })
    }

    /// Returns true if the condition holds. A missing answer satisfies only `<>`.
    pub fn holds(&self, answers: &Answers) -> bool {
        self.any.iter().any(|all| all.iter().all(|one| one.holds(answers)))
    }

    /// Returns the names of the questions in the condition.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.any.iter().flatten().map(|one| one.name.as_str())
    }
}

impl AnswerComparison {
    fn holds(&self, answers: &Answers) -> bool {
        let Some(answer) = answers.get(&self.name) else { return self.by == "<>" };
        // A typed number is stored as its text. `Questionnaire::unlike` refuses comparisons of other texts with numbers.
        let equal = |value: &Value| match self.with.as_f64() {
            Some(with) => number(value) == Some(with),
            None => *value == self.with,
        };
        let order = number(answer).zip(self.with.as_f64());
        match self.by {
            "=" => equal(answer),
            "<>" => !equal(answer),
            "<" => order.is_some_and(|(a, b)| a < b),
            "<=" => order.is_some_and(|(a, b)| a <= b),
            ">" => order.is_some_and(|(a, b)| a > b),
            ">=" => order.is_some_and(|(a, b)| a >= b),
            _ => answer.as_array().is_some_and(|list| list.iter().any(equal)),
        }
    }
}

impl Questionnaire {
    /// Returns the first comparison of a condition that compares unlike types, such as a text with a number; `None` if all are sound.
    /// Names of unknown questions are left to the caller.
    pub(super) fn unlike(&self, condition: &VisibilityCondition) -> Option<QuestionFault> {
        let elements = || self.pages.iter().flat_map(|page| &page.elements);
        condition.any.iter().flatten().find_map(|one| {
            let asked = elements().find(|element| element.answer_names().contains(&one.name))?;
            let (is, allowed) = one.unlike(asked)?;
            Some(QuestionFault::Unlike { comparison: one.text.clone(), name: one.name.clone(), is, allowed })
        })
    }
}

impl AnswerComparison {
    /// Returns the type of the question's answers and the comparisons that it allows, if this is none of them.
    fn unlike(&self, asked: &QuestionElement) -> Option<(String, String)> {
        let is_equality = ["=", "<>"].contains(&self.by);
        let is_order = !is_equality && self.by != "contains";
        let one_of = |choices: &[AnswerChoice]| {
            let words: Vec<String> = choices.iter().map(|choice| word(&choice.value)).collect();
            let near = self.with.as_str().map_or(String::new(), |with| toml_text::did_you_mean(with, &words));
            let quoted = |choice: &AnswerChoice| match &choice.value {
                Value::String(word) => format!("'{word}'"),
                number => number.to_string(),
            };
            (choices.iter().map(quoted).collect::<Vec<_>>().join(", "), near)
        };
        let has = |choices: &[AnswerChoice]| {
            let equal =
                |value: &Value| *value == self.with || value.as_f64().is_some_and(|v| Some(v) == self.with.as_f64());
            choices.iter().any(|choice| equal(&choice.value))
        };
        let (is_sound, is, allowed) = match asked.kind {
            ElementKind::Boolean => {
                (is_equality && self.with.is_boolean(), "yes or no".into(), "= or <> with true or false".into())
            }
            ElementKind::Rating => (
                is_order && self.with.is_number() || is_equality && asked.accepts(&self.with),
                "a rating".into(),
                format!("= <> < <= > >= with a number of its scale, {} to {}", asked.rate_min, asked.rate_max),
            ),
            ElementKind::Radiogroup | ElementKind::Matrix => {
                let choices = if asked.kind == ElementKind::Matrix { &asked.columns } else { &asked.choices };
                let is_number = choices.iter().all(|choice| choice.value.is_number());
                let (list, near) = one_of(choices);
                let by = if is_number { "= <> < <= > >=" } else { "= or <>" };
                let is_sound = is_equality && has(choices) || is_order && is_number && self.with.is_number();
                (is_sound, "one of its choices".into(), format!("{by} with one of {list}{near}"))
            }
            ElementKind::Checkbox => {
                let (list, near) = one_of(&asked.choices);
                let is_sound = self.by == "contains" && has(&asked.choices);
                (is_sound, "a list of choices".into(), format!("contains with one of {list}{near}"))
            }
            ElementKind::Text if asked.input_type == InputType::Number => (
                self.by != "contains" && self.with.is_number(),
                "a number".into(),
                "= <> < <= > >= with a number, without quotes".into(),
            ),
            ElementKind::Text | ElementKind::Comment => (
                is_equality && self.with.is_string(),
                "a text".into(),
                "= or <> with a word in quotes; or let a text ask for a number by \"inputType\": \"number\" with \"min\" and \
                 \"max\""
                    .into(),
            ),
            ElementKind::Html => return None,
        };
        (!is_sound).then_some((is, allowed))
    }
}

#[cfg(test)]
#[path = "answer_condition_tests.rs"]
mod tests;
