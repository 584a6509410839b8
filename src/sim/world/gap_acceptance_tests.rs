//! Tests of changes of lanes: vehicles set by hand beside an ego, gaps counted by hand.

use super::*;
use crate::{
    map::RoadMap,
    sim::{snapshot::VehicleSnapshot, world::path_lanes::PathLanes},
    traffic::{VehicleBody, VehicleId},
};

const GRID: &str = "tests/data/networks/grid-signals.net.xml";
/// B0B1_0 and the turn to the right, by the file: there the change from B1C1_0 to B1C1_1 begins, 69.20 m long.
const START_M: f64 = 78.23;

/// An ego on B1C1_0, on its way to the left at C1.
struct Case {
    map: RoadMap,
    changing: LaneChanging,
    snapshot: Snapshot,
}

impl Case {
    /// The ego is `way_m` along B1C1.
    fn new(way_m: f64, speed_mps: f64) -> Self {
        let map = RoadMap::load_along(GRID, &["B0B1", "B1C1", "C1C2"]).expect("a path");
        let changing = LaneChanging::new(PathLanes::new(&map).lane_changes(&map));
        let mut case = Self { map, changing, snapshot: Snapshot::default() };
        case.drive_to(way_m, "B1C1_0");
        case.snapshot.ego.speed_mps = speed_mps;
        case
    }

    fn drive_to(&mut self, way_m: f64, lane: &str) {
        let lane = self.map.network.lane_named(lane).expect("a lane");
        self.snapshot.ego_s_m = START_M + way_m;
        self.snapshot.ego_lane = Some(LanePosition { lane, s_m: way_m, offset_m: 0.0 });
    }

    fn with(mut self, lane: &str, s_m: f64, speed_mps: f64) -> Self {
        let lane = self.map.network.lane_named(lane).expect("a lane");
        self.snapshot.cars.push(VehicleSnapshot {
            id: VehicleId(7),
            lane: Some(LanePosition { lane, s_m, offset_m: 0.0 }),
            speed_mps,
            body: VehicleBody::CAR,
            ..VehicleSnapshot::default()
        });
        self
    }

    fn update(&mut self) {
        self.changing.update(&mut self.snapshot, &self.map);
    }

    fn goes(mut self) -> bool {
        self.update();
        self.changing.now.expect("on the stretch").going_over.is_some()
    }

    /// How far to the left of the outer lane's middle the driver's line is.
    fn line_m(&self, way_m: f64) -> f64 {
        let change = &self.changing.changes[0];
        self.changing.beside_m(&self.map, START_M + way_m) - change.lane_beside_m(&self.map, 0, START_M + way_m)
    }
}

#[test]
fn an_empty_lane_lets_the_driver_go_at_once_and_a_vehicle_beside_lets_it_wait() {
    assert!(Case::new(10.0, 10.0).goes());
    assert!(!Case::new(4.0, 10.0).goes(), "its tail is still in the junction");
    // Bumpers at 5 m to 10 m of the ego: side by side, and nearer than the gap of a standstill.
    for s_m in [6.0, 10.0, 14.0, 16.9] {
        assert!(!Case::new(10.0, 10.0).with("B1C1_1", s_m, 10.0).goes(), "{s_m}");
    }
    assert!(Case::new(10.0, 10.0).with("B1C1_0", 5.0, 10.0).goes(), "who is behind in the own lane is no matter");
}

#[test]
fn a_gap_is_accepted_if_nobody_has_to_brake_harder_than_is_comfortable_by_the_model() {
    // IDM (a 1, b 1.5, T 1, s0 2): at 10 m/s behind 10 m/s s* is 12 m; (10/13.89)^4 is 0.269. 1 - 0.269 - (12/g)^2 is -1.5 at g = 8.03 m.
    let follower = |gap_m: f64| Case::new(40.0, 10.0).with("B1C1_1", 35.0 - gap_m, 10.0);
    assert!(follower(8.2).goes() && !follower(7.8).goes());
    let leader = |gap_m: f64| Case::new(40.0, 10.0).with("B1C1_1", 45.0 + gap_m, 10.0);
    assert!(leader(8.2).goes() && !leader(7.8).goes());
    // A follower at 13.89 m/s behind 6 m/s: s* = 2 + 13.89 + 13.89 * 7.89 / (2 * sqrt(1.5)) = 60.63 m; (60.63/g)^2 is 1.5 at g = 49.5 m:
    // the front is 0.5 m into B1C1_1 there, and 0.5 m before its start at 50.5 m.
    let fast = |gap_m: f64| Case::new(55.0, 6.0).with("B1C1_1", 50.0 - gap_m, 13.89);
    assert!(fast(49.8).goes() && !fast(49.2).goes());
}

#[test]
fn who_waits_at_the_last_place_takes_a_gap_for_which_4_mps2_are_enough() {
    // At a standstill 47 m along, 2.2 m before the last place (20 m before the end): a follower at 8 m/s has s* = 2 + 8 + 64 / 2.449 = 36.13 m,
    // and (8/13.89)^4 is 0.110: 0.890 - (36.13/g)^2 is -4 at g = 16.34 m, and -1.5 at 23.37 m.
    let standing = |gap_m: f64, speed_mps: f64| Case::new(47.0, speed_mps).with("B1C1_1", 42.0 - gap_m, 8.0);
    assert!(standing(16.6, 0.0).goes() && !standing(16.0, 0.0).goes());
    let earlier = Case::new(30.0, 0.0).with("B1C1_1", 25.0 - 20.0, 8.0);
    assert!(!earlier.goes(), "it does not wait there yet");
}

#[test]
fn the_driver_keeps_its_lane_while_it_waits_stops_at_the_last_place_and_goes_over_in_five_seconds() {
    let driver = DriverParams::default();
    let mut case = Case::new(20.0, 8.0).with("B1C1_1", 20.0, 8.0);
    case.update();
    // 69.20 m less 20 m and the 20 m driven; at 8 m/s it brakes on 64 / 3 = 21.3 m comfortably.
    let ahead_m = case.changing.wait_ahead_m(&case.snapshot, &driver).expect("it waits");
    assert!((ahead_m - 29.2).abs() < 1e-9, "{ahead_m}");
    assert!((5..69).all(|way_m| case.line_m(f64::from(way_m)).abs() < 1e-6));
    assert_eq!(case.changing.over_s_m(), None);
    case.snapshot.cars.clear();
    case.update();
    assert_eq!(case.changing.wait_ahead_m(&case.snapshot, &driver), None);
    // The change that has begun goes on.
    case.drive_to(30.0, "B1C1_0");
    case.update();
    // 40 m at 8 m/s, half of the 3.2 m after half of them.
    for (way_m, line_m) in [(20.0, 0.0), (40.0, 1.6), (60.0, 3.2), (69.0, 3.2)] {
        assert!((case.line_m(way_m) - line_m).abs() < 0.01, "{way_m}: {}", case.line_m(way_m));
    }
    case.drive_to(60.5, "B1C1_1");
    case.update();
    assert_eq!(case.changing.over_s_m(), Some(case.changing.changes[0].start_s_m));
    assert!((case.line_m(65.0) - 3.2).abs() < 0.01);
    // Beyond the edge the line is the route's.
    case.drive_to(70.0, "B1C1_1");
    case.update();
    assert_eq!(case.changing.beside_m(&case.map, START_M + 75.0), 0.0);
}

#[test]
fn the_leader_is_the_one_in_the_drivers_own_lane_and_in_both_while_it_goes_over() {
    let gap_m = |case: &Case| case.snapshot.leader.map(|leader| (leader.gap_m * 100.0).round() / 100.0);
    // The route's line is nearer to the inner lane here, and so is the vehicle that stands 30 m ahead of it.
    let mut case = Case::new(20.0, 8.0).with("B1C1_1", 20.0, 8.0).with("B1C1_1", 60.0, 0.0);
    case.update();
    assert_eq!(gap_m(&case), None);
    let mut case = case.with("B1C1_0", 50.0, 0.0);
    case.update();
    assert_eq!(gap_m(&case), Some(25.0));
    let mut case = Case::new(20.0, 8.0).with("B1C1_0", 65.0, 0.0).with("B1C1_1", 60.0, 8.0);
    case.update();
    assert!(case.changing.now.as_ref().is_some_and(|now| now.going_over.is_some()));
    assert_eq!(gap_m(&case), Some(35.0));
}
