//! The loop around TRPO. In: a [`TrainConfig`]. Out: after each [`Learner::iterate`] a better policy and a [`LearningCurveRow`] of the
//! learning curve. A learner written to a file and read back goes on with the same bits.
//!
//! Rewards are centred on the first batch's mean and multiplied by 1 - gamma, so that a value is a speed above or below
//! that mean and the value's network has numbers near 1 to learn. Cars that collided stand for ever.

use super::{
    config::{ActionKind, TrainConfig},
    distribution::Family,
    environment::{Ending, Outcome, VecEnv},
    evaluation::evaluate,
    net::Shape,
    simd::{LANES, LaneRng},
    trpo::{Batch, Decision, PolicyShape, TrustRegion, advantages},
    value::{ValueFit, ValueFunction},
};
use crate::{
    metrics::mean_and_interval,
    policy::{Action, FORMAT, Hold, Network, NetworkInput, NetworkLayer, NetworkOutput, bounded},
    rng,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Blocks of rings on which a policy is judged during training: of one hold, and of a range of holds.
const JUDGED_BLOCKS: [usize; 2] = [2, 6];

/// One update in the learning curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearningCurveRow {
    /// Number of the update, from 1.
    pub iteration: u32,
    /// Steps of rings so far.
    pub env_steps: u64,
    /// Mean speed of all cars in the batch, with the policy's noise, m/s.
    pub mean_mps: f64,
    /// Mean reward, m/s.
    pub reward: f64,
    /// Episodes of the batch that ended in a crash.
    pub crashes: u32,
    /// KL divergence of the step.
    pub kl: f64,
    /// Entropy of the policy before it, nats.
    pub entropy: f64,
    /// Mean square error of the value.
    pub value_error: f64,
    /// Mean speed without noise over whole horizons, m/s, where the policy was judged.
    pub judged_mps: Option<f64>,
}

/// The best policy so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct BestPolicy {
    judged_mps: f64,
    iteration: u32,
    theta: Vec<f32>,
}

/// A training, running.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Learner {
    config: TrainConfig,
    theta: Vec<f32>,
    value: ValueFunction,
    blocks: Vec<RolloutWorker>,
    /// Mean reward of the first batch, m/s.
    centre_mps: Option<f64>,
    best: Option<BestPolicy>,
    curve: Vec<LearningCurveRow>,
}

/// A block of rings and the random numbers of their actions.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct RolloutWorker {
    env: VecEnv,
    rng: LaneRng,
}

/// What a block lived through: rows are decisions in order of time, lane by lane within each.
struct Rollout {
    inputs: Vec<f32>,
    actions: Vec<f32>,
    outcomes: Vec<Outcome>,
    hold: Hold,
    /// The observation after the last decision.
    after: Vec<f32>,
}

impl Learner {
    /// A training from the beginning.
    pub fn new(config: &TrainConfig) -> Self {
        let shape = policy_shape(config);
        let mut stream = rng::stream(config.seed, "train/first weights");
        let mut theta: Vec<f32> = shape.net.orthogonal(0.01, &mut stream);
        theta.resize(shape.parameters(), config.optimiser.first_sd.ln() as f32);
        let value = ValueFunction::new(&value_shape(config), &mut stream);
        let count = config.run.rings as usize / LANES;
        let blocks = (0..count).into_par_iter().map(|index| {
            let mut env = VecEnv::new(config, "train", index, config.hold_of(index, count));
            env.spread();
            let mut rng = LaneRng::new();
            for l in 0..LANES {
                let mut stream = rng::stream(config.seed, &format!("train/actions/{}", index * LANES + l));
                rng.seed(l, (stream.uniform(0.0, 1.0) * 9.0e15) as u64);
            }
            RolloutWorker { env, rng }
        });
        let blocks = blocks.collect();
        Self { config: config.clone(), theta, value, blocks, centre_mps: None, best: None, curve: Vec::new() }
    }

    /// Its configuration.
    pub fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// The learning curve so far.
    pub fn curve(&self) -> &[LearningCurveRow] {
        &self.curve
    }

    /// Updates so far.
    pub fn iteration(&self) -> u32 {
        self.curve.len() as u32
    }

    /// Goes on for so many updates in all; the rest of a configuration cannot change under way.
    pub fn set_iterations(&mut self, iterations: u32) {
        self.config.run.iterations = iterations;
        self.blocks.iter_mut().for_each(|actor| actor.env.set_iterations(iterations));
    }

    /// One batch and one update.
    pub fn iterate(&mut self) -> LearningCurveRow {
        let shape = policy_shape(&self.config);
        let rollouts = self.collect(&shape);
        let outcomes = || rollouts.iter().flat_map(|rollout| &rollout.outcomes);
        // A long hold counts for more than a short one: means are over time.
        let timed = || rollouts.iter().flat_map(|t| t.outcomes.iter().map(|o| (f64::from(t.hold.steps()), o)));
        let steps: f64 = timed().map(|(steps, _)| steps).sum();
        let mean = |of: fn(&Outcome) -> f32| timed().map(|(steps, o)| steps * f64::from(of(o))).sum::<f64>() / steps;
        let (mean_mps, reward) = (mean(|o| o.mean_mps), mean(|o| o.reward));
        let centre_mps = *self.centre_mps.get_or_insert(reward);
        let (batch, returns) = self.batch(&rollouts, centre_mps);
        let (c, optimiser) = (&self.config, &self.config.optimiser);
        let region = TrustRegion {
            max_kl: optimiser.max_kl,
            cg_steps: optimiser.cg_steps,
            damping: optimiser.damping,
            backtracks: optimiser.backtracks,
        };
        let update = shape.update(&mut self.theta, &batch, &region);
        let how = ValueFit {
            rate: optimiser.value_rate,
            epochs: optimiser.value_epochs,
            batch: optimiser.value_batch as usize,
        };
        let iteration = self.iteration() + 1;
        let mut stream = rng::stream(c.seed, &format!("train/value/{iteration}"));
        let value_error = self.value.fit(&value_shape(c), &batch.inputs, &returns, &how, &mut stream);
        let row = LearningCurveRow {
            iteration,
            env_steps: self.curve.last().map_or(0, |row| row.env_steps) + steps as u64,
            mean_mps,
            reward,
            crashes: outcomes().filter(|o| o.ending == Ending::Crash).count() as u32,
            kl: update.kl,
            entropy: update.entropy,
            value_error,
            judged_mps: (iteration.is_multiple_of(c.judge_every) || iteration == c.run.iterations)
                .then(|| self.evaluate()),
        };
        self.keep_best(&row);
        self.curve.push(row);
        row
    }

    fn keep_best(&mut self, row: &LearningCurveRow) {
        let Some(judged_mps) = row.judged_mps else { return };
        if self.best.as_ref().is_none_or(|best| judged_mps > best.judged_mps) {
            self.best = Some(BestPolicy { judged_mps, iteration: row.iteration, theta: self.theta.clone() });
        }
    }

    /// Mean speed of the present policy without noise, m/s.
    fn evaluate(&self) -> f64 {
        let network = network(&self.config, &self.theta);
        let [low, high] = self.config.holds_s();
        let rings = LANES * JUDGED_BLOCKS[usize::from(high > low)];
        let verdicts = evaluate(&self.config, "judge", rings, || Some(Box::new(network.clone())));
        mean_and_interval(&verdicts).0
    }

    /// The best policy so far and its update and judged speed; the present one if none was judged yet.
    pub fn best(&self) -> (Network, u32, Option<f64>) {
        match &self.best {
            Some(best) => (network(&self.config, &best.theta), best.iteration, Some(best.judged_mps)),
            None => (network(&self.config, &self.theta), self.iteration(), None),
        }
    }

    fn collect(&mut self, shape: &PolicyShape) -> Vec<Rollout> {
        let (config, theta) = (&self.config, &self.theta);
        self.blocks.par_iter_mut().map(|actor| actor.live(config, shape, theta)).collect()
    }

    /// Rows for the update, and the returns that the value shall learn.
    fn batch(&self, rollouts: &[Rollout], centre_mps: f64) -> (Batch<f32>, Vec<f32>) {
        let config = &self.config;
        let shape = value_shape(config);
        let inputs = config.inputs();
        let mut batch = Batch { inputs: Vec::new(), actions: Vec::new(), advantages: Vec::new() };
        let mut returns = Vec::new();
        for rollout in rollouts {
            let gamma = config.gamma(rollout.hold);
            let values = self.value.estimate(&shape, &[&rollout.inputs[..], &rollout.after[..]].concat());
            let last_inputs: Vec<f32> =
                rollout.outcomes.iter().flat_map(|o| inputs.iter().map(|input| input.scaled(&o.last_seen))).collect();
            let last_values = self.value.estimate(&shape, &last_inputs);
            let rows = rollout.outcomes.len();
            let mut of_rows = vec![0.0; rows];
            for l in 0..LANES {
                let decision = |row: usize| {
                    let outcome = &rollout.outcomes[row];
                    Decision {
                        reward: (f64::from(outcome.reward) - centre_mps) * (1.0 - gamma),
                        value: f64::from(values[row]),
                        next_value: match outcome.ending {
                            Ending::None => f64::from(values[row + LANES]),
                            Ending::Horizon => f64::from(last_values[row]),
                            // Standing for ever.
                            Ending::Crash => -centre_mps,
                        },
                        last: outcome.ending != Ending::None,
                    }
                };
                let decisions: Vec<Decision> = (l..rows).step_by(LANES).map(decision).collect();
                let advantages = advantages(&decisions, gamma, config.optimiser.gae_lambda);
                (l..rows).step_by(LANES).zip(advantages).for_each(|(row, a)| of_rows[row] = a);
            }
            returns.extend(of_rows.iter().zip(&values).map(|(a, v)| *a as f32 + v));
            batch.inputs.extend_from_slice(&rollout.inputs);
            batch.actions.extend_from_slice(&rollout.actions);
            // A long hold does more than a short one: each block's advantages are brought to one size.
            if config.advice.hold_max_s > config.advice.hold_s {
                standardise(&mut of_rows);
            }
            batch.advantages.extend(of_rows);
        }
        standardise(&mut batch.advantages);
        (batch, returns)
    }
}

impl RolloutWorker {
    /// A batch's decisions of this block.
    fn live(&mut self, config: &TrainConfig, shape: &PolicyShape, theta: &[f32]) -> Rollout {
        let (net, log_sd) = shape.split(theta);
        let rows = config.decisions() * LANES;
        let seen = config.inputs();
        let hold = self.env.hold_length();
        let mut rollout = Rollout {
            hold,
            inputs: Vec::with_capacity(rows * seen.len()),
            actions: Vec::with_capacity(rows),
            outcomes: Vec::with_capacity(rows),
            after: Vec::new(),
        };
        for _ in 0..config.decisions() {
            let inputs = self.see(&seen);
            let here = shape.net.forward(net, &inputs);
            let (normal, _) = self.rng.normal_pair();
            let uniform = self.rng.uniform();
            let outputs = here.output().chunks_exact(shape.net.outputs());
            let drawn: Vec<f32> =
                outputs.enumerate().map(|(l, out)| shape.family.draw(out, log_sd, normal[l], uniform[l])).collect();
            let actions = std::array::from_fn(|l| action(config, drawn[l], hold));
            rollout.outcomes.extend(self.env.hold(&actions));
            rollout.inputs.extend(inputs);
            rollout.actions.extend(drawn);
        }
        rollout.after = self.see(&seen);
        rollout
    }

    fn see(&self, inputs: &[NetworkInput]) -> Vec<f32> {
        let seen = |l| {
            let observation = self.env.observe(l);
            inputs.iter().map(move |input| input.scaled(&observation))
        };
        (0..LANES).flat_map(seen).collect()
    }
}

/// The action that the policy's family calls `drawn`, to stand for `hold`.
fn action(config: &TrainConfig, drawn: f32, hold: Hold) -> Action {
    let [low, high] = match config.advice.action {
        ActionKind::Acceleration => bounded(config.action_limits(), config.advice.speed_change_mps, hold.seconds()),
        ActionKind::Speed => config.action_limits(),
    };
    let share = match config.advice.levels {
        0 => (f64::from(drawn).clamp(-1.0, 1.0) + 1.0) / 2.0,
        levels => f64::from(drawn) / f64::from(levels - 1),
    };
    let value = low + (high - low) * share;
    match config.advice.action {
        ActionKind::Acceleration => Action::Acceleration(value),
        ActionKind::Speed => Action::Speed(value),
    }
}

/// The shape of the policy that a configuration asks for.
pub fn policy_shape(config: &TrainConfig) -> PolicyShape {
    let family = if config.advice.levels == 0 { Family::Normal } else { Family::Levels(config.advice.levels as usize) };
    PolicyShape { net: Shape::new(&config.layers(family.outputs())), family }
}

fn value_shape(config: &TrainConfig) -> Shape {
    Shape::new(&config.layers(1))
}

/// A policy's parameters as the drive uses them.
fn network(config: &TrainConfig, theta: &[f32]) -> Network {
    let shape = policy_shape(config);
    let layers = shape.net.parts(shape.split(theta).0).into_iter().map(|(weights, bias, outputs)| NetworkLayer {
        bias: bias.to_vec(),
        weights: weights.chunks_exact(outputs).map(<[f32]>::to_vec).collect(),
    });
    Network {
        format: FORMAT.into(),
        action: match config.advice.action {
            ActionKind::Acceleration => NetworkOutput::Acceleration,
            ActionKind::Speed => NetworkOutput::Speed,
        },
        limits: config.action_limits(),
        levels: config.advice.levels,
        speed_change_mps: config.advice.speed_change_mps,
        least_spacing_m: config.ring.least_spacing_m,
        holds_s: config.holds_s(),
        inputs: config.inputs(),
        layers: layers.collect(),
    }
}

/// Brings numbers to mean 0 and standard deviation 1.
fn standardise(xs: &mut [f64]) {
    let n = xs.len().max(1) as f64;
    let mean = xs.iter().sum::<f64>() / n;
    let sd = (xs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt().max(1e-8);
    xs.iter_mut().for_each(|x| *x = (*x - mean) / sd);
}
