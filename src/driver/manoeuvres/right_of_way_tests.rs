//! Tests of waiting at lines: vehicles placed in networks' lanes, times computed by hand.

use super::*;
use crate::{
    map::{
        PathLanes,
        network::{LanePosition, SignalStates},
    },
    space::Pose,
    traffic::VehicleBody,
};

const ROUNDABOUT: &str = "tests/data/networks/roundabout.net.xml";
const GRID: &str = "tests/data/networks/grid-signals.net.xml";
const TOWN: &str = "tests/data/networks/town.net.xml";
const LIMIT_MPS: f64 = 13.89;
/// Starts after half a second, then accelerates at 2 m/s² up to 8 m/s.
const PACE: OwnPace = OwnPace { delay_s: 0.5, accel_mps2: 2.0, decel_mps2: 1.5, through_mps: 8.0 };

/// An ego `ahead_m` before the first line of a path, and other vehicles.
struct Case {
    map: RoadMap,
    right_of_way: RightOfWay,
    snapshot: Snapshot,
}

impl Case {
    fn new(file: &str, edges: &[&str], ahead_m: f64) -> Self {
        let map = RoadMap::load_along(file, edges).expect("a path");
        let right_of_way = RightOfWay::new(PathLanes::new(&map).yield_lines(&map));
        let snapshot = Snapshot { ego_s_m: right_of_way.lines[0].s_m - ahead_m, ..Snapshot::default() };
        Self { map, right_of_way, snapshot }
    }

    fn put(&mut self, id: u32, lane: &str, s_m: f64, speed_mps: f64) {
        let lane = self.map.network.lane_named(lane).expect("a lane");
        let at = LanePosition { lane, s_m, offset_m: 0.0 };
        let pose = Pose::default();
        self.snapshot.cars.push(VehicleSnapshot {
            id: VehicleId(id),
            pose,
            lane: Some(at),
            speed_mps,
            body: VehicleBody::CAR,
            ..VehicleSnapshot::default()
        });
    }

    /// Returns true if the ego waits for this vehicle alone, 5 m long.
    fn waits_for(&mut self, lane: &str, s_m: f64, speed_mps: f64) -> bool {
        self.snapshot.cars.clear();
        self.put(1, lane, s_m, speed_mps);
        self.waits()
    }

    fn waits(&self) -> bool {
        let line = &self.right_of_way.lines[0];
        let ahead_m = line.s_m - self.snapshot.ego_s_m;
        self.right_of_way.must_wait(line, ahead_m, &self.snapshot, &PACE)
    }

    fn stand(&mut self, ticks: u32) {
        for _ in 0..ticks {
            self.right_of_way.update(&self.snapshot, &self.map);
        }
    }
}

#[test]
fn reach_time_is_at_constant_acceleration_up_to_the_top_speed() {
    // 16 m from standstill at 2 m/s²: sqrt(16) s, to 8 m/s; 8 m more at that speed take 1 s.
    assert_eq!((reach_s(16.0, 0.0, 2.0, 8.0), reach_s(24.0, 0.0, 2.0, 8.0)), (4.0, 5.0));
    // 15 m are driven while accelerating: sqrt(15) s.
    assert!((reach_s(15.0, 0.0, 2.0, 8.0) - 15.0_f64.sqrt()).abs() < 1e-12);
    // From 3 m/s to 5 m/s in 1 s and 4 m.
    assert_eq!(reach_s(4.0, 3.0, 2.0, 8.0), 1.0);
    assert_eq!(reach_s(20.0, 10.0, 2.0, 8.0), 2.0, "who is faster keeps its speed");
}

#[test]
fn an_ego_too_fast_for_the_junction_slows_down_evenly_to_its_line() {
    // 18 m at the mean of 10 m/s and 8 m/s: 2 s; 16 m beyond at 8 m/s: 2 s more.
    assert_eq!(PACE.window(18.0, 10.0, 16.0), OwnWindow { arrives_s: 2.0, leaves_s: 4.0, speed_mps: 8.0 });
}

#[test]
fn at_a_roundabout_the_ego_waits_until_the_gap_is_long_enough() {
    let mut case = Case::new(ROUNDABOUT, &["Ss", "se", "en", "nN"], 2.0);
    assert!(!case.waits(), "nobody comes");
    // 2 m and 7.82 m inside take 0.5 s + sqrt(9.82) s = 3.634 s; there the ego has sqrt(4 * 9.82) = 6.267 m/s, 7.623 m/s less than the
    // limit. The other vehicle slows down at 1.5 m/s² while the ego accelerates at 2 m/s², for which it needs 7.623^2 / (2 * 3.5) = 8.301 m
    // more, or 0.598 s. With the gap of 1 s that is 5.231 s, or 72.66 m at the limit, to the end of both paths (12.36 m beyond the line)
    // less the ego's 5 m. The line is 67.28 m from the start of :n_2_0: the vehicle is at 1.98 m of that lane.
    assert!(case.waits_for(":n_2_0", 2.3, LIMIT_MPS) && !case.waits_for(":n_2_0", 1.7, LIMIT_MPS));
    // From 5 m/s it may accelerate at 2 m/s², 41.98 m in 4.445 s, and is slower than the ego: 0.189 s more at the limit are 2.63 m. 44.61 m
    // less 7.36 m are 37.25 m before the line, which is 54.92 m from the start of nw_0: it is at 17.67 m of that lane.
    assert!(case.waits_for("nw_0", 18.0, 5.0) && !case.waits_for("nw_0", 17.4, 5.0));
    // From ws_0 it arrives first. The ego, 2 m away, arrives in sqrt(2) s = 1.41 s; the vehicle, 5 m long, must have left :s_2_0 (12.36 m)
    // within 0.41 s.
    assert!(case.waits_for(":s_2_0", 11.0, LIMIT_MPS), "6.36 m at 13.89 m/s: 0.46 s");
    assert!(!case.waits_for(":s_2_0", 12.2, LIMIT_MPS), "5.16 m: 0.37 s");
    // A vehicle stopped before its line on the ring may start at any time. A vehicle in the lane beyond is a leader, and one from another
    // arm yields itself.
    assert!(case.waits_for("ws_0", 20.0, 0.0));
    assert!(!case.waits_for("se_0", 5.0, 5.0) && !case.waits_for("Ww_0", 120.0, 5.0));
}

#[test]
fn the_ego_waits_5_s_for_stopped_vehicles_and_always_for_moving_ones() {
    let mut case = Case::new(ROUNDABOUT, &["Ss", "se", "en", "nN"], 2.0);
    case.put(1, "ws_0", 20.0, 0.0);
    case.stand(499);
    assert!(case.waits());
    case.stand(1);
    assert!(!case.waits());
    case.stand(2000);
    assert!(case.waits_for("ws_0", 20.0, 3.0));
}

#[test]
fn a_green_left_turn_waits_for_oncoming_traffic_without_red() {
    let mut case = Case::new(GRID, &["B0B1", "B1A1"], 2.0);
    let net = &case.map.network;
    let lights = |letters: &str| {
        // All signals in their first phase, B1 with these letters.
        let mut states = SignalStates::by_first_program(net, 0.0);
        let (mut all, mut starts) = (Vec::new(), vec![0]);
        for (k, signal) in net.signals().iter().enumerate() {
            let own = states.letters(crate::map::network::SignalId::from_index(k));
            all.extend_from_slice(if signal.id == "B1" { letters.as_bytes() } else { own });
            starts.push(all.len() as u32);
        }
        states.set(&all, &starts);
        states
    };
    // Link 13 is the ego's; links 1 and 2 go straight on from B2B1.
    let permissive = lights("GGGggrrrrrGGGggrrrrr");
    let protected = lights("rrrrrrrrrrrrrGrrrrrr");
    let oncoming_red = lights("rrrrrrrrrrGGGggrrrrr");
    let ended = lights("yyyyyrrrrryyyyyrrrrr");
    case.snapshot.signals = permissive;
    assert!(!case.waits());
    // 40 m before the line at the limit: 2.88 s. The ego needs 0.5 s + 4 s for 16 m, and 0.67 s for the rest of 2 m + 14.34 m + 5 m.
    assert!(case.waits_for("B2B1_1", 29.2, LIMIT_MPS) && case.waits_for("B2B1_0", 29.2, LIMIT_MPS));
    // In the junction, until its rear has left it: 20.8 m and 5 m.
    assert!(case.waits_for(":B1_1_1", 10.0, 5.0) && case.waits_for("B1B0_1", 3.0, 2.0));
    assert!(!case.waits_for("B1B0_1", 5.1, 2.0) && !case.waits_for("B1B0_0", 30.0, LIMIT_MPS));
    case.snapshot.signals = protected;
    assert!(!case.waits_for("B2B1_1", 29.2, LIMIT_MPS));
    assert!(!case.waits_for(":B1_1_1", 10.0, 5.0), "green with priority waits for nobody");
    // From the limit it needs 13.89^2 / (2 * 4.5) = 21.4 m to stop: at red, a vehicle 30 m away stops and one 15 m away does not.
    case.snapshot.signals = oncoming_red;
    assert!(!case.waits_for("B2B1_1", 39.2, LIMIT_MPS) && case.waits_for("B2B1_1", 54.2, LIMIT_MPS));
    // At the end of green an ego that is still inside goes before stopped vehicles with right of way.
    case.snapshot.signals = ended;
    assert!(!case.waits_for("B2B1_1", 69.0, 0.0) && case.waits_for(":B1_1_1", 10.0, 5.0));
}

#[test]
fn stopping_inside_a_junction_at_red_counts_as_waiting() {
    let mut case = Case::new(GRID, &["B0B1", "B1A1"], 2.0);
    assert!(case.right_of_way.lines[0].waits_inside);
    let (mut all, mut starts) = (Vec::new(), vec![0]);
    for signal in case.map.network.signals() {
        all.resize(all.len() + signal.links.len(), b'r');
        starts.push(all.len() as u32);
    }
    case.snapshot.signals.set(&all, &starts);
    case.stand(600);
    assert_eq!(case.right_of_way.stood_ticks, 600);
}

#[test]
fn at_an_all_way_stop_the_first_to_arrive_goes_first() {
    // Links 1 (nen back to nne) and 5 (wn to nne) have right of way over cn to nne.
    let mut case = Case::new(TOWN, &["cn", "nne"], 2.0);
    assert!(case.waits(), "it stops where nobody is");
    let end_m = case.map.network.lane(case.map.network.lane_named("wn_0").expect("a lane")).length_m;
    case.put(1, "wn_0", end_m - 1.0, 0.0);
    case.stand(1);
    assert!(case.waits(), "the other was there before");
    case.snapshot.cars.clear();
    assert!(!case.waits());
    case.put(2, "wn_0", end_m - 1.0, 0.0);
    case.stand(1);
    assert!(!case.waits(), "this one came later");
    assert!(case.waits_for(":n_5_0", 3.0, 3.0), "and went before");
    // From 8 m/s it needs 8^2 / (2 * 4.5) = 7.1 m to stop.
    let mut waits_for_another = |before_line_m: f64| {
        case.snapshot.cars.clear();
        case.put(3, "wn_0", end_m - before_line_m, 8.0);
        case.waits()
    };
    assert!(waits_for_another(6.0), "it does not stop any more");
    assert!(!waits_for_another(8.0), "it comes later and can stop");
}

#[test]
fn at_an_all_way_stop_earlier_vehicles_go_first_even_if_already_moving() {
    let mut case = Case::new(TOWN, &["cn", "nne"], 10.0);
    let end_m = case.map.network.lane(case.map.network.lane_named("wn_0").expect("a lane")).length_m;
    case.put(1, "wn_0", end_m - 1.0, 0.0);
    case.stand(1);
    // The ego is at its line now; the other vehicle starts, and could still stop.
    case.snapshot.ego_s_m += 8.0;
    case.snapshot.cars.clear();
    case.put(1, "wn_0", end_m - 0.5, 1.0);
    case.stand(1);
    assert!(case.waits());
    case.snapshot.cars.clear();
    case.put(2, "wn_0", end_m - 0.5, 1.0);
    assert!(!case.waits(), "another one, who comes later");
}

#[test]
fn a_line_to_wait_at_is_reported_in_time_to_brake_for_it() {
    let mut case = Case::new(ROUNDABOUT, &["Ss", "se", "en", "nN"], 40.0);
    let driver = DriverParams::default();
    case.put(1, "ws_0", 20.0, 0.0);
    let mut must_yield = |ahead_m: f64, speed_mps: f64| {
        case.snapshot.ego_s_m = 124.07 - ahead_m;
        case.snapshot.ego.speed_mps = speed_mps;
        case.right_of_way.update(&case.snapshot, &case.map);
        case.right_of_way.must_yield_ahead_m(&case.snapshot, &case.map, &driver).is_some()
    };
    // From 6 m/s comfortable braking at 1.5 m/s² (idm.b) takes 12 m, plus 20 m of look-ahead; braking at 4.5 m/s² takes 4 m.
    assert!(must_yield(31.0, 6.0) && !must_yield(33.0, 6.0) && !must_yield(3.9, 6.0));
    // Beyond the line there is no line to wait at.
    assert!(must_yield(2.0, 0.0) && !must_yield(-0.1, 0.0));
}

#[test]
fn the_next_stop_line_and_the_next_yield_line_are_separate() {
    let ahead =
        |case: &Case| [false, true].map(|stops| case.right_of_way.line_ahead_m(&case.snapshot, &case.map, stops));
    assert_eq!(ahead(&Case::new(ROUNDABOUT, &["Ss", "se", "en", "nN"], 40.0)), [Some(40.0), None]);
    assert_eq!(ahead(&Case::new(ROUNDABOUT, &["Ss", "se", "en", "nN"], -0.1)), [None, None], "behind the ego");
    assert_eq!(ahead(&Case::new(TOWN, &["cn", "nne"], 30.0)), [None, Some(30.0)], "all stop at n");
}

#[test]
fn inside_a_junction_a_driver_stops_nearer_to_a_line_than_to_a_vehicle() {
    let mut case = Case::new(GRID, &["B0B1", "B1A1"], 4.0);
    case.put(1, "B2B1_1", 29.2, LIMIT_MPS);
    let driver = DriverParams::default();
    case.stand(1);
    // The model keeps 2 m (s0) to a vehicle and half a metre to the line, so the reported vehicle is 1.5 m beyond the line.
    assert_eq!(case.right_of_way.must_yield_ahead_m(&case.snapshot, &case.map, &driver), Some(5.5));
}

#[test]
fn at_a_zipper_the_ego_follows_who_is_nearer_to_the_end_and_never_waits() {
    let mut case = Case::new("maps/bottleneck/net.xml", &["3", "4"], 20.0);
    assert_eq!(case.map.route.lanes()[0].id(&case.map.network), "3_0");
    let behind = |case: &Case| case.right_of_way.merges_behind(&case.snapshot, &case.map).map(|seen| seen.gap_m);
    let mut with = |lane: &str, s_m: f64| {
        case.snapshot.cars.clear();
        case.put(1, lane, s_m, 9.0);
        case.right_of_way.update(&case.snapshot, &case.map);
        let driver = DriverParams::default();
        assert_eq!(case.right_of_way.must_yield_ahead_m(&case.snapshot, &case.map, &driver), None);
        behind(&case)
    };
    // The lanes end at 100 m. The other vehicle is 5 m nearer and 5 m long; half of the ego's way of 20 m to its line is left to open the gap.
    // The ways through the junction have a mean length of 80.03 m in the file and differ by 0.06 m.
    let seen_m = with("3_1", 85.0).expect("a vehicle to merge behind");
    assert!((seen_m - 10.0).abs() < 0.15, "{seen_m}");
    // 10 m into the junction it is 30 m ahead.
    let seen_m = with(":first_zipper_0_1", 10.0).expect("a vehicle to merge behind");
    assert!((seen_m - (30.0 - 5.0 + 10.0)).abs() < 0.15, "{seen_m}");
    assert_eq!(with("3_1", 75.0), None, "it is further away than the ego");
    assert_eq!((with("3_0", 85.0), with("3_2", 85.0)), (None, None), "a leader, and a vehicle of the other zipper");
}
