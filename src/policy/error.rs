//! Faults of a trained policy's file, by kind and as messages.

use super::{Feature, network::PolicyNetworkFault};
use std::path::{Path, PathBuf};

/// Error for an unusable policy file.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {fault}")]
pub struct PolicyFileError {
    /// Path of the file.
    pub path: String,
    /// Kind of fault; its message says what is needed.
    pub fault: Box<PolicyFileFault>,
}

impl PolicyFileError {
    /// Returns the error for this file.
    pub(super) fn new(path: &Path, fault: PolicyFileFault) -> Self {
        Self { path: path.display().to_string(), fault: fault.into() }
    }
}

/// Fault of a policy file.
#[derive(Debug, thiserror::Error)]
pub enum PolicyFileFault {
    /// The file cannot be read.
    #[error("cannot be read: {source}{near}")]
    Unreadable {
        /// Error of the operating system.
        source: std::io::Error,
        /// Suggestion of the nearest existing file name; empty if none is near.
        near: String,
    },
    /// The description file beside the network cannot be read.
    #[error("{} cannot be read: {source}", file.display())]
    UnreadableDescription {
        /// Path of the description file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The policy file is invalid.
    #[error(transparent)]
    Network(#[from] PolicyNetworkFault),
    /// The ONNX network is invalid.
    #[cfg(feature = "onnx")]
    #[error(transparent)]
    Onnx(#[from] super::onnx::OnnxFault),
    /// The file is an ONNX network, and this build cannot read ONNX.
    #[cfg(not(feature = "onnx"))]
    #[error(
        "ONNX files are read only by a program that is built with the cargo feature `onnx`\n  \
         remedy: build it with cargo build --release, which scripts/drive keeps"
    )]
    WithoutOnnx,
}

/// Fault of a setting that both file formats have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingFault {
    /// The limits of the action are empty or not finite.
    #[error("limits are {low} to {high}; the first must be below the second")]
    Limits {
        /// Lowest action, m/s² or m/s.
        low: f64,
        /// Highest action, m/s² or m/s.
        high: f64,
    },
    /// The bound on the change of speed is negative or not finite.
    #[error("speed_change_mps must be 0 or more")]
    SpeedChange,
    /// The least spacing is negative or not finite.
    #[error("least_spacing_m must be 0 or more")]
    LeastSpacing,
    /// The bound on the expected gain is not finite.
    #[error("silent_below_mps must be a finite number")]
    SilentBelow,
    /// An input's range is empty or not finite.
    #[error("input {}: `to` must be above `from`", .0.name())]
    Input(Feature),
}
