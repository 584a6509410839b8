//! Demands as people have them: additional files, a begin in the middle of the day, persons on foot. The expected values are read off the
//! files by hand.

use super::network::Town;
use codrive::{
    map::network::Network,
    traffic::{Demand, DemandSetup, Traffic, VehicleKind, VehicleState, sumo::SumoTraffic},
};
use std::{fs, path::PathBuf, sync::Arc};

/// Returns a town of a network of `tests/data/networks`, with these files beside it.
fn setup(network: &str, files: &[(&str, &str)], demand: Demand) -> (tempfile::TempDir, DemandSetup) {
    let folder = tempfile::tempdir().expect("a folder");
    let net = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/networks")).join(network);
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let mut demand = demand;
    demand.input_files_mut().for_each(|file| *file = folder.path().join(&file));
    let network = Arc::new(Network::load(net.to_str().expect("plain")).expect("it can be read"));
    let town = Town { folder: tempfile::tempdir().expect("a folder"), net };
    let setup = DemandSetup { network, ..town.setup(demand) };
    (folder, setup)
}

/// Runs steps and returns the vehicles after each.
fn steps(setup: &DemandSetup, seconds: f64) -> Vec<Vec<VehicleState>> {
    let mut traffic = SumoTraffic::start_with_demand(setup).unwrap_or_else(|error| panic!("{error}"));
    let count = (seconds / setup.step_s).round() as usize;
    (0..count)
        .map(|_| {
            traffic.step(&[]).expect("a step");
            traffic.vehicles().to_vec()
        })
        .collect()
}

const BUS: &str = "<routes><vehicle id=\"a\" depart=\"3\"><route edges=\"B0B1 B1C1 C1C2\"/>\
                   <stop busStop=\"bs1\" duration=\"20\"/></vehicle></routes>";

#[test]
fn a_vehicle_stops_at_the_bus_stop_of_an_additional_file() {
    let _alone = super::alone();
    // The outputs would write two files; codrive leaves them out.
    let additional = "<additional><busStop id=\"bs1\" lane=\"B1C1_0\" startPos=\"30\" endPos=\"60\"/>\
                      <edgeData id=\"e\" file=\"edges.xml\"/><e1Detector id=\"d\" lane=\"B1C1_0\" pos=\"5\" file=\"loop.xml\"/></additional>";
    let files = [("bus.rou.xml", BUS), ("stops.add.xml", additional)];
    let demand = Demand {
        files: vec!["bus.rou.xml".into()],
        additional_files: vec!["stops.add.xml".into()],
        ..Demand::default()
    };
    let (folder, setup) = setup("grid-signals.net.xml", &files, demand);
    let lane = setup.network.lane_named("B1C1_0").expect("a lane");
    let stood = steps(&setup, 120.0);
    let at_stop = stood.iter().flatten().filter(|car| car.lane == Some(lane) && car.speed_mps == 0.0);
    let at_stop: Vec<f64> = at_stop.map(|car| car.s_m).collect();
    let stood_s = at_stop.len() as f64 * setup.step_s;
    assert!((19.0..=21.5).contains(&stood_s), "it stands for 20 s: {stood_s} s");
    assert!(at_stop.iter().all(|s_m| (30.0..=60.0).contains(s_m)), "{at_stop:?}");
    let left: Vec<_> = fs::read_dir(folder.path()).expect("a folder").map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
}

#[test]
fn a_drive_begins_at_its_time_of_the_files_or_says_when_the_first_departs() {
    let _alone = super::alone();
    let late = "<routes><trip id=\"early\" depart=\"100\" from=\"B0B1\" to=\"C1C2\"/>\
                <trip id=\"a\" depart=\"25201\" from=\"B0B1\" to=\"C1C2\"/></routes>";
    let demand = |begin_s: f64| Demand { files: vec!["late.rou.xml".into()], begin_s, ..Demand::default() };
    let files = [("late.rou.xml", late)];
    let (_folder, morning) = setup("grid-signals.net.xml", &files, demand(25_200.0));
    let counts: Vec<usize> = steps(&morning, 3.0).iter().map(Vec::len).collect();
    let first = counts.iter().position(|count| *count > 0).expect("it departs");
    let first_s = (first + 1) as f64 * morning.step_s;
    assert!((1.0..=1.3).contains(&first_s) && counts.iter().all(|count| *count <= 1), "{first_s} s");

    let (_folder, night) = setup("grid-signals.net.xml", &files, demand(3_600.0));
    let text = SumoTraffic::start_with_demand(&night).err().expect("nothing departs").to_string();
    assert!(
        text.contains("late.rou.xml: no vehicle departs: the first at 25201 s; the drive begins at 3600 s of the file"),
        "{text}"
    );
    assert!(text.ends_with("remedy: begin_s = 25201 in [demand]"), "{text}");
    let (_folder, over) = setup("grid-signals.net.xml", &files, demand(40_000.0));
    let text = SumoTraffic::start_with_demand(&over).err().expect("nothing departs").to_string();
    assert!(text.contains("no vehicle departs: the last at 25201 s"), "{text}");
}

#[test]
fn persons_cross_at_a_zebra_and_vehicles_stop_for_them() {
    let _alone = super::alone();
    let text = "<routes><flow id=\"f\" begin=\"0\" end=\"100\" period=\"7\" from=\"cb\" to=\"ba\" departSpeed=\"max\"/>\
                <personFlow id=\"p\" begin=\"0\" end=\"100\" period=\"2\" departPos=\"185\"><walk from=\"ab\" to=\"cb\"/></personFlow></routes>";
    let demand = Demand { files: vec!["zebra.rou.xml".into()], ..Demand::default() };
    let (_folder, setup) = setup("zebra.net.xml", &[("zebra.rou.xml", text)], demand);
    let seen = steps(&setup, 60.0);
    let is_person = |one: &&VehicleState| one.body.kind == VehicleKind::Pedestrian;
    // The crossing is from (200, -3.2) to (200, 3.2) and 4 m wide.
    let crosses = |one: &VehicleState| {
        let at = one.pose.position;
        (at.x - 200.0).abs() < 2.0 && at.y.abs() < 3.2
    };
    let crossing = seen.iter().filter(|all| all.iter().filter(is_person).any(crosses)).count();
    assert!(crossing > 100, "a person every 2 s, each 5 s on the crossing: {crossing} of {}", seen.len());
    let persons = seen.iter().flatten().filter(is_person);
    assert!(
        persons.clone().all(|person| person.lane.is_none() && person.speed_mps < 2.0),
        "they walk beside all lanes"
    );
    // Vehicles come from x = 400 and stop before the crossing.
    let vehicles = || seen.iter().flatten().filter(|one| !is_person(one));
    let stops = vehicles().filter(|car| car.speed_mps < 0.1 && (200.0..215.0).contains(&car.pose.position.x)).count();
    assert!(stops > 10, "{stops}");
    let touched = seen.iter().any(|all| {
        let mut persons = all.iter().filter(is_person);
        persons.any(|person| {
            all.iter().filter(|one| !is_person(one)).any(|car| {
                let way = person.pose.position - car.pose.position;
                way.dot(car.pose.forward()).abs() < car.body.length_m / 2.0
                    && way.dot(car.pose.left()).abs() < car.body.width_m / 2.0
            })
        })
    });
    assert!(!touched, "no vehicle drives over a person");
}
