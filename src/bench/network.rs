//! A step of SUMO on a road network with a thousand vehicles. In: SUMO's netgenerate, which makes ten by ten junctions with signals. Out:
//! [`SumoTimes`]: the step alone, and with all vehicles and signals read.

use super::{TimeStatistics, now, simulation::SumoTimes};
use crate::{
    idm::IdmParams,
    map::network::{EdgeKind, Network},
    private, rng,
    traffic::{
        Demand, TrafficError,
        sumo::{self, NetworkSetup, SumoNetwork},
    },
};
use std::{fmt::Write, fs, path::Path, process::Command, sync::Arc, time::Duration};

/// Vehicles that come, ten a second, and steps in which they do: by then about a thousand are there.
const TRIPS: usize = 1500;
const FILL_STEPS: usize = 1600;
/// Steps that are measured, bare ones and whole ones in turn, so that a change of the machine's speed and of traffic meets both.
const PAIRS: usize = 400;
/// Pairs of which a ratio is made.
const BLOCK: usize = 20;

/// Measures it; how many vehicles there were on average.
///
/// # Errors
/// SUMO or its programs are not here.
pub fn network_step() -> Result<(SumoTimes, f64), TrafficError> {
    let folder = std::env::temp_dir().join(format!("codrive-bench-network-{}", std::process::id()));
    let failed = |error: std::io::Error| TrafficError::Setup(format!("{}: {error}", folder.display()));
    private::folder(&folder).map_err(failed)?;
    let times = grid(&folder).and_then(|setup| measure(&setup));
    let _ = fs::remove_dir_all(&folder);
    times
}

fn measure(setup: &NetworkSetup) -> Result<(SumoTimes, f64), TrafficError> {
    let mut traffic = SumoNetwork::start(setup)?;
    for _ in 0..FILL_STEPS {
        traffic.step(&[])?;
    }
    let (mut bare, mut full, mut vehicles) = (Vec::new(), Vec::new(), 0);
    for _ in 0..PAIRS {
        bare.push(timed(|| traffic.bare_step())?);
        // Whoever came or went in the bare step.
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
        engine: traffic.describe().to_owned(),
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

/// Ten by ten junctions with signals, 200 m apart, two lanes each way, and trips from side to side.
fn grid(folder: &Path) -> Result<NetworkSetup, TrafficError> {
    let home = sumo::home()?;
    let net_file = folder.join("grid.net.xml");
    let failed = |what: String| TrafficError::Setup(format!("netgenerate: {what}"));
    let made = Command::new(home.join("bin/netgenerate"))
        .env("SUMO_HOME", &home)
        .args(["--grid", "--grid.number", "10", "--grid.length", "200", "--grid.attach-length", "200", "-L", "2"])
        .args(["--tls.guess", "--no-turnarounds", "--output-file"])
        .arg(&net_file)
        .output()
        .map_err(|error| failed(error.to_string()))?;
    if !made.status.success() {
        return Err(failed(String::from_utf8_lossy(&made.stderr).into_owned()));
    }
    let network = Network::load(&net_file.to_string_lossy()).map_err(|error| failed(error.to_string()))?;
    // Edges are named by the junctions at their ends: those that come in from a side, and those that lead out to one.
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
    fs::write(&file, trips + "</routes>\n").map_err(|error| failed(error.to_string()))?;
    Ok(NetworkSetup {
        network: Arc::new(network),
        net_file,
        demand: Demand { files: vec![file], flows: Vec::new() },
        egos: Vec::new(),
        idm: IdmParams::default(),
        step_s: 0.1,
        seed: 1,
    })
}
