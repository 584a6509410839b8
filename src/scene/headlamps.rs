//! Headlamps of vehicles. In: the vehicles of a picture. Out: positions and directions of their beams, metres from the scene's origin.

use super::{CarInstance, StaticScene, traffic_parts::drawn_vehicles, vehicles};
use crate::{sim::Snapshot, space::Pose, traffic::VehicleKind};
use glam::Vec3;

/// Headlamps of a vehicle, as one lamp between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Headlamps {
    pub position: Vec3,
    /// Unit direction in which the vehicle faces.
    pub ahead: Vec3,
    /// Unit direction towards the oncoming traffic, which the beam must not dazzle.
    pub inner: Vec3,
    /// True if the main beam is on, too.
    pub is_main: bool,
}

/// Speed from which other drivers use the main beam, m/s: they leave it off in towns.
const MAIN_FROM_MPS: f64 = 16.0;
/// Distance to others up to which they dip it, and half the width of the way ahead that counts, metres and metres per metre.
const DIPPED_M: f32 = 200.0;
const AHEAD_M: f32 = 15.0;
const AHEAD_SLOPE: f32 = 0.15;

/// Returns the headlamps of all motor vehicles, the ego's first. `cars` are the parts of the vehicles, in the same order.
pub(super) fn headlamps(snapshot: &Snapshot, cars: &[CarInstance], static_scene: &StaticScene) -> Vec<Headlamps> {
    let inner = if static_scene.network.is_left_hand() { Vec3::NEG_Y } else { Vec3::Y };
    let mut lit = Vec::with_capacity(cars.len());
    for (body, parts) in drawn_vehicles(snapshot, cars) {
        let front = body.parts(&Pose::default(), None).zip(parts).next();
        let Some((part, car)) = front else { continue };
        if !is_motor(body.kind) {
            continue;
        }
        // Head lamps are beside the front indicators.
        let [beside, _] = vehicles::shape(&body, 0, part.length_m, &static_scene.hubs).indicators;
        lit.push(Headlamps {
            position: car.position + car.rotation * beside.with_y(0.0),
            ahead: car.rotation * Vec3::X,
            inner: car.rotation * inner,
            is_main: false,
        });
    }
    switch_main_beams(snapshot, cars, &mut lit);
    lit
}

fn is_motor(kind: VehicleKind) -> bool {
    !matches!(kind, VehicleKind::Bicycle | VehicleKind::Pedestrian)
}

/// Switches on the main beam of the ego if its driver has, and of others who are fast and have an empty road ahead. `lit` has the headlamps
/// of the motor vehicles.
fn switch_main_beams(snapshot: &Snapshot, cars: &[CarInstance], lit: &mut [Headlamps]) {
    let speeds = snapshot.cars.iter().filter(|car| is_motor(car.body.kind)).map(|car| car.speed_mps);
    let sees = |lamps: &Headlamps, car: &CarInstance| {
        let way = car.position - lamps.position;
        let (ahead_m, aside_m) = (way.dot(lamps.ahead), way.dot(lamps.inner).abs());
        (0.0..DIPPED_M).contains(&ahead_m) && aside_m < AHEAD_M + AHEAD_SLOPE * ahead_m
    };
    let Some((ego, others)) = lit.split_first_mut() else { return };
    ego.is_main = snapshot.ego_main_beam;
    for (lamps, speed_mps) in others.iter_mut().zip(speeds) {
        lamps.is_main = speed_mps > MAIN_FROM_MPS && !cars.iter().any(|car| sees(lamps, car));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::{RoadMap, network::Network},
        scene::{ViewKind, ViewOptions, view},
        sim::VehicleSnapshot,
        traffic::{VehicleBody, VehicleId},
    };

    fn vehicle(id: u32, kind: VehicleKind, length_m: f64, x: f64) -> VehicleSnapshot {
        let pose = Pose { position: glam::DVec2::new(x, 0.0), ..Pose::default() };
        let height_m = if kind == VehicleKind::Bus { 3.4 } else { VehicleBody::CAR.height_m };
        let body = VehicleBody { kind, length_m, height_m, ..VehicleBody::CAR };
        VehicleSnapshot { id: VehicleId(id), pose, pose_before: pose, body, ..VehicleSnapshot::default() }
    }

    #[test]
    fn motor_vehicles_have_headlamps_at_their_fronts_and_the_ego_is_first() {
        let map = RoadMap::load("ring-250").expect("a map that is shipped");
        let static_scene = StaticScene::with_trees(&map, 1, 0);
        // A bus with a joint has two parts.
        let cars = vec![
            vehicle(1, VehicleKind::Bus, 18.0, 30.0),
            vehicle(2, VehicleKind::Bicycle, 1.6, 60.0),
            vehicle(3, VehicleKind::Pedestrian, 0.3, 70.0),
            vehicle(4, VehicleKind::Car, 5.0, 90.0),
        ];
        let snapshot = Snapshot { cars, ..Snapshot::default() };
        let seen = |time_h| {
            let options = ViewOptions::default().at_hour(time_h);
            view(&snapshot, 1.0, ViewKind::Driver, &options, &static_scene).headlamps
        };
        assert!(seen(12.0).is_empty());
        let lit = seen(22.0);
        // Centres of the car at 0 and 90 m, and of the bus's front part.
        let fronts = lit.iter().map(|lamps| lamps.position.x).collect::<Vec<_>>();
        assert_eq!(fronts.len(), 3, "{fronts:?}");
        for (front_m, wanted_m) in fronts.iter().zip([2.5, 39.0, 92.5]) {
            assert!((front_m - wanted_m).abs() < 0.3, "{fronts:?}");
        }
        // UN Regulation 48, 6.2.4.2: 0.5 to 1.2 m high.
        assert!(
            lit.iter().all(|lamps| (0.5..1.2).contains(&lamps.position.z) && lamps.position.y.abs() < 0.01),
            "{lit:?}"
        );
        assert!(lit.iter().all(|lamps| lamps.inner.distance(Vec3::Y) < 1e-3), "right-hand traffic");
        let network = Network::load("tests/data/networks/town-left.net.xml").expect("a network of the tests").into();
        let left_hand = StaticScene { network, ..static_scene };
        let options = ViewOptions::default().at_hour(22.0);
        let lit = view(&snapshot, 1.0, ViewKind::Driver, &options, &left_hand).headlamps;
        assert!(lit.iter().all(|lamps| lamps.inner.distance(Vec3::NEG_Y) < 1e-3), "left-hand traffic");
    }

    #[test]
    fn fast_drivers_dip_for_others_and_the_ego_does_as_its_driver_says() {
        let map = RoadMap::load("ring-250").expect("a map that is shipped");
        let static_scene = StaticScene::with_trees(&map, 1, 0);
        let fast = |id: u32, x: f64| VehicleSnapshot { speed_mps: 25.0, ..vehicle(id, VehicleKind::Car, 5.0, x) };
        // To the east: one 150 m behind another, which has an empty road ahead; a slow one far beyond, and one on foot before it.
        let cars = vec![
            fast(1, 100.0),
            fast(2, 250.0),
            vehicle(3, VehicleKind::Pedestrian, 0.3, 600.0),
            vehicle(4, VehicleKind::Car, 5.0, 900.0),
        ];
        let seen = |ego_main_beam| {
            let snapshot = Snapshot { cars: cars.clone(), ego_main_beam, ..Snapshot::default() };
            let options = ViewOptions::default().at_hour(22.0);
            let lit = view(&snapshot, 1.0, ViewKind::Driver, &options, &static_scene).headlamps;
            lit.iter().map(|lamps| lamps.is_main).collect::<Vec<_>>()
        };
        assert_eq!(seen(false), [false, false, true, false]);
        assert_eq!(seen(true), [true, false, true, false]);
    }
}
