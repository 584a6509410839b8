//! Tuning against references: a grid of speeds, and the same tuning with other numbers of threads.

use super::*;
use crate::{
    driver,
    policy::{ControllerKind, PolicySettings},
    train::{RewardConfig, RingConfig},
};

/// Returns a task with eleven vehicles on half of the paper's ring for a minute and a half, and an ego that follows exactly and brakes
/// where it must.
fn small(kind: ControllerKind, budget: u32) -> TuningTask {
    let ring = RingConfig {
        vehicles_min: 11,
        vehicles_max: 11,
        circumference_min_m: 125.0,
        circumference_max_m: 125.0,
        warm_up_s: 60.0,
        horizon_s: 90.0,
        ..RingConfig::default()
    };
    let guarded = driver::named("guarded").unwrap();
    let config = TrainConfig { ring, reward: RewardConfig::default(), ..TrainConfig::default() };
    let start = Controller::by_name(kind, &config.policy_settings(0.0));
    TuningTask {
        config: config.driven_by(&guarded.params),
        driver: guarded.label(),
        holds_s: vec![1.0],
        rings: 16,
        budget,
        start,
        start_name: kind.name().into(),
    }
}

fn run(task: &TuningTask) -> TuningResult {
    task.run(&AtomicBool::new(false), |_| {})
}

#[test]
fn a_tuned_speed_is_within_one_per_cent_of_the_best_of_forty() {
    let task = small(ControllerKind::Constant, 40);
    // 11 vehicles on 125 m are as dense as the paper's ring: an equilibrium speed of 4.362 m/s (docs/references.md: ring).
    let speeds = (1..=40).map(|k| 1.5 * 4.362 * f64::from(k) / 40.0);
    let of = |speed| task.value_mps(&Controller::of(ControllerKind::Constant, &[speed]));
    let (best_mps, best) = speeds.map(|speed| (of(speed), speed)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    let result = run(&task);
    assert!(result.after_mps > 0.99 * best_mps, "{result:?}; the grid has {best_mps} at {best}");
    // Continued from there, one more try is no better, and the best result stays.
    let further = TuningTask { start: result.best, budget: 2, ..task.clone() };
    let kept = run(&further);
    assert_eq!((kept.best, kept.after_mps, kept.tried), (result.best, result.after_mps, 2));
    // The reported speed is that of the controller in the file.
    assert_eq!(result.after_mps, task.value_mps(&result.best));
    assert_eq!((result.tried, result.before_mps), (40, Some(task.value_mps(&task.start))));
}

#[test]
fn the_same_seed_gives_the_same_file_with_one_thread_and_with_two() {
    let task = small(ControllerKind::FollowerStopper, 20);
    let file = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| task.file(&run(&task)))
    };
    let one = file(1);
    assert_eq!(one, file(2));
    let mut other = task.clone();
    other.config.seed = 2;
    assert_ne!(one, other.file(&run(&other)));
    // The file holds the controller, and its head records the tuning.
    let read = ControllerFile::from_toml(&one, "tuned.toml").unwrap();
    assert_eq!((read.controller, read.advised_share), (run(&task).best, 0.0));
    for part in [
        "# Objective: mean speed of all vehicles over 90 s from the first advice; after a crash all vehicles stand \
         still.\n",
        "# Driver: guarded. Holds: 1 s.\n",
        "# Rings: 16 of the stream \"tune\", seed 1: 11 vehicles on 125 m, 60 s of warm-up.\n",
        "# Parameter sets tried: 20 of 20.\n",
        " before (follower-stopper), ",
    ] {
        assert!(one.contains(part), "{one}\nlacks {part}");
    }
}

#[test]
fn tuning_never_lowers_the_mean_speed_and_weights_holds_equally() {
    for kind in crate::policy::CONTROLLERS {
        let mut task = small(kind, 9);
        task.holds_s = vec![1.0, 10.0];
        let result = run(&task);
        assert!(result.after_mps >= result.before_mps.unwrap(), "{result:?}");
        let alone = |hold_s| TuningTask { holds_s: vec![hold_s], ..task.clone() }.value_mps(&result.best);
        assert!((result.after_mps - (alone(1.0) + alone(10.0)) / 2.0).abs() < 1e-12, "{result:?}");
    }
}

#[test]
fn the_tuning_rings_differ_from_all_other_rings() {
    let task = small(ControllerKind::TwoPhase, 1);
    let of = |stream| {
        let make = || Some(task.start.policy(0.1));
        evaluate(&task.config.held(1.0), stream, 16, make).iter().map(|r| r.mean_speed_mps).sum::<f64>() / 16.0
    };
    assert_eq!(of("tune"), task.value_mps(&task.start));
    for stream in ["train", "judge", "evaluate", "benchmark"] {
        assert_ne!(of(stream), task.value_mps(&task.start), "{stream}");
    }
}

#[test]
fn a_search_goes_through_the_speeds_of_its_ring() {
    let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 4.0, step_s: 0.1 };
    let start = Controller::by_name(ControllerKind::TwoPhase, &settings);
    assert_eq!(search_bounds(&start, &settings), [[0.0, 6.0], [0.0, 200.0], [0.0, 6.0]]);
}

#[test]
fn a_tuning_stopped_at_once_returns_its_start() {
    let task = small(ControllerKind::Pi, 100);
    let result = task.run(&AtomicBool::new(true), |_| {});
    assert_eq!((result.best, result.before_mps, result.tried), (task.start, None, 0));
}

#[test]
fn a_penalty_is_part_of_the_objective_and_of_the_files_head() {
    let mut task = small(ControllerKind::Constant, 2);
    task.config.ring.traffic_drivers = "gap-closers".into();
    let plain = task.value_mps(&task.start);
    task.config.reward.speed_sd_penalty = 0.25;
    let results = evaluate(&task.config.held(1.0), STREAM, 16, || Some(task.start.policy(0.1)));
    let mean = |of: fn(&crate::metrics::EvaluationResult) -> f64| results.iter().map(of).sum::<f64>() / 16.0;
    let sd_mps = mean(|drive| drive.speed_sd_over_vehicles_mps);
    // The deviation must be far above rounding, or the next line would hold without the penalty.
    assert!((plain - mean(|drive| drive.mean_speed_mps)).abs() < 1e-12 && sd_mps > 0.05, "{plain} {sd_mps}");
    assert!((task.value_mps(&task.start) - (plain - 0.25 * sd_mps)).abs() < 1e-12);
    let file = task.file(&run(&task));
    for part in [
        "first advice, minus 0.25 times the standard deviation of speed over them; after",
        "# Objective on these rings: ",
        " vehicles on 125 m among gap-closers, 60 s",
    ] {
        assert!(file.contains(part), "{file}");
    }
}
