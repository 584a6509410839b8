//! The optimiser Adam (Kingma and Ba 2015). In: parameters, and the gradient of the loss. Out: the parameters after one step.

use serde::{Deserialize, Serialize};

/// Decay rates of the first and second moment, and the constant that keeps the division finite.
const DECAY: [f64; 2] = [0.9, 0.999];
const EPSILON: f64 = 1e-8;

/// State of the optimiser: both moments and the step count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adam {
    moments: [Vec<f32>; 2],
    steps: u64,
}

impl Adam {
    /// Returns the initial state for this number of parameters.
    pub fn new(parameters: usize) -> Self {
        Self { moments: [vec![0.0; parameters], vec![0.0; parameters]], steps: 0 }
    }

    /// Takes one step with learning rate `rate` against the sum of `gradients` times `scale`.
    pub fn step<'a>(
        &mut self,
        theta: &mut [f32],
        gradients: impl Iterator<Item = &'a [f32]> + Clone,
        scale: f64,
        rate: f64,
    ) {
        self.steps += 1;
        let t = self.steps as f64;
        let rate = (rate * (1.0 - DECAY[1].powf(t)).sqrt() / (1.0 - DECAY[0].powf(t))) as f32;
        let [first, second] = &mut self.moments;
        let (d0, d1, scale) = (DECAY[0] as f32, DECAY[1] as f32, scale as f32);
        for (i, theta) in theta.iter_mut().enumerate() {
            let gradient = scale * gradients.clone().map(|g| g[i]).sum::<f32>();
            first[i] = d0 * first[i] + (1.0 - d0) * gradient;
            second[i] = d1 * second[i] + (1.0 - d1) * gradient * gradient;
            *theta -= rate * first[i] / (second[i].sqrt() + EPSILON as f32);
        }
    }
}
