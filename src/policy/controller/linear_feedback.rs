//! Linear feedback: a speed that rises with the leader's speed, the gap and the mean speed. In: speed, leader's speed, gap, own mean
//! speed. Out: a speed.
//!
//! Linear feedback is the simplest controller with a network's inputs: a network that does not beat it, once tuned, has learned nothing useful. The
//! command is aim + k_lead (v_lead - v) + k_gap (gap - gap_m) + k_mean (v_mean - v), never below 0; [`crate::policy::Advisor`] keeps it within
//! the speed limit.

use super::parameters::{GAIN, Parameter, Parametric, SPEED};
use crate::policy::{Action, Observation, Policy};
use serde::{Deserialize, Serialize};

/// The controller, which has no state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearFeedback {
    /// Command if all differences are 0, m/s.
    pub aim_mps: f64,
    /// Gain on the leader's speed minus own speed, dimensionless.
    pub k_lead: f64,
    /// Gain on the gap beyond `gap_m`, 1/s.
    pub k_gap_per_s: f64,
    /// Gap at which the gap term is 0, m.
    pub gap_m: f64,
    /// Gain on own mean speed over about half a minute ([`crate::policy::MeanSpeed`]) minus current speed, dimensionless.
    pub k_mean: f64,
}

impl LinearFeedback {
    /// Returns a starting point for `codrive tune`, without a published source: half of the speed difference, a tenth of the gap error
    /// per second, and a time gap of 1.5 s at the target speed.
    pub fn around(aim_mps: f64) -> Self {
        Self { aim_mps, k_lead: 0.5, k_gap_per_s: 0.1, gap_m: 1.5 * aim_mps, k_mean: 0.0 }
    }

    /// Returns the commanded speed, m/s.
    pub fn command_mps(&self, observation: &Observation) -> f64 {
        let Observation { speed_mps, leader_speed_mps, gap_m, mean_speed_mps, .. } = *observation;
        let lead = self.k_lead * (leader_speed_mps - speed_mps);
        let gap = self.k_gap_per_s * (gap_m - self.gap_m);
        let mean = self.k_mean * (mean_speed_mps - speed_mps);
        (self.aim_mps + lead + gap + mean).max(0.0)
    }
}

impl Parametric for LinearFeedback {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { key: "aim_mps", doc: "Speed if all differences are 0", ..SPEED },
        Parameter { key: "k_lead", doc: "Gain on the leader's speed minus the own speed", search: [-1.0, 3.0], ..GAIN },
        Parameter { key: "k_gap_per_s", doc: "Gain on the gap beyond gap_m", unit: "1/s", search: [-0.5, 1.0], ..GAIN },
        Parameter {
            key: "gap_m",
            doc: "Gap at which the term of the gap is 0",
            unit: "m",
            limits: [0.0, 1000.0],
            search: [0.0, 40.0],
            ..GAIN
        },
        Parameter {
            key: "k_mean",
            doc: "Gain on the own half-minute mean speed minus the current speed",
            search: [-2.0, 2.0],
            ..GAIN
        },
    ];

    fn numbers(&self) -> Vec<f64> {
        vec![self.aim_mps, self.k_lead, self.k_gap_per_s, self.gap_m, self.k_mean]
    }

    fn of(x: &[f64]) -> Self {
        Self { aim_mps: x[0], k_lead: x[1], k_gap_per_s: x[2], gap_m: x[3], k_mean: x[4] }
    }
}

impl Policy for LinearFeedback {
    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        Action::Speed(self.command_mps(observation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_gain_works_on_its_own_difference() {
        let seen = Observation {
            speed_mps: 3.0,
            leader_speed_mps: 5.0,
            gap_m: 10.0,
            mean_speed_mps: 2.0,
            ..Observation::default()
        };
        let policy = LinearFeedback { aim_mps: 4.0, k_lead: 0.0, k_gap_per_s: 0.0, gap_m: 6.0, k_mean: 0.0 };
        // By hand: 4, 4 + 0.5 x 2, 4 + 0.25 x 4, 4 - 0.5 x 1, and all terms together.
        assert_eq!(policy.command_mps(&seen), 4.0);
        assert_eq!(LinearFeedback { k_lead: 0.5, ..policy }.command_mps(&seen), 5.0);
        assert_eq!(LinearFeedback { k_gap_per_s: 0.25, ..policy }.command_mps(&seen), 5.0);
        assert_eq!(LinearFeedback { k_mean: 0.5, ..policy }.command_mps(&seen), 3.5);
        let all = LinearFeedback { k_lead: 0.5, k_gap_per_s: 0.25, k_mean: 0.5, ..policy };
        assert_eq!(all.command_mps(&seen), 5.5);
    }

    #[test]
    fn the_command_is_never_below_zero() {
        let policy = LinearFeedback { k_lead: 10.0, ..LinearFeedback::around(4.0) };
        let seen = Observation { speed_mps: 8.0, ..Observation::default() };
        assert_eq!(policy.command_mps(&seen), 0.0);
    }
}
