//! Metrics of one evaluated drive. In: speeds of all vehicles at each step, gaps and the advice. Out: an [`EvaluationResult`]. The same
//! code serves the fast ring and whole drives, on closed routes and on networks. SI units.

use super::{Approach, ConflictTotals, Conflicts, DrivenBy, TrafficTotals};
use crate::policy::Advice;
use serde::{Deserialize, Serialize};

/// Result of one ring or drive, up to the horizon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EvaluationResult {
    /// Mean speed of all vehicles over the horizon, m/s: mean over steps of the mean over the vehicles present; from a crash on it
    /// counts as 0.
    pub mean_speed_mps: f64,
    /// Mean speed over the last quarter of the horizon, after settling, m/s.
    pub settled_speed_mps: f64,
    /// Standard deviation of speed over the vehicles, mean over time, m/s.
    pub speed_sd_over_vehicles_mps: f64,
    /// Standard deviation of a vehicle's speed in time, mean over vehicles, m/s.
    pub speed_sd_over_time_mps: f64,
    /// Time of the last wave, seconds from the first advice: from then on the standard deviation of speed over the vehicles
    /// stays below 0.5 m/s. `None` if it never does.
    pub last_disturbance_s: Option<f64>,
    /// Smallest gap of an advised vehicle to its leader, or of the ego's follower to it, metres; on a network of any two
    /// vehicles in a lane.
    pub min_gap_to_neighbours_m: f64,
    /// True after a collision of vehicles.
    pub crashed: bool,
    /// Time of the collision, seconds from the first advice (to the end of that step).
    pub crash_s: Option<f64>,
    /// Fuel of all vehicles per 100 km ([`fuel`](super::fuel)), litres; `None` if no vehicle moved.
    pub fuel_l_100km: Option<f64>,
    /// Flow on a closed route, 1/h: density times mean speed (Edie 1963).
    pub flow_per_h: Option<f64>,
    /// Share of the time with advice in which the speed was in its range, over all advised vehicles, 0 to 1.
    pub time_in_range: Option<f64>,
    /// Surrogate safety measures, and the sources of the ego's speed; `None` on networks.
    #[serde(default, flatten)]
    pub conflicts: Option<Conflicts>,
    /// Measures of drives on networks only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub network: Option<NetworkFlow>,
}

/// Measures of a drive in which vehicles enter and leave. Mean speed alone says little there: with few vehicles it is high, and steps
/// with few vehicles count as much as others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NetworkFlow {
    /// Space-mean speed of all vehicles, m/s: their distance over their time (Edie 1963); 0 without a vehicle.
    pub space_mean_speed_mps: f64,
    /// Vehicles that entered during the drive, 1/h.
    pub inflow_per_h: f64,
    /// Vehicles that left during the drive, 1/h.
    pub outflow_per_h: f64,
    /// Number of vehicles present, mean over the steps.
    pub vehicles_present: f64,
    /// Number of vehicles of the demand that found no room to enter until the end; `None` if the demand does not say how many
    /// it sends.
    pub vehicles_refused: Option<f64>,
    /// Number of advised vehicles among all that were present at any time.
    pub advised_vehicles: u32,
    /// Number of all vehicles that were present at any time.
    pub vehicles: u32,
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
    pub min_gap_m: Option<f64>,
    /// Number of vehicles with an advice.
    pub advised: u64,
    /// Number of vehicles with a speed in the range of their advice.
    pub in_range: u64,
}

/// Collects an [`EvaluationResult`] step by step, on a ring or a network.
#[derive(Clone, Debug)]
pub struct EpisodeMetrics {
    traffic: TrafficTotals,
    conflicts: ConflictTotals,
    /// Length of the ring, metres; `None` on a network.
    circumference_m: Option<f64>,
    /// Number of vehicles present before the first step.
    at_start: usize,
    /// Mean over the vehicles at each step with any, m/s; 0 from a crash on.
    means_mps: Vec<f64>,
    min_gap_m: f64,
    /// Step in which vehicles collided, from 1.
    crashed_at: Option<u64>,
    advised: u64,
    in_range: u64,
}

impl EpisodeMetrics {
    /// Starts on a ring of this length with steps of `step_s`.
    pub fn new(step_s: f64, circumference_m: f64) -> Self {
        Self {
            traffic: TrafficTotals::new(step_s),
            conflicts: ConflictTotals::default(),
            circumference_m: Some(circumference_m),
            at_start: 0,
            means_mps: Vec::new(),
            min_gap_m: f64::INFINITY,
            crashed_at: None,
            advised: 0,
            in_range: 0,
        }
    }

    /// Starts on a network before the first of the steps of `step_s`: numbers and speeds of the vehicles present. Gaps count up to
    /// `most_gap_m`.
    pub fn on_network(step_s: f64, vehicles: impl Iterator<Item = (u32, f64)>, most_gap_m: f64) -> Self {
        let mut metrics = Self { circumference_m: None, min_gap_m: most_gap_m, ..Self::new(step_s, 0.0) };
        metrics.traffic.start(vehicles);
        metrics.at_start = metrics.traffic.present();
        metrics
    }

    /// Adds a step: numbers and speeds of the vehicles present, on a ring in a fixed order with the ego first, and the other facts. After
    /// a crash only time counts.
    pub fn add(&mut self, vehicles: impl Iterator<Item = (u32, f64)>, now: EpisodeStep) {
        let pairs = [now.ahead, now.behind];
        let gap_m = pairs.iter().flatten().map(|pair| pair.gap_m).fold(f64::INFINITY, f64::min);
        if self.crashed_at.is_none() {
            self.min_gap_m = self.min_gap_m.min(gap_m).min(now.others.min_gap_m.unwrap_or(f64::INFINITY));
            if self.circumference_m.is_some() && self.min_gap_m <= 0.0 {
                self.crash();
            }
        }
        if self.crashed_at.is_some() {
            self.traffic.add_standing();
            self.means_mps.push(0.0);
            return;
        }
        let step = self.traffic.add(vehicles);
        self.conflicts.approach(pairs, now.driven_by.filter(|_| now.advice.is_some()));
        // The fast ring has means of single precision; drives on closed routes are compared with it.
        let rounded = |mean_mps: f64| if self.circumference_m.is_some() { (mean_mps as f32).into() } else { mean_mps };
        self.means_mps.extend(step.mean_mps.map(rounded));
        if let Some(advice) = now.advice {
            self.advised += 1;
            self.in_range += u64::from(advice.accepts(step.first_mps));
        }
        self.advised += now.others.advised;
        self.in_range += now.others.in_range;
    }

    /// Marks a collision in the step that is added next, whatever its gap: bumpers are not the only parts that can touch.
    pub fn crash(&mut self) {
        self.crashed_at.get_or_insert(self.traffic.steps() + 1);
    }

    /// Adds steps after a crash up to this number of steps.
    pub fn stand_until(&mut self, steps: u64) {
        while self.traffic.steps() < steps {
            self.add(std::iter::empty(), EpisodeStep::default());
        }
    }

    /// Returns the highest number of a vehicle so far; 0 without any.
    pub fn newest(&self) -> u32 {
        self.traffic.newest()
    }

    /// Returns the result of the steps so far. Of [`NetworkFlow`] it has the values that follow from the vehicles' speeds.
    pub fn result(&self) -> EvaluationResult {
        let traffic = &self.traffic;
        let crashed = self.crashed_at.is_some();
        let mean_speed_mps = mean(&self.means_mps);
        let flow_per_h = |length_m: f64| traffic.vehicles() as f64 / length_m * mean_speed_mps * 3600.0;
        let conflicts = self.conflicts.conflicts(traffic);
        EvaluationResult {
            mean_speed_mps,
            settled_speed_mps: mean(&self.means_mps[self.means_mps.len() * 3 / 4..]),
            speed_sd_over_vehicles_mps: traffic.speed_sd_over_vehicles_mps(),
            speed_sd_over_time_mps: traffic.speed_sd_over_time_mps(),
            last_disturbance_s: traffic.last_disturbance_s().filter(|_| !crashed),
            min_gap_to_neighbours_m: self.min_gap_m,
            crashed,
            crash_s: self.crashed_at.map(|step| step as f64 * traffic.step_s()),
            fuel_l_100km: traffic.fuel_l_100km(),
            flow_per_h: self.circumference_m.map(flow_per_h),
            conflicts: self.circumference_m.map(|_| conflicts),
            network: self.circumference_m.is_none().then(|| self.flow()),
            time_in_range: (self.advised > 0).then(|| self.in_range as f64 / self.advised as f64),
        }
    }

    /// Returns the numbers of vehicles on a network.
    fn flow(&self) -> NetworkFlow {
        let traffic = &self.traffic;
        let hours = traffic.steps() as f64 * traffic.step_s() / 3600.0;
        let per_h = |n: usize| n as f64 / hours.max(f64::MIN_POSITIVE);
        NetworkFlow {
            space_mean_speed_mps: traffic.space_mean_speed_mps().unwrap_or(0.0),
            inflow_per_h: per_h(traffic.vehicles() - self.at_start),
            outflow_per_h: per_h(traffic.vehicles() - traffic.present()),
            vehicles_present: traffic.mean_present(),
            vehicles: traffic.vehicles() as u32,
            ..NetworkFlow::default()
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Returns the mean speed over rings, and the half width of its 95 % interval (1.96 standard errors), m/s.
pub fn mean_and_interval(results: &[EvaluationResult]) -> (f64, f64) {
    let n = results.len() as f64;
    let mean = results.iter().map(|v| v.mean_speed_mps).sum::<f64>() / n;
    let square = results.iter().map(|v| (v.mean_speed_mps - mean).powi(2)).sum::<f64>();
    (mean, 1.96 * (square / (n - 1.0).max(1.0) / n).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(gap_m: f64) -> EpisodeStep {
        EpisodeStep { ahead: Some(Approach { gap_m, closing_mps: 0.0 }), ..EpisodeStep::default() }
    }

    fn two(speeds_mps: [f64; 2]) -> impl Iterator<Item = (u32, f64)> {
        (0..).zip(speeds_mps)
    }

    #[test]
    fn two_cars_at_2_and_4_mps_give_mean_deviation_and_flow() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        (0..50).for_each(|_| metrics.add(two([2.0, 4.0]), gap(7.0)));
        let v = metrics.result();
        assert!((v.mean_speed_mps - 3.0).abs() < 1e-9 && (v.speed_sd_over_vehicles_mps - 1.0).abs() < 1e-9);
        assert!(v.speed_sd_over_time_mps < 1e-6 && v.last_disturbance_s.is_none() && v.time_in_range.is_none());
        assert!((v.flow_per_h.unwrap() - 2.0 / 100.0 * 3.0 * 3600.0).abs() < 1e-9);
        assert_eq!(v.min_gap_to_neighbours_m, 7.0);
    }

    #[test]
    fn cars_that_touch_side_by_side_have_crashed_whatever_the_gap() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        (0..10).for_each(|_| metrics.add(two([4.0, 4.0]), gap(5.0)));
        assert_eq!(metrics.result().crash_s, None);
        metrics.crash();
        (0..10).for_each(|_| metrics.add(two([4.0, 4.0]), gap(5.0)));
        let v = metrics.result();
        assert!(v.crashed && v.min_gap_to_neighbours_m == 5.0, "{v:?}");
        assert!((v.crash_s.unwrap() - 1.1).abs() < 1e-9 && (v.mean_speed_mps - 2.0).abs() < 1e-9, "{v:?}");
    }

    #[test]
    fn gaps_and_ranges_are_of_all_advised_vehicles() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        let others = AdvisedStep { min_gap_m: Some(3.0), advised: 2, in_range: 1 };
        metrics.add(two([4.0, 4.0]), EpisodeStep { others, ..gap(5.0) });
        let others = AdvisedStep { min_gap_m: Some(6.0), advised: 2, in_range: 0 };
        metrics.add(two([4.0, 4.0]), EpisodeStep { others, ..gap(5.0) });
        let v = metrics.result();
        assert_eq!((v.min_gap_to_neighbours_m, v.time_in_range, v.crashed), (3.0, Some(0.25), false));
    }

    #[test]
    fn a_crash_stops_the_count_but_not_the_clock() {
        let mut metrics = EpisodeMetrics::new(0.1, 100.0);
        (0..50).for_each(|i| metrics.add(two([4.0, 4.0]), gap(if i < 25 { 5.0 } else { -0.1 })));
        let v = metrics.result();
        assert!(v.crashed && v.last_disturbance_s.is_none());
        assert!((v.mean_speed_mps - 2.0).abs() < 1e-9);
        assert!((v.crash_s.unwrap() - 2.6).abs() < 1e-9, "{v:?}");
    }

    fn advised(others: AdvisedStep) -> EpisodeStep {
        EpisodeStep { others, ..EpisodeStep::default() }
    }

    /// Vehicle 1 at 4 m/s is present from the start and leaves after the second step; 2 enters in the second at 8 m/s and
    /// stands in the third.
    fn three_steps() -> EpisodeMetrics {
        let mut totals = EpisodeMetrics::on_network(0.5, [(1, 4.0)].into_iter(), 700.0);
        totals.add([(1, 4.0)].into_iter(), advised(AdvisedStep { advised: 1, in_range: 1, min_gap_m: None }));
        let two = advised(AdvisedStep { min_gap_m: Some(6.0), advised: 2, in_range: 0 });
        totals.add([(1, 4.0), (2, 8.0)].into_iter(), two);
        totals.add([(2, 0.0)].into_iter(), EpisodeStep::default());
        totals
    }

    #[test]
    fn results_with_vehicles_that_enter_and_leave_match_a_hand_count() {
        let found = three_steps().result();
        // Means of the steps: 4, 6 and 0; deviations 0, 2 and 0.
        assert!((found.mean_speed_mps - 10.0 / 3.0).abs() < 1e-12 && found.settled_speed_mps == 0.0, "{found:?}");
        assert!((found.speed_sd_over_vehicles_mps - 2.0 / 3.0).abs() < 1e-12);
        // Vehicle 1: 0; vehicle 2 at 8 and 0: 4.
        assert_eq!((found.speed_sd_over_time_mps, found.last_disturbance_s), (2.0, Some(1.0)));
        assert_eq!((found.min_gap_to_neighbours_m, found.crashed, found.time_in_range), (6.0, false, Some(1.0 / 3.0)));
        // One vehicle entered and one left in 1.5 s.
        let own = found.network.expect("a network");
        assert_eq!((own.inflow_per_h, own.outflow_per_h, found.flow_per_h), (2400.0, 2400.0, None));
        assert_eq!((own.vehicles_present, own.vehicles), (4.0 / 3.0, 2));
        // 4, 4 and 8, and 0 m/s: 16 over four vehicles and steps (Edie 1963), not the mean of 4, 6 and 0.
        assert_eq!(own.space_mean_speed_mps, 4.0);
    }

    #[test]
    fn an_empty_road_has_no_mean_and_a_crash_stands_to_the_end() {
        let mut empty = EpisodeMetrics::on_network(0.5, std::iter::empty(), 700.0);
        empty.add(std::iter::empty(), EpisodeStep::default());
        empty.add([(1, 6.0)].into_iter(), EpisodeStep::default());
        let found = empty.result();
        assert_eq!(
            (found.mean_speed_mps, found.min_gap_to_neighbours_m),
            (6.0, 700.0),
            "of the one step with a vehicle"
        );
        let mut crashed = three_steps();
        crashed.crash();
        crashed.stand_until(10);
        let found = crashed.result();
        // 4 + 6 + 0 and seven steps of 0.
        assert!((found.mean_speed_mps - 1.0).abs() < 1e-12 && found.crashed && found.crash_s == Some(2.0), "{found:?}");
        assert_eq!((found.last_disturbance_s, found.network.map(|own| own.outflow_per_h)), (None, Some(720.0)));
    }
}
