//! Advice that a policy corrects: a controller, or a network that advises by itself. In: an [`Observation`] each step. Out: a speed at
//! each decision, to which the correction is added.
//!
//! A corrected network stays as it was trained (PeRP 2023 corrects a piecewise-constant policy). It is asked whenever its corrector is,
//! so that its advice has the same hold as the correction.

use super::{CorrectionFault, Network, NetworkOutput, NotCorrectable};
use crate::policy::{Controller, EngagedController, Observation, Policy};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use std::fmt::Write;

/// Value of `kind` in files if the corrected advice is a network.
const NETWORK: &str = "network";

/// An advice that a policy corrects.
#[derive(Clone, Debug, PartialEq)]
pub enum CorrectedAdvice {
    /// A controller with its parameters.
    Controller(Controller),
    /// A trained network: its action without noise.
    Network(Box<Network>),
}

impl CorrectedAdvice {
    /// Checks that a policy with such actions, which withholds advice below `least_spacing_m` metres of road per vehicle, can correct
    /// this advice.
    ///
    /// # Errors
    /// A number is out of range, or the two do not fit together.
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

    /// Appends this advice to the text of a policy file.
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

/// Checks that a network needs only the traffic as input and advises a speed wherever its spacing bound permits.
pub(in crate::policy) fn stands_alone(network: &Network) -> Result<(), NotCorrectable> {
    if network.action != NetworkOutput::Speed {
        return Err(NotCorrectable::Acceleration);
    }
    if network.corrected.is_some() {
        return Err(NotCorrectable::CorrectsItself);
    }
    if network.estimator.is_some() || network.needs_driver_traits() {
        return Err(NotCorrectable::AsksWhoDrives);
    }
    if network.probe.is_some() {
        return Err(NotCorrectable::Probes);
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
    /// Reads by `kind`, so that a fault of one variant is not reported as a missing key of the other.
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

/// A running corrected advice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EngagedAdvice {
    /// A controller with its memory.
    Controller(EngagedController),
    /// A network, which has no memory.
    Network(Box<Network>),
}

impl EngagedAdvice {
    /// Returns a newly engaged advice that gets an observation every `step_s` seconds.
    pub fn new(advice: &CorrectedAdvice, step_s: f64) -> Self {
        match advice {
            CorrectedAdvice::Controller(controller) => Self::Controller(EngagedController::new(controller, step_s)),
            CorrectedAdvice::Network(network) => Self::Network(network.clone()),
        }
    }

    /// Returns true if the advice needs the driver as observed.
    pub fn observes_driver(&self) -> bool {
        matches!(self, Self::Network(network) if network.observes_driver())
    }

    /// Observes one step; networks have no memory and ignore it.
    pub fn watch(&mut self, observation: &Observation) {
        if let Self::Controller(controller) = self {
            controller.watch(observation);
        }
    }

    /// Returns the advised speed `time_s` seconds after engagement, m/s, 0 or more.
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
