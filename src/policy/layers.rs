//! Layers of a network. In: numbers. Out: the last layer's outputs, or the reason that the layers are inconsistent.

use serde::{Deserialize, Serialize};
use std::cell::RefCell;

thread_local! {
    /// Values of the current layer and of the previous one, kept to avoid allocation during a drive.
    static LAYERS: RefCell<[Vec<f32>; 2]> = const { RefCell::new([Vec::new(), Vec::new()]) };
}

/// One layer: `y = x W + b`, followed by tanh in all layers but the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkLayer {
    /// One value per output.
    pub bias: Vec<f32>,
    /// One row per input with one value per output.
    pub weights: Vec<Vec<f32>>,
}

/// Reasons that layers are inconsistent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayerFault {
    /// A layer's input count differs from the previous layer's output count.
    #[error("layer {layer} has {inputs} inputs; the layer before has {given} outputs")]
    Inputs {
        /// Index of the layer, from 0.
        layer: usize,
        /// Inputs of the layer.
        inputs: usize,
        /// Outputs of the previous layer.
        given: usize,
    },
    /// A row of weights differs in length from the layer's biases.
    #[error("layer {layer} has {outputs} outputs in a row of its weights and {biases} biases")]
    Row {
        /// Index of the layer, from 0.
        layer: usize,
        /// Length of the row.
        outputs: usize,
        /// Number of biases of the layer.
        biases: usize,
    },
    /// A weight or bias is infinite or NaN.
    #[error("layer {0} holds a number that is not finite")]
    NotFinite(usize),
    /// The last layer has the wrong number of outputs.
    #[error("the last layer has {outputs} outputs; allowed: {needed}")]
    Outputs {
        /// Outputs of the last layer.
        outputs: usize,
        /// Number of outputs needed.
        needed: usize,
    },
}

/// Checks that the layers take `inputs` values, give `needed` values and hold finite numbers only.
pub(super) fn check_layers(layers: &[NetworkLayer], inputs: usize, needed: usize) -> Result<(), LayerFault> {
    let mut size = inputs;
    for (i, layer) in layers.iter().enumerate() {
        if layer.weights.len() != size {
            return Err(LayerFault::Inputs { layer: i, inputs: layer.weights.len(), given: size });
        }
        size = layer.bias.len();
        if let Some(row) = layer.weights.iter().find(|row| row.len() != size) {
            return Err(LayerFault::Row { layer: i, outputs: row.len(), biases: size });
        }
        if layer.weights.iter().flatten().chain(&layer.bias).any(|x| !x.is_finite()) {
            return Err(LayerFault::NotFinite(i));
        }
    }
    if size != needed || layers.is_empty() { Err(LayerFault::Outputs { outputs: size, needed }) } else { Ok(()) }
}

/// Runs the layers and returns the result of `look` on the last layer's outputs, without copying them.
pub(super) fn run_layers<T>(
    layers: &[NetworkLayer],
    inputs: impl Iterator<Item = f32>,
    look: impl FnOnce(&[f32]) -> T,
) -> T {
    LAYERS.with_borrow_mut(|[x, y]| {
        x.clear();
        x.extend(inputs);
        for (i, layer) in layers.iter().enumerate() {
            y.clear();
            y.extend_from_slice(&layer.bias);
            for (x, weights) in x.iter().zip(&layer.weights) {
                y.iter_mut().zip(weights).for_each(|(y, w)| *y += x * w);
            }
            if i + 1 < layers.len() {
                y.iter_mut().for_each(|y| *y = y.tanh());
            }
            std::mem::swap(x, y);
        }
        look(x)
    })
}
