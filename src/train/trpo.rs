//! Trust-region policy optimisation. In: a batch of observations, actions and advantages. Out: an updated policy whose mean KL divergence
//! from the old one is within its bound. Equations: **S15** = Schulman, Levine, Moritz, Jordan, Abbeel, "Trust Region Policy
//! Optimization" (2015); **S16** = Schulman, Moritz, Levine, Jordan, Abbeel, "High-Dimensional Continuous Control Using Generalized
//! Advantage Estimation" (2016).
//!
//! Sums run over chunks of [`CHUNK`] rows in parallel and are added in order, so that the number of threads changes no bit.

use super::{
    distribution::DistributionFamily,
    net::{Activations, Shape},
    scalar::SimdFloat,
};
use rayon::prelude::*;

/// Rows per task of a thread: 500 rows of 64 numbers fit in its cache.
pub const CHUNK: usize = 500;

/// Data of one decision for the advantages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Reward of the hold.
    pub reward: f64,
    /// Value of the state before the decision.
    pub value: f64,
    /// Value of the next state: of the last observed state if the episode was cut off, of the terminal state if it ended.
    pub next_value: f64,
    /// True if another episode follows.
    pub last: bool,
}

/// Returns the generalised advantages of one ring's decisions in order of time (S16 eq. 16): with the residual `delta_t = r_t + gamma
/// V(s_t+1) - V(s_t)` (S16 eq. 10), `A_t = delta_t + gamma lambda A_t+1` within an episode.
pub fn advantages(decisions: &[Decision], gamma: f64, lambda: f64) -> Vec<f64> {
    let mut advantages = vec![0.0; decisions.len()];
    let mut next = 0.0;
    for (advantage, d) in advantages.iter_mut().zip(decisions).rev() {
        let delta = d.reward + gamma * d.next_value - d.value;
        next = delta + if d.last { 0.0 } else { gamma * lambda * next };
        *advantage = next;
    }
    advantages
}

/// A stochastic policy: a network and a family of distributions. Its parameters are the network's, followed for the normal distribution
/// by the logarithm of the standard deviation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PolicyShape {
    /// Shape of the network.
    pub net: Shape,
    /// Distribution of the actions.
    pub family: DistributionFamily,
}

/// Data of an update, with rows in any order.
#[derive(Clone, Debug)]
pub struct Batch<T> {
    /// Observations, row by row.
    pub inputs: Vec<T>,
    /// Actions as their family represents them.
    pub actions: Vec<T>,
    /// Advantages with mean 0 and standard deviation 1.
    pub advantages: Vec<f64>,
}

impl<T: SimdFloat> Batch<T> {
    /// Returns every `n`-th row starting with the first; `inputs` is the length of a row of observations.
    fn every(&self, n: usize, inputs: usize) -> Self {
        Self {
            inputs: self.inputs.chunks_exact(inputs).step_by(n).flatten().copied().collect(),
            actions: self.actions.iter().step_by(n).copied().collect(),
            advantages: self.advantages.iter().step_by(n).copied().collect(),
        }
    }
}

/// Settings of an update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrustRegionSettings {
    /// Bound on the mean KL divergence, delta of S15 eq. 12.
    pub max_kl: f64,
    /// Largest number of conjugate-gradient steps.
    pub cg_steps: u32,
    /// Damping added to the diagonal of the Fisher matrix.
    pub damping: f64,
    /// Stride of the rows used for the Fisher matrix, starting with the first (S15 appendix C also uses a part of the data).
    pub fisher_every: usize,
    /// Largest number of halvings in the line search.
    pub backtracks: u32,
}

/// Result of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    /// Mean KL divergence of the new policy from the old; 0 if no step was accepted.
    pub kl: f64,
    /// Increase of the surrogate objective.
    pub gain: f64,
    /// Mean entropy of the old policy, nat.
    pub entropy: f64,
    /// Halvings before a step was accepted; `None` if none was.
    pub halvings: Option<u32>,
}

/// A part of the batch with the old policy's activations.
struct Chunk<'a, T> {
    inputs: &'a [T],
    actions: &'a [T],
    advantages: &'a [f64],
    old: Activations<T>,
}

/// A batch under a policy, with the quantities of S15 at the old parameters.
pub struct TrustRegion<'a, T> {
    shape: &'a PolicyShape,
    theta: &'a [T],
    chunks: Vec<Chunk<'a, T>>,
    rows: f64,
}

impl PolicyShape {
    /// Returns the number of parameters.
    pub fn parameters(&self) -> usize {
        self.net.parameters() + self.family.extra()
    }

    /// Splits the parameters into the network's and the logarithm of the standard deviation (0 without one).
    pub fn split<'a, T: SimdFloat>(&self, theta: &'a [T]) -> (&'a [T], T) {
        let (net, extra) = theta.split_at(self.net.parameters());
        (net, extra.first().copied().unwrap_or_default())
    }

    /// Runs one update; `theta` is replaced if the line search accepts a step (S15 section 6 and appendix C).
    pub fn update<T: SimdFloat>(&self, theta: &mut Vec<T>, batch: &Batch<T>, region: &TrustRegionSettings) -> Update {
        let old = theta.clone();
        let here = TrustRegion::new(self, &old, batch);
        let mut update = Update { entropy: here.entropy(), ..Update::default() };
        let gradient = here.gradient();
        let part = (region.fisher_every > 1).then(|| batch.every(region.fisher_every, self.net.inputs()));
        let part = part.as_ref().map(|part| TrustRegion::new(self, &old, part));
        let metric = part.as_ref().unwrap_or(&here);
        let fisher = |v: &[f64]| metric.fisher_product(v, region.damping);
        let direction = conjugate_gradient(fisher, &gradient, region.cg_steps);
        // S15 appendix C: beta = sqrt(2 delta / s^T A s), the longest step within the quadratic bound.
        let curvature = dot(&direction, &fisher(&direction));
        if !(curvature > 0.0 && curvature.is_finite()) {
            return update;
        }
        let mut step = (2.0 * region.max_kl / curvature).sqrt();
        for halvings in 0..region.backtracks {
            let moved: Vec<T> = old.iter().zip(&direction).map(|(t, d)| T::of(t.f64() + step * d)).collect();
            let (gain, kl) = here.compare(&moved);
            if gain > 0.0 && kl <= region.max_kl {
                *theta = moved;
                return Update { kl, gain, halvings: Some(halvings), ..update };
            }
            step /= 2.0;
        }
        update.kl = 0.0;
        update
    }
}

impl<'a, T: SimdFloat> TrustRegion<'a, T> {
    /// Runs the old policy on the batch.
    pub fn new(shape: &'a PolicyShape, theta: &'a [T], batch: &'a Batch<T>) -> Self {
        let net = shape.split(theta).0;
        let chunks: Vec<Chunk<'a, T>> = batch
            .inputs
            .par_chunks(CHUNK * shape.net.inputs())
            .zip(batch.actions.par_chunks(CHUNK))
            .zip(batch.advantages.par_chunks(CHUNK))
            .map(|((inputs, actions), advantages)| {
                let old = shape.net.forward(net, inputs);
                Chunk { inputs, actions, advantages, old }
            })
            .collect();
        Self { shape, theta, chunks, rows: batch.actions.len() as f64 }
    }

    /// Returns the mean over the batch, given the sum over each chunk by `of`; chunks are added in order.
    fn mean(&self, of: impl Fn(&Chunk<'a, T>) -> Vec<f64> + Send + Sync) -> Vec<f64> {
        let parts: Vec<Vec<f64>> = self.chunks.par_iter().map(of).collect();
        let mut sum = vec![0.0; parts.first().map_or(0, Vec::len)];
        for part in &parts {
            sum.iter_mut().zip(part).for_each(|(s, p)| *s += p);
        }
        sum.iter_mut().for_each(|s| *s /= self.rows);
        sum
    }

    fn rows<'c>(&self, chunk: &'c Chunk<'a, T>) -> impl Iterator<Item = (&'c [T], T, f64)> {
        let outputs = chunk.old.output().chunks_exact(self.shape.net.outputs());
        outputs.zip(chunk.actions).zip(chunk.advantages).map(|((output, action), a)| (output, *action, *a))
    }

    /// Returns the mean entropy, nat.
    pub fn entropy(&self) -> f64 {
        let log_sd = self.shape.split(self.theta).1;
        self.mean(|chunk| vec![self.rows(chunk).map(|(out, ..)| self.shape.family.entropy(out, log_sd)).sum()])[0]
    }

    /// Returns the gradient of the surrogate objective at the old policy, where the ratio of S15 eq. 14 is 1: the mean of A grad log
    /// pi(a|s).
    pub fn gradient(&self) -> Vec<f64> {
        let (net, log_sd) = self.shape.split(self.theta);
        self.mean(|chunk| {
            let mut by_output = vec![T::default(); chunk.old.output().len()];
            let mut by_log_sd = 0.0;
            let targets = by_output.chunks_exact_mut(self.shape.net.outputs());
            for ((output, action, advantage), by) in self.rows(chunk).zip(targets) {
                by_log_sd += self.shape.family.score(output, log_sd, action, advantage, by);
            }
            self.joined(self.shape.net.vjp(net, &chunk.old, &by_output), by_log_sd)
        })
    }

    /// Returns the Fisher matrix times `v` plus `damping` times `v` (S15 appendix C.1): J^T M J v, where J is the Jacobian of the outputs
    /// (one JVP, one VJP) and M the Fisher matrix of the distribution.
    pub fn fisher_product(&self, v: &[f64], damping: f64) -> Vec<f64> {
        let (net, log_sd) = self.shape.split(self.theta);
        let direction: Vec<T> = v.iter().map(|x| T::of(*x)).collect();
        let (along, log_sd_along) = self.shape.split(&direction);
        let mut product = self.mean(|chunk| {
            let mut tangent = self.shape.net.jvp(net, &chunk.old, along);
            let mut by_log_sd = 0.0;
            let size = self.shape.net.outputs();
            for (output, t) in chunk.old.output().chunks_exact(size).zip(tangent.chunks_exact_mut(size)) {
                by_log_sd += self.shape.family.fisher(output, log_sd, t, log_sd_along);
            }
            self.joined(self.shape.net.vjp(net, &chunk.old, &tangent), by_log_sd)
        });
        product.iter_mut().zip(v).for_each(|(p, x)| *p += damping * x);
        product
    }

    fn joined(&self, net: Vec<T>, by_log_sd: f64) -> Vec<f64> {
        let mut all: Vec<f64> = net.into_iter().map(T::f64).collect();
        all.resize(all.len() + self.shape.family.extra(), by_log_sd);
        all
    }

    /// Returns the increase of the surrogate objective (S15 eq. 14) and the mean KL divergence (S15 eq. 12) for other parameters.
    pub fn compare(&self, theta: &[T]) -> (f64, f64) {
        let (net, log_sd) = self.shape.split(theta);
        let old_log_sd = self.shape.split(self.theta).1;
        let family = self.shape.family;
        let sums = self.mean(|chunk| {
            let new = self.shape.net.forward(net, chunk.inputs);
            let mut sums = vec![0.0; 2];
            let outputs = new.output().chunks_exact(self.shape.net.outputs());
            for ((old, action, advantage), new) in self.rows(chunk).zip(outputs) {
                let change =
                    family.log_probability(new, log_sd, action) - family.log_probability(old, old_log_sd, action);
                sums[0] += (change.exp() - 1.0) * advantage;
                sums[1] += family.kl((old, old_log_sd), (new, log_sd));
            }
            sums
        });
        (sums[0], sums[1])
    }
}

/// Solves `A x = b` in at most `steps` steps (Hestenes and Stiefel 1952), given the product with A.
pub fn conjugate_gradient(product: impl Fn(&[f64]) -> Vec<f64>, b: &[f64], steps: u32) -> Vec<f64> {
    let mut x = vec![0.0; b.len()];
    let mut residual = b.to_vec();
    let mut direction = b.to_vec();
    let first = dot(b, b);
    let mut square = first;
    for _ in 0..steps {
        if square <= 1e-10 * first || square == 0.0 {
            break;
        }
        let along = product(&direction);
        let length = square / dot(&direction, &along);
        for i in 0..x.len() {
            x[i] += length * direction[i];
            residual[i] -= length * along[i];
        }
        let before = square;
        square = dot(&residual, &residual);
        for (d, r) in direction.iter_mut().zip(&residual) {
            *d = r + square / before * *d;
        }
    }
    x
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
