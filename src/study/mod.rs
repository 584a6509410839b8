//! A study as one file: segments in order, conditions and their balance, questionnaires. In: TOML and JSON. Out: for every
//! participant a plan of what comes when, checked whole before anything starts.
//!
//! * [`file`]: what a person writes, and every mistake with its line.
//! * [`order`]: who meets the conditions in which order.
//! * [`plan`]: one participant's visit, step by step, each drive a complete scenario.
//! * [`questions`]: questionnaires, a strict subset of SurveyJS JSON; answers and scores.

pub mod file;
pub mod order;
pub mod plan;
pub mod questions;

pub use file::Study;
pub use plan::{Item, Plan, Planned};
pub use questions::Questionnaire;

/// A mistake in a study, a questionnaire or a participant's code; the message is complete.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct StudyError(pub String);
