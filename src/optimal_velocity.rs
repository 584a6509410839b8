//! The optimal velocity model with a follow-the-leader term as plain arithmetic (docs/references.md: people; Bando et al.
//! 1995). In: own speed, leader's speed and gap. Out: acceleration. SI units throughout.

use serde::{Deserialize, Serialize};

/// Highest rate at which a driver takes over the leader's speed, 1/s. The published term has no bound as the gap closes: a vehicle that
/// follows another out of a queue at 1 cm would shoot off, and a step of 0.1 s would overshoot the leader's speed.
pub const HIGHEST_RATE: f64 = 10.0;

/// Parameters of the model. The defaults are a published fit to people who were told to close the gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OptimalVelocityParams {
    /// Rate at which the speed approaches the optimal velocity of the gap
    #[schemars(range(min = 0.01, max = 10.0), extend("unit" = "1/s"))]
    pub alpha: f64,
    /// Weight of the leader's relative speed, divided by the squared gap
    #[schemars(range(min = 0.0, max = 200.0), extend("unit" = "m2/s"))]
    pub beta: f64,
    /// Optimal velocity on a free road
    #[schemars(range(min = 1.0, max = 60.0), extend("unit" = "m/s"))]
    pub v_max: f64,
    /// Gap over which the optimal velocity rises
    #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "m"))]
    pub d0: f64,
    /// Gap of the steepest rise as a multiple of `d0`
    #[schemars(range(min = 0.1, max = 20.0), extend("unit" = ""))]
    pub ds: f64,
}

impl Default for OptimalVelocityParams {
    /// Returns Gunter's fit of experiment G of the Arizona ring (docs/references.md: people).
    fn default() -> Self {
        Self { alpha: 0.6660, beta: 21.5975, v_max: 8.9368, d0: 2.2146, ds: 2.8150 }
    }
}

impl OptimalVelocityParams {
    /// Returns the speed that a driver wants at this gap, m/s.
    pub fn optimal_speed_mps(&self, gap_m: f64) -> f64 {
        self.v_max * ((gap_m / self.d0 - self.ds).tanh() + self.ds.tanh()) / (1.0 + self.ds.tanh())
    }

    /// Returns the acceleration, m/s2, at `gap_m` (bumper to bumper) behind a leader; the wanted speed is at most `limit_mps`.
    pub fn acceleration(&self, speed_mps: f64, leader_speed_mps: f64, gap_m: f64, limit_mps: f64) -> f64 {
        let gap_m = gap_m.max(0.0);
        let wanted_mps = self.optimal_speed_mps(gap_m).min(limit_mps);
        let rate = (self.beta / (gap_m * gap_m)).min(HIGHEST_RATE);
        self.alpha * (wanted_mps - speed_mps) + rate * (leader_speed_mps - speed_mps)
    }

    /// Returns the gap at which a vehicle keeps `speed_mps` behind a leader of the same speed, metres; infinite from `v_max` up.
    pub fn equilibrium_gap_m(&self, speed_mps: f64) -> f64 {
        let rise = speed_mps / self.v_max * (1.0 + self.ds.tanh()) - self.ds.tanh();
        if rise >= 1.0 { f64::INFINITY } else { self.d0 * (rise.atanh() + self.ds) }
    }

    /// Returns the string stability against long waves, 1/s2, as [`crate::idm::IdmParams::string_stability`]: negative if a small
    /// disturbance grows from vehicle to vehicle.
    pub fn string_stability(&self, gap_m: f64) -> f64 {
        let by_leader = self.beta / (gap_m * gap_m);
        let by_speed = -self.alpha - by_leader;
        let slope = 1.0 - (gap_m / self.d0 - self.ds).tanh().powi(2);
        let by_gap = self.alpha * self.v_max / self.d0 * slope / (1.0 + self.ds.tanh());
        by_speed * by_speed - by_leader * by_leader - 2.0 * by_gap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_optimal_velocity_rises_from_nil_to_its_highest() {
        let model = OptimalVelocityParams::default();
        assert_eq!(model.optimal_speed_mps(0.0), 0.0);
        assert!((model.optimal_speed_mps(100.0) - 8.9368).abs() < 1e-9);
        // Half the rise of tanh lies at ds d0 = 6.234 m: v_max tanh(ds) / (1 + tanh(ds)).
        let middle = 8.9368 * 2.815_f64.tanh() / (1.0 + 2.815_f64.tanh());
        assert!((model.optimal_speed_mps(2.2146 * 2.815) - middle).abs() < 1e-12);
    }

    #[test]
    fn at_equilibrium_the_acceleration_is_nil_and_a_limit_holds() {
        let model = OptimalVelocityParams::default();
        for speed in [0.5, 4.0, 8.0] {
            let gap_m = model.equilibrium_gap_m(speed);
            assert!(model.acceleration(speed, speed, gap_m, 30.0).abs() < 1e-9, "{speed}");
        }
        assert!(model.equilibrium_gap_m(8.9368).is_infinite());
        assert!(model.acceleration(5.0, 5.0, 100.0, 5.0).abs() < 1e-12, "5 m/s are allowed");
        // By hand: behind a leader of the same place and speed 4 m/s lower, 10 m ahead, -beta 4 / 100 is added.
        let difference = model.acceleration(5.0, 1.0, 10.0, 30.0) - model.acceleration(5.0, 5.0, 10.0, 30.0);
        assert!((difference + 21.5975 * 4.0 / 100.0).abs() < 1e-12);
    }

    #[test]
    fn a_driver_overshoots_the_leaders_speed_in_a_step_at_no_gap() {
        let model = OptimalVelocityParams::default();
        for gap_m in [0.0, 1e-6, 0.01, 0.5, 1.4] {
            let after_mps = 0.1 * model.acceleration(0.0, 2.0, gap_m, 30.0);
            // The optimal velocity of such gaps is below 0.9 m/s, of which a tenth of a second adds less than 0.06.
            assert!((0.0..2.06).contains(&after_mps), "{gap_m} m: {after_mps} m/s");
        }
    }

    #[test]
    fn string_stability_follows_from_the_numerical_derivatives() {
        let model = OptimalVelocityParams::default();
        let mut signs = [0; 2];
        for gap_m in [4.0, 5.0, 7.3, 9.0, 12.0, 20.0] {
            let v = model.optimal_speed_mps(gap_m);
            let by = |d: [f64; 3]| {
                let at = |h: f64| model.acceleration(v + h * d[1], v + h * d[2], gap_m + h * d[0], 99.0);
                (at(1e-5) - at(-1e-5)) / 2e-5
            };
            let [f_s, f_v, f_l] = [by([1.0, 0.0, 0.0]), by([0.0, 1.0, 0.0]), by([0.0, 0.0, 1.0])];
            let margin = model.string_stability(gap_m);
            assert!((margin - (f_v * f_v - f_l * f_l - 2.0 * f_s)).abs() < 1e-6, "{gap_m}");
            signs[usize::from(margin < 0.0)] += 1;
        }
        assert!(signs.iter().all(|n| *n > 0), "{signs:?}");
        // The ring of the experiment, 153.9 m of gaps between 21 cars, has strong waves.
        assert!(model.string_stability(153.9 / 21.0) < 0.0);
    }
}
