//! Meaning of an ONNX network's numbers. In: TOML text. Out: a [`NetworkDescription`], or the fault.

use super::DescriptionFault;
use crate::{
    policy::{CorrectedAdvice, ExpectedGain, NetworkInput, NetworkOutput, Probe, SettingFault, file_text::is_zero},
    toml_text,
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
    /// The text is not TOML, has unknown keys, or a number is out of range.
    pub fn from_toml(text: &str) -> Result<Self, DescriptionFault> {
        let d: Self = toml_text::parse(text, "its description").map_err(DescriptionFault::Toml)?;
        let [low, high] = d.limits;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(SettingFault::Limits { low, high }.into());
        }
        let [shortest, longest] = d.holds_s;
        if !(shortest > 0.0 && shortest <= longest && longest.is_finite()) {
            return Err(DescriptionFault::Holds { shortest, longest });
        }
        if !(d.speed_change_mps.is_finite() && d.speed_change_mps >= 0.0) {
            return Err(SettingFault::SpeedChange.into());
        }
        if !(d.least_spacing_m.is_finite() && d.least_spacing_m >= 0.0) {
            return Err(SettingFault::LeastSpacing.into());
        }
        if let Some((name, value)) = d.fixed.iter().find(|(_, value)| !value.is_finite()) {
            return Err(DescriptionFault::Fixed { name: name.clone(), value: *value });
        }
        d.expected_gain.as_ref().map_or(Ok(()), ExpectedGain::check)?;
        d.probe.as_ref().map_or(Ok(()), |probe| probe.check(d.action))?;
        d.corrected.as_ref().map_or(Ok(()), |advice| advice.check(d.action, d.least_spacing_m))?;
        match d.inputs.iter().find(|input| !input.is_sound()) {
            Some(input) => Err(SettingFault::Input(input.feature).into()),
            None if d.inputs.is_empty() => Err(DescriptionFault::NoInputs),
            None => Ok(d),
        }
    }
}
