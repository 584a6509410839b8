//! What advice is expected to gain, so that a policy can be silent where it would slow the traffic. In: an [`Observation`].
//! Out: the mean speed of all cars with this policy's advice less that without any, m/s, as it was learned from drives in pairs
//! (`train::silence`). It sees the road, the hold and the driver, not the speeds of the moment.

use super::{
    NetworkInput, NetworkLayer, Observation, SettingFault,
    network::{LayerFault, check_layers, run_layers},
    network_file::row,
};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A fitted network, and the gain below which nothing is advised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectedGain {
    /// Expected gain below which nothing is advised, m/s.
    pub silent_below_mps: f64,
    /// What the first layer sees, in order.
    pub inputs: Vec<NetworkInput>,
    /// From the observation to the gain, m/s.
    #[serde(rename = "layer")]
    pub layers: Vec<NetworkLayer>,
}

/// Why these numbers tell no gain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpectedGainFault {
    /// Its layers do not fit together.
    #[error("expected_gain: {0}")]
    Layers(#[from] LayerFault),
    /// A bound that is no number, or an input without a range.
    #[error("expected_gain: {0}")]
    Setting(#[from] SettingFault),
}

impl ExpectedGain {
    /// Fails where its numbers cannot be used.
    pub(super) fn check(&self) -> Result<(), ExpectedGainFault> {
        if !self.silent_below_mps.is_finite() {
            return Err(SettingFault::SilentBelow.into());
        }
        if let Some(input) = self.inputs.iter().find(|input| !input.is_sound()) {
            return Err(SettingFault::Input(input.feature).into());
        }
        Ok(check_layers(&self.layers, self.inputs.len(), 1)?)
    }

    /// The gain that is expected, m/s.
    pub fn gain_mps(&self, observation: &Observation) -> f64 {
        let seen = self.inputs.iter().map(|input| input.scaled(observation));
        run_layers(&self.layers, seen, |outputs| f64::from(outputs[0]))
    }

    /// True where nothing is to be advised.
    pub fn asks_for_silence(&self, observation: &Observation) -> bool {
        self.gain_mps(observation) < self.silent_below_mps
    }

    /// Appends it to a policy's file.
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
