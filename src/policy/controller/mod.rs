//! Parametric controllers, by name with their authors' parameters or from a file. In: a name and the road, numbers, or TOML text. Out: a
//! [`Controller`], which makes a [`Policy`](super::Policy), lists its parameters and writes its file.

mod engaged;
mod error;
mod file;
mod follower_stopper;
mod kinds;
mod linear_feedback;
mod open_loop;
mod parameters;
mod pi_saturation;

pub use engaged::EngagedController;
pub use error::ControllerFileError;
pub use file::{ControllerFile, is_controller};
pub use follower_stopper::FollowerStopper;
pub use kinds::{CONTROLLERS, Controller, ControllerKind};
pub use linear_feedback::LinearFeedback;
pub use open_loop::{ConstantSpeed, TwoPhase};
pub use parameters::{Order, Parameter, SearchScale};
pub use pi_saturation::{PiParameters, PiSaturation};

#[cfg(test)]
mod tests;
