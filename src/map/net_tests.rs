//! Tests of reading networks: made by netconvert, with and without internal lanes, and corrupt ones.

use super::*;
use std::{fs, path::Path};

/// Two networks of the same roads, made by netconvert: with internal lanes, and without.
const FIXTURES: [&str; 2] = ["junctions-inside.net.xml", "junctions-none.net.xml"];

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CODRIVE_ROOT")).join("tests/data").join(name)
}

fn load(path: &Path) -> Result<RoadMap, MapError> {
    RoadMap::load(path.to_str().unwrap())
}

fn bounds(seconds: u64) -> import::ImportOptions<'static> {
    static STOP: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
    import::ImportOptions { seconds, memory_mib: import::MEMORY_MIB, stop: &STOP, side: None }
}

/// Loads one of [`FIXTURES`] with its loop as the route; entering `ab` needs a lane change, so it is not the default.
fn load_loop(name: &str) -> RoadMap {
    let edges = ["ab", "bc", "cd", "da"].map(str::to_owned);
    let chosen = loop_search::ChosenEdges { edges: &edges, closed: true };
    RoadMap::read(&fixture(name), &fs::read_to_string(fixture(name)).unwrap(), Some(chosen)).unwrap()
}

/// Returns the edges of the route outside junctions, in order.
fn edges(map: &RoadMap) -> Vec<&str> {
    let streets = map.route.lanes().iter().filter(|lane| lane.is_street(&map.network));
    streets.map(|lane| lane.edge_id(&map.network)).collect()
}

/// Asserts that the road can be driven: it has no jumps and no kinks.
fn assert_drivable(map: &RoadMap) {
    let route = &map.route;
    let n = (route.length_m() * 4.0) as usize;
    for i in 0..n {
        let (a, b) = (route.length_m() * i as f64 / n as f64, route.length_m() * (i + 1) as f64 / n as f64);
        let step_m = route.point_at(a).distance(route.point_at(b));
        // Declared lengths and shapes differ where a junction has no internal lanes: 0.25 m become at most 0.35.
        assert!(step_m < 0.35, "{}: {step_m} m in 0.25 m at {a}", map.name);
        let turn = crate::space::wrap_angle(route.yaw_at(b) - route.yaw_at(a));
        assert!(turn.abs() < 0.35, "{}: turns by {turn} at {a}", map.name);
    }
}

#[test]
fn the_longest_loop_is_found_with_and_without_internal_lanes() {
    for name in FIXTURES {
        let map = load_loop(name);
        assert_eq!(edges(&map), ["ab", "bc", "cd", "da"], "{name}");
        assert_eq!(map.name, name.trim_end_matches(".net.xml"));
        assert_drivable(&map);
    }
    let inside = load_loop(FIXTURES[0]);
    let ids: Vec<&str> = inside.route.lanes().iter().map(|lane| lane.id(&inside.network)).collect();
    // `ab` is entered on its left lane and left on the right one; two internal lanes lie in junction a.
    assert_eq!(ids, ["ab_0", ":b_0_0", "bc_0", ":c_0_0", "cd_0", ":d_0_0", "da_0", ":a_1_0", ":a_7_0"]);
    let declared_m = 69.17 + 11.44 + 46.50 + 14.58 + 69.17 + 11.93 + 51.30 + 5.87 + 10.08;
    assert!((inside.route.length_m() - declared_m).abs() < 1e-9, "{}", inside.route.length_m());
    let s_on = |lane: &str| inside.route.s_on(inside.network.lane_named(lane).unwrap(), 7.0);
    assert_eq!(s_on("ab_0"), Some(7.0));
    assert_eq!([s_on("ab_1"), s_on("ac_0")], [None, None], "a lane beside the route's, and one off the route");
}

#[test]
fn in_a_junction_the_limit_of_its_streets_counts() {
    // Its streets have 13.90 m/s, the lanes within its junctions 7.24 to 8.45 m/s.
    let map = load_loop(FIXTURES[0]);
    let mids = map.route.lanes().iter().map(|lane| lane.start_s_m + lane.length_m / 2.0);
    let [slowest, street] = mids.fold([f64::INFINITY; 2], |[slowest, street], s_m| {
        [slowest.min(map.route.speed_limit_mps(s_m)), street.min(map.street_limit_mps(s_m))]
    });
    assert_eq!([slowest, street], [7.24, 13.9]);
    // The faster street does not count.
    let text = fs::read_to_string(fixture(FIXTURES[0])).unwrap();
    let (before, after) = text.split_once("<lane id=\"bc_0\"").unwrap();
    let slow = format!("{before}<lane id=\"bc_0\"{}", after.replacen("speed=\"13.90\"", "speed=\"10.00\"", 1));
    let edges = ["ab", "bc", "cd", "da"].map(str::to_owned);
    let chosen = loop_search::ChosenEdges { edges: &edges, closed: true };
    let map = RoadMap::read(&fixture(FIXTURES[0]), &slow, Some(chosen)).unwrap();
    let at = |lane: &str| map.street_limit_mps(map.route.s_on(map.network.lane_named(lane).unwrap(), 1.0).unwrap());
    assert_eq!(["ab_0", ":b_0_0", "bc_0", ":c_0_0", "cd_0"].map(at), [13.9, 10.0, 10.0, 10.0, 13.9]);
}

#[test]
fn a_chosen_route_is_driven_and_mistakes_in_it_are_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(fixture(FIXTURES[0]), folder.path().join("net.xml")).unwrap();
    let with = |route: &str| {
        fs::write(folder.path().join("map.toml"), format!("title = \"T\"\n{route}\n")).unwrap();
        load(folder.path())
    };
    let map = with("route = [\"da\", \"ac\", \"cd\"]").unwrap();
    assert_eq!((edges(&map), map.title.as_str()), (vec!["da", "ac", "cd"], "T"));
    assert_drivable(&map);
    assert_eq!(load(&folder.path().join("net.xml")).unwrap().route, map.route, "the file of a map is that map");
    for (route, expected) in [
        ("route = [\"da\", \"xy\"]", "edge \"xy\" does not exist; edges of this network: ab, ac, ae, bc"),
        ("route = [\"da\", \"ac\", \"da\"]", "edge \"da\" is named twice"),
        ("route = [\"da\", \"ab\", \"cd\"]", "cannot go on from edge \"ab\" to \"cd\""),
        ("route = [\"ab\", \"bc\"]", "cannot go on from edge \"bc\" to \"ab\""),
        ("route = []", "the route of map.toml names no edge"),
        ("rout = []", "map.toml:2:1: unknown key `rout`; did you mean `route`?"),
        ("title = 3", "duplicate key"),
    ] {
        let message = with(route).unwrap_err().to_string();
        assert!(message.contains(expected), "{expected:?} is not in: {message}");
    }
}

#[test]
fn the_inside_of_a_junction_without_extent_is_a_point_that_counts() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.net.xml");
    let lane = |id: &str, length: f64, shape: &str| {
        format!("<lane id=\"{id}\" index=\"0\" speed=\"9\" length=\"{length}\" shape=\"{shape}\"/></edge>")
    };
    let text = format!(
        "<net><edge id=\":n\" function=\"internal\">{}<edge id=\"e\" from=\"n\" to=\"n\">{}<connection from=\"e\" \
         to=\"e\" fromLane=\"0\" toLane=\"0\" via=\":n_0\"/><connection from=\":n\" to=\"e\" fromLane=\"0\" \
         toLane=\"0\"/></net>",
        lane(":n_0", 0.1, "0,0,5 0,0,5"),
        lane("e_0", 40.0, "0,0,5 10,0,5 10,10,6 0,10,6 0,0,5"),
    );
    fs::write(&file, text).unwrap();
    let map = load(&file).unwrap();
    assert!((map.route.length_m() - 40.1).abs() < 1e-12);
    assert!(map.route.point_at(40.05).length() < 1e-3);
    assert_eq!(map.route.width_m(1.0), 3.2, "SUMO's width where none is given");
}

#[test]
fn a_long_value_that_is_refused_is_quoted_by_its_beginning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("long.net.xml");
    let good = fs::read_to_string(fixture(FIXTURES[0])).unwrap();
    // 1,000 points of 4 characters, and one malformed point.
    let shape = "1,2 ".repeat(1000) + "x";
    fs::write(&file, good.replacen("141.60,5.50 141.60,52.00", &shape, 1)).unwrap();
    let message = load(&file).unwrap_err().to_string();
    assert!(
        message.contains(&format!("shape is \"{}...\" (4001 characters); allowed", "1,2 ".repeat(25))),
        "{message}"
    );
    assert!(message.len() < 500, "{} bytes", message.len());
}

#[test]
fn a_corrupt_network_is_refused_with_file_line_value_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.net.xml");
    let good = fs::read_to_string(fixture(FIXTURES[0])).unwrap();
    let message = |text: &str| {
        fs::write(&file, text).unwrap();
        load(&file).unwrap_err().to_string()
    };
    let line_of = |what: &str| good.lines().position(|line| line.contains(what)).unwrap() + 1;
    let lane = line_of("id=\"bc_0\"");
    let link = line_of("from=\"ab\" to=\"bc\"");
    let cases = [
        (
            "length=\"46.50\"",
            "length=\"0\"",
            lane,
            "lane \"bc_0\": length is \"0\"; allowed: a number from 0.001 to 100000 m",
        ),
        ("length=\"46.50\"", "length=\"nan\"", lane, "length is \"nan\""),
        ("length=\"46.50\"", "", lane, "length is absent"),
        ("141.60,5.50 141.60,52.00", "", lane, "lane \"bc_0\": shape is \"\"; allowed: two or more different points"),
        ("141.60,5.50 141.60,52.00", "141.60,5.50", lane, "shape is \"141.60,5.50\""),
        ("141.60,5.50 141.60,52.00", "1,2 1,2", lane, "shape is \"1,2 1,2\""),
        ("141.60,5.50 141.60,52.00", "1,2 inf,2", lane, "shape is \"1,2 inf,2\""),
        ("141.60,5.50 141.60,52.00", "1,2 3;4", lane, "shape is \"1,2 3;4\""),
        ("via=\":b_0_0\"", "via=\":z\"", link, "via is \":z\"; allowed: the id of a lane of this network"),
        ("from=\"ab\" to=\"bc\" fromLane=\"0\"", "from=\"ab\" to=\"bc\" fromLane=\"7\"", link, "fromLane is \"7\""),
        ("from=\"ab\" to=\"bc\" fromLane", "from=\"ab\" to=\"zz\" fromLane", link, "to is \"zz\""),
    ];
    for (from, to, line, expected) in cases {
        assert!(good.contains(from), "{from}");
        let message = message(&good.replacen(from, to, 1));
        let place = format!("bad.net.xml:{line}: ");
        assert!(message.contains(&place) && message.contains(expected), "{place:?}, {expected:?}: {message}");
    }
    let cut = message(&good[..good.len() / 2]);
    assert!(cut.contains("bad.net.xml:") && cut.contains("this is not XML") && cut.contains("remedy"), "{cut}");
    assert!(message("").contains("this is not XML"));
    let other = message("<?xml version=\"1.0\"?>\n<routes/>");
    assert!(other.contains("bad.net.xml:2: the root element is <routes>"), "{other}");
    assert!(message("<net/>").contains("no road for cars: the network has no street"));
    let without = fs::read_to_string(fixture(FIXTURES[1])).unwrap();
    let closes =
        |line: &str| line.contains("<connection") && (line.contains("to=\"ea\"") || line.contains("to=\"da\""));
    // A network without a loop has an open route, and is not an error.
    fs::write(&file, without.lines().filter(|line| !closes(line)).collect::<Vec<_>>().join("\n")).unwrap();
    assert!(!load(&file).unwrap().route.is_closed());
    fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    assert!(load(&file).unwrap_err().to_string().contains("not UTF-8"));
}

#[test]
fn an_unknown_map_is_reported_with_the_maps_that_exist() {
    let message = RoadMap::load("ring-25").unwrap_err().to_string();
    assert!(
        message.contains(
            "there is no map \"ring-25\" (did you mean ring-250?); maps here: bottleneck, figure-eight, grid, lane-10km, merge, motorway, practice, ring-250, ring-260, ring-641, town, two-lane-ring"
        ),
        "{message}"
    );
    let message = RoadMap::load("some/where.net.xml").unwrap_err().to_string();
    assert!(message.starts_with("some/where.net.xml: there is no such file"), "{message}");
    assert!(RoadMap::load("maps/../nowhere").is_err());
}

#[test]
fn a_large_grid_is_searched_in_bounded_time_with_the_same_result() {
    // 12 x 12 crossings, streets in both directions, all turns: 528 edges.
    let mut text = String::from("<net>");
    let mut edges = Vec::new();
    for i in 0..12i32 {
        for j in 0..12i32 {
            for (di, dj) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
                let (a, b) = (i + di, j + dj);
                if (0..12).contains(&a) && (0..12).contains(&b) {
                    // Lanes end 10 m before the middle of a crossing, so that a car can turn there.
                    let (x, y) = (i * 50 + di * 10, j * 50 + dj * 10);
                    let shape = format!("{x},{y} {},{}", x + di * 30, y + dj * 30);
                    text += &format!(
                        "<edge id=\"{i}.{j}-{a}.{b}\" to=\"{a}.{b}\"><lane id=\"{i}.{j}-{a}.{b}_0\" speed=\"9\" \
                         length=\"50\" shape=\"{shape}\"/></edge>"
                    );
                    edges.push(((i, j), (a, b)));
                }
            }
        }
    }
    for (from, at) in &edges {
        for (_, to) in edges.iter().filter(|(start, _)| start == at) {
            let ((i, j), (a, b), (x, y)) = (from, at, to);
            let dir = if from == to { "t" } else { "s" };
            text += &format!(
                "<connection from=\"{i}.{j}-{a}.{b}\" to=\"{a}.{b}-{x}.{y}\" fromLane=\"0\" toLane=\"0\" dir=\"{dir}\"/>"
            );
        }
    }
    text += "</net>";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("grid.net.xml");
    fs::write(&file, text).unwrap();
    let map = load(&file).unwrap();
    assert!(map.route.length_m() >= 2000.0, "{}", map.route.length_m());
    assert_eq!(map, load(&file).unwrap());
}

#[test]
fn osm_opendrive_and_sumo_files_are_imported_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let sumo = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo");
    let netconvert = sumo.join("bin/netconvert");
    assert!(netconvert.is_file(), "{}: run scripts/setup first", netconvert.display());
    let maps = folder.path().join("maps");
    let import = |file: &Path, name: &str| {
        import::import_into(&maps, &netconvert, file, name, &bounds(60)).and_then(|made| made.map)
    };

    let osm = folder.path().join("block.osm");
    let block = |ways: &str| {
        let corner = |id, lat, lon| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\"/>");
        let corners =
            [corner(1, 52.0, 13.0), corner(2, 52.0, 13.003), corner(3, 52.002, 13.003), corner(4, 52.002, 13.0)];
        let way = format!("<way id=\"10\">{ways}<tag k=\"highway\" v=\"residential\"/></way>");
        fs::write(&osm, format!("<osm version=\"0.6\">{}{way}</osm>", corners.concat())).unwrap();
    };
    let nodes = |ids: &[u32]| ids.iter().map(|id| format!("<nd ref=\"{id}\"/>")).collect::<String>();
    block(&nodes(&[1, 2, 3, 4, 1]));
    let map = import(&osm, "block").unwrap();
    // 0.002 degrees of latitude are 222.5 m, 0.003 of longitude at 52 degrees 206 m; the corners are cut.
    assert!((780.0..870.0).contains(&map.route.length_m()), "{}", map.route.length_m());
    assert_drivable(&map);
    assert_eq!(map.title, "block");

    let ring = fs::read_to_string(Path::new(env!("CODRIVE_ROOT")).join("maps/ring-250/net.xml")).unwrap();
    let (net, xodr) = (folder.path().join("ring.net.xml"), folder.path().join("ring.xodr"));
    fs::write(&net, ring).unwrap();
    assert_eq!(import(&net, "copy").unwrap().route.length_m(), 250.0);
    let mut export = std::process::Command::new(&netconvert);
    export.arg("-s").arg(&net).arg("--opendrive-output").arg(&xodr).args(["--no-warnings", "true"]);
    assert!(export.env("SUMO_HOME", &sumo).output().unwrap().status.success());
    let map = import(&xodr, "drive").unwrap();
    assert!((map.route.length_m() - 250.0).abs() < 1.0, "{}", map.route.length_m());
    assert_drivable(&map);

    let message = |made: Result<RoadMap, MapError>| made.map(|map| map.name).unwrap_err().to_string();
    assert!(message(import(&net, "copy")).contains("this map exists already"));
    assert!(message(import(&net, "../copy")).contains("the map's name is \"../copy\"; allowed: letters"));
    assert!(message(import(&folder.path().join("no.osm"), "no")).contains("there is no such file"));
    assert!(message(import(&folder.path().join("maps/copy/map.toml"), "no")).contains("allowed: a file .xodr"));
    fs::write(&osm, "<osm version=\"0.6\"><node id=").unwrap();
    assert!(message(import(&osm, "no")).contains("block.osm: netconvert failed: "));
    let absent = import::import_into(&maps, Path::new("nowhere/netconvert"), &osm, "no", &bounds(60));
    assert!(
        message(absent.and_then(|made| made.map))
            .contains("netconvert is not at nowhere/netconvert\n  remedy: run scripts/setup")
    );
    let text = fs::read_to_string(&net).unwrap();
    let open: String = text.lines().filter(|line| !line.contains("<connection from=\"e3\"")).collect();
    fs::write(&net, open).unwrap();
    // A ring that was cut open is a road of the same length.
    let cut = import::import_into(&maps, &netconvert, &net, "cut", &bounds(60)).unwrap().report;
    assert_eq!((cut.path.0.round(), cut.path.2), (250.0, false));
    let mut left: Vec<_> = fs::read_dir(&maps).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["block", "copy", "cut", "drive"]);
}

#[test]
fn heights_that_an_open_street_map_states_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let netconvert = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo/bin/netconvert");
    let osm = folder.path().join("hill.osm");
    let node = |id, lat, lon, ele: &str| format!("<node id=\"{id}\" lat=\"{lat}\" lon=\"{lon}\">{ele}</node>");
    let write = |ele: &dyn Fn(f64) -> String| {
        let corners = [
            node(1, 52.0, 13.0, &ele(30.0)),
            node(2, 52.0, 13.003, &ele(42.0)),
            node(3, 52.002, 13.003, &ele(55.0)),
            node(4, 52.002, 13.0, &ele(42.0)),
        ];
        let nodes: String = [1, 2, 3, 4, 1].map(|id| format!("<nd ref=\"{id}\"/>")).concat();
        let way = format!("<way id=\"10\">{nodes}<tag k=\"highway\" v=\"residential\"/></way>");
        fs::write(&osm, format!("<osm version=\"0.6\">{}{way}</osm>", corners.concat())).unwrap();
    };
    let import =
        |name: &str| import::import_into(folder.path(), &netconvert, &osm, name, &bounds(60)).unwrap().map.unwrap();
    write(&|height_m| format!("<tag k=\"ele\" v=\"{height_m}\"/>"));
    let hill = import("hill").network;
    // From 30 to 55 m; lanes end slightly before the corners.
    let (low_m, high_m) = hill.census().heights_m;
    assert!((low_m - 30.0).abs() < 0.5 && (high_m - 55.0).abs() < 0.5, "{low_m} {high_m}");
    // 12 m up over 206 m of longitude: at least one lane must be that steep.
    let steepest = hill.lanes().iter().map(|lane| lane.line.pose(lane.length_m / 2.0, 0.0).grade).fold(0.0, f64::max);
    assert!((0.04..0.08).contains(&steepest), "{steepest}");
    write(&|_| String::new());
    assert!(!import("flat").network.census().has_heights());
}
