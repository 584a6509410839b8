//! Noise on the acceleration, one definition for both engines (docs/references.md: idm). In: a setup. Out: each car's speed with its
//! noise, m/s.
//!
//! Flow adds `sqrt(dt) N(0, noise)` to the acceleration of each step. Here the model's step comes first, then the noise
//! changes the speed that the next step starts from, because that is what can be told to SUMO. The car's speeds are Flow's;
//! its place follows one step later, 0.6 mm (sd) a step at noise 0.2 and steps of 0.1 s. Both engines then agree to rounding.

use super::{TrafficSetup, VehicleId};
use crate::rng::{self, Stream};

/// Draws the noise of every car.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    /// By the car's number: each has a stream of its own, which no other vehicle disturbs.
    streams: Vec<Stream>,
    /// Standard deviation of the speed change in a step, m/s.
    sd_mps: f64,
}

impl Noise {
    pub(super) fn new(setup: &TrafficSetup) -> Self {
        let streams = (0..setup.cars.len()).map(|id| rng::stream(setup.seed, &format!("vehicle/{id}")));
        Self { streams: streams.collect(), sd_mps: setup.idm.noise * setup.step_s.sqrt() * setup.step_s }
    }

    /// A car's speed with its noise, m/s. To be called once a step for every car, the ego included whoever drives it: a draw that
    /// is not used keeps all later ones where they are. A car that the model holds stays where it is: noise does not creep
    /// through a queue.
    pub(super) fn push(&mut self, car: VehicleId, speed_mps: f64) -> f64 {
        if self.sd_mps == 0.0 {
            return speed_mps;
        }
        let change_mps = self.sd_mps * self.streams[car.0 as usize].normal();
        if speed_mps > 0.0 { (speed_mps + change_mps).max(0.0) } else { 0.0 }
    }
}
