//! The training loop around TRPO. In: a [`TrainConfig`]. Out: after each [`Learner::iterate`] an updated policy and a
//! [`LearningCurveRow`]. A learner written to a file and read back continues with the same bits.
//!
//! Rewards are centred on the first batch's mean and multiplied by 1 - gamma. So a value is a speed above or below that mean, and the
//! value network learns numbers near 1. Vehicles that collided count as stopped forever.

use super::{
    config::{ActionKind, TrainConfig},
    distribution::DistributionFamily,
    evaluation::evaluate,
    fitted_network::{Fit, FittedNetwork},
    identification::{EstimatorLearner, Seconds},
    lessons::Lesson,
    net::Shape,
    outcome::{Ending, STATE_NUMBERS, WholeState},
    rollout::{BatchMeans, Rollout, RolloutWorker},
    silence::{self, LearnedSilence},
    simd::LANES,
    trpo::{Batch, Decision, PolicyShape, TrustRegionSettings, advantages},
};
use crate::{
    policy::{CorrectedAdvice, ExpectedGain, FORMAT, Network, NetworkLayer, NetworkOutput},
    rng,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Blocks of rings on which a policy is evaluated during training: for one hold, and for a range of holds.
const JUDGED_BLOCKS: [usize; 2] = [2, 6];

/// One update in the learning curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LearningCurveRow {
    /// Number of the update, from 1.
    pub iteration: u32,
    /// Ring steps so far.
    pub env_steps: u64,
    /// Mean speed of all vehicles in the batch, with the policy's noise, m/s.
    pub mean_mps: f64,
    /// Mean reward, m/s.
    pub reward: f64,
    /// Episodes of the batch that ended in a crash.
    pub crashes: u32,
    /// KL divergence of the step, nat.
    pub kl: f64,
    /// Entropy of the policy before the update, nat.
    pub entropy: f64,
    /// Mean square error of the value network.
    pub value_error: f64,
    /// Mean speed without noise over whole horizons, m/s, if the policy was evaluated.
    pub judged_mps: Option<f64>,
    /// Loss of the driver's estimator per trait and second, nats, if it learned.
    pub estimator_loss: Option<f64>,
}

/// Best policy so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct BestPolicy {
    judged_mps: f64,
    iteration: u32,
    theta: Vec<f32>,
}

/// A training in progress.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Learner {
    config: TrainConfig,
    theta: Vec<f32>,
    value: FittedNetwork,
    blocks: Vec<RolloutWorker>,
    /// Mean reward of the first batch, m/s.
    centre_mps: Option<f64>,
    best: Option<BestPolicy>,
    curve: Vec<LearningCurveRow>,
    student: Option<EstimatorLearner>,
    corrected: Option<CorrectedAdvice>,
    /// Expected gain of advice, if it has been learned.
    expected_gain: Option<ExpectedGain>,
}

impl Learner {
    /// Returns a new training of a policy that corrects no other advice.
    pub fn new(config: &TrainConfig) -> Self {
        Self::beside(config, None)
    }

    /// Returns a new training of a policy that corrects this advice, which the configuration calls `residual_over`.
    pub fn beside(config: &TrainConfig, corrected: Option<CorrectedAdvice>) -> Self {
        let shape = policy_shape(config);
        let mut stream = rng::stream(config.seed, "train/first weights");
        let mut theta: Vec<f32> = shape.net.orthogonal(0.01, &mut stream);
        theta.resize(shape.parameters(), config.optimiser.first_sd.ln() as f32);
        ignore_latents(config, &mut theta);
        let value = FittedNetwork::new(&value_shape(config), &mut stream);
        let count = config.run.rings as usize / LANES;
        let worker = |index| {
            let mut worker = RolloutWorker::new(config, index, count);
            if let Some(advice) = &corrected {
                worker.env.correct(advice);
            }
            worker
        };
        let blocks = (0..count).into_par_iter().map(worker).collect();
        let config = config.clone();
        let (centre_mps, best, curve, student, expected_gain) = (None, None, Vec::new(), None, None);
        Self { config, theta, value, blocks, centre_mps, best, curve, student, corrected, expected_gain }
    }

    /// Returns the configuration of the training.
    pub fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// Returns the learning curve so far.
    pub fn curve(&self) -> &[LearningCurveRow] {
        &self.curve
    }

    /// Returns the number of updates so far.
    pub fn iteration(&self) -> u32 {
        self.curve.len() as u32
    }

    /// Sets the total number of updates; the rest of the configuration cannot change during a training. No effect once a student learns,
    /// because the teacher's updates are over.
    pub fn set_iterations(&mut self, iterations: u32) {
        if self.student.is_some() {
            return;
        }
        // The further trained policy has other gains.
        self.expected_gain = None;
        self.config.run.iterations = iterations;
        self.blocks.iter_mut().for_each(|actor| actor.env.set_iterations(iterations));
    }

    /// Runs one batch and one update of the current lesson.
    pub fn iterate(&mut self) -> LearningCurveRow {
        let row = match self.config.lesson_after(self.iteration()).0 {
            Lesson::Teacher | Lesson::Student => self.update_policy(),
            Lesson::Estimator => self.update_estimator(),
        };
        self.curve.push(row);
        row
    }

    /// Returns true if the policy is evaluated after this iteration.
    fn is_judged(&self, iteration: u32) -> bool {
        iteration.is_multiple_of(self.config.judge_every) || self.config.ends_lesson(iteration)
    }

    /// Runs one round of the estimator on drives under the best policy of the lessons before.
    fn update_estimator(&mut self) -> LearningCurveRow {
        let config = self.config.clone();
        if config.lesson_after(self.iteration()).1
            && let Some(best) = self.best.take()
        {
            self.theta = best.theta;
        }
        if self.student.is_none() {
            let student = EstimatorLearner::new(&config);
            self.blocks.iter_mut().for_each(|worker| worker.is_watched_by(&student));
            self.student = Some(student);
        }
        let Some(mut student) = self.student.take() else { unreachable!("made above") };
        let shape = policy_shape(&config);
        // Without noise, as in a drive.
        let mut theta = self.theta.clone();
        if shape.family == DistributionFamily::Normal {
            theta[shape.parameters() - 1] = f32::NEG_INFINITY;
        }
        let live = |worker: &mut RolloutWorker| {
            let mut seconds = Seconds::default();
            let decisions = (config.student.estimator_round_s / worker.env.hold_length().seconds()).ceil() as usize;
            let rollout = worker.live(&config, &shape, &theta, decisions, Some(&mut seconds));
            (rollout, seconds)
        };
        let lived: Vec<(Rollout, Seconds)> = self.blocks.par_iter_mut().map(live).collect();
        let (rollouts, seconds): (Vec<Rollout>, Vec<Seconds>) = lived.into_iter().unzip();
        let rounds = config.done_of(Lesson::Estimator, self.iteration());
        let done = f64::from(rounds) / f64::from(config.student.estimator_rounds);
        let loss = student.fit(&seconds, config.student.estimator_rate * 0.1_f64.powf(done));
        self.blocks.iter_mut().filter_map(|worker| worker.watcher.as_mut()).for_each(|watcher| watcher.learn(&student));
        self.student = Some(student);
        let means = BatchMeans::of(&rollouts);
        let iteration = self.iteration() + 1;
        let row = LearningCurveRow { estimator_loss: Some(loss), ..self.row(&means) };
        // Only an evaluation with the finished estimator is comparable with later ones.
        if config.ends_lesson(iteration) {
            self.keep_best(&row);
        }
        row
    }

    /// Returns the next row of the curve for a batch with these means and no learning.
    fn row(&self, means: &BatchMeans) -> LearningCurveRow {
        let (iteration, last) = (self.iteration() + 1, self.curve.last());
        LearningCurveRow {
            iteration,
            env_steps: last.map_or(0, |row| row.env_steps) + means.steps as u64,
            mean_mps: means.mean_mps,
            reward: means.reward,
            crashes: means.crashes,
            kl: 0.0,
            entropy: last.map_or(0.0, |row| row.entropy),
            value_error: 0.0,
            judged_mps: self.is_judged(iteration).then(|| self.evaluate()),
            estimator_loss: None,
        }
    }

    /// Runs one batch and one update of the policy.
    fn update_policy(&mut self) -> LearningCurveRow {
        let shape = policy_shape(&self.config);
        let rollouts = self.collect(&shape);
        let means = BatchMeans::of(&rollouts);
        let centre_mps = *self.centre_mps.get_or_insert(means.reward);
        let (batch, returns) = self.batch(&rollouts, centre_mps);
        let (c, optimiser) = (&self.config, &self.config.optimiser);
        let region = TrustRegionSettings {
            max_kl: optimiser.max_kl * self.share_of_kl(),
            cg_steps: optimiser.cg_steps,
            damping: optimiser.damping,
            fisher_every: optimiser.fisher_every as usize,
            backtracks: optimiser.backtracks,
        };
        let how =
            Fit { rate: optimiser.value_rate, epochs: optimiser.value_epochs, batch: optimiser.value_batch as usize };
        let iteration = self.iteration() + 1;
        let mut stream = rng::stream(c.seed, &format!("train/value/{iteration}"));
        let (seen, value_shape) = (self.value_rows(&rollouts), value_shape(c));
        // In parallel: the two are independent, and each has phases that occupy one thread only.
        let Self { theta, value, .. } = self;
        let (update, value_error) = rayon::join(
            || shape.update(theta, &batch, &region),
            || value.fit(&value_shape, &seen, &returns, &how, &mut stream),
        );
        let row = LearningCurveRow { kl: update.kl, entropy: update.entropy, value_error, ..self.row(&means) };
        self.keep_best(&row);
        row
    }

    /// Returns the current share of the bound on the KL divergence.
    fn share_of_kl(&self) -> f64 {
        self.config.optimiser.max_kl_falls_to.powf(self.config.share_of_updates(self.iteration()))
    }

    fn keep_best(&mut self, row: &LearningCurveRow) {
        let Some(judged_mps) = row.judged_mps else { return };
        if self.best.as_ref().is_none_or(|best| judged_mps > best.judged_mps) {
            self.best = Some(BestPolicy { judged_mps, iteration: row.iteration, theta: self.theta.clone() });
        }
    }

    /// Returns the mean value of drives with the current policy without noise, m/s ([`TrainConfig::value_mps`]).
    fn evaluate(&self) -> f64 {
        let network = self.network(&self.theta);
        let [low, high] = self.config.holds_s();
        // Each population of drivers has as many blocks.
        let rings = LANES * JUDGED_BLOCKS[usize::from(high > low)] * self.config.ring.populations().count();
        let results = evaluate(&self.config, "judge", rings, || Some(network.clone().policy(self.config.ring.step_s)));
        results.iter().map(|result| self.config.value_mps(result)).sum::<f64>() / rings as f64
    }

    /// Returns the best policy so far, its update and its evaluated speed; the current policy if none was evaluated yet.
    pub fn best(&self) -> (Network, u32, Option<f64>) {
        match &self.best {
            Some(best) => (self.network(&best.theta), best.iteration, Some(best.judged_mps)),
            None => (self.network(&self.theta), self.iteration(), None),
        }
    }

    /// Returns the network of a drive for these parameters, with the student if there is one.
    fn network(&self, theta: &[f32]) -> Network {
        Network {
            estimator: self.student.as_ref().map(EstimatorLearner::estimator),
            corrected: self.corrected.clone(),
            expected_gain: self.expected_gain.clone(),
            ..network(&self.config, theta)
        }
    }

    /// Learns when the best policy should withhold advice, after all updates and if the configuration asks for it.
    pub fn learn_silence(&mut self) -> Option<LearnedSilence> {
        let is_over = self.iteration() >= self.config.all_iterations();
        if self.config.silence.silence_rings == 0 || self.expected_gain.is_some() || !is_over {
            return None;
        }
        let learned = silence::learn(&self.config, &self.best().0);
        self.expected_gain = Some(learned.expected_gain.clone());
        Some(learned)
    }

    fn collect(&mut self, shape: &PolicyShape) -> Vec<Rollout> {
        let (config, theta) = (&self.config, &self.theta);
        self.blocks.par_iter_mut().map(|actor| actor.live(config, shape, theta, config.decisions(), None)).collect()
    }

    /// Returns the inputs of the value network at each decision of a batch.
    fn value_rows(&self, rollouts: &[Rollout]) -> Vec<f32> {
        rollouts.iter().flat_map(|rollout| value_inputs(&self.config, &rollout.inputs, &rollout.states)).collect()
    }

    /// Returns the rows of the update, and the returns that the value network is fitted to.
    fn batch(&self, rollouts: &[Rollout], centre_mps: f64) -> (Batch<f32>, Vec<f32>) {
        let config = &self.config;
        let shape = value_shape(config);
        let inputs = config.inputs();
        let mut batch = Batch { inputs: Vec::new(), actions: Vec::new(), advantages: Vec::new() };
        let mut returns = Vec::new();
        for rollout in rollouts {
            let gamma = config.gamma(rollout.hold);
            let seen = [&rollout.inputs[..], &rollout.after[..]].concat();
            let values = self.value.estimate(&shape, &value_inputs(config, &seen, &rollout.states));
            let last_seen: Vec<f32> =
                rollout.outcomes.iter().flat_map(|o| inputs.iter().map(|input| input.scaled(&o.last_seen))).collect();
            let last_states: Vec<WholeState> = rollout.outcomes.iter().map(|o| o.last_state).collect();
            let last_values = self.value.estimate(&shape, &value_inputs(config, &last_seen, &last_states));
            let rows = rollout.outcomes.len();
            let mut of_rows = vec![0.0; rows];
            let width = rollout.width;
            for column in 0..width {
                let decision = |row: usize| {
                    let outcome = &rollout.outcomes[row];
                    Decision {
                        reward: (f64::from(outcome.reward) - centre_mps) * (1.0 - gamma),
                        value: f64::from(values[row]),
                        next_value: match outcome.ending {
                            Ending::None => f64::from(values[row + width]),
                            Ending::Horizon => f64::from(last_values[row]),
                            // The vehicles count as stopped forever.
                            Ending::Crash => -centre_mps,
                        },
                        last: outcome.ending != Ending::None,
                    }
                };
                let decisions: Vec<Decision> = (column..rows).step_by(width).map(decision).collect();
                let advantages = advantages(&decisions, gamma, config.optimiser.gae_lambda);
                (column..rows).step_by(width).zip(advantages).for_each(|(row, a)| of_rows[row] = a);
            }
            returns.extend(of_rows.iter().zip(&values).map(|(a, v)| *a as f32 + v));
            batch.inputs.extend_from_slice(&rollout.inputs);
            batch.actions.extend_from_slice(&rollout.actions);
            // A long hold has a larger effect than a short one, so each block's advantages are standardised.
            if config.advice.hold_max_s > config.advice.hold_s {
                standardise(&mut of_rows);
            }
            batch.advantages.extend(of_rows);
        }
        standardise(&mut batch.advantages);
        (batch, returns)
    }
}

/// Returns the shape of the policy for a configuration.
pub fn policy_shape(config: &TrainConfig) -> PolicyShape {
    let family = if config.advice.levels == 0 {
        DistributionFamily::Normal
    } else {
        DistributionFamily::Levels(config.advice.levels as usize)
    };
    PolicyShape { net: Shape::new(&config.layers(family.outputs())), family }
}

/// Sets the first-layer weights of latents to 0, because the policy first learns without them.
fn ignore_latents(config: &TrainConfig, theta: &mut [f32]) {
    let rows = theta.chunks_exact_mut(config.network.hidden_width as usize);
    let seen = config.inputs();
    rows.zip(seen).filter(|(_, input)| input.feature.is_latent()).for_each(|(row, _)| row.fill(0.0));
}

fn value_shape(config: &TrainConfig) -> Shape {
    let mut layers = config.layers(1);
    if config.optimiser.value_sees_all {
        layers[0] += STATE_NUMBERS;
    }
    Shape::new(&layers)
}

/// Returns the inputs of the value network: rows of observations, each followed by the whole state if it is used.
fn value_inputs(config: &TrainConfig, seen: &[f32], states: &[WholeState]) -> Vec<f32> {
    if !config.optimiser.value_sees_all {
        return seen.to_vec();
    }
    let rows = seen.chunks_exact(config.inputs().len());
    rows.zip(states).flat_map(|(row, state)| row.iter().chain(state)).copied().collect()
}

/// Returns the network of a drive for these parameters.
fn network(config: &TrainConfig, theta: &[f32]) -> Network {
    let shape = policy_shape(config);
    network_of(config, shape.net.network_layers(shape.split(theta).0))
}

/// Returns the network of a drive for layers trained with this configuration in any program; [`Network::check`] checks that they fit.
pub fn network_of(config: &TrainConfig, layers: Vec<NetworkLayer>) -> Network {
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
        advised_share: config.ring.advised_share(),
        inputs: config.inputs(),
        layers,
        corrected: None,
        probe: config.probe(),
        estimator: None,
        expected_gain: None,
    }
}

/// Scales numbers to mean 0 and standard deviation 1.
fn standardise(xs: &mut [f64]) {
    let n = xs.len().max(1) as f64;
    let mean = xs.iter().sum::<f64>() / n;
    let sd = (xs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt().max(1e-8);
    xs.iter_mut().for_each(|x| *x = (*x - mean) / sd);
}
