//! The value of a state: a network fitted to returns by Adam (Kingma and Ba 2015). In: observations and the returns that
//! followed. Out: estimates, in the learner's own unit (see [`super::learner`]).

use super::{net::Shape, trpo::CHUNK};
use crate::rng::Stream;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Adam's decays of the first and second moment, and what keeps its division finite.
const DECAY: [f64; 2] = [0.9, 0.999];
const EPSILON: f64 = 1e-8;

/// Parameters and the state of Adam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueFunction {
    theta: Vec<f32>,
    moments: [Vec<f32>; 2],
    steps: u64,
}

/// How the value is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueFit {
    /// Step of Adam.
    pub rate: f64,
    /// Passes over the batch.
    pub epochs: u32,
    /// Rows a step.
    pub batch: usize,
}

impl ValueFunction {
    /// A fresh value of this shape.
    pub fn new(shape: &Shape, stream: &mut Stream) -> Self {
        let theta: Vec<f32> = shape.orthogonal(1.0, stream);
        Self { moments: [vec![0.0; theta.len()], vec![0.0; theta.len()]], theta, steps: 0 }
    }

    /// Values of rows of observations.
    pub fn estimate(&self, shape: &Shape, inputs: &[f32]) -> Vec<f32> {
        let parts: Vec<Vec<f32>> = inputs
            .par_chunks(CHUNK * shape.inputs())
            .map(|inputs| shape.forward(&self.theta, inputs).output().to_vec())
            .collect();
        parts.concat()
    }

    /// Fits the value to `returns`; `stream` shuffles. Returns the mean square error before the last pass's steps.
    pub fn fit(&mut self, shape: &Shape, inputs: &[f32], returns: &[f32], how: &ValueFit, stream: &mut Stream) -> f64 {
        let n = shape.inputs();
        let mut order: Vec<usize> = (0..returns.len()).collect();
        let mut error = 0.0;
        for _ in 0..how.epochs {
            // Fisher and Yates.
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
                self.step(&parts, 2.0 / rows.len() as f64, how.rate);
            }
        }
        error / returns.len().max(1) as f64
    }

    fn step(&mut self, parts: &[(f64, Vec<f32>)], scale: f64, rate: f64) {
        self.steps += 1;
        let t = self.steps as f64;
        let rate = (rate * (1.0 - DECAY[1].powf(t)).sqrt() / (1.0 - DECAY[0].powf(t))) as f32;
        let [first, second] = &mut self.moments;
        let (d0, d1, scale) = (DECAY[0] as f32, DECAY[1] as f32, scale as f32);
        for i in 0..self.theta.len() {
            let gradient = scale * parts.iter().map(|(_, g)| g[i]).sum::<f32>();
            first[i] = d0 * first[i] + (1.0 - d0) * gradient;
            second[i] = d1 * second[i] + (1.0 - d1) * gradient * gradient;
            self.theta[i] -= rate * first[i] / (second[i].sqrt() + EPSILON as f32);
        }
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
        let mut value = ValueFunction::new(&shape, &mut stream);
        let inputs: Vec<f32> = (0..4 * 2000).map(|_| stream.uniform(-1.0, 1.0) as f32).collect();
        let returns: Vec<f32> = inputs.chunks(4).map(|x| (2.0 * x[0]).sin() + x[1] * x[2] - 0.5 * x[3]).collect();
        let how = ValueFit { rate: 3e-3, epochs: 40, batch: 200 };
        let error = value.fit(&shape, &inputs, &returns, &how, &mut stream);
        assert!(error < 0.005, "{error}");
        assert_eq!(value.estimate(&shape, &inputs).len(), 2000);
    }
}
