//! Fit of a variational encoder to drivers with unknown traits. In: advice and behaviour on the rings of a block. Out: an estimator of
//! latents; its decoder is used only here.

use super::{
    fitting::{BLOCKS_A_STEP, PASSES, estimator},
    gru::GruShape,
    seconds::Seconds,
    variational::{SecondsWindow, VariationalLoss, VariationalShape},
};
use crate::{
    policy::{DriverEstimator, identification::EstimatedTrait},
    rng,
    train::{TrainConfig, adam::Adam, simd::LANES},
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A variational encoder in training.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LatentLearner {
    seed: u64,
    units: usize,
    latents: usize,
    kl_weight: f64,
    /// Passes over seconds so far; each pass has its own random numbers.
    passes: u64,
    /// Parameters of the encoder, then of the decoder.
    theta: Vec<f32>,
    adam: Adam,
}

impl LatentLearner {
    /// Returns an untrained encoder and decoder.
    pub fn new(config: &TrainConfig) -> Self {
        let (units, latents) = (config.student.estimator_units as usize, config.student.latents as usize);
        let shape = VariationalShape::new(units, latents);
        let theta: Vec<f32> = shape.first(&mut rng::stream(config.seed, "train/latents"));
        let kl_weight = config.student.kl_weight;
        Self { seed: config.seed, units, latents, kl_weight, passes: 0, adam: Adam::new(theta.len()), theta }
    }

    fn variational(&self) -> VariationalShape {
        VariationalShape::new(self.units, self.latents)
    }

    /// Returns the shape of the encoder's recurrent unit.
    pub fn shape(&self) -> GruShape {
        self.variational().encoder()
    }

    /// Returns the parameters of the encoder.
    pub fn theta(&self) -> &[f32] {
        &self.theta[..self.shape().parameters()]
    }

    /// Fits to the seconds of all blocks with learning rate `rate`. Returns the mean loss per second during the last pass, each block
    /// before its step, nat.
    pub fn fit(&mut self, blocks: &[Seconds], rate: f64) -> f64 {
        let shape = self.variational();
        let mut loss = (0.0, 0.0);
        for _ in 0..PASSES {
            loss = (0.0, 0.0);
            for (k, blocks) in blocks.chunks(BLOCKS_A_STEP).enumerate() {
                let of_block = |(i, block)| self.of_block(&shape, k * BLOCKS_A_STEP + i, block);
                let parts: Vec<VariationalLoss<f32>> = blocks.par_iter().enumerate().map(of_block).collect();
                let seconds: f64 = parts.iter().map(|part| part.seconds).sum();
                loss = parts.iter().fold(loss, |(sum, n), part| (sum + part.nats, n + part.seconds));
                let gradients = parts.iter().map(|part| part.gradient.as_slice());
                self.adam.step(&mut self.theta, gradients, 1.0 / seconds.max(1.0), rate);
            }
            self.passes += 1;
        }
        loss.0 / f64::max(loss.1, 1.0)
    }

    /// Returns the loss and gradient of one block, with the random numbers of this pass.
    fn of_block(&self, shape: &VariationalShape, index: usize, block: &Seconds) -> VariationalLoss<f32> {
        let mut stream = rng::stream(self.seed, &format!("train/latents/{}/{index}", self.passes));
        let noise: Vec<f32> = (0..shape.noise(block.inputs.len(), LANES)).map(|_| stream.normal() as f32).collect();
        let window = SecondsWindow { state: &block.state, inputs: &block.inputs, begins: &block.begins };
        shape.loss(&self.theta, &window, &noise, self.kl_weight)
    }

    /// Returns the current estimator: the encoder.
    pub fn estimator(&self) -> DriverEstimator {
        let latents: Vec<EstimatedTrait> = (0..self.latents).map(EstimatedTrait::latent).collect();
        estimator(self.shape(), self.theta(), &latents)
    }
}
