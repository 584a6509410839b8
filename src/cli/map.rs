//! `codrive map`: makes, imports, lists and describes road networks.

use super::{CliError, flags, out};
use crate::{
    drive_loop::{RunError, offline::OfflineDrive},
    map::{
        self,
        import::{DrivingSide, ImportOptions},
        network::Network,
    },
    scenario::Scenario,
    sim::Summary,
    traffic::sumo::compare_with_sumo,
};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::{
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
};

/// Duration of the trial drive of a new map, s.
const TRIAL_S: f64 = 10.0;
/// Number of vehicles in the trial drive.
const TRIAL_VEHICLES: u32 = 4;
/// Grade that no street has, as a ratio; the steepest streets have 0.35.
const STEEP: f64 = 0.4;

pub(super) fn command() -> Command {
    let number = |id: &'static str, name: &'static str, help: &'static str| {
        Arg::new(id).long(id).value_name(name).value_parser(value_parser!(f64)).help(help)
    };
    let out = Arg::new("out")
        .long("out")
        .value_name("DIR")
        .value_parser(value_parser!(PathBuf))
        .help("Folder of the new map [default: NAME among your own maps, in ~/.local/share/codrive/maps]");
    let whole = |id: &'static str, name: &'static str, range: std::ops::RangeInclusive<u64>, default: u64| {
        let parser = value_parser!(u64).range(range);
        Arg::new(id).long(id).value_name(name).value_parser(parser).default_value(default.to_string())
    };
    Command::new("map")
        .about("Make, import, list and count road networks")
        .after_help(format!("Limits: {}; a file to import has at most 256 MiB.", map::limits::IN_WORDS))
        .subcommand_required(true)
        .subcommand(Command::new("list").about("List the maps that --map knows"))
        .subcommand(
            Command::new("show")
                .about("Print the contents of a network, and the number of lanes outside the route")
                .arg(Arg::new("map").required(true).value_name("MAP").help("Name of a map, or the path of a net.xml")),
        )
        .subcommand(
            Command::new("path")
                .about("Find the quickest way between places, and print it as a path for --path")
                .after_help(
                    "A place is the id of an edge or of a lane, or a point X,Y in metres of the network.\n\n\
                     Example: codrive map path town.net.xml --from A0B0 --via 120,45 --to C2C1",
                )
                .arg(Arg::new("map").required(true).value_name("MAP").help("Name of a map, or the path of a net.xml"))
                .args(flags::places().map(|arg| if arg.get_id() == "via" { arg } else { arg.required(true) })),
        )
        .subcommand(
            Command::new("ring")
                .about("Make a ring road of any length")
                .arg(number("circumference", "METRES", "Length of the lane, 150 to 5000").required(true))
                .arg(number("speed-limit", "MPS", "Speed limit in m/s").default_value("30"))
                .arg(number("width", "METRES", "Width of the lane").default_value("3.6"))
                .arg(out.clone()),
        )
        .subcommand(
            Command::new("lane")
                .about("Make a straight open lane of any length, for traffic of a file of trajectories")
                .arg(number("length", "METRES", "Length of the lane, 100 to 100000").required(true))
                .arg(number("speed-limit", "MPS", "Speed limit in m/s").default_value("40"))
                .arg(number("width", "METRES", "Width of the lane").default_value("3.6"))
                .arg(out.clone()),
        )
        .subcommand(
            Command::new("circuit")
                .about("Make a circuit from a list of straights and bends (see maps/practice/circuit.toml)")
                .arg(Arg::new("file").required(true).value_name("FILE").value_parser(value_parser!(PathBuf)))
                .arg(out),
        )
        .subcommand(
            Command::new("import")
                .about(
                    "Import a SUMO net.xml, OpenDRIVE (.xodr) or OpenStreetMap (.osm) file as a map, and report the \
                     imported parts",
                )
                .arg(Arg::new("file").required(true).value_name("FILE").value_parser(value_parser!(PathBuf)))
                .arg(
                    Arg::new("name")
                        .long("name")
                        .value_name("NAME")
                        .help("Name of the map [default: the name of the file]"),
                )
                .arg(
                    whole("time-limit", "SECS", 1..=86_400, map::import::SECONDS)
                        .help("Longest run time of netconvert, all attempts together, 1 to 86400 s"),
                )
                .arg(
                    whole("memory-limit", "MIB", 256..=1_048_576, map::import::MEMORY_MIB)
                        .help("Memory limit for each attempt of netconvert, 256 to 1048576 MiB"),
                )
                .arg(
                    Arg::new("driving-side")
                        .long("driving-side")
                        .value_name("SIDE")
                        .value_parser(["left", "right"])
                        .help("Side of traffic, left or right [default: as the roads of an OpenDRIVE file say, by place for OpenStreetMap]"),
                ),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    match matches.subcommand() {
        Some(("ring", m)) => ring(m),
        Some(("lane", m)) => lane(m),
        Some(("circuit", m)) => circuit(m),
        Some(("import", m)) => import(m),
        Some(("show", m)) => show(m),
        Some(("path", m)) => path(m),
        _ => list(),
    }
}

/// Prints the quickest way from one place to another.
fn path(matches: &ArgMatches) -> Result<(), CliError> {
    let name = matches.get_one::<String>("map").map(String::as_str).unwrap_or_default();
    let way = flags::way(matches).unwrap_or_default();
    let words: Vec<&str> = way.split_whitespace().collect();
    let found = map::RoadMap::load_along(name, &words)?;
    let streets = found.route.lanes().iter().filter(|lane| lane.is_street(&found.network));
    let edges: Vec<&str> = streets.map(|lane| lane.edge_id(&found.network)).collect();
    out::line(format_args!("length         {:.0} m along {} edges", found.route.length_m(), edges.len()))?;
    out::line(format_args!("path           {}", edges.join(" ")))?;
    out::line(format_args!("drive it with: codrive --map {name} --path \"{}\"", edges.join(" ")))
}

/// Returns the folder of `--out`, or a folder of this name among the user's own maps.
fn folder(matches: &ArgMatches, name: &str) -> Result<PathBuf, CliError> {
    let named = matches.get_one::<PathBuf>("out").cloned();
    named.or_else(|| Some(map::own_folder()?.join(name))).ok_or_else(|| {
        CliError::Input(
            "no home folder is set, so the map has no default folder\n  remedy: name its folder with --out DIR".into(),
        )
    })
}

/// Returns the number of an argument that is required or has a default.
fn given(matches: &ArgMatches, id: &str) -> f64 {
    matches.get_one::<f64>(id).copied().unwrap_or_default()
}

fn ring(matches: &ArgMatches) -> Result<(), CliError> {
    let ring = map::ring::RingShape {
        circumference_m: given(matches, "circumference"),
        speed_limit_mps: given(matches, "speed-limit"),
        width_m: given(matches, "width"),
    };
    let length = format!("{}", ring.circumference_m);
    let folder = folder(matches, &format!("ring-{length}"))?;
    map::ring::write(&folder, &ring, &format!("Ring of {length} m"), "Made by codrive map ring.")?;
    written(&folder)
}

fn lane(matches: &ArgMatches) -> Result<(), CliError> {
    let lane = map::lane::LaneShape {
        length_m: given(matches, "length"),
        speed_limit_mps: given(matches, "speed-limit"),
        width_m: given(matches, "width"),
    };
    let length = format!("{}", lane.length_m);
    let folder = folder(matches, &format!("lane-{length}"))?;
    map::lane::write(&folder, &lane, &format!("Lane of {length} m"), "Made by codrive map lane.")?;
    written(&folder)
}

fn circuit(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(file) = matches.get_one::<PathBuf>("file") else { return Ok(()) };
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let folder = folder(matches, &stem)?;
    map::circuit::write(&folder, file)?;
    written(&folder)
}

/// Loads the map just written and describes it.
fn written(folder: &Path) -> Result<(), CliError> {
    let path = folder.to_string_lossy();
    // Without a slash it would be the name of another map.
    let path = if map::is_path(&path) { path } else { format!("./{path}").into() };
    let made = map::RoadMap::load(&path)?;
    let is_known = folder.parent().map(Path::to_path_buf) == map::own_folder();
    let drive = if is_known { made.name.clone() } else { path.into_owned() };
    print_map(&made, &drive)
}

fn import(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(file) = matches.get_one::<PathBuf>("file") else { return Ok(()) };
    // `a.net.xml` and `a.osm` both become `a`.
    let stem = file.file_name().unwrap_or_default().to_string_lossy().split('.').next().unwrap_or_default().to_owned();
    let name = matches.get_one::<String>("name").unwrap_or(&stem);
    let number = |id: &str| matches.get_one::<u64>(id).copied().unwrap_or_default();
    let stop = super::stop_on_ctrl_c();
    let side = matches.get_one::<String>("driving-side").map(|side| match side.as_str() {
        "left" => DrivingSide::Left,
        _ => DrivingSide::Right,
    });
    let (seconds, memory_mib) = (number("time-limit"), number("memory-limit"));
    let made = map::import(file, name, &ImportOptions { seconds, memory_mib, stop: &stop, side })?;
    for line in made.report.short() {
        out::line(format_args!("{line}"))?;
    }
    let trial = match &made.map {
        Ok(map) => trial_drive(name, map.route.is_closed(), &stop),
        Err(error) => Err(format!("none: {error}")),
    };
    let (Ok(result) | Err(result)) = &trial;
    out::line(format_args!("trial drive    {result}"))?;
    out::line(format_args!("{}", checked_against_sumo(&made.folder)))?;
    out::line(format_args!(
        "map            {}; the whole report is its {}",
        made.folder.display(),
        map::import::REPORT_FILE
    ))?;
    match trial {
        Ok(_) => out::line(format_args!("drive it with: codrive --map {name}")),
        Err(_) => {
            out::line(format_args!("find a path that can be driven: codrive map path {name} --from EDGE --to EDGE"))
        }
    }
}

/// Compares a new map's network with SUMO's own reading. Returns the result as text.
fn checked_against_sumo(folder: &Path) -> String {
    let file = folder.join("net.xml");
    let network = Network::load(&file.to_string_lossy()).map_err(|error| error.to_string());
    let equal = network.and_then(|network| compare_with_sumo(&network, &file).map_err(|error| error.to_string()));
    equal.map_or_else(|error| format!("warning: {error}"), |equal| format!("checked against SUMO: {equal}"))
}

/// Drives a new map for some seconds with simulated drivers. Returns the result as text, as an error if the route cannot be driven. The
/// map is kept all the same: a person can choose another path on it.
fn trial_drive(map: &str, is_closed: bool, stop: &AtomicBool) -> Result<String, String> {
    let default = Scenario::default();
    let scenario = Scenario {
        map: map.to_owned(),
        // On an open path other vehicles come from a demand, and this number has no effect.
        vehicles: if is_closed { TRIAL_VEHICLES } else { default.vehicles },
        duration_s: TRIAL_S,
        policy: "none".to_owned(),
        ..default
    };
    match trial(&scenario, stop) {
        Ok((summary, is_closed, grade)) => match (summary.contact_count, summary.left_road) {
            (0, 0) if is_closed => {
                Ok(format!("{TRIAL_VEHICLES} simulated drivers drove {:.0} s without a fault", summary.duration_s))
            }
            // An open path gets other vehicles from a demand only, and an import has none.
            (0, 0) => Ok(format!("one simulated driver drove {:.0} s without a fault", summary.duration_s)),
            (0, _) if grade > STEEP => Err(format!(
                "a simulated driver left the road: a grade of {:.0} % is too steep for a vehicle",
                100.0 * grade
            )),
            (0, _) => {
                Err("a simulated driver left the road: the bends of the path may be too tight for a vehicle".to_owned())
            }
            (n, _) => Err(format!("vehicles touched {n} times")),
        },
        Err(error) => Err(format!("failed: {error}")),
    }
}

/// Runs the trial drive. Returns its summary, whether the route is closed, and its steepest grade.
fn trial(scenario: &Scenario, stop: &AtomicBool) -> Result<(Summary, bool, f64), RunError> {
    let mut run = OfflineDrive::new(scenario, [0.0, scenario.duration_s])?;
    while !stop.load(Ordering::Relaxed) && run.world().ended().is_none() {
        match run.step() {
            Err(error) if error.is_interruption() => break,
            other => other?,
        }
    }
    let route = &run.world().map().route;
    let places = (0..route.length_m() as u32).map(|s_m| route.grade(f64::from(s_m)).abs());
    Ok((run.summary(), route.is_closed(), places.fold(0.0, f64::max)))
}

/// Prints length and lanes of a new map; `drive` is its name for `--map`.
fn print_map(made: &map::RoadMap, drive: &str) -> Result<(), CliError> {
    out::line(format_args!(
        "{}: {:.3} m in {} lanes",
        made.net_file.display(),
        made.route.length_m(),
        made.route.lanes().len()
    ))?;
    out::line(format_args!("drive it with: codrive --map {drive}"))
}

fn show(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(name) = matches.get_one::<String>("map") else { return Ok(()) };
    let network = map::network::Network::load(name)?;
    let census = network.census();
    let sides = if network.is_left_hand() { "; left-hand traffic" } else { "" };
    let parts = match census.islands {
        0 | 1 => String::new(),
        parts => format!(", in {parts} unconnected parts"),
    };
    out::line(format_args!("streets        {}{parts}{sides}", census.streets))?;
    out::line(format_args!(
        "lanes          {}, {:.0} m; {} without a connection onwards",
        census.lanes, census.lanes_m, census.ends
    ))?;
    let (inside, connections) = (census.insides, census.connections);
    out::line(format_args!("junctions      {}, {inside} lanes inside, {connections} connections", census.junctions))?;
    let (signalled, idle) = (census.signalled, census.idle_signals);
    out::line(format_args!("signals        {} at {signalled} junctions; {idle} rule no lane", census.signals))?;
    out::line(format_args!("on foot        {} crossings, {} walking areas", census.crossings, census.walking_areas))?;
    match (census.has_heights(), census.heights_m) {
        (true, (low_m, high_m)) => out::line(format_args!("heights        {low_m:.1} to {high_m:.1} m"))?,
        (false, _) => out::line(format_args!("heights        none: flat"))?,
    }
    let dropped = network.sumo_text().dropped();
    if !dropped.is_empty() {
        out::line(format_args!("not for SUMO   {dropped}"))?;
    }
    let map = match map::RoadMap::load(name) {
        Ok(map) => map,
        Err(error @ (map::MapError::NoRoute { .. } | map::MapError::NoPath { .. })) => {
            return out::line(format_args!("closed route   none: {}", first_line(&error)));
        }
        Err(error) => return Err(error.into()),
    };
    let on_route = |lane: &map::network::LaneId| map.route.lanes().iter().any(|of| of.lane == Some(*lane));
    let streets = network.lane_ids().filter(|lane| network.edge_of(*lane).kind.is_street());
    let left_out = streets.filter(|lane| !on_route(lane)).count();
    let length_m = map.route.length_m();
    let kind = if map.route.is_closed() { "closed route" } else { "open path   " };
    out::line(format_args!("{kind}   {length_m:.0} m; it leaves out {left_out} of {} lanes", census.lanes))
}

fn list() -> Result<(), CliError> {
    for info in map::list() {
        // A map that cannot be driven does not hide the others.
        match map::RoadMap::load(&info.name) {
            Ok(map) => out::line(format_args!("{:<12} {:>8.1} m  {}", info.name, map.route.length_m(), info.title))?,
            Err(error) => out::line(format_args!("{:<12} {:>10}  {}", info.name, "-", first_line(&error)))?,
        }
    }
    Ok(())
}

/// Returns the message without the remedy.
fn first_line(error: &map::MapError) -> String {
    error.to_string().lines().next().unwrap_or_default().to_owned()
}
