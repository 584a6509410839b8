//! The advice that a policy in training corrects, for each ring of a block. In: an observation each step. Out: the corrected speed at
//! each decision, as in a drive.

use super::{config::TrainConfig, simd::LANES};
use crate::policy::{Controller, CorrectedAdvice, EngagedController, Network, NetworkOutput, Observation, Policy};
use serde::{Deserialize, Serialize};

impl TrainConfig {
    /// Returns the advice that the policy corrects, if any.
    ///
    /// # Errors
    /// The reason that the advice cannot be corrected, and what can be.
    pub fn corrected_advice(&self) -> Result<Option<CorrectedAdvice>, String> {
        if !self.is_residual() {
            return Ok(None);
        }
        let refused = |why: &dyn std::fmt::Display| format!("residual_over: {why}");
        let settings = self.policy_settings(0.0);
        let advice = CorrectedAdvice::read(&self.advice.residual_over, &settings).map_err(|why| refused(&why))?;
        // The configuration has been checked: the policy's action is a speed.
        advice.check(NetworkOutput::Speed, self.ring.least_spacing_m).map_err(|why| refused(&why))?;
        Ok(Some(advice))
    }
}

/// The corrected advice of sixteen rings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CorrectedLanes {
    advisors: LaneAdvisors,
    /// Advice of each lane at its last decision, m/s, in force until the next.
    advised_mps: [f64; LANES],
}

/// Source of the corrected advice.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum LaneAdvisors {
    /// One controller per ring, with its memory.
    Controllers(LaneControllers),
    /// One network for all rings, since it has no memory.
    Network(Box<Network>),
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct LaneControllers {
    controller: Controller,
    step_s: f64,
    engaged: Vec<EngagedController>,
    /// Steps since each controller was engaged.
    steps: [u32; LANES],
}

impl CorrectedLanes {
    /// Returns the advice for sixteen rings with steps of `step_s` seconds; each lane must be engaged before it is asked.
    pub fn new(advice: &CorrectedAdvice, step_s: f64) -> Self {
        let advisors = match advice {
            CorrectedAdvice::Controller(controller) => LaneAdvisors::Controllers(LaneControllers {
                controller: *controller,
                step_s,
                engaged: vec![EngagedController::new(controller, step_s); LANES],
                steps: [0; LANES],
            }),
            CorrectedAdvice::Network(network) => LaneAdvisors::Network(network.clone()),
        };
        Self { advisors, advised_mps: [0.0; LANES] }
    }

    /// Engages a new controller in lane `l` and makes its first decision with this observation.
    pub fn engage(&mut self, l: usize, seen: &Observation) {
        if let LaneAdvisors::Controllers(lanes) = &mut self.advisors {
            lanes.engaged[l] = EngagedController::new(&lanes.controller, lanes.step_s);
            lanes.engaged[l].watch(seen);
            lanes.steps[l] = 0;
        }
        self.decide(l, seen);
    }

    /// Returns true if the advice needs every step and not only those with a decision.
    pub fn watches(&self) -> bool {
        matches!(self.advisors, LaneAdvisors::Controllers(_))
    }

    /// Observes one step in lane `l`.
    pub fn watch(&mut self, l: usize, seen: &Observation) {
        if let LaneAdvisors::Controllers(lanes) = &mut self.advisors {
            lanes.steps[l] += 1;
            lanes.engaged[l].watch(seen);
        }
    }

    /// Makes a new decision in lane `l`.
    pub fn decide(&mut self, l: usize, seen: &Observation) {
        self.advised_mps[l] = match &self.advisors {
            LaneAdvisors::Controllers(lanes) => {
                lanes.engaged[l].command_mps(f64::from(lanes.steps[l]) * lanes.step_s, seen)
            }
            LaneAdvisors::Network(network) => network.speed_mps(seen),
        };
    }

    /// Returns the advice of lane `l` at its last decision, m/s.
    pub fn advised_mps(&self, l: usize) -> f64 {
        self.advised_mps[l]
    }
}
