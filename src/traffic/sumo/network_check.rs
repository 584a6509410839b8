//! Whether SUMO survives a network. In: a network file. Out: nothing, or an error that names it. SUMO in this process takes
//! the whole program along where it breaks down (12 of 1,000 networks with a mutation did), so one that is not ours, byte
//! by byte, is read by our own reader first and then driven a little by a child process, within limits of time and memory.
//! The result holds for the bytes of the file as long as the program runs.

use super::{
    SumoTraffic,
    inputs::Inputs,
    network::{EgoStart, NetworkSetup, SumoNetwork},
};
use crate::{
    data_folders,
    map::{
        MapError, RoadMap,
        network::{LaneId, Network},
    },
    space::CAR_LENGTH_M,
    traffic::{
        Demand, ExternalVehicleState, ModelMixture, NoiseStreams, Traffic, TrafficError, TrafficSetup, VehicleReport,
        is_interrupted, start,
    },
};
use sha2::{Digest, Sha256};
use std::{
    collections::BTreeMap,
    env::{self, consts},
    ffi::OsString,
    io::Read,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{Arc, Mutex, OnceLock, PoisonError},
    thread::sleep,
    time::{Duration, Instant},
};

/// Name of the hidden command of the program that the child runs.
pub const COMMAND: &str = "check-network";
/// How long the child may take: the largest network that our reader takes (a town) takes SUMO some seconds.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Address space of the child, bytes: SUMO's libraries take 1 GiB of it, a town's network less.
const MOST_MEMORY: u64 = 4 << 30;
/// Steps of the child's drive, half of them with an ego that is told where it is.
const STEPS: usize = 60;
/// Cars of the child's drive, at most.
const MOST_CARS: usize = 60;
/// What the child may say that is kept, bytes.
const MOST_WORDS: u64 = 4096;

/// The program and the arguments before the network's file that the child is started with, where that is not this program.
static CHECKER: OnceLock<(PathBuf, Vec<OsString>)> = OnceLock::new();

/// Lets the child be another program: one that calls [`try_network`] with its last argument, and where that fails says why on its standard
/// error and ends with 1. For whoever has this program as a library.
pub fn check_networks_by(program: PathBuf, arguments: Vec<OsString>) {
    let _ = CHECKER.set((program, arguments));
}

/// What is known of a network: nothing bad, or why it cannot be used.
type Known = BTreeMap<[u8; 32], Result<(), NetworkFault>>;

/// Why SUMO cannot have a network.
#[derive(Clone, Debug, thiserror::Error)]
enum NetworkFault {
    /// It reads and reads.
    #[error("SUMO did not read this network within {} s{REMEDY}", TIMEOUT.as_secs())]
    TimedOut,
    /// It says why not, and perhaps what helps.
    #[error("SUMO cannot drive on this network: {0}{remedy}", remedy = if .0.contains("\n  remedy: ") { "" } else { REMEDY })]
    Refused(String),
    /// It ended without a word; how.
    #[error("SUMO crashes on this network ({0}){REMEDY}")]
    Crashed(std::process::ExitStatus),
}

impl NetworkFault {
    /// The same with the file that somebody knows in the place of its copy.
    fn about(self, copy: &Path, net_file: &Path) -> Self {
        let named = |words: String| words.replace(&*copy.to_string_lossy(), &net_file.to_string_lossy());
        match self {
            Self::Refused(words) => Self::Refused(named(words)),
            other => other,
        }
    }
}

/// What helps against all of them, where nothing closer is said.
const REMEDY: &str = "\n  remedy: repair it with SUMO's netconvert (--sumo-net-file OLD --output-file NEW), or import it again with codrive map import";

/// Fails if a network is not one that SUMO from the folder `home` can be given in this process; messages name `net_file`.
///
/// # Errors
/// SUMO refuses it or breaks down on it.
pub(super) fn check(home: &Path, network: &Network, net_file: &Path) -> Result<(), TrafficError> {
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    let about = |text: String| TrafficError::Setup(format!("{}: {text}", net_file.display()));
    let bytes = network.sumo_text().as_str().as_bytes();
    // By their bytes: a mark in a file would not do, for a damaged copy keeps it.
    if data_folders::is_shipped_network(bytes) {
        return Ok(());
    }
    let hash: [u8; 32] = Sha256::digest(bytes).into();
    // One check at a time: a second one of the same network waits for the first and has its result.
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(result) = known.get(&hash) {
        return result.clone().map_err(|fault| about(fault.to_string()));
    }
    // The child reads what SUMO would read here.
    let inputs = Inputs::of_network(network, net_file)?;
    let result = try_in_child(home, inputs.net())?.map_err(|fault| fault.about(inputs.net(), net_file));
    known.insert(hash, result.clone());
    result.map_err(|fault| about(fault.to_string()))
}

/// What a child process finds.
fn try_in_child(home: &Path, net_file: &Path) -> Result<Result<(), NetworkFault>, TrafficError> {
    let (program, arguments) = match CHECKER.get() {
        Some((program, arguments)) => (program.clone(), arguments.clone()),
        None => (own_program()?, vec![COMMAND.into()]),
    };
    let failed = |error: std::io::Error| TrafficError::Setup(format!("{}: {error}", program.display()));
    let mut child = Command::new(&program)
        .args(arguments)
        .arg(net_file)
        .env("CODRIVE_SUMO_HOME", home)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    let words = child.stderr.take().map(|mut stderr| {
        std::thread::spawn(move || {
            let mut words = Vec::new();
            let _ = stderr.by_ref().take(MOST_WORDS).read_to_end(&mut words);
            // The rest is read, too: a child that cannot write would wait.
            let _ = std::io::copy(&mut stderr, &mut std::io::sink());
            words
        })
    });
    let ended = wait(&mut child);
    if ended.is_err() {
        // It may have ended meanwhile.
        let _ = child.kill();
        let _ = child.wait();
    }
    let words = words.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let words = String::from_utf8_lossy(&words);
    let words = words.trim().trim_start_matches("codrive: ");
    let status = match ended {
        Ok(status) => status,
        Err(Ended::Interrupted) => return Err(TrafficError::Interrupted),
        Err(Ended::TimedOut) => return Ok(Err(NetworkFault::TimedOut)),
        Err(Ended::System(error)) => return Err(failed(error)),
    };
    Ok(match status.code() {
        Some(0) => Ok(()),
        Some(_) => Err(NetworkFault::Refused(words.into())),
        None => Err(NetworkFault::Crashed(status)),
    })
}

/// Why a child was not waited for any longer.
enum Ended {
    Interrupted,
    TimedOut,
    System(std::io::Error),
}

fn wait(child: &mut Child) -> Result<std::process::ExitStatus, Ended> {
    let begun = now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(status),
            Ok(None) if is_interrupted() => return Err(Ended::Interrupted),
            Ok(None) if begun.elapsed() > TIMEOUT => return Err(Ended::TimedOut),
            Ok(None) => sleep(Duration::from_millis(10)),
            Err(error) => return Err(Ended::System(error)),
        }
    }
}

/// The program itself: a test or a benchmark finds it beside its own folder.
fn own_program() -> Result<PathBuf, TrafficError> {
    let name = format!("codrive{}", consts::EXE_SUFFIX);
    let here = env::current_exe().unwrap_or_default();
    let candidates = here.ancestors().skip(1).take(2).map(|folder| folder.join(&name));
    candidates.into_iter().find(|path: &PathBuf| path.is_file()).ok_or_else(|| {
        let text = format!(
            "a network that does not come with codrive is tried in a process of its own first, and the program {name} for \
             that is not beside {}\n  remedy: put it there, or build it with cargo build",
            here.display()
        );
        TrafficError::Setup(text)
    })
}

/// What the child does: limits itself, and drives some cars on the network for a few seconds of simulation.
///
/// # Errors
/// Our reader or SUMO refuses the network.
pub fn try_network(net_file: &Path) -> Result<(), TrafficError> {
    limit();
    let map = match RoadMap::load(&net_file.to_string_lossy()) {
        Ok(map) if !map.route.is_closed() => return try_roads(net_file),
        Ok(map) => Arc::new(map),
        Err(MapError::NoRoute { .. }) => return try_roads(net_file),
        Err(error) => return Err(TrafficError::Setup(error.to_string())),
    };
    let length_m = map.route.length_m();
    let idm = crate::idm::IdmParams::default();
    let fit = (length_m / (2.0 * CAR_LENGTH_M + idm.s0)) as usize;
    let cars = start::even(fit.clamp(2, MOST_CARS), length_m, idm.s0, 0.0)?;
    let step_s = 0.1;
    let setup = TrafficSetup {
        map: Arc::clone(&map),
        cars,
        idm,
        mixture: ModelMixture::default(),
        step_s,
        seed: 1,
        noise_streams: NoiseStreams::Own,
        timeout_s: 1.0,
        lateral_accel_mps2: None,
    };
    let mut traffic = match SumoTraffic::start_unchecked(&super::home()?, setup) {
        Ok(traffic) => traffic,
        // Its loop is none for SUMO's cars, and a path along other edges may be driven.
        Err(TrafficError::RouteChangesLanes { .. } | TrafficError::RouteForks { .. }) => return try_roads(net_file),
        Err(error) => return Err(error),
    };
    for step in 0..STEPS {
        let ego = traffic.cars()[0];
        let report = (step >= STEPS / 2).then(|| ExternalVehicleState {
            pose: ego.pose(&map.route),
            speed_mps: ego.speed_mps,
            next_pose: map.route.pose_of_front(ego.s_m + ego.speed_mps * step_s, CAR_LENGTH_M),
            next_speed_mps: ego.speed_mps,
        });
        traffic.step(report.map(VehicleReport::of_ego).as_slice())?;
    }
    Ok(())
}

/// The same for a network without a closed route: cars that SUMO drives from streets to the next.
fn try_roads(net_file: &Path) -> Result<(), TrafficError> {
    let network = Network::load(&net_file.to_string_lossy()).map_err(|error| TrafficError::Setup(error.to_string()))?;
    let network = Arc::new(network);
    let start = |lane: LaneId| {
        let way = network.connections_from(lane).iter().find(|way| network.lane(way.to).admits_cars())?;
        let is_street = network.edge_of(lane).kind.is_street() && network.lane(lane).admits_cars();
        let route = [lane, way.to].map(|lane| network.edge_of(lane).id.clone());
        let s_m = network.lane(lane).length_m.min(2.0 * CAR_LENGTH_M);
        is_street.then(|| EgoStart { lane, s_m, speed_mps: 0.0, route: route.into() })
    };
    let egos = network.lane_ids().filter_map(start).take(MOST_CARS).collect();
    let setup = NetworkSetup {
        network: Arc::clone(&network),
        net_file: net_file.into(),
        demand: Demand::default(),
        egos,
        idm: crate::idm::IdmParams::default(),
        step_s: 0.1,
        seed: 1,
    };
    let mut traffic = SumoNetwork::start_unchecked(&super::home()?, &setup)?;
    (0..STEPS).try_for_each(|_| traffic.step(&[]))
}

/// Bounds the memory of this process, and keeps a breakdown from leaving an image of it on the disk.
fn limit() {
    #[cfg(target_os = "linux")]
    {
        use nix::sys::resource::{Resource, setrlimit};
        // Where the system refuses there is no limit, and the time-out is left.
        let _ = setrlimit(Resource::RLIMIT_AS, MOST_MEMORY, MOST_MEMORY);
        let _ = setrlimit(Resource::RLIMIT_CORE, 0, 0);
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "a time-out for another process is a matter of wall time, not of simulation"
)]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_network_in_maps_is_known_as_ours() {
        let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
        let nets: Vec<_> =
            std::fs::read_dir(maps).unwrap().map(|folder| folder.unwrap().path().join("net.xml")).collect();
        assert_eq!(nets.len(), 4);
        for net in nets {
            assert!(data_folders::is_shipped_network(&std::fs::read(&net).unwrap()), "{}", net.display());
        }
    }

    #[test]
    fn one_remedy_is_said_and_the_closer_one() {
        let bare = NetworkFault::Refused("edge a is nowhere".into()).to_string();
        assert!(
            bare.starts_with("SUMO cannot drive on this network: edge a is nowhere\n  remedy: repair it"),
            "{bare}"
        );
        let closer = NetworkFault::Refused("edge a is nowhere\n  remedy: name another".into()).to_string();
        assert!(closer.ends_with("nowhere\n  remedy: name another"), "{closer}");
    }
}
