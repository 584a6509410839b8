//! One segment of a study file. In: TOML tables. Out: a [`StudySegment`] with keys that fit its kind and values within their limits, or
//! the key at fault and a message. The questionnaires and drives that it names are checked elsewhere (`file`, `conditions`).

use super::{skills::Skill, spoken::SpokenFiles};
use crate::scenario::Scenario;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// Scenario settings that differ from the settings they are applied to, by key.
pub(super) type SettingChanges = Map<String, Value>;

/// Questionnaire of a consent segment that names no other.
pub const CONSENT: &str = "consent";

/// A limit of a score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScoreLimit {
    /// Name of the score: in its questionnaire (questions), `QUESTIONNAIRE.SCORE` for a questionnaire in `after` (drive, trials), or
    /// `fms` for the scale that is asked while driving (`fms_every_s`).
    pub score: String,
    /// Highest value at which the session continues, in the score's own unit.
    pub value: f64,
}

/// Kind of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SegmentKind {
    /// A page to read.
    Text,
    /// Consent of the participant. If they decline, the session ends with a text of thanks.
    Consent,
    /// A drive that is the same for every participant: familiarisation, a baseline.
    Drive,
    /// One trial per condition, in the participant's own order.
    Trials,
    /// A questionnaire, asked once.
    Questions,
    /// A rest with a timer.
    Break,
}

/// One segment. The kind decides which keys it needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudySegment {
    /// Kind of the segment.
    pub kind: SegmentKind,
    /// Name in the data: lower-case letters, digits, hyphens.
    pub name: String,
    /// Markdown that is shown during the segment (text, break) or before it (consent, drive, trials, questions).
    #[serde(default)]
    pub text: String,
    /// WAV file beside the study that speaks `text`, or one file per language. It plays when the page opens.
    pub spoken: Option<SpokenFiles>,
    /// Settings of the segment's drives (drive, trials).
    #[serde(default)]
    #[schemars(with = "Scenario")]
    pub set: SettingChanges,
    /// Time in s that the speed must stay in the range without a break; the drive then ends early (drive).
    #[schemars(range(min = 1.0, max = 3600.0))]
    pub until_in_range_s: Option<f64>,
    /// Skills that the participant shows in the drive (drive). The experimenter sees which are missing, and the data has the time of each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub skills: Vec<Skill>,
    /// Rest between two trials (trials), or length of the break (break), s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub rest_s: Option<f64>,
    /// Questionnaire: a file beside the study, or the name of a shipped one (questions, consent).
    pub questionnaire: Option<String>,
    /// Questionnaires after every drive of the segment, named as in `questionnaire` (drive, trials).
    #[serde(default)]
    pub after: Vec<String>,
    /// Questionnaires only after drives that give advice, sham advice included (drive, trials).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after_advice: Vec<String>,
    /// Time between two questions of the fast motion sickness scale (0 to 20) in a drive, s (drive, trials).
    #[schemars(range(min = 20.0, max = 3600.0))]
    pub fms_every_s: Option<f64>,
    /// Score limit; a higher score ends the session. Allowed in questions; in drive and trials for the questionnaires in `after`
    /// (`"ssq.total"`) and for `"fms"`.
    pub stop_above: Option<ScoreLimit>,
    /// Answers that end the session, each written like `visibleIf` of a questionnaire (questions).
    #[serde(default)]
    pub ends_if: Vec<String>,
    /// Text for the participant if this segment ends the session, instead of the program's own.
    pub stop_text: Option<String>,
}

/// Returns the name in the data of a questionnaire that a study file names: `trust` for `trust` and for `forms/trust.json`.
pub fn short_name(questionnaire: &str) -> String {
    Path::new(questionnaire).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

impl StudySegment {
    /// Returns true if the segment has drives.
    pub fn has_drives(&self) -> bool {
        matches!(self.kind, SegmentKind::Drive | SegmentKind::Trials)
    }

    /// Returns the segment's own questionnaire (consent, questions).
    pub fn own_questionnaire(&self) -> Option<&str> {
        match self.kind {
            SegmentKind::Consent => Some(self.questionnaire.as_deref().unwrap_or(CONSENT)),
            SegmentKind::Questions => self.questionnaire.as_deref(),
            _ => None,
        }
    }

    /// Returns every questionnaire that the segment asks, each with its key relative to the segment.
    pub(super) fn questionnaires(&self) -> Vec<(String, &str)> {
        let own = self.own_questionnaire().map(|word| ("questionnaire".to_owned(), word));
        own.into_iter().chain(self.asked_after().map(|(key, word)| (key, word.as_str()))).collect()
    }

    /// Returns the questionnaires after the segment's drives, those about advice last, each with its key relative to the segment.
    fn asked_after(&self) -> impl Iterator<Item = (String, &String)> {
        let always = self.after.iter().enumerate().map(|(i, word)| (format!("after.{i}"), word));
        always.chain(self.after_advice.iter().enumerate().map(|(i, word)| (format!("after_advice.{i}"), word)))
    }

    /// Returns the questionnaires after a drive with or without advice.
    pub(super) fn after_drive(&self, has_advice: bool) -> impl Iterator<Item = &String> {
        self.after.iter().chain(self.after_advice.iter().filter(move |_| has_advice))
    }

    /// Returns the faults of a segment that lacks a key its kind needs or has others, and of values that are not within their limits: each with
    /// its key and a message.
    pub(super) fn faults(&self) -> Vec<(String, String)> {
        let mut faults: Vec<(String, String)> = Vec::new();
        let mut add = |key: &str, message: String| faults.push((key.to_owned(), message));
        let drives = self.has_drives();
        let asks = matches!(self.kind, SegmentKind::Questions | SegmentKind::Consent);
        let kind = format!("{:?}", self.kind).to_lowercase();
        let may_end = self.kind == SegmentKind::Consent || self.stop_above.is_some() || !self.ends_if.is_empty();
        let rules = [
            ("set", !self.set.is_empty(), drives, false),
            ("until_in_range_s", self.until_in_range_s.is_some(), self.kind == SegmentKind::Drive, false),
            ("skills", !self.skills.is_empty(), self.kind == SegmentKind::Drive, false),
            (
                "rest_s",
                self.rest_s.is_some(),
                matches!(self.kind, SegmentKind::Trials | SegmentKind::Break),
                self.kind == SegmentKind::Break,
            ),
            ("questionnaire", self.questionnaire.is_some(), asks, self.kind == SegmentKind::Questions),
            ("text", !self.text.is_empty(), true, matches!(self.kind, SegmentKind::Text | SegmentKind::Consent)),
            ("after", !self.after.is_empty(), drives, false),
            ("after_advice", !self.after_advice.is_empty(), drives, false),
            ("fms_every_s", self.fms_every_s.is_some(), drives, false),
            ("stop_above", self.stop_above.is_some(), drives || self.kind == SegmentKind::Questions, false),
            ("ends_if", !self.ends_if.is_empty(), self.kind == SegmentKind::Questions, false),
            ("stop_text", self.stop_text.is_some(), drives || asks, false),
        ];
        for (key, is_there, allowed, needed) in rules {
            if is_there && !allowed {
                add(key, format!("a segment of kind \"{kind}\" has no `{key}`"));
            }
            if needed && !is_there {
                add("kind", format!("a segment of kind \"{kind}\" needs `{key}`"));
            }
        }
        if self.spoken.is_some() && self.text.is_empty() {
            let text = "spoken instructions need `text`: the page shows the same words";
            add("spoken", text.into());
        }
        if self.stop_text.is_some() && !may_end {
            let text = "`stop_text` needs `stop_above` or `ends_if`; no rule ends the session here";
            add("stop_text", text.into());
        }
        let numbers = [
            ("until_in_range_s", self.until_in_range_s, 1.0),
            ("rest_s", self.rest_s, 0.0),
            // A question stays on screen for up to 15 s.
            ("fms_every_s", self.fms_every_s, 20.0),
        ];
        for (key, value, low) in numbers {
            if value.is_some_and(|v| !(low..=3600.0).contains(&v)) {
                let value = value.unwrap_or_default();
                add(key, format!("{key} is {value}; allowed: a number from {low} to 3600 s"));
            }
        }
        let twice = self.skills.iter().enumerate().find(|(i, skill)| self.skills[..*i].contains(skill));
        if let Some((i, skill)) = twice {
            add(&format!("skills.{i}"), format!("the skill \"{}\" occurs twice", skill.name()));
        }
        let mut names: Vec<String> = Vec::new();
        for (key, word) in self.asked_after() {
            let name = short_name(word);
            if let Err(fault) = check_word(&name) {
                add(&key, fault.to_string());
            } else if names.contains(&name) {
                add(&key, format!("the questionnaire \"{name}\" occurs twice"));
            }
            names.push(name);
        }
        faults
    }
}

/// A name that cannot be part of a file name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the name \"{word}\" cannot be used; allowed: 1 to 40 small letters, digits and hyphens")]
pub(super) struct WordFault {
    /// Rejected name, as written in the study file.
    word: String,
}

/// Checks that a name can be part of file names and data.
pub(super) fn check_word(word: &str) -> Result<(), WordFault> {
    let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !word.is_empty() && word.len() <= 40 && word.chars().all(fine) {
        return Ok(());
    }
    Err(WordFault { word: word.into() })
}
