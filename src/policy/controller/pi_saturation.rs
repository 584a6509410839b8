//! PI with saturation (Stern et al. 2018, eqs. 3-6; docs/references.md: pi): estimate the traffic's speed by own mean speed over 38 s,
//! aim slightly above it at a wide gap, and follow the leader at a small one. In: an observation each step. Out: a speed.

use super::parameters::{GAIN, Order, Parameter, Parametric};
use crate::policy::{Action, Observation, Policy};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Parameters of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PiParameters {
    /// Averaging window of own mean speed, s.
    pub mean_s: f64,
    /// Gaps at which the target begins to exceed the mean speed and at which it exceeds it fully, m.
    pub catch_up_m: [f64; 2],
    /// Largest excess of the target over the mean speed, m/s.
    pub catch_up_mps: f64,
    /// Smallest safe gap, m.
    pub safe_m: f64,
    /// Time gap to a faster leader: the safe gap is at least this time multiplied by the leader's excess speed, s.
    pub safe_s: f64,
    /// Width of the blend between following the leader and the target speed, m.
    pub blend_m: f64,
}

impl Default for PiParameters {
    /// Returns the parameters of its authors.
    fn default() -> Self {
        Self { mean_s: 38.0, catch_up_m: [7.0, 30.0], catch_up_mps: 1.0, safe_m: 4.0, safe_s: 2.0, blend_m: 2.0 }
    }
}

const CATCH_UP: &str = "Gap above which the target exceeds the mean speed, and gap at the full excess";

impl Parametric for PiParameters {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            key: "mean_s",
            doc: "Window of the own mean speed",
            unit: "s",
            limits: [0.01, 600.0],
            search: [1.0, 90.0],
            ..GAIN
        },
        Parameter { key: "catch_up_m.0", doc: CATCH_UP, unit: "m", limits: [0.0, 1000.0], search: [0.0, 20.0], ..GAIN },
        Parameter {
            key: "catch_up_m.1",
            doc: CATCH_UP,
            unit: "m",
            limits: [0.0, 1000.0],
            search: [1.0, 60.0],
            order: Order::Above,
            ..GAIN
        },
        Parameter {
            key: "catch_up_mps",
            doc: "Largest excess of the target over the mean speed",
            unit: "m/s",
            limits: [0.0, 60.0],
            search: [0.0, 5.0],
            ..GAIN
        },
        Parameter {
            key: "safe_m",
            doc: "Least safe gap",
            unit: "m",
            limits: [0.0, 100.0],
            search: [0.5, 15.0],
            ..GAIN
        },
        Parameter {
            key: "safe_s",
            doc: "Time by which a faster leader widens the safe gap",
            unit: "s",
            limits: [0.0, 60.0],
            search: [0.0, 6.0],
            ..GAIN
        },
        Parameter {
            key: "blend_m",
            doc: "Width of the blend between following and aiming",
            unit: "m",
            limits: [0.01, 100.0],
            search: [0.1, 10.0],
            ..GAIN
        },
    ];

    fn numbers(&self) -> Vec<f64> {
        let [from_m, to_m] = self.catch_up_m;
        vec![self.mean_s, from_m, to_m, self.catch_up_mps, self.safe_m, self.safe_s, self.blend_m]
    }

    fn of(x: &[f64]) -> Self {
        Self { mean_s: x[0], catch_up_m: [x[1], x[2]], catch_up_mps: x[3], safe_m: x[4], safe_s: x[5], blend_m: x[6] }
    }
}

/// The controller with its memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PiSaturation {
    parameters: PiParameters,
    speeds_mps: VecDeque<f64>,
    /// Sum of `speeds_mps`. Kept because adding up 380 speeds takes longer than a whole step of a ring.
    sum_mps: f64,
    capacity: usize,
    command_mps: Option<f64>,
}

impl PiSaturation {
    /// Returns a newly engaged controller with an empty memory and steps of `step_s` seconds.
    pub fn new(parameters: PiParameters, step_s: f64) -> Self {
        let capacity = (parameters.mean_s / step_s).round().max(1.0) as usize;
        let speeds_mps = VecDeque::with_capacity(capacity + 1);
        Self { parameters, speeds_mps, sum_mps: 0.0, capacity, command_mps: None }
    }

    /// Returns the commanded speed, m/s, 0 or more.
    pub fn command_mps(&self, observation: &Observation) -> f64 {
        self.command_mps.unwrap_or(observation.speed_mps).max(0.0)
    }
}

impl Policy for PiSaturation {
    fn watch(&mut self, observation: &Observation) {
        let Observation { speed_mps, leader_speed_mps, gap_m, .. } = *observation;
        self.speeds_mps.push_back(speed_mps);
        self.sum_mps += speed_mps;
        if self.speeds_mps.len() > self.capacity {
            self.sum_mps -= self.speeds_mps.pop_front().unwrap_or_default();
        }
        let p = &self.parameters;
        let mean_mps = self.sum_mps / self.speeds_mps.len() as f64;
        let share = ((gap_m - p.catch_up_m[0]) / (p.catch_up_m[1] - p.catch_up_m[0])).clamp(0.0, 1.0);
        let target_mps = mean_mps + p.catch_up_mps * share;
        let safe_m = (p.safe_s * (leader_speed_mps - speed_mps)).max(p.safe_m);
        let alpha = ((gap_m - safe_m) / p.blend_m).clamp(0.0, 1.0);
        let beta = 1.0 - alpha / 2.0;
        let before = self.command_mps.unwrap_or(speed_mps);
        let command = beta * (alpha * target_mps + (1.0 - alpha) * leader_speed_mps) + (1.0 - beta) * before;
        self.command_mps = Some(command);
    }

    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        Action::Speed(self.command_mps(observation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observation(speed_mps: f64, leader_speed_mps: f64, gap_m: f64) -> Observation {
        Observation { speed_mps, leader_speed_mps, gap_m, ..Observation::default() }
    }

    #[test]
    fn a_closed_gap_copies_the_leader() {
        let mut policy = PiSaturation::new(PiParameters::default(), 0.1);
        let near = observation(5.0, 2.0, 3.0);
        policy.watch(&near);
        assert_eq!(policy.act(0.0, &near), Action::Speed(2.0));
    }

    #[test]
    fn a_wide_gap_settles_one_above_the_mean() {
        let mut policy = PiSaturation::new(PiParameters::default(), 0.1);
        let wide = observation(4.0, 4.0, 40.0);
        for _ in 0..100 {
            policy.watch(&wide);
        }
        let Action::Speed(speed) = policy.act(10.0, &wide) else { panic!("a speed policy") };
        assert!((speed - 5.0).abs() < 1e-9, "{speed}");
    }

    #[test]
    fn the_mean_forgets_after_38_s() {
        let mut policy = PiSaturation::new(PiParameters::default(), 0.1);
        (0..500).for_each(|_| policy.watch(&observation(0.0, 0.0, 6.0)));
        (0..380).for_each(|_| policy.watch(&observation(4.0, 4.0, 7.0)));
        let Action::Speed(speed) = policy.act(88.0, &observation(4.0, 4.0, 7.0)) else { panic!("a speed policy") };
        assert!((speed - 4.0).abs() < 0.02, "{speed}");
    }
}
