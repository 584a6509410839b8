//! Fits the estimator of `policy::identification` to drivers whose traits are known. In: what was advised and done on the rings
//! of a block, and who drove. Out: a [`DriverEstimator`] for the policy's file.
//!
//! The student drives with his own estimates while he learns (Ross 2011), so that he meets what they lead to. The loss
//! is that of a normal distribution: a mean and a standard deviation for each trait (Nix 1994).

mod gru;
mod watcher;

pub use gru::{GruShape, GruStep};
pub use watcher::{BlockSample, Seconds, Watcher};

use super::{TrainConfig, adam::Adam, simd::LANES};
use crate::{
    policy::{
        DriverEstimator, NetworkLayer,
        identification::{DriverTraits, EstimatedTrait, GATES, INPUTS, LOG_SD, TRAITS},
    },
    rng,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Drivers that are drawn to see how far each trait spreads.
const DRAWN: usize = 4000;

/// The least spread of a trait, in its unit: where all drivers are alike, there is nothing to tell apart.
const LEAST_SPREAD: f64 = 0.05;

/// Passes over the seconds of a round.
const PASSES: usize = 2;

/// Blocks whose seconds make one step of Adam.
const BLOCKS_A_STEP: usize = 4;

/// An estimator in training.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EstimatorLearner {
    units: usize,
    traits: Vec<EstimatedTrait>,
    theta: Vec<f32>,
    adam: Adam,
}

impl EstimatorLearner {
    /// Nothing is known yet but how the traits of the configuration's drivers spread.
    pub fn new(config: &TrainConfig) -> Self {
        let units = config.student.estimator_units as usize;
        let mut stream = rng::stream(config.seed, "train/estimator");
        let theta: Vec<f32> = shape(units).first(&mut stream);
        Self { units, traits: traits(config), adam: Adam::new(theta.len()), theta }
    }

    /// The shape of its unit.
    pub fn shape(&self) -> GruShape {
        shape(self.units)
    }

    /// Its parameters.
    pub fn theta(&self) -> &[f32] {
        &self.theta
    }

    /// Learns from the seconds of all blocks by steps of `rate`. Returns the mean loss of a trait and second before the last
    /// pass's steps, nats.
    pub fn fit(&mut self, blocks: &[Seconds], rate: f64) -> f64 {
        let shape = self.shape();
        let mut loss = (0.0, 0.0);
        for _ in 0..PASSES {
            loss = (0.0, 0.0);
            for blocks in blocks.chunks(BLOCKS_A_STEP) {
                let of_block = |block: &Seconds| self.of_block(shape, block);
                let parts: Vec<(f64, f64, Vec<f32>)> = blocks.par_iter().map(of_block).collect();
                let numbers: f64 = parts.iter().map(|(_, numbers, _)| numbers).sum();
                loss = parts.iter().fold(loss, |(sum, n), (loss, numbers, _)| (sum + loss, n + numbers));
                let gradients = parts.iter().map(|(_, _, gradient)| gradient.as_slice());
                self.adam.step(&mut self.theta, gradients, 1.0 / numbers.max(1.0), rate);
            }
        }
        loss.0 / f64::max(loss.1, 1.0)
    }

    /// Loss, numbers that it is the sum over, and gradient of one block.
    fn of_block(&self, shape: GruShape, block: &Seconds) -> (f64, f64, Vec<f32>) {
        let mut steps: Vec<GruStep<f32>> = Vec::with_capacity(block.inputs.len());
        let mut by_read = Vec::with_capacity(block.inputs.len());
        let mut loss = 0.0;
        let mut state = block.state.clone();
        for ((inputs, begins), truths) in block.inputs.iter().zip(&block.begins).zip(&block.truths) {
            for (l, begins) in begins.iter().enumerate() {
                if *begins {
                    state[l * self.units..][..self.units].fill(0.0);
                }
            }
            let step = shape.step(&self.theta, inputs, &state);
            state.clone_from(&step.state);
            let mut by = vec![0.0; step.read.len()];
            for ((read, by), truth) in
                step.read.chunks_exact(2 * TRAITS).zip(by.chunks_exact_mut(2 * TRAITS)).zip(truths)
            {
                for (k, truth) in truth.numbers().into_iter().enumerate() {
                    let scaled = ((truth - self.traits[k].centre) / self.traits[k].spread) as f32;
                    let log_sd = read[TRAITS + k].clamp(LOG_SD[0], LOG_SD[1]);
                    let precision = (-2.0 * log_sd).exp();
                    let off = read[k] - scaled;
                    loss += f64::from(0.5 * off * off * precision + log_sd);
                    by[k] = off * precision;
                    let push = 1.0 - off * off * precision;
                    // Beyond its bounds only the way back has a derivative.
                    let is_held =
                        (read[TRAITS + k] > LOG_SD[1] && push < 0.0) || (read[TRAITS + k] < LOG_SD[0] && push > 0.0);
                    by[TRAITS + k] = if is_held { 0.0 } else { push };
                }
            }
            by_read.push(by);
            steps.push(step);
        }
        let numbers = (block.inputs.len() * LANES * TRAITS) as f64;
        let begins: Vec<Vec<bool>> = block.begins.iter().map(|begins| begins.to_vec()).collect();
        (loss, numbers, shape.gradient(&self.theta, &steps, &by_read, &begins))
    }

    /// The estimator as it stands.
    pub fn estimator(&self) -> DriverEstimator {
        let [weights, bias, state_weights, state_bias, readout, readout_bias] = self.shape().parts(&self.theta);
        let rows = |numbers: &[f32], columns: usize| numbers.chunks_exact(columns).map(<[f32]>::to_vec).collect();
        let gates = GATES * self.units;
        DriverEstimator {
            traits: self.traits.clone(),
            bias: bias.to_vec(),
            state_bias: state_bias.to_vec(),
            weights: rows(weights, gates),
            state_weights: rows(state_weights, gates),
            readout: NetworkLayer { bias: readout_bias.to_vec(), weights: rows(readout, 2 * TRAITS) },
        }
    }
}

fn shape(units: usize) -> GruShape {
    GruShape { inputs: INPUTS, units, outputs: 2 * TRAITS }
}

/// Centre and spread of each trait among the drivers of a configuration.
fn traits(config: &TrainConfig) -> Vec<EstimatedTrait> {
    let mut stream = rng::stream(config.seed, "train/estimator/drivers");
    let drawn: Vec<[f64; TRAITS]> =
        (0..DRAWN).map(|_| config.draw_driver(&mut stream).traits(config.ring.idm.t).numbers()).collect();
    let of = |k: usize| {
        let n = drawn.len() as f64;
        let centre = drawn.iter().map(|x| x[k]).sum::<f64>() / n;
        let spread = (drawn.iter().map(|x| (x[k] - centre).powi(2)).sum::<f64>() / n).sqrt();
        EstimatedTrait { name: DriverTraits::NAMES[k].into(), centre, spread: spread.max(LEAST_SPREAD) }
    };
    (0..TRAITS).map(of).collect()
}

#[cfg(test)]
mod tests;
