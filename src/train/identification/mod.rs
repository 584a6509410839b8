//! Fits the estimator of `policy::identification`. In: what was advised and done on the rings of a block, and who drove. Out: a
//! [`DriverEstimator`] for the policy's file, of traits or of latents.
//!
//! The student drives with his own estimates while he learns (Ross 2011), so that he meets what they lead to.

mod gru;
mod of_latents;
mod of_traits;
mod variational;
mod watcher;

pub use gru::{GruShape, GruStep};
pub use watcher::{BlockSample, Seconds, Watcher};

use super::{EstimatorKind, TrainConfig, scalar::Real};
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
    /// Told who drives, it learns to tell traits.
    Traits(TraitLearner),
    /// Told nothing, it finds latents.
    Latents(LatentLearner),
}

impl EstimatorLearner {
    /// Nothing is known yet.
    pub fn new(config: &TrainConfig) -> Self {
        match config.student.estimator {
            EstimatorKind::Traits => Self::Traits(TraitLearner::new(config)),
            EstimatorKind::Variational => Self::Latents(LatentLearner::new(config)),
        }
    }

    /// The shape of its unit.
    pub fn shape(&self) -> GruShape {
        match self {
            Self::Traits(learner) => learner.shape(),
            Self::Latents(learner) => learner.shape(),
        }
    }

    /// The unit's parameters.
    pub fn theta(&self) -> &[f32] {
        match self {
            Self::Traits(learner) => learner.theta(),
            Self::Latents(learner) => learner.theta(),
        }
    }

    /// Learns from the seconds of all blocks by steps of `rate`. Returns the mean loss before the last pass's steps, nats: of a
    /// trait and second, or of a second.
    pub fn fit(&mut self, blocks: &[Seconds], rate: f64) -> f64 {
        match self {
            Self::Traits(learner) => learner.fit(blocks, rate),
            Self::Latents(learner) => learner.fit(blocks, rate),
        }
    }

    /// The estimator as it stands.
    pub fn estimator(&self) -> DriverEstimator {
        match self {
            Self::Traits(learner) => learner.estimator(),
            Self::Latents(learner) => learner.estimator(),
        }
    }
}

/// Runs a unit over consecutive seconds of sixteen rings, from their states before the first.
fn forward<T: Real>(
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

/// A unit's parameters as a policy's file has them.
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

/// A logarithm of a standard deviation within its bounds.
fn bounded<T: Real>(read: T) -> T {
    let [low, high] = LOG_SD.map(|bound| T::of(bound.into()));
    if read < low {
        low
    } else if read > high {
        high
    } else {
        read
    }
}

/// The derivative by what was read before it was bounded: beyond its bounds only the way back has one.
fn by_unbounded<T: Real>(read: T, by_bounded: T) -> T {
    let [low, high] = LOG_SD.map(|bound| T::of(bound.into()));
    let zero = T::default();
    let is_held = (read > high && by_bounded < zero) || (read < low && by_bounded > zero);
    if is_held { zero } else { by_bounded }
}

/// How much `truth` surprises whoever expected a normal distribution with this mean and logarithm of a standard deviation, nats (a
/// constant left out); and the derivatives by both.
fn surprise<T: Real>(mean: T, log_sd: T, truth: T) -> (T, [T; 2]) {
    let within = bounded(log_sd);
    let precision = (T::of(-2.0) * within).exp();
    let off = mean - truth;
    let nats = T::of(0.5) * off * off * precision + within;
    (nats, [off * precision, by_unbounded(log_sd, T::of(1.0) - off * off * precision)])
}

#[cfg(test)]
mod tests;
