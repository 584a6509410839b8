//! A running controller with its memory. In: an [`Observation`] each step. Out: a speed on request. Unlike a boxed policy, it can be
//! saved in a checkpoint with its memory.

use super::{ConstantSpeed, Controller, FollowerStopper, LinearFeedback, PiSaturation, TwoPhase};
use crate::policy::{Action, Observation, Policy};
use serde::{Deserialize, Serialize};

/// A controller with its memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EngagedController {
    /// One speed for the whole drive.
    Constant(ConstantSpeed),
    /// A slow phase, then the final speed.
    TwoPhase(TwoPhase),
    FollowerStopper(FollowerStopper),
    /// PI with saturation, and the speeds in its window.
    Pi(PiSaturation),
    LinearFeedback(LinearFeedback),
}

impl EngagedController {
    /// Returns a newly engaged controller that gets an observation every `step_s` seconds.
    pub fn new(controller: &Controller, step_s: f64) -> Self {
        match *controller {
            Controller::Constant(controller) => Self::Constant(controller),
            Controller::TwoPhase(controller) => Self::TwoPhase(controller),
            Controller::FollowerStopper(controller) => Self::FollowerStopper(controller),
            Controller::Pi(parameters) => Self::Pi(PiSaturation::new(parameters, step_s)),
            Controller::LinearFeedback(controller) => Self::LinearFeedback(controller),
        }
    }

    /// Returns the commanded speed `time_s` after engagement, m/s, 0 or more.
    pub fn command_mps(&self, time_s: f64, observation: &Observation) -> f64 {
        match self {
            Self::Constant(controller) => controller.speed_mps,
            Self::TwoPhase(controller) => controller.command_mps(time_s),
            Self::FollowerStopper(controller) => controller.command_mps(observation),
            Self::Pi(controller) => controller.command_mps(observation),
            Self::LinearFeedback(controller) => controller.command_mps(observation),
        }
    }
}

impl Policy for EngagedController {
    fn watch(&mut self, observation: &Observation) {
        if let Self::Pi(controller) = self {
            controller.watch(observation);
        }
    }

    fn act(&mut self, time_s: f64, observation: &Observation) -> Action {
        Action::Speed(self.command_mps(time_s, observation))
    }
}

impl Controller {
    /// Returns a newly engaged policy with steps of `step_s` seconds.
    pub fn policy(&self, step_s: f64) -> Box<dyn Policy> {
        Box::new(EngagedController::new(self, step_s))
    }
}
