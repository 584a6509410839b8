//! Reasons for a wheel without force feedback. In: the error of a library or of the kernel. Out: one message with the
//! remedy; the drive goes on.

use std::{io, path::PathBuf};

/// Message about a wheel without force feedback.
#[derive(Debug, thiserror::Error)]
#[error("{wheel} gives no force ({why}); the drive continues without force\n  remedy: {remedy}")]
pub struct WheelWithoutForce {
    /// Name of the wheel.
    pub wheel: String,
    /// Reason for the missing force.
    pub why: NoForce,
    /// Advice on how to get force feedback.
    pub remedy: String,
}

/// Reason for missing force feedback.
#[derive(Debug, thiserror::Error)]
pub enum NoForce {
    #[error(transparent)]
    NoSdl(#[from] NoSdl),
    /// SDL2 reported an error.
    #[error("SDL2 {refused}: {complaint}")]
    Sdl {
        /// Name of the failed operation, as a predicate ("does not start").
        refused: &'static str,
        /// SDL2's own error message.
        complaint: String,
    },
    /// SDL2 does not list the wheel.
    #[error("SDL2 lists {joysticks} joysticks, and none of them is {vendor:04x}:{product:04x}")]
    Unseen {
        /// Number of joysticks that SDL2 lists.
        joysticks: i32,
        /// USB vendor of the wheel.
        vendor: u16,
        /// USB product of the wheel.
        product: u16,
    },
    /// The wheel or its driver has no constant force effect.
    #[error("its driver has no constant force")]
    NoConstantForce,
    /// The effect cannot be uploaded.
    #[error("upload: {0}")]
    Upload(io::Error),
    /// A system call failed.
    #[error(transparent)]
    System(#[from] io::Error),
}

/// SDL2 cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("SDL2 cannot be used: {}", faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
pub struct NoSdl {
    /// Error of each file that was tried.
    pub faults: Vec<LibraryFault>,
    /// Advice on how to install SDL2.
    pub remedy: String,
}

/// Reason that a file cannot be used as SDL2.
#[derive(Debug, thiserror::Error)]
pub enum LibraryFault {
    /// The system does not open the file.
    #[error("{}: {_1}", _0.display())]
    Unopened(PathBuf, libloading::Error),
    /// The library lacks a function.
    #[error("{} has no {_1}", _0.display())]
    Lacks(PathBuf, &'static str),
}
