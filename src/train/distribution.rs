//! Distribution of a policy's action given the network's outputs: normal around the output with a separate spread parameter, or
//! categorical over levels. In: the outputs of one row. Out: probabilities, divergences and their derivatives. Actions are in -1..1
//! (continuous) or level indices.

use super::scalar::SimdFloat;
use std::f64::consts::{E, PI};

/// A family of distributions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DistributionFamily {
    /// Normal with one output as mean; the logarithm of its standard deviation is the last parameter of the policy.
    Normal,
    /// Categorical over this many levels, with one logit per level as outputs.
    Levels(usize),
}

impl DistributionFamily {
    /// Returns the number of network outputs.
    pub fn outputs(self) -> usize {
        match self {
            Self::Normal => 1,
            Self::Levels(n) => n,
        }
    }

    /// Returns the number of policy parameters in addition to the network's.
    pub fn extra(self) -> usize {
        usize::from(self == Self::Normal)
    }

    /// Returns the logarithm of the probability (density) of `action`.
    pub fn log_probability<T: SimdFloat>(self, output: &[T], log_sd: T, action: T) -> f64 {
        match self {
            Self::Normal => {
                let z = (action - output[0]).f64() / log_sd.f64().exp();
                -0.5 * z * z - log_sd.f64() - 0.5 * (2.0 * PI).ln()
            }
            Self::Levels(_) => log_softmax(output, action.f64() as usize),
        }
    }

    /// Adds `weight` times the derivative of [`DistributionFamily::log_probability`] to `by_output`; returns the derivative by `log_sd`, also
    /// weighted.
    pub fn score<T: SimdFloat>(self, output: &[T], log_sd: T, action: T, weight: f64, by_output: &mut [T]) -> f64 {
        match self {
            Self::Normal => {
                let sd = log_sd.f64().exp();
                let z = (action - output[0]).f64() / sd;
                by_output[0] += T::of(weight * z / sd);
                weight * (z * z - 1.0)
            }
            Self::Levels(_) => {
                let taken = action.f64() as usize;
                for (k, (by, p)) in by_output.iter_mut().zip(softmax(output)).enumerate() {
                    *by += T::of(weight * (f64::from(u8::from(k == taken)) - p));
                }
                0.0
            }
        }
    }

    /// Returns the KL divergence D(old || new).
    pub fn kl<T: SimdFloat>(self, old: (&[T], T), new: (&[T], T)) -> f64 {
        match self {
            Self::Normal => {
                let shift = (old.0[0] - new.0[0]).f64();
                let (old_sd, new_sd) = (old.1.f64().exp(), new.1.f64().exp());
                (new.1 - old.1).f64() + (old_sd * old_sd + shift * shift) / (2.0 * new_sd * new_sd) - 0.5
            }
            Self::Levels(n) => {
                let p = softmax(old.0);
                (0..n).zip(p).map(|(k, p)| p * (log_softmax(old.0, k) - log_softmax(new.0, k))).sum()
            }
        }
    }

    /// Multiplies `tangent` in place by the Fisher matrix of the distribution (the second derivative of the KL divergence); returns the
    /// component of `log_sd`.
    pub fn fisher<T: SimdFloat>(self, output: &[T], log_sd: T, tangent: &mut [T], log_sd_tangent: T) -> f64 {
        match self {
            Self::Normal => {
                tangent[0] = T::of(tangent[0].f64() * (-2.0 * log_sd.f64()).exp());
                2.0 * log_sd_tangent.f64()
            }
            Self::Levels(_) => {
                // (diag(p) - p p^T) t.
                let p = softmax(output);
                let mean: f64 = p.iter().zip(&*tangent).map(|(p, t)| p * t.f64()).sum();
                tangent.iter_mut().zip(p).for_each(|(t, p)| *t = T::of(p * (t.f64() - mean)));
                0.0
            }
        }
    }

    /// Returns the entropy, nat.
    pub fn entropy<T: SimdFloat>(self, output: &[T], log_sd: T) -> f64 {
        match self {
            Self::Normal => 0.5 * (2.0 * PI * E).ln() + log_sd.f64(),
            Self::Levels(n) => -(0..n).zip(softmax(output)).map(|(k, p)| p * log_softmax(output, k)).sum::<f64>(),
        }
    }

    /// Returns an action drawn with one normal and one uniform random number.
    pub fn draw(self, output: &[f32], log_sd: f32, normal: f32, uniform: f32) -> f32 {
        match self {
            Self::Normal => output[0] + log_sd.exp() * normal,
            Self::Levels(n) => {
                let mut left = f64::from(uniform);
                for (k, p) in softmax(output).into_iter().enumerate() {
                    left -= p;
                    if left < 0.0 {
                        return k as f32;
                    }
                }
                (n - 1) as f32
            }
        }
    }
}

fn log_softmax<T: SimdFloat>(output: &[T], k: usize) -> f64 {
    let top = output.iter().map(|x| x.f64()).fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = output.iter().map(|x| (x.f64() - top).exp()).sum();
    output[k].f64() - top - sum.ln()
}

fn softmax<T: SimdFloat>(output: &[T]) -> Vec<f64> {
    let top = output.iter().map(|x| x.f64()).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = output.iter().map(|x| (x.f64() - top).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAMILIES: [(DistributionFamily, f64); 2] =
        [(DistributionFamily::Normal, 0.3), (DistributionFamily::Levels(4), 2.0)];

    fn outputs(family: DistributionFamily) -> Vec<f64> {
        [0.4, -0.3, 1.1, 0.2][..family.outputs()].to_vec()
    }

    #[test]
    fn the_score_is_the_derivative_of_the_log_probability() {
        for (family, action) in FAMILIES {
            let output = outputs(family);
            let log_sd = -0.4;
            let mut score = vec![0.0; output.len()];
            let by_log_sd = family.score(&output, log_sd, action, 1.0, &mut score);
            let at = |i: usize, d: f64| {
                let mut moved = output.clone();
                moved[i] += d;
                family.log_probability(&moved, log_sd, action)
            };
            for (i, score) in score.iter().enumerate() {
                assert!((score - (at(i, 1e-5) - at(i, -1e-5)) / 2e-5).abs() < 1e-8, "{family:?}");
            }
            let at = |d: f64| family.log_probability(&output, log_sd + d, action);
            assert!((by_log_sd - (at(1e-5) - at(-1e-5)) / 2e-5).abs() < 1e-8, "{family:?}");
        }
    }

    #[test]
    fn the_fisher_matrix_is_the_second_derivative_of_the_divergence() {
        for (family, _) in FAMILIES {
            let (output, log_sd) = (outputs(family), -0.4);
            let way: Vec<f64> = [0.7, -0.2, 0.5, 0.1][..output.len()].to_vec();
            let log_sd_way = 0.3 * family.extra() as f64;
            let at = |d: f64| {
                let moved: Vec<f64> = output.iter().zip(&way).map(|(o, w)| o + d * w).collect();
                family.kl((&output, log_sd), (&moved, log_sd + d * log_sd_way))
            };
            let mut fisher = way.clone();
            let by_log_sd = family.fisher(&output, log_sd, &mut fisher, log_sd_way);
            let square: f64 = fisher.iter().zip(&way).map(|(f, w)| f * w).sum::<f64>() + by_log_sd * log_sd_way;
            let difference = (at(1e-4) + at(-1e-4)) / 1e-8;
            assert!((square - difference).abs() < 1e-5, "{family:?}: {square} {difference}");
        }
    }

    #[test]
    fn levels_are_drawn_as_often_as_they_are_likely() {
        let (family, output) = (DistributionFamily::Levels(4), [0.4_f32, -0.3, 1.1, 0.2]);
        let mut counts = [0; 4];
        (0..10_000).for_each(|i| counts[family.draw(&output, 0.0, 0.0, i as f32 / 10_000.0) as usize] += 1);
        for (k, count) in counts.into_iter().enumerate() {
            let likely = family.log_probability(&output, 0.0, k as f32).exp();
            assert!((f64::from(count) / 10_000.0 - likely).abs() < 2e-4);
        }
    }
}
