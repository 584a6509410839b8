//! A network fitted by Adam: the value of states to returns, or the gain of advice to observed gains. In: observations and targets. Out:
//! estimates in the learner's unit (see [`super::learner`]).

use super::{adam::Adam, net::Shape, trpo::CHUNK};
use crate::{policy::NetworkLayer, rng::Stream};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters of the network and state of Adam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedNetwork {
    theta: Vec<f32>,
    adam: Adam,
}

/// Settings of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Learning rate of Adam.
    pub rate: f64,
    /// Passes over the batch.
    pub epochs: u32,
    /// Rows per step of Adam.
    pub batch: usize,
}

impl FittedNetwork {
    /// Returns a network of this shape with random weights.
    pub fn new(shape: &Shape, stream: &mut Stream) -> Self {
        let theta: Vec<f32> = shape.orthogonal(1.0, stream);
        Self { adam: Adam::new(theta.len()), theta }
    }

    /// Returns the network's outputs for rows of observations.
    pub fn estimate(&self, shape: &Shape, inputs: &[f32]) -> Vec<f32> {
        let parts: Vec<Vec<f32>> = inputs
            .par_chunks(CHUNK * shape.inputs())
            .map(|inputs| shape.forward(&self.theta, inputs).output().to_vec())
            .collect();
        parts.concat()
    }

    /// Returns the layers in the format of a policy's file.
    pub fn layers(&self, shape: &Shape) -> Vec<NetworkLayer> {
        shape.network_layers(&self.theta)
    }

    /// Fits the network to `returns`; `stream` shuffles the rows. Returns the mean square error of the last pass, each row before its
    /// step.
    pub fn fit(&mut self, shape: &Shape, inputs: &[f32], returns: &[f32], how: &Fit, stream: &mut Stream) -> f64 {
        let n = shape.inputs();
        let mut order: Vec<usize> = (0..returns.len()).collect();
        let mut error = 0.0;
        for _ in 0..how.epochs {
            // Fisher-Yates shuffle.
            (1..order.len()).rev().for_each(|i| order.swap(i, stream.index(i + 1)));
            error = 0.0;
            for rows in order.chunks(how.batch) {
                let parts: Vec<(f64, Vec<f32>)> = rows
                    .par_chunks(CHUNK)
                    .map(|rows| {
                        let chunk: Vec<f32> = rows.iter().flat_map(|r| &inputs[r * n..r * n + n]).copied().collect();
                        let here = shape.forward(&self.theta, &chunk);
                        let misses: Vec<f32> =
                            here.output().iter().zip(rows).map(|(value, r)| value - returns[*r]).collect();
                        let square = misses.iter().map(|m| f64::from(m * m)).sum();
                        (square, shape.vjp(&self.theta, &here, &misses))
                    })
                    .collect();
                error += parts.iter().map(|(square, _)| square).sum::<f64>();
                let gradients = parts.iter().map(|(_, gradient)| gradient.as_slice());
                self.adam.step(&mut self.theta, gradients, 2.0 / rows.len() as f64, how.rate);
            }
        }
        error / returns.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn a_value_learns_a_smooth_function() {
        let shape = Shape::new(&[4, 32, 32, 1]);
        let mut stream = rng::stream(1, "value");
        let mut value = FittedNetwork::new(&shape, &mut stream);
        let inputs: Vec<f32> = (0..4 * 2000).map(|_| stream.uniform(-1.0, 1.0) as f32).collect();
        let returns: Vec<f32> = inputs.chunks(4).map(|x| (2.0 * x[0]).sin() + x[1] * x[2] - 0.5 * x[3]).collect();
        let how = Fit { rate: 3e-3, epochs: 40, batch: 200 };
        let error = value.fit(&shape, &inputs, &returns, &how, &mut stream);
        assert!(error < 0.005, "{error}");
        assert_eq!(value.estimate(&shape, &inputs).len(), 2000);
    }
}
