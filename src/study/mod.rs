//! A study as one file: segments in order, conditions and their balance, questionnaires. In: TOML and JSON. Out: for every
//! participant a plan of what comes when, checked whole before anything starts.
//!
//! * [`mod@file`]: what a person writes, and every mistake with its line.
//! * [`conditions`]: what a condition changes, and the drives that it makes.
//! * [`order`]: who meets the conditions in which order.
//! * [`segment`]: one segment of that file. [`stop_rule`]: answers that end a session.
//! * [`fms`]: the fast motion sickness scale, asked while driving.
//! * [`plan`]: one participant's session, step by step, each drive a complete scenario.
//! * `reckoning`: how long pages and questionnaires take.
//! * [`practice`]: when a drive of practice has been enough.
//! * [`questions`]: questionnaires, a strict subset of SurveyJS JSON; answers. [`scores`]: what is computed from them.
//! * [`questionnaire_form`]: a questionnaire being answered, by mouse, keys or wheel.
//! * [`participant_code`]: what a participant is called in files.
//! * [`session`]: one participant's session as it goes: what comes next, what was done; on the disk after every step.
//! * [`session_log`]: what that file holds.
//! * [`completion`]: how far a session came. [`lock`]: one program a participant.
//! * `exclusion`: leaves a participant out once the windows are closed. [`erasure`]: nothing of them stays. `export`: all of
//!   it for themselves.
//! * [`dataset`]: the folder of a study, as BIDS has it; [`bids`]: its tables and sidecars; `answer_tables`: those of answers,
//!   `event_table` of events, `motion` of the car's motion, `scans` of all files with shifted dates.
//! * `source`: what a data set keeps of the study's file.
//! * [`checksums`]: the list of a data set's files with their SHA-256. [`places`]: whether each recording lies where it belongs.
//! * [`preregistration`]: the plan of study and analysis as a text to register, with the power.
//! * [`spoken`]: instructions that are heard.
//! * [`simulated`]: participants that nobody has to invite, for a rehearsal.

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
pub mod fms;
mod fms_table;
mod inherited;
pub mod lock;
mod mentions;
mod motion;
pub mod order;
pub mod participant_code;
pub mod places;
pub mod plan;
pub mod practice;
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
mod source;
pub mod spoken;
pub mod stop_rule;

pub use completion::Completion;
pub use dataset::DataSet;
pub use file::{ParticipantTexts, Study};
pub use fms::{FmsPrompt, FmsRating};
pub use participant_code::ParticipantCode;
pub use plan::{PlanItem, PlannedItem, SessionPlan};
pub use practice::UnbrokenTime;
pub use questionnaire_form::{FormInput, QuestionnaireForm};
pub use questions::Questionnaire;
pub use session::Session;
pub use session_log::ItemOutcome;
pub use spoken::SpokenText;

/// A mistake in a study, a questionnaire or a participant's code; the message is complete.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct StudyError(pub String);

/// Why a session cannot begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// It must not; the message says why and what to do.
    #[error("{0}")]
    Refused(String),
    /// The disk refuses.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
}
