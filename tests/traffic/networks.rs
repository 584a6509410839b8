//! Networks that are not shipped with the program: SUMO crashes on some of them, which must not end the program.

use super::*;
use codrive::{
    map::network::Network,
    traffic::{
        NativeTraffic, TrafficError,
        sumo::{SumoTraffic, compare_with_sumo},
    },
};
use std::{
    path::Path,
    process::{Command, Output},
    time::{Duration, Instant},
};

/// Returns the time, for limits on durations.
#[allow(clippy::disallowed_methods, reason = "that a wait ends is a matter of wall time")]
fn now() -> Instant {
    Instant::now()
}

/// Returns the ring's network with one attribute changed.
fn changed(from: &str, to: &str) -> String {
    let text = std::fs::read_to_string(RoadMap::load("ring-250").unwrap().net_file).unwrap();
    assert!(text.contains(from), "the ring has no {from}");
    text.replacen(from, to, 1)
}

/// Returns a network on which SUMO 1.28 crashes and in which codrive's reader finds no fault: an actuated signal with a next phase that
/// does not exist.
fn breaks_sumo() -> String {
    let phase = r#"<phase duration="9" minDur="1" maxDur="3" state="G" next="77"/>"#;
    let signal = format!(r#"<tlLogic id="n0" type="actuated" programID="0" offset="0">{phase}</tlLogic>"#);
    changed(r#"<junction id="n0""#, &format!(r#"{signal}<junction id="n0""#))
}

fn written(folder: &Path, text: &str) -> std::path::PathBuf {
    let file = folder.join("net.xml");
    std::fs::write(&file, text).unwrap();
    file
}

fn run_on(net: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_codrive"))
        .args(["run", "--duration", "1", "--map", net.to_str().unwrap()])
        .output()
        .unwrap()
}

/// Returns the setup of the ring on the network in `file`.
fn on(file: &Path) -> FixedSetup {
    FixedSetup { map: Arc::new(RoadMap::load(file.to_str().unwrap()).unwrap()), ..ring(0.0) }
}

#[test]
fn a_foreign_network_is_tried_once_and_then_driven() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path(), &changed("speed=\"", "friction=\"1\" speed=\""));
    let before = now();
    SumoTraffic::start(on(&file)).unwrap().step(&[]).unwrap();
    let first = before.elapsed();
    let before = now();
    SumoTraffic::start(on(&file)).unwrap().step(&[]).unwrap();
    let second = before.elapsed();
    // A process starts for the first and not for the second: it loads SUMO's hundred libraries, 0.1 s at least.
    assert!(second < first && second < Duration::from_millis(500), "{first:?}, then {second:?}");
}

#[test]
fn a_network_that_crashes_sumo_is_an_error_and_the_next_start_works() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path(), &breaks_sumo());
    for _ in 0..2 {
        let error = SumoTraffic::start(on(&file)).err().expect("SUMO breaks down on it");
        let text = error.to_string();
        assert!(matches!(error, TrafficError::Setup(_)), "{text}");
        assert!(text.starts_with(&format!("{}: SUMO crashes on this network (signal: ", file.display())), "{text}");
        assert!(text.contains("remedy"), "{text}");
    }
    SumoTraffic::start(ring(0.0)).unwrap().step(&[]).unwrap();
}

#[test]
fn the_program_reports_a_network_that_crashes_sumo_and_survives() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path(), &breaks_sumo());
    let ended = run_on(&file);
    let text = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(2), "{text}");
    assert!(text.contains("SUMO crashes on this network"), "{text}");
}

#[test]
fn the_reader_of_codrive_refuses_a_network_before_sumo_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path(), &changed("speed=\"", "speed=\"-"));
    let text = RoadMap::load(file.to_str().unwrap()).expect_err("a speed below 0").to_string();
    assert!(text.starts_with(&format!("{}:", file.display())) && text.contains("speed"), "{text}");
    assert!(!text.contains("SUMO cannot drive") && !text.contains("breaks down"), "{text}");
}

#[test]
fn cars_are_put_on_a_lane_for_cars_where_the_outermost_is_a_pavement() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let node = |(id, x, y)| format!("<node id=\"{id}\" x=\"{x}\" y=\"{y}\"/>");
    let nodes: String = [("a", 0, 0), ("b", 120, 0), ("c", 120, 120), ("d", 0, 120)].map(node).concat();
    std::fs::write(place("block.nod.xml"), format!("<nodes>{nodes}</nodes>")).unwrap();
    let edge = |(from, to)| {
        format!(
            "<edge id=\"{from}{to}\" from=\"{from}\" to=\"{to}\" numLanes=\"1\" speed=\"13.9\" sidewalkWidth=\"2\"/>"
        )
    };
    let edges: String = [("a", "b"), ("b", "c"), ("c", "d"), ("d", "a")].map(edge).concat();
    std::fs::write(place("block.edg.xml"), format!("<edges>{edges}</edges>")).unwrap();
    let sumo = Path::new(env!("CARGO_MANIFEST_DIR")).join(".sumo/sumo");
    let mut netconvert = Command::new(sumo.join("bin/netconvert"));
    netconvert.arg("-n").arg(place("block.nod.xml")).arg("-e").arg(place("block.edg.xml"));
    netconvert.arg("-o").arg(place("net.xml")).args(["--no-turnarounds", "true"]).env("SUMO_HOME", &sumo);
    assert!(netconvert.output().unwrap().status.success());
    let setup = even(place("net.xml").to_str().unwrap(), 6, model(0.0), 0.0);
    assert!(setup.map.route.lanes().iter().any(|lane| lane.id(&setup.map.network) == "ab_1"), "ab_0 is the pavement");
    let map = setup.map.clone();
    let mut traffic = SumoTraffic::start(setup).unwrap();
    let history = super::run(&map, &mut traffic, 300, |_, _| None);
    // After 30 s at 1 m/s2 and at most 13.9 m/s, all vehicles are far along the route's lanes.
    assert!(history[300].iter().all(|car| car.speed_mps > 3.0), "{:?}", history[300]);
}

#[test]
fn only_sumo_drives_a_figure_of_eight_and_the_native_engine_refuses() {
    let _alone = alone();
    let net = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/networks/figure-eight.net.xml");
    let setup = || even(net, 6, model(0.0), 0.0);
    let map = setup().map;
    let error = NativeTraffic::start(setup()).expect_err("cars would drive through each other");
    assert!(matches!(error, TrafficError::RouteMeetsItself { .. }), "{error}");
    assert!(error.to_string().contains("--traffic sumo"), "{error}");
    let mut traffic = SumoTraffic::start(setup()).unwrap();
    let history = super::run(&map, &mut traffic, 600, |_, _| None);
    // No two vehicles overlap, also at the crossing: each is 1.8 m wide.
    for cars in &history {
        for (k, car) in cars.iter().enumerate() {
            let middle = |car: &CarState| car.pose.position;
            let apart = |other: &CarState| middle(other).distance(middle(car));
            assert!(cars[..k].iter().all(|other| apart(other) > 1.8), "{cars:?}");
        }
    }
}

#[test]
fn lanes_and_connections_of_every_network_are_as_sumo_reads_them() {
    let _alone = alone();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = |folder: &str| {
        let found = std::fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        found.map(|path| if path.is_dir() { path.join("net.xml") } else { path }).collect::<Vec<_>>()
    };
    let all = [files("tests/data/networks"), files("maps"), files("tests/data")].concat();
    let nets: Vec<_> =
        all.iter().filter(|file| file.is_file() && file.to_string_lossy().ends_with("net.xml")).collect();
    assert!(nets.len() > 20, "{}", nets.len());
    for file in nets {
        let network = Network::load(&file.to_string_lossy()).unwrap();
        let equal = compare_with_sumo(&network, file).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((equal.lanes, equal.connections), (network.lanes().len(), network.connections().len()));
    }
}
