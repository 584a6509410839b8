//! Time to collision of the ego with another vehicle, if both go on along their lanes at constant speed. In: a snapshot and its map. Out:
//! seconds.
//!
//! Vehicles that pass each other in a bend head for each other. Therefore both follow their lanes. The ego follows its route while on it,
//! and its lane while it heads along it, as in a lane change. A vehicle goes straight on where its lane has several successors, and off all
//! lanes. Vehicles on a bridge do not collide with vehicles below it.

use crate::{
    map::{
        RoadMap,
        network::{LanePosition, Network},
    },
    sim::{Snapshot, VehicleSnapshot},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, is_one_road},
    traffic::VehiclePart,
};
use glam::{DVec2, DVec3};
use std::cell::OnceCell;

/// Largest time to collision considered, s.
const HORIZON_S: f64 = 3.0;
/// Moments considered in a second, and in all from now to [`HORIZON_S`].
const STEPS_PER_S: f64 = 10.0;
const STEPS: usize = (HORIZON_S * STEPS_PER_S) as usize + 1;
/// Largest speed of a vehicle's centre, as a multiple of the speed along its lane: on the outside of the tightest bend it is 1.3.
const OUTSIDE: f64 = 1.5;
/// Largest lateral offset at which the ego follows its route, metres; beyond, it goes straight on or along its lane.
const ON_ROUTE_M: f64 = 1.0;
/// Cosine of the largest angle to its lane at which an ego off its route follows the lane: 0.3 rad, a little more than in a lane change
/// within 20 m.
const ALONG_LANE: f64 = 0.955;
/// Length of the longest vehicle, metres: an articulated bus.
const LONGEST_M: f64 = 20.0;

/// The ego and its assumed motion.
pub(super) struct MovingEgo<'a> {
    map: &'a RoadMap,
    /// The ego as a vehicle of the traffic; it has a lane if it heads along it.
    vehicle: VehicleSnapshot,
    /// Position of the front on the route, metres, if the ego follows the route.
    route_s_m: Option<f64>,
    /// Outline at each moment, found once for all vehicles.
    boxes: [OnceCell<VehicleBox>; STEPS],
}

/// Outline of a vehicle on the road.
#[derive(Clone, Copy, Debug)]
struct VehicleBox {
    pose: Pose,
    /// Height of the road under the vehicle, metres.
    height_m: f64,
    length_m: f64,
    width_m: f64,
}

impl<'a> MovingEgo<'a> {
    /// Returns the ego of a snapshot; `now` is the pose of its centre.
    pub fn of(snapshot: &Snapshot, map: &'a RoadMap, now: &Pose, is_wrong_way: bool) -> Self {
        let follows = snapshot.ego_lane.is_some() && !is_wrong_way && snapshot.lane_offset_m.abs() < ON_ROUTE_M;
        let heads_along = |at: &LanePosition| (now.yaw_rad - map.network.pose(*at).yaw_rad).cos() > ALONG_LANE;
        let lane = snapshot.ego_lane.filter(heads_along);
        let (speed_mps, height_m) = (snapshot.ego.speed_mps, snapshot.ego.position.z);
        let vehicle = VehicleSnapshot { pose: *now, lane, speed_mps, height_m, ..VehicleSnapshot::default() };
        Self {
            map,
            vehicle,
            route_s_m: follows.then_some(snapshot.ego_s_m),
            boxes: std::array::from_fn(|_| OnceCell::new()),
        }
    }

    /// Returns the seconds until both touch; `None` if they do not touch within [`HORIZON_S`].
    pub fn time_to_collision_s(&self, car: &VehicleSnapshot) -> Option<f64> {
        let own = &self.vehicle;
        let closing_mps = own.speed_mps.abs() + car.speed_mps;
        let reach_m = closing_mps * HORIZON_S + LONGEST_M;
        if own.pose.position.distance(car.pose.position) > reach_m || closing_mps == 0.0 {
            return None;
        }
        let mut step = 0;
        while let Some(own) = self.boxes.get(step) {
            let after_s = step as f64 / STEPS_PER_S;
            let own = own.get_or_init(|| self.after(after_s));
            let mut between_m = f64::INFINITY;
            for other in car_after(&self.map.network, car, after_s) {
                if own.overlaps(&other) {
                    return Some(after_s);
                }
                let apart_m = own.pose.position.distance(other.pose.position) - own.radius_m() - other.radius_m();
                between_m = between_m.min(apart_m);
            }
            // Until the vehicles can have met, no outline is computed.
            step += ((between_m / (OUTSIDE * closing_mps) * STEPS_PER_S) as usize).max(1);
        }
        None
    }

    fn after(&self, after_s: f64) -> VehicleBox {
        let (route, way_m) = (&self.map.route, self.vehicle.speed_mps * after_s);
        let on_route = self.route_s_m.filter(|s_m| route.is_closed() || s_m + way_m < route.length_m());
        let Some(s_m) = on_route.filter(|_| way_m > 0.0) else {
            let whole = VehiclePart { pose: self.vehicle.pose, length_m: CAR_LENGTH_M };
            return part_after(&self.map.network, &self.vehicle, &whole, 0.0, after_s);
        };
        let front_s_m = route.wrap(s_m + way_m);
        let pose = route.pose_of_front(front_s_m, CAR_LENGTH_M);
        VehicleBox { pose, height_m: route.height_m(front_s_m), length_m: CAR_LENGTH_M, width_m: CAR_WIDTH_M }
    }
}

/// Returns the outlines of a vehicle's parts `after_s` seconds later.
fn car_after(net: &Network, car: &VehicleSnapshot, after_s: f64) -> impl Iterator<Item = VehicleBox> {
    let mut behind_m = 0.0;
    car.parts().map(move |part| {
        let outline = part_after(net, car, &part, behind_m, after_s);
        behind_m += part.length_m;
        outline
    })
}

/// Returns the outline of a part of a vehicle `after_s` seconds later. Its front is now `behind_m` behind the vehicle's.
fn part_after(net: &Network, car: &VehicleSnapshot, part: &VehiclePart, behind_m: f64, after_s: f64) -> VehicleBox {
    let (length_m, width_m, way_m) = (part.length_m, car.body.width_m, car.speed_mps * after_s);
    let Some(at) = car.lane.filter(|_| way_m > 0.0) else {
        let pose = Pose { position: part.pose.position + car.pose.forward() * way_m, ..part.pose };
        return VehicleBox { pose, height_m: car.height_m, length_m, width_m };
    };
    // The rear follows the front: it enters a bend only when it gets there.
    let point = |behind_m: f64| match way_m >= behind_m {
        true => front_after(net, at, way_m - behind_m),
        false => on_body(car, behind_m - way_m).extend(car.height_m),
    };
    let (front, tail) = (point(behind_m), point(behind_m + length_m).truncate());
    let along = front.truncate() - tail;
    let middle = front.truncate() - along.normalize_or_zero() * (length_m / 2.0);
    VehicleBox { pose: Pose::new(middle, along.to_angle()), height_m: front.z, length_m, width_m }
}

/// Returns the point of a vehicle's middle line that is `behind_m` behind its front, along its parts.
fn on_body(car: &VehicleSnapshot, mut behind_m: f64) -> DVec2 {
    let mut point = car.pose.front(car.body.length_m);
    for part in car.parts() {
        let within_m = behind_m.min(part.length_m);
        point -= part.pose.forward() * within_m;
        behind_m -= within_m;
    }
    point
}

/// Returns the position of a front that goes on along its lane, and along successors while there is only one.
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
    /// Returns the distance from the centre to a corner, metres.
    fn radius_m(&self) -> f64 {
        DVec2::new(self.length_m, self.width_m).length() / 2.0
    }

    /// Returns half the extent of the box along a unit vector, metres.
    fn half_along(&self, axis: DVec2) -> f64 {
        let (along, across) = (self.pose.forward(), self.pose.left());
        (along.dot(axis).abs() * self.length_m + across.dot(axis).abs() * self.width_m) / 2.0
    }

    /// Returns true if two boxes overlap. They do not if they are separate along one of their four axes (separating axes), or if one is on
    /// a bridge above the other.
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
    use crate::traffic::{Articulation, VehicleBody, VehicleKind};
    use glam::dvec2;
    use std::f64::consts::FRAC_PI_4;

    fn car(x: f64, y: f64, yaw_rad: f64) -> VehicleBox {
        VehicleBox { pose: Pose::new(dvec2(x, y), yaw_rad), height_m: 0.0, length_m: 5.0, width_m: 1.8 }
    }

    #[test]
    fn a_moving_vehicle_hits_a_stopped_ego_and_a_stopped_one_does_not() {
        let map = RoadMap::load("ring-250").expect("a shipped map");
        let standing = |x: f64| VehicleSnapshot { pose: Pose::new(dvec2(x, 900.0), 0.0), ..VehicleSnapshot::default() };
        let ego = MovingEgo {
            map: &map,
            vehicle: standing(0.0),
            route_s_m: None,
            boxes: std::array::from_fn(|_| OnceCell::new()),
        };
        // The centres are 25 m apart and both vehicles are 5 m long: 20 m at 10 m/s, checked every tenth of a second.
        let comes = VehicleSnapshot { speed_mps: 10.0, ..standing(-25.0) };
        let found_s = ego.time_to_collision_s(&comes).expect("it comes");
        assert!((found_s - 2.0).abs() < 0.11, "{found_s}");
        assert_eq!(ego.time_to_collision_s(&standing(-4.0)), None);
    }

    #[test]
    fn a_search_that_leaves_moments_out_finds_the_first_overlap() {
        let mut stream = crate::rng::stream(1, "meeting");
        for map in [RoadMap::load("ring-250").expect("a ring"), RoadMap::load("practice").expect("a circuit")] {
            let (mut meet, mut pass) = (0, 0);
            let mut vehicle = |near_s_m: f64| {
                let s_m = map.route.wrap(near_s_m + stream.uniform(-40.0, 40.0));
                let (front, lane) =
                    (map.route.pose_of_front(s_m, CAR_LENGTH_M), map.route.lanes()[map.route.lane_at(s_m).0].lane);
                let lane = lane.map(|lane| map.network.place_in(lane, front.front(CAR_LENGTH_M).extend(0.0)));
                let speed_mps = stream.uniform(0.0, 20.0);
                (s_m, VehicleSnapshot { pose: front, lane, speed_mps, ..VehicleSnapshot::default() })
            };
            for _ in 0..500 {
                let (s_m, own) = vehicle(100.0);
                let (_, other) = vehicle(s_m);
                let ego = MovingEgo {
                    map: &map,
                    vehicle: own,
                    route_s_m: Some(s_m),
                    boxes: std::array::from_fn(|_| OnceCell::new()),
                };
                let moments = (0..STEPS).map(|step| step as f64 / STEPS_PER_S);
                let meets = |s: &f64| car_after(&map.network, &other, *s).any(|part| ego.after(*s).overlaps(&part));
                let first = moments.into_iter().find(meets);
                assert_eq!(ego.time_to_collision_s(&other), first, "{own:?} {other:?}");
                *(if first.is_some() { &mut meet } else { &mut pass }) += 1;
            }
            assert!(meet > 50 && pass > 50, "both happen: {meet}, {pass}");
        }
    }

    #[test]
    fn a_lorry_hits_with_its_trailer_where_the_tractor_has_passed() {
        let map = RoadMap::load("ring-250").expect("a shipped map");
        let ego = MovingEgo {
            map: &map,
            vehicle: VehicleSnapshot { pose: Pose::new(dvec2(0.0, 900.0), 0.0), ..VehicleSnapshot::default() },
            route_s_m: None,
            boxes: std::array::from_fn(|_| OnceCell::new()),
        };
        let lorry = |rear_yaw_rad: f64| VehicleSnapshot {
            pose: Pose::new(dvec2(-10.0, 900.0), FRAC_PI_4),
            articulation: Some(Articulation { front_yaw_rad: 2.0 * FRAC_PI_4, rear_yaw_rad }),
            body: VehicleBody { kind: VehicleKind::Truck, length_m: 16.5, width_m: 2.5, height_m: 4.0 },
            ..VehicleSnapshot::default()
        };
        let parts: Vec<_> = car_after(&map.network, &lorry(0.0), 0.0).collect();
        assert_eq!(parts.len(), 2);
        let front = lorry(0.0).pose.front(16.5);
        assert!(parts[0].pose.front(parts[0].length_m).distance(front) < 1e-9);
        let joint = parts[0].pose.rear(parts[0].length_m);
        assert!(joint.distance(parts[1].pose.front(parts[1].length_m)) < 1e-9);
        assert!((parts[0].length_m + parts[1].length_m - 16.5).abs() < 1e-9);
        // A car beside the joint is touched by the trailer if that is turned to it, and by no rigid bar.
        let to_the_car = (dvec2(-0.9, 900.0) - joint).to_angle() + std::f64::consts::PI;
        let stands = |car: VehicleSnapshot| VehicleSnapshot { speed_mps: 0.01, ..car };
        assert!(ego.time_to_collision_s(&stands(lorry(to_the_car))).is_some());
        assert!(ego.time_to_collision_s(&stands(lorry(to_the_car + 2.0 * FRAC_PI_4))).is_none());
    }

    #[test]
    fn boxes_overlap_exactly_when_their_sides_meet() {
        let own = car(0.0, 0.0, 0.0);
        assert!(own.overlaps(&car(4.99, 0.0, 0.0)) && !own.overlaps(&car(5.01, 0.0, 0.0)));
        assert!(own.overlaps(&car(0.0, 1.79, 0.0)) && !own.overlaps(&car(0.0, 1.81, 0.0)));
        // Along the axis across the turned vehicle, both cover 0.9 m + (2.5 m + 0.9 m) / sqrt 2 = 3.304 m, so they touch at 4.673 m in x.
        assert!(own.overlaps(&car(4.66, 0.0, FRAC_PI_4)) && !own.overlaps(&car(4.69, 0.0, FRAC_PI_4)));
    }
}
