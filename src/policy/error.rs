//! Reasons that a policy cannot be built or its file cannot be used, by kind and as messages.

use super::{
    ControllerFileError, FEATURES, NAMES, NotCorrectable, PolicyNetworkFault,
    names::{all_names, correctable_names},
};
use crate::toml_text::did_you_mean;
use std::path::{Path, PathBuf};

/// Reasons that a policy cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// No policy has this name.
    #[error(
        "policy `{name}` is unknown{}; allowed: {}, the FILE.toml or FILE.onnx of a trained policy, or the FILE.toml \
         of a controller",
        did_you_mean(name, &all_names()), all_names().join(", ")
    )]
    Unknown {
        /// Policy name as the user gave it.
        name: String,
    },
    /// No controller has this name.
    #[error(
        "controller `{name}` is unknown{}; allowed: {}, or the FILE.toml of a controller",
        did_you_mean(name, &NAMES[1..]), NAMES[1..].join(", ")
    )]
    UnknownController {
        /// Controller name as the user gave it.
        name: String,
    },
    /// No controller and no correctable policy has this name.
    #[error(
        "controller or policy `{name}` is unknown{}; allowed: {}, or the FILE.toml of a controller or of a trained \
         policy",
        did_you_mean(name, &correctable_names()), correctable_names().join(", ")
    )]
    UnknownCorrected {
        /// Name as the user gave it.
        name: String,
    },
    /// An ONNX network cannot be embedded in a policy file.
    #[error(
        "policy {name} cannot be corrected: it is not a policy file of this program\n  remedy: name its policy.toml"
    )]
    CorrectedOnnx {
        /// Policy name as the user gave it.
        name: String,
    },
    /// The policy's advice cannot be corrected.
    #[error("policy {name} {fault}")]
    NotCorrectable {
        /// Policy name as the user gave it.
        name: String,
        /// Reason that it cannot be corrected.
        fault: NotCorrectable,
    },
    /// The policy was trained with the driver's traits as input. A drive does not supply them.
    #[error(
        "policy {name} needs the driver's traits ({}), and has no estimator for them\n  remedy: train it with \
         estimator_rounds above 0, or name another policy",
        FEATURES.iter().filter(|feature| feature.is_of_driver()).map(|feature| feature.name()).collect::<Vec<_>>().join(", ")
    )]
    MustBeTold {
        /// Policy name as the user gave it.
        name: String,
    },
    /// The policy sees the whole ring or the driver's deviation. A drive does not supply them.
    #[error(
        "policy {name} sees `{feature}`, which is known only while training and in codrive evaluate on fast rings\n  remedy: name \
         another policy"
    )]
    SeesWholeRing {
        /// Policy name as the user gave it.
        name: String,
        /// Name of the first such input.
        feature: &'static str,
    },
    /// The policy needs more of the road than training and evaluation rings have.
    #[error(
        "policy {name} needs whole drives: it {why} on rings of training and evaluation\n  remedy: use codrive run, or \
         name another policy"
    )]
    NotOnRings {
        /// Policy name as the user gave it.
        name: String,
        /// Part of the road that the policy needs.
        why: String,
    },
    /// The file of a trained policy cannot be used.
    #[error("policy {0}")]
    File(#[from] PolicyFileError),
    /// The file of a controller cannot be used.
    #[error("policy {0}")]
    Controller(#[from] ControllerFileError),
}

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
        "this program was built without the cargo feature `onnx`, which reads ONNX files\n  remedy: build it with \
         cargo build --profile first, which scripts/drive keeps"
    )]
    WithoutOnnx,
}
