//! When the ego would collide with another vehicle if both went on along their lanes at the speeds that they have. In: a snapshot and its map.
//! Out: seconds.
//!
//! Vehicles that pass each other in a bend head for each other: so both follow their lanes, the ego its route while it is on it, and its lane while it
//! heads along it, as where it changes lanes. Where a lane leads on in several ways, and beside all lanes, a vehicle goes on straight. Who is on a
//! bridge then does not meet who is below it.

use crate::{
    ego::is_one_road,
    map::{
        RoadMap,
        network::{LanePosition, Network},
    },
    sim::{Snapshot, snapshot::VehicleSnapshot},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};
use glam::{DVec2, DVec3};

/// So far ahead is looked, s.
const HORIZON_S: f64 = 3.0;
const STEPS_PER_S: f64 = 10.0;
/// An ego so far beside its route's line goes on straight, metres.
const ON_ROUTE_M: f64 = 1.0;
/// Cosine of the greatest angle to its lane at which an ego beside its route follows the lane: 0.3 rad, a little more than in a change of lanes within
/// 20 m.
const ALONG_LANE: f64 = 0.955;
/// The longest vehicle, metres: a bus with a joint.
const LONGEST_M: f64 = 20.0;

/// The ego, and how it goes on.
pub(super) struct MovingEgo<'a> {
    /// As a vehicle of the traffic: in its lane, if it heads along it.
    vehicle: VehicleSnapshot,
    /// Its route and where its front is on it, if it follows it.
    on_route: Option<(&'a RoadMap, f64)>,
}

/// A vehicle on its road.
#[derive(Clone, Copy, Debug)]
struct VehicleBox {
    pose: Pose,
    /// Height of the road under it.
    height_m: f64,
    length_m: f64,
    width_m: f64,
}

impl<'a> MovingEgo<'a> {
    /// The ego of a snapshot; `now` is the pose of its middle.
    pub fn of(snapshot: &Snapshot, map: &'a RoadMap, now: &Pose, is_wrong_way: bool) -> Self {
        let follows = snapshot.ego_lane.is_some() && !is_wrong_way && snapshot.lane_offset_m.abs() < ON_ROUTE_M;
        let on_route = follows.then_some((map, snapshot.ego_s_m));
        let heads_along = |at: &LanePosition| (now.yaw_rad - map.network.pose(*at).yaw_rad).cos() > ALONG_LANE;
        let lane = snapshot.ego_lane.filter(heads_along);
        let (speed_mps, height_m) = (snapshot.ego.speed_mps, snapshot.ego.position.z);
        Self {
            vehicle: VehicleSnapshot { pose: *now, lane, speed_mps, height_m, ..VehicleSnapshot::default() },
            on_route,
        }
    }

    /// Seconds until both touch, at most [`HORIZON_S`]; `None` if they do not within that.
    pub fn time_to_collision_s(&self, map: &RoadMap, car: &VehicleSnapshot) -> Option<f64> {
        let own = &self.vehicle;
        let reach_m = (own.speed_mps.abs() + car.speed_mps) * HORIZON_S + LONGEST_M;
        if own.pose.position.distance(car.pose.position) > reach_m || (own.speed_mps == 0.0 && car.speed_mps == 0.0) {
            return None;
        }
        let steps = (HORIZON_S * STEPS_PER_S).round() as u32;
        let times = (0..=steps).map(|step| f64::from(step) / STEPS_PER_S);
        times
            .into_iter()
            .find(|after_s| self.after(&map.network, *after_s).overlaps(&car_after(&map.network, car, *after_s)))
    }

    fn after(&self, net: &Network, after_s: f64) -> VehicleBox {
        let way_m = self.vehicle.speed_mps * after_s;
        let on_route = self.on_route.filter(|(map, s_m)| map.route.is_closed() || s_m + way_m < map.route.length_m());
        let Some((map, s_m)) = on_route.filter(|_| way_m > 0.0) else { return car_after(net, &self.vehicle, after_s) };
        let front_s_m = map.route.wrap(s_m + way_m);
        let pose = map.route.pose_of_front(front_s_m, CAR_LENGTH_M);
        VehicleBox { pose, height_m: map.route.height_m(front_s_m), length_m: CAR_LENGTH_M, width_m: CAR_WIDTH_M }
    }
}

/// A vehicle some seconds on.
fn car_after(net: &Network, car: &VehicleSnapshot, after_s: f64) -> VehicleBox {
    let (length_m, width_m, way_m) = (car.body.length_m, car.body.width_m, car.speed_mps * after_s);
    let straight = |point: DVec2, way_m: f64| point + car.pose.forward() * way_m;
    let (pose, height_m) = match car.lane.filter(|_| way_m > 0.0) {
        Some(at) => {
            // The tail follows the front: into a bend it comes only once it is there.
            let front = front_after(net, at, way_m);
            let tail = match way_m >= length_m {
                true => front_after(net, at, way_m - length_m).truncate(),
                false => straight(car.pose.front(length_m), way_m - length_m),
            };
            let along = front.truncate() - tail;
            let middle = front.truncate() - along.normalize_or_zero() * (length_m / 2.0);
            (Pose::new(middle, along.to_angle()), front.z)
        }
        None => (Pose { position: straight(car.pose.position, way_m), ..car.pose }, car.height_m),
    };
    VehicleBox { pose, height_m, length_m, width_m }
}

/// Where a front is that goes on along its lane, and along what follows where there is one way only.
fn front_after(net: &Network, mut at: LanePosition, way_m: f64) -> DVec3 {
    at.s_m += way_m;
    loop {
        let beyond_m = at.s_m - net.lane(at.lane).length_m;
        let mut ways = net.successors(at.lane);
        match (beyond_m > 0.0, ways.next(), ways.next()) {
            (true, Some(next), None) => at = LanePosition { lane: next, s_m: beyond_m, ..at },
            (true, ..) => {
                let end = net.pose(LanePosition { s_m: net.lane(at.lane).length_m, ..at });
                return end.position + end.flat().forward().extend(end.grade) * beyond_m;
            }
            (false, ..) => return net.pose(at).position,
        }
    }
}

impl VehicleBox {
    /// Half of what the box covers along a direction of length one, metres.
    fn half_along(&self, axis: DVec2) -> f64 {
        let (along, across) = (self.pose.forward(), self.pose.left());
        (along.dot(axis).abs() * self.length_m + across.dot(axis).abs() * self.width_m) / 2.0
    }

    /// Two boxes are apart if they are along one of the four directions of their sides (separating axes), or one is on a bridge above the other.
    fn overlaps(&self, other: &Self) -> bool {
        if !is_one_road(self.height_m, other.height_m) {
            return false;
        }
        let apart = other.pose.position - self.pose.position;
        let axes = [self.pose.forward(), self.pose.left(), other.pose.forward(), other.pose.left()];
        axes.into_iter().all(|axis| apart.dot(axis).abs() <= self.half_along(axis) + other.half_along(axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;
    use std::f64::consts::FRAC_PI_4;

    fn car(x: f64, y: f64, yaw_rad: f64) -> VehicleBox {
        VehicleBox { pose: Pose::new(dvec2(x, y), yaw_rad), height_m: 0.0, length_m: 5.0, width_m: 1.8 }
    }

    #[test]
    fn a_moving_vehicle_meets_a_standing_ego_and_a_standing_one_does_not() {
        let map = RoadMap::load("ring-250").expect("a shipped map");
        let standing = |x: f64| VehicleSnapshot { pose: Pose::new(dvec2(x, 900.0), 0.0), ..VehicleSnapshot::default() };
        let ego = MovingEgo { vehicle: standing(0.0), on_route: None };
        // From middle to middle 25 m, of which both are 5 m long: 20 m at 10 m/s, looked at each tenth of a second.
        let comes = VehicleSnapshot { speed_mps: 10.0, ..standing(-25.0) };
        let found_s = ego.time_to_collision_s(&map, &comes).expect("it comes");
        assert!((found_s - 2.0).abs() < 0.11, "{found_s}");
        assert_eq!(ego.time_to_collision_s(&map, &standing(-4.0)), None);
    }

    #[test]
    fn boxes_touch_where_their_sides_do() {
        let own = car(0.0, 0.0, 0.0);
        assert!(own.overlaps(&car(4.99, 0.0, 0.0)) && !own.overlaps(&car(5.01, 0.0, 0.0)));
        assert!(own.overlaps(&car(0.0, 1.79, 0.0)) && !own.overlaps(&car(0.0, 1.81, 0.0)));
        // Across the other, which is turned by half a right angle, both cover 0.9 m + (2.5 m + 0.9 m) / sqrt 2 = 3.304 m: 4.673 m apart in x.
        assert!(own.overlaps(&car(4.66, 0.0, FRAC_PI_4)) && !own.overlaps(&car(4.69, 0.0, FRAC_PI_4)));
    }
}
