//! Rules and near misses at a crossing with coordinates from its file: the ego comes from the south at x = 94.8, its front at y = 10.4 + s;
//! vehicles from the west drive at y = 85.2.

use super::*;
use crate::{
    ego::EgoState,
    map::network::SignalStates,
    sim::VehicleSnapshot,
    time::Tick,
    traffic::{VehicleBody, VehicleId},
};
use glam::{DVec2, dvec2};
use std::f64::consts::{FRAC_PI_2, PI};

const GRID: &str = "tests/data/networks/grid-signals.net.xml";

struct Drive {
    map: RoadMap,
    rules: RoadRules,
    tick: u64,
    signals: SignalStates,
    turned_rad: f64,
    offset_m: f64,
    cars: Vec<VehicleSnapshot>,
}

impl Drive {
    /// Returns a drive straight on at the crossing; every link of every signal shows `letter`.
    fn straight_on(letter: u8) -> Self {
        Self::along(&["B0B1", "B1B2"], letter)
    }

    fn along(edges: &[&str], letter: u8) -> Self {
        let map = RoadMap::load_along(GRID, edges).expect("a path");
        let signals = SignalStates::uniform(&map.network, letter);
        Self { map, rules: RoadRules::default(), tick: 0, signals, turned_rad: 0.0, offset_m: 0.0, cars: Vec::new() }
    }

    /// Runs one tick with the ego's front at this position and returns the events.
    fn at(&mut self, s_m: f64, speed_mps: f64) -> Vec<EventKind> {
        let route = &self.map.route;
        let (index, on_lane_m) = route.lane_at(s_m);
        let lane = route.lanes()[index].lane.expect("a lane");
        let middle = route.pose_of_front(s_m, CAR_LENGTH_M);
        let position = middle.position + middle.left() * self.offset_m;
        let pose = Pose { position, yaw_rad: middle.yaw_rad + self.turned_rad };
        self.tick += 1;
        let snapshot = Snapshot {
            tick: Tick(self.tick),
            ego: EgoState { speed_mps, position: pose.position.extend(route.height_m(s_m)), ..EgoState::default() },
            ego_s_m: s_m,
            lane_offset_m: self.offset_m,
            ego_lane: Some(LanePosition { lane, s_m: on_lane_m, offset_m: 0.0 }),
            cars: self.cars.clone(),
            signals: self.signals.clone(),
            ..Snapshot::default()
        };
        let mut events = Vec::new();
        self.rules.watch(&snapshot, &self.map, &pose, &mut events);
        events.into_iter().map(|event| event.kind).collect()
    }

    /// Drives from one position to another at constant speed; returns the events with the positions of the front.
    fn drive_along(&mut self, from_m: f64, to_m: f64, speed_mps: f64) -> Vec<(f64, EventKind)> {
        let ticks = ((to_m - from_m) / (speed_mps * TICK_S)).round() as u32;
        let places = (1..=ticks).map(|tick| from_m + f64::from(tick) * speed_mps * TICK_S);
        places.flat_map(|s_m| self.at(s_m, speed_mps).into_iter().map(move |kind| (s_m, kind))).collect()
    }
}

#[test]
fn a_red_light_is_run_once_the_centre_of_the_ego_is_over_the_line() {
    // The lane and its line end at 69.2 m.
    let found = Drive::straight_on(b'r').drive_along(60.0, 85.0, 10.0);
    let [(line_m, EventKind::StopLine { .. }), (run_m, EventKind::RedLight { .. })] = found[..] else {
        panic!("{found:?}")
    };
    assert!((69.2..69.35).contains(&line_m) && (run_m - 71.7).abs() < 0.25, "{line_m} {run_m}");
    for letter in *b"Ggyo" {
        assert_eq!(Drive::straight_on(letter).drive_along(60.0, 85.0, 10.0), [], "{}", char::from(letter));
    }
}

#[test]
fn an_ego_that_stops_just_beyond_the_line_has_not_run_the_light() {
    let mut drive = Drive::straight_on(b'r');
    let found = drive.drive_along(68.0, 70.0, 5.0);
    assert!(matches!(found[..], [(_, EventKind::StopLine { .. })]), "{found:?}");
    assert!((0..300).all(|_| drive.at(70.0, 0.0).is_empty()));
    // The signal turns green and the ego drives on.
    drive.signals = Drive::straight_on(b'G').signals;
    assert_eq!(drive.drive_along(70.0, 80.0, 5.0), []);
}

#[test]
fn a_second_against_the_lane_is_the_wrong_way() {
    let mut drive = Drive::straight_on(b'G');
    drive.turned_rad = PI;
    let found: Vec<EventKind> = (0..300).flat_map(|_| drive.at(30.0, 5.0)).collect();
    assert!(matches!(found[..], [EventKind::WrongWay { .. }]), "{found:?}");
    drive.turned_rad = 0.0;
    assert_eq!(drive.at(30.0, 5.0), [EventKind::RightWay]);
    // Less than a second does not count.
    drive.turned_rad = PI;
    assert!((0..99).all(|_| drive.at(30.0, 5.0).is_empty()));
    drive.turned_rad = 0.0;
    assert_eq!(drive.at(30.0, 5.0), []);
}

#[test]
fn speeding_begins_a_little_above_the_limit_and_ends_at_it() {
    // The file's limit is 13.89 m/s.
    let mut drive = Drive::straight_on(b'G');
    assert_eq!(drive.at(20.0, 14.8), []);
    let found = drive.at(20.0, 15.89);
    assert!(matches!(found[..], [EventKind::Speeding { over_mps, .. }] if (over_mps - 2.0).abs() < 1e-9), "{found:?}");
    assert_eq!((drive.at(20.0, 16.0), drive.at(20.0, 14.0)), (vec![], vec![]));
    assert_eq!(drive.at(20.0, 13.89), [EventKind::WithinLimit]);
}

/// Returns a car with its front here, in the lane of this name.
fn car(map: &RoadMap, lane: &str, s_m: f64, front: DVec2, yaw_rad: f64, speed_mps: f64) -> VehicleSnapshot {
    let lane = map.network.lane_named(lane).expect("a lane");
    VehicleSnapshot {
        id: VehicleId(7),
        pose: Pose::new(front - DVec2::from_angle(yaw_rad) * (VehicleBody::CAR.length_m / 2.0), yaw_rad),
        lane: Some(LanePosition { lane, s_m, offset_m: 0.0 }),
        speed_mps,
        ..VehicleSnapshot::default()
    }
}

/// Returns the near misses of ten ticks at one position.
fn near_misses(drive: &mut Drive, s_m: f64, speed_mps: f64) -> Vec<f64> {
    let kinds: Vec<EventKind> = (0..30).flat_map(|_| drive.at(s_m, speed_mps)).collect();
    kinds
        .iter()
        .map(|kind| if let EventKind::NearMiss { time_s, .. } = kind { *time_s } else { panic!("{kind:?}") })
        .collect()
}

#[test]
fn a_near_miss_when_both_would_be_in_the_crossing_at_the_same_time() {
    let mut drive = Drive::straight_on(b'G');
    // The ego's front, at y = 74.4 with 10 m/s, reaches the other's side (y = 84.3) after 0.99 s; its rear leaves the other's path (y =
    // 86.1) after 1.67 s. The other's front, at x = 84.4 with 10 m/s, reaches the ego's side (x = 93.9) after 0.95 s.
    drive.cars = vec![car(&drive.map, ":B1_16_0", 4.8, dvec2(84.4, 85.2), 0.0, 10.0)];
    assert_eq!(near_misses(&mut drive, 64.0, 10.0), [1.0], "once, in steps of 0.1 s");
    // From 20 m further back it reaches the ego's path after 2.95 s: the ego has left.
    let mut drive = Drive::straight_on(b'G');
    drive.cars = vec![car(&drive.map, "A1B1_0", 54.0, dvec2(64.4, 85.2), 0.0, 10.0)];
    assert!(near_misses(&mut drive, 64.0, 10.0).is_empty());
}

#[test]
fn a_stopped_car_ahead_is_a_near_miss_below_1_5_s_and_one_beside_never() {
    for (gap_m, wanted) in [(13.5, vec![1.4]), (16.5, vec![])] {
        let mut drive = Drive::straight_on(b'G');
        // The ego's front is at y = 30.4.
        let front = dvec2(94.8, 30.4 + gap_m + 5.0);
        drive.cars = vec![car(&drive.map, "B0B1_0", 20.0 + gap_m + 5.0, front, FRAC_PI_2, 0.0)];
        assert_eq!(near_misses(&mut drive, 20.0, 10.0), wanted, "{gap_m}");
    }
    let mut drive = Drive::straight_on(b'G');
    drive.cars = vec![car(&drive.map, "B0B1_1", 30.0, dvec2(91.6, 40.4), FRAC_PI_2, 0.0)];
    assert!(near_misses(&mut drive, 20.0, 10.0).is_empty());
}

#[test]
fn no_near_miss_with_an_oncoming_car_in_its_own_lane_in_a_bend() {
    // The ego turns right at B1 from south to east (:B1_10_0); the other vehicle takes the corner in the other direction (C1B1 to B1B0,
    // :B1_8_0 and on).
    let map = RoadMap::load_along(GRID, &["B0B1", "B1C1"]).expect("a path");
    let mut drive = Drive { map, ..Drive::straight_on(b'G') };
    let front = dvec2(97.9, 91.24);
    let mut other = car(&drive.map, ":B1_8_0", 2.52, front, PI + 0.142, 6.0);
    other.speed_mps = 6.0;
    drive.cars = vec![other];
    assert!(near_misses(&mut drive, 69.4, 6.0).is_empty());
}

#[test]
fn no_near_miss_when_a_vehicle_turns_off_beside_a_stopped_ego() {
    // The ego waits in B0B1_1 (x = 91.6) to turn left; the other vehicle turns right from the lane beside it (x = 94.8).
    let mut drive = Drive::along(&["B0B1", "B1A1"], b'r');
    for way_m in [-3.0, -1.0, 0.1, 1.0, 2.0] {
        let lane = if way_m < 0.0 { ("B0B1_0", 69.2 + way_m) } else { (":B1_10_0", way_m) };
        drive.cars = vec![car(&drive.map, lane.0, lane.1, dvec2(94.8, 79.6 + way_m), FRAC_PI_2, 7.0)];
        assert!(near_misses(&mut drive, 69.0, 0.0).is_empty(), "{way_m}");
    }
}

#[test]
fn no_near_miss_with_oncoming_cars_in_a_lane_change_but_when_swerving() {
    // The ego is at x = 92.2, changing to the inner lane. At 10 m/s and 0.15 rad its side would be at x = 89.0 in 1.3 s, when both fronts
    // meet; the oncoming car's side is at 89.3. At 0.4 rad the ego leaves its lanes.
    for (turned_rad, wanted) in [(0.15, 0), (0.4, 1)] {
        let mut drive = Drive { turned_rad, offset_m: 2.6, ..Drive::straight_on(b'G') };
        drive.cars = vec![car(&drive.map, "B1B0_1", 25.2, dvec2(88.4, 54.4), -FRAC_PI_2, 10.0)];
        assert_eq!(near_misses(&mut drive, 20.0, 10.0).len(), wanted, "{turned_rad}");
    }
}

const HILL: &str = "tests/data/networks/hill.net.xml";

#[test]
fn no_near_miss_between_a_tunnel_and_the_road_above_it() {
    // By the file's description the road up crosses the tunnel at (139, 131.5): it is 17 m high there, and the tunnel 2.6 m below zero.
    let mut drive = Drive { map: RoadMap::load_along(HILL, &["up"]).expect("a path"), ..Drive::straight_on(b'G') };
    let route = &drive.map.route;
    let crossing = dvec2(139.0, 131.5);
    let above_m = route.project(crossing, None).s_m - 10.0;
    let net = &drive.map.network;
    let tunnel = net.lane_named("tunnel_0").expect("a lane");
    let below = net.locate(crossing.extend(-2.6), Some(tunnel)).expect("a place");
    assert_eq!(below.lane, tunnel);
    // Also ten metres before the crossing, where both would meet a second later.
    let at = LanePosition { s_m: below.s_m - 10.0, ..below };
    let front = net.pose(at);
    assert!(front.position.z < 0.0 && front.position.distance(crossing.extend(0.0)) < 12.0, "{front:?}");
    let mut other = car(&drive.map, "tunnel_0", at.s_m, front.position.truncate(), front.yaw_rad, 10.0);
    other.height_m = front.position.z;
    drive.cars = vec![other];
    assert!(near_misses(&mut drive, above_m, 10.0).is_empty());
    // At the same level it is a near miss.
    let mut level = Drive { map: RoadMap::load_along(HILL, &["up"]).expect("a path"), ..Drive::straight_on(b'G') };
    level.cars = vec![VehicleSnapshot { lane: None, height_m: 17.0, ..drive.cars[0] }];
    assert_eq!(near_misses(&mut level, above_m, 10.0).len(), 1);
}

#[test]
fn a_vehicle_stopped_higher_up_a_slope_is_in_the_way() {
    // From 62 m to 112 m the road rises by 14 %: 23.3 m ahead it is 3.4 m higher, as much as a bridge might be. The gap closes in 1.36 s.
    let mut drive = Drive { map: RoadMap::load_along(HILL, &["up"]).expect("a path"), ..Drive::straight_on(b'G') };
    let (route, gap_m) = (&drive.map.route, 18.3);
    let pose = route.pose_of_front(70.0 + gap_m + 5.0, 5.0);
    let name = route.lanes()[0].id(&drive.map.network).to_owned();
    let mut other = car(&drive.map, &name, 70.0 + gap_m + 5.0, pose.front(5.0), pose.yaw_rad, 0.0);
    other.height_m = route.height_m(70.0 + gap_m + 5.0);
    assert!(other.height_m - route.height_m(70.0) > 3.0);
    drive.cars = vec![other];
    assert_eq!(near_misses(&mut drive, 70.0, 13.5), [1.4]);
}
