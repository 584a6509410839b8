//! The drive loop without a window: simulated drivers at full speed, rehearsals, evaluation drives. In: a scenario, who
//! drives. Out: ticks, recordings, summaries.
//!
//! * [`drive`]: the loop's body, the same with and without a window. [`offline`]: a drive by a simulated driver.
//! * [`rehearsal`]: a study with simulated participants; [`baselines`]: trials once more without advice.
//! * [`evaluation_drive`]: one whole drive, evaluated as on the fast ring.
//! * [`episode`]: a drive that is advised from outside, as a learner needs it; [`episode_config`]: its settings.
//! * [`recording_manifest`]: what a recording says of its circumstances. [`summary_text`]: a drive in words.

pub mod baselines;
pub mod drive;
pub mod episode;
pub mod episode_config;
pub mod evaluation_drive;
pub mod offline;
pub mod recording_manifest;
pub mod rehearsal;
pub mod summary_text;

use crate::{sim::WorldError, traffic::TrafficError};

pub use drive::Drive;

impl RunError {
    /// True if nothing failed: somebody ended the program while traffic was being started.
    pub fn is_interruption(&self) -> bool {
        matches!(self, Self::World(WorldError::Traffic(TrafficError::Interrupted)))
    }
}

/// Why a drive could not be shown or run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The world could not start or go on.
    #[error(transparent)]
    World(#[from] crate::sim::WorldError),
    /// A recorded scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] crate::settings::SettingsError),
    /// The recording cannot be written or read.
    #[error(transparent)]
    Record(#[from] crate::record::RecordError),
    /// A session of a study cannot begin or go on.
    #[error(transparent)]
    Session(#[from] crate::study::SessionError),
    /// A stream of another device, or one for others, cannot be had.
    #[error(transparent)]
    Lsl(#[from] crate::lsl::LslError),
    /// There are no triggers.
    #[error(transparent)]
    Trigger(#[from] crate::triggers::TriggerError),
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
    #[cfg(feature = "desktop")]
    #[error(transparent)]
    Gpu(#[from] crate::render::GpuError),
}
