//! `codrive analyse` of drives on networks: travel times, time lost and throughput equal those that SUMO's own program writes for the same
//! traffic. The report names what a recording lacks.

use super::{
    codrive,
    network::{run_lorries, run_sumo, tick},
    printed,
};
use codrive::record::{Table, TableReader};
use std::{collections::BTreeMap, fs, path::Path};

/// Reads a CSV table that the analysis wrote; each row is keyed by column name.
fn rows(file: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let head = lines.next().unwrap();
    lines.map(|cells| head.iter().cloned().zip(cells).collect()).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> Option<f64> {
    Some(&row[column]).filter(|cell| !cell.is_empty()).map(|cell| cell.parse().unwrap())
}

/// Analyses a drive and returns the exit code and the output.
fn analyse(drive: &Path, more: &[&str]) -> (i32, String) {
    printed(&mut codrive(&[&["analyse", drive.to_str().unwrap()], more].concat()))
}

/// Returns the time of the drive, s, for a time of SUMO's own program, s.
fn drive_s(time_s: f64) -> f64 {
    tick(time_s) as f64 * 0.01
}

/// Returns these attributes of all elements with this name in an XML file of SUMO.
fn elements(file: &Path, name: &str, attributes: &[&str]) -> Vec<Vec<String>> {
    let text = fs::read_to_string(file).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let found = document.descendants().filter(|node| node.has_tag_name(name));
    found.map(|node| attributes.iter().map(|name| node.attribute(*name).unwrap().to_owned()).collect()).collect()
}

#[test]
fn travel_times_time_lost_and_throughput_equal_those_of_the_sumo_program() {
    let folder = tempfile::tempdir().unwrap();
    let (mut command, drive) = run_lorries(folder.path(), "p1");
    assert!(command.output().unwrap().status.success());
    // Lorries enter on A2B2, stop at the signal B2 and leave on B2C2: lines before the signal, behind it, and on one lane.
    let lines = ["A2B2:20", "B2C2:30", "B2C2_0:30"];
    let asked: Vec<&str> = lines.iter().flat_map(|line| ["--line", line]).collect();
    let (code, text) = analyse(&drive, &asked);
    assert_eq!(code, 0, "{text}");
    let out = drive.join("analysis");

    let (info, loops, events) =
        (folder.path().join("trips.xml"), folder.path().join("loops.add.xml"), folder.path().join("loops.xml"));
    let detector = |(lane, pos): (&str, u32)| {
        let file = events.display();
        format!("<instantInductionLoop id=\"{lane}:{pos}\" lane=\"{lane}\" pos=\"{pos}\" file=\"{file}\"/>\n")
    };
    let places = [("A2B2_0", 20), ("A2B2_1", 20), ("B2C2_0", 30), ("B2C2_1", 30)];
    let detectors: String = places.into_iter().map(detector).collect();
    fs::write(&loops, format!("<additional>\n{detectors}</additional>\n")).unwrap();
    run_sumo(folder.path(), "90", &[("--tripinfo-output", &info), ("--additional-files", &loops)]);

    // Vehicles are numbered in order of departure; those that departed before the drive have no travel time.
    let last_s = TableReader::parquet(&Table::Ego.parquet(&drive)).unwrap().rows() as f64 * 0.01;
    let mut wanted: Vec<[f64; 3]> = elements(&info, "tripinfo", &["depart", "arrival", "timeLoss"])
        .into_iter()
        .map(|cells| [0, 1, 2].map(|k| cells[k].parse::<f64>().unwrap()))
        .filter(|[depart, arrival, _]| drive_s(*depart) > 0.0 && drive_s(*arrival) <= last_s)
        .collect();
    wanted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let trips = rows(&out.join("trips.csv"));
    let whole: Vec<_> = trips.iter().filter(|trip| !trip["travel_time_s"].is_empty()).collect();
    assert!(wanted.len() >= 3 && whole.len() == wanted.len(), "{} {}", whole.len(), wanted.len());
    assert!(trips.len() > whole.len(), "some were there before, or are there at the end");
    for (trip, [depart, arrival, loss_s]) in whole.iter().zip(&wanted) {
        assert!((number(trip, "departure_s").unwrap() - drive_s(*depart)).abs() < 1e-9, "{trip:?}");
        assert!((number(trip, "travel_time_s").unwrap() - (arrival - depart)).abs() < 1e-9, "{trip:?}");
        // SUMO sums over steps of 0.1 s. The rows are 1 s apart, and the ratio of speed to limit is interpolated linearly between them.
        let found_s = number(trip, "time_loss_s").unwrap();
        assert!((found_s - loss_s).abs() < 0.1, "{found_s} {loss_s}");
    }
    assert!(wanted.iter().any(|trip| trip[2] > 5.0), "one has to wait at least: {wanted:?}");
    let trial = &rows(&out.join("trials.csv"))[0];
    let mut times: Vec<f64> = wanted.iter().map(|[depart, arrival, _]| arrival - depart).collect();
    times.sort_by(f64::total_cmp);
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    assert!((number(trial, "travel_time_s").unwrap() - mean).abs() < 1e-9);
    assert!(
        (number(trial, "travel_time_p95_s").unwrap() - times[times.len() - 1]).abs() < 1e-9,
        "of fewer than 20 the last"
    );
    assert_eq!(number(trial, "trips"), Some(wanted.len() as f64));

    // Entries at each loop during the drive.
    let entered = |ids: &[&str]| -> usize {
        let found = elements(&events, "instantOut", &["id", "time", "state"]);
        let is_entry = |cells: &&Vec<String>| {
            let at_s = drive_s(cells[1].parse::<f64>().unwrap());
            ids.contains(&cells[0].as_str()) && cells[2] == "enter" && at_s > 0.0 && at_s <= last_s.floor()
        };
        found.iter().filter(is_entry).count()
    };
    let passed = rows(&out.join("lines.csv"));
    assert_eq!(passed.iter().map(|row| row["line"].as_str()).collect::<Vec<_>>(), lines);
    for (row, ids) in passed.iter().zip([&["A2B2_0:20", "A2B2_1:20"][..], &["B2C2_0:30", "B2C2_1:30"], &["B2C2_0:30"]])
    {
        let wanted = entered(ids);
        assert_eq!(row["passages"], wanted.to_string(), "{row:?}");
        assert_eq!(row["resolution_s"], if wanted > 0 { "1" } else { "" }, "far from the ego");
        let flow_per_h = wanted as f64 / number(row, "duration_s").unwrap() * 3600.0;
        assert!((number(row, "line_passages_per_h").unwrap() - flow_per_h).abs() < 1e-9);
    }
    assert!(entered(&["A2B2_0:20", "A2B2_1:20"]) > 5 && entered(&["B2C2_0:30", "B2C2_1:30"]) > 5);
    assert_eq!(trial["line_passages_per_h"], passed[0]["line_passages_per_h"]);

    // Measures of rings alone are empty; the report and a file beside the tables say why.
    assert!(
        ["speed_sd_over_vehicles_mps", "passages_per_h", "fuel_l_100km"].iter().all(|name| trial[*name].is_empty())
    );
    assert!(
        ["mean_speed_mps", "ego_mean_speed_mps", "ego_fuel_l_100km", "red_lights"]
            .iter()
            .all(|name| !trial[*name].is_empty())
    );
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let columns = fs::read_to_string(out.join("columns.json")).unwrap();
    for text in [&page, &columns] {
        assert!(text.contains("not on networks: streets, turns and signals make speeds differ without any wave"));
    }
    assert!(page.contains("Not measured on networks, for reasons given in the"));
    for file in ["space-time-1.svg", "speeds-1.svg", "mean-speed-1.svg"] {
        let svg = fs::read_to_string(out.join("figures").join(file)).unwrap();
        roxmltree::Document::parse(&svg).unwrap();
        assert!(page.contains("Positions of all vehicles in the lanes of the ego vehicle's path"), "{file}");
    }
}

#[test]
fn lines_outside_the_network_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let ring = folder.path().join("ring");
    super::record(&ring, "2");
    let (code, text) = analyse(&ring, &["--line", "B0B1:5"]);
    assert!(code != 0 && text.contains("--line B0B1:5: no recording is of a network"), "{text}");
    let (code, text) = analyse(&ring, &["--line", "B0B1"]);
    assert!(code != 0 && text.contains("allowed: LANE_OR_EDGE:METRES"), "{text}");
}

/// Records a drive of 20 s with the ego alone on the grid.
fn alone(folder: &Path) -> std::path::PathBuf {
    let (drive, scenario) = (folder.join("alone"), folder.join("alone.toml"));
    let net = fs::canonicalize("tests/data/networks/grid-signals.net.xml").unwrap();
    fs::write(&scenario, format!("map = {net:?}\npath = \"A0B0 B0B1 B1C1 C1C0\"\nduration_s = 20.0\n")).unwrap();
    let arguments = ["run", "--scenario", scenario.to_str().unwrap(), "--out", drive.to_str().unwrap()];
    assert_eq!(printed(&mut codrive(&arguments)).0, 0);
    drive
}

#[test]
fn an_ego_alone_on_a_network_is_analysed() {
    let folder = tempfile::tempdir().unwrap();
    let drive = alone(folder.path());
    let (code, text) = analyse(&drive, &["--line", "B0B7:5"]);
    assert!(code != 0 && text.contains("the network has no edge or lane of this name (did you mean B0B1"), "{text}");
    let (code, text) = analyse(&drive, &[]);
    assert_eq!(code, 0, "{text}");
    let trial = &rows(&drive.join("analysis/trials.csv"))[0];
    // With the ego alone every speed is its own; it may or may not pass the middle of its path.
    let [mean, space_mean] = ["mean_speed_mps", "space_mean_speed_mps"].map(|name| number(trial, name).unwrap());
    assert!((mean - space_mean).abs() < 0.2, "{mean} {space_mean}");
    assert_eq!(trial["vehicles"], "1");
    let line = &rows(&drive.join("analysis/lines.csv"))[0];
    let cars = TableReader::parquet(&Table::Cars.parquet(&drive)).unwrap();
    let (lanes, s_m) = (cars.words("lane"), cars.numbers("lane_s_m"));
    let (edge, at_m) = line["line"].split_once(':').unwrap();
    let is_past = |i: usize| {
        let on_edge = lanes[i].rsplit_once('_').is_some_and(|(of, _)| of == edge);
        on_edge && s_m[i].unwrap() >= at_m.parse::<f64>().unwrap()
    };
    assert_eq!(line["passages"], if (0..cars.rows()).any(is_past) { "1" } else { "0" });
}
