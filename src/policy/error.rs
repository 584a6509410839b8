//! What can be wrong with the file of a trained policy, in words and by kind.

use super::{Feature, network::NetworkFault};
use std::path::{Path, PathBuf};

/// Why a policy file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {fault}")]
pub struct PolicyFileError {
    /// The file.
    pub path: String,
    /// What is wrong, and what is needed.
    pub fault: Box<PolicyFileFault>,
}

impl PolicyFileError {
    /// Of this file.
    pub(super) fn new(path: &Path, fault: PolicyFileFault) -> Self {
        Self { path: path.display().to_string(), fault: fault.into() }
    }
}

/// What is wrong with a policy file.
#[derive(Debug, thiserror::Error)]
pub enum PolicyFileFault {
    /// The system does not give it.
    #[error("cannot be read: {source}{near}")]
    Unreadable {
        /// What the system said.
        source: std::io::Error,
        /// The nearest file that exists, as a question; empty where none is near.
        near: String,
    },
    /// What lies beside it to describe it cannot be read.
    #[error("{} cannot be read: {source}", file.display())]
    UnreadableDescription {
        /// The file of the description.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A policy of this program's own kind is wrong.
    #[error(transparent)]
    Network(#[from] NetworkFault),
    /// A network in ONNX is wrong.
    #[cfg(feature = "onnx")]
    #[error(transparent)]
    Onnx(#[from] super::onnx::OnnxFault),
    /// It is a network in ONNX, which this program does not read.
    #[cfg(not(feature = "onnx"))]
    #[error(
        "ONNX files are read only by a program that is built with the cargo feature `onnx`\n  \
         remedy: build it with cargo build --release, which scripts/drive keeps"
    )]
    WithoutOnnx,
}

/// What is wrong with a number that files of both kinds have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingFault {
    /// The actions have no range.
    #[error("limits are {low} to {high}; the first must be below the second")]
    Limits {
        /// Lowest action, m/s2 or m/s.
        low: f64,
        /// Highest action, m/s2 or m/s.
        high: f64,
    },
    /// A negative or no bound of the change of speed.
    #[error("speed_change_mps must be 0 or more")]
    SpeedChange,
    /// A negative or no spacing.
    #[error("least_spacing_m must be 0 or more")]
    LeastSpacing,
    /// The bound of what is expected to be gained is no number.
    #[error("silent_below_mps must be a finite number")]
    SilentBelow,
    /// An input has no range.
    #[error("input {}: `to` must be above `from`", .0.name())]
    Input(Feature),
}
