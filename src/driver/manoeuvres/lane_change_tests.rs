//! Tests of lane changes: vehicles placed beside an ego, gaps computed by hand.

use super::*;
use crate::{
    map::{PathLanes, RoadMap},
    snapshot::VehicleSnapshot,
    traffic::{VehicleBody, VehicleId},
};

const GRID: &str = "tests/data/networks/grid-signals.net.xml";
/// Length of B0B1_0 and the right turn, from the file, metres: there the change from B1C1_0 to B1C1_1 begins, 69.20 m long.
const START_M: f64 = 78.23;

/// An ego on B1C1_0 that is to turn left at C1.
struct Case {
    map: RoadMap,
    changing: LaneChanging,
    snapshot: Snapshot,
}

impl Case {
    /// Returns a case with the ego `way_m` along B1C1.
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

    /// Returns the offset of the driver's line from the centre of the outer lane, metres, positive to the left.
    fn line_m(&self, way_m: f64) -> f64 {
        let change = &self.changing.changes[0];
        self.changing.beside_m(&self.map, START_M + way_m) - change.lane_beside_m(&self.map, 0, START_M + way_m)
    }
}

#[test]
fn a_driver_changes_into_an_empty_lane_and_waits_for_a_vehicle_beside() {
    assert!(Case::new(10.0, 10.0).goes());
    assert!(!Case::new(4.0, 10.0).goes(), "its tail is still in the junction");
    // From positions beside the ego (5 m to 10 m along the edge) to a gap below the minimum gap.
    for s_m in [6.0, 10.0, 14.0, 16.9] {
        assert!(!Case::new(10.0, 10.0).with("B1C1_1", s_m, 10.0).goes(), "{s_m}");
    }
    assert!(Case::new(10.0, 10.0).with("B1C1_0", 5.0, 10.0).goes(), "who is behind in the own lane is no matter");
}

#[test]
fn a_gap_is_accepted_if_the_model_brakes_no_harder_than_comfortably() {
    // IDM (a 1, b 1.5, T 1, s0 2): at 10 m/s behind 10 m/s s* is 12 m; (10/13.89)^4 is 0.269. 1 - 0.269 - (12/g)^2 is -1.5 at g = 8.03 m.
    let follower = |gap_m: f64| Case::new(40.0, 10.0).with("B1C1_1", 35.0 - gap_m, 10.0);
    assert!(follower(8.2).goes() && !follower(7.8).goes());
    let leader = |gap_m: f64| Case::new(40.0, 10.0).with("B1C1_1", 45.0 + gap_m, 10.0);
    assert!(leader(8.2).goes() && !leader(7.8).goes());
    // A follower at 13.89 m/s behind 6 m/s: s* = 2 + 13.89 + 13.89 * 7.89 / (2 * sqrt(1.5)) = 60.63 m; (60.63/g)^2 is 1.5 at g = 49.5 m.
    // Its front is then 0.5 m into B1C1_1, and 0.5 m before the start of B1C1_1 at 50.5 m.
    let fast = |gap_m: f64| Case::new(55.0, 6.0).with("B1C1_1", 50.0 - gap_m, 13.89);
    assert!(fast(49.8).goes() && !fast(49.2).goes());
}

#[test]
fn a_driver_at_the_last_place_accepts_gaps_that_need_up_to_4_mps2() {
    // At a standstill 47 m along, 2.2 m before the last place (20 m before the end): a follower at 8 m/s has s* = 2 + 8 + 64 / 2.449 =
    // 36.13 m, and (8/13.89)^4 is 0.110. 0.890 - (36.13/g)^2 is -4 at g = 16.34 m, and -1.5 at 23.37 m.
    let standing = |gap_m: f64, speed_mps: f64| Case::new(47.0, speed_mps).with("B1C1_1", 42.0 - gap_m, 8.0);
    assert!(standing(16.6, 0.0).goes() && !standing(16.0, 0.0).goes());
    let earlier = Case::new(30.0, 0.0).with("B1C1_1", 25.0 - 20.0, 8.0);
    assert!(!earlier.goes(), "it does not wait there yet");
}

#[test]
fn a_driver_waits_in_its_lane_and_then_changes_lanes_in_five_seconds() {
    let driver = DriverParams::default();
    let mut case = Case::new(20.0, 8.0).with("B1C1_1", 20.0, 8.0);
    case.update();
    // 69.20 m less 20 m and the 20 m driven; from 8 m/s the comfortable braking distance is 64 / 3 = 21.3 m.
    let ahead_m = case.changing.wait_ahead_m(&case.snapshot, &driver).expect("it waits");
    assert!((ahead_m - 29.2).abs() < 1e-9, "{ahead_m}");
    assert!((5..69).all(|way_m| case.line_m(f64::from(way_m)).abs() < 1e-6));
    assert_eq!(case.changing.over_s_m(), None);
    case.snapshot.cars.clear();
    case.update();
    assert_eq!(case.changing.wait_ahead_m(&case.snapshot, &driver), None);
    // A lane change in progress continues.
    case.drive_to(30.0, "B1C1_0");
    case.update();
    // 40 m at 8 m/s; half of the 3.2 m after half of them.
    for (way_m, line_m) in [(20.0, 0.0), (40.0, 1.6), (60.0, 3.2), (69.0, 3.2)] {
        assert!((case.line_m(way_m) - line_m).abs() < 0.01, "{way_m}: {}", case.line_m(way_m));
    }
    case.drive_to(60.5, "B1C1_1");
    case.update();
    assert_eq!(case.changing.over_s_m(), Some(case.changing.changes[0].start_s_m));
    assert!((case.line_m(65.0) - 3.2).abs() < 0.01);
    // Beyond the edge the driver's line is the route's.
    case.drive_to(70.0, "B1C1_1");
    case.update();
    assert_eq!(case.changing.beside_m(&case.map, START_M + 75.0), 0.0);
}

#[test]
fn the_leader_is_in_the_own_lane_or_in_either_lane_during_a_change() {
    let gap_m = |case: &Case| case.snapshot.leader.map(|leader| (leader.gap_m * 100.0).round() / 100.0);
    // Near the stopped vehicle the route's line is closer to the inner lane, but the ego is in the outer lane.
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
