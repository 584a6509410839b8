//! Many runs from one plan. In: a plan file, which names drives, rings, trainings and rehearsals with all combinations of what is varied.
//! Out: for each run a table of its own (Parquet), under a name that says what was run; and all of them in one table a kind.
//!
//! * [`plan`]: the file and the runs that it names; [`identity`]: what a run is made of, and its fingerprint, with those of the files that it
//!   reads, `file_fingerprints`.
//! * [`execute`]: one run, here and now; [`rows`]: what is written of it.
//! * [`results`]: the folder of a sweep: what is done, what is missing, all of it in tables.
//!
//! Who carries the runs out is decided elsewhere: this program's own workers (`codrive sweep`), an array of jobs by `--part`, or Ray
//! by way of the Python package. A run is the same bytes wherever it is made: it has no clock in it, and its random numbers come from its
//! own seed (docs/decisions.md: 30).

mod combinations;
pub mod execute;
mod file_fingerprints;
pub mod identity;
pub mod plan;
pub mod results;
pub mod rows;

pub use plan::{SweepPlan, SweepRun};

use crate::{drive_loop::RunError, record::RecordError};

/// Why a sweep does not do what was asked; the message is complete.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The plan, or a file that it names, has to be mended.
    #[error("{0}")]
    Plan(String),
    /// A run failed.
    #[error("{0}")]
    Run(String),
    /// A drive failed.
    #[error(transparent)]
    Drive(#[from] RunError),
    /// The disk, or a table on it.
    #[error(transparent)]
    Record(#[from] RecordError),
}
