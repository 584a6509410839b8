//! Noise on the acceleration, one definition for both engines (docs/references.md: idm, people). In: drivers. Out: each vehicle's speed
//! with noise, m/s.
//!
//! Flow adds `sqrt(dt) N(0, noise)` to the acceleration of each step. Here the model's step comes first; then the noise changes the speed
//! that the next step starts from, because SUMO accepts noise only in this form. The speeds equal Flow's; the positions follow one step
//! later, 0.6 mm (sd) per step at noise 0.2 and steps of 0.1 s. Both engines then agree to rounding.

use super::{VehicleId, drivers::TrafficDriver};
use crate::rng::{self, Stream};

/// Noise generator of a fixed number of vehicles, by vehicle number.
#[derive(Clone, Debug)]
pub(super) struct Noise(Vec<DriverNoise>);

/// Noise generator of one vehicle.
#[derive(Clone, Debug)]
pub(super) struct DriverNoise {
    stream: Stream,
    /// Share of the change of speed that a step keeps.
    keeps: f64,
    /// Standard deviation of the change that a step adds, m/s.
    adds_mps: f64,
    /// Change of speed in the present step, m/s.
    change_mps: f64,
}

impl Noise {
    pub(super) fn new(drivers: &[TrafficDriver], step_s: f64, seed: u64) -> Self {
        let of = |(id, driver): (u32, &TrafficDriver)| DriverNoise::new(driver, VehicleId(id), step_s, seed);
        Self((0..).zip(drivers).map(of).collect())
    }

    /// Returns a vehicle's speed with noise, m/s, as [`DriverNoise::push`].
    pub(super) fn push(&mut self, car: VehicleId, speed_mps: f64) -> f64 {
        self.0[car.0 as usize].push(speed_mps)
    }
}

impl DriverNoise {
    pub(super) fn new(driver: &TrafficDriver, id: VehicleId, step_s: f64, seed: u64) -> Self {
        let (keeps, adds_mps) = driver.noise.in_steps_of(step_s);
        Self { stream: rng::stream(seed, &format!("vehicle/{}", id.0)), keeps, adds_mps, change_mps: 0.0 }
    }

    /// Returns the vehicle's speed with noise, m/s. Must be called once per step, also while the vehicle is driven externally: a discarded
    /// draw keeps all later draws unchanged. A vehicle that the model keeps at a standstill gets no noise, so that queues do not creep.
    pub(super) fn push(&mut self, speed_mps: f64) -> f64 {
        if self.adds_mps == 0.0 {
            return speed_mps;
        }
        self.change_mps = self.keeps * self.change_mps + self.adds_mps * self.stream.normal();
        if speed_mps > 0.0 { (speed_mps + self.change_mps).max(0.0) } else { 0.0 }
    }
}
