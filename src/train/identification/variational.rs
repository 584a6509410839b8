//! A variational encoder of drivers (Kingma and Welling 2014; PeRP 2023 has one), its loss and the gradient. In: seconds of some rings,
//! and random numbers from N(0, 1). Out: the loss in nat, and its gradient by the parameters of encoder and decoder. Generic over `f32`
//! for training and `f64` for tests with finite differences.
//!
//! The encoder is the recurrent unit of a drive: after each second it outputs a mean and the logarithm of a standard deviation per
//! latent. The decoder predicts the driver's change of speed in a later second. Its inputs are a draw of the latents, the state at the
//! beginning of that second, and the advice and the leader's behaviour in it. All inputs but the latents are independent of the driver,
//! so that the latents must describe the driver. One draw must predict near and far seconds, because a driver stays the same.

use super::{
    fitting::{bounded, by_unbounded, forward, surprise},
    gru::{GruShape, GruStep},
};
use crate::{
    policy::identification::{INPUTS, SAMPLE_NUMBERS, SAMPLES},
    rng::Stream,
    train::{net::Shape, scalar::SimdFloat},
};

/// Look-ahead of the predicted seconds for each draw, s.
const AHEAD: [usize; 5] = [1, 2, 4, 8, 16];
/// Number of the decoder's inputs besides the latents; see [`SecondsWindow::condition`].
const CONDITION: usize = 8;
/// Units of each of the decoder's two hidden layers.
const UNITS: usize = 32;
/// Number of the decoder's outputs: the mean and the logarithm of the standard deviation of a change of speed, m/s.
const PREDICTED: usize = 2;

/// Sizes of encoder and decoder; their parameters follow each other in this order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VariationalShape {
    latents: usize,
    encoder: GruShape,
    decoder: Shape,
}

/// Consecutive seconds of some rings.
pub struct SecondsWindow<'a, T> {
    /// States before the first second, one row per ring.
    pub state: &'a [T],
    /// Inputs of each second, one row per ring.
    pub inputs: &'a [Vec<T>],
    /// Rings that restart in each second.
    pub begins: &'a [Vec<bool>],
}

/// Loss of a block of seconds.
pub struct VariationalLoss<T> {
    /// Sum of the loss over seconds, nat.
    pub nats: f64,
    /// Number of ring seconds in the sum.
    pub seconds: f64,
    /// Gradient of the loss by all parameters.
    pub gradient: Vec<T>,
}

/// A future second predicted from earlier latents.
struct PredictionTarget {
    /// Second in which the latents are read.
    now: usize,
    /// Second that the decoder predicts.
    then: usize,
    /// Index of the ring.
    row: usize,
    /// Weight: 1 over the number of targets from `now`.
    share: f64,
}

impl<T: SimdFloat> SecondsWindow<'_, T> {
    fn rows(&self) -> usize {
        self.begins.first().map_or(0, Vec::len)
    }

    /// Returns a ring's last sample in a second, and 1 if an advice is in force then, else 0.
    fn last(&self, second: usize, row: usize) -> (&[T], T) {
        let inputs = &self.inputs[second][row * INPUTS..][..INPUTS];
        (&inputs[(SAMPLES - 1) * SAMPLE_NUMBERS..][..SAMPLE_NUMBERS], inputs[INPUTS - 1])
    }

    /// Returns the own speed at the end of a second, m/s; `policy::identification::sample` defines the scaling.
    fn speed_mps(&self, second: usize, row: usize) -> T {
        (self.last(second, row).0[1] + T::of(1.0)) * T::of(5.0)
    }

    /// Returns the change of own speed in a second, m/s.
    fn change_mps(&self, second: usize, row: usize) -> T {
        self.speed_mps(second, row) - self.speed_mps(second - 1, row)
    }

    /// Returns the decoder's inputs for a second: the state at its beginning, and the advice and the leader's speed at its end, both
    /// relative to own speed at the beginning.
    fn condition(&self, second: usize, row: usize) -> [T; CONDITION] {
        let (before, was_advised) = self.last(second - 1, row);
        let (after, is_advised) = self.last(second, row);
        let change = self.change_mps(second, row) * T::of(0.5);
        let advised = (after[0] + change) * is_advised;
        [before[0], before[1], before[2], before[3], was_advised, advised, after[2] + change, is_advised]
    }

    /// Returns all targets that stay within one drive.
    fn targets(&self) -> Vec<PredictionTarget> {
        let mut targets = Vec::new();
        for now in 0..self.inputs.len() {
            for row in 0..self.rows() {
                let goes_on = |then: usize| then < self.inputs.len() && !(now + 1..=then).any(|t| self.begins[t][row]);
                let first = targets.len();
                let ahead = AHEAD.iter().map(|ahead| now + ahead).take_while(|then| goes_on(*then));
                targets.extend(ahead.map(|then| PredictionTarget { now, then, row, share: 1.0 }));
                let share = 1.0 / (targets.len() - first).max(1) as f64;
                targets[first..].iter_mut().for_each(|target| target.share = share);
            }
        }
        targets
    }
}

/// Returns the KL divergence of a normal distribution from N(0, 1), nat, and its derivatives by the mean and by the logarithm of the
/// standard deviation.
fn divergence<T: SimdFloat>(mean: T, log_sd: T) -> (T, [T; 2]) {
    let variance = (T::of(2.0) * log_sd).exp();
    let nats = T::of(0.5) * (mean * mean + variance - T::of(1.0)) - log_sd;
    (nats, [mean, variance - T::of(1.0)])
}

impl VariationalShape {
    /// Returns an encoder with this many units and latents, and its decoder.
    pub fn new(units: usize, latents: usize) -> Self {
        let encoder = GruShape { inputs: INPUTS, units, outputs: 2 * latents };
        Self { latents, encoder, decoder: Shape::new(&[latents + CONDITION, UNITS, UNITS, PREDICTED]) }
    }

    /// Returns the shape of the encoder.
    pub fn encoder(&self) -> GruShape {
        self.encoder
    }

    /// Returns initial parameters: latents near N(0, 1), and decoder outputs near 0.
    pub fn first<T: SimdFloat>(&self, stream: &mut Stream) -> Vec<T> {
        [self.encoder.first(stream), self.decoder.orthogonal(0.1, stream)].concat()
    }

    /// Returns the number of N(0, 1) draws for this many seconds and rings.
    pub fn noise(&self, seconds: usize, rows: usize) -> usize {
        seconds * rows * self.latents
    }

    /// Returns the loss: summed over seconds, the mean negative log likelihood of the seconds ahead plus `kl_weight` times the divergence
    /// of the latents.
    pub fn loss<T: SimdFloat>(
        &self,
        theta: &[T],
        window: &SecondsWindow<'_, T>,
        noise: &[T],
        kl_weight: f64,
    ) -> VariationalLoss<T> {
        let n = self.latents;
        let (of_encoder, of_decoder) = theta.split_at(self.encoder.parameters());
        let steps: Vec<GruStep<T>> = forward(self.encoder, of_encoder, window.state, window.inputs, window.begins);
        let targets = window.targets();
        let posterior = |target: &PredictionTarget| &steps[target.now].read[target.row * 2 * n..][..2 * n];
        let drawn = |target: &PredictionTarget| &noise[(target.now * window.rows() + target.row) * n..][..n];
        let mut conditions = Vec::with_capacity(targets.len() * self.decoder.inputs());
        for target in &targets {
            let (read, drawn) = (posterior(target), drawn(target));
            conditions.extend((0..n).map(|k| read[k] + bounded(read[n + k]).exp() * drawn[k]));
            conditions.extend(window.condition(target.then, target.row));
        }
        let decoded = self.decoder.forward(of_decoder, &conditions);
        let mut nats = 0.0;
        let mut by_predicted = Vec::with_capacity(targets.len() * PREDICTED);
        for (target, predicted) in targets.iter().zip(decoded.output().chunks_exact(PREDICTED)) {
            let (surprise, by) = surprise(predicted[0], predicted[1], window.change_mps(target.then, target.row));
            nats += target.share * surprise.f64();
            by_predicted.extend(by.map(|by| T::of(target.share) * by));
        }
        let (by_decoder, by_conditions) = self.decoder.vjp_with_inputs(of_decoder, &decoded, &by_predicted);
        let mut by_read: Vec<Vec<T>> = steps.iter().map(|step| vec![T::default(); step.read.len()]).collect();
        let mut seconds = 0.0;
        let weight = T::of(kl_weight);
        for (i, (target, by)) in targets.iter().zip(by_conditions.chunks_exact(self.decoder.inputs())).enumerate() {
            let (read, drawn) = (posterior(target), drawn(target));
            let of = &mut by_read[target.now][target.row * 2 * n..][..2 * n];
            for k in 0..n {
                of[k] += by[k];
                of[n + k] += by[k] * bounded(read[n + k]).exp() * drawn[k];
            }
            let is_last = targets.get(i + 1).is_none_or(|next| (next.now, next.row) != (target.now, target.row));
            if is_last {
                seconds += 1.0;
                for k in 0..n {
                    let (divergence, by) = divergence(read[k], bounded(read[n + k]));
                    nats += kl_weight * divergence.f64();
                    of[k] += weight * by[0];
                    of[n + k] = by_unbounded(read[n + k], of[n + k] + weight * by[1]);
                }
            }
        }
        let by_encoder = self.encoder.gradient(of_encoder, &steps, &by_read, window.begins);
        VariationalLoss { nats, seconds, gradient: [by_encoder, by_decoder].concat() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    const ROWS: usize = 2;
    const SECONDS: usize = 6;

    /// Two rings, of which the second restarts in second 3; the fields are as in [`SecondsWindow`], without the state, which is 0.
    struct Drives {
        inputs: Vec<Vec<f64>>,
        begins: Vec<Vec<bool>>,
    }

    fn drives(stream: &mut Stream) -> Drives {
        let second =
            |_| (0..ROWS * INPUTS).map(|i| if i % INPUTS == INPUTS - 1 { 1.0 } else { stream.normal() }).collect();
        let inputs = (0..SECONDS).map(second).collect();
        Drives { inputs, begins: (0..SECONDS).map(|t| vec![t == 0, t == 0 || t == 3]).collect() }
    }

    #[test]
    fn the_gradient_equals_finite_differences() {
        let shape = VariationalShape::new(3, 2);
        let mut stream = rng::stream(4, "variational");
        let Drives { inputs, begins } = drives(&mut stream);
        let state = vec![0.0; ROWS * 3];
        let window = SecondsWindow { state: &state, inputs: &inputs, begins: &begins };
        let mut theta: Vec<f64> = shape.first(&mut stream);
        theta.iter_mut().for_each(|x| *x += 0.1 * stream.normal());
        let noise: Vec<f64> = (0..shape.noise(SECONDS, ROWS)).map(|_| stream.normal()).collect();
        let found = shape.loss(&theta, &window, &noise, 0.3);
        assert_eq!(found.gradient.len(), theta.len());
        // The last second of a drive has no second ahead: one such second on ring 0, two on ring 1.
        assert_eq!(found.seconds, (ROWS * SECONDS - 3) as f64);
        for i in 0..theta.len() {
            let at = |d: f64| {
                let mut moved = theta.clone();
                moved[i] += d;
                shape.loss(&moved, &window, &noise, 0.3).nats
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            let off = (found.gradient[i] - difference).abs();
            assert!(off < 1e-6 * difference.abs().max(1.0), "{i}: {} {difference}", found.gradient[i]);
        }
    }

    #[test]
    fn the_divergence_equals_its_numerical_integral() {
        for (mean, log_sd) in [(0.0, 0.0), (1.5, -1.0), (-0.4, 0.6)] {
            let sd = f64::exp(log_sd);
            let step = 1e-3 * sd;
            // q ln (q / p) over ten standard deviations in either direction.
            let integral: f64 = (-10_000..10_000)
                .map(|i| {
                    let z = (f64::from(i) + 0.5) * 1e-3;
                    let x = mean + sd * z;
                    let q = (-0.5 * z * z).exp() / (sd * std::f64::consts::TAU.sqrt());
                    q * (0.5 * x * x - 0.5 * z * z - log_sd) * step
                })
                .sum();
            let (nats, _) = divergence(mean, log_sd);
            assert!((nats - integral).abs() < 1e-6, "{mean} {log_sd}: {nats} {integral}");
        }
    }

    #[test]
    fn the_divergence_counts_once_a_second_for_any_number_of_looks() {
        let shape = VariationalShape::new(3, 2);
        let mut stream = rng::stream(5, "variational");
        let Drives { inputs, begins } = drives(&mut stream);
        let state = vec![0.0; ROWS * 3];
        let window = SecondsWindow { state: &state, inputs: &inputs, begins: &begins };
        let mut theta: Vec<f64> = shape.first(&mut stream);
        // Latents that are constant in time: means 0.5 and -1, standard deviations e^0.2 and e^-0.3.
        let readout = shape.encoder.parameters() - 3 * 4 - 4;
        theta[readout..][..12].fill(0.0);
        theta[readout + 12..][..4].copy_from_slice(&[0.5, -1.0, 0.2, -0.3]);
        let noise = vec![0.0; shape.noise(SECONDS, ROWS)];
        let nats = |weight: f64| shape.loss(&theta, &window, &noise, weight).nats;
        let of = |mean: f64, log_sd: f64| 0.5 * (mean * mean + (2.0 * log_sd).exp() - 1.0) - log_sd;
        let expected = 9.0 * (of(0.5, 0.2) + of(-1.0, -0.3));
        assert!((nats(1.0) - nats(0.0) - expected).abs() < 1e-9, "{} {expected}", nats(1.0) - nats(0.0));
    }
}
