//! Lane changes of a simulated driver along the path. In: the stretches on which the path changes lanes and the snapshot of a tick. Out:
//! the line that the driver follows there, the place to wait, and the leader. Metres, m/s, m/s².
//!
//! The driver keeps to the entry lane until the gap beside is large enough, and then changes lanes in [`CHANGE_S`]. A gap is accepted by
//! the safety criterion of MOBIL (Kesting, Treiber, Helbing 2007): by the car-following model, neither the new follower nor the driver has
//! to brake harder than a bound. The bound is the comfortable deceleration, and [`SAFE_MPS2`] for a vehicle that waits at the last place
//! for the change.

use super::lane_beside::Corridor;
use crate::{
    driver::DriverParams,
    idm::IdmParams,
    map::{LaneChange, RoadMap, network::LanePosition},
    policy::NearVehicle,
    snapshot::{Leader, Snapshot},
    space::CAR_LENGTH_M,
};
use glam::DVec2;

/// Duration of a lane change, s, as in the traffic (drivers take 5 to 6 s on average: Toledo 2007).
const CHANGE_S: f64 = 5.0;
/// Minimum length of a lane change, metres: at walking pace the arc of a 3.2 m change then has a radius of 20 m.
const CHANGE_M: f64 = 20.0;
/// Minimum length of a lane change at the end of its edge, metres (avoids division by zero).
const SHORTEST_CHANGE_M: f64 = 0.1;
/// Hardest braking that a lane change may require, m/s² (`b_safe` of MOBIL).
const SAFE_MPS2: f64 = 4.0;
/// A vehicle below this speed, m/s, within this distance of the last place for the change, metres, is waiting.
const WAITING_MPS: f64 = 1.0;
const WAITING_M: f64 = 10.0;
/// Look-ahead to the place to wait beyond the comfortable braking distance, metres.
const SEEN_EARLIER_M: f64 = 20.0;

/// The lane changes of a path, and the progress of the one at the ego.
#[derive(Debug)]
pub struct LaneChanging {
    changes: Vec<LaneChange>,
    now: Option<Progress>,
}

/// Progress of a lane change.
#[derive(Debug)]
struct Progress {
    /// Index of the lane change.
    change: usize,
    /// Index, among the lanes of the change, of the lane in which the ego drives or that it leaves.
    at: usize,
    /// Corridor of each of these lanes, with the lanes before and behind.
    corridors: Vec<Corridor>,
    /// Motion to the next lane, while in progress.
    going_over: Option<GoingOver>,
}

/// Stretch of the route on which the ego moves to the next lane, metres.
#[derive(Clone, Copy, Debug)]
struct GoingOver {
    from_s_m: f64,
    length_m: f64,
}

impl LaneChanging {
    /// Returns the state for the lane changes of a path.
    pub fn new(changes: Vec<LaneChange>) -> Self {
        Self { changes, now: None }
    }

    /// Updates the progress, begins a lane change if the gap is large enough, and sets the snapshot's leader to the one in the ego's own
    /// lane while the route's line is between lanes.
    pub fn update(&mut self, snapshot: &mut Snapshot, map: &RoadMap) {
        let here = self.changes.iter().position(|change| change.way_m(map, snapshot.ego_s_m).is_some());
        let Some(k) = here else {
            self.now = None;
            return;
        };
        let change = &self.changes[k];
        if self.now.as_ref().is_none_or(|now| now.change != k) {
            let corridors = change.lanes.iter().map(|lane| Corridor::new(map, *lane, change.index)).collect();
            self.now = Some(Progress { change: k, at: 0, corridors, going_over: None });
        }
        let Some(now) = &mut self.now else { return };
        now.update(change, snapshot, map);
        snapshot.leader = now.leader(change, snapshot, map);
    }

    /// Returns the offset of the driver's own line from the route's line, metres, positive to the left.
    pub fn beside_m(&self, map: &RoadMap, s_m: f64) -> f64 {
        let Some(now) = &self.now else { return 0.0 };
        let change = &self.changes[now.change];
        let s_m = s_m.clamp(change.start_s_m, change.end_s_m());
        let of = |at: usize| change.lane_beside_m(map, at, s_m);
        match now.going_over {
            None => of(now.at),
            Some(over) => {
                let share = ((s_m - over.from_s_m) / over.length_m).clamp(0.0, 1.0);
                let share = share * share * (3.0 - 2.0 * share);
                of(now.at) * (1.0 - share) + of(now.at + 1) * share
            }
        }
    }

    /// Returns the distance to the place where the ego has to wait for a gap, metres, if it has to wait and the place is near.
    pub fn wait_ahead_m(&self, snapshot: &Snapshot, driver: &DriverParams) -> Option<f64> {
        let now = self.now.as_ref().filter(|now| now.going_over.is_none())?;
        let ahead_m = now.to_last_place_m(&self.changes[now.change], snapshot)?;
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        (ahead_m <= speed_mps * speed_mps / (2.0 * driver.idm.b) + SEEN_EARLIER_M).then_some(ahead_m)
    }

    /// Returns the start of the lane change that is complete while its edge goes on, metres along the route.
    pub fn over_s_m(&self) -> Option<f64> {
        let now = self.now.as_ref()?;
        let change = &self.changes[now.change];
        (now.at + 1 == change.lanes.len()).then_some(change.start_s_m)
    }

    /// Returns the distance from the ego's front bumper to the end of the next edge on which its path changes lanes, metres.
    pub fn lane_end_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<f64> {
        let ends = self.changes.iter().map(|change| map.route.drawn_ahead_m(snapshot.ego_s_m, change.end_s_m()));
        ends.filter(|ahead_m| *ahead_m >= 0.0).min_by(f64::total_cmp)
    }
}

impl Progress {
    fn update(&mut self, change: &LaneChange, snapshot: &Snapshot, map: &RoadMap) {
        let is_over = |over: GoingOver| snapshot.ego_s_m - over.from_s_m >= over.length_m;
        if self.going_over.is_some_and(|over| !is_over(over)) {
            return;
        }
        self.going_over = None;
        // A driver may have changed lanes earlier, or not at all.
        let lane = snapshot.ego_lane.map(|at| at.lane);
        self.at = change.lanes.iter().position(|known| lane == Some(*known)).unwrap_or(self.at);
        let Some(last_m) = self.to_last_place_m(change, snapshot) else { return };
        let way_m = snapshot.ego_s_m - change.start_s_m;
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        let waits = speed_mps < WAITING_MPS && last_m < WAITING_M;
        let bound_mps2 = if waits { SAFE_MPS2 } else { IdmParams::default().b };
        // The vehicle's rear has left the junction first.
        if way_m >= CAR_LENGTH_M && self.is_gap_wide(change, snapshot, map, bound_mps2) {
            let rest_m = change.end_s_m() - snapshot.ego_s_m;
            let length_m = (speed_mps * CHANGE_S).max(CHANGE_M).min(rest_m).max(SHORTEST_CHANGE_M);
            self.going_over = Some(GoingOver { from_s_m: snapshot.ego_s_m, length_m });
        }
    }

    /// Returns the distance to the last place from which all remaining changes are possible, metres; beyond it the distance to the end of
    /// the edge. `None` without remaining changes.
    fn to_last_place_m(&self, change: &LaneChange, snapshot: &Snapshot) -> Option<f64> {
        let left = change.lanes.len() - 1 - self.at;
        let rest_m = change.end_s_m() - snapshot.ego_s_m;
        let last_m = rest_m - CHANGE_M * left as f64;
        (left > 0).then_some(if last_m >= 0.0 { last_m } else { rest_m })
    }

    /// Returns true if a change to the next lane needs no harder braking than this by the driver or the follower and leaves the minimum gap
    /// to both neighbours.
    fn is_gap_wide(&self, change: &LaneChange, snapshot: &Snapshot, map: &RoadMap, bound_mps2: f64) -> bool {
        let net = &map.network;
        let own_mps = snapshot.ego.speed_mps.max(0.0);
        let next = self.at + 1;
        let limit_mps = net.lane(change.lanes[next]).speed_limit_mps;
        let is_wide = |behind_mps: f64, ahead_mps: f64, gap_m: f64| {
            let idm = IdmParams { v0: limit_mps.max(behind_mps), ..IdmParams::default() };
            gap_m >= idm.s0 && idm.acceleration(behind_mps, ahead_mps, gap_m) >= -bound_mps2
        };
        let beside = self.corridors[next].around(net, snapshot, change.level_m(map, next, snapshot.ego_s_m));
        let fits_behind = |leader: NearVehicle| is_wide(own_mps, leader.speed_mps, leader.gap_m);
        let fits_before = |follower: NearVehicle| is_wide(follower.speed_mps, own_mps, follower.gap_m);
        beside.leader.is_none_or(fits_behind) && beside.follower.is_none_or(fits_before)
    }

    /// Returns the nearest leader in the lanes that the ego is in; beyond the edge, the leader on the route.
    fn leader(&self, change: &LaneChange, snapshot: &Snapshot, map: &RoadMap) -> Option<Leader> {
        let rest_m = change.end_s_m() - snapshot.ego_s_m;
        let beyond = snapshot.leader.filter(|leader| leader.gap_m >= rest_m);
        let lanes = self.at..=self.at + usize::from(self.going_over.is_some());
        let own = lanes.filter_map(|at| {
            let own_m = change.level_m(map, at, snapshot.ego_s_m);
            self.corridors[at].nearest(&map.network, snapshot, own_m).0
        });
        own.chain(beyond).min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
    }
}

impl LaneChange {
    /// Returns the distance from the start of the stretch to a position of the route, metres; `None` off the stretch.
    fn way_m(&self, map: &RoadMap, s_m: f64) -> Option<f64> {
        let way_m = map.route.ahead(self.start_s_m, s_m);
        (0.0..self.length_m).contains(&way_m).then_some(way_m)
    }

    /// Returns the position in one of the lanes that is level with a position of the route, metres from the lane's start.
    fn level_m(&self, map: &RoadMap, at: usize, s_m: f64) -> f64 {
        (s_m - self.start_s_m) / self.length_m * map.network.lane(self.lanes[at]).length_m
    }

    /// Returns the offset of the centre of one of the lanes from the route's line, metres, positive to the left.
    fn lane_beside_m(&self, map: &RoadMap, at: usize, s_m: f64) -> f64 {
        let place = LanePosition { lane: self.lanes[at], s_m: self.level_m(map, at, s_m), offset_m: 0.0 };
        let to_lane = map.network.pose(place).position.truncate() - map.route.point_at(s_m);
        to_lane.dot(DVec2::from_angle(map.route.yaw_at(s_m)).perp())
    }
}

#[cfg(test)]
#[path = "lane_change_tests.rs"]
mod tests;
