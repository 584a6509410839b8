//! Noise on the acceleration, one definition and one order of draws for both engines (FACTS 2). In: a setup. Out: what to
//! add to a car's speed in a step, m/s.

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
        // Flow adds sqrt(dt) N(0, noise) to the acceleration, which acts for dt.
        let sd_mps = setup.idm.noise * setup.step_s.sqrt() * setup.step_s;
        Self { stream: rng::stream(setup.seed, "traffic"), sd_mps }
    }

    /// True if every draw is 0.
    pub(super) fn is_silent(&self) -> bool {
        self.sd_mps == 0.0
    }

    /// Speed change of the next car, m/s. To be called once a step for every car in order of ids, the ego included
    /// whoever drives it: a draw that is not used keeps all others where they are.
    pub(super) fn draw_mps(&mut self) -> f64 {
        if self.is_silent() { 0.0 } else { self.sd_mps * self.stream.normal() }
    }
}
