//! What a policy corrects: a controller, or a network that advises by itself. In: an [`Observation`] each step. Out: a speed at
//! each decision, to which the correction is added.
//!
//! A network that is corrected stays as it was trained (PeRP 2023 corrects a piecewise-constant policy). It is asked when its
//! corrector is, so that what it advises stands as long as the correction.

use super::{
    Controller, EngagedController, Network, NetworkFault, NetworkOutput, Observation, Policy, PolicyError,
    PolicySettings, PolicySource, SourceKind,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::fmt::Write;

/// What the `kind` of a corrected advice is in files where it is no controller.
const NETWORK: &str = "network";

/// An advice that a policy corrects.
#[derive(Clone, Debug, PartialEq)]
pub enum CorrectedAdvice {
    /// A controller and what it is set to.
    Controller(Controller),
    /// A trained network: its action without noise.
    Network(Box<Network>),
}

/// Why a policy cannot correct what it is to correct.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CorrectionFault {
    /// An acceleration cannot be added to a speed.
    #[error("only a policy whose action is \"speed\" can correct a controller or a network")]
    OfAcceleration,
    /// A number of the controller that it corrects cannot be.
    #[error("the controller's {key} is {value}; allowed: {allowed}")]
    Controller {
        /// The parameter.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// The network cannot be used at all.
    #[error("the network that is corrected: {0}")]
    Network(Box<NetworkFault>),
    /// The network can be used, but not be corrected.
    #[error("the network that is corrected {0}")]
    NotCorrectable(#[from] NotCorrectable),
}

/// Why a network cannot be corrected; it is said behind its name.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotCorrectable {
    /// It puts out an acceleration.
    #[error("advises an acceleration, to which no speed can be added{}", REMEDY)]
    Acceleration,
    /// It is the correction of something else.
    #[error("corrects another advice itself{}", REMEDY)]
    CorrectsItself,
    /// It needs to be told who drives.
    #[error("asks who drives{}", REMEDY)]
    AsksWhoDrives,
    /// It is silent for some drivers on some roads.
    #[error("is silent where it expects harm{}", REMEDY)]
    IsSilent,
    /// It is silent on roads on which its corrector is not.
    #[error(
        "withholds advice where there is less than {corrected_m} m of road for each car, its correction below {own_m} m\n  \
         remedy: train the correction with least_spacing_m = {corrected_m} or more"
    )]
    LeastSpacing {
        /// Road for each car below which it is silent, metres.
        corrected_m: f64,
        /// The same of its corrector.
        own_m: f64,
    },
}

const REMEDY: &str = "\n  remedy: name a speed policy that stands alone, such as ring-250-speed, or a controller";

impl CorrectedAdvice {
    /// The advice of a name or a file: of a controller, or of a trained policy.
    ///
    /// # Errors
    /// There is none, its file cannot be used, or it is no advice that can be corrected.
    pub fn read(name: &str, settings: &PolicySettings) -> Result<Self, PolicyError> {
        if name.ends_with(".onnx") {
            return Err(PolicyError::CorrectedOnnx { name: name.into() });
        }
        match PolicySource::for_rings(name, settings).map(|source| source.kind) {
            Ok(SourceKind::Controller(controller)) => Ok(Self::Controller(controller)),
            Ok(SourceKind::Network(network)) => match stands_alone(&network) {
                Ok(()) => Ok(Self::Network(network)),
                Err(fault) => Err(PolicyError::NotCorrectable { name: name.into(), fault }),
            },
            Ok(SourceKind::NoAdvice | SourceKind::Onnx(_)) | Err(PolicyError::Unknown { .. }) => {
                Err(PolicyError::UnknownCorrected { name: name.into() })
            }
            Err(other) => Err(other),
        }
    }

    /// Fails where a policy of such actions, which withholds advice below `least_spacing_m` metres of road for each car, cannot
    /// correct it.
    ///
    /// # Errors
    /// A number of it cannot be, or it is an advice of another kind.
    pub fn check(&self, action: NetworkOutput, least_spacing_m: f64) -> Result<(), CorrectionFault> {
        if action != NetworkOutput::Speed {
            return Err(CorrectionFault::OfAcceleration);
        }
        match self {
            Self::Controller(controller) => controller.fault().map_or(Ok(()), |(parameter, value, allowed)| {
                Err(CorrectionFault::Controller { key: parameter.key, value, allowed })
            }),
            Self::Network(network) => {
                network.check().map_err(|fault| CorrectionFault::Network(fault.into()))?;
                stands_alone(network)?;
                let (corrected_m, own_m) = (network.least_spacing_m, least_spacing_m);
                if own_m < corrected_m {
                    return Err(NotCorrectable::LeastSpacing { corrected_m, own_m }.into());
                }
                Ok(())
            }
        }
    }

    /// Appends it to a policy's file.
    pub(super) fn write(&self, text: &mut String) {
        match self {
            Self::Controller(controller) => {
                let table = toml::to_string(controller).unwrap_or_default();
                let _ = write!(text, "\n# The output is added to the speed of this controller.\n[controller]\n{table}");
            }
            Self::Network(network) => {
                text.push_str("\n# The output is added to the speed that this network advises.\n");
                let _ = writeln!(text, "[controller]\nkind = \"{NETWORK}\"");
                network.write_alone(text, "controller.");
            }
        }
    }
}

/// Fails where a network needs more than the traffic to advise a speed, or does not always advise one.
fn stands_alone(network: &Network) -> Result<(), NotCorrectable> {
    if network.action != NetworkOutput::Speed {
        return Err(NotCorrectable::Acceleration);
    }
    if network.corrected.is_some() {
        return Err(NotCorrectable::CorrectsItself);
    }
    if network.estimator.is_some() || network.must_be_told_who_drives() {
        return Err(NotCorrectable::AsksWhoDrives);
    }
    if network.expected_gain.is_some() { Err(NotCorrectable::IsSilent) } else { Ok(()) }
}

impl Serialize for CorrectedAdvice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct NetworkTable<'a> {
            kind: &'static str,
            #[serde(flatten)]
            network: &'a Network,
        }
        match self {
            Self::Controller(controller) => controller.serialize(serializer),
            Self::Network(network) => NetworkTable { kind: NETWORK, network }.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for CorrectedAdvice {
    /// By its `kind`, so that what is wrong with the one is not told as what it lacks of the other.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut table = toml::Table::deserialize(deserializer)?;
        let is_network = table.get("kind").and_then(toml::Value::as_str) == Some(NETWORK);
        let read = if is_network {
            table.remove("kind");
            table.try_into().map(Self::Network)
        } else {
            table.try_into().map(Self::Controller)
        };
        read.map_err(|fault| D::Error::custom(fault.message()))
    }
}

/// A corrected advice at work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EngagedAdvice {
    /// A controller with its memory.
    Controller(EngagedController),
    /// A network, which has none.
    Network(Box<Network>),
}

impl EngagedAdvice {
    /// Engaged now, to be shown an observation each `step_s` seconds.
    pub fn new(advice: &CorrectedAdvice, step_s: f64) -> Self {
        match advice {
            CorrectedAdvice::Controller(controller) => Self::Controller(EngagedController::new(controller, step_s)),
            CorrectedAdvice::Network(network) => Self::Network(network.clone()),
        }
    }

    /// Sees a step.
    pub fn watch(&mut self, observation: &Observation) {
        if let Self::Controller(controller) = self {
            controller.watch(observation);
        }
    }

    /// What it advises `time_s` seconds after it was engaged, m/s, 0 or more.
    pub fn speed_mps(&self, time_s: f64, observation: &Observation) -> f64 {
        match self {
            Self::Controller(controller) => controller.command_mps(time_s, observation),
            Self::Network(network) => network.speed_mps(observation),
        }
    }
}

#[cfg(test)]
#[path = "corrected_tests.rs"]
mod tests;
