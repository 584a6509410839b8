//! Trial of SUMO on a network and the demand of a drive. In: their files. Out: nothing, or an error that names them. SUMO in this
//! process takes the whole program along where it breaks down (12 of 1,000 networks with a mutation did), so files that are
//! not ours, byte by byte, are read by our own readers first and then driven a little by a child process, within limits of
//! time and memory. The result holds for the bytes of all files together as long as the program runs.

use super::{
    SumoTraffic,
    network::{EgoStart, NetworkSetup, SumoNetwork},
    trial_process::{self, Ended, TIMEOUT},
};
use crate::{
    data_folders, file,
    map::{
        MapError, RoadMap,
        limits::MOST_BYTES,
        network::{LaneId, Network},
    },
    space::CAR_LENGTH_M,
    sumo_xml::stream,
    temporary::TemporaryFolder,
    traffic::{
        Demand, ExternalVehicleState, ModelMixture, Traffic, TrafficError, TrafficSetup, VehicleReport, go_on, start,
    },
};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::{
    collections::BTreeMap,
    env::{self, consts},
    ffi::OsString,
    path::{Path, PathBuf},
    process::{Command, ExitStatus},
    sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError},
    thread::sleep,
    time::Duration,
};

/// Name of the hidden command of the program that the child runs.
pub const COMMAND: &str = "check-network";
/// Steps of the child's drive, half of them with an ego that is told where it is.
const STEPS: usize = 60;
/// Cars of the child's drive, at most.
const MOST_CARS: usize = 60;
/// The most bytes of a trial's file: room for a demand with many flows of its own.
const MOST_TRIAL_BYTES: u64 = 64 << 20;

/// The program and the arguments before the trial's file that the child is started with, where that is not this program.
static CHECKER: OnceLock<(PathBuf, Vec<OsString>)> = OnceLock::new();

/// Lets the child be another program: one that calls [`try_network`] with its last argument, and where that fails says why on its standard
/// error and ends with 1. For whoever has this program as a library.
pub fn check_networks_by(program: PathBuf, arguments: Vec<OsString>) {
    let _ = CHECKER.set((program, arguments));
}

/// Files on which SUMO is to be tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Trial {
    /// The network.
    pub net_file: PathBuf,
    /// The demand of the drive; none on a closed route.
    pub demand: Demand,
    /// True if the drive has an ego, or moves all cars of a closed route.
    pub has_ego: bool,
}

/// Results of trials by the hash of their files.
type Known = BTreeMap<[u8; 32], Result<(), Fault>>;

/// Why SUMO cannot have a network, or a demand on it.
#[derive(Clone, Debug)]
enum Fault {
    /// It reads and reads.
    TimedOut,
    /// It says why not, and perhaps what helps.
    Refused(String),
    /// It ended without a word; how.
    Crashed(ExitStatus),
}

impl Trial {
    /// A closed route without demand.
    pub fn of_network(net_file: &Path) -> Self {
        Self { net_file: net_file.into(), demand: Demand::default(), has_ego: true }
    }

    /// The message of a fault.
    fn about(&self, fault: &Fault) -> String {
        let net = self.net_file.display();
        let demand: Vec<String> = self.demand.files.iter().map(|file| file.display().to_string()).collect();
        let (named, what, remedy) = if demand.is_empty() {
            let remedy = "repair it with SUMO's netconvert (--sumo-net-file OLD --output-file NEW), or import it again with codrive map import";
            (net.to_string(), "this network", remedy.to_owned())
        } else {
            let files = demand.join(",");
            let remedy = format!("SUMO's own program may say more: sumo --net-file {net} --route-files {files}");
            (format!("{} on {net}", demand.join(", ")), "this demand", remedy)
        };
        let on = if demand.is_empty() { "on " } else { "" };
        let remedy = format!("\n  remedy: {remedy}");
        match fault {
            Fault::TimedOut => format!("{named}: SUMO did not read {what} within {} s{remedy}", TIMEOUT.as_secs()),
            Fault::Refused(words) if words.contains("\n  remedy: ") => {
                format!("{named}: SUMO cannot drive {on}{what}: {words}")
            }
            Fault::Refused(words) => format!("{named}: SUMO cannot drive {on}{what}: {words}{remedy}"),
            Fault::Crashed(status) => format!("{named}: SUMO crashes on {what} ({status}){remedy}"),
        }
    }

    /// Words about copies with the files of this trial in their place.
    fn in_place_of(&self, copies: &Self, words: &str) -> String {
        let files = |trial: &Self| -> Vec<String> {
            let all = std::iter::once(&trial.net_file).chain(&trial.demand.files);
            all.map(|file| file.display().to_string()).collect()
        };
        files(copies).iter().zip(files(self)).fold(words.to_owned(), |words, (copy, own)| words.replace(copy, &own))
    }

    /// Hash of the bytes of all files; `None` if all come with the program.
    fn hash(&self) -> Result<Option<[u8; 32]>, TrafficError> {
        let (mut hash, mut is_shipped) = (Sha256::new(), true);
        let limits = std::iter::once(MOST_BYTES).chain(std::iter::repeat(stream::MOST_BYTES));
        for (path, limit) in std::iter::once(&self.net_file).chain(&self.demand.files).zip(limits) {
            let failed = |error: std::io::Error| TrafficError::Setup(format!("{}: {error}", path.display()));
            let bytes = file::read_bounded(path, limit).map_err(failed)?;
            // By their bytes: a mark in a file would not do, for a damaged copy keeps it.
            is_shipped &= data_folders::is_shipped_for_sumo(&bytes);
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(&bytes);
        }
        hash.update([u8::from(self.has_ego)]);
        hash.update(serde_json::to_vec(&self.demand.flows).unwrap_or_default());
        Ok((!is_shipped).then(|| hash.finalize().into()))
    }
}

/// Fails if SUMO from the folder `home` cannot be given these files in this process: copies of those in `named`, which messages name.
///
/// # Errors
/// One cannot be read, SUMO refuses it or breaks down on it, or nobody waits any longer.
pub(super) fn check(home: &Path, trial: &Trial, named: &Trial) -> Result<(), TrafficError> {
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    let Some(hash) = trial.hash()? else { return Ok(()) };
    // One check at a time: a second one of the same files waits for the first and has its result.
    let mut known = lock(&KNOWN)?;
    let failed = |fault: Fault| TrafficError::Setup(named.about(&fault));
    if let Some(result) = known.get(&hash) {
        return result.clone().map_err(failed);
    }
    let result = try_in_child(home, trial, named)?;
    known.insert(hash, result.clone());
    result.map_err(failed)
}

/// Locks the results, or fails once nobody waits any longer.
fn lock(known: &Mutex<Known>) -> Result<MutexGuard<'_, Known>, TrafficError> {
    loop {
        match known.try_lock() {
            Ok(known) => return Ok(known),
            Err(TryLockError::Poisoned(known)) => return Ok(PoisonError::into_inner(known)),
            Err(TryLockError::WouldBlock) => go_on()?,
        }
        sleep(Duration::from_millis(10));
    }
}

/// What a child process finds.
fn try_in_child(home: &Path, trial: &Trial, named: &Trial) -> Result<Result<(), Fault>, TrafficError> {
    let (program, arguments) = match CHECKER.get() {
        Some((program, arguments)) => (program.clone(), arguments.clone()),
        None => (own_program()?, vec![COMMAND.into()]),
    };
    let request = serde_json::to_vec(trial).map_err(|error| TrafficError::Setup(error.to_string()))?;
    let written = TemporaryFolder::new().and_then(|folder| Ok((folder.write("trial.json", &request)?, folder)));
    let (file, folder) = written.map_err(|error| TrafficError::Setup(error.to_string()))?;
    let mut command = Command::new(&program);
    // What it leaves when it is killed goes with the folder.
    command.args(arguments).arg(file).env("CODRIVE_SUMO_HOME", home).env("TMPDIR", folder.path());
    let what = named.demand.files.first().map_or_else(
        || named.net_file.display().to_string(),
        |demand| format!("{} on {}", demand.display(), named.net_file.display()),
    );
    Ok(match trial_process::run(&mut command, &what)? {
        Ended::TimedOut => Err(Fault::TimedOut),
        Ended::Itself(status, words) => match status.code() {
            // Where it cannot read a part of a demand it says so and goes on without.
            Some(0) if !words.lines().any(|line| line.starts_with(ERROR)) => Ok(()),
            Some(_) => Err(Fault::Refused(named.in_place_of(trial, &bare(&words)))),
            None => Err(Fault::Crashed(status)),
        },
    })
}

/// Beginning of the lines with which SUMO states a fault on its standard error.
const ERROR: &str = "Error: ";

/// Words of a child without the beginnings of its lines.
fn bare(words: &str) -> String {
    let bare = |line: &str| line.trim_start_matches("codrive: ").trim_start_matches(ERROR).to_owned();
    words.lines().map(bare).collect::<Vec<_>>().join("\n")
}

/// The program itself: a test or a benchmark finds it beside its own folder.
fn own_program() -> Result<PathBuf, TrafficError> {
    let name = format!("codrive{}", consts::EXE_SUFFIX);
    let here = env::current_exe().unwrap_or_default();
    let candidates = here.ancestors().skip(1).take(2).map(|folder| folder.join(&name));
    candidates.into_iter().find(|path: &PathBuf| path.is_file()).ok_or_else(|| {
        let text = format!(
            "a network or demand that does not come with codrive is tried in a process of its own first, and the program {name} for \
             that is not beside {}\n  remedy: put it there, or build it with cargo build",
            here.display()
        );
        TrafficError::Setup(text)
    })
}

/// Runs the trial in the child: drives some vehicles for a few seconds of simulation, as the trial in a file says.
///
/// # Errors
/// Our reader or SUMO refuses the network or the demand.
pub fn try_network(trial_file: &Path) -> Result<(), TrafficError> {
    let unreadable = |why: String| TrafficError::Setup(format!("{}: {why}", trial_file.display()));
    let text = file::read_text(trial_file, MOST_TRIAL_BYTES).map_err(|error| unreadable(error.to_string()))?;
    let trial: Trial = serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
    if !trial.demand.is_empty() {
        return try_roads(&trial);
    }
    let map = match RoadMap::load(&trial.net_file.to_string_lossy()) {
        Ok(map) if !map.route.is_closed() => return try_roads(&trial),
        Ok(map) => Arc::new(map),
        Err(MapError::NoRoute { .. }) => return try_roads(&trial),
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
        lateral_accel_mps2: None,
    };
    let mut traffic = match SumoTraffic::start_unchecked(&super::home()?, setup) {
        Ok(traffic) => traffic,
        // Its loop is none for SUMO's cars, and a path along other edges may be driven.
        Err(TrafficError::RouteChangesLanes { .. } | TrafficError::RouteForks { .. }) => return try_roads(&trial),
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

/// The same for a network without a closed route: the vehicles of the demand, and where the drive has an ego, cars that SUMO drives from
/// streets to the next.
fn try_roads(trial: &Trial) -> Result<(), TrafficError> {
    let network =
        Network::load(&trial.net_file.to_string_lossy()).map_err(|error| TrafficError::Setup(error.to_string()))?;
    let network = Arc::new(network);
    let start = |lane: LaneId| {
        let way = network.connections_from(lane).iter().find(|way| network.lane(way.to).admits_cars())?;
        let is_street = network.edge_of(lane).kind.is_street() && network.lane(lane).admits_cars();
        let route = [lane, way.to].map(|lane| network.edge_of(lane).id.clone());
        let s_m = network.lane(lane).length_m.min(2.0 * CAR_LENGTH_M);
        is_street.then(|| EgoStart { lane, s_m, speed_mps: 0.0, route: route.into() })
    };
    let most = if trial.has_ego { MOST_CARS } else { 0 };
    let egos = network.lane_ids().filter_map(start).take(most).collect();
    let setup = NetworkSetup {
        network: Arc::clone(&network),
        net_file: trial.net_file.clone(),
        demand: trial.demand.clone(),
        egos,
        first_number: 0,
        idm: crate::idm::IdmParams::default(),
        step_s: 0.1,
        // The drive has counted it, for its own length.
        until_s: 0.0,
        seed: 1,
    };
    let mut traffic = SumoNetwork::start_unchecked(&super::home()?, &setup)?;
    (0..STEPS).try_for_each(|_| traffic.step(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_network_in_maps_is_known_as_ours() {
        let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
        let nets: Vec<_> =
            std::fs::read_dir(&maps).unwrap().map(|folder| folder.unwrap().path().join("net.xml")).collect();
        assert_eq!(nets.len(), 4);
        for net in nets {
            let trial = Trial::of_network(&net);
            assert_eq!(trial.hash().unwrap(), None, "{}", net.display());
        }
        let merge = |file: &str| maps.join("merge").join(file);
        let shipped = Demand { files: vec![merge("demand.rou.xml")], flows: Vec::new() };
        let trial = Trial { net_file: merge("net.xml"), demand: shipped, has_ego: false };
        assert_eq!(trial.hash().unwrap(), None);
    }

    #[test]
    fn words_of_a_child_are_said_without_the_beginnings_of_their_lines() {
        assert_eq!(bare("codrive: it ended\nError: no lane x\nQuitting."), "it ended\nno lane x\nQuitting.");
    }

    #[test]
    fn a_trial_is_known_by_the_bytes_of_network_and_demand_together() {
        let folder = tempfile::tempdir().unwrap();
        let net = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/merge/net.xml");
        let hash = |files: &[&str], has_ego: bool| {
            let write = |(k, text): (usize, &&str)| {
                let file = folder.path().join(format!("{k}.rou.xml"));
                std::fs::write(&file, text).unwrap();
                file
            };
            let files = files.iter().enumerate().map(write).collect();
            let trial = Trial { net_file: net.clone(), demand: Demand { files, flows: Vec::new() }, has_ego };
            trial.hash().unwrap().expect("not shipped")
        };
        let one = hash(&["<routes/>"], true);
        assert_eq!(hash(&["<routes/>"], true), one);
        for (files, has_ego) in [(&["<routes />"][..], true), (&["<routes", "/>"], true), (&["<routes/>"], false)] {
            assert_ne!(hash(files, has_ego), one, "{files:?}");
        }
    }

    #[test]
    fn a_wait_for_the_trial_of_another_drive_ends_with_an_interruption() {
        let (known, interruption) = (Mutex::new(Known::new()), crate::traffic::Interruption::default());
        let trial_of_another = known.lock().unwrap();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| {
                interruption.clone().obey();
                matches!(lock(&known), Err(TrafficError::Interrupted))
            });
            interruption.interrupt();
            let has_ended = (0..100).any(|_| {
                sleep(Duration::from_millis(10));
                waiting.is_finished()
            });
            drop(trial_of_another);
            assert!(has_ended && waiting.join().unwrap());
        });
    }

    #[test]
    fn one_remedy_is_said_and_the_closer_one() {
        let trial = Trial::of_network(Path::new("town.net.xml"));
        let bare = trial.about(&Fault::Refused("edge a is nowhere".into()));
        assert!(
            bare.starts_with("town.net.xml: SUMO cannot drive on this network: edge a is nowhere\n  remedy: repair it"),
            "{bare}"
        );
        let closer = trial.about(&Fault::Refused("edge a is nowhere\n  remedy: name another".into()));
        assert!(closer.ends_with("nowhere\n  remedy: name another"), "{closer}");
        let demand = Demand { files: vec!["rush.rou.xml".into()], flows: Vec::new() };
        let late = Trial { demand, ..trial }.about(&Fault::TimedOut);
        assert!(late.starts_with("rush.rou.xml on town.net.xml: SUMO did not read this demand"), "{late}");
        assert!(
            late.ends_with(
                "remedy: SUMO's own program may say more: sumo --net-file town.net.xml --route-files rush.rou.xml"
            ),
            "{late}"
        );
    }
}
