//! The one loop, in a window or off-line. In: a scenario, devices or a simulated driver. Out: frames, pictures, summaries.
//! [`Drive`] is the loop's body and the same for both; only here is the wall clock read.

pub mod bench;
mod card;
pub mod contacts;
mod desk;
pub mod display;
mod drive;
mod effort;
mod facts;
pub mod flash;
pub mod host;
mod instruments;
mod keys;
pub mod latency;
pub mod offline;
mod pulse;
mod recordings;
pub mod rehearsal;
pub mod replay;
pub mod shell;
mod show;
pub mod sound;
mod starting;
mod surface;
pub mod trial;
mod view_options;
pub mod visit;
pub mod wheel;
pub mod window;
mod words;

use crate::{sim::WorldError, traffic::TrafficError};

pub use desk::Desk;
pub use drive::Drive;
pub use effort::{quality, renderer_that_keeps_up};
pub use facts::now as utc_now;
pub use instruments::Instruments;
pub use pulse::Pulse;
pub use show::{Restarted, Show};
pub use view_options::view_options;

impl AppError {
    /// True if nothing failed: somebody ended the program while it waited for an engine that runs elsewhere.
    pub fn is_interruption(&self) -> bool {
        matches!(self, Self::World(WorldError::Traffic(TrafficError::Interrupted)))
    }
}

/// Why a drive could not be shown or run.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The world could not start or go on.
    #[error(transparent)]
    World(#[from] crate::sim::WorldError),
    /// A recorded scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] crate::sim::ScenarioError),
    /// The recording cannot be written or read.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
    /// A session of a study cannot begin or go on.
    #[error(transparent)]
    Session(#[from] crate::study::SessionError),
    /// The simulated driver is unknown.
    #[error(transparent)]
    Driver(#[from] crate::driver::DriverError),
    /// There is no display to open a window on.
    #[error(
        "no window can be opened: {0}\n  remedy: start it on a computer with a display (DISPLAY or WAYLAND_DISPLAY); without one, codrive render draws pictures and codrive run drives"
    )]
    NoDisplay(String),
    /// There is no such monitor.
    #[error("there is no monitor {number}; there are {there}\n  remedy: name one of them: codrive doctor lists them")]
    NoMonitor {
        /// The one that was asked for.
        number: usize,
        /// All that there are.
        there: String,
    },
    /// The monitor has no such refresh rate.
    #[error(
        "no mode of the monitor has {hz} Hz at its size; there is {there}\n  remedy: name one of its rates, or set it in the system"
    )]
    NoRefresh {
        /// The rate that was asked for.
        hz: f64,
        /// What there is.
        there: String,
    },
    /// The adapter cannot show pictures in the window.
    #[error("the graphics adapter cannot draw into the window: {0}. WGPU_BACKEND=vulkan|gl chooses another")]
    NoSurface(String),
    /// A thread of ours ended before its time: a bug.
    #[error("{0} ended before its time")]
    Ended(String),
    /// No graphics device, or it was lost.
    #[error(transparent)]
    Gpu(#[from] crate::render::GpuError),
}
