//! From recordings to measures, tables and figures. In: one recording, a participant, or a whole data set. Out: CSV, SVG
//! and one HTML page that opens off-line. SI units.
//!
//! * [`trial`]: one recorded drive, row by row: nothing here reads a whole table, so that a drive of days fits into memory.
//! * [`traffic_steps`]: its vehicles by their numbers, step by step.
//! * [`totals`]: one drive in sums.
//! * [`events`]: when advice asks something new; [`pedal_noise`]: how pedals move when it does not; [`response`]: what a driver does
//!   about each change (SAE J2944).
//! * [`latency_fit`]: distributions of censored times; [`reactions`]: those of each participant in each condition.
//! * [`measures`]: one drive in numbers; every definition with its options is in [`measures::MEASURES`], made of
//!   `measure_list` and the list of networks.
//! * [`network`]: drives on networks, where vehicles come and go.
//! * [`driver_moments`], [`driver_fit`], [`drivers`]: each participant in the numbers of the simulated driver.
//! * [`collect`]: which recordings a folder holds, and which condition each is of.
//! * [`people`]: who took part, and whose drives are left out.
//! * [`sickness`]: ratings of sickness while driving.
//! * [`trajectories`]: what a figure of one drive can show.
//! * [`plan`], [`planned`]: the analysis that the study's file plans, and how it came out; [`mixed_model`], [`normality`],
//!   [`distributions`] are its statistics, `models_page` its part of the report; [`power`]: how often a plan finds an effect.
//! * [`glossary`]: what each column of the tables is, in words.
//! * [`setup`], [`methods`]: what the drives have in common, and the paragraphs that say how they were made.
//! * [`tables`], [`figures`], [`report`]: what is written, drive by drive in `drive_section`; `page` counts figures and tables and has the page's style.

pub mod answer_fit;
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
pub mod reactions;
pub mod report;
pub mod response;
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

/// Why a folder cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// It holds nothing to analyse, or something that is not as this program writes it; the message is complete.
    #[error("{0}")]
    Input(String),
    /// A recording cannot be read.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
}
