//! Persons on foot, and vehicles at other heights, around the ego: what a simulated driver does about them.

use super::{network::drive, world::one_at_a_time};
use codrive::{
    scenario::Scenario,
    sim::World,
    traffic::{Demand, VehicleKind},
};
use std::{fs, path::Path};

/// Returns a drive on a network of `tests/data/networks` along a path, with this demand.
pub(super) fn scenario(folder: &Path, net: &str, path: &str, text: &str) -> Scenario {
    let file = folder.join("demand.rou.xml");
    fs::write(&file, text).expect("written");
    Scenario {
        map: format!("tests/data/networks/{net}.net.xml"),
        path: path.into(),
        demand: Demand { files: vec![file], ..Demand::default() },
        duration_s: 60.0,
        policy: "none".into(),
        ..Scenario::default()
    }
}

#[test]
fn a_driver_stops_before_a_zebra_while_persons_cross_and_touches_none() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    // A group of persons who begin 15 m before the zebra and cross it one after the other.
    let text = "<routes><personFlow id=\"p\" begin=\"0\" end=\"30\" period=\"1.5\" departPos=\"185\"><walk from=\"ab\" to=\"cb\"/>\
                </personFlow></routes>";
    let scenario = scenario(folder.path(), "zebra", "ab bc", text);
    let (mut stood, mut crossed, mut nearest_m) = (0, 0, f64::INFINITY);
    let summary = drive(&scenario, |world: &World| {
        let snapshot = world.snapshot();
        let ego = snapshot.ego.pose();
        let is_on_zebra = |at: glam::DVec2| (at.x - 200.0).abs() < 2.0 && at.y.abs() < 3.2;
        crossed += usize::from(snapshot.persons().any(|person| is_on_zebra(person.pose.position)));
        // The lane ends at 198 m.
        stood += usize::from(snapshot.ego.speed_mps < 0.2 && (190.0..=198.5).contains(&ego.front(5.0).x));
        for person in snapshot.persons() {
            assert_eq!(person.body.kind, VehicleKind::Pedestrian);
            let way = person.pose.position - ego.position;
            let (ahead_m, beside_m) = (way.dot(ego.forward()).abs() - 2.5, way.dot(ego.left()).abs() - 0.9);
            nearest_m = nearest_m.min(ahead_m.max(beside_m));
        }
        let all = snapshot.speeds_mps().count();
        assert_eq!(all, 1, "persons are no part of the mean speed of vehicles");
    });
    assert!(crossed > 500, "a person is on the zebra for 30 s: {crossed} ticks");
    assert!(stood > 200, "the driver waits before the zebra: {stood} ticks");
    assert!(summary.contacts.is_empty() && nearest_m > 0.3, "{} contacts, {nearest_m} m", summary.contacts.len());
    assert!(summary.ended.is_some(), "and drives on to the end of its path");
}

#[test]
fn a_vehicle_on_a_bridge_above_the_path_is_nobodys_leader() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    // It stops on the bridge, 7 m above the ego's lane, with its rear still over it.
    let text = "<routes><vehicle id=\"a\" depart=\"0\" departSpeed=\"max\"><route edges=\"over\"/>\
                <stop lane=\"over_0\" endPos=\"299.6\" duration=\"120\"/></vehicle></routes>";
    let scenario = scenario(folder.path(), "bridge", "under", text);
    let (mut slowest_mps, mut was_above) = (f64::INFINITY, false);
    drive(&scenario, |world: &World| {
        let snapshot = world.snapshot();
        assert!(snapshot.leader.is_none(), "{:?} at {} s", snapshot.leader, world.time_s());
        was_above |= snapshot.cars.iter().any(|car| car.speed_mps == 0.0 && car.height_m > 6.9);
        if (250.0..350.0).contains(&snapshot.ego_s_m) {
            slowest_mps = slowest_mps.min(snapshot.ego.speed_mps);
        }
    });
    assert!(was_above && slowest_mps > 12.0, "it passes at the limit of 13.9 m/s: {slowest_mps}");
}
