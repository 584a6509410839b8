//! A study as one file: segments in order, conditions with their balanced orders, questionnaires. In: TOML and JSON. Out: the plan of
//! each participant's session, checked whole before anything starts.
//!
//! * [`mod@file`]: the study file; errors name the line. [`texts`]: its texts for the participant, which name the controls in use.
//! * [`conditions`]: the settings that a condition changes, and the drives that result.
//! * [`order`]: the order of the conditions for each participant.
//! * [`segment`]: one segment of the study file. [`stop_rule`]: answers that end a session.
//! * [`fms`]: the fast motion sickness scale, asked while driving.
//! * [`plan`]: one participant's session, step by step, each drive a complete scenario.
//! * `reckoning`: expected durations of pages and questionnaires.
//! * [`practice`]: the progress of a practice drive. [`skills`]: its skills and their criteria.
//! * [`questions`]: questionnaires, a strict subset of SurveyJS JSON, and answers. `answer_condition`: conditions on
//!   answers. [`scores`]: scores computed from answers.
//! * [`questionnaire_form`]: a questionnaire being answered, by mouse, keys or wheel.
//! * [`participant_code`]: the code that names a participant in files.
//! * [`session`]: one participant's session: the next item, and everything done so far; written to disk after every step.
//! * [`session_log`]: contents of the session file.
//! * [`completion`]: how far a session got. [`lock`]: keeps a second program away from a participant.
//! * `exclusion`: excludes a participant after the session windows are closed. [`erasure`]: removes all data of a participant. `export`:
//!   copies all data of a participant for them.
//! * [`dataset`]: the folder of a study, in BIDS layout; [`bids`]: its tables and sidecars; `answer_tables`: tables of answers;
//!   `participant_table`: the table of participants;
//!   `event_table`: tables of events; `motion`: the ego's motion; `scans`: all files with shifted dates.
//! * `source`: the copy of the study file that a data set keeps.
//! * [`checksums`]: the list of a data set's files with their SHA-256. [`places`]: checks that each recording lies where it belongs.
//! * [`preregistration`]: the plan of study and analysis as a text to register, with the power.
//! * [`spoken`]: spoken instructions.
//! * [`simulated`]: simulated participants, for a rehearsal.

mod answer_condition;
mod answer_tables;
pub mod bids;
pub mod checksums;
pub mod completion;
pub mod conditions;
pub mod dataset;
mod dial;
pub mod erasure;
mod event_table;
mod exclusion;
mod export;
pub mod file;
mod file_names;
pub mod fms;
mod fms_table;
mod inherited;
pub mod lock;
mod mentions;
mod motion;
pub mod order;
pub mod participant_code;
mod participant_table;
pub mod places;
pub mod plan;
pub mod practice;
mod preregistered_power;
mod preregistered_questions;
mod preregistered_settings;
pub mod preregistration;
mod question_fault;
pub mod questionnaire_form;
pub mod questions;
mod reckoning;
mod scans;
pub mod scores;
pub mod segment;
pub mod session;
pub mod session_log;
#[cfg(test)]
mod session_tests;
pub mod simulated;
pub mod skills;
mod source;
pub mod spoken;
pub mod stop_rule;
pub mod texts;

pub use completion::Completion;
pub use dataset::DataSet;
pub use file::{Study, StudyFile};
pub use fms::{FmsPrompt, FmsRating};
pub use participant_code::ParticipantCode;
pub use plan::{PlanItem, PlannedItem, SessionPlan};
pub use practice::{PracticeGoals, PracticeObserver, PracticeProgress};
pub use questionnaire_form::{FormInput, QuestionnaireForm};
pub use questions::Questionnaire;
pub use session::Session;
pub use session_log::ItemOutcome;
pub use spoken::SpokenText;
pub use texts::{NamedControl, ParticipantTexts};

/// An error in a study, a questionnaire or a participant code; the message is complete.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct StudyError(pub String);

/// Reason why a session cannot begin or continue.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// A rule forbids it; the message says why and what to do.
    #[error("{0}")]
    Refused(String),
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
}
