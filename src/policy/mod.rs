//! Advice. In: an [`Observation`] each step. Out: an [`Action`] each hold, shown to the driver as [`Advice`]. Policies
//! are built by name or from a file with [`build`]; [`Advisor`] keeps the hold. SI units.

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
pub use network::{FORMAT, LayerFault, Network, NetworkFault, NetworkLayer, NetworkOutput, bounded};
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

/// What a policy may know: HC22's four numbers first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Own speed, m/s.
    pub speed_mps: f64,
    /// Leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// Own front bumper to the leader's rear bumper, metres.
    pub gap_m: f64,
    /// Length of the closed route, metres.
    pub circumference_m: f64,
    /// Cars on it, the ego included.
    pub vehicles: u32,
    /// How long its action will stand, seconds; [`Advisor`] knows.
    pub hold_s: f64,
    /// Own mean speed of about the last half minute, m/s ([`MeanSpeed`]); [`Advisor`] knows.
    pub mean_speed_mps: f64,
    /// The advice that stands, m/s; [`Advisor`] knows.
    pub advised_mps: Option<f64>,
    /// Who drives, where that is known or has been estimated.
    pub driver: Option<DriverTraits>,
    /// What a variational encoder made out of him, without a unit; 0 where nothing is known.
    pub latents: [f64; identification::MOST_LATENTS],
    /// The speed that the policy corrects, if it corrects one, m/s.
    pub corrected_mps: Option<f64>,
    /// The road ahead; rings of training have none.
    pub road: RoadAhead,
}

/// What a policy puts out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Keep this acceleration for the hold, m/s2.
    Acceleration(f64),
    /// Drive this speed for the hold, m/s.
    Speed(f64),
}

/// One advice as it stands on the speedometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice {
    /// When it was issued.
    pub issued: Tick,
    /// How long it stands.
    pub hold: Hold,
    /// The policy's own action.
    pub action: Action,
    /// Speed to be driven, m/s, within 0 and the speed limit.
    pub target_mps: f64,
    /// Half width of the acceptable range, m/s: target +- this.
    pub range_mps: f64,
    /// The policy's answer was no number, and what was advised before stands.
    pub is_fallback: bool,
    /// What the policy made of the driver when it was issued, if it asks.
    pub driver: Option<DriverEstimate>,
}

impl Advice {
    /// Lowest and highest acceptable speed, m/s; never below 0.
    pub fn band_mps(&self) -> (f64, f64) {
        ((self.target_mps - self.range_mps).max(0.0), self.target_mps + self.range_mps)
    }

    /// True if `speed_mps` lies in the acceptable range, its edges included.
    pub fn accepts(&self, speed_mps: f64) -> bool {
        let (low, high) = self.band_mps();
        (low..=high).contains(&speed_mps)
    }
}

/// A source of actions. A world is begun on one thread and driven on another.
pub trait Policy: Send {
    /// Sees every step, also those within a hold; called before [`Policy::act`] in the same step.
    fn watch(&mut self, observation: &Observation) {
        let _ = observation;
    }

    /// The action for the hold that begins now, `time_s` after the policy was engaged.
    fn act(&mut self, time_s: f64, observation: &Observation) -> Action;

    /// True where it knows that advice would not help: nothing is shown for the hold that begins now, `time_s` after it was
    /// engaged, and the driver drives as without.
    fn abstains(&mut self, time_s: f64, observation: &Observation) -> bool {
        let _ = (time_s, observation);
        false
    }

    /// What it has found out about the driver, if it asks.
    fn who_drives(&self) -> Option<WhoDrives> {
        None
    }

    /// The driver's traits as it makes them out, if it asks for traits.
    fn driver_estimate(&self) -> Option<DriverEstimate> {
        self.who_drives().and_then(|told| told.traits())
    }

    /// True where it must be told who drives and does not find out by itself.
    fn must_be_told_who_drives(&self) -> bool {
        false
    }

    /// Shortest and longest hold that it was made for, seconds, if it was made for some.
    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        None
    }
}

/// What [`build`] needs to know of the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolicySettings {
    /// Speed to aim for, m/s; 0 takes [`AUTOMATIC_SHARE`] of `equilibrium_mps`.
    pub aim_mps: f64,
    /// Speed at which an even ring of these cars flows, m/s.
    pub equilibrium_mps: f64,
    /// Length of a step, seconds.
    pub step_s: f64,
}

impl PolicySettings {
    /// The aim, or the automatic one where none is set, m/s.
    pub fn aim_or_automatic_mps(&self) -> f64 {
        if self.aim_mps > 0.0 { self.aim_mps } else { AUTOMATIC_SHARE * self.equilibrium_mps }
    }
}

/// The automatic aim as a share of the equilibrium speed. On the 250 m ring 4.30 of 4.362 m/s: from there on two-phase and
/// FollowerStopper calm every seed, at 4.43 the latter only 11 of 20 (docs/references.md: advice).
pub const AUTOMATIC_SHARE: f64 = 0.985;

/// Names that [`build`] knows; the first advises nothing, the others are those of [`CONTROLLERS`].
pub const NAMES: [&str; 6] = ["none", "constant", "two-phase", "follower-stopper", "pi", "linear-feedback"];

/// Why there is no such policy.
#[derive(Debug, thiserror::Error)]
pub enum PolicyError {
    /// No policy has this name.
    #[error(
        "policy `{name}` is unknown{}; known are {}, or the FILE.toml or FILE.onnx of a trained one, or a controller's FILE.toml",
        did_you_mean(name, &all_names()), all_names().join(", ")
    )]
    Unknown {
        /// The name as given.
        name: String,
    },
    /// No controller has this name.
    #[error(
        "controller `{name}` is unknown{}; known are {}, or the FILE.toml of one",
        did_you_mean(name, &NAMES[1..]), NAMES[1..].join(", ")
    )]
    UnknownController {
        /// The name as given.
        name: String,
    },
    /// Nothing that could be corrected has this name.
    #[error(
        "controller or policy `{name}` is unknown{}; known are {}, or the FILE.toml of a controller or of a trained policy",
        did_you_mean(name, &correctable_names()), correctable_names().join(", ")
    )]
    UnknownCorrected {
        /// The name as given.
        name: String,
    },
    /// A network in another program's format cannot be built into a policy's file.
    #[error("policy {name} cannot be corrected: it is no policy file of this program\n  remedy: name its policy.toml")]
    CorrectedOnnx {
        /// The name as given.
        name: String,
    },
    /// It is no advice that can be corrected.
    #[error("policy {name} {fault}")]
    NotCorrectable {
        /// The name as given.
        name: String,
        /// Why.
        fault: NotCorrectable,
    },
    /// It was told in training who drives, which nobody can tell it in a drive.
    #[error(
        "policy {name} must be told who drives ({}), and has no estimator that finds out\n  remedy: train it with \
         estimator_rounds above 0, or name another policy",
        FEATURES.iter().filter(|feature| feature.is_of_driver()).map(|feature| feature.name()).collect::<Vec<_>>().join(", ")
    )]
    MustBeTold {
        /// The name as given.
        name: String,
    },
    /// It needs more of the road than rings of training and evaluation have.
    #[error(
        "policy {name} needs whole drives: it {why} on rings of training and evaluation\n  remedy: codrive run, or name another policy"
    )]
    NotOnRings {
        /// The name as given.
        name: String,
        /// What it needs.
        why: String,
    },
    /// The file of a trained policy cannot be used.
    #[error("policy {0}")]
    File(#[from] PolicyFileError),
    /// The file of a controller cannot be used.
    #[error("policy {0}")]
    Controller(#[from] ControllerFileError),
}

/// Stands for the shipped speed policy of the map, or for two-phase advice where there is none.
pub const AUTO: &str = "auto";

/// Names of the policies in `assets/policies`, sorted.
pub fn shipped() -> Vec<String> {
    let folders = std::fs::read_dir(data_folders::root().join(SHIPPED)).into_iter().flatten().flatten();
    let whole = folders.filter(|folder| folder.path().join("policy.toml").exists());
    let mut names: Vec<String> = whole.map(|folder| folder.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// All names: of [`AUTO`], of [`NAMES`], and of the shipped ones.
fn all_names() -> Vec<String> {
    std::iter::once(AUTO).chain(NAMES).map(str::to_owned).chain(shipped()).collect()
}

/// Names of what can be corrected: of controllers, and of the shipped policies.
fn correctable_names() -> Vec<String> {
    NAMES[1..].iter().map(|name| (*name).to_owned()).chain(shipped()).collect()
}

/// Where the shipped policies lie, below the project's root.
const SHIPPED: &str = "assets/policies";

/// The policy that drives, and how it came to that.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResolvedPolicy {
    /// Its own name, or its file.
    pub name: String,
    /// Why it is this one, where another name was asked for.
    pub why: Option<String>,
}

impl ResolvedPolicy {
    /// For people: the name, and in brackets why it is this one.
    pub fn words(&self) -> String {
        match &self.why {
            Some(why) => format!("{} ({why})", self.name),
            None => self.name.clone(),
        }
    }
}

/// The policy that a name stands for on a map: that of [`AUTO`], otherwise itself. A shipped map is the same by its name, by
/// its path and as a copy.
pub fn resolve(name: &str, map: &RoadMap) -> ResolvedPolicy {
    resolve_among(&shipped(), name, map)
}

/// The same with these policies as the shipped ones.
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

/// True if a policy is named by the path of its file.
pub fn is_path(name: &str) -> bool {
    name.ends_with(".onnx") || name.ends_with(".toml")
}

/// The file of a policy that has one: as it is given, or that of a shipped one.
pub fn file_of(name: &str) -> Option<PathBuf> {
    if is_path(name) {
        return Some(name.into());
    }
    shipped().iter().any(|own| own == name).then(|| data_folders::root().join(SHIPPED).join(name).join("policy.toml"))
}

/// All files that the policy of a path is made of, its own first.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    if path.extension().is_some_and(|e| e == "onnx") { OnnxPolicy::files(path) } else { vec![path.into()] }
}

/// A policy that has been read and can be engaged any number of times: reading a trained one's file takes longer than driving
/// with it.
#[derive(Clone)]
pub struct PolicySource {
    kind: SourceKind,
    step_s: f64,
}

/// What was read.
#[derive(Clone)]
enum SourceKind {
    NoAdvice,
    Controller(Controller),
    Network(Box<Network>),
    Onnx(Box<OnnxPolicy>),
}

impl PolicySource {
    /// A policy by name, a shipped one's included, or by the path of its file (`.toml`, `.onnx`).
    ///
    /// # Errors
    /// The name is neither among [`NAMES`] nor shipped, or the file cannot be used.
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

    /// The policy of a TOML file, which is a trained one or a controller.
    fn from_toml_file(path: &Path) -> Result<SourceKind, PolicyError> {
        let text = network::read(path)?;
        Ok(if controller::is_controller(&text) {
            SourceKind::Controller(Controller::from_toml(&text, &path.display().to_string())?)
        } else {
            SourceKind::Network(Box::new(Network::from_text_of(path, &text)?))
        })
    }

    /// The policy, engaged now; `None` for `none`.
    pub fn engage(&self) -> Option<Box<dyn Policy>> {
        Some(match &self.kind {
            SourceKind::NoAdvice => return None,
            SourceKind::Controller(controller) => controller.policy(self.step_s),
            SourceKind::Network(network) => network.as_ref().clone().policy(self.step_s),
            SourceKind::Onnx(policy) => policy.engaged(self.step_s),
        })
    }
}

/// A policy by name or by the path of its file, engaged now; `None` for `none`.
///
/// # Errors
/// As [`PolicySource::read`] has them.
pub fn build(name: &str, settings: &PolicySettings) -> Result<Option<Box<dyn Policy>>, PolicyError> {
    Ok(PolicySource::read(name, settings)?.engage())
}

/// The controller of a name, or of a file.
///
/// # Errors
/// No controller has this name, or the file cannot be used or is no controller's.
pub fn controller(name: &str, settings: &PolicySettings) -> Result<Controller, PolicyError> {
    match ControllerKind::named(name) {
        Some(kind) => Ok(Controller::by_name(kind, settings)),
        None if name.ends_with(".toml") => Ok(Controller::from_toml(&network::read(Path::new(name))?, name)?),
        None => Err(PolicyError::UnknownController { name: name.into() }),
    }
}
