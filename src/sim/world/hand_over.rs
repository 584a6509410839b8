//! When the ego passes from its model to its driver. In: the cars at the end of each step of the warm-up. Out: whether to go on
//! waiting, and how traffic was at the moment. Without a wave there is nothing to calm, and a wave that differs from drive to
//! drive is noise in what is compared (docs/decisions.md: 20).

use crate::{scenario::Scenario, traffic::CarState};
use serde::{Deserialize, Serialize};

/// For how long the wave must have been as strong as the scenario asks, seconds.
pub const WAVE_STANDS_S: f64 = 10.0;

/// A car that is slower than this stands, m/s, as it does for a simulated driver: the model never comes to 0 in finite time.
pub(super) const STANDS_MPS: f64 = 0.08;

/// How traffic was when the driver took over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HandOver {
    /// How long it was waited beyond the warm-up, seconds.
    pub waited_s: f64,
    /// Standard deviation of speeds over all cars (N), m/s.
    pub speed_sd_mps: f64,
    /// Speed of the ego, m/s.
    pub speed_mps: f64,
    /// All that the scenario asks for was there; false after the longest wait.
    pub is_as_asked: bool,
}

/// Watches traffic until it is as the scenario asks.
pub(super) struct HandOverGate {
    least_sd_mps: f64,
    asks_for_standstill: bool,
    longest_s: f64,
    step_s: f64,
    steps: u64,
    wave_steps: u64,
}

impl HandOverGate {
    /// A gate that has seen nothing yet.
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

    /// Looks at the cars, the ego first, at the end of the warm-up and after each step of waiting. `Some` once the driver takes over.
    pub fn look(&mut self, cars: &[CarState]) -> Option<HandOver> {
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

/// Of speeds over cars (N), m/s.
fn standard_deviation(cars: &[CarState]) -> f64 {
    let n = cars.len().max(1) as f64;
    let mean = cars.iter().map(|car| car.speed_mps).sum::<f64>() / n;
    (cars.iter().map(|car| (car.speed_mps - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three cars; of 1, 2 and 3 m/s the deviation is sqrt(2/3) = 0.8165.
    fn cars(speeds_mps: [f64; 3]) -> Vec<CarState> {
        speeds_mps.map(|speed_mps| CarState { speed_mps, ..CarState::default() }).to_vec()
    }

    fn gate(wave_sd_mps: f64, standing_start: bool) -> HandOverGate {
        let wave_wait_s = 60.0;
        HandOverGate::new(&Scenario { wave_sd_mps, standing_start, wave_wait_s, ..Scenario::default() })
    }

    #[test]
    fn who_asks_for_nothing_takes_over_at_once() {
        let told = gate(0.0, false).look(&cars([1.0, 2.0, 3.0])).unwrap();
        assert_eq!((told.waited_s, told.speed_mps, told.is_as_asked), (0.0, 1.0, true));
        assert!((told.speed_sd_mps - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_wave_must_stand_for_ten_seconds_on_end() {
        let mut gate = gate(0.8, false);
        let (strong, weak) = (cars([1.0, 2.0, 3.0]), cars([2.0, 2.0, 3.0]));
        assert!((0..99).all(|_| gate.look(&strong).is_none()));
        assert!(gate.look(&weak).is_none(), "0.47 m/s: it begins anew");
        assert!((0..99).all(|_| gate.look(&strong).is_none()));
        let told = gate.look(&strong).unwrap();
        assert!(told.is_as_asked && (told.waited_s - 19.9).abs() < 1e-9, "{told:?}");
    }

    #[test]
    fn a_standing_start_waits_until_the_own_car_stands_and_at_the_longest_wait_it_says_that_it_does_not() {
        let mut stands = gate(0.0, true);
        assert!(stands.look(&cars([0.2, 2.0, 3.0])).is_none());
        assert!(stands.look(&cars([0.05, 2.0, 3.0])).unwrap().is_as_asked);
        let mut never = gate(0.0, true);
        let looks = (0..1000).map(|_| never.look(&cars([1.0; 3]))).position(|told| told.is_some()).unwrap();
        assert_eq!(looks, 600, "60 s of 0.1 s");
        assert!(!gate(9.0, false).look(&cars([1.0; 3])).is_some_and(|told| told.is_as_asked));
    }
}
