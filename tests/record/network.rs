//! Recordings of drives on networks: the table of cars has the vehicles that enter and leave, the recording includes the demand, and the
//! drive replays to the bit.

use super::{codrive, printed};
use codrive::{
    record::{Manifest, Table, TableReader, recover},
    traffic::sumo,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Writes a scenario with a demand file beside it and returns the scenario's path.
pub fn town(folder: &Path) -> std::path::PathBuf {
    let trips: String = (0..40)
        .map(|k| format!("<trip id=\"v{k}\" depart=\"{k}\" from=\"B0B1\" to=\"B1C1\" departLane=\"best\"/>\n"))
        .collect();
    fs::write(folder.join("trips.rou.xml"), format!("<routes>\n{trips}</routes>\n")).unwrap();
    let net = fs::canonicalize("tests/data/networks/grid-signals.net.xml").unwrap();
    let text = format!(
        "map = {net:?}\npath = \"A0B0 B0B1 B1C1 C1C2 C2B2\"\nwarm_up_s = 10.0\nduration_s = 120.0\n\n[demand]\nfiles = [\"trips.rou.xml\"]\n\n\
         [[demand.flows]]\nfrom = \"A0B0\"\nto = \"B2C2\"\nper_hour = 500.0\nmix = [{{ kind = \"car\", share = 3.0 }}, {{ kind = \"truck\", \
         share = 1.0 }}]\n"
    );
    let file = folder.join("town.toml");
    fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_network_drive_has_its_vehicles_in_the_tables_and_replays_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = town(folder.path());
    let hashes: Vec<Option<String>> = ["p1", "p2"]
        .map(|name| {
            let drive = folder.path().join(name);
            let arguments = ["run", "--scenario", scenario.to_str().unwrap(), "--out", drive.to_str().unwrap()];
            let (code, text) = printed(&mut codrive(&arguments));
            assert!(code == 0 && text.contains("vehicles that enter and leave on"), "{text}");
            Manifest::load(&drive).unwrap().hash
        })
        .into();
    assert!(hashes[0].is_some() && hashes[0] == hashes[1], "{hashes:?}");

    let drive = folder.path().join("p1");
    let cars = TableReader::parquet(&Table::Cars.parquet(&drive)).unwrap();
    let (ticks, ids, lanes) = (cars.wholes("tick"), cars.ids("car"), cars.words("lane"));
    let (s_m, lane_s_m, x_m) = (cars.numbers("s_m"), cars.numbers("lane_s_m"), cars.numbers("x_m"));
    let of_step = |tick: u64| -> BTreeSet<u32> {
        (0..cars.rows()).filter(|&i| ticks[i] == tick).map(|i| ids[i].unwrap()).collect()
    };
    let (early, late) = (of_step(100), of_step(ticks[cars.rows() - 1]));
    assert!(early.contains(&0) && late.contains(&0), "the ego is there all the time");
    assert!(!early.is_subset(&late) && !late.is_subset(&early), "others come and go: {early:?} {late:?}");
    assert!(x_m.iter().all(Option::is_some));
    let beside = (0..cars.rows()).filter(|&i| s_m[i].is_none()).count();
    assert!(beside > 100 && beside < cars.rows() - 100, "{beside} of {} rows are beside the path", cars.rows());
    // B1B2 is not on the path.
    let off = (0..cars.rows()).filter(|&i| lanes[i].starts_with("B1B2"));
    assert!(off.clone().count() > 10 && off.into_iter().all(|i| s_m[i].is_none() && lane_s_m[i].is_some()));

    // At a full second every vehicle has a row, as departures and arrivals say; between full seconds only those within 100 m of the ego.
    let came =
        |table: Table| -> Vec<u64> { TableReader::parquet(&table.parquet(&drive)).unwrap().wholes("tick").to_vec() };
    let (departures, arrivals) = (came(Table::Departures), came(Table::Arrivals));
    let until = |ticks: &[u64], tick: u64| ticks.iter().filter(|&&at| at <= tick).count();
    for tick in (100..=12_000).step_by(100).filter(|tick| *tick <= ticks[cars.rows() - 1]) {
        let here = until(&departures, tick) - until(&arrivals, tick);
        assert_eq!(of_step(tick).len(), here + 1, "at tick {tick}, the ego among them");
    }
    let y_m = cars.numbers("y_m");
    let at = |i: usize| [x_m[i].unwrap(), y_m[i].unwrap()];
    let (mut ego, mut near, mut far) = ([0.0; 2], 0, 0);
    for i in 0..cars.rows() {
        if ids[i] == Some(0) {
            ego = at(i);
        } else if (at(i)[0] - ego[0]).hypot(at(i)[1] - ego[1]) > 100.0 {
            assert_eq!(ticks[i] % 100, 0, "car {:?} at tick {} is far away", ids[i], ticks[i]);
            far += 1;
        } else {
            near += usize::from(ticks[i] % 100 != 0);
        }
    }
    assert!(far > 100 && near > 1000, "{far} {near}");

    // The recording needs no file that it was made from.
    fs::remove_file(folder.path().join("trips.rou.xml")).unwrap();
    let (code, text) = printed(&mut codrive(&["analyse", drive.to_str().unwrap()]));
    assert!(code == 0 && text.contains("of 1 drive"), "{code} {text}");
    headways_have_the_length_of_each_leader(&drive);
    let (code, text) = printed(&mut codrive(&["replay", drive.to_str().unwrap()]));
    assert!(code == 0 && text.contains("are the same to the bit; every file agrees"), "{text}");
}

/// Checks that the analysis has the smallest headway of the tables: the gap plus the length of the leader at that tick.
fn headways_have_the_length_of_each_leader(drive: &Path) {
    let table = |table: Table| TableReader::parquet(&table.parquet(drive)).unwrap();
    let (ego, came) = (table(Table::Ego), table(Table::Departures));
    let lengths: BTreeMap<Option<u32>, f64> =
        came.ids("vehicle").into_iter().zip(came.numbers("length_m").into_iter().flatten()).collect();
    assert!(lengths.values().any(|length_m| *length_m > 6.0), "lorries among cars");
    let rows = ego.ids("leader").into_iter().zip(ego.numbers("gap_m")).zip(ego.numbers("lane_offset_m"));
    let headways = rows.filter_map(|((leader, gap_m), offset_m)| {
        let gap_m = gap_m.filter(|gap_m| *gap_m >= 0.0 && offset_m.unwrap().abs() < 1.8)?;
        Some(gap_m + lengths[&leader])
    });
    let least_m = headways.fold(f64::INFINITY, f64::min);
    let text = fs::read_to_string(drive.join("analysis/trials.csv")).unwrap();
    let [head, cells] = [0, 1].map(|line| text.lines().nth(line).unwrap().split(',').collect::<Vec<_>>());
    let found: f64 = cells[head.iter().position(|name| *name == "min_headway_m").unwrap()].parse().unwrap();
    assert!((found - least_m).abs() < 1e-9, "{found} {least_m}");
}

/// Writes a scenario with an ego in the south of the grid and lorries that cross it in the north, too far apart to see each other. A lorry
/// departs every 4 s, without randomness.
fn lorries(folder: &Path) -> PathBuf {
    let trips: String = (0..15)
        .map(|k| format!("<trip id=\"v{k}\" type=\"lorry\" depart=\"{}\" from=\"A2B2\" to=\"B2C2\"/>\n", 4 * k))
        .collect();
    let kind = "<vType id=\"lorry\" vClass=\"truck\" length=\"9\" width=\"2.5\" height=\"3.5\" carFollowModel=\"IDM\" accel=\"1.2\" \
                decel=\"2\" tau=\"1\" minGap=\"2\" maxSpeed=\"20\" speedDev=\"0\"/>";
    fs::write(folder.join("lorries.rou.xml"), format!("<routes>\n{kind}\n{trips}</routes>\n")).unwrap();
    let net = fs::canonicalize("tests/data/networks/grid-signals.net.xml").unwrap();
    let text = format!(
        "map = {net:?}\npath = \"A0B0 B0B1 B1C1 C1C0 C0B0 B0A0\"\nwarm_up_s = 10.0\nduration_s = 50.0\n\n[demand]\nfiles = \
         [\"lorries.rou.xml\"]\n"
    );
    let file = folder.join("lorries.toml");
    fs::write(&file, text).unwrap();
    file
}

/// Returns the command that records the drive with lorries, and the folder of the recording.
pub fn run_lorries(folder: &Path, name: &str) -> (Command, PathBuf) {
    let (scenario, drive) = (lorries(folder), folder.join(name));
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.env("RUST_LOG", "error").arg("run").arg("--scenario").arg(scenario).arg("--out").arg(&drive);
    (command, drive)
}

/// Runs SUMO's own program on the lorries' demand until `end` s, with the options of the engine and the output files in `outputs`.
pub fn run_sumo(folder: &Path, end: &str, outputs: &[(&str, &Path)]) {
    let home = sumo::home().unwrap();
    let arguments = "--step-length 0.100 --precision 16 --time-to-teleport -1 --collision.action none \
                     --lanechange.duration 5 --no-step-log true --no-warnings true";
    let mut command = Command::new(sumo::program(&home));
    command.env("SUMO_HOME", &home).args(["--net-file", "tests/data/networks/grid-signals.net.xml", "--end", end]);
    command.arg("--route-files").arg(folder.join("lorries.rou.xml")).args(arguments.split_whitespace());
    for (option, path) in outputs {
        command.arg(option).arg(path);
    }
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// Returns the first and the last step of each vehicle in the output of SUMO's own program: time in s, lane, metres along the lane, speed
/// in m/s.
fn written_by_sumo(folder: &Path) -> BTreeMap<String, [(f64, String, f64, f64); 2]> {
    let out = folder.join("fcd.xml");
    run_sumo(folder, "90", &[("--fcd-output", &out)]);
    let text = fs::read_to_string(&out).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let mut found = BTreeMap::new();
    for vehicle in document.descendants().filter(|node| node.has_tag_name("vehicle")) {
        let number = |node: roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
        let time_s = number(vehicle.parent().unwrap(), "time");
        let lane = vehicle.attribute("lane").unwrap().to_owned();
        let seen = (time_s, lane, number(vehicle, "pos"), number(vehicle, "speed"));
        let id = vehicle.attribute("id").unwrap().to_owned();
        let steps = found.entry(id).or_insert_with(|| [seen.clone(), seen.clone()]);
        steps[1] = seen;
    }
    found
}

/// Returns the tick at whose end the engine has the state that SUMO's own program writes for a time in s. The first step of SUMO has time
/// 0; the drive begins after a warm-up of 100 steps.
pub fn tick(time_s: f64) -> i64 {
    10 * ((time_s / 0.1).round() as i64 - 99)
}

#[test]
fn departures_and_arrivals_equal_those_of_the_sumo_program() {
    let folder = tempfile::tempdir().unwrap();
    let (mut command, drive) = run_lorries(folder.path(), "p1");
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let last = TableReader::parquet(&Table::Ego.parquet(&drive)).unwrap().rows() as i64;
    let wanted = written_by_sumo(folder.path());
    assert_eq!(wanted.len(), 15);

    let table = TableReader::parquet(&Table::Departures.parquet(&drive)).unwrap();
    let mut expected: Vec<_> = wanted.values().filter(|[_, gone]| tick(gone.0) >= 0).map(|[first, _]| first).collect();
    expected.sort_by(|a, b| a.0.total_cmp(&b.0));
    let there_before = expected.iter().filter(|first| tick(first.0) < 0).count();
    expected.retain(|first| tick(first.0) <= last);
    let ticks: Vec<i64> = expected.iter().map(|first| tick(first.0).max(0)).collect();
    assert_eq!(table.wholes("tick").iter().map(|tick| *tick as i64).collect::<Vec<_>>(), ticks);
    assert!(there_before >= 2 && ticks.iter().filter(|tick| **tick > 0).count() > 8, "{ticks:?}");
    let (lanes, s_m, speeds) = (table.words("lane"), table.numbers("lane_s_m"), table.numbers("speed_mps"));
    for (row, (_, lane, pos_m, speed_mps)) in expected.iter().enumerate().skip(there_before) {
        assert_eq!(&lanes[row], lane);
        assert!((s_m[row].unwrap() - pos_m).abs() < 1e-9 && (speeds[row].unwrap() - speed_mps).abs() < 1e-9, "{row}");
    }
    // Size and class are those of the demand file.
    assert!(table.words("kind").iter().all(|kind| kind == "truck"));
    for (column, size_m) in [("length_m", 9.0), ("width_m", 2.5), ("height_m", 3.5)] {
        assert!(table.numbers(column).iter().all(|found| *found == Some(size_m)), "{column}");
    }

    let arrivals = TableReader::parquet(&Table::Arrivals.parquet(&drive)).unwrap();
    let mut expected: Vec<_> = wanted.values().map(|[_, gone]| gone).collect();
    expected.sort_by(|a, b| a.0.total_cmp(&b.0));
    expected.retain(|gone| (1..=last).contains(&tick(gone.0 + 0.1)));
    let ticks: Vec<i64> = expected.iter().map(|gone| tick(gone.0 + 0.1)).collect();
    assert_eq!(arrivals.wholes("tick").iter().map(|tick| *tick as i64).collect::<Vec<_>>(), ticks);
    assert!(ticks.len() > 5, "{ticks:?}");
    let (lanes, s_m) = (arrivals.words("lane"), arrivals.numbers("lane_s_m"));
    for (row, (_, lane, pos_m, _)) in expected.iter().enumerate() {
        assert_eq!(&lanes[row], lane);
        assert!((s_m[row].unwrap() - pos_m).abs() < 1e-9, "{row}: {} {pos_m}", s_m[row].unwrap());
    }
    // Every vehicle that arrives has departed.
    let came: BTreeSet<_> = table.ids("vehicle").into_iter().collect();
    assert_eq!(came.len(), table.rows(), "a number is given once");
    assert!(arrivals.ids("vehicle").iter().all(|id| came.contains(id)));
}

/// Returns the states of a signal in the output of SUMO's own program, as time in s and letters, one entry for each change.
fn shown_by_sumo(folder: &Path, signal: &str) -> Vec<(f64, String)> {
    let (out, events) = (folder.join("tls.xml"), folder.join("tls.add.xml"));
    let event = format!("<timedEvent type=\"SaveTLSStates\" source=\"{signal}\" dest=\"{}\"/>", out.display());
    fs::write(&events, format!("<additional>{event}</additional>")).unwrap();
    run_sumo(folder, "70", &[("--additional-files", &events)]);
    let text = fs::read_to_string(&out).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let states = document.descendants().filter(|node| node.has_tag_name("tlsState"));
    let mut found: Vec<(f64, String)> = states
        .map(|node| (node.attribute("time").unwrap().parse().unwrap(), node.attribute("state").unwrap().to_owned()))
        .collect();
    found.dedup_by(|later, earlier| later.1 == earlier.1);
    found
}

#[test]
fn signals_change_when_the_sumo_program_changes_them() {
    let folder = tempfile::tempdir().unwrap();
    let (mut command, drive) = run_lorries(folder.path(), "p1");
    assert!(command.output().unwrap().status.success());
    let last = TableReader::parquet(&Table::Ego.parquet(&drive)).unwrap().rows() as i64;
    let table = TableReader::parquet(&Table::Signals.parquet(&drive)).unwrap();
    let (ticks, signals, states) = (table.wholes("tick"), table.words("signal"), table.words("state"));
    // All signals of the file have a row at the start.
    let at_start: Vec<&str> =
        signals.iter().zip(&ticks).filter(|(_, tick)| **tick == 0).map(|(id, _)| id.as_str()).collect();
    assert_eq!(at_start, ["A1", "B0", "B1", "B2", "C1"]);
    // The ego comes near neither of these two signals; lorries pass one of them.
    for signal in ["A1", "B2"] {
        let written = shown_by_sumo(folder.path(), signal);
        let before = written.iter().rposition(|(time_s, _)| tick(*time_s) <= 0).unwrap();
        let wanted: Vec<(i64, &str)> = written[before..]
            .iter()
            .map(|(time_s, state)| (tick(*time_s).max(0), state.as_str()))
            .filter(|(tick, _)| *tick <= last)
            .collect();
        let rows = (0..table.rows()).filter(|&row| signals[row] == signal);
        let found: Vec<(i64, &str)> = rows.map(|row| (ticks[row] as i64, states[row].as_str())).collect();
        assert_eq!(found, wanted, "{signal}");
        assert!(found.len() > 1, "{signal}: {found:?}");
    }
}

#[test]
fn the_path_follows_the_scenario_on_lanes_that_the_file_connects() {
    let folder = tempfile::tempdir().unwrap();
    let (mut command, drive) = run_lorries(folder.path(), "p1");
    assert!(command.output().unwrap().status.success());
    let path = TableReader::parquet(&Table::Path.parquet(&drive)).unwrap();
    let (edges, lanes) = (path.words("edge"), path.words("lane"));
    let (starts, lengths) = (path.numbers("start_s_m"), path.numbers("length_m"));
    assert_eq!(path.wholes("order"), (0..path.rows() as u64).collect::<Vec<_>>());
    let streets: Vec<&str> = edges.iter().filter(|edge| !edge.starts_with(':')).map(String::as_str).collect();
    assert_eq!(streets, ["A0B0", "B0B1", "B1C1", "C1C0", "C0B0", "B0A0"]);
    // The network file has the length of each lane and the connections between lanes.
    let text = fs::read_to_string("tests/data/networks/grid-signals.net.xml").unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let lane =
        |id: &str| document.descendants().find(|node| node.has_tag_name("lane") && node.attribute("id") == Some(id));
    let edge_of = |lane: &str| lane.rsplit_once('_').unwrap().0.to_owned();
    let connections: BTreeSet<(String, String)> = document
        .descendants()
        .filter(|node| node.has_tag_name("connection"))
        .flat_map(|node| {
            let part = |name| node.attribute(name).unwrap().to_owned();
            let from = format!("{}_{}", part("from"), part("fromLane"));
            match node.attribute("via").map(str::to_owned) {
                Some(via) => vec![(from, edge_of(&via)), (via, part("to"))],
                None => vec![(from, part("to"))],
            }
        })
        .collect();
    let mut start_m = 0.0;
    for k in 0..path.rows() {
        let node = lane(&lanes[k]).expect("a lane of the file");
        assert_eq!(node.parent_element().unwrap().attribute("id"), Some(edges[k].as_str()));
        let length_m: f64 = node.attribute("length").unwrap().parse().unwrap();
        assert_eq!(lengths[k], Some(length_m));
        assert!((starts[k].unwrap() - start_m).abs() < 1e-9, "{k}");
        start_m += length_m;
        if k > 0 {
            // Within an edge the path may change lanes: the recorded lane is the one from which the path leaves the edge.
            let pair = (lanes[k - 1].clone(), edges[k].clone());
            assert!(connections.contains(&pair), "{pair:?}");
        }
    }
    // The path crosses five junctions.
    assert!(path.rows() >= 11, "{lanes:?}");
}

/// Number of tables of a drive on a network.
const TABLES: usize = Table::OF_EVERY_DRIVE.len() + Table::OF_NETWORKS.len();

fn replayed(drive: &Path) -> (i32, String) {
    printed(&mut codrive(&["replay", drive.to_str().unwrap()]))
}

#[test]
fn a_killed_network_drive_keeps_its_tables_and_replays() {
    let folder = tempfile::tempdir().unwrap();
    // No number of rows is promised in the middle of a drive. The last table to be renamed ends the writing of tables.
    let last = format!("finish.table_renamed:{}", TABLES);
    for (point, least) in
        [("tick:4500", 0), ("flush.synced", 1), ("finish.tables_written", 5000), (last.as_str(), 5000)]
    {
        let name = format!("killed-{}", point.replace(':', "-"));
        let (mut command, drive) = run_lorries(folder.path(), &name);
        let output = command.env("CODRIVE_KILL_AT", point).output().unwrap();
        assert_eq!(std::os::unix::process::ExitStatusExt::signal(&output.status), Some(9), "{point}");
        let found = recover(&drive).unwrap();
        assert_eq!(found.kept, None, "nothing is damaged");
        let rows: BTreeMap<&str, u64> = found.rows.iter().map(|(table, rows)| (table.name(), *rows)).collect();
        assert_eq!(rows.len(), TABLES, "{rows:?}");
        assert!(rows["ego"] >= least, "{point}: {rows:?}");
        if rows["ego"] == 0 {
            continue;
        }
        // Six streets and five junctions between them, five signals, and the lorries of 0, 4 and 8 s, which are still on the road at 10 s.
        assert!(rows["path"] >= 11 && rows["signals"] >= 5 && rows["departures"] >= 3, "{point}: {rows:?}");
        assert!(rows["ego"] < 5000 || (rows["departures"] > 8 && rows["arrivals"] > 2), "{point}: {rows:?}");
        let (code, text) = replayed(&drive);
        assert!(code == 0 && text.contains("the same to the bit; every file agrees"), "{text}");
    }
}

#[test]
fn advised_vehicles_of_a_network_are_in_their_table_and_replay_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = town(folder.path());
    let recorded = |policy: &str, duration: &str| {
        let drive = folder.path().join(policy);
        let words = format!("run --policy {policy} --advised 50% --duration {duration}");
        let mut command = codrive(&words.split(' ').collect::<Vec<_>>());
        let (code, text) = printed(command.arg("--scenario").arg(&scenario).arg("--out").arg(&drive));
        assert_eq!(code, 0, "{text}");
        (drive, text)
    };
    let (drive, text) = recorded("pi", "60");
    assert!(text.contains(" vehicles, in order of entry\n"), "{text}");
    let read = |table: Table| TableReader::parquet(&table.parquet(&drive)).unwrap();
    let rows: Vec<(u64, u32)> = read(Table::Advised)
        .wholes("tick")
        .into_iter()
        .zip(read(Table::Advised).ids("vehicle").into_iter().flatten())
        .collect();
    let ids: BTreeSet<u32> = rows.iter().map(|(_, id)| *id).collect();
    let departures = read(Table::Departures);
    let kinds = departures.words("kind").into_iter().zip(departures.ids("vehicle"));
    let cars: BTreeSet<u32> = kinds.filter(|(kind, _)| kind == "car").filter_map(|(_, id)| id).collect();
    // Only cars are advised; the random streams select more than a quarter of them, but not all.
    assert!(ids.is_subset(&cars) && 4 * ids.len() > cars.len() && ids.len() < cars.len(), "{ids:?} of {cars:?}");
    // The trips are 200 m long: the first end within the minute.
    let last = rows.last().unwrap().0;
    let at_end: BTreeSet<u32> = rows.iter().filter(|(tick, _)| *tick == last).map(|(_, id)| *id).collect();
    assert!(at_end.len() < ids.len(), "some have left: {at_end:?} of {ids:?}");
    // Without a policy the same drivers drive, without advice.
    let (without, text) = recorded("none", "20");
    let table = TableReader::parquet(&Table::Advised.parquet(&without)).unwrap();
    assert!(!text.contains("in order of entry") && table.numbers("target_mps").iter().all(Option::is_none), "{text}");
    assert!(table.rows() > 0, "the step of each agent");
    for drive in [drive, without] {
        let (code, text) = replayed(&drive);
        assert!(code == 0 && text.contains("the same to the bit; every file agrees"), "{text}");
    }
}
