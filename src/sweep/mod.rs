//! Many runs from one plan. In: a plan file that names drives, rings, trainings and rehearsals, with all combinations of the varied
//! settings. Out: one Parquet table per run, named after the run's fingerprint, and one combined table per kind.
//!
//! * [`plan`]: the file and its runs; [`identity`]: the identity of a run and its fingerprint, with the fingerprints of the files that it
//!   reads in `file_fingerprints`.
//! * [`single_run`]: execution of one run in this process; [`rows`]: its rows; [`checkpoint`]: the state from which a training continues.
//! * [`results`]: the folder of a sweep: finished runs, missing runs, and combined tables.
//! * [`supervisor`]: worker processes that carry out the runs on this machine, with retries and time limits.
//!
//! The whole plan runs on one machine (`codrive sweep`), as an array of jobs by `--part`, or on Ray through the Python package. A run gives
//! the same bytes on every machine: no clock changes it, and its random numbers come from its own seed (docs/decisions.md: 30).

pub mod checkpoint;
mod combinations;
mod file_fingerprints;
pub mod identity;
pub mod plan;
mod plan_file;
pub mod results;
pub mod rows;
pub mod single_run;
pub mod supervisor;

pub use checkpoint::{NoCheckpoint, RunCheckpoint};
pub use plan::{SweepPlan, SweepRun};
pub use plan_file::PlanFile;

use crate::{drive_loop::RunError, record::RecordError};

/// Reasons that a sweep fails; the message is complete.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The plan, or a file that it names, is faulty.
    #[error("{0}")]
    Plan(String),
    /// A run failed, with its message.
    #[error("{0}")]
    Run(String),
    /// A drive could not start or continue.
    #[error(transparent)]
    Drive(#[from] RunError),
    /// A file or a table on disk could not be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
}
