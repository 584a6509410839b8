//! Plan of an evaluation: every combination of policies, holds and drivers. In: the command line. Out: an [`EvaluationPlan`].

use super::{
    CliError,
    checks::{check_network, check_ring, check_whole, mixture},
};
use crate::{
    cli::flags,
    driver::{self, DriverError, NamedDriver, Population},
    map::RoadMap,
    policy::{self, Policy, PolicySettings, PolicySource, ResolvedPolicy},
    scenario::{AdvisedVehicles, PlannedDrive, Scenario},
    settings::{Field, Settings, fields_of},
    sim::{WorldError, policy_of},
    toml_text::did_you_mean,
    traffic::{EngineChoice, ModelMixture, UnknownEngine},
    train::{RingConfig, TrainConfig},
};
use clap::ArgMatches;
use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

/// Simulation engine of an evaluation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Fast ring, on which policies are trained.
    FastRing,
    /// Whole drives on this traffic engine.
    Traffic(EngineChoice),
}

impl std::fmt::Display for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::FastRing => f.write_str("ring"),
            Self::Traffic(engine) => engine.fmt(f),
        }
    }
}

/// Driver who follows the advice.
#[derive(Clone, Debug, PartialEq)]
pub enum FollowingDriver {
    /// Driver of the configuration, which may draw another one for each ring.
    Configured,
    /// One driver, the same on every engine.
    Named(Box<NamedDriver>),
    /// Driver drawn from a population, another one for each ring.
    Population(Population),
}

/// Default driver: an attentive participant who brakes for the vehicle ahead.
const NOBODY_NAMED: &str = "follow";
/// Driver who ignores advice.
const IGNORES_ADVICE: &str = "idm";

/// Settings of a configuration that choose the driver.
const WHO: [&str; 15] = [
    "follow",
    "brakes_for_leader",
    "reaction_s",
    "error_mps",
    "error_time_s",
    "speed_bias_mps",
    "deadband_mps",
    "random_driver",
    "leader_reaction_s",
    "compliance",
    "compliance_fade_s",
    "patience_mps",
    "inattention_per_min",
    "inattention_s",
    "population",
];

/// Failure to find a driver by name.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum FollowingDriverError {
    /// Name of neither a driver nor a population.
    #[error(
        "no driver is called {name:?}{near}\n  remedy: use one of {}; or a population, with another driver in each \
         ring: {}; or parameters: reaction=1,error=0.5,speed_bias=0,deadband=0",
        known_drivers().join(", "),
        Population::NAMES.join(", ")
    )]
    Unknown {
        /// Name that was asked for.
        name: String,
        /// Suggestion of the nearest name, or empty.
        near: String,
    },
    /// Invalid number of the driver.
    #[error(transparent)]
    Driver(#[from] DriverError),
}

fn known_drivers() -> Vec<&'static str> {
    [driver::PRESETS.as_slice(), &driver::MACHINES].concat()
}

/// Returns a driver or a population of drivers by name, as `--driver` takes it.
///
/// # Errors
/// The name is unknown, with the known names in the message; or a number of the driver is wrong.
pub fn driver(text: &str) -> Result<FollowingDriver, FollowingDriverError> {
    if let Ok(population) = Population::named(text) {
        return Ok(FollowingDriver::Population(population));
    }
    match driver::named(text) {
        Ok(named) => Ok(FollowingDriver::Named(Box::new(named))),
        Err(DriverError::Unknown { name }) => {
            let near = did_you_mean(&name, &[known_drivers(), Population::NAMES.to_vec()].concat());
            Err(FollowingDriverError::Unknown { name, near })
        }
        Err(fault) => Err(fault.into()),
    }
}

/// Checks whether a configuration or one of its flags chooses the driver.
pub fn says_who_follows(matches: &ArgMatches) -> bool {
    let says_who = |field: &str| WHO.contains(&field);
    matches.contains_id("config")
        || flags::changes(matches, &config_fields()).iter().any(|(field, _)| says_who(&field.path))
}

/// Returns the default driver.
///
/// # Errors
/// None in practice: the name is a preset's.
pub fn default_driver() -> Result<FollowingDriver, CliError> {
    driver(NOBODY_NAMED).map_err(|e| CliError::Input(e.to_string()))
}

impl FollowingDriver {
    /// Returns the driver's name in tables and files.
    pub fn label(&self) -> String {
        match self {
            Self::Configured => "configured".into(),
            Self::Named(named) => named.label(),
            Self::Population(population) => population.name().into(),
        }
    }

    /// Returns the configuration with this driver.
    pub fn of(&self, config: &TrainConfig) -> TrainConfig {
        match self {
            Self::Configured => config.clone(),
            Self::Named(named) => config.driven_by(&named.params),
            Self::Population(population) => config.driven_by_some_of(*population),
        }
    }
}

/// One row of the evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct EvaluationCase {
    /// Name or file of the policy.
    pub policy: String,
    /// Hold of the advice, s.
    pub hold_s: f64,
    /// Driver who follows the advice.
    pub driver: FollowingDriver,
    /// Number or share of advised vehicles.
    pub advised: AdvisedVehicles,
    /// True if the advised vehicles ignore the advice. This separates the effect of the driver model from that of the advice.
    pub ignores_advice: bool,
}

impl std::fmt::Display for EvaluationCase {
    /// Writes the case as text: label, hold and driver.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, hold {} s, driver {}", self.label(), self.hold_s, self.driver.label())
    }
}

impl EvaluationCase {
    /// Returns the configuration of the case's rings. Where no vehicle is advised, the ego has no policy.
    pub fn config(&self, config: &TrainConfig) -> TrainConfig {
        let mut config = self.driver.of(config).held(self.hold_s);
        config.ring.advised = if self.advised.is_no_vehicle() { AdvisedVehicles::default() } else { self.advised };
        config
    }

    /// Returns the policy's short name: the folder of a shipped `policy.toml`, or the last part of a path.
    pub fn label(&self) -> String {
        if self.ignores_advice {
            return "driven whole; ignores advice".into();
        }
        let bare = self.policy.trim_end_matches("/policy.toml").trim_end_matches("/policy.onnx");
        bare.rsplit('/').next().unwrap_or(bare).to_owned()
    }
}

/// Cases to drive and how to drive them.
#[derive(Clone)]
pub struct EvaluationPlan {
    /// Names or files of policies; `none` is among them unless `advised` is given.
    pub policies: Vec<String>,
    /// Policies that the requested names were resolved to.
    pub resolved: Vec<ResolvedPolicy>,
    /// Holds to drive with, s.
    pub holds_s: Vec<f64>,
    /// Drivers who follow the advice.
    pub drivers: Vec<FollowingDriver>,
    /// Advised numbers or shares of a curve, starting at 0; `None` if there is no curve.
    pub advised: Option<Vec<AdvisedVehicles>>,
    /// Advised vehicles without a curve: those of the configuration.
    pub(super) configured: AdvisedVehicles,
    /// Engine that simulates the drives.
    pub engine: Engine,
    /// Other vehicles with a different car-following model, in whole drives.
    pub mixture: ModelMixture,
    /// Road and vehicles of whole drives.
    pub drive: PlannedDrive,
    /// Number of rings for each case.
    pub rings: usize,
    /// Settings of the built-in policies; the equilibrium speed is 0 where vehicles enter and leave.
    pub settings: PolicySettings,
    /// Policies by name, each read once.
    pub(super) sources: BTreeMap<String, PolicySource>,
    /// Folder to write to.
    pub out: Option<PathBuf>,
    /// True if figures of adherence are drawn as well.
    pub adherence: bool,
}

impl EvaluationPlan {
    /// Makes the plan from the command line.
    ///
    /// # Errors
    /// A hold is no whole number of steps, a policy cannot be read, or the engine cannot take this driver, map or share.
    pub fn new(matches: &ArgMatches, config: &TrainConfig, road: Arc<RoadMap>) -> Result<Self, CliError> {
        let holds_s = holds_s(matches, config)?;
        let engine = engine(matches)?;
        let drivers = drivers(matches, config, &engine)?;
        let map = asked_map(matches);
        let written = Scenario { map, vehicles: config.ring.vehicles_min, ..Scenario::default() };
        let scenario = match &engine {
            Engine::Traffic(traffic @ EngineChoice::Log(_)) => Scenario {
                traffic: traffic.clone(),
                warm_up_s: config.ring.warm_up_s,
                duration_s: config.ring.horizon_s,
                ..written
            },
            _ => written,
        };
        let drive = PlannedDrive::on(&scenario, road).map_err(WorldError::from)?;
        let aim_mps = matches.get_one::<f64>("policy-speed").copied().unwrap_or_default();
        let mut settings = config.policy_settings(aim_mps);
        if drive.is_open() {
            check_network(matches, &scenario.map, &engine)?;
            settings.equilibrium_mps = 0.0;
        }
        if drive.logged().is_some() {
            settings.equilibrium_mps = drive.logged_mean_speed_mps();
        }
        match engine {
            Engine::FastRing => check_ring(matches, &scenario.map, drive.map())?,
            Engine::Traffic(_) => check_whole(matches, config)?,
        }
        let advised = advised_curve(matches, &engine, &drive, config)?;
        let (policies, resolved) = policies(matches, drive.map(), advised.is_none());
        let mut sources = BTreeMap::new();
        for name in &policies {
            let source = match engine {
                Engine::FastRing => {
                    PolicySource::for_rings(name, &settings).map_err(|e| CliError::Input(e.to_string()))?
                }
                Engine::Traffic(_) => {
                    let with = Scenario { policy: name.clone(), policy_speed_mps: aim_mps, ..drive.scenario().clone() };
                    let with = PlannedDrive::on(&with, Arc::clone(drive.map())).map_err(WorldError::from)?;
                    policy_of(&with)?.1
                }
            };
            sources.insert(name.clone(), source);
        }
        Ok(Self {
            sources,
            settings,
            policies,
            resolved,
            holds_s,
            drivers,
            advised,
            configured: config.ring.advised,
            mixture: mixture(matches, &engine)?,
            engine,
            drive,
            rings: matches.get_one::<u32>("over").copied().unwrap_or(20) as usize,
            out: matches.get_one::<PathBuf>("out").cloned(),
            adherence: matches.get_flag("adherence"),
        })
    }

    /// Returns a newly engaged policy; `None` for `none`.
    pub fn engage(&self, name: &str) -> Option<Box<dyn Policy>> {
        self.sources.get(name)?.engage()
    }

    /// Returns each policy with each hold, each driver and each share of advised vehicles.
    pub fn cases(&self) -> Vec<EvaluationCase> {
        let mut cases = Vec::new();
        let advised = self.advised.clone().unwrap_or_else(|| vec![self.configured]);
        for policy in &self.policies {
            for driver in &self.drivers {
                for hold_s in &self.holds_s {
                    let case = |advised: &AdvisedVehicles| EvaluationCase {
                        policy: policy.clone(),
                        hold_s: *hold_s,
                        driver: driver.clone(),
                        advised: *advised,
                        ignores_advice: false,
                    };
                    cases.extend(advised.iter().map(case));
                }
            }
        }
        cases.extend(self.ignoring_cases());
        cases
    }

    /// Returns the cases of a curve whose drivers ignore the advice; their policy has no effect.
    fn ignoring_cases(&self) -> Vec<EvaluationCase> {
        let policy = self.policies.iter().find(|name| *name != "none");
        let (Some(advised), Some(policy), Ok(ignores)) = (&self.advised, policy, driver(IGNORES_ADVICE)) else {
            return Vec::new();
        };
        let case = |advised: &AdvisedVehicles| EvaluationCase {
            policy: policy.clone(),
            hold_s: self.holds_s[0],
            driver: ignores.clone(),
            advised: *advised,
            ignores_advice: true,
        };
        advised.iter().map(case).collect()
    }

    /// Returns the case that stands for bit-identical drives: without advice the hold has no effect, and with no advised
    /// vehicle neither policy nor driver has.
    pub fn driven_as(&self, case: &EvaluationCase) -> EvaluationCase {
        let mut same = case.clone();
        if case.advised.is_no_vehicle() {
            (same.policy, same.driver, same.ignores_advice) = ("none".into(), self.drivers[0].clone(), false);
        }
        if same.policy == "none" {
            same.hold_s = self.holds_s[0];
        }
        same
    }

    /// Returns the number of vehicles that a case advises on a ring.
    pub fn advised_by(&self, case: &EvaluationCase) -> u32 {
        case.advised.by_policy(&case.policy).of(self.most_advised())
    }

    /// Returns the planned share of advised vehicles of a case, 0 to 1; on a network, of the vehicles that enter. A case without advice has the
    /// share of those with which it is compared.
    pub fn advised_share(&self, case: &EvaluationCase) -> f64 {
        case.advised.share_of(self.most_advised())
    }

    /// Returns the number of vehicles that can be advised, where it is fixed.
    pub(super) fn most_advised(&self) -> u32 {
        self.drive.advisable().unwrap_or(self.drive.scenario().vehicles)
    }
}

/// Returns the holds to drive with, s: a whole number of steps each.
fn holds_s(matches: &ArgMatches, config: &TrainConfig) -> Result<Vec<f64>, CliError> {
    let asked = matches.get_many::<f64>("holds");
    let holds_s: Vec<f64> = asked.map_or_else(|| vec![config.advice.hold_s], |holds| holds.copied().collect());
    for hold_s in &holds_s {
        config.held(*hold_s).check().map_err(|(_, fault)| CliError::Input(fault))?;
    }
    Ok(holds_s)
}

/// Returns the name or path of the road that was asked for.
pub(super) fn asked_map(matches: &ArgMatches) -> String {
    matches.get_one::<String>("map").cloned().unwrap_or_default()
}

/// Returns the engine that was asked for.
pub(super) fn engine(matches: &ArgMatches) -> Result<Engine, CliError> {
    match matches.get_one::<String>("traffic").map_or("ring", String::as_str) {
        "ring" => Ok(Engine::FastRing),
        traffic => traffic.parse().map(Engine::Traffic).map_err(|e: UnknownEngine| CliError::Input(e.to_string())),
    }
}

/// Returns the drivers. Whole drives take one driver for all rings.
fn drivers(matches: &ArgMatches, config: &TrainConfig, engine: &Engine) -> Result<Vec<FollowingDriver>, CliError> {
    let is_ring = *engine == Engine::FastRing;
    let drivers = match matches.get_many::<FollowingDriver>("driver") {
        Some(drivers) => drivers.cloned().collect(),
        None if !says_who_follows(matches) => vec![default_driver()?],
        None if is_ring => vec![FollowingDriver::Configured],
        None => vec![FollowingDriver::Named(Box::new(config.named_driver().ok_or_else(|| {
            CliError::Input(format!(
                "the configuration draws a driver for each ring (random_driver); traffic {engine} needs one for all\n  \
                 remedy: name one with --driver, or random_driver = false"
            ))
        })?))],
    };
    if !is_ring && drivers.iter().any(|driver| matches!(driver, FollowingDriver::Population(_))) {
        return Err(CliError::Input(format!(
            "a population draws a driver for each ring; traffic {engine} needs one for all\n  remedy: name one with \
             --driver, such as follow, or use traffic ring"
        )));
    }
    Ok(drivers)
}

pub(super) fn asked_policies(matches: &ArgMatches) -> Option<impl Iterator<Item = &String>> {
    matches.get_many::<String>("policy")
}

/// Returns the names of the policies, and what the requested names were resolved to. Tables and figures name the resolved policy.
fn policies(matches: &ArgMatches, road: &RoadMap, needs_baseline: bool) -> (Vec<String>, Vec<ResolvedPolicy>) {
    let resolve = |name: &str| policy::resolve(name, road);
    let resolved: Vec<ResolvedPolicy> = match asked_policies(matches) {
        Some(names) => names.map(|name| resolve(name)).collect(),
        None => policy::NAMES.into_iter().map(resolve).collect(),
    };
    let mut names: Vec<String> = resolved.iter().map(|policy| policy.name.clone()).collect();
    // Results of advice need a baseline without advice; a curve over shares starts with it.
    if needs_baseline && !names.iter().any(|name| name == "none") {
        names.push("none".into());
    }
    (names, resolved)
}

/// Returns the numbers or shares of a curve of advised vehicles, from none upwards; `None` if only the ego is advised.
fn advised_curve(
    matches: &ArgMatches,
    engine: &Engine,
    drive: &PlannedDrive,
    config: &TrainConfig,
) -> Result<Option<Vec<AdvisedVehicles>>, CliError> {
    let (vehicles, most) = (drive.advisable(), drive.advisable().unwrap_or(drive.scenario().vehicles));
    let Some(asked) = matches.get_many::<AdvisedVehicles>("advised") else { return Ok(None) };
    let mut advised: Vec<AdvisedVehicles> = asked.copied().filter(|advised| !advised.is_no_vehicle()).collect();
    let is_too_many = |advised: &&AdvisedVehicles| match advised {
        AdvisedVehicles::Count(count) => vehicles.is_none_or(|vehicles| *count > vehicles),
        AdvisedVehicles::Share(_) => false,
    };
    if let Some(wrong) = advised.iter().find(is_too_many) {
        let allowed = match vehicles {
            Some(vehicles) => format!("allowed: 0 to {vehicles}, as many as there are vehicles, or a share"),
            None => "allowed on a network that vehicles enter and leave: shares, such as 10%".into(),
        };
        return Err(CliError::Input(format!("--advised is {wrong}; {allowed}")));
    }
    if *engine == Engine::FastRing {
        for advised in advised.iter().copied() {
            let ring = RingConfig { advised, ..config.ring.clone() };
            let checked = TrainConfig { ring, ..config.clone() }.check();
            checked.map_err(|(_, text)| CliError::Input(format!("--{text}")))?;
        }
    }
    advised.push(AdvisedVehicles::Count(0));
    let mut advised: Vec<AdvisedVehicles> = advised.into_iter().map(|advised| advised.among(vehicles)).collect();
    advised.sort_by(|a, b| a.share_of(most).total_cmp(&b.share_of(most)));
    advised.dedup();
    Ok(Some(advised))
}

/// Returns the settings of a training that are flags of an evaluation; `--advised` is a list here.
pub(super) fn config_fields() -> Vec<Field> {
    fields_of::<TrainConfig>().into_iter().filter(|field| field.path != "advised").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_driver_is_refused_with_the_known_drivers_and_populations() {
        let message = driver("peple").map_err(|e| e.to_string()).expect_err("nobody is called so");
        assert!(message.starts_with("no driver is called \"peple\" (did you mean people?)\n"), "{message}");
        for known in driver::PRESETS.iter().chain(&driver::MACHINES).chain(&Population::NAMES) {
            assert!(message.contains(known), "{known}: {message}");
        }
        let message = driver("reaction=soon").map_err(|e| e.to_string()).expect_err("no number");
        assert!(message.contains("reaction is \"soon\""), "{message}");
    }
}
