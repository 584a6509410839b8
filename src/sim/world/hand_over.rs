//! The hand-over of the ego from its car-following model to its driver. In: the vehicles at the end of each step of the warm-up. Out:
//! whether to go on waiting, and the state of traffic at the hand-over. Without a wave there is nothing to damp, and a wave that differs
//! between drives adds noise to comparisons (docs/decisions.md: 20).

use crate::{scenario::Scenario, traffic::VehicleState};
use serde::{Deserialize, Serialize};

/// Time for which the wave must have had the strength that the scenario asks for, seconds.
pub const WAVE_STANDS_S: f64 = 10.0;

/// Speed below which a vehicle counts as stopped, m/s, as for a simulated driver: the model does not reach 0 in finite time.
pub(super) const STANDS_MPS: f64 = 0.08;

/// State of traffic at the hand-over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandOver {
    /// Waiting time after the warm-up, seconds.
    pub waited_s: f64,
    /// Standard deviation of speed over all vehicles, m/s (divisor N).
    pub speed_sd_mps: f64,
    /// Speed of the ego, m/s.
    pub speed_mps: f64,
    /// True if the scenario's conditions were met; false after the longest wait.
    pub is_as_asked: bool,
}

/// Waits for the traffic that the scenario asks for.
pub(super) struct HandOverGate {
    least_sd_mps: f64,
    asks_for_standstill: bool,
    longest_s: f64,
    step_s: f64,
    steps: u64,
    wave_steps: u64,
}

impl HandOverGate {
    /// Returns a gate before its first look.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            least_sd_mps: scenario.wave_sd_mps,
            asks_for_standstill: scenario.standing_start,
            longest_s: scenario.wave_wait_s,
            step_s: scenario.step_s,
            steps: 0,
            wave_steps: 0,
        }
    }

    /// Checks the vehicles, the ego first, at the end of the warm-up and after each step of waiting. Returns `Some` at the hand-over.
    pub fn look(&mut self, cars: &[VehicleState]) -> Option<HandOver> {
        let speed_sd_mps = standard_deviation(cars);
        self.wave_steps = if speed_sd_mps >= self.least_sd_mps { self.wave_steps + 1 } else { 0 };
        let has_wave = self.least_sd_mps <= 0.0 || self.wave_steps as f64 * self.step_s >= WAVE_STANDS_S - 1e-9;
        let speed_mps = cars.first().map_or(0.0, |ego| ego.speed_mps);
        let is_as_asked = has_wave && (!self.asks_for_standstill || speed_mps < STANDS_MPS);
        let waited_s = self.steps as f64 * self.step_s;
        self.steps += 1;
        let is_over = is_as_asked || waited_s >= self.longest_s;
        is_over.then_some(HandOver { waited_s, speed_sd_mps, speed_mps, is_as_asked })
    }
}

/// Returns the standard deviation of speed over the vehicles, m/s (divisor N).
fn standard_deviation(cars: &[VehicleState]) -> f64 {
    let n = cars.len().max(1) as f64;
    let mean = cars.iter().map(|car| car.speed_mps).sum::<f64>() / n;
    (cars.iter().map(|car| (car.speed_mps - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns three vehicles; for 1, 2 and 3 m/s the deviation is sqrt(2/3) = 0.8165 m/s.
    fn cars(speeds_mps: [f64; 3]) -> Vec<VehicleState> {
        speeds_mps.map(|speed_mps| VehicleState { speed_mps, ..VehicleState::default() }).to_vec()
    }

    fn gate(wave_sd_mps: f64, standing_start: bool) -> HandOverGate {
        let wave_wait_s = 60.0;
        HandOverGate::new(&Scenario { wave_sd_mps, standing_start, wave_wait_s, ..Scenario::default() })
    }

    #[test]
    fn a_scenario_without_conditions_hands_over_at_once() {
        let hand_over = gate(0.0, false).look(&cars([1.0, 2.0, 3.0])).unwrap();
        assert_eq!((hand_over.waited_s, hand_over.speed_mps, hand_over.is_as_asked), (0.0, 1.0, true));
        assert!((hand_over.speed_sd_mps - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_wave_must_last_for_ten_seconds_without_a_break() {
        let mut gate = gate(0.8, false);
        let (strong, weak) = (cars([1.0, 2.0, 3.0]), cars([2.0, 2.0, 3.0]));
        assert!((0..99).all(|_| gate.look(&strong).is_none()));
        assert!(gate.look(&weak).is_none(), "0.47 m/s: it begins anew");
        assert!((0..99).all(|_| gate.look(&strong).is_none()));
        let hand_over = gate.look(&strong).unwrap();
        assert!(hand_over.is_as_asked && (hand_over.waited_s - 19.9).abs() < 1e-9, "{hand_over:?}");
    }

    #[test]
    fn a_standing_start_waits_until_the_ego_stops_or_the_longest_wait_is_over() {
        let mut stands = gate(0.0, true);
        assert!(stands.look(&cars([0.2, 2.0, 3.0])).is_none());
        assert!(stands.look(&cars([0.05, 2.0, 3.0])).unwrap().is_as_asked);
        let mut never = gate(0.0, true);
        let looks = (0..1000).map(|_| never.look(&cars([1.0; 3]))).position(|hand_over| hand_over.is_some()).unwrap();
        assert_eq!(looks, 600, "60 s of 0.1 s");
        assert!(!gate(9.0, false).look(&cars([1.0; 3])).is_some_and(|hand_over| hand_over.is_as_asked));
    }
}
