//! Setup of SUMO for a drive: options, vehicle types, endless route. In: a [`FixedSetup`](crate::traffic::FixedSetup). Out: arguments
//! for the shim.

use super::{fixed_cars::NAME, shim_data::VehicleType};
use crate::{
    idm::IdmParams,
    map::RoadMap,
    space::{CAR_LENGTH_M, CAR_WIDTH_M},
    temporary::TemporaryFolder,
    traffic::{
        CarFollowing, Demand, FixedSetup, FollowingModel, GUARD, HARDEST_MPS2, TrafficDriver, TrafficDrivers,
        TrafficError,
    },
};
use std::path::{Path, PathBuf};

/// Exponent of SUMO's IDM unless a file sets another.
pub(super) const DEFAULT_DELTA: f64 = 4.0;
/// Minimum length of a route before it ends, metres: at 30 m/s, 9 hours.
const ENDLESS_M: f64 = 1.0e6;

/// Returns SUMO's command-line options for a closed route.
pub(super) fn options(net: &str, step_s: f64, types: Option<&Path>, seed: u64) -> Vec<String> {
    let mut options = common(net, step_s, seed);
    options.extend(["--default.carfollowmodel", "IDM"].map(String::from));
    // The initial positions are codrive's choice.
    options.extend(["--insertion-checks", "none"].map(String::from));
    if let Some(types) = types {
        options.extend(["--additional-files".to_string(), types.display().to_string()]);
    }
    options
}

/// Files of a demand, and the way in which SUMO reads them.
pub(super) struct DemandFiles<'a> {
    /// Files read before all others.
    pub additional: &'a [PathBuf],
    /// Files with vehicles, read as the drive goes on.
    pub routes: &'a [PathBuf],
    /// Time of day at the drive's begin, seconds.
    pub begin_s: f64,
    /// True to read everything at once.
    pub is_trial: bool,
    /// True to end at the first vehicle that cannot depart or drive on; false to go on without it.
    pub ends_at_faults: bool,
}

/// Returns SUMO's command-line options for a road network, with these demand files and this duration of lane changes, seconds.
pub(super) fn network_options(
    net: &str,
    step_s: f64,
    files: &DemandFiles,
    lane_change_s: f64,
    seed: u64,
) -> Vec<String> {
    let mut options = common(net, step_s, seed);
    for (name, files) in [("--additional-files", files.additional), ("--route-files", files.routes)] {
        if !files.is_empty() {
            let files: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
            options.extend([name.to_string(), files.join(",")]);
        }
    }
    options.extend(["--begin".to_string(), files.begin_s.to_string()]);
    options.extend(["--lanechange.duration".to_string(), lane_change_s.to_string()]);
    for (is_set, option) in
        [(files.is_trial, ["--route-steps", "0"]), (!files.ends_at_faults, ["--ignore-route-errors", "true"])]
    {
        options.extend(option.map(String::from).into_iter().filter(|_| is_set));
    }
    options
}

/// Returns the options that all simulations share.
fn common(net: &str, step_s: f64, seed: u64) -> Vec<String> {
    let step = format!("{step_s:.3}");
    let mut options: Vec<String> = [
        ("--net-file", net),
        ("--step-length", step.as_str()),
        // Numbers are passed as text when a type is created, so all digits are needed.
        ("--precision", "16"),
        // Vehicles in a jam must not be teleported away.
        ("--time-to-teleport", "-1"),
        // The default would teleport a vehicle that the ego touches. The ego's physics detects contacts.
        ("--collision.action", "none"),
        ("--xml-validation", "never"),
        ("--no-step-log", "true"),
        ("--duration-log.disable", "true"),
        // Behind an ego that stops suddenly, SUMO would print a line for each emergency braking.
        ("--no-warnings", "true"),
    ]
    .iter()
    .flat_map(|(name, value)| [(*name).to_string(), (*value).to_string()])
    .collect();
    // SUMO's own random numbers are for models other than the IDM. SUMO accepts 31 bits.
    options.extend(["--seed".to_string(), (seed % (1 << 31)).to_string()]);
    options
}

/// Returns the numbers of SUMO's IDM for a driver. One with another model
/// chooses a speed, which [`GUARD`] bounds.
pub(super) fn idm_of(driver: &TrafficDriver) -> IdmParams {
    match driver.model {
        CarFollowing::Idm(idm) => idm,
        CarFollowing::OptimalVelocity(model) => IdmParams { v0: model.v_max, ..GUARD },
    }
}

/// Returns names and models of the types that the cars have: one for all where the drivers are alike or where their speeds are imposed,
/// otherwise one for each.
pub(super) fn driver_types(setting: &TrafficDrivers, drivers: &[TrafficDriver]) -> Vec<(String, IdmParams)> {
    let one = |idm| vec![(NAME.to_owned(), idm)];
    if let TrafficDrivers::Alike(idm) = setting {
        return one(*idm);
    }
    let models = drivers.iter().enumerate().map(|(i, driver)| match driver.model {
        CarFollowing::Idm(idm) => Some((format!("{NAME}.person{i}"), idm)),
        CarFollowing::OptimalVelocity(_) => None,
    });
    models.collect::<Option<Vec<_>>>().unwrap_or_else(|| one(idm_of(&setting.typical())))
}

/// Returns the name of the type in a [`TypeFile`] from which the type `name` is made; `None` if SUMO's default has its exponent.
pub(super) fn type_in_file(name: &str, idm: &IdmParams) -> Option<String> {
    (idm.delta != DEFAULT_DELTA).then(|| format!("{name}.delta"))
}

/// Returns the vehicle type of cars with this model.
pub(super) fn vehicle_type(idm: &IdmParams) -> VehicleType {
    VehicleType {
        length_m: CAR_LENGTH_M,
        width_m: CAR_WIDTH_M,
        accel_mps2: idm.a,
        decel_mps2: idm.b,
        emergency_decel_mps2: HARDEST_MPS2.max(idm.b),
        time_gap_s: idm.t,
        min_gap_m: idm.s0,
        max_speed_mps: idm.v0,
    }
}

/// Returns the vehicle type with another model: same size and maximum speed, otherwise SUMO's own numbers for a passenger car, which its
/// models share.
pub(super) fn other_vehicle_type(idm: &IdmParams) -> VehicleType {
    VehicleType {
        accel_mps2: 2.6,
        decel_mps2: 4.5,
        emergency_decel_mps2: HARDEST_MPS2,
        time_gap_s: 1.0,
        min_gap_m: 2.5,
        ..vehicle_type(idm)
    }
}

/// Returns the edges of laps without end: the normal edges of the route (SUMO adds those inside junctions), repeated so often that no drive
/// reaches the end.
pub(super) fn endless_edges(map: &RoadMap) -> Vec<String> {
    let streets = map.route.lanes().iter().filter(|lane| lane.is_street(&map.network));
    let lap: Vec<&str> = streets.map(|lane| lane.edge_id(&map.network)).collect();
    let laps = (ENDLESS_M / map.route.length_m()).ceil() as usize;
    lap.iter().cycle().take(lap.len() * laps).map(|edge| (*edge).to_owned()).collect()
}

/// File with declarations that SUMO's API cannot make: an IDM type with its own exponent, a type with another model, or flows; removed on
/// drop.
pub(super) struct TypeFile {
    _folder: TemporaryFolder,
    path: PathBuf,
}

/// Name of the vehicle type with another model in a [`TypeFile`].
pub(super) const OTHER_TYPE_IN_FILE: &str = "codrive.other";

impl TypeFile {
    /// Writes the file if this setup needs one.
    pub fn of(setup: &FixedSetup) -> Result<Option<Self>, TrafficError> {
        let other = setup.mixture.model;
        let mut types = String::new();
        for (name, idm) in driver_types(&setup.drivers, &setup.drivers.drivers(setup.seed, setup.cars.len())) {
            if let Some(id) = type_in_file(&name, &idm) {
                types += &format!("  <vType id=\"{id}\" carFollowModel=\"IDM\" delta=\"{}\"/>\n", idm.delta);
            }
        }
        if other != FollowingModel::Idm {
            let model = other.sumo_name();
            types += &format!("  <vType id=\"{OTHER_TYPE_IN_FILE}\" carFollowModel=\"{model}\"/>\n");
        }
        let text = format!("<additional>\n{types}</additional>\n");
        if types.is_empty() { Ok(None) } else { Self::write("add", &text).map(Some) }
    }

    /// Writes a file with the flows of a demand and their vehicle types; cars have these drivers.
    pub fn of_demand(
        demand: &Demand,
        drivers: &TrafficDrivers,
        defines_default_type: bool,
    ) -> Result<Self, TrafficError> {
        let IdmParams { v0, t, a, b, delta, s0, .. } = idm_of(&drivers.typical());
        let car = format!(
            "carFollowModel=\"IDM\" length=\"{CAR_LENGTH_M}\" width=\"{CAR_WIDTH_M}\" maxSpeed=\"{v0}\" tau=\"{t}\" accel=\"{a}\" \
             decel=\"{b}\" delta=\"{delta}\" minGap=\"{s0}\" emergencyDecel=\"{}\"",
            HARDEST_MPS2.max(b)
        );
        Self::write("rou", &demand.flows_xml(&car, defines_default_type))
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    fn write(kind: &str, text: &str) -> Result<Self, TrafficError> {
        let folder = TemporaryFolder::new();
        let written =
            folder.and_then(|folder| Ok((folder.write(&format!("codrive.{kind}.xml"), text.as_bytes())?, folder)));
        let (path, folder) = written.map_err(|error| TrafficError::Setup(error.to_string()))?;
        Ok(Self { _folder: folder, path })
    }
}
