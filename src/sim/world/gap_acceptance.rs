//! When a simulated driver changes lanes where its path does. In: the stretches on which the path changes lanes and the snapshot of a tick. Out: the
//! line that the driver follows there, where it waits, and its leader. Metres, m/s, m/s2.
//!
//! The driver keeps to the lane by which it came until the gap beside is large enough, and then goes over in [`CHANGE_S`]. A gap is accepted by
//! the safety criterion of MOBIL (Kesting, Treiber, Helbing 2007): by the car-following model neither the new follower nor the driver
//! itself has to brake harder than a bound. That is what is comfortable, and [`SAFE_MPS2`] for who waits where the lane is left at last.

use super::{lane_beside::Corridor, lane_changes::LaneChange};
use crate::{
    driver::DriverParams,
    idm::IdmParams,
    map::{RoadMap, network::LanePosition},
    policy::NearVehicle,
    sim::{Snapshot, snapshot::Leader},
    space::CAR_LENGTH_M,
};
use glam::DVec2;

/// A change of lanes takes this long, s, as that of the traffic (drivers take 5 to 6 on average: Toledo 2007).
const CHANGE_S: f64 = 5.0;
/// And at least this much way, metres: at walking pace the arc of a car that goes over by 3.2 m has a radius of 20 m there.
const CHANGE_M: f64 = 20.0;
/// A change at the very end of its edge takes a way, too, metres: a share of nothing is no number.
const SHORTEST_CHANGE_M: f64 = 0.1;
/// The hardest braking that a change may ask for, m/s2 (`b_safe` of MOBIL).
const SAFE_MPS2: f64 = 4.0;
/// Who is slower than this, m/s, so near the place where it has to wait, metres, waits.
const WAITING_MPS: f64 = 1.0;
const WAITING_M: f64 = 10.0;
/// The place to wait is no matter further away than the way on which the ego brakes comfortably and this, metres.
const SEEN_EARLIER_M: f64 = 20.0;

/// The changes of lanes of a path, and how far the ego is with that where it is.
#[derive(Debug)]
pub(super) struct LaneChanging {
    changes: Vec<LaneChange>,
    now: Option<Progress>,
}

/// How far the ego is with a change of lanes.
#[derive(Debug)]
struct Progress {
    /// Which.
    change: usize,
    /// The lane in which it drives, or that it leaves: its place among the lanes of the change.
    at: usize,
    /// Those lanes with what is before and behind.
    corridors: Vec<Corridor>,
    /// It goes over to the next of them.
    going_over: Option<GoingOver>,
}

/// Where on the route the ego goes over, metres.
#[derive(Clone, Copy, Debug)]
struct GoingOver {
    from_s_m: f64,
    length_m: f64,
}

impl LaneChanging {
    /// With the changes of lanes of a path.
    pub fn new(changes: Vec<LaneChange>) -> Self {
        Self { changes, now: None }
    }

    /// Notes how far the ego is, begins a change where there is a gap, and puts the leader in the ego's own lane into the snapshot, where the
    /// route's line is between lanes.
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

    /// How far to the left of the route's line the driver's own line is at a place of the route, metres.
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

    /// Way to where the ego has to wait for a gap, metres, if it does and the place is near.
    pub fn wait_ahead_m(&self, snapshot: &Snapshot, driver: &DriverParams) -> Option<f64> {
        let now = self.now.as_ref().filter(|now| now.going_over.is_none())?;
        let ahead_m = now.to_last_place_m(&self.changes[now.change], snapshot)?;
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        (ahead_m <= speed_mps * speed_mps / (2.0 * driver.idm.b) + SEEN_EARLIER_M).then_some(ahead_m)
    }

    /// Where the change began that is over although its edge is not, metres along the route.
    pub fn over_s_m(&self) -> Option<f64> {
        let now = self.now.as_ref()?;
        let change = &self.changes[now.change];
        (now.at + 1 == change.lanes.len()).then_some(change.start_s_m)
    }

    /// Way from the ego's front bumper to the end of the next edge on which its path changes lanes, metres.
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
        // Whoever drives may have gone over earlier, or not at all.
        let lane = snapshot.ego_lane.map(|at| at.lane);
        self.at = change.lanes.iter().position(|known| lane == Some(*known)).unwrap_or(self.at);
        let Some(last_m) = self.to_last_place_m(change, snapshot) else { return };
        let way_m = snapshot.ego_s_m - change.start_s_m;
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        let waits = speed_mps < WAITING_MPS && last_m < WAITING_M;
        let bound_mps2 = if waits { SAFE_MPS2 } else { IdmParams::default().b };
        // Its tail has left the junction before.
        if way_m >= CAR_LENGTH_M && self.is_gap_wide(change, snapshot, map, bound_mps2) {
            let rest_m = change.end_s_m() - snapshot.ego_s_m;
            let length_m = (speed_mps * CHANGE_S).max(CHANGE_M).min(rest_m).max(SHORTEST_CHANGE_M);
            self.going_over = Some(GoingOver { from_s_m: snapshot.ego_s_m, length_m });
        }
    }

    /// Way to the last place from which all changes that are left can be made, or beyond it to the edge's end, metres; `None` where
    /// none is left.
    fn to_last_place_m(&self, change: &LaneChange, snapshot: &Snapshot) -> Option<f64> {
        let left = change.lanes.len() - 1 - self.at;
        let rest_m = change.end_s_m() - snapshot.ego_s_m;
        let last_m = rest_m - CHANGE_M * left as f64;
        (left > 0).then_some(if last_m >= 0.0 { last_m } else { rest_m })
    }

    /// True if nobody has to brake harder than this for a change to the next lane, and nobody stands too near.
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

    /// The leader in the lanes in which the ego is; beyond the edge that on the route.
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
    /// How far a place of the route is along the stretch, metres, if it is there.
    fn way_m(&self, map: &RoadMap, s_m: f64) -> Option<f64> {
        let way_m = map.route.ahead(self.start_s_m, s_m);
        (0.0..self.length_m).contains(&way_m).then_some(way_m)
    }

    /// The place in one of its lanes that is level with a place of the route, metres from the lane's start.
    fn level_m(&self, map: &RoadMap, at: usize, s_m: f64) -> f64 {
        (s_m - self.start_s_m) / self.length_m * map.network.lane(self.lanes[at]).length_m
    }

    /// How far to the left of the route's line the middle of one of its lanes is, metres.
    fn lane_beside_m(&self, map: &RoadMap, at: usize, s_m: f64) -> f64 {
        let place = LanePosition { lane: self.lanes[at], s_m: self.level_m(map, at, s_m), offset_m: 0.0 };
        let to_lane = map.network.pose(place).position.truncate() - map.route.point_at(s_m);
        to_lane.dot(DVec2::from_angle(map.route.yaw_at(s_m)).perp())
    }
}

#[cfg(test)]
#[path = "gap_acceptance_tests.rs"]
mod tests;
