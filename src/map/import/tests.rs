//! Tests of imports: invalid files, limits, further attempts, and the content of a report.

use super::*;
use crate::map::{loop_search::default_path, network::Network};
use std::{f64::consts::PI, fs, sync::atomic::AtomicBool};

static STOP: AtomicBool = AtomicBool::new(false);

fn bounds() -> ImportOptions<'static> {
    ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side: None }
}

fn sumos_netconvert() -> PathBuf {
    let program = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo/bin/netconvert");
    assert!(program.is_file(), "{}: run scripts/setup first", program.display());
    program
}

/// Makes a converter that runs `script`; `$net` is the file that it must write.
#[cfg(unix)]
fn converter(folder: &Path, script: &str) -> PathBuf {
    let program = folder.join("netconvert");
    let net = "while [ \"$1\" != --output-file ]; do shift; done; net=$2";
    fs::write(&program, format!("#!/bin/sh\nall=\"$*\"\n{net}\n{script}\n")).unwrap();
    fs::set_permissions(&program, std::os::unix::fs::PermissionsExt::from_mode(0o700)).unwrap();
    program
}

/// Returns a network of straight lanes heading east, each starting at the end of the first lane that leads to it. An edge is given by id,
/// length and permitted class. Two edges that lead to each other become the halves of a circle of 20 m radius.
fn net_of(edges: &[(&str, f64, &str)], ways: &[(&str, &str)]) -> String {
    let leads = |from: &str, to: &str| ways.contains(&(from, to));
    let begin_of = |id: &str| {
        let length = |id: &str| edges.iter().find(|(other, ..)| *other == id).map_or(0.0, |(_, length, _)| *length);
        let before = |id: &str| ways.iter().find(|(_, to)| *to == id).map(|(from, _)| *from);
        std::iter::successors(before(id), |id| before(id)).take(9).map(length).sum::<f64>()
    };
    let edge = |(id, length, vehicle_class): &(&str, f64, &str)| {
        let round = edges.iter().find(|(other, ..)| leads(id, other) && leads(other, id)).map(|(other, ..)| id < other);
        let shape = match round {
            Some(first) => (0..=20)
                .map(|k| (f64::from(k) / 20.0 + f64::from(u8::from(first))) * PI)
                .fold(String::new(), |text, angle| {
                    text + &format!("{:.4},{:.4} ", 20.0 * angle.cos(), 500.0 + 20.0 * angle.sin())
                }),
            None => format!("{},0 {},0", begin_of(id), begin_of(id) + length),
        };
        format!(
            "<edge id=\"{id}\"><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"{length}\" allow=\"{vehicle_class}\" \
             shape=\"{}\"/></edge>\n",
            shape.trim()
        )
    };
    let way = |(from, to): &(&str, &str)| {
        format!("<connection from=\"{from}\" to=\"{to}\" fromLane=\"0\" toLane=\"0\" dir=\"s\"/>\n")
    };
    let edges: String = edges.iter().map(edge).collect();
    format!("<net>\n{edges}{}</net>", ways.iter().map(way).collect::<String>())
}

fn path_of(text: &str) -> Result<(Vec<String>, bool, f64), MapError> {
    let net = Network::read(Path::new("t.net.xml"), text)?;
    let path = default_path(Path::new("t.net.xml"), &net)?;
    let ids = path.lanes(&net).map(|lane| net.lane(lane).id.clone()).collect();
    Ok((ids, path.is_closed, path.length_m(&net)))
}

#[test]
fn a_way_with_a_corner_inside_the_junction_is_avoided_if_possible() {
    // From a to the north, by b (100 m) or, after a corner inside the junction, by c (200 m).
    let lane = |id: &str, kind: &str, length: u32, shape: &str| {
        format!(
            "<edge id=\"{id}\" {kind}><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"{length}\" shape=\"{shape}\"/></edge>"
        )
    };
    let way = |to: &str, via: &str| {
        format!(
            "<connection from=\"a\" to=\"{to}\" fromLane=\"0\" toLane=\"0\" via=\":{via}_0\" dir=\"l\"/>\
             <connection from=\":{via}\" to=\"{to}\" fromLane=\"0\" toLane=\"0\" dir=\"l\"/>"
        )
    };
    let inside = "function=\"internal\"";
    let edges = [
        lane("a", "", 100, "-100,0 0,0"),
        lane("b", "", 100, "15,15 15,115"),
        lane("c", "", 200, "20,20 20,220"),
        lane(":n", inside, 25, "0,0 4,0.5 8,2 11.5,4.5 13.5,8 14.5,11 15,15"),
        lane(":m", inside, 40, "0,0 20,0 20,20"),
    ];
    let text = |ways: &[String]| format!("<net>{}{}</net>", edges.concat(), ways.concat());
    let found = path_of(&text(&[way("b", "n"), way("c", "m")])).unwrap();
    assert_eq!(found.0, ["a_0", ":n_0", "b_0"]);
    // The corner is avoided even without an alternative: the longest street makes a path.
    assert_eq!(path_of(&text(&[way("c", "m")])).unwrap().0, ["c_0"]);
}

#[test]
fn without_a_loop_the_longest_open_path_of_lanes_for_cars_is_found() {
    let fork = [("a", 100.0, "passenger"), ("b", 50.0, "passenger"), ("c", 80.0, "passenger"), ("d", 500.0, "bus")];
    let ways = [("a", "b"), ("a", "c"), ("c", "d")];
    assert_eq!(path_of(&net_of(&fork, &ways)).unwrap(), (vec!["a_0".into(), "c_0".into()], false, 180.0));
    // A third branch makes a path of 210 m, which is longer.
    let longer = [fork[0], fork[1], fork[2], ("e", 110.0, "passenger")];
    let found = path_of(&net_of(&longer, &[("a", "b"), ("a", "c"), ("a", "e")])).unwrap();
    assert_eq!(found, (vec!["a_0".into(), "e_0".into()], false, 210.0));
    // A loop takes precedence over a longer open path.
    let looped = path_of(&net_of(&longer, &[("a", "e"), ("b", "c"), ("c", "b")])).unwrap();
    assert_eq!(looped, (vec!["b_0".into(), "c_0".into()], true, 130.0));
    // A loop of 90 m counts as driving round on the spot.
    let on_the_spot = [fork[0], fork[1], ("c", 40.0, "passenger"), ("e", 110.0, "passenger")];
    let found = path_of(&net_of(&on_the_spot, &[("a", "e"), ("b", "c"), ("c", "b")])).unwrap();
    assert_eq!(found, (vec!["a_0".into(), "e_0".into()], false, 210.0));
    let alone = path_of(&net_of(&on_the_spot[1..3], &[("b", "c"), ("c", "b")])).unwrap();
    assert_eq!(alone, (vec!["b_0".into(), "c_0".into()], true, 90.0));
}

#[test]
fn a_network_without_a_road_for_cars_reports_what_it_has_instead() {
    let message = |edges: &[(&str, f64, &str)]| path_of(&net_of(edges, &[])).unwrap_err().to_string();
    assert!(message(&[]).contains("t.net.xml: no road for cars: the network has no street"));
    let walk = message(&[("w", 90.0, "pedestrian"), ("r", 90.0, "rail")]);
    assert!(walk.contains("none of the 2 lanes of its streets is open to passenger cars"), "{walk}");
    let short = message(&[("a", 3.0, "passenger"), ("b", 12.5, "passenger")]);
    assert!(short.contains("2 lanes are open to passenger cars, the longest has 12.5 m"), "{short}");
    assert!(path_of(&net_of(&[("a", 20.0, "passenger")], &[])).is_ok(), "as long as is asked for");
}

#[test]
fn a_road_that_joins_no_other_is_imported() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("road.osm");
    // One way, 0.003 degrees east at 52 degrees north: 206 m.
    let text = "<osm version=\"0.6\"><node id=\"1\" lat=\"52\" lon=\"13\"/><node id=\"2\" lat=\"52\" lon=\"13.003\"/><way \
                id=\"9\"><nd ref=\"1\"/><nd ref=\"2\"/><tag k=\"highway\" v=\"residential\"/><tag k=\"oneway\" v=\"yes\"/></way></osm>";
    fs::write(&file, text).unwrap();
    let made = import_into(&folder.path().join("maps"), &sumos_netconvert(), &file, "road", &bounds()).unwrap();
    let network = Network::load(&made.folder.join("net.xml").to_string_lossy()).unwrap();
    assert_eq!(network.census().streets, 1);
    let length_m = network.lanes()[0].length_m;
    assert!((length_m - 206.0).abs() < 2.0, "{length_m} m");
}

#[test]
fn an_unreadable_file_is_refused_by_its_own_name_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let (maps, netconvert) = (folder.path().join("maps"), sumos_netconvert());
    let laughs = "<!DOCTYPE net [<!ENTITY a \"ha\">\n<!ENTITY b \"&a;&a;&a;\">]>\n<net>&b;</net>";
    let road =
        "<OpenDRIVE><header revMajor=\"1\" revMinor=\"4\"/><road id=\"7\" length=\"50\" junction=\"-1\"><planView>";
    let walk = net_of(&[("w", 90.0, "pedestrian")], &[]);
    let cases: [(&str, &str, &[&str]); 10] = [
        ("empty.xodr", "", &["the file is empty", "remedy"]),
        ("empty.net.xml", "", &["the file is empty"]),
        ("laughs.osm", laughs, &["laughs.osm:1: the document declares a type or entities"]),
        ("laughs.net.xml", laughs, &["laughs.net.xml:1: the document declares a type or entities"]),
        ("cut.xodr", road, &["netconvert failed: input ended before all started tags were ended", "line"]),
        ("cut.osm", "<osm version=\"0.6\"><node id=", &["netconvert failed: "]),
        ("cut.net.xml", "<net>\n<edge", &["cut.net.xml:2:1: ", "this is not XML"]),
        (
            "none.xodr",
            "<OpenDRIVE><header revMajor=\"1\" revMinor=\"4\"/></OpenDRIVE>",
            &["no road for cars: the file has no road"],
        ),
        ("none.osm", "<osm version=\"0.6\"></osm>", &["no road for cars: the file has no road"]),
        ("walk.net.xml", &walk, &["no road for cars: none of the 1 lanes"]),
    ];
    for (name, text, expected) in cases {
        let file = folder.path().join(name);
        fs::write(&file, text).unwrap();
        let message =
            import_into(&maps, &netconvert, &file, "no", &bounds()).map(|made| made.folder).unwrap_err().to_string();
        assert!(message.starts_with(&file.display().to_string()), "{name}: {message}");
        assert!(expected.iter().all(|part| message.contains(part)), "{expected:?}: {message}");
        assert!(!message.contains("unfinished"), "names a file that is gone: {message}");
        assert_eq!(fs::read_dir(&maps).map_or(0, Iterator::count), 0, "{name} leaves something behind");
    }
}

#[test]
fn idle_signals_and_islands_are_reported_and_do_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("two.net.xml");
    let roads =
        [("a", 90.0, "passenger"), ("b", 70.0, "passenger"), ("c", 60.0, "passenger"), ("w", 60.0, "pedestrian")];
    let signal = "<tlLogic id=\"t\" type=\"static\"><phase duration=\"9\" state=\"G\"/></tlLogic></net>";
    fs::write(&file, net_of(&roads, &[("a", "b")]).replace("</net>", signal)).unwrap();
    let made = import_into(&folder.path().join("maps"), Path::new("none"), &file, "two", &bounds()).unwrap();
    let report = made.report;
    assert_eq!((report.census.islands, report.alone, report.census.idle_signals), (3, 1, 1));
    assert_eq!((report.car_lanes, report.census.lanes), (3, 4));
    assert_eq!(report.path, (160.0, 2, false));
    let written = fs::read_to_string(made.folder.join(REPORT_FILE)).unwrap();
    for line in [
        "taken          as it is",
        "lanes          3 for cars, 1 not for cars",
        "signals        1; 1 without a lane",
        "parts          3, not connected to each other; 1 streets without access",
        "path           160 m over 2 streets, open: no loop was found",
    ] {
        assert!(written.lines().any(|found| found == line), "{line:?} is not in:\n{written}");
    }
    let map_file = fs::read_to_string(made.folder.join("map.toml")).unwrap();
    assert!(map_file.contains("closed = false\nroute = [\"a\", \"b\"]\n"), "{map_file}");
}

#[cfg(unix)]
#[test]
fn where_fine_options_fail_coarser_ones_are_tried_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("road.xodr");
    fs::write(&file, "<OpenDRIVE><road><signals/></road><road></road></OpenDRIVE>").unwrap();
    let good = folder.path().join("good.net.xml");
    fs::write(&good, net_of(&[("a", 90.0, "passenger")], &[])).unwrap();
    let script = format!(
        "case \"$all\" in *curve-resolution*) echo 'Error: too fine' >&2; exit 1;; esac\n\
         echo \"Warning: table $PROJ_DATA\" >&2\necho 'Error: no road 3' >&2\ncp {} $net",
        good.display()
    );
    let program = converter(folder.path(), &script);
    let maps = folder.path().join("maps");
    let report = import_into(&maps, &program, &file, "road", &bounds()).unwrap().report;
    assert!(report.conversion.contains("sampled every 2 m"), "{report:?}");
    assert_eq!(report.finer.len(), 2);
    assert!(report.finer[0].ends_with("every metre: netconvert failed: too fine"), "{:?}", report.finer);
    assert_eq!(report.elements[0], ("roads", 2));
    assert_eq!(report.errors[0].example, "no road 3");
    // SUMO's folder, two levels above the converter, overrides the environment.
    let home = folder.path().parent().unwrap().join("data/proj");
    assert_eq!(report.warnings[0].example, format!("table {}", home.display()));
    // The last attempt gets a copy without signals; errors still name the original file.
    let program = converter(
        folder.path(),
        "case \"$all\" in *repaired*) ;; *) echo 'Error: bad signal' >&2; exit 1;; esac\nexit 3",
    );
    let message = import_into(&maps, &program, &file, "no", &bounds()).map(|made| made.folder).unwrap_err().to_string();
    assert_eq!(message, format!("{}: netconvert failed: bad signal", file.display()));
}

#[cfg(unix)]
#[test]
fn netconvert_gets_the_canonical_copy_of_a_network_not_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let [file, good] = ["town.net.xml", "good.net.xml"].map(|name| folder.path().join(name));
    // 5 m are too short to drive.
    fs::write(&file, net_of(&[("a", 5.0, "passenger")], &[])).unwrap();
    fs::write(&good, net_of(&[("a", 90.0, "passenger")], &[])).unwrap();
    let program = converter(folder.path(), &format!("echo \"$all\" > $(dirname $0)/said; cp {} $net", good.display()));
    let report = import_into(&folder.path().join("maps"), &program, &file, "town", &bounds()).unwrap().report;
    assert!(report.conversion.contains("rebuilt by netconvert"), "{report:?}");
    let message = fs::read_to_string(folder.path().join("said")).unwrap();
    assert!(message.contains("copy.net.xml") && !message.contains("town.net.xml"), "{message}");
}

#[cfg(unix)]
#[test]
fn a_network_that_becomes_too_large_is_reported_by_the_files_name() {
    let folder = tempfile::tempdir().unwrap();
    let maps = folder.path().join("maps");
    // One byte beyond the limit. Coarser options may help with OpenDRIVE, and are tried; nothing helps with other formats.
    let program = converter(folder.path(), "echo >> $(dirname $0)/runs; truncate -s $((48 * 1024 * 1024 + 1)) $net");
    for (name, runs) in [("town.xodr", 3), ("town.osm", 1)] {
        let file = folder.path().join(name);
        fs::write(&file, "<OpenDRIVE><road/></OpenDRIVE>").unwrap();
        let message =
            import_into(&maps, &program, &file, "no", &bounds()).map(|made| made.folder).unwrap_err().to_string();
        let begin = format!("{}: netconvert makes a network that has 49 MiB; allowed: at most 48 MiB", file.display());
        assert!(message.starts_with(&begin) && message.contains("remedy: import a part of the map"), "{message}");
        let counted = fs::read_to_string(folder.path().join("runs")).unwrap().len();
        assert_eq!(counted, runs, "{name}");
        fs::remove_file(folder.path().join("runs")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn lanes_without_a_speed_limit_get_one_and_the_report_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("road.xodr");
    fs::write(&file, "<OpenDRIVE><road/></OpenDRIVE>").unwrap();
    let still = folder.path().join("still.net.xml");
    let net = net_of(&[("a", 90.0, "passenger"), ("b", 80.0, "passenger")], &[("a", "b")]);
    fs::write(&still, net.replacen("speed=\"9\"", "speed=\"0.000000\"", 1)).unwrap();
    let program = converter(folder.path(), &format!("cp {} $net", still.display()));
    let made = import_into(&folder.path().join("maps"), &program, &file, "road", &bounds()).unwrap();
    let line = "taken          with its own lines through junctions and curves sampled every metre; 50 km/h for 1 lane that \
         has a speed limit of 0";
    let written = fs::read_to_string(made.folder.join(REPORT_FILE)).unwrap();
    assert!(written.lines().any(|found| found == line), "{written}");
    let network = Network::load(&made.folder.join("net.xml").to_string_lossy()).unwrap();
    let limits: Vec<f64> = network.lanes().iter().map(|lane| lane.speed_limit_mps).collect();
    assert_eq!(limits, [13.89, 9.0]);
    // A SUMO network is used as it is, and refused.
    let own = import_into(&folder.path().join("maps"), Path::new("none"), &still, "own", &bounds());
    assert!(own.map(|made| made.folder).unwrap_err().to_string().contains("speed"));
}

#[test]
fn lines_through_a_junction_that_miss_its_lanes_are_not_driven() {
    // Lane b begins 2 m beside the end of a's line through the junction, as in some OpenDRIVE files.
    let folder = tempfile::tempdir().unwrap();
    let net = |end_y: f64| {
        let lane = |id: &str, shape: &str, kind: &str| {
            format!(
                "<edge id=\"{id}\" {kind}><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"40\" shape=\"{shape}\"/></edge>"
            )
        };
        format!(
            "<net>{}{}{}<connection from=\"a\" to=\"b\" fromLane=\"0\" toLane=\"0\" via=\":n_0\"/><connection from=\":n\" \
             to=\"b\" fromLane=\"0\" toLane=\"0\"/></net>",
            lane(":n", &format!("40,0 60,{end_y}"), "function=\"internal\""),
            lane("a", "0,0 40,0", ""),
            lane("b", "60,2 100,2", ""),
        )
    };
    fs::write(folder.path().join("fine.net.xml"), net(0.0)).unwrap();
    fs::write(folder.path().join("coarse.net.xml"), net(2.0)).unwrap();
    let file = folder.path().join("road.xodr");
    fs::write(&file, "<OpenDRIVE/>").unwrap();
    let script = format!(
        "case \"$all\" in *internal-shapes*) cp {0}/fine.net.xml $net;; *) cp {0}/coarse.net.xml $net;; esac",
        folder.path().display()
    );
    let program = converter(folder.path(), &script);
    let report = import_into(&folder.path().join("maps"), &program, &file, "road", &bounds()).unwrap().report;
    assert!(report.conversion.starts_with("with netconvert's lines"), "{report:?}");
    assert!(
        report.finer[0].ends_with("these lines miss the lanes that they join by up to 2.0 m"),
        "{:?}",
        report.finer
    );
}
