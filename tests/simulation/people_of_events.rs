//! People whom events of a scenario move: a pedestrian crosses, a cyclist rides. Drivers and the traffic of both engines brake for them, a contact ends the
//! drive, and all is recorded and replayed to the bit.

use crate::world::one_at_a_time;
use codrive::{
    controls::Controls,
    drive_loop::offline::OfflineDrive,
    record::{self, Table, TableReader},
    replay::Replay,
    scenario::{PlannedDrive, Scenario},
    sim::{EndReason, Event, EventKind, EventStage, PERSON_TOUCHED, World},
    traffic::{FIRST_OF_EVENTS, VehicleId, VehicleKind},
};

pub(crate) fn scenario(text: &str) -> Scenario {
    Scenario::from_toml(text, "people.toml").unwrap_or_else(|fault| panic!("{fault}"))
}

const RING: &str = "traffic = \"native\"\nwarm_up_s = 60\nidm = { noise = 0 }\npolicy = \"none\"\ntrees = 0\n";
const LANE: &str = "map = \"lane-10km\"\npolicy = \"none\"\ntrees = 0\n";

/// Returns a scenario in which a pedestrian crosses at a time and place.
fn crosses(road: &str, time_s: f64, place_m: f64) -> Scenario {
    scenario(&format!(
        "{road}[[event]]\nname = \"crosses\"\ntrigger = {{ time_s = {time_s} }}\nactions = [{{ pedestrian_crosses = {{ place_m = {place_m}, from = \"right\" }} }}]\n"
    ))
}

/// Drives by the simulated driver for `seconds`; `look` sees the world at each step's end. Returns the events.
pub(crate) fn drive(scenario: &Scenario, seconds: f64, mut look: impl FnMut(&World)) -> Vec<Event> {
    let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    let mut seen = Vec::new();
    for k in 1..=(seconds / 0.1).round() as usize {
        for tick in 1..=10 {
            run.until((k - 1) as f64 * 0.1 + f64::from(tick) * 0.01).expect("the traffic goes on");
            seen.extend_from_slice(run.world().events());
        }
        look(run.world());
    }
    seen
}

pub(crate) fn contacts(events: &[Event]) -> usize {
    events.iter().filter(|event| matches!(event.kind, EventKind::Contact { .. })).count()
}

#[test]
fn a_simulated_driver_and_its_followers_stop_for_a_pedestrian() {
    // On the ring all drive at 3.7 m/s or so, 6.4 m apart.
    let mut world_starts_m = 0.0;
    drive(&crosses(RING, 50.0, 0.0), 0.1, |world| world_starts_m = world.snapshot().ego_s_m);
    let place_m = (world_starts_m + 25.0) % 250.0;
    let (mut slowest, mut crossed, mut nearest_m) = ([f64::INFINITY; 2], 0, f64::INFINITY);
    let events = drive(&crosses(RING, 2.0, place_m), 25.0, |world| {
        let view = world.snapshot();
        let person = view.persons().next().expect("the pedestrian");
        assert_eq!((person.id, person.body.kind), (FIRST_OF_EVENTS, VehicleKind::Pedestrian));
        let at = world.map().route.project(person.pose.position, None);
        crossed += usize::from(at.offset_m.abs() < 0.9);
        let follower = view.vehicle(VehicleId(21)).expect("on the ring");
        slowest = [slowest[0].min(view.ego.speed_mps), slowest[1].min(follower.speed_mps)];
        nearest_m =
            view.vehicles().map(|car| car.pose.position.distance(person.pose.position)).fold(nearest_m, f64::min);
    });
    assert!(crossed >= 10, "{crossed} steps on the lane");
    assert_eq!(contacts(&events), 0);
    assert!(slowest[0] < 1.0 && slowest[1] < 2.0, "{slowest:?}");
    // A car is 5 m long and 1.8 m wide.
    assert!(nearest_m > 1.2, "{nearest_m}");
    let stages: Vec<_> = events
        .iter()
        .filter_map(|event| match event.kind {
            EventKind::Scripted { vehicle, stage, .. } => Some((event.tick.0, vehicle, stage)),
            _ => None,
        })
        .collect();
    let [
        (0, None, EventStage::Armed),
        (200, None, EventStage::Triggered),
        (201, Some(FIRST_OF_EVENTS), EventStage::Onset),
        (ended, None, EventStage::Ended),
    ] = stages[..]
    else {
        panic!("{stages:?}")
    };
    // 5.6 m: 0.7 s of acceleration and 5.11 m at 1.4 m/s.
    assert!((ended as f64 * 0.01 - 2.0 - 4.35).abs() < 0.2, "{ended}");
}

#[test]
fn vehicles_ahead_of_the_ego_brake_for_a_pedestrian_too() {
    // The person steps before the vehicle that is ahead of the leader.
    let mut front_m = 0.0;
    drive(&crosses(RING, 50.0, 0.0), 2.0, |world| {
        front_m = world.snapshot().vehicle(VehicleId(5)).and_then(|car| car.s_m).expect("on the ring");
    });
    let place_m = (front_m + 14.0) % 250.0;
    let (mut slowest_mps, mut nearest_m) = (f64::INFINITY, f64::INFINITY);
    drive(&crosses(RING, 2.0, place_m), 8.0, |world| {
        let view = world.snapshot();
        let person = view.persons().next().expect("the pedestrian");
        slowest_mps = slowest_mps.min(view.vehicle(VehicleId(5)).expect("on the ring").speed_mps);
        nearest_m =
            view.vehicles().map(|car| car.pose.position.distance(person.pose.position)).fold(nearest_m, f64::min);
    });
    assert!(slowest_mps < 1.0 && nearest_m > 1.2, "{slowest_mps} m/s, {nearest_m} m");
}

#[test]
fn a_contact_with_a_pedestrian_ends_the_drive_and_says_so() {
    let mut scenario = crosses(RING, 0.0, 0.0);
    let mut world = World::of(PlannedDrive::new(&scenario).expect("planned")).expect("a drive");
    let here_m = world.snapshot().ego_s_m;
    scenario = crosses(RING, 0.5, (here_m + 12.0) % 250.0);
    world = World::of(PlannedDrive::new(&scenario).expect("planned")).expect("a drive");
    let controls = Controls { throttle: 0.4, ..Controls::default() };
    let mut touched = None;
    for _ in 0..1500 {
        // The ego follows the ring without looking.
        let hint = world.lane_hint();
        let steer = (2.8 * hint.curvature).atan() - 0.9 * hint.heading_error_rad - 0.06 * hint.offset_m;
        world.tick(&Controls { steering_wheel_rad: 15.0 * steer as f32, ..controls }).expect("a tick");
        touched = touched.or(world.events().iter().find_map(|event| match event.kind {
            EventKind::Contact { car, kind, .. } => Some((car, kind, event.tick)),
            _ => None,
        }));
    }
    let (car, kind, tick) = touched.expect("a contact");
    assert_eq!((car, kind), (FIRST_OF_EVENTS, VehicleKind::Pedestrian));
    assert_eq!(world.ended(), Some(EndReason::Contact), "although a contact with a car would not end it");
    assert_eq!((world.snapshot().tick, world.snapshot().message.as_deref()), (tick, Some(PERSON_TOUCHED)));
}

#[test]
fn traffic_of_sumo_brakes_for_a_pedestrian() {
    let _alone = one_at_a_time();
    let (mut slowest_mps, mut nearest_m, mut crossed) = (f64::INFINITY, f64::INFINITY, 0);
    let text =
        crosses("map = \"ring-250\"\nwarm_up_s = 60\nidm = { noise = 0 }\npolicy = \"none\"\ntrees = 0\n", 2.0, 100.0);
    drive(&text, 10.0, |world| {
        let view = world.snapshot();
        let Some(person) = view.persons().next() else { return };
        let at = world.map().route.project(person.pose.position, None);
        crossed += usize::from(at.offset_m.abs() < 0.9);
        slowest_mps = view.vehicles().map(|car| car.speed_mps).fold(slowest_mps, f64::min);
        nearest_m =
            view.vehicles().map(|car| car.pose.position.distance(person.pose.position)).fold(nearest_m, f64::min);
    });
    assert!(crossed >= 10 && slowest_mps < 1.0 && nearest_m > 1.2, "{crossed}, {slowest_mps} m/s, {nearest_m} m");
}

#[test]
fn a_driver_stays_behind_a_cyclist_on_the_road() {
    let _alone = one_at_a_time();
    let scenario = scenario(&format!(
        "{LANE}[[event]]\nname = \"rides\"\ntrigger = {{ place_m = 150 }}\nactions = [{{ cyclist_rides = {{ place_m = 350, for_m = 150, speed_mps = 5 }} }}]\n"
    ));
    let (mut followed, mut rode, mut nearest_m) = (0, 0, f64::INFINITY);
    let events = drive(&scenario, 60.0, |world| {
        let view = world.snapshot();
        let Some(cyclist) = view.persons().next() else { return };
        assert_eq!(cyclist.body.kind, VehicleKind::Bicycle);
        let at = world.map().route.project(cyclist.pose.position, None);
        let is_on_road = at.offset_m.abs() < 1.75 && cyclist.speed_mps == 5.0;
        rode += usize::from(is_on_road);
        followed += usize::from(is_on_road && (view.ego.speed_mps - 5.0).abs() < 0.5 && view.ego_s_m < at.s_m);
        nearest_m = nearest_m.min(cyclist.pose.position.distance(view.ego.position.truncate()));
    });
    assert!(rode > 150 && followed > 80, "{rode} steps on the road, {followed} followed");
    assert!(contacts(&events) == 0 && nearest_m > 1.0, "{nearest_m}");
}

#[test]
fn a_person_beyond_the_road_and_one_too_fast_are_faults() {
    let fault = PlannedDrive::new(&crosses(RING, 1.0, 260.0)).map(drop).expect_err("beyond the ring").to_string();
    assert!(fault.contains("place_m is 260, and the route is 250.0 m long"), "{fault}");
    let text = "[[event]]\nname = \"a\"\ntrigger = { time_s = 1 }\nactions = [{ pedestrian_crosses = { place_m = 1, from = \"left\", speed_mps = 9 } }]\n";
    let fault = Scenario::from_toml(text, "people.toml").expect_err("too fast").message;
    assert!(fault.contains("people.toml:4") && fault.contains("speed_mps is 9; allowed: 0.3 to 5"), "{fault}");
}

#[test]
fn a_recorded_pedestrian_is_replayed_to_the_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = Scenario { duration_s: 6.0, ..crosses(RING, 1.0, 60.0) };
    let path = folder.path().join("drive");
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    run.record(&path).expect("a recording");
    run.until(6.0).expect("the drive goes on");
    drop(run);
    record::recover(&path).expect("it is recovered");
    let cars = TableReader::parquet(&Table::Cars.parquet(&path)).expect("a table");
    let of_person: Vec<usize> =
        (0..cars.rows()).filter(|row| cars.ids("car")[*row] == Some(FIRST_OF_EVENTS.0)).collect();
    // A row for each step of 0.1 s.
    assert!((58..=61).contains(&of_person.len()), "{}", of_person.len());
    let speeds = cars.numbers("speed_mps");
    assert_eq!(of_person.last().and_then(|row| speeds[*row]), Some(1.4));
    let mut replay = Replay::open(&path).expect("it can be driven");
    replay.advance(u64::MAX).expect("the drive goes on");
    assert!(replay.report().is_proven() && replay.report().ticks == 600, "{:?}", replay.report());
}
