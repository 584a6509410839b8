//! Tests of whole maps: rings of many lengths, and the shipped maps.

use super::{ring::RingShape, *};
use std::{fs, path::Path};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CODRIVE_ROOT")).join("maps").join(name)
}

fn shipped_ring(name: &str) -> RingShape {
    match name {
        "ring-250" => RingShape { circumference_m: 250.0, speed_limit_mps: 30.0, width_m: 3.6 },
        "ring-260" => RingShape { circumference_m: 260.0, speed_limit_mps: 30.0, width_m: 3.6 },
        "ring-641" => RingShape { circumference_m: 640.9, speed_limit_mps: 17.88, width_m: 4.0 },
        _ => unreachable!("{name}"),
    }
}

/// Compares a committed file with the generator's present result; `CODRIVE_UPDATE_MAPS=1` writes the file instead.
fn compare_with_generator(file: &Path, made: &str) {
    if std::env::var_os("CODRIVE_UPDATE_MAPS").is_some() {
        fs::write(file, made).unwrap();
    }
    let kept = fs::read_to_string(file).unwrap();
    let line = kept.lines().zip(made.lines()).position(|(a, b)| a != b).map(|line| line + 1);
    assert!(kept == made, "{}: line {line:?} is not what the generator makes", file.display());
}

#[test]
fn the_shipped_rings_equal_the_generators_results() {
    for name in ["ring-250", "ring-260", "ring-641"] {
        compare_with_generator(&shipped(name).join("net.xml"), &shipped_ring(name).net_xml().unwrap());
    }
}

#[test]
fn the_practice_circuit_equals_the_result_of_its_list_of_pieces() {
    let folder = tempfile::tempdir().unwrap();
    let made = folder.path().join("made");
    circuit::write(&made, &shipped("practice").join("circuit.toml")).unwrap();
    // Shipped files also name their schema.
    let schema = "#:schema ../../assets/schemas/map.schema.json\n";
    for (file, head) in [("net.xml", ""), ("map.toml", schema)] {
        let made = fs::read_to_string(made.join(file)).unwrap();
        compare_with_generator(&shipped("practice").join(file), &format!("{head}{made}"));
    }
}

#[test]
fn the_practice_circuit_has_smooth_bends_of_many_radii_to_both_sides() {
    let route = RoadMap::load("practice").unwrap().route;
    assert!((1000.0..2000.0).contains(&route.length_m()), "{}", route.length_m());
    let curvatures: Vec<f64> =
        (0..(route.length_m() * 2.0) as usize).map(|i| route.curvature_at(i as f64 * 0.5, 2.0)).collect();
    let (right, left) = curvatures.iter().fold((0.0, 0.0), |(low, high), k| (k.min(low), k.max(high)));
    assert!((1.0 / left - 25.0).abs() < 0.1 && (1.0 / right + 40.0).abs() < 0.1, "{left} {right}");
    let straight = curvatures.iter().filter(|k| k.abs() < 1e-4).count() as f64 / curvatures.len() as f64;
    assert!((0.2..0.5).contains(&straight), "straight share {straight}");
    // The tightest easing goes to 1/25 m in 16 m: 0.00125 1/m in each half metre. Headings are interpolated between the middles of chords
    // of c = 0.84 m, wrong by up to 0.0025 c^2 / 8 = 0.00022 rad, which a window of 2 m turns into 0.00011.
    let limit = 0.00125 + 2.0 * 0.00011;
    for (i, pair) in curvatures.windows(2).enumerate() {
        assert!((pair[1] - pair[0]).abs() < limit, "jerk at {} m: {pair:?}", i as f64 * 0.5);
    }
    // Declared lengths are those of the curve, not of its chords.
    let chords_m: f64 = route.lanes().iter().flat_map(|l| l.shape.windows(2)).map(|p| p[0].distance(p[1])).sum();
    assert!((0.0..0.2).contains(&(route.length_m() - chords_m)), "{} {chords_m}", route.length_m());
}

#[test]
fn a_circuit_that_cannot_be_built_reports_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("circuit.toml");
    let text = fs::read_to_string(shipped("practice").join("circuit.toml")).unwrap();
    let message = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        fs::write(&file, text.replacen(from, to, 1)).unwrap();
        circuit::make(&file).map(|made| made.title).unwrap_err().to_string()
    };
    let expect = |message: String, parts: &[&str]| {
        parts.iter().for_each(|part| assert!(message.contains(part), "{part:?} is not in: {message}"));
    };
    expect(message("turn_deg = 90", "turn_deg = 91"), &["circuit.toml", "361 degrees", "360"]);
    expect(
        message("solved = true\n\n[[piece]]\nradius_m = 80", "straight_m = 20\n\n[[piece]]\nradius_m = 80"),
        &["1 pieces have solved = true"],
    );
    // Pieces 9 and 12 both lead south.
    let parallel =
        text.replacen("\nsolved = true", "\nstraight_m = 20", 1).replacen("\nstraight_m = 40", "\nsolved = true", 1);
    fs::write(&file, parallel).unwrap();
    expect(
        circuit::make(&file).map(|made| made.title).unwrap_err().to_string(),
        &["pieces 9 and 12, are nearly parallel"],
    );
    expect(message("straight_m = 110", "straight_m = 50"), &["piece 12", "-39.8 m long to close"]);
    expect(message("radius_m = 60", "radius_m = nan"), &["circuit.toml:14:12: piece 2: radius_m is NaN", "10 to 5000"]);
    expect(message("radius_m = 60", "radius_m = \"60\""), &["circuit.toml:14:12: invalid type: string", "^^^^"]);
    expect(
        message("radius_m = 60", "radios_m = 60"),
        &["circuit.toml:14:1: unknown key `radios_m`; did you mean `radius_m`?", " ^^^^^^^^"],
    );
    expect(message("easing_m = 25", "easing_m = 95"), &["easing_m is 95", "94.2"]);
    expect(message("easing_m = 25\n", "straight_m = 3\n"), &["piece 2", "either straight_m"]);
}

#[test]
fn all_mistakes_of_a_circuit_are_in_one_report() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("circuit.toml");
    let text = "title = \"a\"\ndescription = \"b\"\nwidth_m = 1\nspeed_limit_mps = 20\n[[piece]]\nstraight_m = 5\n[[piece]]\n\
                radius_m = 5\nturn_deg = 300\neasing_m = 20\n[[piece]]\nsolved = 1\n[[piece]]\nstraigth_m = 50\n[[piece]]\nturn_deg = 9\n";
    fs::write(&file, text).unwrap();
    let report = circuit::make(&file).unwrap_err().to_string();
    let places: Vec<&str> = report.lines().filter_map(|line| Some(line.split_once("circuit.toml:")?.1)).collect();
    let wanted = [
        "3:11: width_m is 1",
        "6:14: piece 1: straight_m is 5",
        "8:12: piece 2: radius_m is 5",
        "9:12: piece 2: turn_deg is 300",
        "12:10: invalid type: integer `1`",
        "14:1: unknown key `straigth_m`",
        "15:1: piece 5: a piece has either straight_m",
    ];
    assert!(
        places.len() == wanted.len() && places.iter().zip(wanted).all(|(one, begin)| one.starts_with(begin)),
        "{report}"
    );
}

#[test]
fn rings_of_any_length_add_up_and_lie_on_their_circle() {
    for circumference_m in [150.0, 250.0, 640.9, 1234.5, 5000.0] {
        let folder = tempfile::tempdir().unwrap();
        let ring = RingShape { circumference_m, speed_limit_mps: 30.0, width_m: 3.6 };
        ring::write(&folder.path().join("r"), &ring, "A \"ring\"", "").unwrap();
        let map = RoadMap::load(folder.path().join("r").to_str().unwrap()).unwrap();
        assert_eq!((map.name.as_str(), map.title.as_str()), ("r", "A \"ring\""));
        assert!((map.route.length_m() - circumference_m).abs() < 1e-3, "{}", map.route.length_m());
        let radius_m = circumference_m / std::f64::consts::TAU;
        for i in 0..10_000 {
            let s_m = circumference_m * f64::from(i) / 10_000.0;
            let off = map.route.point_at(s_m).length() - radius_m;
            assert!(off < 2e-6 && off > -0.004, "{circumference_m} {s_m} {off}");
            assert!((map.route.curvature_at(s_m, 4.0) * radius_m - 1.0).abs() < 1e-3, "{circumference_m} {s_m}");
        }
        let (centre, radius) = map.bounds();
        assert!(centre.length() < 1e-6 && (radius - radius_m).abs() < 1e-5);
    }
}

#[test]
fn a_ring_out_of_range_is_refused_with_the_range() {
    let ring =
        |circumference_m, speed_limit_mps| RingShape { circumference_m, speed_limit_mps, width_m: 3.6 }.net_xml();
    let message = |made: Result<String, MapError>| made.unwrap_err().to_string();
    assert_eq!(message(ring(149.9, 30.0)), "circumference is 149.9; allowed: 150 to 5000 m");
    assert_eq!(message(ring(f64::NAN, 30.0)), "circumference is NaN; allowed: 150 to 5000 m");
    assert_eq!(message(ring(250.0, -1.0)), "speed limit is -1; allowed: 1 to 100 m/s");
}

#[test]
fn every_shipped_map_loads_closes_and_round_trips() {
    let maps = list();
    assert!(maps.len() >= 4, "{maps:?}");
    for info in maps {
        let map = RoadMap::load(&info.name).unwrap();
        assert!(!info.title.is_empty() && !info.description.is_empty(), "{info:?}");
        let route = &map.route;
        let lanes = route.lanes();
        assert_eq!(
            route.is_closed(),
            !["bottleneck", "grid", "lane-10km", "merge", "motorway", "town"].contains(&info.name.as_str()),
            "{}",
            info.name
        );
        let joints = lanes.len() - usize::from(!route.is_closed());
        for (k, lane) in lanes.iter().enumerate().take(joints) {
            let next = &lanes[(k + 1) % lanes.len()];
            let gap_m = lane.shape[lane.shape.len() - 1].distance(next.shape[0]);
            assert!(
                gap_m < 1e-3,
                "{}: {} ends {gap_m} m from {}",
                map.name,
                lane.id(&map.network),
                next.id(&map.network)
            );
            let on_m = (lane.length_m / 2.0).min(1.0);
            assert_eq!(route.s_on(lane.lane.unwrap(), on_m), Some(lane.start_s_m + on_m));
        }
        for i in 0..2000 {
            let s_m = route.length_m() * f64::from(i) / 2000.0;
            for offset_m in [-1.5, 0.0, 1.5] {
                let left = DVec2::from_angle(route.yaw_at(s_m)).perp();
                let found = route.project(route.point_at(s_m) + left * offset_m, Some(s_m));
                assert!(route.difference(found.s_m, s_m).abs() < 0.05, "{} {s_m} {found:?}", map.name);
                assert!((found.offset_m - offset_m).abs() < 0.005, "{} {s_m} {found:?}", map.name);
            }
        }
    }
}

#[test]
fn the_merge_has_the_dimensions_of_flow_and_its_main_road_yields() {
    let map = RoadMap::load("merge").unwrap();
    let network = &map.network;
    // flow/networks/merge.py and flow/benchmarks/merge0.py: 500 + 100 m of main road, 100 m of ramp, 100 m before each, 30 m/s.
    let edges =
        [("inflow_highway", 100.0), ("left", 500.0), ("center", 100.0), ("inflow_merge", 100.0), ("bottom", 100.0)];
    for (edge, length_m) in edges {
        let lane = network.lane(network.lane_named(&format!("{edge}_0")).unwrap());
        assert_eq!((lane.length_m, lane.speed_limit_mps), (length_m, 30.0), "{edge}");
        assert!(network.lane_named(&format!("{edge}_1")).is_none(), "{edge} has one lane");
    }
    let streets: Vec<&str> =
        map.route.lanes().iter().map(|lane| lane.edge_id(&map.network)).filter(|edge| !edge.starts_with(':')).collect();
    assert_eq!(streets, ["inflow_highway", "left", "center"]);
    let demand = fs::read_to_string(map.demand_file().unwrap()).unwrap();
    assert!(demand.contains("vehsPerHour=\"2000\" from=\"inflow_highway\" to=\"center\""), "{demand}");
    assert!(demand.contains("vehsPerHour=\"100\" from=\"inflow_merge\" to=\"center\""), "{demand}");
    assert_eq!(RoadMap::load("practice").unwrap().demand_file(), None);
    // Links of the junction in the order of its file: the ramp's, then the main road's. SUMO's bits are read from the right.
    let text = fs::read_to_string(&map.net_file).unwrap();
    assert!(
        text.contains("<request index=\"0\" response=\"00\"") && text.contains("<request index=\"1\" response=\"01\"")
    );
}

#[test]
fn sumo_drives_exactly_one_lap_of_the_networks_written_here() {
    let sumo = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo");
    assert!(sumo.join("bin/sumo").is_file(), "{}: run scripts/setup first", sumo.display());
    let folder = tempfile::tempdir().unwrap();
    let by_netconvert = ["bottleneck", "figure-eight", "grid", "merge", "motorway", "town", "two-lane-ring"];
    let written_here = list().into_iter().filter(|map| !by_netconvert.contains(&map.name.as_str()));
    let mut nets: Vec<PathBuf> = written_here.map(|map| map.folder.join("net.xml")).collect();
    for circumference_m in [150.0, 5000.0] {
        let ring = RingShape { circumference_m, speed_limit_mps: 30.0, width_m: 3.6 };
        nets.push(folder.path().join(format!("{circumference_m}.net.xml")));
        fs::write(&nets[nets.len() - 1], ring.net_xml().unwrap()).unwrap();
    }
    for net in nets {
        let map = RoadMap::load(net.to_str().unwrap()).unwrap();
        let edges: Vec<&str> = map.route.lanes().iter().map(|lane| lane.edge_id(&map.network)).collect();
        let (routes, trips) = (folder.path().join("lap.rou.xml"), folder.path().join("trips.xml"));
        let lap = format!(
            "<routes><vehicle id=\"v\" depart=\"0\" departPos=\"0\" arrivalPos=\"max\"><route edges=\"{}\"/></vehicle></routes>",
            edges.join(" ")
        );
        fs::write(&routes, lap).unwrap();
        let mut run = std::process::Command::new(sumo.join("bin/sumo"));
        run.arg("-n").arg(&net).arg("-r").arg(&routes).arg("--tripinfo-output").arg(&trips).env("SUMO_HOME", &sumo);
        run.args(["--no-step-log", "true", "--xml-validation", "never", "--precision", "6"]);
        let done = run.output().unwrap();
        let words = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.success() && words.is_empty(), "{}: {words}", net.display());
        let trips = fs::read_to_string(&trips).unwrap();
        let trips = roxmltree::Document::parse(&trips).unwrap();
        let trip = trips.descendants().find(|node| node.has_tag_name("tripinfo")).unwrap();
        let driven_m: f64 = trip.attribute("routeLength").unwrap().parse().unwrap();
        assert!((driven_m - map.route.length_m()).abs() < 1e-5, "{}: {driven_m}", net.display());
    }
}
