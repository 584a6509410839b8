//! The gated recurrent unit of `policy::identification` on many rows at once, with its gradient. In: inputs and states, row by row. Out:
//! next states and readouts; the gradient of a scalar by the parameters, through time. Generic over `f32` for training and `f64` for
//! tests with finite differences.
//!
//! Parameters in order: input weights and bias, state weights and bias, readout weights and bias. Gates are columns side by side: reset,
//! update, candidate.

use crate::{
    policy::identification::GATES,
    rng::Stream,
    train::{
        matrix::{Matrix, add_product},
        net::Shape,
        scalar::SimdFloat,
    },
};

/// Sizes of a unit with its readout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GruShape {
    /// Number of inputs per row.
    pub inputs: usize,
    /// Number of units of the state.
    pub units: usize,
    /// Length of the readout.
    pub outputs: usize,
}

/// One step of all rows, kept for backpropagation.
#[derive(Clone, Debug)]
pub struct GruStep<T> {
    inputs: Vec<T>,
    before: Vec<T>,
    /// Gates side by side: reset, update, candidate.
    gates: Vec<T>,
    /// Contribution of the state to the candidate, before the reset gate.
    from_state: Vec<T>,
    /// States after the step.
    pub state: Vec<T>,
    /// Readouts of the states after the step.
    pub read: Vec<T>,
}

/// Parameters, split into their parts.
struct GruParameters<'a, T> {
    weights: &'a [T],
    bias: &'a [T],
    state_weights: &'a [T],
    state_bias: &'a [T],
    readout: &'a [T],
    readout_bias: &'a [T],
}

impl GruShape {
    fn sizes(self) -> [usize; 6] {
        let gates = GATES * self.units;
        [self.inputs * gates, gates, self.units * gates, gates, self.units * self.outputs, self.outputs]
    }

    /// Returns the number of parameters.
    pub fn parameters(self) -> usize {
        self.sizes().iter().sum()
    }

    /// Splits the parameters in the order of the file: input weights, input bias, state weights, state bias, readout weights, readout
    /// bias.
    pub fn parts<T>(self, theta: &[T]) -> [&[T]; 6] {
        let mut rest = theta;
        self.sizes().map(|size| {
            let (part, others) = rest.split_at(size);
            rest = others;
            part
        })
    }

    fn named<T>(self, theta: &[T]) -> GruParameters<'_, T> {
        let [weights, bias, state_weights, state_bias, readout, readout_bias] = self.parts(theta);
        GruParameters { weights, bias, state_weights, state_bias, readout, readout_bias }
    }

    /// Returns initial parameters: orthogonal within each gate, the readout near 0.
    pub fn first<T: SimdFloat>(self, stream: &mut Stream) -> Vec<T> {
        let gates = GATES * self.units;
        let orthogonal = |n: usize, m: usize, gain: f64, stream: &mut Stream| -> Vec<T> {
            Shape::new(&[n, m]).orthogonal(gain, stream)[..n * m].to_vec()
        };
        let mut by_gate = |n: usize| -> Vec<T> {
            let of_gates: Vec<Vec<T>> = (0..GATES).map(|_| orthogonal(n, self.units, 1.0, stream)).collect();
            (0..n * gates)
                .map(|k| {
                    let (row, column) = (k / gates, k % gates);
                    of_gates[column / self.units][row * self.units + column % self.units]
                })
                .collect()
        };
        let none = |n: usize| vec![T::default(); n];
        let (weights, state_weights) = (by_gate(self.inputs), by_gate(self.units));
        let readout = orthogonal(self.units, self.outputs, 0.1, stream);
        [weights, none(gates), state_weights, none(gates), readout, none(self.outputs)].concat()
    }

    /// Computes one step of all rows; a row restarts if its previous state is 0.
    pub fn step<T: SimdFloat>(self, theta: &[T], inputs: &[T], before: &[T]) -> GruStep<T> {
        let p = self.named(theta);
        let (n, gates_wide) = (self.units, GATES * self.units);
        let rows = inputs.len() / self.inputs;
        let repeated = |bias: &[T]| -> Vec<T> { (0..rows).flat_map(|_| bias.iter().copied()).collect() };
        let mut gates = repeated(p.bias);
        add_product(Matrix::new(inputs, self.inputs), Matrix::new(p.weights, gates_wide), &mut gates);
        let mut driven = repeated(p.state_bias);
        add_product(Matrix::new(before, n), Matrix::new(p.state_weights, gates_wide), &mut driven);
        let mut from_state = Vec::with_capacity(rows * n);
        let half = T::of(0.5);
        for (gate, driven) in gates.chunks_exact_mut(gates_wide).zip(driven.chunks_exact(gates_wide)) {
            // s(x) = (1 + tanh(x / 2)) / 2: one tanh serves all gates.
            for k in 0..2 * n {
                gate[k] = (gate[k] + driven[k]) * half;
            }
            T::tanh_all(&mut gate[..2 * n]);
            for gate in &mut gate[..2 * n] {
                *gate = (*gate + T::of(1.0)) * half;
            }
            for k in 0..n {
                gate[2 * n + k] += gate[k] * driven[2 * n + k];
            }
            T::tanh_all(&mut gate[2 * n..]);
            from_state.extend_from_slice(&driven[2 * n..]);
        }
        let mut state = Vec::with_capacity(rows * n);
        for (gate, before) in gates.chunks_exact(gates_wide).zip(before.chunks_exact(n)) {
            for k in 0..n {
                let update = gate[n + k];
                state.push((T::of(1.0) - update) * gate[2 * n + k] + update * before[k]);
            }
        }
        let mut read = repeated(p.readout_bias);
        add_product(Matrix::new(&state, n), Matrix::new(p.readout, self.outputs), &mut read);
        GruStep { inputs: inputs.to_vec(), before: before.to_vec(), gates, from_state, state, read }
    }

    /// Returns the gradient of a scalar by the parameters, given its gradient by the readouts of each step. `begins` marks the rows that
    /// restart in each step; the gradient does not pass through a restart.
    pub fn gradient<T: SimdFloat>(
        self,
        theta: &[T],
        steps: &[GruStep<T>],
        by_read: &[Vec<T>],
        begins: &[Vec<bool>],
    ) -> Vec<T> {
        let p = self.named(theta);
        let (n, wide) = (self.units, GATES * self.units);
        let mut gradient = self.sizes().map(|size| vec![T::default(); size]);
        let mut by_state = vec![T::default(); steps.first().map_or(0, |step| step.state.len())];
        for ((step, by_read), begins) in steps.iter().zip(by_read).zip(begins).rev() {
            add_product(Matrix::new(&step.state, n).t(), Matrix::new(by_read, self.outputs), &mut gradient[4]);
            add_rows(by_read, &mut gradient[5]);
            add_product(Matrix::new(by_read, self.outputs), Matrix::new(p.readout, self.outputs).t(), &mut by_state);
            let mut by_input = vec![T::default(); step.gates.len()];
            let mut by_driven = vec![T::default(); step.gates.len()];
            let mut by_before = vec![T::default(); by_state.len()];
            let one = T::of(1.0);
            for row in 0..begins.len() {
                let (gate, driven) = (&step.gates[row * wide..][..wide], &step.from_state[row * n..][..n]);
                for k in 0..n {
                    let (reset, update, candidate) = (gate[k], gate[n + k], gate[2 * n + k]);
                    let by = by_state[row * n + k];
                    let by_candidate = by * (one - update) * (one - candidate * candidate);
                    let by_update = by * (step.before[row * n + k] - candidate) * update * (one - update);
                    let by_reset = by_candidate * driven[k] * reset * (one - reset);
                    by_before[row * n + k] = by * update;
                    for (at, by_input_gate, by_driven_gate) in [
                        (k, by_reset, by_reset),
                        (n + k, by_update, by_update),
                        (2 * n + k, by_candidate, by_candidate * reset),
                    ] {
                        by_input[row * wide + at] = by_input_gate;
                        by_driven[row * wide + at] = by_driven_gate;
                    }
                }
            }
            add_product(Matrix::new(&step.inputs, self.inputs).t(), Matrix::new(&by_input, wide), &mut gradient[0]);
            add_rows(&by_input, &mut gradient[1]);
            add_product(Matrix::new(&step.before, n).t(), Matrix::new(&by_driven, wide), &mut gradient[2]);
            add_rows(&by_driven, &mut gradient[3]);
            add_product(Matrix::new(&by_driven, wide), Matrix::new(p.state_weights, wide).t(), &mut by_before);
            for (row, begins) in begins.iter().enumerate() {
                if *begins {
                    by_before[row * n..][..n].fill(T::default());
                }
            }
            by_state = by_before;
        }
        gradient.concat()
    }
}

/// Adds the sum of all rows to `out`.
fn add_rows<T: SimdFloat>(rows: &[T], out: &mut [T]) {
    let width = out.len();
    for row in rows.chunks_exact(width) {
        for k in 0..width {
            out[k] += row[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    const SHAPE: GruShape = GruShape { inputs: 3, units: 4, outputs: 2 };
    const ROWS: usize = 2;
    const STEPS: usize = 4;

    /// Rows restart at the first step, and row 1 again at step 2.
    fn begins() -> Vec<Vec<bool>> {
        (0..STEPS).map(|t| vec![t == 0, t == 0 || t == 2]).collect()
    }

    fn run(theta: &[f64], inputs: &[Vec<f64>]) -> Vec<GruStep<f64>> {
        let mut steps: Vec<GruStep<f64>> = Vec::new();
        for (inputs, begins) in inputs.iter().zip(begins()) {
            let mut before = steps.last().map_or(vec![0.0; ROWS * SHAPE.units], |step| step.state.clone());
            for (row, begins) in begins.iter().enumerate() {
                if *begins {
                    before[row * SHAPE.units..][..SHAPE.units].fill(0.0);
                }
            }
            steps.push(SHAPE.step(theta, inputs, &before));
        }
        steps
    }

    #[test]
    fn the_gradient_through_time_equals_finite_differences() {
        let mut stream = rng::stream(3, "gru");
        let mut theta: Vec<f64> = SHAPE.first(&mut stream);
        theta.iter_mut().for_each(|x| *x += 0.2 * stream.normal());
        let mut numbers = |n: usize| -> Vec<f64> { (0..n).map(|_| stream.normal()).collect() };
        let inputs: Vec<Vec<f64>> = (0..STEPS).map(|_| numbers(ROWS * SHAPE.inputs)).collect();
        let weights: Vec<Vec<f64>> = (0..STEPS).map(|_| numbers(ROWS * SHAPE.outputs)).collect();
        let value = |theta: &[f64]| -> f64 {
            let steps = run(theta, &inputs);
            steps.iter().zip(&weights).flat_map(|(s, w)| s.read.iter().zip(w)).map(|(r, w)| r * w).sum()
        };
        let gradient = SHAPE.gradient(&theta, &run(&theta, &inputs), &weights, &begins());
        assert_eq!(gradient.len(), SHAPE.parameters());
        for i in 0..theta.len() {
            let at = |d: f64| {
                let mut moved = theta.clone();
                moved[i] += d;
                value(&moved)
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((gradient[i] - difference).abs() < 1e-8, "{i}: {} {difference}", gradient[i]);
        }
    }
}
