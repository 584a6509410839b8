//! Text of a trained network's file. In: a [`Network`]. Out: TOML whose numbers are as short as possible and still read back to the same
//! bits.

use super::Network;
use crate::policy::{NetworkInput, file_text::row};
use std::fmt::Write;

impl Network {
    /// Returns the text of the policy file.
    pub fn to_toml(&self) -> String {
        let mut text = String::from("# A policy trained by codrive; `codrive drive --policy THIS_FILE` uses it.\n");
        text.push_str("# Each layer is y = x W + b, then tanh on all but the last. Output -1..1 spans the limits.\n");
        self.write_alone(&mut text, "");
        if let Some(corrected) = &self.corrected {
            corrected.write(&mut text);
        }
        if let Some(probe) = &self.probe {
            probe.write(&mut text);
        }
        if let Some(estimator) = &self.estimator {
            estimator.write(&mut text);
        }
        if let Some(expected_gain) = &self.expected_gain {
            expected_gain.write(&mut text);
        }
        text
    }

    /// Appends the network without its corrected advice, probe, estimator and expected gain. `path` is the enclosing table with a trailing dot,
    /// or empty.
    pub(super) fn write_alone(&self, text: &mut String, path: &str) {
        let head = Self {
            layers: Vec::new(),
            corrected: None,
            probe: None,
            estimator: None,
            expected_gain: None,
            ..self.clone()
        };
        let mut table = toml::Table::try_from(head).unwrap_or_default();
        table.remove("layer");
        table.remove("inputs");
        text.push_str(&toml::to_string(&table).unwrap_or_default());
        text.push_str("# `from` is seen as -1 and `to` as 1.\ninputs = [\n");
        for NetworkInput { feature, from, to } in &self.inputs {
            let _ = writeln!(text, "  {{ feature = \"{}\", from = {from:?}, to = {to:?} }},", feature.name());
        }
        text.push_str("]\n");
        for layer in &self.layers {
            let _ = writeln!(text, "\n[[{path}layer]]\nbias = {}\nweights = [", row(&layer.bias));
            for weights in &layer.weights {
                let _ = writeln!(text, "  {},", row(weights));
            }
            text.push_str("]\n");
        }
    }
}
