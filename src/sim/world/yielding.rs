//! Vehicles of the traffic that brake for people of events, whom no traffic engine knows. In: the people on the road and all vehicles, where a step
//! begins. Out: motions in that step. Metres, m/s.
//!
//! A driver sees a person who is in the vehicle's way, or will be soon: along the ego's route where the vehicle is on it, else straight ahead.

use super::{
    driving_order::DrivingOrder,
    persons_ahead::{AHEAD_M, BesideRoute, along, is_in_way},
    speed_control::{KEEPER, behind},
};
use crate::{
    idm::IdmParams,
    map::Route,
    sim::{Leader, VehicleSnapshot},
    space::is_one_road,
    traffic::{GUARD, LaneMotion},
};

/// Driver who brakes for a person: comfortable braking and gap before them (docs/references.md: walkers).
const BRAKES_FOR: IdmParams = IdmParams { v0: 70.0, t: 1.0, s0: 3.0, a: 1.5, b: 2.5, ..GUARD };
/// Speed below which a vehicle before a person stands until they have passed, and gap up to which it does.
const STANDS_MPS: f64 = 0.5;
const STANDS_M: f64 = 8.0;

/// Returns the motion of a vehicle that brakes for one of these people; `None` for one that has none in its way. `order` has its leader where the
/// engine does not keep distances by itself.
pub(super) fn motion<'a>(
    car: &VehicleSnapshot,
    people: impl Iterator<Item = &'a VehicleSnapshot>,
    route: &Route,
    order: Option<&DrivingOrder>,
    step_s: f64,
) -> Option<LaneMotion> {
    let speed_mps = car.speed_mps.max(0.0);
    let braked = people.filter_map(|person| ahead(car, person, route)).filter_map(|leader| {
        if speed_mps < STANDS_MPS && leader.gap_m < STANDS_M && leader.speed_mps < STANDS_MPS {
            return Some([0.0, speed_mps / 2.0]);
        }
        Some(behind(&BRAKES_FOR, speed_mps, &leader, step_s)).filter(|[end_mps, _]| *end_mps < speed_mps)
    });
    let braked = braked.min_by(|a, b| a[0].total_cmp(&b[0]))?;
    let leader = order.and_then(|order| order.leader(car.id, route));
    let kept = leader.map(|leader| behind(&KEEPER, speed_mps, &leader, step_s));
    let [end_mps, mean_mps] = kept.filter(|kept| kept[0] < braked[0]).unwrap_or(braked);
    Some(LaneMotion { id: car.id, mean_mps, end_mps })
}

/// Returns a person in a vehicle's way as the driver sees them, a person on foot as one who stands.
fn ahead(car: &VehicleSnapshot, person: &VehicleSnapshot, route: &Route) -> Option<Leader> {
    let front = car.pose.front(car.body.length_m);
    if front.distance(person.pose.position) > AHEAD_M || !is_one_road(car.height_m, person.height_m) {
        return None;
    }
    let (ahead_m, offset_m, nearing_mps, turned_rad) = match car.s_m {
        Some(s_m) => {
            let near_s_m = route.wrap(s_m + front.distance(person.pose.position));
            let at = BesideRoute::near(person, route, near_s_m, &|_| 0.0);
            let ahead_m = route.difference(s_m, at.s_m);
            (ahead_m, at.offset_m, at.nearing_mps, person.pose.yaw_rad - route.yaw_at(at.s_m))
        }
        None => {
            let (way, left) = (person.pose.position - front, car.pose.left());
            let offset_m = way.dot(left);
            let nearing_mps = -offset_m.signum() * person.pose.forward().dot(left) * person.speed_mps;
            (way.dot(car.pose.forward()), offset_m, nearing_mps, person.pose.yaw_rad - car.pose.yaw_rad)
        }
    };
    let is_in_way = is_in_way(offset_m, nearing_mps, car.body.width_m + person.body.width_m);
    let (rear_m, speed_mps) = along(person, turned_rad);
    (ahead_m > 0.0 && is_in_way).then_some(Leader { id: person.id, gap_m: ahead_m - rear_m, speed_mps })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::RoadMap,
        space::Pose,
        traffic::{VehicleBody, VehicleId, VehicleKind},
    };
    use glam::dvec2;
    use std::f64::consts::FRAC_PI_2;

    /// Returns the speed after a step of 0.1 s of a car at 10 m/s that heads east, with its front at the origin, and a person who walks to the left.
    fn speed_mps(ahead_m: f64, to_the_left_m: f64, height_m: f64) -> Option<f64> {
        let map = RoadMap::load("ring-250").expect("the shipped ring");
        let pose = Pose::new(dvec2(-2.5, 0.0), 0.0);
        let car = VehicleSnapshot { id: VehicleId(3), pose, speed_mps: 10.0, ..VehicleSnapshot::default() };
        let body = VehicleBody { kind: VehicleKind::Pedestrian, length_m: 0.2, width_m: 0.5, height_m: 1.7 };
        let pose = Pose::new(dvec2(ahead_m, to_the_left_m), FRAC_PI_2);
        let person = VehicleSnapshot { pose, speed_mps: 1.4, body, height_m, ..VehicleSnapshot::default() };
        motion(&car, std::iter::once(&person), &map.route, None, 0.1).map(|motion| motion.end_mps)
    }

    #[test]
    fn a_vehicle_brakes_as_its_model_says_for_a_person_soon_in_its_way() {
        // Desired gap: 3 + 10 + 100 / (2 √(1.5 · 2.5)) = 38.82 m. At 20 m: 1.5 (1 - (10/70)⁴ - (38.82/20)²) = -4.152 m/s².
        let braked_mps = speed_mps(20.0, -3.0, 0.0).expect("it brakes");
        assert!((braked_mps - (10.0 - 0.4152)).abs() < 1e-3, "{braked_mps}");
        // In 2 s the person walks 2.8 m; half of both widths and half a metre are 1.65 m.
        assert!(speed_mps(20.0, -4.4, 0.0).is_some() && speed_mps(20.0, -4.5, 0.0).is_none());
    }

    #[test]
    fn no_vehicle_brakes_for_a_person_behind_beside_far_or_on_a_bridge() {
        assert!(speed_mps(20.0, 1.6, 0.0).is_some() && speed_mps(20.0, 1.7, 0.0).is_none());
        assert!(speed_mps(-1.0, -1.0, 0.0).is_none() && speed_mps(80.0, 0.0, 0.0).is_none());
        assert!(speed_mps(20.0, 0.0, 5.0).is_none());
    }
}
