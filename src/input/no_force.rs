//! Why a wheel gives no force. In: what a library or the kernel said. Out: one message with the remedy; the drive goes on.

use std::{io, path::PathBuf};

/// A wheel that gives no force.
#[derive(Debug, thiserror::Error)]
#[error("{wheel} gives no force ({why}); the drive goes on without\n  remedy: {remedy}")]
pub struct WheelWithoutForce {
    /// What it is called.
    pub wheel: String,
    /// Why.
    pub why: NoForce,
    /// What helps.
    pub remedy: String,
}

/// Why there is no force.
#[derive(Debug, thiserror::Error)]
pub enum NoForce {
    /// There is no SDL2.
    #[error(transparent)]
    NoSdl(#[from] NoSdl),
    /// SDL2 would not do what it was asked.
    #[error("SDL2 {refused}: {complaint}")]
    Sdl {
        /// What it did not do.
        refused: &'static str,
        /// What it said of it.
        complaint: String,
    },
    /// SDL2 does not see the wheel.
    #[error("SDL2 sees {joysticks} joysticks, none of them {vendor:04x}:{product:04x}")]
    Unseen {
        /// How many it sees.
        joysticks: i32,
        /// The wheel's maker on USB.
        vendor: u16,
        /// The wheel's model on USB.
        product: u16,
    },
    /// The wheel, or its driver, has no such effect.
    #[error("its driver has no constant force")]
    NoConstantForce,
    /// The effect cannot be made.
    #[error("upload: {0}")]
    Upload(io::Error),
    /// The kernel refuses.
    #[error(transparent)]
    System(#[from] io::Error),
}

/// SDL2 cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("SDL2 cannot be used: {}", faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
pub struct NoSdl {
    /// What is wrong with each file that was tried.
    pub faults: Vec<LibraryFault>,
    /// What helps.
    pub remedy: String,
}

/// Why one file is not SDL2.
#[derive(Debug, thiserror::Error)]
pub enum LibraryFault {
    /// The system does not open it.
    #[error("{}: {_1}", _0.display())]
    Unopened(PathBuf, libloading::Error),
    /// It lacks a function.
    #[error("{} has no {_1}", _0.display())]
    Lacks(PathBuf, &'static str),
}
