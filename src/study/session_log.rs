//! Contents of a session file, and how it is read. In: `session.json`. Out: all runs, answers and notes so far ([`SessionLog`]).

use super::{FmsRating, ParticipantCode, SessionError, questions::Answers};
use crate::file;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::{collections::BTreeMap, path::Path};

/// Name of the session file.
pub const FILE: &str = "session.json";
/// Maximum size of the file, bytes; a note every ten seconds for a day takes less.
const MOST_BYTES: u64 = 8 << 20;

/// End of one run of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ItemOutcome {
    /// Completed to its end.
    Done,
    /// Broken off; the item comes again.
    Aborted,
    /// Interrupted by the end of the program or a power cut; the item comes again.
    Cut,
    /// Skipped by the experimenter.
    Skipped,
    /// Called back by the experimenter after it was done; the item comes again.
    Repeat,
}

impl ItemOutcome {
    fn settles(self) -> bool {
        matches!(self, Self::Done | Self::Skipped)
    }
}

/// One run of an item.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ItemRun {
    /// Name of the item in the plan.
    pub item: String,
    /// End of the run.
    pub outcome: ItemOutcome,
    /// Reason in the experimenter's words; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// Start of the run, UTC.
    pub began: String,
    /// End of the run, UTC.
    pub ended: String,
    /// Folder of the run's recording, relative to the session file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// Answers to a questionnaire that was not completed, with what was typed and not yet entered; and those of a completed one that was repeated
    /// and completed again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<TimedAnswer>,
}

/// Item that is running now.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunningItem {
    /// Name of the item in the plan.
    pub item: String,
    /// Folder for the recording, relative to the session file.
    pub recording: String,
    /// Start of the run, UTC.
    pub began: String,
    /// Answers so far, if the item is a questionnaire.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<TimedAnswer>,
}

/// Note by the experimenter: a text, a mark, an extension.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionNote {
    /// Time of the note, UTC.
    pub at: String,
    /// Item that was running.
    pub item: Option<String>,
    /// Kind of the note: `note`, `mark`, `extend` or another word.
    pub kind: String,
    /// Text of the note.
    pub text: String,
}

/// Answer to one question, with its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedAnswer {
    /// Name of the question; `name.row` for a matrix.
    pub question: String,
    /// Answer as a JSON value.
    pub answer: Value,
    /// Time from first sight of the page to this answer, s.
    pub time_s: f64,
}

/// Rating of sickness while driving.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveRating {
    /// Name of the drive in the plan.
    pub item: String,
    /// Folder of the drive's recording, relative to the session file.
    pub recording: String,
    /// Time of the question, and the rating.
    #[serde(flatten)]
    pub rating: FmsRating,
}

/// End of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionEnd {
    /// True if all items are done or skipped; false if the session was stopped before, as after sickness.
    pub complete: bool,
    /// Reason why the session was stopped; empty if it was completed.
    pub reason: String,
    /// Time of the end, UTC.
    pub at: String,
    /// Rule of the study that stopped the session, or a technical reason; `None` if the experimenter stopped it for another
    /// reason, and in logs of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<EndCause>,
    /// Reason for excluding the data from the study, if they are excluded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excluded: Option<String>,
}

/// Kind of the cause that ends a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndCause {
    /// The participant did not agree to take part.
    Declined,
    /// The answers exclude the participant from the study.
    NotEligible,
    /// A score was above its limit.
    ScoreLimit,
    /// The program, the computer or a device failed, by the experimenter's word.
    Technical,
}

/// Person or simulated participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParticipantKind {
    Person,
    /// A simulated participant of a rehearsal.
    Simulated,
}

/// Contents of the session file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionLog {
    /// Code of the participant.
    pub participant: ParticipantCode,
    /// Number of the participant in the study, from 0; selects the order of conditions.
    pub index: usize,
    /// Kind of participant: a person, or a simulated one of a rehearsal.
    pub kind: ParticipantKind,
    /// Parameters of a simulated participant, by name with unit.
    #[serde(default)]
    pub traits: BTreeMap<String, f64>,
    /// Frames per second that the computer drew before the first page, the lowest if the session was opened repeatedly; `None` if the
    /// study asks for none, and for simulated participants.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames_per_s: Option<f64>,
    /// Conditions in this participant's order.
    pub order: Vec<String>,
    /// Item that is running; an item found here when the file is opened was cut.
    #[serde(default)]
    pub running: Option<RunningItem>,
    /// Runs of items, in order.
    pub item_runs: Vec<ItemRun>,
    /// Notes of the experimenter.
    #[serde(default)]
    pub notes: Vec<SessionNote>,
    /// Answers of the last completed run, by the item's name. These count; those of runs before it are with their run.
    #[serde(default)]
    pub answers: BTreeMap<String, Vec<TimedAnswer>>,
    /// Ratings of sickness while driving, in order, including drives that were broken off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fms: Vec<DriveRating>,
    /// End of the session; `None` while it can go on.
    #[serde(default)]
    pub end: Option<SessionEnd>,
}

impl SessionLog {
    /// Reads a session file.
    ///
    /// # Errors
    /// The file cannot be read or is not a session file.
    pub fn load(path: &Path) -> Result<Self, SessionError> {
        let refused = |why: String| {
            SessionError::Refused(format!(
                "{}: {why}; restore a copy of the file, or begin with another participant code",
                path.display()
            ))
        };
        let text = file::read_text(path, MOST_BYTES).map_err(|e| refused(format!("cannot be read: {e}")))?;
        serde_json::from_str(&text).map_err(|e| refused(format!("not a session of this program: {e}")))
    }

    /// Returns the last run of an item.
    pub fn last(&self, item: &str) -> Option<&ItemRun> {
        self.item_runs.iter().rfind(|item_run| item_run.item == item)
    }

    /// Returns true if the item was done or skipped and not called back.
    pub fn is_settled(&self, item: &str) -> bool {
        self.last(item).is_some_and(|item_run| item_run.outcome.settles())
    }

    /// Returns the last run of an item if it was completed, and neither called back nor skipped.
    pub fn done(&self, item: &str) -> Option<&ItemRun> {
        self.last(item).filter(|item_run| item_run.outcome == ItemOutcome::Done)
    }
}

/// Converts answers to a map by question, as scores and conditions need it.
pub fn as_map(answered: &[TimedAnswer]) -> Answers {
    answered.iter().map(|a| (a.question.clone(), a.answer.clone())).collect()
}
