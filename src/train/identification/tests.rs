//! The student: it learns to distinguish unknown drivers, and estimates the same beside the rings as in a drive.

use super::*;
use crate::{
    driver::Population,
    metrics::correlation,
    policy::{
        DriverTraits, LatentEstimate, Observation, ObservedDriver,
        identification::{Identification, SAMPLES},
    },
    train::{
        ActionKind, AdviceConfig, DriverConfig, EstimatorKind, FollowKind, NetworkConfig, RingConfig, RunConfig,
        StudentConfig, TrainConfig, latent_traits::LatentTraits, learner::policy_shape, rollout::RolloutWorker,
        simd::LANES,
    },
};

/// Rings of 8 vehicles on 100 m whose egos drive up to 1 m/s faster or slower than advised, with up to 2 s of delay.
fn biased() -> TrainConfig {
    TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, top_speed_mps: 6.0, hold_s: 2.0, ..AdviceConfig::default() },
        ring: RingConfig {
            vehicles_min: 8,
            vehicles_max: 8,
            circumference_min_m: 100.0,
            circumference_max_m: 100.0,
            warm_up_s: 20.0,
            horizon_s: 120.0,
            ..RingConfig::default()
        },
        driver: DriverConfig {
            follow: FollowKind::Driver,
            population: Population::None,
            random_driver: true,
            reaction_s: 2.0,
            error_mps: 0.3,
            speed_bias_mps: 1.0,
            ..DriverConfig::default()
        },
        network: NetworkConfig { sees: "speed,gap,speed_bias".into(), hidden_width: 8, ..NetworkConfig::default() },
        student: StudentConfig { estimator_rounds: 1, estimator_units: 16, ..StudentConfig::default() },
        run: RunConfig { rings: 64, ..RunConfig::default() },
        ..TrainConfig::default()
    }
}

/// Four blocks under an untrained policy whose advice wanders.
fn blocks(config: &TrainConfig, first: usize, learner: &EstimatorLearner) -> Vec<RolloutWorker> {
    let mut blocks: Vec<RolloutWorker> = (first..first + 4).map(|index| RolloutWorker::new(config, index, 4)).collect();
    blocks.iter_mut().for_each(|worker| worker.is_watched_by(learner));
    blocks
}

fn mean(watcher: &Watcher, l: usize) -> DriverTraits {
    watcher.who_drives(l).traits().expect("traits").mean
}

fn live(config: &TrainConfig, blocks: &mut [RolloutWorker]) -> Vec<Seconds> {
    let shape = policy_shape(config);
    let mut theta = vec![0.0; shape.parameters()];
    theta[shape.parameters() - 1] = 0.5_f32.ln();
    let one = |worker: &mut RolloutWorker| {
        let mut seconds = Seconds::default();
        worker.live(config, &shape, &theta, 30, Some(&mut seconds));
        seconds
    };
    blocks.iter_mut().map(one).collect()
}

#[test]
fn new_drivers_are_distinguished_by_their_bias_after_a_minute() {
    let config = biased();
    let mut learner = EstimatorLearner::new(&config);
    let mut known = blocks(&config, 0, &learner);
    let mut losses = Vec::new();
    for _ in 0..40 {
        let seconds = live(&config, &mut known);
        losses.push(learner.fit(&seconds, 5e-3));
        // There are few drivers, so the same seconds are used again.
        (0..4).for_each(|_| _ = learner.fit(&seconds, 5e-3));
        known.iter_mut().filter_map(|worker| worker.watcher.as_mut()).for_each(|watcher| watcher.learn(&learner));
    }
    assert!(losses[39] < losses[0] - 0.1, "{losses:?}");
    // Other drivers, a minute after the beginning; a trait counts as identified at a correlation of 0.8.
    let mut strangers = blocks(&config, 50, &learner);
    live(&config, &mut strangers);
    let pairs: Vec<(f64, f64)> = strangers
        .iter()
        .flat_map(|worker| {
            let (watcher, drivers) = (worker.watcher.as_ref().expect("a student"), worker.env.drivers());
            (0..LANES).map(move |l| (mean(watcher, l).speed_bias_mps, drivers[l].speed_bias_mps))
        })
        .collect();
    let found = correlation(&pairs).expect("they differ");
    assert!(found > 0.8, "{found} {pairs:?}");
}

#[test]
fn the_student_estimates_the_same_beside_the_rings_and_in_a_drive() {
    for also_sees in ["", ",observed_reaction"] {
        let mut config = biased();
        config.network.sees += also_sees;
        student_beside_the_rings_and_in_a_drive(&config);
    }
}

fn student_beside_the_rings_and_in_a_drive(config: &TrainConfig) {
    let learner = EstimatorLearner::new(config);
    let mut watcher = Watcher::new(&learner);
    let mut alone = Identification::new(learner.estimator());
    let number = |k: usize, salt: usize| 3.0 + ((k * 13 + salt * 7) % 10) as f32 / 5.0;
    let advised = |k: usize| if k < 7 { -1.0 } else { number(k, 4) };
    // The first step of a drive has no past.
    alone.watch(&Observation::default(), 0.2);
    for k in 0..SAMPLES * 12 {
        let seen = [number(k, 1), number(k, 2), number(k, 3), advised(k), number(k, 5), number(k, 6)];
        watcher.watch(&[seen.map(|number| [number; LANES])], &[DriverTraits::default(); LANES], None);
        let [speed_mps, leader_speed_mps, gap_m, advised, reaction_s, time_gap_factor] = seen.map(f64::from);
        let observation = Observation {
            speed_mps,
            leader_speed_mps,
            gap_m,
            advised_mps: (advised >= 0.0).then_some(advised),
            observed: ObservedDriver { deviation_mps: 0.0, reaction_s, time_gap_factor },
            ..Observation::default()
        };
        alone.watch(&observation, 0.2);
        let drive = alone.who_drives().traits().expect("traits");
        for (beside, drive) in mean(&watcher, 3).numbers().into_iter().zip(drive.mean.numbers()) {
            assert!((beside - drive).abs() < 1e-5, "{k}: {beside} {drive}");
        }
    }
    assert_ne!(mean(&watcher, 3), mean(&Watcher::new(&learner), 3));
    // A new driver starts without any estimate.
    watcher.begin(3);
    assert_eq!(mean(&watcher, 3), mean(&Watcher::new(&learner), 3));
}

#[test]
fn latents_distinguish_new_drivers_by_their_bias() {
    let mut config = biased();
    config.network.sees = "speed,gap,latent_1,latent_2".into();
    config.student.estimator = EstimatorKind::Variational;
    let mut learner = EstimatorLearner::new(&config);
    let mut known = blocks(&config, 0, &learner);
    let mut losses = Vec::new();
    for _ in 0..40 {
        let seconds = live(&config, &mut known);
        losses.push(learner.fit(&seconds, 5e-3));
        (0..4).for_each(|_| _ = learner.fit(&seconds, 5e-3));
        known.iter_mut().filter_map(|worker| worker.watcher.as_mut()).for_each(|watcher| watcher.learn(&learner));
    }
    assert!(losses[39] < losses[0] - 0.1, "{losses:?}");
    let estimates = |first: usize| -> Vec<(DriverTraits, LatentEstimate)> {
        let mut strangers = blocks(&config, first, &learner);
        live(&config, &mut strangers);
        let of = |worker: &RolloutWorker| {
            let (watcher, drivers) = (worker.watcher.clone().expect("a student"), worker.env.drivers());
            (0..LANES).map(move |l| (drivers[l], watcher.who_drives(l).latents().expect("latents")))
        };
        strangers.iter().flat_map(of).collect()
    };
    let fit = LatentTraits::of(&estimates(50));
    let pair = |(traits, latents): &(DriverTraits, LatentEstimate)| {
        (traits.speed_bias_mps, fit.traits(latents).mean.speed_bias_mps)
    };
    let pairs: Vec<(f64, f64)> = estimates(60).iter().map(pair).collect();
    let found = correlation(&pairs).expect("they differ");
    assert!(found > 0.8, "{found} {pairs:?}");
}
