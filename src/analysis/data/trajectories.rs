//! Data for the figures of one drive. In: a [`RecordedTrial`]. Out: [`DriveTrajectories`], which take no more memory for a
//! drive of days than for one of hours. Seconds since the start of the drive, metres, m/s.
//!
//! A picture is some hundred units wide. Above [`MOST_VALUES`], speeds are kept at evenly spaced steps only. A round of a
//! minute on a ring is a visible line only while a minute is some units wide: positions are shown for the first hour.

use super::{ego_samples::EgoSample, thinned_values::ThinnedValues, traffic_steps::TrafficStep, trial::RecordedTrial};
use crate::analysis::{error::AnalysisError, statistics::median};
use crate::{metrics::Trajectories, time::Tick};

/// Largest number of speeds of all vehicles that are kept: 22 vehicles over 2.5 h at steps of 0.1 s, 8 MB.
pub const MOST_VALUES: usize = 2_000_000;
/// Longest time for which positions are shown, seconds.
const WAYS_S: f64 = 3600.0;
/// Smallest number of steps for a figure.
const LEAST_STEPS: usize = 20;

/// Data for the figures of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveTrajectories {
    /// Positions of all vehicles from the start on.
    pub ways: Trajectories,
    /// End of the positions, seconds; `None` if they cover the whole drive.
    pub ways_end_s: Option<f64>,
    /// Speeds over the whole drive, without positions.
    pub speeds: Trajectories,
    /// Median of the speeds of all vehicles at every tenth step, as long as positions are shown.
    pub median_speed_mps: Option<f64>,
    /// Distance of the first target from the upper edge of its range, m/s.
    pub range_mps: f64,
}

/// A step with the speeds that are kept.
struct TraceStep {
    time_s: f64,
    speed_mps: Vec<f32>,
    shown_mps: Option<f64>,
}

impl DriveTrajectories {
    /// Reads a drive; `None` if its map is missing, or if it has fewer than 20 steps.
    ///
    /// # Errors
    /// A table cannot be read, or does not have this program's format.
    pub fn of(trial: &RecordedTrial) -> Result<Option<Self>, AnalysisError> {
        if trial.setup.route_m <= 0.0 {
            return Ok(None);
        }
        let mut collector = TrajectoryCollector::new(trial.setup.route_m);
        let (mut ego, mut last) = (trial.ego()?, None::<EgoSample>);
        for step in trial.steps()? {
            let step = step?;
            // The ego's row of the same tick, if there is one.
            while last.is_none_or(|row| row.tick < step.tick) {
                let Some(row) = ego.next().transpose()? else { break };
                last = Some(row);
            }
            let shown_mps = last.filter(|row| row.tick == step.tick).and_then(|row| row.target_mps);
            collector.add(step, shown_mps);
        }
        Ok(collector.finish(trial.first_advice.map_or(0.0, |advice| advice.range_mps[1] - advice.target_mps)))
    }
}

/// Collects the data from the steps of a drive.
struct TrajectoryCollector {
    seen: usize,
    ways: Trajectories,
    ways_end_s: Option<f64>,
    /// Numbers of the vehicles at the first step.
    cars: Vec<u32>,
    /// Distance of each vehicle, metres from the start of the route in its first round; and the step before.
    way_m: Vec<f64>,
    before: TrafficStep,
    /// Advised speed at that step, m/s.
    before_shown_mps: Option<f64>,
    tenths_mps: Vec<f64>,
    speeds: ThinnedValues<TraceStep>,
}

impl TrajectoryCollector {
    fn new(route_m: f64) -> Self {
        Self {
            seen: 0,
            ways: Trajectories { circumference_m: route_m, ..Trajectories::default() },
            ways_end_s: None,
            cars: Vec::new(),
            way_m: Vec::new(),
            before: TrafficStep::default(),
            before_shown_mps: None,
            tenths_mps: Vec::new(),
            speeds: ThinnedValues::new(1),
        }
    }

    fn add(&mut self, step: TrafficStep, shown_mps: Option<f64>) {
        if self.seen == 0 {
            self.cars = step.ids().collect();
            self.way_m = step.vehicles.iter().map(|car| car.s_m.unwrap_or_default()).collect();
            self.before = step.clone();
            self.speeds = ThinnedValues::new(MOST_VALUES / self.cars.len().max(1));
        }
        let time_s = Tick(step.tick).seconds();
        let has_room = self.ways.time_s.len() < MOST_VALUES / self.way_m.len().max(1);
        if self.ways_end_s.is_none() && (time_s > WAYS_S || !has_room) {
            self.ways_end_s = self.ways.time_s.last().copied();
        }
        let is_way = self.ways_end_s.is_none();
        if is_way && self.seen.is_multiple_of(10) {
            self.tenths_mps.extend(step.speeds_mps());
        }
        self.seen += 1;
        // A closed route has the same vehicles from first to last step; the last step of a drive that was cut may lack some.
        if !step.ids().eq(self.cars.iter().copied()) {
            return;
        }
        let speeds = || step.speeds_mps().map(|speed| speed as f32).collect::<Vec<f32>>();
        if is_way {
            let length_m = self.ways.circumference_m;
            for (way, (now, was)) in self.way_m.iter_mut().zip(step.vehicles.iter().zip(&self.before.vehicles)) {
                let (Some(now_m), Some(was_m)) = (now.s_m, was.s_m) else { continue };
                // The shorter way round, in either direction.
                let moved = (now_m - was_m).rem_euclid(length_m);
                *way += if moved > length_m / 2.0 { moved - length_m } else { moved };
            }
            self.ways.time_s.push(time_s);
            self.ways.way_m.push(self.way_m.iter().map(|way| *way as f32).collect());
            self.ways.speed_mps.push(speeds());
            self.ways.shown_mps.push(shown_mps);
        }
        let speed_mps = if self.speeds.takes_next() { speeds() } else { Vec::new() };
        self.speeds.push(TraceStep { time_s, speed_mps, shown_mps });
        self.before = step;
        self.before_shown_mps = shown_mps;
    }

    fn finish(mut self, range_mps: f64) -> Option<DriveTrajectories> {
        if self.seen < LEAST_STEPS {
            return None;
        }
        // The last step is always kept, so that the drive is shown to its end.
        let (end_s, kept) = (Tick(self.before.tick).seconds(), &mut self.speeds.values);
        if kept.last().is_some_and(|moment| moment.time_s < end_s) {
            let speed_mps = self.before.speeds_mps().map(|speed| speed as f32).collect();
            kept.push(TraceStep { time_s: end_s, speed_mps, shown_mps: self.before_shown_mps });
        }
        let mut speeds = Trajectories { circumference_m: self.ways.circumference_m, ..Trajectories::default() };
        for moment in self.speeds.values {
            speeds.time_s.push(moment.time_s);
            speeds.speed_mps.push(moment.speed_mps);
            speeds.shown_mps.push(moment.shown_mps);
        }
        let (ways, ways_end_s) = (self.ways, self.ways_end_s);
        Some(DriveTrajectories { ways, ways_end_s, speeds, median_speed_mps: median(self.tenths_mps), range_mps })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::data::StepVehicle;

    /// Collects so many steps of 0.1 s of vehicles that drive 3 m/s, 4 m/s, ... on a ring of 100 m.
    fn collected(steps: u64, cars: u32) -> TrajectoryCollector {
        let mut collector = TrajectoryCollector::new(100.0);
        for k in 1..=steps {
            let at_s = k as f64 * 0.1;
            let car = |id: u32| {
                let speed_mps = f64::from(3 + id);
                StepVehicle { id, s_m: Some((speed_mps * at_s).rem_euclid(100.0)), speed_mps, lane: None }
            };
            collector.add(TrafficStep { tick: 10 * k, vehicles: (0..cars).map(car).collect() }, Some(at_s));
        }
        collector
    }

    #[test]
    fn a_short_drive_is_shown_whole() {
        let found = collected(600, 2).finish(0.5).unwrap();
        assert_eq!((found.ways_end_s, found.median_speed_mps, found.range_mps), (None, Some(3.5), 0.5));
        assert_eq!((found.ways.time_s.len(), &found.ways.time_s), (600, &found.speeds.time_s));
        assert_eq!(found.ways.shown_mps, found.speeds.shown_mps);
        // Two rounds: the distance goes on over the end of the route.
        let [first, last] = [0, 599].map(|i| found.ways.way_m[i][1]);
        assert!((last - first - 59.9 * 4.0).abs() < 1e-3, "{first} {last}");
        assert_eq!(collected(19, 2).finish(0.5), None);
    }

    #[test]
    fn a_drive_of_days_keeps_one_hour_of_ways_and_speeds_to_its_end() {
        let day = collected(864_000, 4);
        let (ways, kept) = (day.ways.time_s.len(), day.speeds.values.len());
        assert_eq!((ways, day.tenths_mps.len()), (36_000, 4 * 3_600));
        assert!(kept * 4 <= MOST_VALUES && kept * 4 > MOST_VALUES / 2, "{kept}");
        let found = day.finish(0.5).unwrap();
        assert_eq!(found.ways_end_s, Some(3600.0));
        assert_eq!(found.speeds.time_s.last(), Some(&86_400.0), "to the last step");
        assert_eq!(found.speeds.shown_mps.last(), Some(&Some(86_400.0)));
        assert!(found.speeds.speed_mps.iter().all(|row| row.len() == 4));
    }

    #[test]
    fn many_cars_are_shown_for_a_shorter_time() {
        let found = collected(3000, 1000).finish(0.5).unwrap();
        assert_eq!((found.ways.time_s.len(), found.ways_end_s), (2000, Some(200.0)));
        assert_eq!(found.speeds.time_s.len(), 1501, "every second one, and the last");
    }
}
