//! Networks of any origin as policies, in ONNX. In: a `.onnx` file, and what its numbers mean: a [`NetworkDescription`] in its
//! metadata or in a TOML file beside it (`policy.onnx.toml` beside `policy.onnx`). Out: a [`Policy`](super::Policy), or a
//! message that says what does not fit, before the drive. Run by tract; written by [`write()`], and by
//! [`write_estimator()`] what tells it who drives.

#[cfg(test)]
mod border_tests;
mod error;
mod external;
mod inputs;
pub mod limits;
mod load;
mod sizes;
mod wire;
mod write;
mod write_estimator;

pub use error::{AnswerFault, DescriptionFault, NodeFault, OnnxFault, PortFault, RunFault, RuntimeFault, TensorFault};
pub use load::OnnxPolicy;
pub use write::{describe, write};
pub use write_estimator::write_estimator;

use super::{CorrectedAdvice, ExpectedGain, NetworkInput, NetworkOutput, SettingFault, network_file::is_zero};
use crate::toml_text;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Key of the description in a file's metadata.
pub const METADATA_KEY: &str = "codrive";

/// What a network's output is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutputMeaning {
    /// One number: -1 and 1 are the limits; what lies beyond is drawn in.
    #[default]
    Scaled,
    /// One number: the action itself in m/s2 or m/s; what lies beyond the limits is drawn in.
    Si,
    /// A number for each level; the largest wins. Levels lie evenly between the limits, both included.
    Levels,
}

/// What the numbers of a network mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkDescription {
    /// What the action is.
    pub action: NetworkOutput,
    /// Lowest and highest action, m/s2 or m/s.
    pub limits: [f64; 2],
    /// Largest change of speed that an acceleration leads to in one hold, m/s; 0 sets no bound.
    #[serde(default)]
    pub speed_change_mps: f64,
    /// Road for each car, metres, below which the policy withholds advice; 0 is nowhere.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub least_spacing_m: f64,
    /// Shortest and longest hold that it was trained for, seconds.
    pub holds_s: [f64; 2],
    /// What the output is.
    #[serde(default)]
    pub output: OutputMeaning,
    /// Which number of the output, where it has more than the action needs (a mean before a deviation, say).
    #[serde(default)]
    pub element: Option<usize>,
    /// Name of the input tensor; may be left out where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_name: Option<String>,
    /// Inputs that are no observation, each with the number that it is at every decision.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fixed: BTreeMap<String, f64>,
    /// Name of the output tensor; may be left out where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_name: Option<String>,
    /// What the network sees, in order.
    pub inputs: Vec<NetworkInput>,
    /// What it corrects, where it does: its action is then what is added to that speed, m/s.
    #[serde(default, rename = "controller", skip_serializing_if = "Option::is_none")]
    pub corrected: Option<CorrectedAdvice>,
    /// What tells it where to be silent, where it has learned that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<ExpectedGain>,
}

/// A description as a person would write it, for messages.
const EXAMPLE: &str = r#"action = "acceleration"   # or "speed"
limits = [-0.5, 0.5]       # m/s2 or m/s
holds_s = [1.0, 1.0]       # shortest and longest hold, s
output = "scaled"          # -1..1 spans the limits; "si": the action itself; "levels": one number a level
inputs = [                 # `from` is seen as -1 and `to` as 1
  { feature = "speed", from = 0.0, to = 10.0 },
  { feature = "leader_speed", from = 0.0, to = 10.0 },
  { feature = "gap", from = 0.0, to = 300.0 },
  { feature = "circumference", from = 200.0, to = 300.0 },
]
# input_name = "obs"       # where it has several inputs; of the others each is a constant:
# fixed = { mask = 1.0 }"#;

impl NetworkDescription {
    /// Reads a description.
    ///
    /// # Errors
    /// It is not TOML, has other keys, or a number cannot be.
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
        d.corrected.as_ref().map_or(Ok(()), |advice| advice.check(d.action, d.least_spacing_m))?;
        match d.inputs.iter().find(|input| !input.is_sound()) {
            Some(input) => Err(SettingFault::Input(input.feature).into()),
            None if d.inputs.is_empty() => Err(DescriptionFault::NoInputs),
            None => Ok(d),
        }
    }
}
