//! PI with saturation (Stern et al. 2018, eqs. 3-6; docs/references.md: pi): estimate the flow's speed by one's own mean
//! over 38 s, aim a little above it where the gap is wide, follow the leader where it is not. In: an observation a step.
//! Out: a speed.

use super::{Action, Observation, Policy};
use std::collections::VecDeque;

/// Window of the mean speed, seconds.
const MEAN_S: f64 = 38.0;
/// Gap from which on the target exceeds the mean, and where it exceeds it fully, metres.
const CATCH_UP_M: [f64; 2] = [7.0, 30.0];
/// By how much it exceeds it at most, m/s.
const CATCH_UP_MPS: f64 = 1.0;
/// Least safe gap, metres, and the time by which relative speed widens it, seconds.
const SAFE_M: f64 = 4.0;
const SAFE_S: f64 = 2.0;
/// Width of the blend between following and aiming, metres.
const BLEND_M: f64 = 2.0;

/// The controller and its memory.
#[derive(Clone, Debug, PartialEq)]
pub struct PiSaturation {
    speeds_mps: VecDeque<f64>,
    capacity: usize,
    command_mps: Option<f64>,
}

impl PiSaturation {
    /// Engaged now, with nothing remembered.
    pub fn new(step_s: f64) -> Self {
        let capacity = (MEAN_S / step_s).round().max(1.0) as usize;
        Self { speeds_mps: VecDeque::with_capacity(capacity + 1), capacity, command_mps: None }
    }
}

impl Policy for PiSaturation {
    fn watch(&mut self, observation: &Observation) {
        let Observation { speed_mps, leader_speed_mps, gap_m, .. } = *observation;
        self.speeds_mps.push_back(speed_mps);
        if self.speeds_mps.len() > self.capacity {
            self.speeds_mps.pop_front();
        }
        let mean_mps = self.speeds_mps.iter().sum::<f64>() / self.speeds_mps.len() as f64;
        let share = ((gap_m - CATCH_UP_M[0]) / (CATCH_UP_M[1] - CATCH_UP_M[0])).clamp(0.0, 1.0);
        let target_mps = mean_mps + CATCH_UP_MPS * share;
        let safe_m = (SAFE_S * (leader_speed_mps - speed_mps)).max(SAFE_M);
        let alpha = ((gap_m - safe_m) / BLEND_M).clamp(0.0, 1.0);
        let beta = 1.0 - alpha / 2.0;
        let before = self.command_mps.unwrap_or(speed_mps);
        let command = beta * (alpha * target_mps + (1.0 - alpha) * leader_speed_mps) + (1.0 - beta) * before;
        self.command_mps = Some(command);
    }

    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        Action::Speed(self.command_mps.unwrap_or(observation.speed_mps).max(0.0))
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
        let mut policy = PiSaturation::new(0.1);
        let near = observation(5.0, 2.0, 3.0);
        policy.watch(&near);
        assert_eq!(policy.act(0.0, &near), Action::Speed(2.0));
    }

    #[test]
    fn a_wide_gap_settles_one_above_the_mean() {
        let mut policy = PiSaturation::new(0.1);
        let wide = observation(4.0, 4.0, 40.0);
        for _ in 0..100 {
            policy.watch(&wide);
        }
        let Action::Speed(speed) = policy.act(10.0, &wide) else { panic!("a speed policy") };
        assert!((speed - 5.0).abs() < 1e-9, "{speed}");
    }

    #[test]
    fn the_mean_forgets_after_38_s() {
        let mut policy = PiSaturation::new(0.1);
        (0..500).for_each(|_| policy.watch(&observation(0.0, 0.0, 6.0)));
        (0..380).for_each(|_| policy.watch(&observation(4.0, 4.0, 7.0)));
        let Action::Speed(speed) = policy.act(88.0, &observation(4.0, 4.0, 7.0)) else { panic!("a speed policy") };
        assert!((speed - 4.0).abs() < 0.02, "{speed}");
    }
}
