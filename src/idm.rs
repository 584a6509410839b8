//! The Intelligent Driver Model as plain arithmetic (docs/references.md: idm; Treiber, Hennecke, Helbing 2000). In: own
//! speed, leader's speed and gap. Out: acceleration. SI units throughout.

use serde::{Deserialize, Serialize};

/// Parameters of the model and of the noise on its acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IdmParams {
    /// Desired speed on a free road
    #[schemars(range(min = 1.0, max = 60.0), extend("unit" = "m/s"))]
    pub v0: f64,
    /// Desired time gap to the leader
    #[serde(rename = "T")]
    #[schemars(range(min = 0.1, max = 5.0), extend("unit" = "s"))]
    pub t: f64,
    /// Maximum acceleration
    #[schemars(range(min = 0.1, max = 5.0), extend("unit" = "m/s2"))]
    pub a: f64,
    /// Comfortable deceleration
    #[schemars(range(min = 0.1, max = 9.0), extend("unit" = "m/s2"))]
    pub b: f64,
    /// Acceleration exponent
    #[schemars(range(min = 0.5, max = 10.0), extend("unit" = ""))]
    pub delta: f64,
    /// Gap at a standstill
    #[schemars(range(min = 0.1, max = 20.0), extend("unit" = "m"))]
    pub s0: f64,
    /// Acceleration noise: Flow's convention, sqrt(step) N(0, noise) in m/s2
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "m/s2"))]
    pub noise: f64,
}

impl Default for IdmParams {
    /// The ring study's (docs/references.md: idm), with Flow's noise.
    fn default() -> Self {
        Self { v0: 30.0, t: 1.0, a: 1.0, b: 1.5, delta: 4.0, s0: 2.0, noise: 0.2 }
    }
}

impl IdmParams {
    /// Desired gap s* at `speed_mps` behind a leader at `leader_speed_mps`, metres.
    pub fn desired_gap_m(&self, speed_mps: f64, leader_speed_mps: f64) -> f64 {
        let approach = speed_mps * (speed_mps - leader_speed_mps) / (2.0 * (self.a * self.b).sqrt());
        self.s0 + (speed_mps * self.t + approach).max(0.0)
    }

    /// Acceleration, m/s2, at `gap_m` (bumper to bumper) behind a leader. Braking is never clipped (docs/references.md:
    /// idm; clipping at `b` crashes every run).
    pub fn acceleration(&self, speed_mps: f64, leader_speed_mps: f64, gap_m: f64) -> f64 {
        let gap_m = gap_m.max(1e-3);
        let interaction = self.desired_gap_m(speed_mps, leader_speed_mps) / gap_m;
        self.a * (1.0 - (speed_mps / self.v0).powf(self.delta) - interaction * interaction)
    }

    /// The gap at which a car keeps `speed_mps` behind a leader of the same speed, metres; infinite from `v0` up.
    pub fn equilibrium_gap_m(&self, speed_mps: f64) -> f64 {
        let free = 1.0 - (speed_mps / self.v0).powf(self.delta);
        if free <= 0.0 { f64::INFINITY } else { self.desired_gap_m(speed_mps, speed_mps) / free.sqrt() }
    }

    /// The speed at which all cars of an even ring with `gap_m` between them keep going, m/s; 0 if the gap is below `s0`.
    pub fn equilibrium_speed_mps(&self, gap_m: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.v0);
        for _ in 0..100 {
            let middle = (low + high) / 2.0;
            if self.equilibrium_gap_m(middle) < gap_m { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equilibrium_speeds_are_those_of_the_field() {
        // docs/references.md: ring: by length with 22 cars, and the successor's ring.
        let idm = IdmParams::default();
        for (length_m, speed) in
            [(220.0, 3.000), (230.0, 3.454), (240.0, 3.908), (250.0, 4.362), (260.0, 4.816), (270.0, 5.269)]
        {
            let found = idm.equilibrium_speed_mps((length_m - 5.0 * 22.0) / 22.0);
            assert!((found - speed).abs() < 0.001, "{length_m} m: {found}");
        }
    }

    #[test]
    fn at_equilibrium_the_acceleration_is_nil() {
        let idm = IdmParams::default();
        for speed in [0.0, 1.0, 4.362, 20.0] {
            assert!(idm.acceleration(speed, speed, idm.equilibrium_gap_m(speed)).abs() < 1e-9);
        }
    }
}
