//! The file of a study. In: TOML (`assets/studies/`). Out: a [`Study`] in which every scenario can be driven, or a message
//! that names file, line, column, value and what is allowed.

pub use super::segment::{SegmentKind, StudySegment};

use super::{
    Questionnaire, SpokenText, StudyError,
    conditions::{Condition, ExpectedDrives, changed, conditions},
    order,
};
use crate::{
    analysis::plan::AnalysisPlan,
    file::{SETTINGS_BYTES, read_bounded, read_text},
    lsl::LslSettings,
    plot,
    scenario::Scenario,
    toml_text::{self, KeyPart},
    triggers::TriggerSettings,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Scenario settings that differ from those before, by their keys.
pub(super) type SettingChanges = Map<String, Value>;

/// What a person writes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// What the study is called.
    pub title: String,
    /// Who leads the study, in the order of a paper; the data set says so. Participants have no names.
    #[serde(default)]
    pub authors: Vec<String>,
    /// Under which licence the data may be used, such as CC0 or CC-BY-4.0.
    pub licence: Option<String>,
    /// Where it is led.
    pub institution: Option<String>,
    /// How many participants are planned.
    #[schemars(range(min = 1, max = 1000))]
    pub participants: u32,
    /// Seed of all orders and drives.
    #[serde(default)]
    pub seed: u64,
    /// In which order participants meet the conditions.
    #[serde(default)]
    pub order: order::OrderDesign,
    /// From the first picture of a road to the start of its drive, seconds.
    #[serde(default = "countdown_s")]
    #[schemars(range(min = 0.0, max = 60.0))]
    pub countdown_s: f64,
    /// Settings of every drive that differ from the program's own (keys of a scenario file).
    #[serde(default)]
    #[schemars(with = "Scenario")]
    pub base: SettingChanges,
    /// Factors by name, each with its levels by name; all combinations are conditions.
    #[serde(default)]
    pub factors: BTreeMap<String, Vec<ConditionLevel>>,
    /// Conditions one by one, instead of factors.
    #[serde(default)]
    pub condition: Vec<ConditionLevel>,
    /// What is analysed and how, written before the first participant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub analysis: Option<AnalysisPlan>,
    /// Streams of other devices that are recorded, and of this program for others (Lab Streaming Layer).
    #[serde(default, skip_serializing_if = "is_default")]
    pub lsl: LslSettings,
    /// A byte on a serial port for each of named events.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triggers: Option<TriggerSettings>,
    /// What comes one after the other.
    pub segment: Vec<StudySegment>,
    /// Sentences that the program says, in any language; what is not here is said in English.
    #[serde(default)]
    pub texts: ParticipantTexts,
    /// The language that is spoken, as `spoken` of the segments names it.
    pub language: Option<String>,
    /// Records the room by the microphone during every drive, which a consent must come before.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub record_room: bool,
    /// A font (TTF, OTF) beside the study, for letters that the program's own have not: those know Latin, Greek and Cyrillic.
    pub font: Option<PathBuf>,
}

impl StudyFile {
    /// Free texts of one line, by their keys.
    fn lines(&self) -> Vec<(String, &str)> {
        let authors = self.authors.iter().enumerate().map(|(i, name)| (format!("authors.{i}"), name.as_str()));
        let others = [
            ("title", Some(&self.title)),
            ("licence", self.licence.as_ref()),
            ("institution", self.institution.as_ref()),
        ];
        let factors = self.factors.keys().map(|name| (format!("factors.{}", name.escape_debug()), name.as_str()));
        let others = others.into_iter().filter_map(|(key, text)| Some((key.to_owned(), text?.as_str())));
        others.chain(authors).chain(factors).collect()
    }
}

fn is_default(lsl: &LslSettings) -> bool {
    *lsl == LslSettings::default()
}

fn countdown_s() -> f64 {
    3.0
}

/// A level of a factor, or a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionLevel {
    /// Its name, in data and figures.
    pub name: String,
    /// Settings that it changes (keys of a scenario file).
    #[serde(default)]
    #[schemars(with = "Scenario")]
    pub set: SettingChanges,
}

/// What the program says to a participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ParticipantTexts {
    /// Below a page, with a wheel in hands; `{button}` stands for the button that answers.
    pub go_on: String,
    /// Before a drive that begins at a standstill.
    pub ready: String,
    /// Before one in flowing traffic; `{speed}` stands for the speed with its unit.
    pub rolling: String,
    /// Before a drive that begins at a standstill, while the brake is not pressed.
    pub brake: String,
    /// After a drive.
    pub drive_over: String,
    /// In a break.
    pub rest: String,
    /// When a break is over.
    pub rest_over: String,
    /// At the end.
    pub thanks: String,
    /// After a session that was stopped before its end.
    pub stopped: String,
    /// After a consent that was not given.
    pub declined: String,
    /// After answers with which nobody can take part.
    pub not_eligible: String,
    /// After a score above its limit.
    pub score_limit: String,
    /// The question of the sickness scale while driving, and what its ends mean.
    pub fms: String,
    /// Its lower end.
    pub fms_low: String,
    /// Its upper end.
    pub fms_high: String,
    /// What hears a spoken page once more.
    pub again: String,
    /// While the room is recorded.
    pub room: String,
    /// While the experimenter has something to do.
    pub wait: String,
    /// While a drive is held.
    pub paused: String,
    /// After the participant asked for an end.
    pub asked: String,
    /// At a question that has to be answered.
    pub required: String,
    /// What the star at a question means.
    pub star: String,
    /// The answers of a yes-or-no question.
    pub yes: String,
    /// Its other answer.
    pub no: String,
    /// Of a list of which several can be taken: no more of them.
    pub no_more: String,
    /// On the button to the next page, and what a button does.
    pub next: String,
    /// On the button to the page before.
    pub back: String,
    /// What arrows and wheel do.
    pub choose: String,
    /// What Enter and the answer button do.
    pub answer: String,
    /// The keys that choose.
    pub arrows: String,
    /// What a hand does with a wheel to choose.
    pub wheel: String,
    /// The pad of the wheel whose directions change a rating.
    pub dpad: String,
    /// The button of the wheel that answers.
    pub answer_button: String,
    /// The button of the wheel that goes back.
    pub back_button: String,
}

impl Default for ParticipantTexts {
    fn default() -> Self {
        Self {
            go_on: "Press {button} on the wheel to continue.".into(),
            ready: "The drive begins soon. Hands on the wheel, foot on the brake.".into(),
            rolling: "The drive begins soon, at {speed}. Hands on the wheel.".into(),
            brake: "Press the brake pedal and hold it.".into(),
            drive_over: "This drive is over.".into(),
            rest: "Take a rest.".into(),
            rest_over: "The rest is over.".into(),
            thanks: "You have finished. Thank you!".into(),
            stopped: "We stop here. Thank you for taking part!".into(),
            declined: "You do not take part, and that is fine. Nothing more is asked. Thank you for coming!".into(),
            not_eligible: "Thank you for your answers. The rules of this study do not let you drive today: we stop \
                           here. The experimenter will tell you why. Thank you for coming!"
                .into(),
            score_limit:
                "We stop here so that you stay well: your last answers are above the limit of this study. Please \
                          tell the experimenter how you feel. Thank you for taking part!"
                    .into(),
            fms: "How sick do you feel now?".into(),
            fms_low: "0 not at all".into(),
            fms_high: "20 very sick".into(),
            again: "hear again".into(),
            room: "the room is recorded".into(),
            wait: "Please wait a moment.".into(),
            paused: "A short pause. The drive will continue soon.".into(),
            asked: "You asked to stop. The experimenter will be with you in a moment.".into(),
            required: "Please answer this question.".into(),
            star: "* Please answer".into(),
            yes: "Yes".into(),
            no: "No".into(),
            no_more: "That is all".into(),
            next: "Next".into(),
            back: "Back".into(),
            choose: "choose".into(),
            answer: "answer".into(),
            arrows: "arrow keys".into(),
            wheel: "turn the wheel".into(),
            dpad: "arrow buttons".into(),
            answer_button: "× (cross)".into(),
            back_button: "Δ (triangle)".into(),
        }
    }
}

/// The most that a font may hold, bytes: those with all of Chinese, Japanese and Korean have 20 MB.
const FONT_BYTES: u64 = 32 << 20;

/// Why a font cannot be used.
#[derive(Debug, thiserror::Error)]
enum FontFault {
    /// The system does not give it.
    #[error("the font {} cannot be read: {source}", file.display())]
    Unreadable { file: PathBuf, source: std::io::Error },
    /// Another kind of file.
    #[error("{} is no font; allowed: a TTF or OTF file", .0.display())]
    NoFont(PathBuf),
}

/// The bytes of a font.
fn read_font(path: &Path) -> Result<Arc<[u8]>, FontFault> {
    let bytes = read_bounded(path, FONT_BYTES).map_err(|source| FontFault::Unreadable { file: path.into(), source })?;
    if plot::is_font(&bytes) {
        return Ok(bytes.into());
    }
    Err(FontFault::NoFont(path.into()))
}

/// A study that can be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// As it was written.
    pub file: StudyFile,
    /// The scenario that all drives begin from.
    pub base: Scenario,
    /// Conditions: name, level of each factor, settings.
    pub conditions: Vec<Condition>,
    /// Questionnaires by the word in the file.
    pub questionnaires: BTreeMap<String, Questionnaire>,
    /// The text as it was, for the data set.
    pub source: String,
    /// The bytes of its font.
    pub font: Option<Arc<[u8]>>,
    /// Spoken instructions by the name of their segment.
    pub spoken: BTreeMap<String, SpokenText>,
    pub(super) expected: ExpectedDrives,
    /// Folder of its file, where the paths in it start.
    pub(super) folder: PathBuf,
}

impl Study {
    /// Reads and checks a study: every scenario, map, policy and questionnaire in it.
    ///
    /// # Errors
    /// What is wrong, where, and what is allowed.
    pub fn load(path: &Path) -> Result<Self, StudyError> {
        let source = read_text(path, SETTINGS_BYTES).map_err(|e| {
            StudyError(format!("{}: cannot be read: {e}{}", path.display(), toml_text::did_you_mean_file(path)))
        })?;
        Self::parse(source, path)
    }

    /// The same study with another seed of all orders and drives; `path` is its file's.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn with_seed(&self, seed: u64, path: &Path) -> Result<Self, StudyError> {
        let mut file: toml::Table =
            self.source.parse().map_err(|why| StudyError(format!("{}: {why}", path.display())))?;
        let seed = i64::try_from(seed).map_err(|why| StudyError(format!("seed is {seed}: {why}")))?;
        file.insert("seed".into(), seed.into());
        Self::parse(file.to_string(), path)
    }

    /// The same for text that stands in `path`.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse(source: String, path: &Path) -> Result<Self, StudyError> {
        let name = path.display().to_string();
        let said = |e: toml_text::TomlError| StudyError(e.to_string());
        let text = toml_text::without_format(&source, &name).map_err(said)?;
        let file: StudyFile = toml_text::parse(&text, &name).map_err(said)?;
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let mut study = Self {
            folder: folder.clone(),
            base: Scenario::default(),
            conditions: Vec::new(),
            questionnaires: BTreeMap::new(),
            file,
            source,
            font: None,
            spoken: BTreeMap::new(),
            expected: ExpectedDrives::default(),
        };
        let fault =
            |key: &str, message: String| StudyError(toml_text::at(&study.source, &name, key, KeyPart::Value, &message));
        study.check_shape().map_err(|(key, message)| fault(&key, message))?;
        let base = changed(&Scenario::default(), "base", &study.file.base, &folder)
            .map_err(|wrong| wrong.located(&study.source, &name))?;
        let conditions = conditions(&study.file);
        let (mut questionnaires, mut spoken) = (BTreeMap::new(), BTreeMap::new());
        for (i, segment) in study.file.segment.iter().enumerate() {
            for (key, word) in segment.questionnaires() {
                let found =
                    Questionnaire::find(word, &folder).map_err(|e| fault(&format!("segment.{i}.{key}"), e.0))?;
                questionnaires.insert(word.to_owned(), found);
            }
            if let Some(files) = &segment.spoken {
                let text = files.read(&folder, study.file.language.as_deref());
                let text = text.map_err(|e| fault(&format!("segment.{i}.spoken"), e.to_string()))?;
                spoken.insert(segment.name.clone(), text);
            }
        }
        let font = study.file.font.as_ref().map(|font| read_font(&folder.join(font))).transpose();
        study.font = font.map_err(|e| fault("font", e.to_string()))?;
        study.base = base;
        study.conditions = conditions;
        if let Some(plan) = &study.file.analysis {
            let names: Vec<&str> = study.conditions.iter().map(|condition| condition.name.as_str()).collect();
            plan.check(&names).map_err(|wrong| fault(&wrong.key, wrong.message))?;
        }
        (study.questionnaires, study.spoken) = (questionnaires, spoken);
        study.check_rules().map_err(|(key, wrong)| {
            StudyError(toml_text::at(&study.source, &name, &key, KeyPart::Value, &wrong.to_string()))
        })?;
        study.expected = study.check_drives(&name)?;
        Ok(study)
    }

    /// JSON Schema of the file, for editors.
    pub fn schema() -> Value {
        let mut schema = schemars::schema_for!(StudyFile).to_value();
        let about = "Number of the file's format; without it, 1.";
        schema["properties"]["format"] = json!({ "description": about, "type": "integer", "const": toml_text::FORMAT });
        schema
    }

    /// What does not depend on other files. The key at fault and the message.
    fn check_shape(&self) -> Result<(), (String, String)> {
        let file = &self.file;
        let wrong = |key: String, message: String| Err((key, message));
        if !(1..=1000).contains(&file.participants) {
            return wrong("participants".into(), format!("participants is {}; allowed: 1 to 1000", file.participants));
        }
        if !(0.0..=60.0).contains(&file.countdown_s) {
            let text = format!("countdown_s is {}; allowed: a number from 0 to 60 s", file.countdown_s);
            return wrong("countdown_s".into(), text);
        }
        for (key, text) in file.lines() {
            let commands =
                |c: char| c.is_control() || "\u{2028}\u{2029}".contains(c) || ('\u{202a}'..='\u{202e}').contains(&c);
            if let Some(c) = text.chars().find(|c| commands(*c) || ('\u{2066}'..='\u{2069}').contains(c)) {
                let text = format!("{key} has the character {}; allowed: one line of text", c.escape_unicode());
                return wrong(key, text);
            }
        }
        file.lsl.check().map_err(|fault| (format!("lsl.{}", fault.key()), fault.to_string()))?;
        if let Some(triggers) = &file.triggers {
            triggers.check().map_err(|fault| (format!("triggers.{}", fault.key()), fault.to_string()))?;
        }
        let first_drive = file.segment.iter().position(StudySegment::has_drives).unwrap_or(file.segment.len());
        let has_consent = file.segment[..first_drive].iter().any(|segment| segment.kind == SegmentKind::Consent);
        if file.record_room && !has_consent {
            let text = "a voice tells who somebody is: the room is recorded only after a segment of kind \"consent\" before the first drive, \
                        whose text says so";
            return wrong("record_room".into(), text.into());
        }
        if !file.factors.is_empty() && !file.condition.is_empty() {
            return wrong("condition".into(), "a study has either [factors] or [[condition]], not both".into());
        }
        let mut levels: Vec<(String, &[ConditionLevel])> =
            file.factors.iter().map(|(name, levels)| (format!("factors.{name}"), levels.as_slice())).collect();
        levels.push(("condition".into(), &file.condition));
        for (key, list) in levels {
            if list.is_empty() && key != "condition" {
                return wrong(key.clone(), format!("{key} has no levels"));
            }
            for (i, level) in list.iter().enumerate() {
                let here = format!("{key}.{i}.name");
                check_word(&level.name).map_err(|fault| (here.clone(), fault.to_string()))?;
                if list[..i].iter().any(|other| other.name == level.name) {
                    return wrong(here, format!("the name \"{}\" comes twice", level.name));
                }
            }
        }
        let trials = file.segment.iter().any(|segment| segment.kind == SegmentKind::Trials);
        let count = conditions(file).len();
        if trials && file.factors.is_empty() && file.condition.is_empty() {
            return wrong("segment".into(), "there are trials but no [factors] and no [[condition]]".into());
        }
        if file.order == order::OrderDesign::Full && count > order::MOST_FULL {
            let text = format!("{count} conditions have too many orders; \"full\" is for at most {}", order::MOST_FULL);
            return wrong("order".into(), text);
        }
        for (i, segment) in file.segment.iter().enumerate() {
            let key = |key: &str| format!("segment.{i}.{key}");
            check_word(&segment.name).map_err(|fault| (key("name"), fault.to_string()))?;
            if file.segment[..i].iter().any(|other| other.name == segment.name) {
                return wrong(key("name"), format!("the name \"{}\" comes twice", segment.name));
            }
            segment.check().map_err(|(at, message)| (key(&at), message))?;
        }
        self.check_item_names()
    }
}

/// A name that is no part of a file's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the name \"{word}\" cannot be used; allowed: 1 to 40 small letters, digits and hyphens")]
pub(super) struct WordFault {
    /// The name.
    word: String,
}

/// Names are parts of file names and of data.
pub(super) fn check_word(word: &str) -> Result<(), WordFault> {
    let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !word.is_empty() && word.len() <= 40 && word.chars().all(fine) {
        return Ok(());
    }
    Err(WordFault { word: word.into() })
}
#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
