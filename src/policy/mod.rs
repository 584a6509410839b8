//! Advice. In: an [`Observation`] each step. Out: an [`Action`] each hold, shown to the driver as [`Advice`]. [`build`] makes policies
//! from a name or a file; [`Advisor`] asks them once a hold. SI units.

mod advisor;
mod assisted;
mod controller;
mod corrected;
mod error;
mod expected_gain;
mod follower_stopper;
mod hold;
pub mod identification;
mod linear_feedback;
mod network;
mod network_file;
mod observe;
#[cfg(feature = "onnx")]
pub mod onnx;
#[cfg(not(feature = "onnx"))]
#[path = "without_onnx.rs"]
pub mod onnx;
mod open_loop;
mod outside;
mod parameters;
mod pi_saturation;
mod replayed;
mod road_ahead;

pub use advisor::{Advisor, shown_mps, untrained_hold};
pub use assisted::{AssistedPolicy, residual};
pub use controller::{
    CONTROLLERS, Controller, ControllerFault, ControllerFileError, ControllerKind, EngagedController,
};
pub use corrected::{CorrectedAdvice, CorrectionFault, EngagedAdvice, NotCorrectable};
pub use error::{PolicyFileError, PolicyFileFault, SettingFault};
pub use expected_gain::{ExpectedGain, ExpectedGainFault};
pub use follower_stopper::FollowerStopper;
pub use hold::{Hold, HoldError};
pub use identification::{DriverEstimate, DriverEstimator, DriverTraits, LatentEstimate, WhoDrives};
pub use linear_feedback::LinearFeedback;
pub use network::{FORMAT, LayerFault, Network, NetworkLayer, NetworkOutput, PolicyNetworkFault, bounded};
pub use observe::{FEATURES, FIELD_INPUTS, Feature, LATENTS, MeanSpeed, NetworkInput};
pub use onnx::OnnxPolicy;
pub use open_loop::{ConstantSpeed, TwoPhase};
pub use outside::OutsideAdvice;
pub use parameters::{Order, Parameter, SearchScale};
pub use pi_saturation::{PiParameters, PiSaturation};
pub use replayed::ReplayedAdvice;
pub use road_ahead::{FAR_M, LaneBeside, LanesBeside, NearVehicle, RoadAhead, RoadKind, SignalAhead};

use crate::{
    data_folders,
    map::{self, RoadMap},
    time::Tick,
    toml_text::did_you_mean,
};
use std::path::{Path, PathBuf};

/// Inputs available to a policy; the first four are HC22's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Own speed, m/s.
    pub speed_mps: f64,
    /// Leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// Own front bumper to the leader's rear bumper, m.
    pub gap_m: f64,
    /// Length of the closed route, m.
    pub circumference_m: f64,
    /// Number of vehicles on the closed route, the ego included.
    pub vehicles: u32,
    /// Hold of the action, s; set by [`Advisor`].
    pub hold_s: f64,
    /// Own mean speed over about the last half minute, m/s ([`MeanSpeed`]); set by [`Advisor`].
    pub mean_speed_mps: f64,
    /// Target of the current advice, m/s; set by [`Advisor`].
    pub advised_mps: Option<f64>,
    /// Traits of the driver, if known or estimated.
    pub driver: Option<DriverTraits>,
    /// Latents of the driver from a variational encoder, dimensionless; 0 if unknown.
    pub latents: [f64; identification::MOST_LATENTS],
    /// Speed that the policy corrects, m/s, if it corrects one.
    pub corrected_mps: Option<f64>,
    /// Road ahead; absent on training rings.
    pub road: RoadAhead,
}

/// Output of a policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Acceleration to keep for the hold, m/s².
    Acceleration(f64),
    /// Speed to drive for the hold, m/s.
    Speed(f64),
}

/// One advice as shown on the speedometer.
///
/// # Examples
///
/// ```
/// use codrive::{
///     policy::{Action, Advice, Hold},
///     time::Tick,
/// };
///
/// let advice = Advice {
///     issued: Tick(0),
///     hold: Hold::nearest(10.0, 0.1),
///     action: Action::Speed(4.5),
///     target_mps: 4.5,
///     range_mps: 0.5,
///     is_fallback: false,
///     driver: None,
/// };
/// assert_eq!(advice.band_mps(), (4.0, 5.0));
/// assert!(advice.accepts(4.0) && !advice.accepts(5.1));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice {
    /// Tick at which the advice was issued.
    pub issued: Tick,
    /// Time that the advice stays in force.
    pub hold: Hold,
    /// Action as the policy returned it.
    pub action: Action,
    /// Speed to drive, m/s, within 0 and the speed limit.
    pub target_mps: f64,
    /// Half width of the acceptable range, m/s: target +- this.
    pub range_mps: f64,
    /// True if the policy returned no finite number and the previous target stays in force.
    pub is_fallback: bool,
    /// Estimate of the driver's traits at the issue time, if the policy has an estimator.
    pub driver: Option<DriverEstimate>,
}

impl Advice {
    /// Returns the lowest and the highest acceptable speed, m/s, never below 0.
    pub fn band_mps(&self) -> (f64, f64) {
        ((self.target_mps - self.range_mps).max(0.0), self.target_mps + self.range_mps)
    }

    /// Returns true if `speed_mps` lies in the acceptable range, edges included.
    pub fn accepts(&self, speed_mps: f64) -> bool {
        let (low, high) = self.band_mps();
        (low..=high).contains(&speed_mps)
    }
}

/// A source of actions. It is `Send`: a world is created on one thread and driven on another.
///
/// # Examples
///
/// ```
/// use codrive::policy::{Action, Observation, Policy};
///
/// struct CloseUp;
///
/// impl Policy for CloseUp {
///     fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
///         let extra_mps = if observation.gap_m > 20.0 { 1.0 } else { 0.0 };
///         Action::Speed(observation.leader_speed_mps + extra_mps)
///     }
/// }
///
/// let observation = Observation { leader_speed_mps: 4.0, gap_m: 25.0, ..Observation::default() };
/// assert_eq!(CloseUp.act(0.0, &observation), Action::Speed(5.0));
/// assert!(!CloseUp.abstains(0.0, &observation));
/// ```
pub trait Policy: Send {
    /// Receives every step, also within a hold; called before [`Policy::act`] in the same step.
    fn watch(&mut self, observation: &Observation) {
        let _ = observation;
    }

    /// Returns the action for the hold that begins now, `time_s` after the policy was engaged.
    fn act(&mut self, time_s: f64, observation: &Observation) -> Action;

    /// Returns true if advice would not help. Nothing is shown for the hold that begins now, `time_s` after the policy was engaged, and
    /// the driver drives without advice.
    fn abstains(&mut self, time_s: f64, observation: &Observation) -> bool {
        let _ = (time_s, observation);
        false
    }

    /// Returns the current estimate of the driver, if the policy has an estimator.
    fn who_drives(&self) -> Option<WhoDrives> {
        None
    }

    /// Returns the estimated traits of the driver, if the policy estimates traits.
    fn driver_estimate(&self) -> Option<DriverEstimate> {
        self.who_drives().and_then(|driver| driver.traits())
    }

    /// Returns true if the policy needs the driver's traits or latents as input and has no estimator for them.
    fn needs_driver_traits(&self) -> bool {
        false
    }

    /// Shortest and longest hold seen in training, s, if the policy was trained.
    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        None
    }
}

/// Road and step data that [`build`] needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicySettings {
    /// Target speed, m/s; 0 takes [`AUTOMATIC_SHARE`] of `equilibrium_mps`.
    pub aim_mps: f64,
    /// Equilibrium speed of an evenly spaced ring of these vehicles, m/s.
    pub equilibrium_mps: f64,
    /// Length of a step, s.
    pub step_s: f64,
}

impl PolicySettings {
    /// Returns the target speed, or the automatic one if none is set, m/s.
    pub fn aim_or_automatic_mps(&self) -> f64 {
        if self.aim_mps > 0.0 { self.aim_mps } else { AUTOMATIC_SHARE * self.equilibrium_mps }
    }
}

/// Automatic target speed as a share of the equilibrium speed: on the 250 m ring 4.30 of 4.362 m/s. At 4.30 m/s two-phase and
/// FollowerStopper calm every seed; at 4.43 m/s the latter calms only 11 of 20 (docs/references.md: advice).
pub const AUTOMATIC_SHARE: f64 = 0.985;

/// Names that [`build`] knows: the first gives no advice, the others are the names of [`CONTROLLERS`].
pub const NAMES: [&str; 6] = ["none", "constant", "two-phase", "follower-stopper", "pi", "linear-feedback"];

/// Reasons that a policy cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// No policy has this name.
    #[error(
        "policy `{name}` is unknown{}; known are {}, or the FILE.toml or FILE.onnx of a trained one, or a controller's FILE.toml",
        did_you_mean(name, &all_names()), all_names().join(", ")
    )]
    Unknown {
        /// Policy name as the user gave it.
        name: String,
    },
    /// No controller has this name.
    #[error(
        "controller `{name}` is unknown{}; known are {}, or the FILE.toml of one",
        did_you_mean(name, &NAMES[1..]), NAMES[1..].join(", ")
    )]
    UnknownController {
        /// Controller name as the user gave it.
        name: String,
    },
    /// No controller and no correctable policy has this name.
    #[error(
        "controller or policy `{name}` is unknown{}; known are {}, or the FILE.toml of a controller or of a trained policy",
        did_you_mean(name, &correctable_names()), correctable_names().join(", ")
    )]
    UnknownCorrected {
        /// Name as the user gave it.
        name: String,
    },
    /// An ONNX network cannot be embedded in a policy file.
    #[error("policy {name} cannot be corrected: it is no policy file of this program\n  remedy: name its policy.toml")]
    CorrectedOnnx {
        /// Policy name as the user gave it.
        name: String,
    },
    /// The policy's advice cannot be corrected.
    #[error("policy {name} {fault}")]
    NotCorrectable {
        /// Policy name as the user gave it.
        name: String,
        /// Reason that it cannot be corrected.
        fault: NotCorrectable,
    },
    /// The policy was trained with the driver's traits as input. A drive does not supply them.
    #[error(
        "policy {name} must be told who drives ({}), and has no estimator that finds out\n  remedy: train it with \
         estimator_rounds above 0, or name another policy",
        FEATURES.iter().filter(|feature| feature.is_of_driver()).map(|feature| feature.name()).collect::<Vec<_>>().join(", ")
    )]
    MustBeTold {
        /// Policy name as the user gave it.
        name: String,
    },
    /// The policy needs more of the road than training and evaluation rings have.
    #[error(
        "policy {name} needs whole drives: it {why} on rings of training and evaluation\n  remedy: codrive run, or name another policy"
    )]
    NotOnRings {
        /// Policy name as the user gave it.
        name: String,
        /// Part of the road that the policy needs.
        why: String,
    },
    /// The file of a trained policy cannot be used.
    #[error("policy {0}")]
    File(#[from] PolicyFileError),
    /// The file of a controller cannot be used.
    #[error("policy {0}")]
    Controller(#[from] ControllerFileError),
}

/// Name that stands for the shipped speed policy of the map, or for two-phase advice if there is none.
pub const AUTO: &str = "auto";

/// Returns the sorted names of the policies in `assets/policies`.
pub fn shipped() -> Vec<String> {
    let folders = std::fs::read_dir(data_folders::root().join(SHIPPED)).into_iter().flatten().flatten();
    let whole = folders.filter(|folder| folder.path().join("policy.toml").exists());
    let mut names: Vec<String> = whole.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Returns all names: [`AUTO`], [`NAMES`] and the shipped policies.
fn all_names() -> Vec<String> {
    std::iter::once(AUTO).chain(NAMES).map(str::to_owned).chain(shipped()).collect()
}

/// Returns the names of everything that can be corrected: controllers and shipped policies.
fn correctable_names() -> Vec<String> {
    NAMES[1..].iter().map(|name| (*name).to_owned()).chain(shipped()).collect()
}

/// Folder of the shipped policies, relative to the project's root.
const SHIPPED: &str = "assets/policies";

/// A policy's name after [`AUTO`] has been resolved, with the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResolvedPolicy {
    /// Name of the policy, or path of its file.
    pub name: String,
    /// Reason for the choice; `None` unless [`AUTO`] was resolved.
    pub why: Option<String>,
}

impl ResolvedPolicy {
    /// Returns false for `none`.
    pub fn gives_advice(&self) -> bool {
        self.name != NAMES[0]
    }
}

impl std::fmt::Display for ResolvedPolicy {
    /// Writes the name for display, with the reason in brackets if there is one.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.why {
            Some(why) => write!(f, "{} ({why})", self.name),
            None => f.write_str(&self.name),
        }
    }
}

/// Resolves a policy name for a map: [`AUTO`] to a shipped policy or two-phase, any other name to itself. A shipped map is recognised by
/// name, by path and as a copy.
pub fn resolve(name: &str, map: &RoadMap) -> ResolvedPolicy {
    resolve_among(&shipped(), name, map)
}

/// Resolves a policy name with `shipped` as the list of shipped policies.
fn resolve_among(shipped: &[String], name: &str, map: &RoadMap) -> ResolvedPolicy {
    if name != AUTO {
        return ResolvedPolicy { name: name.into(), why: None };
    }
    let road = map::known_as(map);
    let own = road.as_deref().map(|road| format!("{road}-speed")).filter(|own| shipped.contains(own));
    let why = match (&own, &road) {
        (Some(_), Some(road)) => format!("{AUTO}: the policy that is shipped for {road}"),
        _ if shipped.is_empty() => {
            format!("{AUTO}: no shipped policies at {}", data_folders::root().join(SHIPPED).display())
        }
        _ => format!("{AUTO}: no policy is shipped for {}", map.name),
    };
    ResolvedPolicy { name: own.unwrap_or_else(|| "two-phase".into()), why: Some(why) }
}

/// Returns true if the name is the path of a policy file.
pub fn is_path(name: &str) -> bool {
    name.ends_with(".onnx") || name.ends_with(".toml")
}

/// Returns the policy file of a name: the path itself, or the file of a shipped policy.
pub fn file_of(name: &str) -> Option<PathBuf> {
    if is_path(name) {
        return Some(name.into());
    }
    shipped().iter().any(|own| own == name).then(|| data_folders::root().join(SHIPPED).join(name).join("policy.toml"))
}

/// Returns all files of the policy at a path, its main file first.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    if path.extension().is_some_and(|e| e == "onnx") { OnnxPolicy::files(path) } else { vec![path.into()] }
}

/// A policy that is read once and engaged any number of times; reading a trained policy's file takes longer than driving with it.
#[derive(Clone)]
pub struct PolicySource {
    kind: SourceKind,
    step_s: f64,
}

#[derive(Clone)]
enum SourceKind {
    NoAdvice,
    Controller(Controller),
    Network(Box<Network>),
    Onnx(Box<OnnxPolicy>),
}

impl PolicySource {
    /// Reads a policy by name, shipped ones included, or by the path of its file (`.toml`, `.onnx`).
    ///
    /// # Errors
    /// The name is neither in [`NAMES`] nor shipped, or the file cannot be used.
    pub fn read(name: &str, settings: &PolicySettings) -> Result<Self, PolicyError> {
        let kind = match (ControllerKind::named(name), file_of(name)) {
            (Some(kind), _) => SourceKind::Controller(Controller::by_name(kind, settings)),
            (None, _) if name == "none" => SourceKind::NoAdvice,
            (None, Some(file)) if name.ends_with(".onnx") => SourceKind::Onnx(Box::new(OnnxPolicy::from_file(&file)?)),
            (None, Some(file)) => Self::from_toml_file(&file)?,
            (None, None) => return Err(PolicyError::Unknown { name: name.into() }),
        };
        Ok(Self { kind, step_s: settings.step_s })
    }

    /// Reads the policy of a TOML file, a trained network or a controller.
    fn from_toml_file(path: &Path) -> Result<SourceKind, PolicyError> {
        let text = network::read(path)?;
        Ok(if controller::is_controller(&text) {
            SourceKind::Controller(Controller::from_toml(&text, &path.display().to_string())?)
        } else {
            SourceKind::Network(Box::new(Network::from_text_of(path, &text)?))
        })
    }

    /// Returns a newly engaged policy; `None` for `none`.
    pub fn engage(&self) -> Option<Box<dyn Policy>> {
        Some(match &self.kind {
            SourceKind::NoAdvice => return None,
            SourceKind::Controller(controller) => controller.policy(self.step_s),
            SourceKind::Network(network) => network.as_ref().clone().policy(self.step_s),
            SourceKind::Onnx(policy) => policy.engaged(self.step_s),
        })
    }
}

/// Builds and engages a policy by name or by the path of its file; `None` for `none`.
///
/// # Errors
/// The errors of [`PolicySource::read`].
///
/// # Examples
///
/// ```
/// use codrive::policy::{self, Action, Observation, PolicySettings};
///
/// let settings = PolicySettings { aim_mps: 4.3, equilibrium_mps: 4.362, step_s: 0.1 };
/// let mut constant = policy::build("constant", &settings)?.expect("only `none` gives no advice");
/// assert_eq!(constant.act(0.0, &Observation::default()), Action::Speed(4.3));
/// assert!(policy::build("none", &settings)?.is_none());
/// assert!(policy::build("constnat", &settings).is_err());
/// # Ok::<(), policy::PolicyError>(())
/// ```
pub fn build(name: &str, settings: &PolicySettings) -> Result<Option<Box<dyn Policy>>, PolicyError> {
    Ok(PolicySource::read(name, settings)?.engage())
}

/// Returns the controller with this name, or reads it from a file.
///
/// # Errors
/// No controller has this name, or the file cannot be used or holds no controller.
pub fn controller(name: &str, settings: &PolicySettings) -> Result<Controller, PolicyError> {
    match ControllerKind::named(name) {
        Some(kind) => Ok(Controller::by_name(kind, settings)),
        None if name.ends_with(".toml") => Ok(Controller::from_toml(&network::read(Path::new(name))?, name)?),
        None => Err(PolicyError::UnknownController { name: name.into() }),
    }
}
