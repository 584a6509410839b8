//! The one loop, in a window or off-line. In: a scenario, devices or a simulated driver. Out: frames, pictures, summaries.
//! [`Drive`] is the loop's body and the same for both; only here is the wall clock read.

mod drive;
pub mod offline;
mod instruments;

pub use drive::Drive;
pub use instruments::Instruments;

/// Why a drive could not be shown or run.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The world could not start or go on.
    #[error(transparent)]
    World(#[from] crate::sim::WorldError),
    /// The simulated driver is unknown.
    #[error(transparent)]
    Driver(#[from] crate::driver::DriverError),
}
