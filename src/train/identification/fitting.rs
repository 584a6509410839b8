//! Parts of the fit of both estimators: the recurrent unit over seconds, the likelihood of a normal distribution, and the estimator of a
//! policy's file. Generic over `f32` for training and `f64` for tests with finite differences.

use super::gru::{GruShape, GruStep};
use crate::{
    policy::{
        DriverEstimator, NetworkLayer,
        identification::{EstimatedTrait, GATES, LOG_SD},
    },
    train::scalar::SimdFloat,
};

/// Passes over the seconds of a round.
pub(super) const PASSES: usize = 2;

/// Blocks whose seconds make one step of Adam.
pub(super) const BLOCKS_A_STEP: usize = 4;

/// Runs a unit over consecutive seconds of sixteen rings, starting from `state`.
pub(super) fn forward<T: SimdFloat>(
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
pub(super) fn estimator(shape: GruShape, theta: &[f32], traits: &[EstimatedTrait]) -> DriverEstimator {
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
pub(super) fn bounded<T: SimdFloat>(read: T) -> T {
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
pub(super) fn by_unbounded<T: SimdFloat>(read: T, by_bounded: T) -> T {
    let [low, high] = LOG_SD.map(|bound| T::of(bound.into()));
    let zero = T::default();
    let is_held = (read > high && by_bounded < zero) || (read < low && by_bounded > zero);
    if is_held { zero } else { by_bounded }
}

/// Returns the negative log likelihood of `truth` under a normal distribution, nat (without the constant), and its derivatives by the
/// mean and by the logarithm of the standard deviation.
pub(super) fn surprise<T: SimdFloat>(mean: T, log_sd: T, truth: T) -> (T, [T; 2]) {
    let within = bounded(log_sd);
    let precision = (T::of(-2.0) * within).exp();
    let off = mean - truth;
    let nats = T::of(0.5) * off * off * precision + within;
    (nats, [off * precision, by_unbounded(log_sd, T::of(1.0) - off * off * precision)])
}
