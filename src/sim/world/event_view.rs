//! View of a drive for the events of its scenario. In: the participant's view where a step begins, and the road. Out: the vehicles that events name by
//! their places, distances to them, and the next signal. Metres, m/s.

use super::agent::Agent;
use crate::{
    map::{RoadMap, StopLine},
    scenario::scripted_event::{EventLight, FOLLOWER, LEADER, LEFT_LEADER, RIGHT_LEADER},
    sim::{Snapshot, VehicleSnapshot},
    traffic::VehicleId,
};
use glam::DVec3;

/// Distance from the ego within which a vehicle is one of its neighbours, metres.
const NEIGHBOUR_M: f64 = 200.0;
/// Lateral distances between the ways of vehicles in neighbouring lanes, metres: half of a wide lane to one and a half narrow ones.
const ASIDE_M: [f64; 2] = [1.8, 4.8];

/// Vehicle along the ego's route.
pub(super) struct OnRoute {
    /// Ends of its body, m: the lower place and the higher one.
    pub extent_m: [f64; 2],
    /// Speed along the route, m/s, negative against it.
    pub along_mps: f64,
    pub speed_mps: f64,
    /// Acceleration along its heading, m/s2.
    pub accel_mps2: f64,
    /// Distance driven since the start, m.
    pub driven_m: f64,
    /// Point that follows the lane, with its height: the rear axle of a road user, the middle of another vehicle.
    pub point: DVec3,
}

/// View of a drive where a step begins.
pub(super) struct ScriptView<'a> {
    /// The participant's view of all vehicles.
    pub view: &'a Snapshot,
    pub map: &'a RoadMap,
    /// Vehicle of the participant, if the drive has one.
    pub participant: Option<&'a Agent>,
    /// Vehicles with drivers of their own.
    pub agents: &'a dyn Fn(VehicleId) -> bool,
}

impl ScriptView<'_> {
    /// Returns the image of the participant's vehicle.
    pub fn own(&self) -> Option<&VehicleSnapshot> {
        self.participant.map(|participant| &participant.image)
    }

    /// Returns where a vehicle is along the ego's route.
    pub fn on_route(&self, car: &VehicleSnapshot) -> OnRoute {
        let (route, half_m) = (&self.map.route, car.body.length_m / 2.0);
        let s_m =
            car.s_m.map_or_else(|| route.project(car.pose.position, Some(self.view.ego_s_m)).s_m, |s_m| s_m - half_m);
        let along = (car.pose.yaw_rad - route.yaw_at(s_m)).cos();
        OnRoute {
            extent_m: [s_m - half_m, s_m + half_m],
            along_mps: car.speed_mps * along,
            speed_mps: car.speed_mps,
            accel_mps2: car.accel_mps2,
            driven_m: car.odometer_m,
            point: car.pose.position.extend(car.height_m),
        }
    }

    /// Returns the distance from the ego's front to another vehicle ahead, bumper to bumper along the route; beside the route, from body to body.
    /// `None` for one that is behind.
    pub fn distance_m(&self, id: VehicleId) -> Option<f64> {
        if let Some(leader) = self.view.leader.filter(|leader| leader.id == id) {
            return Some(leader.gap_m);
        }
        let car = self.view.vehicle(id)?;
        let along_m = car.s_m.map(|s_m| self.map.route.drawn_ahead_m(self.view.ego_s_m, s_m) - car.body.length_m);
        let beside_m = || {
            self.own().map(|own| {
                own.pose.position.distance(car.pose.position) - (own.body.length_m + car.body.length_m) / 2.0
            })
        };
        along_m.or_else(beside_m).filter(|distance_m| *distance_m >= 0.0)
    }

    /// Returns the vehicle at a place beside the ego; `None` if there is none, or for another name.
    pub fn neighbour(&self, place: &str) -> Option<VehicleId> {
        match place {
            LEADER => self.view.leader.map(|leader| leader.id),
            FOLLOWER => self.follower(),
            LEFT_LEADER => self.beside(1.0),
            RIGHT_LEADER => self.beside(-1.0),
            _ => None,
        }
    }

    fn follower(&self) -> Option<VehicleId> {
        let own_m = self.own()?.body.length_m;
        let behind = self.view.vehicles().filter_map(|car| {
            let gap_m = self.map.route.drawn_ahead_m(car.s_m?, self.view.ego_s_m) - own_m;
            (0.0..NEIGHBOUR_M).contains(&gap_m).then_some((gap_m, car.id))
        });
        behind.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id)
    }

    /// Returns the next vehicle whose centre is ahead of the ego's, on the lane to its left (1) or right (-1).
    fn beside(&self, left: f64) -> Option<VehicleId> {
        let own = self.own()?;
        let own_m = self.map.route.project(own.pose.position, Some(self.view.ego_s_m));
        let ahead = self.view.vehicles().filter_map(|car| {
            let away_m = own.pose.position.distance(car.pose.position);
            // In a bend a vehicle ahead in the ego's own lane is beside the ego's straight way.
            let near_m = car.s_m.unwrap_or(self.map.route.wrap(own_m.s_m + away_m));
            let at = (away_m < NEIGHBOUR_M).then(|| self.map.route.project(car.pose.position, Some(near_m)))?;
            let is_along = (car.pose.yaw_rad - self.map.route.yaw_at(at.s_m)).cos() > 0.0;
            let aside_m = left * (at.offset_m - own_m.offset_m);
            let ahead_m = self.map.route.drawn_ahead_m(own_m.s_m, at.s_m);
            let is_beside = is_along && (ASIDE_M[0]..ASIDE_M[1]).contains(&aside_m);
            (is_beside && ahead_m >= 0.0).then_some((ahead_m, car.id))
        });
        ahead.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id)
    }

    /// Returns the distance to the next signal on the ego's path, metres, and its stop line.
    pub fn signal_ahead(&self) -> Option<(f64, &StopLine)> {
        self.participant?.network.next_line(self.view, self.map)
    }

    /// Checks whether the next signal on the ego's path is nearer than this and shows a light.
    pub fn has_signal_ahead(&self, light: EventLight, below_m: f64) -> bool {
        let ahead = self.signal_ahead().filter(|(distance_m, _)| *distance_m < below_m);
        ahead.and_then(|(_, line)| self.view.signals.light(line.signal, line.link)).is_some_and(|shown| light.is(shown))
    }

    /// Checks whether the ego's front is on an edge, on this lane of it if one is given, at a place or beyond.
    pub fn is_on_edge(&self, id: &str, lane: Option<usize>, at_m: f64) -> bool {
        let Some(at) = self.view.ego_lane else { return false };
        let edge = self.map.network.edge_of(at.lane);
        let is_lane = |number: usize| edge.lanes().nth(number) == Some(at.lane);
        edge.id == id && at.s_m >= at_m && lane.is_none_or(is_lane)
    }
}
