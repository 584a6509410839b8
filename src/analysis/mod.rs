//! From recordings to measures, tables and figures. In: one recording, a participant, or a whole data set. Out: CSV, SVG and
//! one HTML page that opens off-line. SI units.
//!
//! * [`trial`]: one recorded drive, row by row. Nothing here reads a whole table, so that a drive of days fits into memory.
//! * [`traffic_steps`]: vehicles of a drive by their numbers, step by step.
//! * [`totals`]: sums of one drive.
//! * [`events`]: changes of the advice that need a response; [`pedal_noise`]: pedal movements without one; [`response_detection`]: the
//!   driver's response to each change (SAE J2944).
//! * [`latency_fit`]: distributions of censored times; [`response_time_table`]: times of each participant in each condition.
//! * [`measures`]: measures of one drive; every definition with its options is in [`measures::MEASURES`], made of
//!   `measure_list` and the list of networks.
//! * [`network`]: drives on networks, where vehicles enter and leave.
//! * [`driver_moments`], [`driver_fit`], [`drivers`]: each participant as a simulated driver.
//! * [`collect`]: the recordings in a folder, each with its condition.
//! * [`people`]: participants, and exclusions.
//! * [`sickness`]: ratings of sickness while driving.
//! * [`trajectories`]: data for the figures of one drive.
//! * [`plan`], [`planned`]: the analysis planned in the study's file, and its results; [`mixed_model`], [`normality`],
//!   [`distributions`] are its statistics, `models_page` its part of the report; [`power`]: how often a plan detects an effect.
//! * [`glossary`]: definitions of all columns of the tables.
//! * [`setup`], [`methods`]: the setup that drives share, and the paragraphs of the methods.
//! * [`tables`], [`figures`], [`report`]: the output, with single drives in `drive_section`; `page` numbers figures and tables
//!   and has the page's style.

pub mod collect;
pub mod distributions;
mod drive_section;
pub mod driver_fit;
pub mod driver_moments;
pub mod drivers;
pub mod events;
pub mod figures;
pub mod glossary;
pub mod latency_fit;
mod measure_inputs;
mod measure_list;
pub mod measures;
pub mod methods;
pub mod mixed_model;
mod models_page;
pub mod network;
pub mod normality;
mod page;
pub mod pedal_noise;
pub mod people;
pub mod plan;
pub mod planned;
pub mod power;
pub mod report;
pub mod response_detection;
pub mod response_time_model;
pub mod response_time_table;
pub mod setup;
pub mod sickness;
mod simplex;
pub mod tables;
pub mod totals;
pub mod traffic_steps;
pub mod trajectories;
pub mod trial;

pub use collect::{AnalysedRecording, FoundRecording, find};
pub use drive_section::space_time;
pub use measures::{DriveMeasures, MEASURES, RoadKinds};
pub use people::StudyParticipants;
pub use setup::DriveSetup;
pub use trial::RecordedTrial;

#[cfg(test)]
mod page_tests;

/// Reason why a folder cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// Nothing to analyse, or a file that does not have this program's format; the message is complete.
    #[error("{0}")]
    Input(String),
    /// A recording cannot be read.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
}
