//! Training of the estimator of `policy::identification`. In: advice and behaviour on the rings of a block, and the drivers' traits. Out:
//! a [`DriverEstimator`] for the policy's file, of traits or of latents.
//!
//! During training the policy drives with the student's own estimates (Ross 2011), so that the student sees their consequences.

mod gru;
mod of_latents;
mod of_traits;
mod variational;
mod watcher;

pub use gru::{GruShape, GruStep};
pub use watcher::{BlockSample, Seconds, Watcher};

use super::{EstimatorKind, TrainConfig, scalar::SimdFloat};
use crate::policy::{
    DriverEstimator, NetworkLayer,
    identification::{EstimatedTrait, GATES, LOG_SD},
};
use of_latents::LatentLearner;
use of_traits::TraitLearner;
use serde::{Deserialize, Serialize};

/// Passes over the seconds of a round.
const PASSES: usize = 2;

/// Blocks whose seconds make one step of Adam.
const BLOCKS_A_STEP: usize = 4;

/// An estimator in training.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum EstimatorLearner {
    /// Learns traits from drivers with known traits.
    Traits(TraitLearner),
    /// Learns latents without any traits.
    Latents(LatentLearner),
}

impl EstimatorLearner {
    /// Returns an untrained estimator.
    pub fn new(config: &TrainConfig) -> Self {
        match config.student.estimator {
            EstimatorKind::Traits => Self::Traits(TraitLearner::new(config)),
            EstimatorKind::Variational => Self::Latents(LatentLearner::new(config)),
        }
    }

    /// Returns the shape of the recurrent unit.
    pub fn shape(&self) -> GruShape {
        match self {
            Self::Traits(learner) => learner.shape(),
            Self::Latents(learner) => learner.shape(),
        }
    }

    /// Returns the parameters of the recurrent unit.
    pub fn theta(&self) -> &[f32] {
        match self {
            Self::Traits(learner) => learner.theta(),
            Self::Latents(learner) => learner.theta(),
        }
    }

    /// Fits to the seconds of all blocks with learning rate `rate`. Returns the mean loss during the last pass, each block before its
    /// step, nat: per trait and second, or per second.
    pub fn fit(&mut self, blocks: &[Seconds], rate: f64) -> f64 {
        match self {
            Self::Traits(learner) => learner.fit(blocks, rate),
            Self::Latents(learner) => learner.fit(blocks, rate),
        }
    }

    /// Returns the current estimator.
    pub fn estimator(&self) -> DriverEstimator {
        match self {
            Self::Traits(learner) => learner.estimator(),
            Self::Latents(learner) => learner.estimator(),
        }
    }
}

/// Runs a unit over consecutive seconds of sixteen rings, starting from `state`.
fn forward<T: SimdFloat>(
    shape: GruShape,
    theta: &[T],
    state: &[T],
    inputs: &[Vec<T>],
    begins: &[Vec<bool>],
) -> Vec<GruStep<T>> {
    let mut steps: Vec<GruStep<T>> = Vec::with_capacity(inputs.len());
    let mut state = state.to_vec();
    for (inputs, begins) in inputs.iter().zip(begins) {
        for (l, begins) in begins.iter().enumerate() {
            if *begins {
                state[l * shape.units..][..shape.units].fill(T::default());
            }
        }
        let step = shape.step(theta, inputs, &state);
        state.clone_from(&step.state);
        steps.push(step);
    }
    steps
}

/// Returns the estimator with a unit's parameters, in the format of a policy's file.
fn estimator(shape: GruShape, theta: &[f32], traits: &[EstimatedTrait]) -> DriverEstimator {
    let [weights, bias, state_weights, state_bias, readout, readout_bias] = shape.parts(theta);
    let rows = |numbers: &[f32], columns: usize| numbers.chunks_exact(columns).map(<[f32]>::to_vec).collect();
    let gates = GATES * shape.units;
    DriverEstimator {
        traits: traits.to_vec(),
        bias: bias.to_vec(),
        state_bias: state_bias.to_vec(),
        weights: rows(weights, gates),
        state_weights: rows(state_weights, gates),
        readout: NetworkLayer { bias: readout_bias.to_vec(), weights: rows(readout, shape.outputs) },
    }
}

/// Clamps a logarithm of a standard deviation to its bounds.
fn bounded<T: SimdFloat>(read: T) -> T {
    let [low, high] = LOG_SD.map(|bound| T::of(bound.into()));
    if read < low {
        low
    } else if read > high {
        high
    } else {
        read
    }
}

/// Returns the derivative by the unclamped value; beyond a bound only the direction back inside has one.
fn by_unbounded<T: SimdFloat>(read: T, by_bounded: T) -> T {
    let [low, high] = LOG_SD.map(|bound| T::of(bound.into()));
    let zero = T::default();
    let is_held = (read > high && by_bounded < zero) || (read < low && by_bounded > zero);
    if is_held { zero } else { by_bounded }
}

/// Returns the negative log likelihood of `truth` under a normal distribution, nat (without the constant), and its derivatives by the
/// mean and by the logarithm of the standard deviation.
fn surprise<T: SimdFloat>(mean: T, log_sd: T, truth: T) -> (T, [T; 2]) {
    let within = bounded(log_sd);
    let precision = (T::of(-2.0) * within).exp();
    let off = mean - truth;
    let nats = T::of(0.5) * off * off * precision + within;
    (nats, [off * precision, by_unbounded(log_sd, T::of(1.0) - off * off * precision)])
}

#[cfg(test)]
mod tests;
