//! The drive loop without a window: simulated drivers at full speed, rehearsals, evaluation drives. In: a scenario, a
//! driver. Out: ticks, recordings, summaries.
//!
//! * [`drive`]: the loop's body, the same with and without a window. [`offline`]: a drive by a simulated driver.
//! * [`rehearsal`]: a study with simulated participants; [`baselines`]: trials repeated without advice.
//! * [`evaluation_drive`]: one whole drive, evaluated as on the fast ring.
//! * [`episode`]: a drive that a learner advises from outside; [`episode_config`]: its settings; [`hold_measures`]: its
//!   measures.
//! * [`recording_manifest`]: the manifest of a recording. [`summary_text`]: a drive's summary as text.

pub mod baselines;
pub mod drive;
pub mod episode;
pub mod episode_config;
pub mod evaluation_drive;
pub mod hold_measures;
pub mod offline;
pub mod recording_manifest;
pub mod rehearsal;
pub mod summary_text;

use crate::{sim::WorldError, traffic::TrafficError};

pub use drive::Drive;

impl RunError {
    /// Returns true if nothing failed: the user ended the program while traffic was starting.
    pub fn is_interruption(&self) -> bool {
        matches!(self, Self::World(WorldError::Traffic(TrafficError::Interrupted)))
    }
}

/// Error of a drive or of its window.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The world cannot start or go on.
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
    /// An LSL stream of another device or of this program is not available.
    #[error(transparent)]
    Lsl(#[from] crate::lsl::LslError),
    /// No program speaks a sentence of the guidance.
    #[cfg(feature = "desktop")]
    #[error(transparent)]
    Speech(#[from] crate::audio::SpeechFault),
    /// The trigger device is not available.
    #[error(transparent)]
    Trigger(#[from] crate::triggers::TriggerError),
    /// The simulated driver is unknown or invalid.
    #[error(transparent)]
    Driver(#[from] crate::driver::DriverError),
    /// There is no display for a window.
    #[error(
        "no window can be opened: {0}\n  remedy: start it on a computer with a display (DISPLAY or WAYLAND_DISPLAY); without one, codrive render draws pictures and codrive run drives"
    )]
    NoDisplay(String),
    /// The scale of the windows in the environment is not a scale.
    #[error(
        "{variable}={value}: the scale of windows is a number from {} to {}, or randr\n  remedy: unset {variable}, or set \
         it to one of these",
        range[0],
        range[1]
    )]
    NoScale {
        /// Name of the variable.
        variable: &'static str,
        /// Value of the variable.
        value: String,
        /// Smallest and largest scale.
        range: [f64; 2],
    },
    /// There is no such monitor.
    #[error(
        "there is no monitor {number}; there are {there}\n  remedy: name one of these monitors; codrive doctor lists \
         them"
    )]
    NoMonitor {
        /// Number of the requested monitor.
        number: usize,
        /// Description of the existing monitors.
        there: String,
    },
    /// The monitor has no such refresh rate.
    #[error(
        "no mode of the monitor has {hz} Hz at its size; there is {there}\n  remedy: name one of these rates, or set \
         the rate in the system"
    )]
    NoRefresh {
        /// Requested refresh rate, Hz.
        hz: f64,
        /// Description of the monitor's refresh rates.
        there: String,
    },
    /// The adapter cannot draw into the window.
    #[error(
        "the graphics adapter cannot draw into the window: {0}\n  remedy: choose another graphics interface with \
         WGPU_BACKEND=vulkan or WGPU_BACKEND=gl"
    )]
    NoSurface(String),
    /// A thread of this program ended early, which is a bug.
    #[error("{0} ended too early")]
    Ended(String),
    /// There is no graphics device, or it was lost.
    #[cfg(feature = "desktop")]
    #[error(transparent)]
    Gpu(#[from] crate::render::GpuError),
}
