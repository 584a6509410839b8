//! The Intelligent Driver Model as plain arithmetic (docs/references.md: idm; Treiber, Hennecke, Helbing 2000). In: own speed,
//! leader's speed and gap. Out: acceleration. SI units throughout.

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
    /// Returns the parameters of the ring study (docs/references.md: idm), with Flow's noise.
    fn default() -> Self {
        Self { v0: 30.0, t: 1.0, a: 1.0, b: 1.5, delta: 4.0, s0: 2.0, noise: 0.2 }
    }
}

impl IdmParams {
    /// Returns the desired gap s* at `speed_mps` behind a leader at `leader_speed_mps`, metres.
    pub fn desired_gap_m(&self, speed_mps: f64, leader_speed_mps: f64) -> f64 {
        let approach = speed_mps * (speed_mps - leader_speed_mps) / (2.0 * (self.a * self.b).sqrt());
        self.s0 + (speed_mps * self.t + approach).max(0.0)
    }

    /// Returns the acceleration, m/s2, at `gap_m` (bumper to bumper) behind a leader. Braking is never clipped: clipping at `b`
    /// crashes every run (docs/references.md: idm).
    pub fn acceleration(&self, speed_mps: f64, leader_speed_mps: f64, gap_m: f64) -> f64 {
        let gap_m = gap_m.max(1e-3);
        let interaction = self.desired_gap_m(speed_mps, leader_speed_mps) / gap_m;
        self.a * (1.0 - (speed_mps / self.v0).powf(self.delta) - interaction * interaction)
    }

    /// Returns the string stability against long waves of a row of such vehicles with `gap_m` between them, 1/s2. It is
    /// negative if a small disturbance grows from vehicle to vehicle. With the derivatives of the acceleration by gap, own
    /// speed and leader's speed in the even flow it is f_v^2 - f_l^2 - 2 f_s (Wilson and Ward 2011).
    pub fn string_stability(&self, gap_m: f64) -> f64 {
        let speed_mps = self.equilibrium_speed_mps(gap_m);
        let desired_m = self.desired_gap_m(speed_mps, speed_mps);
        let interaction = 2.0 * self.a * desired_m / (gap_m * gap_m);
        let by_leader = interaction * speed_mps / (2.0 * (self.a * self.b).sqrt());
        let by_gap = interaction * desired_m / gap_m;
        let free = self.a * self.delta / self.v0 * (speed_mps / self.v0).powf(self.delta - 1.0);
        let by_speed = -free - interaction * self.t - by_leader;
        by_speed * by_speed - by_leader * by_leader - 2.0 * by_gap
    }

    /// Returns the gap at which a vehicle keeps `speed_mps` behind a leader of the same speed, metres; infinite from `v0` up.
    pub fn equilibrium_gap_m(&self, speed_mps: f64) -> f64 {
        let free = 1.0 - (speed_mps / self.v0).powf(self.delta);
        if free <= 0.0 { f64::INFINITY } else { self.desired_gap_m(speed_mps, speed_mps) / free.sqrt() }
    }

    /// Returns the equilibrium speed of an even ring with `gap_m` between the vehicles, m/s; 0 if the gap is below `s0`.
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
    fn equilibrium_speeds_agree_with_published_values() {
        // docs/references.md: ring: by length with 22 vehicles, and the successor's ring.
        let idm = IdmParams::default();
        for (length_m, speed) in
            [(220.0, 3.000), (230.0, 3.454), (240.0, 3.908), (250.0, 4.362), (260.0, 4.816), (270.0, 5.269)]
        {
            let found = idm.equilibrium_speed_mps((length_m - 5.0 * 22.0) / 22.0);
            assert!((found - speed).abs() < 0.001, "{length_m} m: {found}");
        }
    }

    /// Returns the largest real part of the linearised ring's eigenvalues for the longest waves, by numerical derivatives: x''
    /// of vehicle n is f_s (e_{n-1} - e_n) + f_v e_n' + f_l e_{n-1}', so that lambda^2 - (f_v + f_l z) lambda - f_s (z - 1) = 0
    /// with z = exp(-i k).
    fn growth(idm: &IdmParams, gap_m: f64) -> f64 {
        let v = idm.equilibrium_speed_mps(gap_m);
        let by = |d: [f64; 3]| {
            let at = |h: f64| idm.acceleration(v + h * d[1], v + h * d[2], gap_m + h * d[0]);
            (at(1e-5) - at(-1e-5)) / 2e-5
        };
        let [f_s, f_v, f_l] = [by([1.0, 0.0, 0.0]), by([0.0, 1.0, 0.0]), by([0.0, 0.0, 1.0])];
        let mut most = f64::NEG_INFINITY;
        for k in [0.005_f64, 0.01, 0.02] {
            let (zr, zi) = (k.cos(), -k.sin());
            // lambda = (p +- sqrt(p^2 + 4 q)) / 2 with p = f_v + f_l z, q = f_s (z - 1).
            let (pr, pi) = (f_v + f_l * zr, f_l * zi);
            let (dr, di) = (pr * pr - pi * pi + 4.0 * f_s * (zr - 1.0), 2.0 * pr * pi + 4.0 * f_s * zi);
            let size = (dr * dr + di * di).sqrt();
            let root = ((size + dr) / 2.0).max(0.0).sqrt();
            most = most.max((pr + root) / 2.0);
        }
        most
    }

    #[test]
    fn string_stability_has_the_sign_of_the_rings_own_eigenvalues() {
        let mut kinds = [0; 2];
        for a in [0.5, 1.0, 1.5, 3.0] {
            for t in [0.8, 1.0, 1.5, 2.0] {
                for gap_m in [4.0, 6.4, 10.0, 30.0] {
                    let idm = IdmParams { a, t, ..IdmParams::default() };
                    let (margin, growth) = (idm.string_stability(gap_m), growth(&idm, gap_m));
                    kinds[usize::from(margin < 0.0)] += 1;
                    assert_eq!(margin < 0.0, growth > 0.0, "a {a}, T {t}, gap {gap_m}: {margin} {growth}");
                }
            }
        }
        assert!(kinds.iter().all(|n| *n > 5), "{kinds:?}");
        // The published ring of 250 m with 22 vehicles has a wave.
        assert!(IdmParams::default().string_stability(250.0 / 22.0 - 5.0) < 0.0);
    }

    #[test]
    fn at_equilibrium_the_acceleration_is_nil() {
        let idm = IdmParams::default();
        for speed in [0.0, 1.0, 4.362, 20.0] {
            assert!(idm.acceleration(speed, speed, idm.equilibrium_gap_m(speed)).abs() < 1e-9);
        }
    }
}
