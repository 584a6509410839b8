//! A multi-layer perceptron with tanh on all layers but the last, on one flat array of parameters. In: rows of inputs. Out: rows of
//! outputs, gradients (VJP) and directional derivatives (JVP). Generic over `f32` for training and `f64` for tests with finite
//! differences.
//!
//! Parameters are stored layer by layer: the weights, one row per input, then the biases. All matrices are row-major.

use super::{
    matrix::{Matrix, add_product},
    scalar::SimdFloat,
};
use crate::{policy::NetworkLayer, rng::Stream};

/// Layer sizes of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    sizes: Vec<usize>,
}

/// Inputs and the output of every layer, for some rows.
#[derive(Clone, Debug)]
pub struct Activations<T> {
    layers: Vec<Vec<T>>,
}

impl<T> Activations<T> {
    /// Returns the last layer's output.
    pub fn output(&self) -> &[T] {
        &self.layers[self.layers.len() - 1]
    }
}

impl Shape {
    /// Returns a network with these numbers of inputs, hidden units and outputs.
    pub fn new(sizes: &[usize]) -> Self {
        Self { sizes: sizes.to_vec() }
    }

    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.sizes.windows(2).map(|pair| pair[0] * pair[1] + pair[1]).sum()
    }

    /// Returns the number of inputs.
    pub fn inputs(&self) -> usize {
        self.sizes[0]
    }

    /// Returns the number of outputs.
    pub fn outputs(&self) -> usize {
        self.sizes[self.sizes.len() - 1]
    }

    /// Returns the inputs, the outputs and the index of the first weight of each layer.
    fn layers(&self) -> impl DoubleEndedIterator<Item = (usize, usize, usize)> + ExactSizeIterator {
        let mut place = 0;
        let layers: Vec<_> = self
            .sizes
            .windows(2)
            .map(|pair| {
                let at = place;
                place += pair[0] * pair[1] + pair[1];
                (pair[0], pair[1], at)
            })
            .collect();
        layers.into_iter()
    }

    /// Returns the weights, the biases and the number of outputs of each layer; weights have one row per input.
    pub fn parts<'a, T>(&self, theta: &'a [T]) -> Vec<(&'a [T], &'a [T], usize)> {
        self.layers().map(|(n, m, at)| (&theta[at..at + n * m], &theta[at + n * m..at + n * m + m], m)).collect()
    }

    /// Returns the layers in the format of a policy's file.
    pub fn network_layers(&self, theta: &[f32]) -> Vec<NetworkLayer> {
        let layers = self.parts(theta).into_iter().map(|(weights, bias, outputs)| NetworkLayer {
            bias: bias.to_vec(),
            weights: weights.chunks_exact(outputs).map(<[f32]>::to_vec).collect(),
        });
        layers.collect()
    }

    /// Returns orthogonal weights with gain sqrt 2 in hidden layers and `last_gain` in the last, and zero biases (Saxe et al. 2014; usual
    /// in the field, docs/references.md: learning).
    pub fn orthogonal<T: SimdFloat>(&self, last_gain: f64, stream: &mut Stream) -> Vec<T> {
        let mut theta = vec![T::default(); self.parameters()];
        let layers = self.layers();
        let last = layers.len() - 1;
        for (i, (n, m, at)) in layers.enumerate() {
            let gain = if i == last { last_gain } else { std::f64::consts::SQRT_2 };
            for (k, value) in orthogonal_matrix(n, m, stream).into_iter().enumerate() {
                theta[at + k] = T::of(gain * value);
            }
        }
        theta
    }

    /// Runs the network on rows of inputs.
    pub fn forward<T: SimdFloat>(&self, theta: &[T], inputs: &[T]) -> Activations<T> {
        let rows = inputs.len() / self.inputs();
        let mut layers = vec![inputs.to_vec()];
        let last = self.sizes.len() - 2;
        for (i, (n, m, at)) in self.layers().enumerate() {
            let (weights, bias) = (&theta[at..at + n * m], &theta[at + n * m..at + n * m + m]);
            let mut out = Vec::with_capacity(rows * m);
            (0..rows).for_each(|_| out.extend_from_slice(bias));
            add_product(Matrix::new(&layers[i], n), Matrix::new(weights, m), &mut out);
            if i < last {
                T::tanh_all(&mut out);
            }
            layers.push(out);
        }
        Activations { layers }
    }

    /// Returns the vector-Jacobian product: the gradient of a scalar by the parameters, given its gradient by the outputs.
    pub fn vjp<T: SimdFloat>(&self, theta: &[T], at_rows: &Activations<T>, by_output: &[T]) -> Vec<T> {
        self.backward(theta, at_rows, by_output, false).0
    }

    /// Returns the vector-Jacobian product by the parameters and by the inputs, row by row.
    pub fn vjp_with_inputs<T: SimdFloat>(
        &self,
        theta: &[T],
        at_rows: &Activations<T>,
        by_output: &[T],
    ) -> (Vec<T>, Vec<T>) {
        self.backward(theta, at_rows, by_output, true)
    }

    /// Returns the gradient by the parameters and, if requested, by the inputs.
    fn backward<T: SimdFloat>(
        &self,
        theta: &[T],
        at_rows: &Activations<T>,
        by_output: &[T],
        asks_for_inputs: bool,
    ) -> (Vec<T>, Vec<T>) {
        let mut gradient = vec![T::default(); self.parameters()];
        let mut delta = by_output.to_vec();
        for (i, (n, m, at)) in self.layers().enumerate().rev() {
            let input = &at_rows.layers[i];
            let (weights, bias) = gradient[at..at + n * m + m].split_at_mut(n * m);
            add_product(Matrix::new(input, n).t(), Matrix::new(&delta, m), weights);
            for row in delta.chunks_exact(m) {
                bias.iter_mut().zip(row).for_each(|(b, d)| *b += *d);
            }
            if i == 0 && !asks_for_inputs {
                break;
            }
            let mut below = vec![T::default(); input.len()];
            add_product(Matrix::new(&delta, m), Matrix::new(&theta[at..at + n * m], m).t(), &mut below);
            if i > 0 {
                // d tanh = 1 - tanh^2.
                below.iter_mut().zip(input).for_each(|(d, a)| *d = *d * (T::of(1.0) - *a * *a));
            }
            delta = below;
        }
        (gradient, delta)
    }

    /// Returns the Jacobian-vector product: the change of the outputs as the parameters move along `direction`.
    pub fn jvp<T: SimdFloat>(&self, theta: &[T], at_rows: &Activations<T>, direction: &[T]) -> Vec<T> {
        let rows = at_rows.layers[0].len() / self.inputs();
        let mut tangent: Vec<T> = Vec::new();
        let last = self.sizes.len() - 2;
        for (i, (n, m, at)) in self.layers().enumerate() {
            let bias = &direction[at + n * m..at + n * m + m];
            let mut out = Vec::with_capacity(rows * m);
            (0..rows).for_each(|_| out.extend_from_slice(bias));
            let moved = Matrix::new(&direction[at..at + n * m], m);
            add_product(Matrix::new(&at_rows.layers[i], n), moved, &mut out);
            if i > 0 {
                let weights = Matrix::new(&theta[at..at + n * m], m);
                add_product(Matrix::new(&tangent, n), weights, &mut out);
            }
            if i < last {
                let after = &at_rows.layers[i + 1];
                out.iter_mut().zip(after).for_each(|(d, a)| *d = *d * (T::of(1.0) - *a * *a));
            }
            tangent = out;
        }
        tangent
    }
}

/// Returns a random `n` by `m` matrix with orthonormal rows, or orthonormal columns if there are fewer columns.
fn orthogonal_matrix(n: usize, m: usize, stream: &mut Stream) -> Vec<f64> {
    let (few, many) = (n.min(m), n.max(m));
    let mut basis: Vec<Vec<f64>> = Vec::new();
    while basis.len() < few {
        let mut vector: Vec<f64> = (0..many).map(|_| stream.normal()).collect();
        // Two passes of Gram-Schmidt remove the rounding error.
        for _ in 0..2 {
            for other in &basis {
                let dot: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                vector.iter_mut().zip(other).for_each(|(a, b)| *a -= dot * b);
            }
        }
        let norm = vector.iter().map(|a| a * a).sum::<f64>().sqrt();
        vector.iter_mut().for_each(|a| *a /= norm);
        basis.push(vector);
    }
    (0..n * m).map(|k| if n <= m { basis[k / m][k % m] } else { basis[k % m][k / m] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    fn numbers(n: usize, name: &str) -> Vec<f64> {
        let mut stream = rng::stream(5, name);
        (0..n).map(|_| stream.normal()).collect()
    }

    fn network() -> (Shape, Vec<f64>, Vec<f64>) {
        let shape = Shape::new(&[4, 7, 5, 3]);
        let mut theta: Vec<f64> = shape.orthogonal(1.0, &mut rng::stream(1, "net"));
        theta.iter_mut().zip(numbers(1000, "shift")).for_each(|(t, d)| *t += 0.1 * d);
        (shape, theta, numbers(4 * 6, "inputs"))
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn the_gradient_equals_finite_differences() {
        let (shape, theta, inputs) = network();
        let weight = numbers(3 * 6, "weights");
        let value = |theta: &[f64]| dot(shape.forward(theta, &inputs).output(), &weight);
        let gradient = shape.vjp(&theta, &shape.forward(&theta, &inputs), &weight);
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

    #[test]
    fn the_jvp_equals_finite_differences_and_is_the_adjoint_of_the_vjp() {
        let (shape, theta, inputs) = network();
        let direction = numbers(theta.len(), "direction");
        let at = |d: f64| {
            let moved: Vec<f64> = theta.iter().zip(&direction).map(|(t, v)| t + d * v).collect();
            shape.forward(&moved, &inputs).output().to_vec()
        };
        let here = shape.forward(&theta, &inputs);
        let jvp = shape.jvp(&theta, &here, &direction);
        for ((high, low), j) in at(1e-5).iter().zip(at(-1e-5)).zip(&jvp) {
            assert!(((high - low) / 2e-5 - j).abs() < 1e-7);
        }
        let weight = numbers(3 * 6, "weights");
        let (left, right) = (dot(&jvp, &weight), dot(&shape.vjp(&theta, &here, &weight), &direction));
        assert!((left - right).abs() < 1e-10, "{left} {right}");
    }

    #[test]
    fn the_fast_tanh_equals_that_of_the_library() {
        let mut xs: Vec<f32> = (-40_000..=40_000).map(|i| i as f32 * 3e-4).collect();
        let exact: Vec<f64> = xs.iter().map(|x| f64::from(*x).tanh()).collect();
        f32::tanh_all(&mut xs);
        for (x, y) in xs.iter().zip(exact) {
            assert!((f64::from(*x) - y).abs() < 2e-7, "{x} {y}");
        }
        let mut odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        f32::tanh_all(&mut odd);
        assert!(odd[0].is_nan() && (odd[1] - 1.0).abs() < 2e-7 && (odd[2] + 1.0).abs() < 2e-7, "{odd:?}");
    }

    #[test]
    fn first_weights_are_orthogonal_with_the_gain_of_their_layer() {
        let shape = Shape::new(&[4, 64, 64, 1]);
        let theta: Vec<f64> = shape.orthogonal(0.01, &mut rng::stream(1, "net"));
        let parts = shape.parts(&theta);
        for (weights, gain, n, m) in [(parts[0].0, 2.0, 4, 64), (parts[1].0, 2.0, 64, 64)] {
            for i in 0..n {
                for j in 0..n {
                    let product = dot(&weights[i * m..i * m + m], &weights[j * m..j * m + m]);
                    assert!((product - if i == j { gain } else { 0.0 }).abs() < 1e-10);
                }
            }
        }
        assert!((dot(parts[2].0, parts[2].0) - 1e-4).abs() < 1e-12);
        assert!(parts.iter().all(|(_, bias, _)| bias.iter().all(|b| *b == 0.0)));
    }
}
