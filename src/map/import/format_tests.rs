//! Tests of what an import keeps of OpenDRIVE and OpenStreetMap files: speed limits, lane types, places of lanes, side of traffic, ids and
//! widths; and of compressed files and files in Latin-1. Expected values are those of the files; places of lanes come from the formulas of
//! OpenDRIVE (`tests/data/opendrive/lane_points.py`).

use super::{ImportOptions, ImportReport, import_into};
use crate::map::{
    MapError,
    network::{Network, VehicleClasses},
};
use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::Command,
    sync::atomic::AtomicBool,
};

static STOP: AtomicBool = AtomicBool::new(false);

fn root() -> &'static Path {
    Path::new(env!("CODRIVE_ROOT"))
}

/// Imports a text as a file of this name into a folder.
fn imported(
    folder: &Path,
    name: &str,
    text: &[u8],
    side: Option<super::DrivingSide>,
) -> Result<(Network, ImportReport, PathBuf), MapError> {
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    let netconvert = root().join(".sumo/sumo/bin/netconvert");
    assert!(netconvert.is_file(), "{}: run scripts/setup first", netconvert.display());
    let options = ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side };
    let made = import_into(&folder.join("maps"), &netconvert, &file, "town", &options)?;
    let net = made.folder.join("net.xml");
    let network = Network::load(&net.to_string_lossy()).unwrap();
    let kept = folder.join("kept.net.xml");
    fs::copy(&net, &kept).unwrap();
    let mut left: Vec<_> = fs::read_dir(&made.folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["import.txt", "map.toml", "net.xml"], "no copy is left behind");
    fs::remove_dir_all(made.folder).unwrap();
    Ok((network, made.report, kept))
}

/// Returns an OpenDRIVE lane of constant width.
fn lane(id: i32, kind: &str, width_m: f64, more: &str) -> String {
    format!(
        "<lane id=\"{id}\" type=\"{kind}\"><width sOffset=\"0\" a=\"{width_m}\" b=\"0\" c=\"0\" d=\"0\"/>{more}</lane>"
    )
}

/// Returns a straight OpenDRIVE road of 300 m to the east.
fn road(attributes: &str, y_m: f64, types: &str, left: &str, right: &str) -> String {
    format!(
        "<road {attributes} junction=\"-1\" length=\"300\">{types}<planView><geometry s=\"0\" x=\"0\" y=\"{y_m}\" hdg=\"0\" \
         length=\"300\"><line/></geometry></planView><lanes><laneSection s=\"0\"><left>{left}</left><center><lane id=\"0\" \
         type=\"none\"/></center><right>{right}</right></laneSection></lanes></road>"
    )
}

fn document(roads: &[String]) -> String {
    format!("<OpenDRIVE><header revMajor=\"1\" revMinor=\"6\"/>{}</OpenDRIVE>", roads.concat())
}

fn limit_mps(net: &Network, lane: &str) -> f64 {
    net.lane(net.lane_named(lane).unwrap_or_else(|| panic!("no lane {lane}"))).speed_limit_mps
}

#[test]
fn limits_of_open_drive_roads_are_kept_and_those_of_lanes_win() {
    let kind = |s: u32, speed: &str| format!("<type s=\"{s}\" type=\"rural\">{speed}</type>");
    let limited = |max: &str, unit: &str| kind(0, &format!("<speed max=\"{max}\"{unit}/>"));
    let driving = lane(-1, "driving", 3.5, "");
    let own = "<speed sOffset=\"0\" max=\"30\" unit=\"mph\"/><speed sOffset=\"200\" max=\"-1\"/>";
    let plain = |id: u32, types: &str| road(&format!("id=\"{id}\""), 50.0 * f64::from(id), types, "", &driving);
    let changing = kind(0, "<speed max=\"100\" unit=\"km/h\"/>") + &kind(120, "<speed max=\"50\" unit=\"km/h\"/>");
    let text = document(&[
        plain(1, &limited("100", " unit=\"km/h\"")),
        plain(2, &limited("30", " unit=\"mph\"")),
        plain(3, &limited("25", "")),
        plain(4, &limited("no limit", "")),
        plain(5, &limited("undefined", " unit=\"km/h\"")),
        plain(6, &changing),
        road(
            "id=\"7\"",
            400.0,
            &limited("80", " unit=\"km/h\""),
            "",
            &(lane(-1, "driving", 3.5, own) + &lane(-2, "driving", 3.5, "")),
        ),
    ]);
    let folder = tempfile::tempdir().unwrap();
    let (net, report, _) = imported(folder.path(), "limits.xodr", text.as_bytes(), None).unwrap();
    let kmh = 1.0 / 3.6;
    for (lane, expected) in [
        ("-1_0", 100.0 * kmh),
        ("-2_0", 30.0 * 0.447_04),
        ("-3_0", 25.0),
        ("-4_0", 142.0 * kmh),
        ("-5_0", 13.89),
        ("-6#0_0", 100.0 * kmh),
        ("-6#1_0", 50.0 * kmh),
        // The inner lane has 30 mph for 200 m, and then no limit of its own: the road's.
        ("-7#0_1", 30.0 * 0.447_04),
        ("-7#0_0", 80.0 * kmh),
        ("-7#1_1", 80.0 * kmh),
    ] {
        assert!((limit_mps(&net, lane) - expected).abs() < 1e-5, "{lane}: {} is not {expected}", limit_mps(&net, lane));
    }
    let lengths = ["-6#0_0", "-7#0_0"].map(|lane| net.lane(net.lane_named(lane).unwrap()).length_m);
    assert!((lengths[0] - 120.0).abs() < 0.2 && (lengths[1] - 200.0).abs() < 0.2, "{lengths:?}");
    for line in [
        "limits         50 km/h for 1 road that has none in the file",
        "limits         142 km/h for 1 road that has \"no limit\"",
    ] {
        assert!(report.notes.iter().any(|note| note == line), "{line:?} is not in {:?}", report.notes);
    }
}

#[test]
fn lane_types_of_open_drive_become_permissions_with_the_limit_of_the_road() {
    let kinds = [
        ("entry", "passenger", 20.0),
        ("connectingRamp", "passenger", 20.0),
        ("bidirectional", "passenger", 20.0),
        ("bus", "bus", 20.0),
        ("taxi", "taxi", 20.0),
        ("HOV", "hov", 20.0),
        ("stop", "emergency", 20.0),
        ("parking", "", 1.39),
        ("biking", "bicycle", 5.56),
        ("sidewalk", "pedestrian", 2.78),
    ];
    let limit = "<type s=\"0\" type=\"town\"><speed max=\"20\" unit=\"m/s\"/></type>";
    let of_kind = |(k, (kind, ..)): (usize, &(&str, &str, f64))| {
        let lanes = lane(-1, "driving", 3.5, "")
            + &lane(-2, "curb", 0.2, "")
            + &lane(-3, kind, 2.0, "")
            + &lane(-4, "shoulder", 1.0, "");
        road(&format!("id=\"{kind}\""), 50.0 * k as f64, limit, "", &lanes)
    };
    let roads: Vec<String> = kinds.iter().enumerate().map(of_kind).collect();
    let folder = tempfile::tempdir().unwrap();
    let (net, report, _) = imported(folder.path(), "types.xodr", document(&roads).as_bytes(), None).unwrap();
    for (k, (kind, class, mps)) in kinds.iter().enumerate() {
        let outer = net.lane(net.lane_named(&format!("-{kind}_0")).unwrap());
        let inner = net.lane(net.lane_named(&format!("-{kind}_2")).unwrap());
        assert!(inner.admits_cars(), "{kind}");
        assert_eq!(outer.admits_cars(), *class == "passenger", "{kind}");
        assert!(outer.permissions.contains(VehicleClasses::parse(class)), "{kind}: {}", outer.permissions.list());
        assert_eq!(outer.permissions.is_empty(), class.is_empty(), "{kind}");
        assert!((outer.speed_limit_mps - mps).abs() < 1e-6, "{kind}: {}", outer.speed_limit_mps);
        // The kerb of 0.2 m keeps its place: the outer lane's middle is 3.5 + 0.2 + 1 m from the road's line.
        let apart_m = 50.0 * k as f64 - outer.shape()[0].y;
        assert!((apart_m - 4.7).abs() < 0.01 && (outer.width_m - 2.0).abs() < 1e-6, "{kind}: {apart_m}");
    }
    assert!(report.notes.iter().any(|note| note.ends_with("bidirectional are driven in one direction")));
}

#[test]
fn left_hand_roads_of_open_drive_have_their_own_lanes_on_the_left() {
    // Two lanes to the east on the left of the road's line, of 2.5 and 3 m, and one of 4 m to the west.
    let left = lane(2, "driving", 3.0, "") + &lane(1, "driving", 2.5, "");
    let text =
        |rule: &str| document(&[road(&format!("id=\"1\"{rule}"), 0.0, "", &left, &lane(-1, "driving", 4.0, ""))]);
    let folder = tempfile::tempdir().unwrap();
    let check = |text: &str, side, why: &str| {
        let (net, report, _) = imported(folder.path(), "left.xodr", text.as_bytes(), side).unwrap();
        assert!(net.is_left_hand());
        assert!(
            report.notes[0].starts_with("traffic        on the left: ") && report.notes[0].contains(why),
            "{:?}",
            report.notes
        );
        let ways: Vec<(f64, f64, bool)> = net
            .lanes()
            .iter()
            .filter(|lane| net.edge(lane.edge).kind.is_street())
            .map(|lane| (lane.shape()[0].y, lane.width_m, lane.shape()[1].x > lane.shape()[0].x))
            .collect();
        assert_eq!(ways.len(), 3);
        for expected in [(1.25, 2.5, true), (4.0, 3.0, true), (-2.0, 4.0, false)] {
            let is_it = |way: &&(f64, f64, bool)| {
                (way.0 - expected.0).abs() < 0.01 && way.1 == expected.1 && way.2 == expected.2
            };
            assert!(ways.iter().any(|way| is_it(&way)), "{expected:?} is not in {ways:?}");
        }
    };
    check(&text(" rule=\"LHT\""), None, "rule=\"LHT\"");
    check(&text(""), Some(super::DrivingSide::Left), "--driving-side");
    let other = road("id=\"2\" rule=\"RHT\"", 90.0, "", "", &lane(-1, "driving", 4.0, ""));
    let mixed = text(" rule=\"LHT\"").replace("</OpenDRIVE>", &format!("\n{other}</OpenDRIVE>"));
    let message = imported(folder.path(), "mixed.xodr", mixed.as_bytes(), None).unwrap_err().to_string();
    assert!(
        message.contains("mixed.xodr:1: road \"1\": rule is \"LHT\"") && message.contains("road \"2\" in line 2"),
        "{message}"
    );
    assert!(message.contains("remedy"), "{message}");
}

#[test]
fn ids_that_sumo_cannot_hold_are_renamed_with_all_that_refers_to_them() {
    let link = |kind: &str, id: &str, contact: &str| {
        format!("<link><{kind} elementType=\"road\" elementId=\"{id}\" contactPoint=\"{contact}\"/></link>")
    };
    let driving = lane(-1, "driving", 3.5, "");
    let first = road("id=\"Stra\u{df}e 1\"", 0.0, &link("successor", "a &amp; b", "start"), "", &driving);
    let second = road("id=\"a &amp; b\"", 0.0, &link("predecessor", "Stra\u{df}e 1", "end"), "", &driving).replacen(
        "x=\"0\"",
        "x=\"300\"",
        1,
    );
    let text = document(&[first, second]);
    let folder = tempfile::tempdir().unwrap();
    // In UTF-8 and in Latin-1.
    let latin_1 = format!("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n{text}");
    let latin_1: Vec<u8> = latin_1.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    for bytes in [text.into_bytes(), latin_1] {
        let (net, report, _) = imported(folder.path(), "ids.xodr", &bytes, None).unwrap();
        assert_eq!((report.path.0.round(), report.path.1), (600.0, 2), "the two roads follow each other");
        assert!(net.lane_named("-Strasse_1_0").is_some() && net.lane_named("-a___b_0").is_some());
        assert!(report.notes.iter().any(|note| note.ends_with("\"Stra\u{df}e 1\" is Strasse_1")), "{:?}", report.notes);
    }
}

#[test]
fn lanes_of_open_drive_lie_where_its_formulas_put_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = root().join("tests/data/opendrive/reference-lines.xodr");
    let (_, _, net) = imported(folder.path(), "lines.xodr", &fs::read(&file).unwrap(), None).unwrap();
    let script = root().join("tests/data/opendrive/lane_points.py");
    let tools = root().join(".sumo/sumo/tools");
    let done = Command::new("python3").arg(script).arg(tools).arg(file).arg(net).output().expect("python3 is there");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let found: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    // Lines, an arc, two spirals, a cubic and a parametric cubic, with a median without traffic: 0.1 m is a third of a line's width.
    assert!(found["points"].as_u64().unwrap() > 1000, "{found}");
    assert!(found["worst_m"].as_f64().unwrap() < 0.1, "{found}");
}

/// Returns an OpenStreetMap file: a street of 400 m at a place, and one more that begins at its end.
fn streets(latitude: f64, longitude: f64, tags: &str) -> String {
    let node = |id: u32, north: f64, east: f64| {
        format!("<node id=\"{id}\" lat=\"{}\" lon=\"{}\"/>", latitude + north, longitude + east)
    };
    let nodes = [node(1, 0.0, 0.0), node(2, 0.0, 0.004), node(3, 0.002, 0.004)].concat();
    format!(
        "<osm version=\"0.6\">{nodes}<way id=\"11\"><nd ref=\"1\"/><nd ref=\"2\"/>{tags}</way><way id=\"12\"><nd ref=\"2\"/><nd \
         ref=\"3\"/><tag k=\"highway\" v=\"residential\"/></way></osm>"
    )
}

#[test]
fn the_side_of_traffic_of_open_street_map_follows_from_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let side_at = |latitude: f64, longitude: f64, side| {
        let text = streets(latitude, longitude, "<tag k=\"highway\" v=\"residential\"/>");
        let (net, report, _) = imported(folder.path(), "town.osm", text.as_bytes(), side).unwrap();
        let note = report.notes[0].clone();
        assert_eq!(net.is_left_hand(), note.starts_with("traffic        on the left: "), "{note}");
        (net.is_left_hand(), note)
    };
    let (london, note) = side_at(51.5, -0.1, None);
    assert!(london && note.contains("3 of 3 nodes") && note.contains("--driving-side right"), "{note}");
    let (berlin, note) = side_at(52.5, 13.4, None);
    assert!(!berlin && note.contains("--driving-side left"), "{note}");
    assert!(!side_at(51.5, -0.1, Some(super::DrivingSide::Right)).0);
    assert!(side_at(52.5, 13.4, Some(super::DrivingSide::Left)).0);
}

#[test]
fn names_of_streets_are_kept_and_those_in_other_letters_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    for (name, line) in [
        ("Allée d\u{2019}Été", "names          1 of streets"),
        ("\u{4e2d}\u{5c71}\u{8def}", "names          1 of streets; 1 in letters that no sign can show"),
    ] {
        let tags = format!("<tag k=\"highway\" v=\"residential\"/><tag k=\"name\" v=\"{name}\"/>");
        let text = streets(48.8, 2.3, &tags);
        let (net, report, _) = imported(folder.path(), "town.osm", text.as_bytes(), None).unwrap();
        // The other street of the file has no name.
        let names = ["11", "12"].map(|id| net.edge(net.edge_named(id).unwrap()).name.as_deref());
        assert_eq!(names, [Some(name), None]);
        assert!(report.short().iter().any(|found| found == line), "{:?}", report.short());
    }
}

#[test]
fn the_largest_place_of_open_street_map_is_the_title() {
    let place = |kind: &str, name: &str| {
        format!(
            "<node id=\"9{}\" lat=\"48.8\" lon=\"2.3\"><tag k=\"place\" v=\"{kind}\"/><tag k=\"name\" v=\"{name}\"/></node>",
            name.len()
        )
    };
    let places =
        [place("village", "Bois"), place("town", "Mer &amp; Mont"), place("town", "Val"), place("suburb", "Le Port")];
    let text = streets(48.8, 2.3, "<tag k=\"highway\" v=\"residential\"/>");
    let folder = tempfile::tempdir().unwrap();
    for (more, title) in [(places.concat(), "Mer & Mont"), (String::new(), "port")] {
        let file = folder.path().join("port.osm");
        fs::write(&file, text.replace("<way id=\"11\"", &format!("{more}<way id=\"11\""))).unwrap();
        let netconvert = root().join(".sumo/sumo/bin/netconvert");
        let options = ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side: None };
        let made = import_into(&folder.path().join("maps"), &netconvert, &file, "port", &options).unwrap();
        assert_eq!(made.map.unwrap().title, title);
        let says_so = made.report.notes.iter().any(|note| note == "place          Mer & Mont, the map's title");
        assert_eq!(says_so, title == "Mer & Mont", "{:?}", made.report.notes);
        fs::remove_dir_all(made.folder).unwrap();
    }
}

#[test]
fn two_way_roads_with_one_lane_become_wide_enough_for_two_cars() {
    let folder = tempfile::tempdir().unwrap();
    let imported = |tags: &str| {
        let text = streets(52.5, 13.4, &format!("<tag k=\"highway\" v=\"primary\"/><tag k=\"lanes\" v=\"1\"/>{tags}"));
        imported(folder.path(), "narrow.osm", text.as_bytes(), None).unwrap()
    };
    let (net, report, _) = imported("");
    let ways = ["11_0", "-11_0"].map(|id| net.lane(net.lane_named(id).unwrap()));
    let apart_m = ways[0].shape()[0].truncate().distance(ways[1].shape().last().unwrap().truncate());
    // Two cars of 1.8 m, and a metre between them.
    assert!(ways.iter().all(|lane| lane.width_m >= 2.8) && apart_m >= 2.8, "{apart_m}");
    assert!(
        report.notes.iter().any(|note| note.starts_with("widened        1 two-way roads with one lane")),
        "{:?}",
        report.notes
    );
    // A one-way road keeps its lane.
    let (net, report, _) = imported("<tag k=\"oneway\" v=\"yes\"/>");
    assert!(net.lane_named("-11_0").is_none() && net.lane_named("11_1").is_none());
    assert_eq!(report.notes.len(), 1, "{:?}", report.notes);
}

#[test]
fn compressed_files_are_imported_and_compressed_networks_are_driven() {
    let folder = tempfile::tempdir().unwrap();
    let packed = |bytes: &[u8]| {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packed.write_all(bytes).unwrap();
        packed.finish().unwrap()
    };
    let driving = lane(-1, "driving", 3.5, "");
    for (name, text) in [
        ("town.xodr.gz", document(&[road("id=\"1\"", 0.0, "", "", &driving)])),
        ("town.osm.gz", streets(52.5, 13.4, "<tag k=\"highway\" v=\"primary\"/>")),
    ] {
        let (net, ..) = imported(folder.path(), name, &packed(text.as_bytes()), None).unwrap();
        assert!(net.census().lanes > 0, "{name}");
    }
    let ring = fs::read(root().join("maps/ring-250/net.xml")).unwrap();
    let file = folder.path().join("ring.net.xml.gz");
    fs::write(&file, packed(&ring)).unwrap();
    let map = crate::map::RoadMap::load(&file.to_string_lossy()).unwrap();
    assert_eq!((map.name.as_str(), map.route.length_m()), ("ring", 250.0));
}

#[test]
fn files_of_other_kinds_are_refused_with_the_file_to_take_instead() {
    let folder = tempfile::tempdir().unwrap();
    let configuration = b"<configuration><input><net-file value=\"town.net.xml\"/></input></configuration>";
    let message = imported(folder.path(), "town.sumocfg", configuration, None).unwrap_err().to_string();
    assert!(message.contains("<net-file>"), "{message}");
    let load = |name: &str, text: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, text).unwrap();
        crate::map::RoadMap::load(&file.to_string_lossy()).unwrap_err().to_string()
    };
    assert!(
        load("town.sumocfg", configuration)
            .contains("drive it with --scenario, or name the network that stands in its <net-file>")
    );
    assert!(load("town.xodr", b"<OpenDRIVE/>").contains("convert it with `codrive map import`"));
    // The format of SUMO 0.x, with a fault that an import mends.
    let old = b"<net version=\"0.13\"><edge id=\"a\"><lane id=\"a_0\" index=\"1\"/></edge></net>";
    let message = load("old.net.xml", old);
    assert!(message.contains("index is \"1\"") && message.contains("`codrive map import "), "{message}");
}
