//! Metrics of one drive on a network. In: the vehicles present at each step, by number, since they enter and leave. Out: an
//! [`EvaluationResult`] with a [`NetworkFlow`]. SI units.

use super::{AdvisedStep, EvaluationResult, episode_metrics::CALM_SD_MPS, fuel};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Measures of a drive in which vehicles enter and leave. Mean speed alone says little there: with few vehicles it is high.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NetworkFlow {
    /// Vehicles that entered during the drive, 1/h.
    pub inflow_per_h: f64,
    /// Vehicles that left during the drive, 1/h.
    pub outflow_per_h: f64,
    /// Number of vehicles present, mean over the steps.
    pub vehicles: f64,
    /// Number of vehicles of the demand that found no room to enter until the end; `None` if the demand does not say how many
    /// it sends.
    pub refused: Option<f64>,
    /// Number of advised vehicles among all that were present at any time.
    pub advised: u32,
    /// Number of all vehicles that were present at any time.
    pub of: u32,
}

/// Sums over a vehicle's speeds.
#[derive(Clone, Copy, Debug)]
struct VehicleTotals {
    steps: u64,
    sum_mps: f64,
    square: f64,
    before_mps: f64,
}

/// Collects an [`EvaluationResult`] of a drive on a network step by step.
#[derive(Clone, Debug)]
pub struct NetworkEpisodeMetrics {
    step_s: f64,
    /// Number of vehicles present before the first step.
    at_start: usize,
    vehicles: BTreeMap<u32, VehicleTotals>,
    /// Mean over the vehicles at each step with any, m/s; 0 from a crash on.
    means_mps: Vec<f64>,
    sum_sd_mps: f64,
    sum_vehicles: u64,
    steps: u64,
    /// Number of vehicles present now.
    there: usize,
    last_disturbance: u64,
    fuel_ml: f64,
    way_m: f64,
    least_gap_m: f64,
    crash_s: Option<f64>,
    advised: u64,
    in_range: u64,
}

impl NetworkEpisodeMetrics {
    /// Starts before the first of the steps of `step_s`: numbers and speeds of the vehicles present. Gaps count up to
    /// `most_gap_m`.
    pub fn new(step_s: f64, vehicles: impl Iterator<Item = (u32, f64)>, most_gap_m: f64) -> Self {
        let start = |speed_mps| VehicleTotals { steps: 0, sum_mps: 0.0, square: 0.0, before_mps: speed_mps };
        let vehicles: BTreeMap<u32, VehicleTotals> = vehicles.map(|(id, speed_mps)| (id, start(speed_mps))).collect();
        Self {
            step_s,
            at_start: vehicles.len(),
            there: vehicles.len(),
            vehicles,
            means_mps: Vec::new(),
            sum_sd_mps: 0.0,
            sum_vehicles: 0,
            steps: 0,
            last_disturbance: 0,
            fuel_ml: 0.0,
            way_m: 0.0,
            least_gap_m: most_gap_m,
            crash_s: None,
            advised: 0,
            in_range: 0,
        }
    }

    /// Adds a step: numbers and speeds of the vehicles present at its end.
    pub fn add(&mut self, vehicles: impl Iterator<Item = (u32, f64)>, now: AdvisedStep) {
        self.steps += 1;
        let (mut n, mut sum, mut square) = (0_u32, 0.0, 0.0);
        for (id, speed_mps) in vehicles {
            let first = VehicleTotals { steps: 0, sum_mps: 0.0, square: 0.0, before_mps: speed_mps };
            let of = self.vehicles.entry(id).or_insert(first);
            let accel_mps2 = (speed_mps - of.before_mps) / self.step_s;
            (of.steps, of.before_mps) = (of.steps + 1, speed_mps);
            (of.sum_mps, of.square) = (of.sum_mps + speed_mps, of.square + speed_mps * speed_mps);
            self.fuel_ml += f64::from(fuel::rate_ml_s(speed_mps as f32, accel_mps2 as f32)) * self.step_s;
            self.way_m += speed_mps * self.step_s;
            (n, sum, square) = (n + 1, sum + speed_mps, square + speed_mps * speed_mps);
        }
        self.there = n as usize;
        self.sum_vehicles += u64::from(n);
        if n > 0 {
            let mean_mps = sum / f64::from(n);
            let sd_mps = (square / f64::from(n) - mean_mps * mean_mps).max(0.0).sqrt();
            self.means_mps.push(mean_mps);
            self.sum_sd_mps += sd_mps;
            self.last_disturbance = if sd_mps >= CALM_SD_MPS { self.steps } else { self.last_disturbance };
        }
        self.least_gap_m = now.least_gap_m.map_or(self.least_gap_m, |gap_m| self.least_gap_m.min(gap_m));
        (self.advised, self.in_range) = (self.advised + now.advised, self.in_range + now.in_range);
    }

    /// Marks a collision in the next step: from then on no vehicle moves, for all steps up to `last`.
    pub fn crash(&mut self, last: u64) {
        self.crash_s = Some((self.steps + 1) as f64 * self.step_s);
        let standing = last.saturating_sub(self.steps);
        self.means_mps.extend(std::iter::repeat_n(0.0, standing as usize));
        self.steps += standing;
        self.last_disturbance = self.steps;
    }

    /// Returns the highest number of a vehicle so far; 0 without any.
    pub fn newest(&self) -> u32 {
        self.vehicles.last_key_value().map_or(0, |(id, _)| *id)
    }

    /// Returns the result; `flow` has the values that do not follow from the vehicles' speeds.
    pub fn result(&self, flow: NetworkFlow) -> EvaluationResult {
        let hours = self.steps as f64 * self.step_s / 3600.0;
        let per_h = |n: usize| n as f64 / hours.max(f64::MIN_POSITIVE);
        let outflow_per_h = per_h(self.vehicles.len() - self.there);
        EvaluationResult {
            mean_mps: mean(&self.means_mps),
            settled_mps: mean(&self.means_mps[self.means_mps.len() * 3 / 4..]),
            sd_over_cars_mps: self.sum_sd_mps / self.means_mps.len().max(1) as f64,
            sd_in_time_mps: self.sd_in_time_mps(),
            last_disturbance_s: (self.last_disturbance < self.steps)
                .then_some(self.last_disturbance as f64 * self.step_s),
            least_gap_m: self.least_gap_m,
            crashed: self.crash_s.is_some(),
            crash_s: self.crash_s,
            fuel_l_100km: (self.way_m > 0.0).then(|| self.fuel_ml / self.way_m * 100.0),
            throughput_per_h: outflow_per_h,
            in_range: (self.advised > 0).then(|| self.in_range as f64 / self.advised as f64),
            conflicts: None,
            network: Some(NetworkFlow {
                inflow_per_h: per_h(self.vehicles.len() - self.at_start),
                outflow_per_h,
                vehicles: self.sum_vehicles as f64 / self.steps.max(1) as f64,
                of: self.vehicles.len() as u32,
                ..flow
            }),
        }
    }

    /// Returns the standard deviation of a vehicle's speed in time, m/s: mean over the vehicles present at any step.
    fn sd_in_time_mps(&self) -> f64 {
        let sds = self.vehicles.values().filter(|of| of.steps > 0).map(|of| {
            let (n, sum) = (of.steps as f64, of.sum_mps);
            (of.square / n - (sum / n).powi(2)).max(0.0).sqrt()
        });
        mean(&sds.collect::<Vec<_>>())
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vehicle 1 at 4 m/s is present from the start and leaves after the second step; 2 enters in the second at 8 m/s and
    /// stands in the third.
    fn three_steps() -> NetworkEpisodeMetrics {
        let mut totals = NetworkEpisodeMetrics::new(0.5, [(1, 4.0)].into_iter(), 700.0);
        totals.add([(1, 4.0)].into_iter(), AdvisedStep { advised: 1, in_range: 1, ..AdvisedStep::default() });
        let two = AdvisedStep { least_gap_m: Some(6.0), advised: 2, in_range: 0 };
        totals.add([(1, 4.0), (2, 8.0)].into_iter(), two);
        totals.add([(2, 0.0)].into_iter(), AdvisedStep::default());
        totals
    }

    #[test]
    fn results_with_vehicles_that_enter_and_leave_match_a_hand_count() {
        let flow = NetworkFlow { refused: Some(3.0), advised: 1, ..NetworkFlow::default() };
        let found = three_steps().result(flow);
        // Means of the steps: 4, 6 and 0; deviations 0, 2 and 0.
        assert!((found.mean_mps - 10.0 / 3.0).abs() < 1e-12 && found.settled_mps == 0.0, "{found:?}");
        assert!((found.sd_over_cars_mps - 2.0 / 3.0).abs() < 1e-12);
        // Vehicle 1: 0; vehicle 2 at 8 and 0: 4.
        assert_eq!((found.sd_in_time_mps, found.last_disturbance_s), (2.0, Some(1.0)));
        assert_eq!((found.least_gap_m, found.crashed, found.in_range), (6.0, false, Some(1.0 / 3.0)));
        // One vehicle entered and one left in 1.5 s.
        let own = found.network.expect("a network");
        assert_eq!((own.inflow_per_h, own.outflow_per_h, found.throughput_per_h), (2400.0, 2400.0, 2400.0));
        assert_eq!((own.vehicles, own.of, own.advised, own.refused), (4.0 / 3.0, 2, 1, Some(3.0)));
    }

    #[test]
    fn an_empty_road_has_no_mean_and_a_crash_stands_to_the_end() {
        let mut empty = NetworkEpisodeMetrics::new(0.5, std::iter::empty(), 700.0);
        empty.add(std::iter::empty(), AdvisedStep::default());
        empty.add([(1, 6.0)].into_iter(), AdvisedStep::default());
        let found = empty.result(NetworkFlow::default());
        assert_eq!((found.mean_mps, found.least_gap_m), (6.0, 700.0), "of the one step with a vehicle");
        let mut crashed = three_steps();
        crashed.crash(10);
        let found = crashed.result(NetworkFlow::default());
        // 4 + 6 + 0 and seven steps of 0.
        assert!((found.mean_mps - 1.0).abs() < 1e-12 && found.crashed && found.crash_s == Some(2.0), "{found:?}");
        assert_eq!((found.last_disturbance_s, found.network.map(|own| own.outflow_per_h)), (None, Some(720.0)));
    }
}
