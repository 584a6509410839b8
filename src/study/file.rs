//! The study file. In: TOML (`assets/studies/`). Out: a [`Study`] in which every scenario can be driven, or an error with file, line,
//! column, value and the allowed values.

pub use super::segment::{SegmentKind, StudySegment};

use super::{
    ParticipantTexts, Questionnaire, SpokenText, StudyError,
    conditions::{Condition, ExpectedDrives, conditions},
    order,
    segment::{SettingChanges, check_word},
};
use crate::{
    analysis::{MethodsStatements, models::plan::AnalysisPlan},
    file::{SETTINGS_BYTES, read_bounded, read_text},
    lsl::LslSettings,
    plot,
    scenario::Scenario,
    toml_text::{self, KeyPart, Mistakes},
    triggers::TriggerSettings,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Contents of a study file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// Title of the study.
    pub title: String,
    /// People who lead the study, in the order of authors; the data set names them. Participants have no names.
    #[serde(default)]
    pub authors: Vec<String>,
    /// Licence under which the data may be used, such as CC0 or CC-BY-4.0.
    pub licence: Option<String>,
    /// Institution that leads the study.
    pub institution: Option<String>,
    /// Planned number of participants.
    #[schemars(range(min = 1, max = 1000))]
    pub participants: u32,
    /// Seed of all orders and drives.
    #[serde(default)]
    pub seed: u64,
    /// Design of the orders in which participants meet the conditions.
    #[serde(default)]
    pub order: order::OrderDesign,
    /// Time from the first picture of a road to the start of the drive, s.
    #[serde(default = "countdown_s")]
    #[schemars(range(min = 0.0, max = 60.0))]
    pub countdown_s: f64,
    /// Least number of frames per second that a computer must draw for a session with a person, 1/s; 0 asks for none.
    #[serde(default = "least_frames_per_s")]
    #[schemars(range(min = 0.0, max = 240.0))]
    pub least_frames_per_s: f64,
    /// Settings of every drive that differ from the program's defaults (keys of a scenario file).
    #[serde(default)]
    #[schemars(with = "Scenario")]
    pub base: SettingChanges,
    /// Factors by name, each with its levels by name; all combinations are conditions.
    #[serde(default)]
    pub factors: BTreeMap<String, Vec<ConditionLevel>>,
    /// Conditions one by one, instead of factors.
    #[serde(default)]
    pub condition: Vec<ConditionLevel>,
    /// Planned analysis, written before the first participant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub analysis: Option<AnalysisPlan>,
    /// Recruitment, ethics and apparatus in whole sentences, which preregistration and methods print.
    #[serde(default, skip_serializing_if = "MethodsStatements::is_empty")]
    pub methods: MethodsStatements,
    /// Lab Streaming Layer: streams of other devices to record, and streams of this program for other devices.
    #[serde(default, skip_serializing_if = "is_default")]
    pub lsl: LslSettings,
    /// Bytes on a serial port, one for each named event.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triggers: Option<TriggerSettings>,
    /// Segments of the session, in order.
    pub segment: Vec<StudySegment>,
    /// Texts for the participant, in any language; texts left out are in English.
    #[serde(default)]
    pub texts: ParticipantTexts,
    /// Language of the spoken instructions, as named in `spoken` of the segments.
    pub language: Option<String>,
    /// Records the room by microphone during every drive; needs a consent segment before the first drive.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub record_room: bool,
    /// Font (TTF, OTF) beside the study, for letters outside Latin, Greek and Cyrillic, which the program's own fonts cover.
    pub font: Option<PathBuf>,
}

impl StudyFile {
    /// Returns the free texts that must fit on one line, by their keys.
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

/// Returns the least rate at which latency can stay below 50 ms (docs/references.md: display).
fn least_frames_per_s() -> f64 {
    30.0
}

/// Level of a factor, or a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionLevel {
    /// Name in data and figures.
    pub name: String,
    /// Meaning of the level and reason for it, in whole sentences, which the preregistration prints.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub about: String,
    /// Settings that the level changes (keys of a scenario file).
    #[serde(default)]
    #[schemars(with = "Scenario")]
    pub set: SettingChanges,
}

/// Maximum size of a font, bytes; fonts with all of Chinese, Japanese and Korean have 20 MB.
const FONT_BYTES: u64 = 32 << 20;

/// Reason why a font cannot be used.
#[derive(Debug, thiserror::Error)]
enum FontFault {
    /// The file cannot be read.
    #[error("the font {} cannot be read: {source}", file.display())]
    Unreadable { file: PathBuf, source: std::io::Error },
    /// The file is not a font.
    #[error("{} is not a font; allowed: a TTF or OTF file", .0.display())]
    NoFont(PathBuf),
}

/// Reads the bytes of a font.
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
    /// Contents of the study file.
    pub file: StudyFile,
    /// Scenario that all drives begin from.
    pub base: Scenario,
    /// Conditions of the study, with the level of each factor and the changed settings.
    pub conditions: Vec<Condition>,
    /// Questionnaires, by their name in the study file.
    pub questionnaires: BTreeMap<String, Questionnaire>,
    /// Text of the study file, for the data set.
    pub source: String,
    /// Bytes of the study's font.
    pub font: Option<Arc<[u8]>>,
    /// Spoken instructions, by the name of their segment.
    pub spoken: BTreeMap<String, SpokenText>,
    pub(super) expected: ExpectedDrives,
    /// Folder of the study file, in which relative paths start.
    pub(super) folder: PathBuf,
}

impl Study {
    /// Reads and checks a study: every scenario, map, policy and questionnaire in it.
    ///
    /// # Errors
    /// Something in the study is wrong; the message says where, and what is allowed.
    pub fn load(path: &Path) -> Result<Self, StudyError> {
        let source = read_text(path, SETTINGS_BYTES).map_err(|e| {
            StudyError(format!("{}: cannot be read: {e}{}", path.display(), toml_text::did_you_mean_file(path)))
        })?;
        Self::parse(source, path)
    }

    /// Returns the study with another seed of all orders and drives. `path` is the path of its file.
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

    /// Parses and checks the text of a study file whose path is `path`.
    ///
    /// # Errors
    /// As [`Study::load`].
    pub fn parse(source: String, path: &Path) -> Result<Self, StudyError> {
        let name = path.display().to_string();
        let study_error = |e: toml_text::TomlError| StudyError(e.to_string());
        let (file, mut mistakes) = toml_text::read_formatted::<StudyFile>(&source, &name);
        let Some(file) = file else { return toml_text::finished((None, mistakes)).map_err(study_error) };
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let mut study = Self {
            folder,
            base: Scenario::default(),
            conditions: conditions(&file),
            questionnaires: BTreeMap::new(),
            file,
            source,
            font: None,
            spoken: BTreeMap::new(),
            expected: ExpectedDrives::default(),
        };
        study.check_shape(&mut mistakes);
        study.check_settings(&mut mistakes);
        study.read_files(&mut mistakes);
        if let Some(plan) = &study.file.analysis {
            let names: Vec<&str> = study.conditions.iter().map(|condition| condition.name.as_str()).collect();
            for wrong in plan.faults(&names) {
                mistakes.add_related(&wrong.key, &["condition", "factors"], KeyPart::Value, &wrong.message);
            }
        }
        if mistakes.is_empty() {
            for (key, wrong) in study.rule_faults() {
                mistakes.add(&key, KeyPart::Value, &wrong.to_string());
            }
        }
        mistakes.finish().map_err(study_error)?;
        // Drives can start only with settings that are all right.
        study.expected = study.check_drives(&name)?;
        Ok(study)
    }

    /// Reads the questionnaires, spoken instructions and the font that the study names.
    fn read_files(&mut self, mistakes: &mut Mistakes) {
        let Self { file, folder, questionnaires, spoken, .. } = self;
        for (i, segment) in file.segment.iter().enumerate() {
            for (key, word) in segment.questionnaires() {
                match Questionnaire::find(word, folder) {
                    Ok(found) => _ = questionnaires.insert(word.to_owned(), found),
                    Err(e) => mistakes.add_related(
                        &format!("segment.{i}.{key}"),
                        &[&format!("segment.{i}.kind")],
                        KeyPart::Value,
                        &e.0,
                    ),
                }
            }
            match segment.spoken.as_ref().map(|files| files.read(folder, file.language.as_deref())) {
                Some(Ok(text)) => _ = spoken.insert(segment.name.clone(), text),
                Some(Err(e)) => mistakes.add(&format!("segment.{i}.spoken"), KeyPart::Value, &e.to_string()),
                None => {}
            }
        }
        match file.font.as_ref().map(|font| read_font(&folder.join(font))).transpose() {
            Ok(font) => self.font = font,
            Err(e) => mistakes.add("font", KeyPart::Value, &e.to_string()),
        }
    }

    /// Checks everything that needs no other files.
    fn check_shape(&self, mistakes: &mut Mistakes) {
        let file = &self.file;
        let mut add =
            |key: &str, others: &[&str], message: &str| mistakes.add_related(key, others, KeyPart::Value, message);
        if !(1..=1000).contains(&file.participants) {
            add("participants", &[], &format!("participants is {}; allowed: 1 to 1000", file.participants));
        }
        if !(0.0..=60.0).contains(&file.countdown_s) {
            add("countdown_s", &[], &format!("countdown_s is {}; allowed: a number from 0 to 60 s", file.countdown_s));
        }
        if !(0.0..=240.0).contains(&file.least_frames_per_s) {
            let text = format!("least_frames_per_s is {}; allowed: a number from 0 to 240", file.least_frames_per_s);
            add("least_frames_per_s", &[], &text);
        }
        for (key, text) in file.lines() {
            let commands =
                |c: char| c.is_control() || "\u{2028}\u{2029}".contains(c) || ('\u{202a}'..='\u{202e}').contains(&c);
            if let Some(c) = text.chars().find(|c| commands(*c) || ('\u{2066}'..='\u{2069}').contains(c)) {
                let text = format!("{key} has the character {}; allowed: one line of text", c.escape_unicode());
                add(&key, &[], &text);
            }
        }
        if let Err(fault) = file.lsl.check() {
            add(&format!("lsl.{}", fault.key()), &[], &fault.to_string());
        }
        if let Some(Err(fault)) = file.triggers.as_ref().map(TriggerSettings::check) {
            add(&format!("triggers.{}", fault.key()), &[], &fault.to_string());
        }
        let first_drive = file.segment.iter().position(StudySegment::has_drives).unwrap_or(file.segment.len());
        let has_consent = file.segment[..first_drive].iter().any(|segment| segment.kind == SegmentKind::Consent);
        if file.record_room && !has_consent {
            let text = "a voice identifies a person: recording the room needs a segment of kind \"consent\" before the \
                first drive, with a text about the recording";
            add("record_room", &["segment"], text);
        }
        if !file.factors.is_empty() && !file.condition.is_empty() {
            add("condition", &[], "a study has either [factors] or [[condition]], not both");
        }
        let mut levels: Vec<(String, &[ConditionLevel])> =
            file.factors.iter().map(|(name, levels)| (format!("factors.{name}"), levels.as_slice())).collect();
        levels.push(("condition".into(), &file.condition));
        for (key, list) in levels {
            if list.is_empty() && key != "condition" {
                add(&key, &[], &format!("{key} has no levels"));
            }
            for (i, level) in list.iter().enumerate() {
                let here = format!("{key}.{i}.name");
                if let Err(fault) = check_word(&level.name) {
                    add(&here, &[], &fault.to_string());
                } else if list[..i].iter().any(|other| other.name == level.name) {
                    add(&here, &[], &format!("the name \"{}\" occurs twice", level.name));
                }
            }
        }
        let trials = file.segment.iter().any(|segment| segment.kind == SegmentKind::Trials);
        if trials && file.factors.is_empty() && file.condition.is_empty() {
            let text = "there are trials but no [factors] and no [[condition]]";
            add("segment", &["factors", "condition"], text);
        }
        let count = self.conditions.len();
        if file.order == order::OrderDesign::Full && count > order::MOST_FULL {
            let text =
                format!("{count} conditions have too many orders; allowed with \"full\": at most {}", order::MOST_FULL);
            add("order", &["factors", "condition"], &text);
        }
        for (i, segment) in file.segment.iter().enumerate() {
            let key = |key: &str| format!("segment.{i}.{key}");
            if let Err(fault) = check_word(&segment.name) {
                add(&key("name"), &[], &fault.to_string());
            } else if file.segment[..i].iter().any(|other| other.name == segment.name) {
                add(&key("name"), &[], &format!("the name \"{}\" occurs twice", segment.name));
            }
            // A key is at fault because of the kind, and each other one that is missing at the kind.
            for (at, message) in segment.faults() {
                add(&key(&at), &[&key("kind")], &message);
            }
        }
        if let Err((key, message)) = self.check_item_names() {
            add(&key, &["segment", "factors", "condition"], &message);
        }
    }
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
