//! Parameters of the estimator as stored in a policy's file, and its arithmetic. In: the samples of one second. Out: the state of the
//! recurrent unit and its readout.

use super::{
    DriverEstimate, DriverTraits, INPUTS, INPUTS_WITH_OBSERVED, LatentEstimate, MOST_LATENTS, WhoDrives, latent_name,
};
use crate::policy::{Feature, NetworkLayer, file_text::row};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Gates of the unit: reset, update, candidate; each weight matrix has this many columns per hidden unit.
pub const GATES: usize = 3;

/// Bounds on the logarithms of standard deviations, in fitting and in reading, in units of the trait's spread.
pub const LOG_SD: [f32; 2] = [-3.0, 1.0];

/// Scaling of one trait in the readout: the centre reads as 0, and centre plus spread as 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimatedTrait {
    /// Name of the trait or latent.
    pub name: String,
    /// Value that reads as 0, in the trait's unit.
    pub centre: f64,
    /// Change of the trait per unit of readout, in the trait's unit.
    pub spread: f64,
}

impl EstimatedTrait {
    /// Returns the readout scaling of latent `k`, counted from 0: centre 0, spread 1.
    pub fn latent(k: usize) -> Self {
        Self { name: latent_name(k), centre: 0.0, spread: 1.0 }
    }
}

/// A fitted driver estimator: a gated recurrent unit with a linear readout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverEstimator {
    /// Traits in the order of the readout, which holds first all means, then the logarithms of all standard deviations. All of
    /// [`DriverTraits::NAMES`], or up to [`MOST_LATENTS`] latents.
    pub traits: Vec<EstimatedTrait>,
    /// Input bias of each gate's units: reset, update, candidate.
    pub bias: Vec<f32>,
    /// State bias of each gate's units: reset, update, candidate.
    pub state_bias: Vec<f32>,
    /// Input weights, one row per input.
    pub weights: Vec<Vec<f32>>,
    /// State weights, one row per unit.
    pub state_weights: Vec<Vec<f32>>,
    /// Linear layer from the state to the readout.
    pub readout: NetworkLayer,
}

/// Reasons that an estimator cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EstimatorFault {
    /// The traits are other ones or in another order.
    #[error(
        "the estimator's traits are {found}; allowed: {}, or {} to at most {}",
        DriverTraits::NAMES.join(", "), latent_name(0), latent_name(MOST_LATENTS - 1)
    )]
    Traits {
        /// Names of the traits in the file.
        found: String,
    },
    /// A trait's spread is not positive and finite, or its centre is not finite.
    #[error("the estimator's trait {name} has no valid centre and spread")]
    Scale {
        /// Name of the trait.
        name: String,
    },
    /// A part has the wrong size.
    #[error("the estimator's {part} are {rows} x {columns} numbers; allowed: {needed_rows} x {needed_columns}")]
    Size {
        /// Name of the part.
        part: &'static str,
        /// Rows of the part.
        rows: usize,
        /// Columns of the part.
        columns: usize,
        /// Required number of rows.
        needed_rows: usize,
        /// Required number of columns.
        needed_columns: usize,
    },
    /// The policy has an input that this estimator does not estimate.
    #[error(
        "the policy sees {}, which its estimator does not estimate; it estimates {known}\n  remedy: train the policy \
         with an estimator of the other kind", feature.name()
    )]
    NotTold {
        /// Input of the policy.
        feature: Feature,
        /// Names of the estimated traits or latents.
        known: String,
    },
    /// A number is infinite or NaN.
    #[error("the estimator's {part} hold a number that is not finite")]
    NotFinite {
        /// Name of the part.
        part: &'static str,
    },
}

/// State of the unit, with buffers for the next step.
#[derive(Clone, Debug, PartialEq)]
pub struct Recurrent {
    state: Vec<f32>,
    from_input: Vec<f32>,
    from_state: Vec<f32>,
}

impl Recurrent {
    /// Returns the state, one number per unit, each -1 to 1.
    pub fn state(&self) -> &[f32] {
        &self.state
    }
}

impl DriverEstimator {
    /// Returns the number of units.
    pub fn units(&self) -> usize {
        self.state_weights.len()
    }

    /// Returns the number of inputs: [`INPUTS`], or [`INPUTS_WITH_OBSERVED`].
    pub fn inputs(&self) -> usize {
        if self.observes_driver() { INPUTS_WITH_OBSERVED } else { INPUTS }
    }

    /// Returns true if the inputs include the observed reaction time and time gap.
    pub fn observes_driver(&self) -> bool {
        self.weights.len() == INPUTS_WITH_OBSERVED
    }

    /// Returns the length of the readout: a mean and a logarithm of a standard deviation per trait or latent.
    pub fn outputs(&self) -> usize {
        2 * self.traits.len()
    }

    /// Returns true if the estimator estimates latents, in order from the first, instead of traits.
    pub fn is_of_latents(&self) -> bool {
        let is_named = |(k, of): (usize, &EstimatedTrait)| of.name == latent_name(k);
        (1..=MOST_LATENTS).contains(&self.traits.len()) && self.traits.iter().enumerate().all(is_named)
    }

    /// Checks that the estimator estimates every driver input among `features`; a missing one would read as 0.
    pub(in crate::policy) fn check_tells(
        &self,
        mut features: impl Iterator<Item = Feature>,
    ) -> Result<(), EstimatorFault> {
        let is_told = |feature: Feature| match feature.is_latent() {
            true => self.traits.iter().any(|of| of.name == feature.name()),
            false => !self.is_of_latents(),
        };
        let Some(feature) = features.find(|feature| feature.is_of_driver() && !is_told(*feature)) else {
            return Ok(());
        };
        let known = self.traits.iter().map(|of| of.name.as_str()).collect::<Vec<_>>().join(", ");
        Err(EstimatorFault::NotTold { feature, known })
    }

    /// Checks that the parts fit together.
    ///
    /// # Errors
    /// Names the first part that does not fit.
    pub fn check(&self) -> Result<(), EstimatorFault> {
        let names: Vec<&str> = self.traits.iter().map(|t| t.name.as_str()).collect();
        if names != DriverTraits::NAMES && !self.is_of_latents() {
            return Err(EstimatorFault::Traits { found: names.join(", ") });
        }
        if let Some(t) = self.traits.iter().find(|t| !(t.centre.is_finite() && t.spread > 0.0 && t.spread.is_finite()))
        {
            return Err(EstimatorFault::Scale { name: t.name.clone() });
        }
        let units = self.units();
        let biases = |bias: &Vec<f32>| vec![bias.clone()];
        for (part, rows, needed_rows, needed_columns) in [
            ("bias", biases(&self.bias), 1, GATES * units),
            ("state_bias", biases(&self.state_bias), 1, GATES * units),
            ("weights", self.weights.clone(), self.inputs(), GATES * units),
            ("state_weights", self.state_weights.clone(), units.max(1), GATES * units),
            ("readout.bias", biases(&self.readout.bias), 1, self.outputs()),
            ("readout.weights", self.readout.weights.clone(), units, self.outputs()),
        ] {
            let odd = rows.iter().find(|row| row.len() != needed_columns);
            if rows.len() != needed_rows || odd.is_some() {
                let columns = odd.map_or(needed_columns, Vec::len);
                return Err(EstimatorFault::Size { part, rows: rows.len(), columns, needed_rows, needed_columns });
            }
            if rows.iter().flatten().any(|x| !x.is_finite()) {
                return Err(EstimatorFault::NotFinite { part });
            }
        }
        Ok(())
    }

    /// Returns the state before the first input.
    pub fn begin(&self) -> Recurrent {
        let gates = GATES * self.units();
        Recurrent { state: vec![0.0; self.units()], from_input: vec![0.0; gates], from_state: vec![0.0; gates] }
    }

    /// Updates the state with one second of input: [`Self::inputs`] numbers.
    pub fn step(&self, inputs: &[f32], unit: &mut Recurrent) {
        let n = self.units();
        let Recurrent { state, from_input, from_state, .. } = unit;
        affine(inputs, &self.weights, &self.bias, from_input);
        affine(state, &self.state_weights, &self.state_bias, from_state);
        for k in 0..n {
            let reset = sigmoid(from_input[k] + from_state[k]);
            let update = sigmoid(from_input[n + k] + from_state[n + k]);
            let candidate = (from_input[2 * n + k] + reset * from_state[2 * n + k]).tanh();
            state[k] = (1.0 - update) * candidate + update * state[k];
        }
    }

    /// Returns the readout of a state.
    pub fn read(&self, state: &[f32]) -> Vec<f32> {
        let mut read = vec![0.0; self.outputs()];
        self.read_into(state, &mut read);
        read
    }

    /// Writes the readout of a state into `read`, which holds [`Self::outputs`] numbers.
    pub fn read_into(&self, state: &[f32], read: &mut [f32]) {
        affine(state, &self.readout.weights, &self.readout.bias, read);
    }

    /// Converts a readout into an estimate of the driver.
    pub fn of_readout(&self, read: &[f32]) -> WhoDrives {
        let count = self.traits.len();
        let mean = |k: usize| self.traits[k].centre + self.traits[k].spread * f64::from(read[k]);
        let sd = |k: usize| self.traits[k].spread * f64::from(read[count + k].clamp(LOG_SD[0], LOG_SD[1]).exp());
        if self.is_of_latents() {
            let of_each = |of: &dyn Fn(usize) -> f64| std::array::from_fn(|k| if k < count { of(k) } else { 0.0 });
            return WhoDrives::Latents(LatentEstimate { count, mean: of_each(&mean), sd: of_each(&sd) });
        }
        WhoDrives::Traits(DriverEstimate {
            mean: DriverTraits::of(std::array::from_fn(mean)).possible(),
            sd: DriverTraits::of(std::array::from_fn(sd)),
        })
    }
}

impl DriverEstimator {
    /// Appends the estimator to the text of a policy file.
    pub(in crate::policy) fn write(&self, text: &mut String) {
        text.push_str(
            "\n# Who drives: a gated recurrent unit over the last seconds, read out as means and uncertainties.\n",
        );
        let _ = writeln!(text, "[estimator]\nbias = {}", row(&self.bias));
        let _ = writeln!(text, "state_bias = {}\ntraits = [", row(&self.state_bias));
        for EstimatedTrait { name, centre, spread } in &self.traits {
            let _ = writeln!(text, "  {{ name = \"{name}\", centre = {centre:?}, spread = {spread:?} }},");
        }
        text.push_str("]\n");
        matrix("weights", &self.weights, text);
        matrix("state_weights", &self.state_weights, text);
        let _ = writeln!(text, "\n[estimator.readout]\nbias = {}", row(&self.readout.bias));
        matrix("weights", &self.readout.weights, text);
    }
}

/// Appends a matrix under its key, one line per row.
fn matrix(key: &str, rows: &[Vec<f32>], text: &mut String) {
    let _ = writeln!(text, "{key} = [");
    for numbers in rows {
        let _ = writeln!(text, "  {},", row(numbers));
    }
    text.push_str("]\n");
}

/// Computes `out = bias + x weights`.
fn affine(x: &[f32], weights: &[Vec<f32>], bias: &[f32], out: &mut [f32]) {
    out.copy_from_slice(bias);
    for (x, row) in x.iter().zip(weights) {
        for (out, weight) in out.iter_mut().zip(row) {
            *out += x * weight;
        }
    }
}

fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}
