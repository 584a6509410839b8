//! SUMO on a road network: a step with a thousand vehicles, and the reading of a network of ten thousand edges. In: SUMO's
//! netgenerate, which makes grids of junctions with signals. Out: [`SumoTimes`], the step alone and with all vehicles and
//! signals read; [`NetworkLoading`]; and scenarios on such grids and among a thousand vehicles in a town, to be drawn.

use super::{TimeStatistics, now, simulation::SumoTimes};
use crate::{
    idm::IdmParams,
    map::network::{EdgeKind, LaneId, Network},
    rng,
    scenario::Scenario,
    temporary::TemporaryFolder,
    traffic::{
        Demand, DemandSetup, Traffic, TrafficDrivers, TrafficError,
        sumo::{self, SumoTraffic},
    },
};
use serde::Serialize;
use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
    time::Duration,
};

/// Number of vehicles that enter, ten a second, and number of steps before the measurement; about a thousand are then present.
const TRIPS: usize = 1500;
const FILL_STEPS: usize = 1600;
/// Number of measured pairs of a bare and a full step, taken in turn so that changes of machine speed and traffic affect both.
const PAIRS: usize = 400;
/// Number of pairs in each ratio.
const BLOCK: usize = 20;

/// Options of netgenerate for grids of 98 and of 10,200 edges of two lanes, with signals.
const SMALL_GRID: [&str; 8] =
    ["--grid.x-number", "5", "--grid.y-number", "6", "--grid.length", "100", "-j", "traffic_light"];
const LARGE_GRID: [&str; 6] = ["--grid.number", "51", "--grid.length", "100", "-j", "traffic_light"];

/// Time to read a network.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NetworkLoading {
    /// Number of edges outside junctions.
    pub edges: usize,
    /// Size of the file, MB.
    pub file_mb: f64,
    /// Time from the file to the network, including all derived tables, s.
    pub seconds: f64,
}

/// Reads a network of 51 by 51 junctions with signals and two lanes each way.
///
/// # Errors
/// SUMO's netgenerate is missing.
pub fn network_loading() -> Result<NetworkLoading, TrafficError> {
    in_folder(|folder| {
        let file = netgenerate(folder, &LARGE_GRID)?;
        let start = now();
        let network = Network::load(&file.to_string_lossy()).map_err(|error| TrafficError::Setup(error.to_string()))?;
        let seconds = start.elapsed().as_secs_f64();
        let edges = network.edges().iter().filter(|edge| edge.kind.is_street()).count();
        let bytes = fs::metadata(&file).map_or(0, |file| file.len());
        Ok(NetworkLoading { edges, file_mb: bytes as f64 / 1e6, seconds })
    })
}

/// Measures a step of SUMO on a network. Returns the times and the mean number of vehicles.
///
/// # Errors
/// SUMO or its programs are missing.
pub fn network_step() -> Result<(SumoTimes, f64), TrafficError> {
    in_folder(|folder| measure(&grid(folder)?))
}

/// Does some work in a temporary folder.
fn in_folder<T>(work: impl FnOnce(&Path) -> Result<T, TrafficError>) -> Result<T, TrafficError> {
    let folder = TemporaryFolder::new().map_err(|error| TrafficError::Setup(error.to_string()))?;
    work(folder.path())
}

/// Makes a grid by SUMO's netgenerate with these options, two lanes each way. Returns the network file.
fn netgenerate(folder: &Path, options: &[&str]) -> Result<PathBuf, TrafficError> {
    let home = sumo::home()?;
    let net_file = folder.join("grid.net.xml");
    let failed = |what: String| TrafficError::Setup(format!("netgenerate: {what}"));
    let made = Command::new(home.join("bin/netgenerate"))
        .env("SUMO_HOME", &home)
        .args(["--grid", "-L", "2"])
        .args(options)
        .arg("--output-file")
        .arg(&net_file)
        .output()
        .map_err(|error| failed(error.to_string()))?;
    if made.status.success() { Ok(net_file) } else { Err(failed(String::from_utf8_lossy(&made.stderr).into_owned())) }
}

/// Returns a drive along a few edges of a grid with 98 edges, or with 10,200. The network is written to `folder`.
///
/// # Errors
/// SUMO's netgenerate is missing.
pub(super) fn drive_on_grid(folder: &Path, is_large: bool, scenario: &Scenario) -> Result<Scenario, TrafficError> {
    let folder = folder.join(if is_large { "large" } else { "small" });
    fs::create_dir_all(&folder).map_err(|error| TrafficError::Setup(format!("{}: {error}", folder.display())))?;
    let (file, path) = if is_large {
        (netgenerate(&folder, &LARGE_GRID)?, "AA0AA1 AA1AA2 AA2AA3 AA3AA4")
    } else {
        (netgenerate(&folder, &SMALL_GRID)?, "A0A1 A1A2 A2A3 A3A4")
    };
    Ok(Scenario { map: file.to_string_lossy().into_owned(), path: path.into(), ..on_network(scenario) })
}

/// Returns a drive through the town among a thousand vehicles, which start at random places; their ways are written to `folder`.
///
/// # Errors
/// The town cannot be read, or the folder cannot be written.
pub(super) fn drive_in_full_town(folder: &Path, scenario: &Scenario) -> Result<Scenario, TrafficError> {
    const VEHICLES: usize = 1000;
    const MOST_EDGES: usize = 12;
    let failed = |error: &dyn std::fmt::Display| TrafficError::Setup(error.to_string());
    let network = Network::load("town").map_err(|error| failed(&error))?;
    let admits = |lane: &LaneId| network.is_driven(*lane) && network.lane(*lane).admits_cars();
    let lanes: Vec<LaneId> =
        network.lane_ids().filter(|lane| network.edge_of(*lane).kind.is_street() && admits(lane)).collect();
    let mut stream = rng::stream(1, "bench");
    let mut trips = String::from("<routes>\n<vType id=\"car\" carFollowModel=\"Krauss\"/>\n");
    for k in 0..VEHICLES {
        // A walk at random: not every street leads to every other one.
        let mut lane = lanes[stream.index(lanes.len())];
        let mut edges = vec![network.edge_of(lane).id.as_str()];
        while edges.len() < MOST_EDGES {
            let beside = network.edge_of(lane).lanes().filter(admits);
            let ways = beside.flat_map(|lane| network.connections_from(lane)).filter(|way| !way.is_turnaround());
            let onwards: Vec<LaneId> = ways.map(|way| way.to).filter(admits).collect();
            let Some(next) = (!onwards.is_empty()).then(|| onwards[stream.index(onwards.len())]) else { break };
            lane = next;
            edges.push(network.edge_of(lane).id.as_str());
        }
        writeln!(
            trips,
            "<vehicle id=\"v{k}\" type=\"car\" depart=\"0\" departLane=\"random\" departPos=\"random_free\"><route edges=\"{}\"/></vehicle>",
            edges.join(" ")
        )
        .expect("a String takes all text");
    }
    let file = folder.join("full-town.rou.xml");
    fs::write(&file, trips + "</routes>\n").map_err(|error| failed(&error))?;
    let demand = Demand { files: vec![file], ..Demand::default() };
    Ok(Scenario { map: "town".into(), demand, ..on_network(scenario) })
}

/// Returns the default scenario with the picture of this one.
fn on_network(scenario: &Scenario) -> Scenario {
    Scenario { display: scenario.display.clone(), ..Scenario::default() }
}

fn measure(setup: &DemandSetup) -> Result<(SumoTimes, f64), TrafficError> {
    let mut traffic = SumoTraffic::start_with_demand(setup)?;
    for _ in 0..FILL_STEPS {
        traffic.step(&[])?;
    }
    let (mut bare, mut full, mut vehicles) = (Vec::new(), Vec::new(), 0);
    for _ in 0..PAIRS {
        bare.push(timed(|| traffic.bare_step())?);
        // Reads the vehicles that entered or left in the bare step.
        traffic.read()?;
        full.push(timed(|| traffic.step(&[]))?);
        vehicles += traffic.vehicles().len();
    }
    let mean = |times: &[Duration]| times.iter().sum::<Duration>().as_secs_f64() / times.len() as f64;
    let mut ratios: Vec<f64> =
        bare.chunks(BLOCK).zip(full.chunks(BLOCK)).map(|(bare, full)| mean(full) / mean(bare)).collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = ratios[ratios.len() / 2];
    let times = SumoTimes {
        engine: traffic.name_and_version().to_owned(),
        bare: TimeStatistics::of(bare),
        full: TimeStatistics::of(full),
        ratio,
    };
    Ok((times, vehicles as f64 / PAIRS as f64))
}

fn timed(call: impl FnOnce() -> Result<(), TrafficError>) -> Result<Duration, TrafficError> {
    let start = now();
    call()?;
    Ok(start.elapsed())
}

/// Makes a grid of ten by ten junctions with signals, 200 m apart, two lanes each way, and trips from side to side.
fn grid(folder: &Path) -> Result<DemandSetup, TrafficError> {
    let net_file = netgenerate(
        folder,
        &[
            "--grid.number",
            "10",
            "--grid.length",
            "200",
            "--grid.attach-length",
            "200",
            "--tls.guess",
            "--no-turnarounds",
        ],
    )?;
    let failed = |error: std::io::Error| TrafficError::Setup(format!("{}: {error}", folder.display()));
    let network = Network::load(&net_file.to_string_lossy()).map_err(|error| TrafficError::Setup(error.to_string()))?;
    // Edges are named by the junctions at their ends; those of interest start or end at a side.
    let sides = ["left", "right", "top", "bottom"];
    let starts = |id: &&String| sides.iter().any(|side| id.starts_with(side));
    let edges = || network.edges().iter().filter(|edge| edge.kind == EdgeKind::Normal).map(|edge| &edge.id);
    let from: Vec<&String> = edges().filter(starts).collect();
    let to: Vec<&String> = edges().filter(|id| !starts(id) && sides.iter().any(|side| id.contains(side))).collect();
    let mut stream = rng::stream(1, "bench");
    let mut trips = String::from("<routes>\n");
    for k in 0..TRIPS {
        let (from, to) = (from[stream.index(from.len())], to[stream.index(to.len())]);
        let at = k as f64 / 10.0;
        writeln!(trips, "<trip id=\"v{k}\" depart=\"{at}\" from=\"{from}\" to=\"{to}\" departLane=\"best\"/>")
            .expect("a String takes all text");
    }
    let file = folder.join("trips.rou.xml");
    fs::write(&file, trips + "</routes>\n").map_err(failed)?;
    Ok(DemandSetup {
        network: Arc::new(network),
        net_file,
        demand: Demand { files: vec![file], ..Demand::default() },
        egos: Vec::new(),
        first_number: 0,
        drivers: TrafficDrivers::Alike(IdmParams::default()),
        step_s: 0.1,
        until_s: 3600.0,
        seed: 1,
    })
}
