//! Data of the current drive for plots and maps. In: the world after each tick. Out: speeds over time, the space-time
//! diagram, the share of time in range; of bounded size for a drive of any length. Seconds, metres, m/s.

use super::space_time::{SpaceTime, WINDOW_S};
use crate::{
    map::network::{Edge, Lane, Network},
    panel::SpeedHistory,
    sim::{Snapshot, World},
};
use std::collections::VecDeque;

/// Maximum number of a network's streets on the map, and of the points of each: a picture has no room for more.
const MOST_STREETS: usize = 4000;
const STREET_POINTS: usize = 12;

/// Interval between two rows of all vehicles' speeds, s.
const EVERY_S: f64 = 1.0;

/// Speeds of all vehicles at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedRow {
    /// Time since the start of the drive, seconds.
    pub time_s: f64,
    /// Speeds, m/s: the ego's first, then the others' by ascending id.
    pub speeds_mps: Vec<f32>,
}

/// Log of the drive so far.
#[derive(Clone, Debug)]
pub struct DriveLog {
    /// Mean speed, ego speed and target speed.
    pub history: SpeedHistory,
    /// Positions of all vehicles over time.
    pub space_time: SpaceTime,
    /// Speeds of all vehicles in the last [`WINDOW_S`].
    pub speeds: VecDeque<SpeedRow>,
    /// Centre line of the road that the ego drives, metres.
    pub road: Vec<[f64; 2]>,
    /// Length of that road, metres.
    pub length_m: f64,
    /// Lines of the streets of a network, metres; empty on a closed road.
    pub streets: Vec<Vec<[f64; 2]>>,
    /// True if the end of the road is its start.
    pub is_closed: bool,
    /// Width of the road, metres.
    pub road_width_m: f64,
    /// Speed at the upper end of the colour scale, m/s.
    pub top_mps: f64,
    /// Planned duration of the drive, s; 0 for a drive without an end.
    pub duration_s: f64,
    /// Ticks with advice, and the number of them in range.
    advised: [u64; 2],
    began: bool,
}

impl DriveLog {
    /// Creates an empty log for a drive in `world`.
    pub fn new(world: &World) -> Self {
        let route = &world.map().route;
        let expected = world.expected_speeds();
        // Twice the equilibrium speed, so that standing and flowing traffic differ clearly in colour.
        let top_mps = (2.0 * expected.equilibrium_mps).clamp(4.0, expected.limit_mps.max(4.0));
        let length_m = route.length_m();
        let points = (length_m / 3.0).ceil().clamp(24.0, 2000.0) as usize;
        let point = |i: usize| route.point_at(i as f64 / points as f64 * length_m).to_array();
        let log = Self::on((0..points).map(point).collect(), length_m, route.width_m(0.0), top_mps);
        let streets = if route.is_closed() { Vec::new() } else { streets(&world.map().network) };
        Self { duration_s: world.scenario().duration_s, is_closed: route.is_closed(), streets, ..log }
    }

    /// Creates an empty log for a closed road given by its centre line.
    pub fn on(road: Vec<[f64; 2]>, length_m: f64, road_width_m: f64, top_mps: f64) -> Self {
        Self {
            history: SpeedHistory::default(),
            space_time: SpaceTime::new(length_m, top_mps),
            speeds: VecDeque::new(),
            road,
            length_m,
            streets: Vec::new(),
            is_closed: true,
            road_width_m,
            top_mps,
            duration_s: 0.0,
            advised: [0; 2],
            began: false,
        }
    }

    /// Returns the part of the centre line beyond a position, metres.
    pub fn road_to_come(&self, from_m: f64) -> &[[f64; 2]] {
        let share = (from_m / self.length_m).clamp(0.0, 1.0);
        &self.road[(share * self.road.len() as f64) as usize..]
    }

    /// Adds the world after a tick.
    pub fn watch(&mut self, world: &World) {
        self.add(world.snapshot(), world.scenario().step_ticks());
    }

    /// Adds a snapshot. Advice is counted each tick; vehicles are sampled once a step.
    pub fn add(&mut self, snapshot: &Snapshot, step_ticks: u64) {
        if let Some(advice) = snapshot.advice {
            self.advised[0] += 1;
            self.advised[1] += u64::from(advice.accepts(snapshot.ego.speed_mps));
        }
        if self.began && !snapshot.tick.0.is_multiple_of(step_ticks) {
            return;
        }
        self.began = true;
        let time_s = snapshot.tick.seconds();
        let target = snapshot.advice.map(|advice| advice.target_mps);
        self.history.push(time_s, snapshot.mean_speed_mps, snapshot.ego.speed_mps, target);
        let others = snapshot.cars.iter().filter_map(|car| Some((car.s_m?, car.speed_mps)));
        self.space_time.add(time_s, (snapshot.ego_s_m, snapshot.ego.speed_mps), others);
        if self.speeds.back().is_none_or(|row| time_s - row.time_s > EVERY_S - 1e-6) {
            let all = std::iter::once(snapshot.ego.speed_mps).chain(snapshot.cars.iter().map(|car| car.speed_mps));
            self.speeds.push_back(SpeedRow { time_s, speeds_mps: all.map(|speed| speed as f32).collect() });
        }
        while self.speeds.front().is_some_and(|row| time_s - row.time_s > WINDOW_S) {
            self.speeds.pop_front();
        }
    }

    /// Returns the share of the time with advice in which the ego was in range, 0 to 1; `None` before the first advice.
    pub fn share_in_range(&self) -> Option<f64> {
        let [all, inside] = self.advised;
        (all > 0).then(|| inside as f64 / all as f64)
    }

    /// Returns the start and end of the time axis of plots of all vehicles at `time_s`, s. A drive shorter than
    /// [`WINDOW_S`] is shown whole, a longer one by its last [`WINDOW_S`]. A drive without an end starts with a minute.
    pub fn window(&self, time_s: f64) -> [f64; 2] {
        let whole_s = if self.duration_s > 0.0 { self.duration_s } else { time_s.max(60.0) };
        let width_s = whole_s.min(WINDOW_S);
        let end_s = time_s.max(width_s);
        [end_s - width_s, end_s]
    }
}

/// Returns the lines of the streets for cars, each by a lane in its middle; the longest ones of a large network.
fn streets(net: &Network) -> Vec<Vec<[f64; 2]>> {
    let is_shown = |edge: &&Edge| edge.kind.is_street() && edge.lanes().any(|lane| net.lane(lane).admits_cars());
    let lanes = net.edges().iter().filter(is_shown).filter_map(|edge| edge.lanes().nth(edge.lanes().len() / 2));
    let mut lanes: Vec<&Lane> = lanes.map(|lane| net.lane(lane)).collect();
    lanes.sort_by(|a, b| b.length_m.total_cmp(&a.length_m));
    let line = |lane: &Lane| {
        let points = lane.line.points();
        let every = points.len().div_ceil(STREET_POINTS);
        let last = points.last().filter(|_| !(points.len() - 1).is_multiple_of(every));
        points.iter().step_by(every).chain(last).map(|point| [point.x, point.y]).collect()
    };
    lanes.into_iter().take(MOST_STREETS).map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ego::EgoState,
        policy::{Action, Advice},
        time::Tick,
    };

    fn at(tick: u64, speed_mps: f64, advice: Option<Advice>) -> Snapshot {
        Snapshot {
            tick: Tick(tick),
            ego: EgoState { speed_mps, ..EgoState::default() },
            ego_before: EgoState::default(),
            advice,
            mean_speed_mps: speed_mps,
            ..Snapshot::default()
        }
    }

    #[test]
    fn the_share_in_range_counts_ticks_with_advice_only() {
        let advice = Advice {
            issued: Tick(0),
            hold: crate::policy::Hold::of_steps(1, 0.1),
            action: Action::Speed(4.0),
            target_mps: 4.0,
            range_mps: 0.5,
            is_fallback: false,
            driver: None,
            observed: None,
        };
        let mut log = DriveLog::on(Vec::new(), 250.0, 4.0, 8.0);
        assert_eq!(log.share_in_range(), None);
        for tick in 0..100 {
            log.add(&at(tick, 4.2, None), 10);
        }
        assert_eq!(log.share_in_range(), None);
        for tick in 100..200 {
            log.add(&at(tick, if tick < 125 { 4.2 } else { 5.0 }, Some(advice)), 10);
        }
        assert_eq!(log.share_in_range(), Some(0.25));
    }

    #[test]
    fn an_hour_of_driving_keeps_the_last_five_minutes() {
        let mut log = DriveLog::on(Vec::new(), 250.0, 4.0, 8.0);
        for step in 0..36_000 {
            log.add(&at(step * 10, 4.0, None), 10);
        }
        assert!(log.speeds.len() <= 302, "{}", log.speeds.len());
        assert_eq!(log.speeds.back().unwrap().time_s, 3599.0);
        assert_eq!(log.window(3599.0), [3299.0, 3599.0]);
        assert_eq!((log.window(20.0), log.window(100.0)), ([0.0, 60.0], [0.0, 100.0]));
        // A drive of 90 s fills the width at its end; after an extension, its last 90 s are shown.
        log.duration_s = 90.0;
        assert_eq!((log.window(20.0), log.window(90.0), log.window(120.0)), ([0.0, 90.0], [0.0, 90.0], [30.0, 120.0]));
        log.duration_s = 3600.0;
        assert_eq!(log.window(20.0), [0.0, 300.0]);
    }

    #[test]
    fn a_network_has_its_streets_and_the_part_of_the_path_to_come() {
        let map = crate::map::RoadMap::load("town").expect("a shipped map");
        let lines = streets(&map.network);
        // Every street of the town, one line for each direction, from its first to its last point.
        let cars = map.network.edges().iter().filter(|edge| edge.kind.is_street());
        assert_eq!(lines.len(), cars.count());
        assert!(lines.iter().all(|line| (2..=STREET_POINTS + 1).contains(&line.len())));
        let longest = map.network.lanes().iter().filter(|lane| lane.admits_cars());
        let longest = longest.max_by(|a, b| a.length_m.total_cmp(&b.length_m)).expect("a lane");
        let last = longest.line.points().last().expect("a point");
        assert_eq!(lines[0].last(), Some(&[last.x, last.y]));
        let log = DriveLog::on((0..100).map(|x| [f64::from(x), 0.0]).collect(), 100.0, 4.0, 8.0);
        assert_eq!((log.road_to_come(0.0).len(), log.road_to_come(60.5).first()), (100, Some(&[60.0, 0.0])));
        assert_eq!((log.road_to_come(100.0).len(), log.road_to_come(-3.0).len()), (0, 100));
    }
}
