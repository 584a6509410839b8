//! Expected gain of advice, used by a policy to withhold advice that would slow the traffic. In: an [`Observation`]. Out: the mean speed
//! of all vehicles with this policy's advice minus that without advice, m/s, learned from paired drives (`train::silence`). Inputs are
//! the road, the hold and the driver, not the current speeds.

use super::{ExpectedGainFault, SettingFault};
use crate::policy::{
    NetworkInput, NetworkLayer, Observation,
    file_text::row,
    layers::{check_layers, run_layers},
};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A fitted network, and the gain below which advice is withheld.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectedGain {
    /// Expected gain below which advice is withheld, m/s.
    pub silent_below_mps: f64,
    /// Inputs of the first layer, in order.
    pub inputs: Vec<NetworkInput>,
    /// Layers from the inputs to the gain, m/s.
    #[serde(rename = "layer")]
    pub layers: Vec<NetworkLayer>,
}

impl ExpectedGain {
    /// Checks that the numbers can be used.
    pub(in crate::policy) fn check(&self) -> Result<(), ExpectedGainFault> {
        if !self.silent_below_mps.is_finite() {
            return Err(SettingFault::SilentBelow.into());
        }
        if let Some(input) = self.inputs.iter().find(|input| !input.is_sound()) {
            return Err(SettingFault::Input(input.feature).into());
        }
        Ok(check_layers(&self.layers, self.inputs.len(), 1)?)
    }

    /// Returns the expected gain, m/s.
    pub fn gain_mps(&self, observation: &Observation) -> f64 {
        let seen = self.inputs.iter().map(|input| input.scaled(observation));
        run_layers(&self.layers, seen, |outputs| f64::from(outputs[0]))
    }

    /// Returns true if advice should be withheld.
    pub fn asks_for_silence(&self, observation: &Observation) -> bool {
        self.gain_mps(observation) < self.silent_below_mps
    }

    /// Appends the predictor to the text of a policy file.
    pub(super) fn write(&self, text: &mut String) {
        let _ = write!(
            text,
            "\n# What advice is expected to gain, m/s; below this nothing is advised.\n[expected_gain]\nsilent_below_mps = {:?}\ninputs = [\n",
            self.silent_below_mps
        );
        for NetworkInput { feature, from, to } in &self.inputs {
            let _ = writeln!(text, "  {{ feature = \"{}\", from = {from:?}, to = {to:?} }},", feature.name());
        }
        text.push_str("]\n");
        for layer in &self.layers {
            let _ = writeln!(text, "\n[[expected_gain.layer]]\nbias = {}\nweights = [", row(&layer.bias));
            layer.weights.iter().for_each(|weights| {
                let _ = writeln!(text, "  {},", row(weights));
            });
            text.push_str("]\n");
        }
    }
}
