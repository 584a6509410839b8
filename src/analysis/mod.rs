//! From recordings to measures, tables and figures. In: one recording, a participant, or a whole data set. Out: CSV, SVG and
//! one HTML page that opens off-line. SI units.
//!
//! # Rooms, bottom first
//! A room names only rooms of lower rows, by `crate::analysis::ROOM` (`tests/layers.rs` checks it):
//! ```text
//! error  text  statistics  columns   faults / numbers in text / medians / declared columns, lines of CSV
//! data                               recordings of a folder, row by row; participants
//! responses  network                 changes of the advice, and responses to them / drives where vehicles enter and leave
//! measures                           sums of one drive, and the measures made of them
//! drives                             analysed drives, by condition and participant
//! drivers  models                    participants as simulated drivers / planned analysis, mixed models, power
//! tables                             results as CSV, each table with its columns
//! report                             figures, methods, data dictionary, the page
//! ```

mod columns;
pub mod data;
pub mod drivers;
pub mod drives;
pub mod error;
pub mod measures;
pub mod models;
pub mod network;
pub mod report;
pub mod responses;
mod statistics;
pub mod tables;
pub mod text;

pub use columns::{quoted_cell, text_cell};
pub use data::{
    MethodsStatements,
    found::{FolderContents, FoundRecording, find, find_undamaged},
    people::{DamagedParticipants, StudyParticipants},
    setup::DriveSetup,
    trial::RecordedTrial,
};
pub use drives::{AnalysedRecording, analyse};
pub use error::AnalysisError;
pub use measures::{DriveMeasures, MEASURES};
pub use report::space_time;
