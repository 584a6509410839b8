//! Report of an analysis. In: analysed drives, participants, drivers and the planned analysis. Out: one HTML page that opens
//! off-line, its figures as SVG, the methods as text, and the data dictionary.
//!
//! * [`study_report`]: the page from top to bottom; `page` numbers figures and tables and has the page's style; `words`: text
//!   and cells that sections share.
//! * `participant_flow`, `by_condition`, `drive_section`, `drivers_section`, `every_drive`, `models_section`, `scores_section`,
//!   `sickness_section`, `dictionary`: sections; `sample`: the participants in a sentence.
//! * `figures`, `network_figures`: pictures; `methods`, `network_text`, `setup_facts`: the paragraphs of the methods.
//! * `validation_report`, `validation_figures`: a page of its own, of traffic beside measured people.
//! * [`files`]: the files of an analysis. [`glossary`]: definitions of all columns of the tables.

mod by_condition;
mod dictionary;
mod drive_section;
mod drivers_section;
mod every_drive;
mod figures;
pub mod files;
pub mod glossary;
mod methods;
mod models_section;
mod network_figures;
mod network_text;
mod page;
mod participant_flow;
mod sample;
mod scores_section;
mod setup_facts;
mod sickness_section;
pub mod study_report;
mod validation_figures;
mod validation_report;
mod words;

#[cfg(test)]
mod page_tests;

pub use drive_section::space_time;
pub use files::{AnalysisResults, write_page};
pub use study_report::{FileProof, StudyReport, report};
pub use validation_report::{ValidationReport, cells, judged, validation_report};
