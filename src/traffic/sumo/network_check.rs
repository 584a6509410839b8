//! Trial of SUMO on a network and the demand of a drive. In: their files. Out: nothing, or an error that names them. A crash of SUMO in
//! this process ends the whole program (12 of 1,000 mutated networks caused one). Therefore files that differ from the shipped ones in any
//! byte are first read by codrive's own readers and then driven briefly by a child process, within limits of time and memory. A result
//! holds for the bytes of all files together, as long as the program runs.

use super::{
    SumoTraffic,
    trial_process::{self, Ended, TIMEOUT},
};
use crate::{
    data_folders, file,
    map::{
        MapError, RoadMap,
        limits::MOST_BYTES,
        network::{LaneId, Network},
    },
    space::{CAR_LENGTH_M, Pose},
    sumo_xml::stream,
    temporary::TemporaryFolder,
    traffic::{
        Demand, DemandSetup, EgoStart, ExternalVehicleState, FixedSetup, ModelMixture, Traffic, TrafficDrivers,
        TrafficError, VehicleReport, go_on, start,
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
/// Steps of the child's drive; on a closed route, the ego is externally driven in the second half.
const STEPS: usize = 60;
/// Maximum number of cars that the trial adds to the child's drive.
const MOST_CARS: usize = 60;
/// Maximum size of a trial's file, bytes: enough for a demand with many flows.
const MOST_TRIAL_BYTES: u64 = 64 << 20;

/// Program and leading arguments of the child, if it is not this program.
static CHECKER: OnceLock<(PathBuf, Vec<OsString>)> = OnceLock::new();

/// Sets the program for the child. It must call [`try_network`] with its last argument; on failure it must state the reason on its standard
/// error and exit with 1. For programs that use codrive as a library.
pub fn check_networks_by(program: PathBuf, arguments: Vec<OsString>) {
    let _ = CHECKER.set((program, arguments));
}

/// Files for a trial of SUMO.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Trial {
    pub net_file: PathBuf,
    /// Demand of the drive; empty on a closed route.
    pub demand: Demand,
    /// True if the drive has an ego, or is on a closed route.
    pub has_ego: bool,
}

/// Results of trials by the hash of their files.
type Known = BTreeMap<[u8; 32], Result<(), Fault>>;

/// Reason why SUMO cannot use a network or a demand.
#[derive(Clone, Debug)]
enum Fault {
    /// The trial exceeded its time limit.
    TimedOut,
    /// The child states the reason, with a remedy in some cases.
    Refused(String),
    /// The child crashed, with this exit status.
    Crashed(ExitStatus),
}

impl Trial {
    /// Creates a trial of a closed route without demand.
    pub fn of_network(net_file: &Path) -> Self {
        Self { net_file: net_file.into(), demand: Demand::default(), has_ego: true }
    }

    /// Returns the message about a fault.
    fn about(&self, fault: &Fault) -> String {
        let net = self.net_file.display();
        let demand: Vec<String> = self.demand.input_files().map(|file| file.display().to_string()).collect();
        let (named, what, remedy) = if demand.is_empty() {
            let remedy = "repair it with SUMO's netconvert (--sumo-net-file OLD --output-file NEW), or import it again with codrive map import";
            (net.to_string(), "this network", remedy.to_owned())
        } else {
            let additional: Vec<String> =
                self.demand.additional_files.iter().map(|file| file.display().to_string()).collect();
            let files = demand[additional.len()..].join(",");
            let before = if additional.is_empty() {
                String::new()
            } else {
                format!("--additional-files {} ", additional.join(","))
            };
            let remedy =
                format!("run SUMO's own program for details: sumo --net-file {net} {before}--route-files {files}");
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

    /// Replaces the paths of the copies in a message by the paths of this trial's files.
    fn in_place_of(&self, copies: &Self, words: &str) -> String {
        let files = |trial: &Self| -> Vec<String> {
            let all = std::iter::once(&trial.net_file).chain(trial.demand.input_files());
            all.map(|file| file.display().to_string()).collect()
        };
        files(copies).iter().zip(files(self)).fold(words.to_owned(), |words, (copy, own)| words.replace(copy, &own))
    }

    /// Returns the hash of the bytes of all files, of the flows and of `has_ego`; `None` if all files are shipped with the program.
    fn hash(&self) -> Result<Option<[u8; 32]>, TrafficError> {
        let (mut hash, mut is_shipped) = (Sha256::new(), true);
        let limits = std::iter::once(MOST_BYTES).chain(std::iter::repeat(stream::MOST_BYTES));
        for (path, limit) in std::iter::once(&self.net_file).chain(self.demand.input_files()).zip(limits) {
            let failed = |error: std::io::Error| TrafficError::Setup(format!("{}: {error}", path.display()));
            let bytes = file::read_bounded(path, limit).map_err(failed)?;
            // Shipped files are recognised by their bytes, because a damaged copy would keep a mark inside the file.
            is_shipped &= data_folders::is_shipped_for_sumo(&bytes);
            hash.update((bytes.len() as u64).to_le_bytes());
            hash.update(&bytes);
        }
        hash.update([u8::from(self.has_ego)]);
        // The names of the copies say nothing; their number says which of them are additional files.
        let Demand { additional_files, files: _, begin_s, leave_out_faults, flows } = &self.demand;
        hash.update(
            serde_json::to_vec(&(additional_files.len(), begin_s, leave_out_faults, flows)).unwrap_or_default(),
        );
        Ok((!is_shipped).then(|| hash.finalize().into()))
    }
}

/// Checks that SUMO from the folder `home` can use these files in this process. They are copies of the files in `named`, which messages
/// name.
///
/// # Errors
/// A file cannot be read, SUMO refuses it or crashes on it, or the wait was interrupted.
pub(super) fn check(home: &Path, trial: &Trial, named: &Trial) -> Result<(), TrafficError> {
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    let Some(hash) = trial.hash()? else { return Ok(()) };
    // One check at a time: a second check of the same files waits for the first and gets its result.
    let mut known = lock(&KNOWN)?;
    let failed = |fault: Fault| TrafficError::Setup(named.about(&fault));
    if let Some(result) = known.get(&hash) {
        return result.clone().map_err(failed);
    }
    let result = try_in_child(home, trial, named)?;
    known.insert(hash, result.clone());
    result.map_err(failed)
}

/// Locks the results, or fails after an interruption.
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

/// Runs the trial in a child process and returns its result.
fn try_in_child(home: &Path, trial: &Trial, named: &Trial) -> Result<Result<(), Fault>, TrafficError> {
    let (program, arguments) = match CHECKER.get() {
        Some((program, arguments)) => (program.clone(), arguments.clone()),
        None => (own_program()?, vec![COMMAND.into()]),
    };
    let request = serde_json::to_vec(trial).map_err(|error| TrafficError::Setup(error.to_string()))?;
    let written = TemporaryFolder::new().and_then(|folder| Ok((folder.write("trial.json", &request)?, folder)));
    let (file, folder) = written.map_err(|error| TrafficError::Setup(error.to_string()))?;
    let mut command = Command::new(&program);
    // Files that a killed child leaves are removed with the folder.
    command.args(arguments).arg(file).env("CODRIVE_SUMO_HOME", home).env("TMPDIR", folder.path());
    let what = named.demand.input_files().next().map_or_else(
        || named.net_file.display().to_string(),
        |demand| format!("{} on {}", demand.display(), named.net_file.display()),
    );
    Ok(match trial_process::run(&mut command, &what)? {
        Ended::TimedOut => Err(Fault::TimedOut),
        Ended::Itself(status, words) => match status.code() {
            // SUMO reports a part of a demand that it cannot read, and continues without it.
            Some(0) if !words.lines().any(|line| line.starts_with(ERROR)) => Ok(()),
            Some(_) => Err(Fault::Refused(named.in_place_of(trial, &bare(&words)))),
            None => Err(Fault::Crashed(status)),
        },
    })
}

/// Prefix of SUMO's error lines on its standard error.
const ERROR: &str = "Error: ";

/// Removes the prefixes of a child's lines.
fn bare(words: &str) -> String {
    let bare = |line: &str| line.trim_start_matches("codrive: ").trim_start_matches(ERROR).to_owned();
    words.lines().map(bare).collect::<Vec<_>>().join("\n")
}

/// Returns the path of the codrive program: in the folder of this executable, or in the parent folder for a test or a benchmark.
fn own_program() -> Result<PathBuf, TrafficError> {
    let name = format!("codrive{}", consts::EXE_SUFFIX);
    let here = env::current_exe().unwrap_or_default();
    let candidates = here.ancestors().skip(1).take(2).map(|folder| folder.join(&name));
    candidates.into_iter().find(|path: &PathBuf| path.is_file()).ok_or_else(|| {
        let text = format!(
            "codrive first tests a network or demand of other origin in a separate process; the program {name} for \
             this is not beside {}\n  remedy: put it there, or build it with cargo build",
            here.display()
        );
        TrafficError::Setup(text)
    })
}

/// Runs the trial in the child: drives some vehicles for a few seconds of simulation, as stated in the trial file.
///
/// # Errors
/// The reader of codrive or SUMO refuses the network or the demand.
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
    let setup = FixedSetup {
        map: Arc::clone(&map),
        cars,
        drivers: TrafficDrivers::Alike(idm),
        mixture: ModelMixture::default(),
        step_s,
        seed: 1,
        lateral_accel_mps2: None,
    };
    let mut traffic = match SumoTraffic::start_fixed_untried(setup) {
        Ok(traffic) => traffic,
        // SUMO's vehicles cannot drive its loop, but a path along other edges may be possible.
        Err(TrafficError::RouteChangesLanes { .. } | TrafficError::RouteForks { .. }) => return try_roads(&trial),
        Err(error) => return Err(error),
    };
    for step in 0..STEPS {
        let ego = traffic.vehicles()[0];
        let report = (step >= STEPS / 2).then(|| ExternalVehicleState {
            pose: ego.pose,
            speed_mps: ego.speed_mps,
            next_pose: Pose { position: ego.pose.position + ego.pose.forward() * ego.speed_mps * step_s, ..ego.pose },
            next_speed_mps: ego.speed_mps,
        });
        traffic.step(report.map(VehicleReport::of_ego).as_slice())?;
    }
    Ok(())
}

/// Runs the trial on a network without a closed route: the vehicles of the demand and, if the drive has an ego, cars that SUMO drives from
/// a street to the next edge.
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
    let setup = DemandSetup {
        network: Arc::clone(&network),
        net_file: trial.net_file.clone(),
        demand: trial.demand.clone(),
        egos,
        first_number: 0,
        drivers: TrafficDrivers::Alike(crate::idm::IdmParams::default()),
        step_s: 0.1,
        // The drive has already counted the demand for its own length.
        until_s: 0.0,
        seed: 1,
    };
    let mut traffic = SumoTraffic::start_untried(&setup)?;
    (0..STEPS).try_for_each(|_| traffic.step(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_network_in_maps_is_known_as_ours() {
        let maps = Path::new(env!("CODRIVE_ROOT")).join("maps");
        let nets: Vec<_> =
            std::fs::read_dir(&maps).unwrap().map(|folder| folder.unwrap().path().join("net.xml")).collect();
        assert_eq!(nets.len(), crate::map::SHIPPED.len());
        for net in nets {
            let trial = Trial::of_network(&net);
            assert_eq!(trial.hash().unwrap(), None, "{}", net.display());
        }
        let merge = |file: &str| maps.join("merge").join(file);
        let shipped = Demand { files: vec![merge("demand.rou.xml")], ..Demand::default() };
        let trial = Trial { net_file: merge("net.xml"), demand: shipped, has_ego: false };
        assert_eq!(trial.hash().unwrap(), None);
    }

    #[test]
    fn the_lines_of_a_child_are_reported_without_their_prefixes() {
        assert_eq!(bare("codrive: it ended\nError: no lane x\nQuitting."), "it ended\nno lane x\nQuitting.");
    }

    #[test]
    fn a_trial_is_known_by_the_bytes_of_network_and_demand_together() {
        let folder = tempfile::tempdir().unwrap();
        let net = Path::new(env!("CODRIVE_ROOT")).join("maps/merge/net.xml");
        let hash = |files: &[&str], has_ego: bool| {
            let write = |(k, text): (usize, &&str)| {
                let file = folder.path().join(format!("{k}.rou.xml"));
                std::fs::write(&file, text).unwrap();
                file
            };
            let files = files.iter().enumerate().map(write).collect();
            let trial = Trial { net_file: net.clone(), demand: Demand { files, ..Demand::default() }, has_ego };
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
    fn a_message_has_one_remedy_and_prefers_the_specific_one() {
        let trial = Trial::of_network(Path::new("town.net.xml"));
        let bare = trial.about(&Fault::Refused("edge a is nowhere".into()));
        assert!(
            bare.starts_with("town.net.xml: SUMO cannot drive on this network: edge a is nowhere\n  remedy: repair it"),
            "{bare}"
        );
        let closer = trial.about(&Fault::Refused("edge a is nowhere\n  remedy: name another".into()));
        assert!(closer.ends_with("nowhere\n  remedy: name another"), "{closer}");
        let demand = Demand { files: vec!["rush.rou.xml".into()], ..Demand::default() };
        let late = Trial { demand, ..trial }.about(&Fault::TimedOut);
        assert!(late.starts_with("rush.rou.xml on town.net.xml: SUMO did not read this demand"), "{late}");
        assert!(
            late.ends_with(
                "remedy: run SUMO's own program for details: sumo --net-file town.net.xml --route-files rush.rou.xml"
            ),
            "{late}"
        );
    }
}
