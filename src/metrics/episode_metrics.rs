//! Metrics of one drive on a ring. In: speeds of all vehicles at each step, the ego first, its gaps and the advice. Out: an
//! [`EvaluationResult`]. The same code serves the fast ring and whole drives. SI units.

use super::{Approach, ConflictTotals, Conflicts, DrivenBy, NetworkFlow, fuel};
use crate::policy::Advice;
use serde::{Deserialize, Serialize};

/// Standard deviation of speed over the vehicles at which a wave begins, m/s; below it traffic is calm (docs/references.md:
/// advice).
pub(super) const CALM_SD_MPS: f64 = 0.5;

/// Result of one ring or drive, up to the horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EvaluationResult {
    /// Mean speed of all vehicles over the horizon, m/s; from a crash on it counts as 0.
    pub mean_mps: f64,
    /// Mean speed over the last quarter of the horizon, after settling, m/s.
    pub settled_mps: f64,
    /// Standard deviation of speed over the vehicles, mean over time, m/s.
    pub sd_over_cars_mps: f64,
    /// Standard deviation of a vehicle's speed in time, mean over vehicles, m/s.
    pub sd_in_time_mps: f64,
    /// Time of the last wave, seconds from the first advice: from then on the standard deviation of speed over the vehicles
    /// stays below 0.5 m/s. `None` if it never does.
    pub last_disturbance_s: Option<f64>,
    /// Smallest gap of an advised vehicle to its leader, or of the ego's follower to it, metres; on a network of any two
    /// vehicles in a lane.
    pub least_gap_m: f64,
    /// True after a collision of vehicles.
    pub crashed: bool,
    /// Time of the collision, seconds from the first advice (to the end of that step).
    pub crash_s: Option<f64>,
    /// Fuel of all vehicles per 100 km ([`fuel`]), litres; `None` if no vehicle moved.
    pub fuel_l_100km: Option<f64>,
    /// Throughput, 1/h: density times mean speed (Edie 1963); on a network the vehicles that left it.
    pub throughput_per_h: f64,
    /// Share of the time with advice in which the speed was in its range, over all advised vehicles, 0 to 1.
    pub in_range: Option<f64>,
    /// Surrogate safety measures, and the sources of the ego's speed; `None` on networks.
    #[serde(default, flatten)]
    pub conflicts: Option<Conflicts>,
    /// Measures of drives on networks only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub network: Option<NetworkFlow>,
}

/// Facts of one step, apart from the speeds.
#[derive(Clone, Copy, Debug, Default)]
pub struct EpisodeStep {
    /// Ego and its leader.
    pub ahead: Option<Approach>,
    /// Follower and the ego.
    pub behind: Option<Approach>,
    /// Advice in force at this step.
    pub advice: Option<Advice>,
    /// Source of the ego's speed, if known.
    pub driven_by: Option<DrivenBy>,
    /// Advised vehicles other than the ego.
    pub others: AdvisedStep,
}

/// Facts of one step about several advised vehicles together.
#[derive(Clone, Copy, Debug, Default)]
pub struct AdvisedStep {
    /// Smallest gap, metres: of one of them to its leader; on a network of any two vehicles in a lane.
    pub least_gap_m: Option<f64>,
    /// Number of vehicles with an advice.
    pub advised: u64,
    /// Number of vehicles with a speed in the range of their advice.
    pub in_range: u64,
}

/// Sums over the speeds of all vehicles, step by step; memory does not grow with the drive.
#[derive(Clone, Debug)]
pub struct FlowTotals {
    step_s: f64,
    steps: u64,
    sums: Vec<[f64; 2]>,
    before_mps: Vec<f32>,
    /// Sum over the steps of the mean over the vehicles, m/s.
    sum_means_mps: f64,
    sum_sd_mps: f64,
    fuel_ml: f64,
    /// Number of steps up to the last with a wave.
    last_disturbance: u64,
}

/// Values of a step, returned by [`FlowTotals::add`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowStep {
    /// Mean over the vehicles, m/s.
    pub mean_mps: f32,
    /// Speed of the ego, m/s.
    pub ego_mps: f64,
}

impl FlowTotals {
    /// Starts with steps of `step_s`.
    pub fn new(step_s: f64) -> Self {
        Self {
            step_s,
            steps: 0,
            sums: Vec::new(),
            before_mps: Vec::new(),
            sum_means_mps: 0.0,
            sum_sd_mps: 0.0,
            fuel_ml: 0.0,
            last_disturbance: 0,
        }
    }

    /// Adds a step: speeds of all vehicles in a fixed order, the ego first.
    pub fn add(&mut self, speeds_mps: impl Iterator<Item = f32>) -> FlowStep {
        self.steps += 1;
        let (mut n, mut sum, mut square, mut fuel_ml_s, mut ego_mps) = (0, 0.0, 0.0, 0.0, 0.0);
        for (k, speed_mps) in speeds_mps.enumerate() {
            if k == self.sums.len() {
                self.sums.push([0.0; 2]);
                self.before_mps.push(speed_mps);
            }
            let accel_mps2 = (speed_mps - self.before_mps[k]) / self.step_s as f32;
            self.before_mps[k] = speed_mps;
            fuel_ml_s += f64::from(fuel::rate_ml_s(speed_mps, accel_mps2));
            let v = f64::from(speed_mps);
            if k == 0 {
                ego_mps = v;
            }
            self.sums[k][0] += v;
            self.sums[k][1] += v * v;
            (n, sum, square) = (n + 1, sum + v, square + v * v);
        }
        let mean = sum / f64::from(n);
        let sd = (square / f64::from(n) - mean * mean).max(0.0).sqrt();
        let mean_mps = mean as f32;
        self.sum_means_mps += f64::from(mean_mps);
        self.sum_sd_mps += sd;
        self.fuel_ml += fuel_ml_s * self.step_s;
        if sd >= CALM_SD_MPS {
            self.last_disturbance = self.steps;
        }
        FlowStep { mean_mps, ego_mps }
    }

    /// Adds a step in which no vehicle moves, as after a crash: only time passes.
    fn add_standing(&mut self) {
        self.steps += 1;
    }

    /// Returns the number of steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the mean speed over vehicles and steps, m/s.
    pub fn mean_mps(&self) -> f64 {
        self.sum_means_mps / self.some_steps()
    }

    /// Returns the standard deviation of speed over the vehicles, mean over time, m/s.
    pub fn sd_over_cars_mps(&self) -> f64 {
        self.sum_sd_mps / self.some_steps()
    }

    /// Returns the seconds from the first step to the last with a wave; `None` if the drive ends in one.
    pub fn last_disturbance_s(&self) -> Option<f64> {
        (self.last_disturbance < self.steps).then_some(self.last_disturbance as f64 * self.step_s)
    }

    /// Returns the fuel of all vehicles per 100 km ([`fuel`]), litres; `None` if no vehicle moved.
    pub fn fuel_l_100km(&self) -> Option<f64> {
        let way_m = self.mean_mps() * self.some_steps() * self.step_s * self.sums.len() as f64;
        // 1 ml/m is 100 l per 100 km.
        (way_m > 0.0).then(|| self.fuel_ml / way_m * 100.0)
    }

    /// Returns the standard deviation of a vehicle's speed in time, mean over vehicles, m/s.
    pub fn sd_in_time_mps(&self) -> f64 {
        let steps = self.some_steps();
        let sd = |[sum, square]: &[f64; 2]| (square / steps - (sum / steps).powi(2)).max(0.0).sqrt();
        self.sums.iter().map(sd).sum::<f64>() / (self.sums.len() as f64).max(1.0)
    }

    fn some_steps(&self) -> f64 {
        self.steps.max(1) as f64
    }
}

/// Collects an [`EvaluationResult`] step by step.
#[derive(Clone, Debug)]
pub struct EpisodeMetrics {
    flow: FlowTotals,
    conflicts: ConflictTotals,
    circumference_m: f64,
    /// Mean over the vehicles at each step, m/s.
    means_mps: Vec<f32>,
    least_gap_m: f64,
    /// Step in which vehicles collided, from 1.
    crashed_at: Option<u64>,
    advised: u64,
    in_range: u64,
}

impl EpisodeMetrics {
    /// Starts on a ring of this length with steps of `step_s`.
    pub fn new(step_s: f64, circumference_m: f64) -> Self {
        Self {
            flow: FlowTotals::new(step_s),
            conflicts: ConflictTotals::new(step_s),
            circumference_m,
            means_mps: Vec::new(),
            least_gap_m: f64::INFINITY,
            crashed_at: None,
            advised: 0,
            in_range: 0,
        }
    }

    /// Adds a step: speeds of all vehicles in a fixed order, the ego first, and the other facts. After a crash only time
    /// counts.
    pub fn add(&mut self, speeds_mps: impl Iterator<Item = f32>, now: EpisodeStep) {
        let pairs = [now.ahead, now.behind];
        let gap_m = pairs.iter().flatten().map(|pair| pair.gap_m).fold(f64::INFINITY, f64::min);
        if self.crashed_at.is_none() {
            self.least_gap_m = self.least_gap_m.min(gap_m).min(now.others.least_gap_m.unwrap_or(f64::INFINITY));
            if self.least_gap_m <= 0.0 {
                self.crash();
            }
        }
        if self.crashed_at.is_some() {
            self.flow.add_standing();
            self.means_mps.push(0.0);
            return;
        }
        let mut k = 0;
        let conflicts = &mut self.conflicts;
        let step = self.flow.add(speeds_mps.inspect(|speed_mps| {
            conflicts.car(k, *speed_mps);
            k += 1;
        }));
        self.conflicts.approach(pairs, now.driven_by.filter(|_| now.advice.is_some()));
        self.means_mps.push(step.mean_mps);
        if let Some(advice) = now.advice {
            self.advised += 1;
            self.in_range += u64::from(advice.accepts(step.ego_mps));
        }
        self.advised += now.others.advised;
        self.in_range += now.others.in_range;
    }

    /// Marks a collision in the step that is added next, whatever its gap: bumpers are not the only parts that can touch.
    pub fn crash(&mut self) {
        self.crashed_at.get_or_insert(self.flow.steps() + 1);
    }

    /// Returns the result of the steps so far.
    pub fn result(&self) -> EvaluationResult {
        let flow = &self.flow;
        let crashed = self.crashed_at.is_some();
        let settled = &self.means_mps[self.means_mps.len() * 3 / 4..];
        let mean_mps = flow.mean_mps();
        EvaluationResult {
            mean_mps,
            settled_mps: settled.iter().copied().map(f64::from).sum::<f64>() / settled.len().max(1) as f64,
            sd_over_cars_mps: flow.sd_over_cars_mps(),
            sd_in_time_mps: flow.sd_in_time_mps(),
            last_disturbance_s: flow.last_disturbance_s().filter(|_| !crashed),
            least_gap_m: self.least_gap_m,
            crashed,
            crash_s: self.crashed_at.map(|step| step as f64 * flow.step_s),
            fuel_l_100km: flow.fuel_l_100km(),
            throughput_per_h: flow.sums.len() as f64 / self.circumference_m * mean_mps * 3600.0,
            conflicts: Some(self.conflicts.conflicts()),
            network: None,
            in_range: (self.advised > 0).then(|| self.in_range as f64 / self.advised as f64),
        }
    }
}

/// Returns the mean speed over rings, and the half width of its 95 % interval (1.96 standard errors), m/s.
pub fn mean_and_interval(results: &[EvaluationResult]) -> (f64, f64) {
    let n = results.len() as f64;
    let mean = results.iter().map(|v| v.mean_mps).sum::<f64>() / n;
    let square = results.iter().map(|v| (v.mean_mps - mean).powi(2)).sum::<f64>();
    (mean, 1.96 * (square / (n - 1.0).max(1.0) / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(gap_m: f64) -> EpisodeStep {
        EpisodeStep { ahead: Some(Approach { gap_m, closing_mps: 0.0 }), ..EpisodeStep::default() }
    }

    #[test]
    fn two_cars_at_2_and_4_mps_give_mean_deviation_and_throughput() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        (0..50).for_each(|_| metrics.add([2.0, 4.0].into_iter(), gap(7.0)));
        let v = metrics.result();
        assert!((v.mean_mps - 3.0).abs() < 1e-9 && (v.sd_over_cars_mps - 1.0).abs() < 1e-9);
        assert!(v.sd_in_time_mps < 1e-6 && v.last_disturbance_s.is_none() && v.in_range.is_none());
        assert!((v.throughput_per_h - 2.0 / 100.0 * 3.0 * 3600.0).abs() < 1e-9);
        assert_eq!(v.least_gap_m, 7.0);
    }

    #[test]
    fn cars_that_touch_side_by_side_have_crashed_whatever_the_gap() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        (0..10).for_each(|_| metrics.add([4.0, 4.0].into_iter(), gap(5.0)));
        assert_eq!(metrics.result().crash_s, None);
        metrics.crash();
        (0..10).for_each(|_| metrics.add([4.0, 4.0].into_iter(), gap(5.0)));
        let v = metrics.result();
        assert!(v.crashed && v.least_gap_m == 5.0, "{v:?}");
        assert!((v.crash_s.unwrap() - 1.1).abs() < 1e-9 && (v.mean_mps - 2.0).abs() < 1e-9, "{v:?}");
    }

    #[test]
    fn gaps_and_ranges_are_of_all_advised_vehicles() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        let others = AdvisedStep { least_gap_m: Some(3.0), advised: 2, in_range: 1 };
        metrics.add([4.0, 4.0].into_iter(), EpisodeStep { others, ..gap(5.0) });
        let others = AdvisedStep { least_gap_m: Some(6.0), advised: 2, in_range: 0 };
        metrics.add([4.0, 4.0].into_iter(), EpisodeStep { others, ..gap(5.0) });
        let v = metrics.result();
        assert_eq!((v.least_gap_m, v.in_range, v.crashed), (3.0, Some(0.25), false));
    }

    #[test]
    fn a_crash_stops_the_count_but_not_the_clock() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        (0..50).for_each(|i| metrics.add([4.0, 4.0].into_iter(), gap(if i < 25 { 5.0 } else { -0.1 })));
        let v = metrics.result();
        assert!(v.crashed && v.last_disturbance_s.is_none());
        assert!((v.mean_mps - 2.0).abs() < 1e-9);
        assert!((v.crash_s.unwrap() - 2.6).abs() < 1e-9, "{v:?}");
    }
}
