//! Recordings: every tick of a drive on disk, as it happens. In: the world after each tick, frames, marks. Out: a folder.
//!
//! ```text
//! manifest.json   format of the recording; what was driven, on what, by which program; how it ended
//! scenario.toml   the scenario, to be driven again
//! streams/        other devices: tables of their streams, triggers, the drive's clock ([`streams`])
//! inputs/         copies of a map, a policy and a demand that are not shipped
//! journal/        blocks of rows during the drive; a cut at any byte loses one batch at most
//! ego.parquet     at the end, instead of the journal: one row for each tick; also cars, advice, frames, events;
//!                 on networks departures, arrivals, signals, path; with other advised vehicles advised
//! summary.json    key figures of the drive
//! checksums.json  SHA-256 of all files and of each column of the tables
//! lost+found/     only after damage: the journal with the unreadable rows
//! lock            held by the program that records
//! ```
//! Each row carries its tick, so rows of different tables join exactly. [`tables`] names every column with its unit. Nothing is
//! ever overwritten, and files are private to the user. Names and contact data of people are never recorded.

mod block;
mod checksums;
pub mod compare;
mod error;
mod files;
pub mod inputs;
mod journal;
mod journal_reader;
#[cfg(test)]
mod journal_tests;
pub mod kill_point;
mod lock;
pub mod manifest;
pub mod parts;
mod recorder;
pub mod recover;
pub mod seals;
mod sha256;
mod stream_clock;
pub mod streams;
pub mod table;
mod table_writer;
pub mod tables;

pub use checksums::Checksums;
pub use compare::{CellDifference, TableComparison};
pub use error::RecordError;
pub use files::{
    BESIDE, LITTLE_GB, TOO_LITTLE_GB, entries, free_bytes, is_there, new_dir_within, new_private_dir, remove, rename,
    replace, replace_streaming, write_new,
};
pub use journal::LOST_AND_FOUND;
pub use journal_reader::LostRows;
pub use manifest::Manifest;
pub use recorder::{FLUSH_EVERY, Recorder, WriterStatus};
pub use recover::{RecoveryReport, count, open, recover, remove_unbegun};
pub use seals::{AlteredFile, changes};
pub use sha256::{file_sha256, sha256};
pub use table::{TableColumn, TableParts, TableReader};
pub use tables::Table;
