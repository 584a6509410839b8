//! Controllers whose speeds a policy in training corrects, one for each ring of a block. In: an observation a step. Out: the speed
//! of each, as the drive has it.

use super::simd::LANES;
use crate::policy::{Controller, EngagedController, Observation, Policy};
use serde::{Deserialize, Serialize};

/// The controllers of sixteen rings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CorrectedControllers {
    controller: Controller,
    step_s: f64,
    engaged: Vec<EngagedController>,
    /// Steps since each was engaged.
    steps: [u32; LANES],
}

impl CorrectedControllers {
    /// Sixteen of this one, asked each `step_s` seconds; each is to be engaged before it is asked.
    pub fn new(controller: &Controller, step_s: f64) -> Self {
        let engaged = vec![EngagedController::new(controller, step_s); LANES];
        Self { controller: *controller, step_s, engaged, steps: [0; LANES] }
    }

    /// A fresh one for lane `l`, which begins with this observation.
    pub fn engage(&mut self, l: usize, seen: &Observation) {
        self.engaged[l] = EngagedController::new(&self.controller, self.step_s);
        self.steps[l] = 0;
        self.engaged[l].watch(seen);
    }

    /// A step has passed in lane `l`.
    pub fn watch(&mut self, l: usize, seen: &Observation) {
        self.steps[l] += 1;
        self.engaged[l].watch(seen);
    }

    /// What it commands in lane `l` now, m/s.
    pub fn command_mps(&self, l: usize, seen: &Observation) -> f64 {
        self.engaged[l].command_mps(f64::from(self.steps[l]) * self.step_s, seen)
    }
}
