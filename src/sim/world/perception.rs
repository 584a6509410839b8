//! Input of policies, simulated drivers and lane help. In: the world seen from a vehicle. Out: the policy's [`Observation`], a simulated
//! driver's [`Perception`], and the lane for lane help. Metres, m/s, radians.

use super::{World, agent::Agent, derived_state};
use crate::{
    controls::LaneHint,
    driver::{Perception, SeenLeader, SimulatedDriver, manoeuvres::lane_beside},
    map::network::Side,
    policy::{Observation, RoadAhead},
    scenario::PlannedDrive,
    space::{CAR_LENGTH_M, wrap_angle},
};

/// Look-ahead of lane help for curvature, seconds (about the delay of steering), and the length over which it is measured, metres.
const LANE_HINT_AHEAD_S: f64 = 0.2;
pub(super) const LANE_HINT_SPAN_M: f64 = 4.0;
/// Look-ahead of a policy for curvature, seconds.
const BEND_AHEAD_S: f64 = 3.0;

impl World {
    /// Returns what a simulated driver in the participant's vehicle perceives now; nothing without a participant.
    pub fn perceived_by(&self, driver: &SimulatedDriver) -> Perception {
        self.observer.participant().map(|agent| agent.perceived_by(driver)).unwrap_or_default()
    }

    /// Returns the participant's lane for lane help: offset and heading error at the ego's centre, curvature `LANE_HINT_AHEAD_S` ahead.
    pub fn lane_hint(&self) -> LaneHint {
        self.observer.participant().map(Agent::lane_hint).unwrap_or_default()
    }
}

impl Agent {
    /// Returns what the policy observes now.
    pub(super) fn observe(&self, drive: &PlannedDrive) -> Observation {
        Observation { road: self.road_ahead(), ..self.observe_traffic(drive) }
    }

    /// Returns what the policy observes now, without the road ahead.
    pub(super) fn observe_traffic(&self, drive: &PlannedDrive) -> Observation {
        let speed_mps = self.view.ego.speed_mps;
        let length_m = self.map.route.length_m();
        let without_leader = self.advice.road.without_leader(length_m, speed_mps);
        let (gap_m, leader_speed_mps) = self.view.leader.map_or(without_leader, |l| (l.gap_m, l.speed_mps));
        Observation {
            speed_mps,
            leader_speed_mps,
            gap_m,
            circumference_m: length_m,
            vehicles: drive.scenario().vehicles,
            ..Observation::default()
        }
    }

    fn road_ahead(&self) -> RoadAhead {
        let (route, snapshot) = (&self.map.route, &self.view);
        let ahead_m = snapshot.ego.speed_mps.max(0.0) * BEND_AHEAD_S;
        let network = &self.network;
        let beside =
            |side: Side| self.advice.sees.lanes_beside.then(|| lane_beside(snapshot, &self.map, side)).flatten();
        RoadAhead {
            speed_limit_mps: route.speed_limit_mps(snapshot.ego_s_m),
            bend_per_m: route.curvature_at(snapshot.ego_s_m + ahead_m, LANE_HINT_SPAN_M),
            follower: derived_state::follower(snapshot, route),
            left: beside(Side::Left),
            right: beside(Side::Right),
            signal: network.next_signal(snapshot, &self.map),
            yield_line_m: network.line_ahead_m(snapshot, &self.map, false),
            stop_line_m: network.line_ahead_m(snapshot, &self.map, true),
            lane_end_m: network.lane_end_ahead_m(snapshot, &self.map),
            path_left_m: (!route.is_closed()).then(|| (route.length_m() - snapshot.ego_s_m).max(0.0)),
        }
    }

    /// Returns what a simulated driver in this vehicle perceives now.
    pub(super) fn perceived_by(&self, driver: &SimulatedDriver) -> Perception {
        let snapshot = &self.view;
        Perception {
            speed_mps: snapshot.ego.speed_mps,
            lane: driver.look_beside(&self.map.route, &snapshot.ego, Some(snapshot.ego_s_m), |s_m| {
                self.network.beside_m(&self.map, s_m)
            }),
            leader: self.nearest_ahead(),
            stop_ahead_m: self.network.stop_ahead_m(snapshot, &self.map, driver.params()),
            advice: snapshot.advice,
            speed_limit_mps: self.map.route.speed_limit_mps(snapshot.ego_s_m),
            indicator: self.network.indicator(snapshot, &self.map),
            task: snapshot.task,
            automation: snapshot.automation,
            wheel_rad: snapshot.ego.steering_wheel_rad,
        }
    }

    /// Returns the leader, or what is nearer: persons in the way, for whom a driver stops as behind a vehicle that stands, a vehicle across the
    /// way in a junction, or the vehicle of another lane behind which the driver merges.
    fn nearest_ahead(&self) -> Option<SeenLeader> {
        let leader = self.view.leader.map(|leader| SeenLeader { gap_m: leader.gap_m, speed_mps: leader.speed_mps });
        let person = self.network.person_ahead(&self.view, &self.map);
        let merging = self.network.merges_behind(&self.view, &self.map);
        let crossing = self.network.across(&self.view, &self.map);
        [leader, person, merging, crossing].into_iter().flatten().min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
    }

    /// Returns the offset and heading error at this vehicle's centre and the curvature `LANE_HINT_AHEAD_S` ahead.
    pub(super) fn lane_hint(&self) -> LaneHint {
        let (route, snapshot) = (&self.map.route, &self.view);
        let middle_s_m = snapshot.ego_s_m - CAR_LENGTH_M / 2.0;
        let ahead_m = snapshot.ego.speed_mps.max(0.0) * LANE_HINT_AHEAD_S;
        LaneHint {
            curvature: route.curvature_at(middle_s_m + ahead_m, LANE_HINT_SPAN_M),
            offset_m: snapshot.lane_offset_m,
            heading_error_rad: wrap_angle(snapshot.ego.pose().yaw_rad - route.yaw_at(middle_s_m)),
        }
    }
}
