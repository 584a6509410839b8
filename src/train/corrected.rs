//! What a policy in training corrects, in each ring of a block. In: an observation a step. Out: at each decision the speed that is
//! corrected, as the drive has it.

use super::{config::TrainConfig, simd::LANES};
use crate::policy::{Controller, CorrectedAdvice, EngagedController, Network, NetworkOutput, Observation, Policy};
use serde::{Deserialize, Serialize};

impl TrainConfig {
    /// What the policy is to correct, if anything.
    ///
    /// # Errors
    /// Why that cannot be corrected, and what can.
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
    /// What each advised at its last decision, m/s; it stands until the next.
    advised_mps: [f64; LANES],
}

/// Who advises.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum LaneAdvisors {
    /// A controller for each ring, with its memory.
    Controllers(LaneControllers),
    /// A network has no memory: one serves all rings.
    Network(Box<Network>),
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct LaneControllers {
    controller: Controller,
    step_s: f64,
    engaged: Vec<EngagedController>,
    /// Steps since each was engaged.
    steps: [u32; LANES],
}

impl CorrectedLanes {
    /// Sixteen of this one, shown an observation each `step_s` seconds; each is to be engaged before it is asked.
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

    /// A fresh one for lane `l`, which begins and advises with this observation.
    pub fn engage(&mut self, l: usize, seen: &Observation) {
        if let LaneAdvisors::Controllers(lanes) = &mut self.advisors {
            lanes.engaged[l] = EngagedController::new(&lanes.controller, lanes.step_s);
            lanes.engaged[l].watch(seen);
            lanes.steps[l] = 0;
        }
        self.decide(l, seen);
    }

    /// True where it must see every step, and not only those in which it decides.
    pub fn watches(&self) -> bool {
        matches!(self.advisors, LaneAdvisors::Controllers(_))
    }

    /// A step has passed in lane `l`.
    pub fn watch(&mut self, l: usize, seen: &Observation) {
        if let LaneAdvisors::Controllers(lanes) = &mut self.advisors {
            lanes.steps[l] += 1;
            lanes.engaged[l].watch(seen);
        }
    }

    /// Lane `l` decides anew.
    pub fn decide(&mut self, l: usize, seen: &Observation) {
        self.advised_mps[l] = match &self.advisors {
            LaneAdvisors::Controllers(lanes) => {
                lanes.engaged[l].command_mps(f64::from(lanes.steps[l]) * lanes.step_s, seen)
            }
            LaneAdvisors::Network(network) => network.speed_mps(seen),
        };
    }

    /// What it advised in lane `l` at its last decision, m/s.
    pub fn advised_mps(&self, l: usize) -> f64 {
        self.advised_mps[l]
    }
}
