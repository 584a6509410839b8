//! A controller at work. In: an [`Observation`] each step. Out: a speed whenever one is asked for. It can be kept in a
//! checkpoint with its memory, which a boxed policy cannot.

use super::Controller;
use crate::policy::{
    Action, ConstantSpeed, FollowerStopper, LinearFeedback, Observation, PiSaturation, Policy, TwoPhase,
};
use serde::{Deserialize, Serialize};

/// A controller with its memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EngagedController {
    /// One speed for ever.
    Constant(ConstantSpeed),
    /// A slow phase first.
    TwoPhase(TwoPhase),
    /// FollowerStopper.
    FollowerStopper(FollowerStopper),
    /// PI with saturation, and the speeds of its window.
    Pi(PiSaturation),
    /// Linear feedback.
    LinearFeedback(LinearFeedback),
}

impl EngagedController {
    /// Engaged now, to be shown an observation each `step_s` seconds.
    pub fn new(controller: &Controller, step_s: f64) -> Self {
        match *controller {
            Controller::Constant(controller) => Self::Constant(controller),
            Controller::TwoPhase(controller) => Self::TwoPhase(controller),
            Controller::FollowerStopper(controller) => Self::FollowerStopper(controller),
            Controller::Pi(parameters) => Self::Pi(PiSaturation::new(parameters, step_s)),
            Controller::LinearFeedback(controller) => Self::LinearFeedback(controller),
        }
    }

    /// Its command `time_s` after it was engaged, m/s, 0 or more.
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
