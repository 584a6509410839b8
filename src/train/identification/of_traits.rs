//! Fit of an estimator to drivers with known traits. In: advice and behaviour on the rings of a block, and the drivers' traits. Out:
//! means and standard deviations of the traits.
//!
//! The loss is the negative log likelihood of a normal distribution with a mean and a standard deviation per trait (Nix 1994).

use super::{
    fitting::{BLOCKS_A_STEP, PASSES, estimator, forward, surprise},
    gru::{GruShape, GruStep},
    seconds::Seconds,
};
use crate::{
    policy::{
        DriverEstimator,
        identification::{DriverTraits, EstimatedTrait, INPUTS, INPUTS_WITH_OBSERVED, TRAITS},
    },
    rng,
    train::{TrainConfig, adam::Adam, simd::LANES},
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Number of drivers drawn to measure the spread of each trait.
const DRAWN: usize = 4000;

/// Smallest spread of a trait, in its unit; keeps the scaling finite if all drivers are alike.
const LEAST_SPREAD: f64 = 0.05;

/// An estimator of traits in training.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TraitLearner {
    inputs: usize,
    units: usize,
    traits: Vec<EstimatedTrait>,
    theta: Vec<f32>,
    adam: Adam,
}

impl TraitLearner {
    /// Returns an untrained estimator, scaled by the spread of traits among the configuration's drivers.
    pub fn new(config: &TrainConfig) -> Self {
        let units = config.student.estimator_units as usize;
        let mut stream = rng::stream(config.seed, "train/estimator");
        let is_observed = config.inputs().iter().any(|input| input.feature.is_observed());
        let inputs = if is_observed { INPUTS_WITH_OBSERVED } else { INPUTS };
        let theta: Vec<f32> = GruShape { inputs, units, outputs: 2 * TRAITS }.first(&mut stream);
        Self { inputs, units, traits: traits(config), adam: Adam::new(theta.len()), theta }
    }

    /// Returns the shape of the recurrent unit.
    pub fn shape(&self) -> GruShape {
        GruShape { inputs: self.inputs, units: self.units, outputs: 2 * TRAITS }
    }

    /// Returns the parameters of the recurrent unit.
    pub fn theta(&self) -> &[f32] {
        &self.theta
    }

    /// Fits to the seconds of all blocks with learning rate `rate`. Returns the mean loss per trait and second during the last pass, each
    /// block before its step, nat.
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

    /// Returns the summed loss of one block, the number of its terms, and its gradient.
    fn of_block(&self, shape: GruShape, block: &Seconds) -> (f64, f64, Vec<f32>) {
        let mut by_read = Vec::with_capacity(block.inputs.len());
        let mut loss = 0.0;
        let steps: Vec<GruStep<f32>> = forward(shape, &self.theta, &block.state, &block.inputs, &block.begins);
        for (step, truths) in steps.iter().zip(&block.truths) {
            let mut by = vec![0.0; step.read.len()];
            for ((read, by), truth) in
                step.read.chunks_exact(2 * TRAITS).zip(by.chunks_exact_mut(2 * TRAITS)).zip(truths)
            {
                for (k, truth) in truth.numbers().into_iter().enumerate() {
                    let scaled = ((truth - self.traits[k].centre) / self.traits[k].spread) as f32;
                    let (nats, [by_mean, by_log_sd]) = surprise(read[k], read[TRAITS + k], scaled);
                    loss += f64::from(nats);
                    (by[k], by[TRAITS + k]) = (by_mean, by_log_sd);
                }
            }
            by_read.push(by);
        }
        let numbers = (block.inputs.len() * LANES * TRAITS) as f64;
        (loss, numbers, shape.gradient(&self.theta, &steps, &by_read, &block.begins))
    }

    /// Returns the current estimator.
    pub fn estimator(&self) -> DriverEstimator {
        estimator(self.shape(), &self.theta, &self.traits)
    }
}

/// Returns the mean and spread of each trait among the drivers of a configuration.
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
