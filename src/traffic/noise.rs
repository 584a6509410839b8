//! Noise on the acceleration, one definition for both engines (docs/references.md: idm). In: a setup. Out: each vehicle's speed with noise,
//! m/s.
//!
//! Flow adds `sqrt(dt) N(0, noise)` to the acceleration of each step. Here the model's step comes first; then the noise changes the speed
//! that the next step starts from, because SUMO accepts noise only in this form. The speeds equal Flow's; the positions follow one step
//! later, 0.6 mm (sd) per step at noise 0.2 and steps of 0.1 s. Both engines then agree to rounding.

use super::{FixedSetup, VehicleId};
use crate::rng::{self, Stream};

/// Noise generator of all vehicles.
#[derive(Clone, Debug)]
pub(super) struct Noise {
    /// Streams by vehicle number; a single stream serves all vehicles.
    streams: Vec<Stream>,
    /// Standard deviation of the speed change in a step, m/s.
    sd_mps: f64,
}

impl Noise {
    pub(super) fn new(setup: &FixedSetup) -> Self {
        let streams = (0..setup.cars.len()).map(|id| rng::stream(setup.seed, &format!("vehicle/{id}")));
        Self { streams: streams.collect(), sd_mps: setup.idm.noise * setup.step_s.sqrt() * setup.step_s }
    }

    /// Returns a vehicle's speed with noise, m/s. Must be called once per step for every vehicle, including externally driven ones, and in
    /// the order of ids if all share a stream: a discarded draw keeps all later draws unchanged. A vehicle that the model keeps at a
    /// standstill gets no noise, so that queues do not creep.
    pub(super) fn push(&mut self, car: VehicleId, speed_mps: f64) -> f64 {
        if self.sd_mps == 0.0 {
            return speed_mps;
        }
        let change_mps = self.sd_mps * self.streams[car.0 as usize].normal();
        if speed_mps > 0.0 { (speed_mps + change_mps).max(0.0) } else { 0.0 }
    }
}
