//! Noise on the acceleration, one definition and one order of draws for both engines (docs/references.md: idm). In: a setup.
//! Out: each car's speed with its noise, m/s.
//!
//! Flow adds `sqrt(dt) N(0, noise)` to the acceleration of each step. Here the model's step comes first, then the noise
//! changes the speed that the next step starts from, because that is what can be told to SUMO. The car's speeds are Flow's;
//! its place follows one step later, 0.6 mm (sd) a step at noise 0.2 and steps of 0.1 s. Both engines then agree to rounding.

use super::TrafficSetup;
use crate::rng::{self, Stream};

/// Draws a step's noise car by car.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    stream: Stream,
    /// Standard deviation of the speed change in a step, m/s.
    sd_mps: f64,
}

impl Noise {
    pub(super) fn new(setup: &TrafficSetup) -> Self {
        let sd_mps = setup.idm.noise * setup.step_s.sqrt() * setup.step_s;
        Self { stream: rng::stream(setup.seed, "traffic"), sd_mps }
    }

    /// The speed of the next car with its noise, m/s. To be called once a step for every car in order of ids, the ego
    /// included whoever drives it: a draw that is not used keeps all others where they are. A car that the model holds
    /// stays where it is: noise does not creep through a queue.
    pub(super) fn push(&mut self, speed_mps: f64) -> f64 {
        if self.sd_mps == 0.0 {
            return speed_mps;
        }
        let change_mps = self.sd_mps * self.stream.normal();
        if speed_mps > 0.0 { (speed_mps + change_mps).max(0.0) } else { 0.0 }
    }
}
