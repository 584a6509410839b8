//! Lanes beside the ego's in a drive: a policy's inputs for vehicles there, and for lane changes of the path.

use super::{
    network::{GRID, drive, driver, flows, policy_that_sees, scenario},
    world::one_at_a_time,
};
use codrive::{
    controls::{Controls, Indicator},
    scenario::Scenario,
    sim::{EventKind, Snapshot, World},
    space::CAR_LENGTH_M,
    traffic::{Demand, Flow},
};

/// Returns the gap from an ego that drives up B0B1 in its outer lane to the next vehicle ahead in the inner lane (x = 91.60 m in the file),
/// by the positions of bodies on the ground. `None` if a vehicle is about to leave that lane or to enter it.
fn gap_by_bodies_m(snapshot: &Snapshot) -> Option<f64> {
    let own_m = snapshot.ego.pose().front(CAR_LENGTH_M).y;
    let on_street = snapshot.cars.iter().filter(|car| car.pose.yaw_rad.sin() > 0.9 && car.pose.position.y < 260.0);
    let beside = on_street.map(|car| (car, (car.pose.position.x - 91.6).abs())).filter(|(_, off_m)| *off_m < 2.6);
    let mut nearest_m = 1000.0_f64;
    for (car, off_m) in beside {
        let front_m = car.pose.front(car.body.length_m).y;
        if off_m > 0.5 {
            return None;
        }
        if front_m >= own_m && front_m - car.body.length_m - own_m < 200.0 {
            nearest_m = nearest_m.min(front_m - car.body.length_m - own_m);
        }
    }
    Some(nearest_m)
}

#[test]
fn a_policy_gets_the_gap_to_the_next_vehicle_in_the_lane_beside() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    // The policy advises 2 m/s at 0 m and 8 m/s at 60 m and beyond.
    let policy = policy_that_sees(folder.path(), "left_leader_gap", 0.0, 60.0);
    let drive = Scenario { policy, hold_s: 1.0, warm_up_s: 40.0, ..scenario("B0B1 B1B2", flows()) };
    let mut world = World::new(&drive).unwrap_or_else(|error| panic!("{error}"));
    let mut driver = driver(&world);
    let (mut compared, mut near) = (0, 0);
    while world.ended().is_none() {
        let is_here = (80.0..150.0).contains(&(world.snapshot().ego.position.y + 70.0));
        let expected = gap_by_bodies_m(world.snapshot()).filter(|_| is_here);
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("a tick");
        for event in world.events() {
            let (EventKind::Advice(advice), Some(gap_m)) = (event.kind, expected) else { continue };
            let expected_mps = (2.0 + gap_m / 10.0).clamp(2.0, 8.0);
            assert!((advice.target_mps - expected_mps).abs() < 0.02, "{:?}: {gap_m} m, {advice:?}", event.tick);
            compared += 1;
            near += u32::from(gap_m < 60.0);
        }
    }
    println!("{compared} compared, {near} with somebody near");
    assert!(compared > 10 && near > 5);
}

#[test]
fn a_policy_gets_distances_to_lines_and_lane_ends_if_they_exist() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    let first_advice_mps = |map: &str, path: &str, feature: &str, to: f64| {
        let policy = policy_that_sees(folder.path(), feature, 0.0, to);
        let map = map.into();
        let drive = Scenario { policy, hold_s: 1.0, path_start_m: 20.0, ..scenario(path, Demand::default()) };
        let mut world =
            World::new(&Scenario { map, standing_start: true, ..drive }).map_err(|error| error.to_string())?;
        world.tick(&Controls::default()).expect("a tick");
        Ok::<f64, String>(world.snapshot().advice.expect("advice").target_mps)
    };
    let (round, town) = ("tests/data/networks/roundabout.net.xml", "tests/data/networks/town.net.xml");
    // The distance to the feature is the middle of the range, where 5 m/s are advised: from the lengths in the files, less 20 m.
    for (map, path, feature, way_m) in [
        (round, "Ss se eE", "yield_distance", 124.07 - 20.0),
        (town, "cn nne", "stop_distance", 104.90 - 20.0),
        (GRID, "B0B1 B1C1 C1C2", "lane_end_distance", 69.20 + 9.03 + 69.20 - 20.0),
    ] {
        let advised_mps = first_advice_mps(map, path, feature, 2.0 * way_m).expect("it drives");
        assert!((advised_mps - 5.0).abs() < 0.01, "{feature}: {advised_mps}");
    }
    let refused = first_advice_mps(round, "Ss se eE", "right_follower_gap", 1.0).expect_err("one lane");
    assert!(refused.contains("`right_follower_gap`, and its path has no lane to the right of its own"), "{refused}");
}

#[test]
fn a_driver_changes_lanes_in_traffic_without_contact_and_indicates() {
    let _alone = one_at_a_time();
    let flow = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 700.0, mix: Vec::new() };
    // All vehicles use B1C1, which the ego enters on the outer lane and must leave on the inner one.
    let demand =
        Demand { flows: vec![flow("A1B1", "C1C2"), flow("A1B1", "C1C0"), flow("B0B1", "C1C2")], ..Demand::default() };
    for seed in 1..=3 {
        let on_grid = scenario("B0B1 B1C1 C1C2", demand.clone());
        let (mut beside, mut indicated) = (0, 0);
        let found = drive(&Scenario { warm_up_s: 60.0, seed, ..on_grid }, |world| {
            let (snapshot, net) = (world.snapshot(), &world.map().network);
            let lane = snapshot.ego_lane.map(|at| net.lane(at.lane).id.as_str());
            // The ego is on the outer lane before the change is over.
            if lane == Some("B1C1_0") && snapshot.ego_s_m > 69.20 + 9.03 + 1.0 {
                indicated += u32::from(snapshot.ego_indicator == Indicator::Left);
                beside += 1;
            }
        });
        println!("seed {seed}: {indicated} of {beside} ticks; {found:?}");
        assert!(beside > 100 && indicated == beside);
        assert_eq!((found.ended, found.contact_count), (Some(codrive::sim::EndReason::PathEnd), 0));
        assert_eq!((found.left_road, found.near_misses), (0, 0));
    }
}
