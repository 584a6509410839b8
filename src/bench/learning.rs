//! Measurements of training on this machine. In: nothing. Out: [`LearningTimes`]. The fast ring is measured on one core: bare,
//! under a policy, and under a policy that estimates the driver. A TRPO update and a training iteration are measured at the
//! sizes of the comparisons with other programs (`benches/peers`).

use super::{TimeStatistics, now};
use crate::{
    idm::IdmParams,
    rng,
    train::{
        Learner, TrainConfig,
        distribution::DistributionFamily,
        fitted_network::{Fit, FittedNetwork},
        identification::EstimatorLearner,
        net::Shape,
        ring::{RingStart, VectorizedRing},
        rollout::{BatchMeans, Rollout, RolloutWorker},
        simd::LANES,
        trpo::{Batch, PolicyShape, TrustRegionSettings},
    },
};
use serde::Serialize;

/// Results of the measurement of training.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LearningTimes {
    /// Steps of rings of 22 vehicles per second on one core, noise included.
    pub ring_steps_per_s: f64,
    /// Updates of single vehicles per second: ring steps times 22.
    pub vehicle_updates_per_s: f64,
    /// Vehicle updates per second on one core, in rollouts of a 64-64 policy that decides each second.
    pub rollout_updates_per_s: f64,
    /// Vehicle updates per second in such rollouts of a policy that estimates the driver, with a gated recurrent unit for each
    /// driver.
    pub asking_rollout_updates_per_s: f64,
    /// Update at batch 16,000, nets 64-64, policy and value, on one core.
    pub update_one_core: TimeStatistics,
    /// The update on all cores.
    pub update: TimeStatistics,
    /// Iteration at batch 16,000 and hold 1 s with its 16,000 seconds of driving, on all cores.
    pub iteration: TimeStatistics,
    /// Number of cores used.
    pub cores: usize,
}

/// Number of vehicles of a ring.
const CARS: usize = 22;
const BLOCKS: usize = 16;
/// Number of decisions of an update.
const BATCH: usize = 16_000;

/// Measures training; takes about ten seconds.
pub fn learning() -> LearningTimes {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let ring_steps_per_s = rings();
    LearningTimes {
        ring_steps_per_s,
        vehicle_updates_per_s: ring_steps_per_s * CARS as f64,
        rollout_updates_per_s: rollouts(false),
        asking_rollout_updates_per_s: rollouts(true),
        update_one_core: match pool {
            Ok(pool) => pool.install(|| update(5)),
            Err(_) => update(5),
        },
        update: update(5),
        iteration: iteration(8),
        cores: rayon::current_num_threads(),
    }
}

/// Returns the ring steps per second of 256 rings, run block by block as in training; median of nine runs.
fn rings() -> f64 {
    const STEPS: usize = 500;
    let start = RingStart::bunched(CARS, 250.0, IdmParams::default(), 1);
    let block = |index: usize| {
        let mut ring = VectorizedRing::new(CARS, 0.1);
        (0..LANES).for_each(|l| ring.set(l, &RingStart { seed: (index * LANES + l) as u64, ..start.clone() }));
        ring
    };
    let mut blocks: Vec<VectorizedRing> = (0..BLOCKS).map(block).collect();
    let mut times = Vec::new();
    for _ in 0..9 {
        let begin = now();
        blocks.iter_mut().for_each(|ring| ring.run(STEPS));
        times.push(begin.elapsed());
    }
    (BLOCKS * LANES * STEPS) as f64 / (TimeStatistics::of(times).median_us * 1e-6)
}

/// Returns the vehicle updates per second in rollouts of blocks of sixteen rings, run as in training; median of nine runs.
fn rollouts(asks: bool) -> f64 {
    const DECISIONS: usize = 50;
    let mut config = TrainConfig::default();
    let (cars, metres) = (CARS as u32, 250.0);
    (config.ring.vehicles_min, config.ring.vehicles_max) = (cars, cars);
    (config.ring.circumference_min_m, config.ring.circumference_max_m) = (metres, metres);
    let inputs = config.inputs().len();
    let shape = PolicyShape { net: Shape::new(&[inputs, 64, 64, 1]), family: DistributionFamily::Normal };
    let mut theta: Vec<f32> = shape.net.orthogonal(0.01, &mut rng::stream(1, "bench"));
    theta.resize(shape.parameters(), 0.0);
    let mut blocks: Vec<RolloutWorker> = (0..BLOCKS).map(|i| RolloutWorker::new(&config, i, BLOCKS)).collect();
    if asks {
        let estimator = EstimatorLearner::new(&config);
        blocks.iter_mut().for_each(|block| block.is_watched_by(&estimator));
    }
    let (mut times, mut steps) = (Vec::new(), 0.0);
    for _ in 0..9 {
        let begin = now();
        let lived: Vec<Rollout> =
            blocks.iter_mut().map(|block| block.live(&config, &shape, &theta, DECISIONS, None)).collect();
        times.push(begin.elapsed());
        steps = BatchMeans::of(&lived).steps;
    }
    steps * CARS as f64 / (TimeStatistics::of(times).median_us * 1e-6)
}

/// Measures updates of policy and value, with the passes over the batch that training makes.
fn update(n: usize) -> TimeStatistics {
    let config = TrainConfig::default();
    let shape = PolicyShape { net: Shape::new(&[4, 64, 64, 1]), family: DistributionFamily::Normal };
    let value_shape = Shape::new(&[4, 64, 64, 1]);
    let mut stream = rng::stream(1, "bench");
    let mut theta: Vec<f32> = shape.net.orthogonal(0.01, &mut stream);
    theta.resize(shape.parameters(), 0.0);
    let mut value = FittedNetwork::new(&value_shape, &mut stream);
    let region = TrustRegionSettings {
        max_kl: config.optimiser.max_kl,
        cg_steps: config.optimiser.cg_steps,
        damping: config.optimiser.damping,
        fisher_every: config.optimiser.fisher_every as usize,
        backtracks: config.optimiser.backtracks,
    };
    let how = Fit {
        rate: config.optimiser.value_rate,
        epochs: config.optimiser.value_epochs,
        batch: config.optimiser.value_batch as usize,
    };
    let mut times = Vec::new();
    for _ in 0..n {
        let mut normals = |n: usize| (0..n).map(|_| stream.normal()).collect::<Vec<f64>>();
        let batch = Batch {
            inputs: normals(4 * BATCH).into_iter().map(|x| x as f32).collect(),
            actions: normals(BATCH).into_iter().map(|x| x as f32).collect(),
            advantages: normals(BATCH),
        };
        let returns: Vec<f32> = normals(BATCH).into_iter().map(|x| x as f32).collect();
        let begin = now();
        shape.update(&mut theta, &batch, &region);
        value.fit(&value_shape, &batch.inputs, &returns, &how, &mut stream);
        times.push(begin.elapsed());
    }
    TimeStatistics::of(times)
}

/// Measures iterations of a training, without evaluations.
fn iteration(n: usize) -> TimeStatistics {
    let config = TrainConfig { judge_every: 1_000_000, ..TrainConfig::default() };
    let mut learner = Learner::new(&config);
    let mut times = Vec::new();
    for _ in 0..n {
        let begin = now();
        learner.iterate();
        times.push(begin.elapsed());
    }
    TimeStatistics::of(times)
}
