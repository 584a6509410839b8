//! Meaning of an ONNX network's numbers. In: TOML text. Out: a [`NetworkDescription`], or the fault.

use super::DescriptionFault;
use crate::{
    policy::{
        CorrectedAdvice, ExpectedGain, NetworkInput, NetworkOutput, Probe, file_text::is_zero, network::setting_faults,
    },
    toml_text::{self, KeyPart},
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Key of the description in a file's metadata.
pub const METADATA_KEY: &str = "codrive";

/// Meaning of a network's output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutputMeaning {
    /// One number: -1 and 1 map to the limits, and values beyond are clamped.
    #[default]
    Scaled,
    /// One number: the action itself, m/s² or m/s, clamped to the limits.
    Si,
    /// One number per level; the largest wins. Levels are evenly spaced between the limits, both included.
    Levels,
}

/// Meaning of a network's inputs and outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkDescription {
    /// Quantity that the network advises.
    pub action: NetworkOutput,
    /// Lowest and highest action, m/s² or m/s.
    pub limits: [f64; 2],
    /// Largest change of speed caused by an acceleration within one hold, m/s; 0: no bound.
    #[serde(default)]
    pub speed_change_mps: f64,
    /// Road per vehicle, m, below which the policy withholds advice; 0: never.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub least_spacing_m: f64,
    /// Shortest and longest hold in training, s.
    pub holds_s: [f64; 2],
    /// Largest share of advised vehicles in training, 0 to 1; 0: one vehicle.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub advised_share: f64,
    /// Meaning of the output.
    #[serde(default)]
    pub output: OutputMeaning,
    /// Index of the output used as action, if there are several (a mean before a deviation, for example).
    #[serde(default)]
    pub element: Option<usize>,
    /// Name of the input tensor; optional if there is only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_name: Option<String>,
    /// Constant values of inputs that are not part of the observation, by input name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fixed: BTreeMap<String, f64>,
    /// Numbers of states at the first decision of a drive, by the name of their input; other states begin with zeros.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub initial_state: BTreeMap<String, Vec<f32>>,
    /// Name of the output tensor; optional if there is only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_name: Option<String>,
    /// Inputs of the network, in order.
    pub inputs: Vec<NetworkInput>,
    /// Advice that the network corrects, if any; the action is then added to that speed, m/s.
    #[serde(default, rename = "controller", skip_serializing_if = "Option::is_none")]
    pub corrected: Option<CorrectedAdvice>,
    /// Probe of the driver, if the policy probes them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe: Option<Probe>,
    /// Predictor of the gain from advice, used to withhold advice, if trained.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<ExpectedGain>,
}

impl NetworkDescription {
    /// Parses a description.
    ///
    /// # Errors
    /// The text is not TOML, has unknown keys, or a number is out of range. The message has all mistakes.
    pub fn from_toml(text: &str) -> Result<Self, DescriptionFault> {
        let (description, mut mistakes) = toml_text::read::<Self>(text, "its description");
        for (key, others, fault) in description.iter().flat_map(Self::faults) {
            mistakes.add_related(&key, others, KeyPart::Value, &fault);
        }
        toml_text::finished((description, mistakes)).map_err(DescriptionFault)
    }

    /// Returns the values that are not allowed, each with its key, the keys because of which it is not, and a message.
    fn faults(&self) -> Vec<(String, &'static [&'static str], String)> {
        let mut faults = Vec::new();
        let mut add = |key: &str, others: &'static [&'static str], message: Option<String>| {
            faults.extend(message.map(|message| (key.to_owned(), others, message)));
        };
        let settings = setting_faults(self.limits, self.speed_change_mps, self.least_spacing_m, &self.inputs);
        settings.into_iter().for_each(|(key, fault)| add(&key, &[], Some(fault.to_string())));
        let [shortest, longest] = self.holds_s;
        let is_sound = shortest > 0.0 && shortest <= longest && longest.is_finite();
        let allowed = "allowed: numbers above 0, the first not above the second";
        add("holds_s", &[], (!is_sound).then(|| format!("holds_s are {shortest} to {longest}; {allowed}")));
        for (name, value) in self.fixed.iter().filter(|(_, value)| !value.is_finite()) {
            let message = format!("input `{name}` is fixed to {value}; allowed: a finite number");
            add(&format!("fixed.{name}"), &[], Some(message));
        }
        let gain = self.expected_gain.as_ref().and_then(|gain| gain.check().err());
        add("expected_gain", &[], gain.map(|fault| fault.to_string()));
        let probe = self.probe.as_ref().and_then(|probe| probe.check(self.action).err());
        add("probe", &["action"], probe.map(|fault| fault.to_string()));
        let corrected =
            self.corrected.as_ref().and_then(|advice| advice.check(self.action, self.least_spacing_m).err());
        add("controller", &["action", "least_spacing_m"], corrected.map(|fault| fault.to_string()));
        add("inputs", &[], self.inputs.is_empty().then(|| "inputs are empty; allowed: at least one input".into()));
        faults
    }
}
