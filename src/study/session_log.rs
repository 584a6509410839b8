//! What a session's file holds, and how it is read. In: `session.json`. Out: what was done, answered and noted so far
//! ([`SessionLog`]).

use super::{FmsRating, ParticipantCode, SessionError};
use crate::file;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{collections::BTreeMap, path::Path};

/// The most that is read of it, bytes: a note every ten seconds of a day takes less.
const MOST_BYTES: u64 = 8 << 20;

/// How a passage through an item ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ItemOutcome {
    /// To its end.
    Done,
    /// Broken off; the item comes again.
    Aborted,
    /// The program or the power went away; the item comes again.
    Cut,
    /// Left out by the experimenter.
    Skipped,
    /// It was done, and the experimenter wants it once more.
    Repeat,
}

impl ItemOutcome {
    fn settles(self) -> bool {
        matches!(self, Self::Done | Self::Skipped)
    }
}

/// One passage through an item.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SegmentRecord {
    /// Name of the item in the plan.
    pub item: String,
    /// How it ended.
    pub outcome: ItemOutcome,
    /// Why, in the experimenter's words; empty where nothing is to be said.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// When it began and ended, UTC.
    pub began: String,
    /// When it ended, UTC.
    pub ended: String,
    /// Folder of its recording, beside the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// What had been answered of a questionnaire that did not come to its end.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<TimedAnswer>,
}

/// What happens now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunningItem {
    /// Name of the item.
    pub item: String,
    /// Folder for its recording, beside the file.
    pub recording: String,
    /// When it began, UTC.
    pub began: String,
    /// What has been answered, of a questionnaire.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<TimedAnswer>,
}

/// Something that an experimenter writes down: a note, a mark, an extension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionNote {
    /// When, UTC.
    pub at: String,
    /// The item that was running.
    pub item: Option<String>,
    /// note, mark, extend, ...
    pub kind: String,
    /// In words.
    pub text: String,
}

/// One answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedAnswer {
    /// Name of the question; of a matrix `name.row`.
    pub question: String,
    /// The answer.
    pub answer: Value,
    /// From seeing the page to this answer, seconds.
    pub time_s: f64,
}

/// A rating of sickness while driving.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveRating {
    /// The drive's name in the plan.
    pub item: String,
    /// Folder of its recording, beside the file.
    pub recording: String,
    /// When it was asked, and the answer.
    #[serde(flatten)]
    pub rating: FmsRating,
}

/// How a session ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionEnd {
    /// All items are settled, done or skipped; false: stopped before, as after sickness.
    pub complete: bool,
    /// Why it was stopped.
    pub reason: String,
    /// When, UTC.
    pub at: String,
    /// The rule of the study that stopped it; none where the experimenter did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<EndCause>,
    /// Why its data are excluded from the study, where they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excluded: Option<String>,
}

/// Rules of a study that end a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndCause {
    /// The participant did not agree to take part.
    Declined,
    /// Answers with which nobody takes part.
    NotEligible,
    /// A score was above its limit.
    ScoreLimit,
}

/// Who drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParticipantKind {
    /// A person.
    Person,
    /// A simulated participant.
    Simulated,
}

/// What the file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionLog {
    /// Whose session.
    pub participant: ParticipantCode,
    /// The participant's number in the study, from 0: which order of conditions.
    pub index: usize,
    /// A person, or a rehearsal.
    pub who: ParticipantKind,
    /// Numbers of a simulated participant, by name with unit.
    #[serde(default)]
    pub traits: BTreeMap<String, f64>,
    /// Conditions in this participant's order.
    pub order: Vec<String>,
    /// Now running; what stands here when the file is opened was cut.
    #[serde(default)]
    pub running: Option<RunningItem>,
    /// What was, in order.
    pub passages: Vec<SegmentRecord>,
    /// What was written down.
    #[serde(default)]
    pub notes: Vec<SessionNote>,
    /// Answers by the item's name: of its last passage.
    #[serde(default)]
    pub answers: BTreeMap<String, Vec<TimedAnswer>>,
    /// Ratings of sickness while driving, in order; also of drives that were broken off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fms: Vec<DriveRating>,
    /// Set once the session is over for good.
    #[serde(default)]
    pub end: Option<SessionEnd>,
}

impl SessionLog {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn load(path: &Path) -> Result<Self, SessionError> {
        let refused = |why: String| {
            SessionError::Refused(format!(
                "{}: {why}; put back a copy of it, or begin with another participant code",
                path.display()
            ))
        };
        let text = file::read_text(path, MOST_BYTES).map_err(|e| refused(format!("cannot be read: {e}")))?;
        serde_json::from_str(&text).map_err(|e| refused(format!("is no session of this program: {e}")))
    }

    /// The last passage through an item.
    pub fn last(&self, item: &str) -> Option<&SegmentRecord> {
        self.passages.iter().rfind(|passage| passage.item == item)
    }

    /// True if the item was done or skipped and not called back.
    pub fn is_settled(&self, item: &str) -> bool {
        self.last(item).is_some_and(|passage| passage.outcome.settles())
    }

    /// The last passage through an item that went to its end, unless it was called back or skipped.
    pub fn done(&self, item: &str) -> Option<&SegmentRecord> {
        self.last(item).filter(|passage| passage.outcome == ItemOutcome::Done)
    }
}
