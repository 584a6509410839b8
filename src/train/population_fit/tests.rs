//! Fits to simulated people, whose numbers are known.

use super::*;
use crate::{traffic::PopulationModel, train::ring_trajectories};

const NUMBERS: [&str; 2] = ["T", "noise_sd"];

fn start() -> TrafficPopulation {
    let parameter = |name: &str, mean: f64, spread: f64, unit: &str| {
        format!("[parameters.{name}]\nmean = {mean}\nspread = {spread}\nunit = '{unit}'\n")
    };
    let text = "format = 1\ntitle = 'start'\nsource = 'a choice'\nmodel = 'idm'\n".to_owned()
        + &parameter("v0", 30.0, 0.0, "m/s")
        + &parameter("T", 1.83, 0.25, "s")
        + &parameter("a", 1.04, 0.0, "m/s2")
        + &parameter("b", 1.5, 0.0, "m/s2")
        + &parameter("delta", 4.0, 0.0, "")
        + &parameter("s0", 2.0, 0.0, "m")
        + &parameter("noise_sd", 0.346, 0.3, "m/s2")
        + &parameter("noise_memory", 1.31, 0.0, "s");
    TrafficPopulation::parse(&text, "start.toml").unwrap()
}

fn task(budget: u32, bootstrap: u32) -> FitTask {
    let start = start();
    let numbers = NUMBERS.map(|name| FittedNumber::named(name, &start).unwrap()).to_vec();
    FitTask { start, numbers, runs: 8, budget, bootstrap, sample_budget: 12, seed: 1 }
}

/// Returns ten persons with other numbers on a ring of 130 m for four minutes.
fn people(values: [f64; 2]) -> VehicleTrajectories {
    let task = task(1, 0);
    let coordinates = [0, 1].map(|k| task.numbers[k].coordinate(values[k]));
    let drivers = task.drivers(&coordinates).unwrap();
    ring_trajectories(&drivers, (10, 130.0), 270.0, (77, 1))[0].between(30.0, 270.0)
}

#[test]
fn known_numbers_are_recovered_within_their_intervals() {
    let truth = [1.35, 0.22];
    let (task, people, stop) = (task(30, 6), people(truth), AtomicBool::new(false));
    let run = || task.run(&people, [30.0, 270.0], &stop, &|_| {}).unwrap().unwrap();
    let fit = run();
    let intervals = fit.intervals.as_ref().unwrap();
    for k in 0..2 {
        let ([low, high], value) = (intervals[k], fit.values[k]);
        assert!((low..=high).contains(&truth[k]) && (low..=high).contains(&value), "{k}: {value} {low} to {high}");
        // An interval as wide as the number itself would say nothing.
        assert!(high - low < truth[k] && (value - truth[k]).abs() < 0.25 * truth[k], "{k}: {value} {low} to {high}");
    }
    let held_out = fit.held_out.unwrap();
    assert!(held_out.model < held_out.start && held_out.model < held_out.ring_study, "{held_out:?}");
    assert!(fit.tried <= task.most_tried());
    // The file holds the population.
    assert_eq!(TrafficPopulation::parse(&fit.population.to_toml(), "mine.toml").unwrap(), fit.population);
}

#[test]
fn the_same_seed_gives_the_same_fit_with_one_thread_and_with_two() {
    let (task, people) = (task(8, 5), people([1.5, 0.3]));
    let task = FitTask { sample_budget: 3, ..task };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| task.run(&people, [30.0, 270.0], &AtomicBool::new(false), &|_| {}).unwrap().unwrap())
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn a_stopped_fit_has_the_best_so_far() {
    let people = people([1.5, 0.3]);
    let count = std::sync::atomic::AtomicU32::new(0);
    let stop = AtomicBool::new(false);
    let watch = |_| stop.store(count.fetch_add(1, Ordering::Relaxed) >= 4, Ordering::Relaxed);
    let fit = task(100, 5).run(&people, [30.0, 270.0], &stop, &watch).unwrap().unwrap();
    assert!((5..20).contains(&fit.tried) && fit.intervals.is_none() && fit.held_out.is_none(), "{}", fit.tried);
    let at_once = task(100, 5).run(&people, [30.0, 270.0], &AtomicBool::new(true), &|_| {});
    assert_eq!(at_once, Ok(None));
}

#[test]
fn a_part_without_a_moment_is_named() {
    let short = people([1.5, 0.3]).between(0.0, 60.0);
    let fault = task(4, 0).run(&short, [30.0, 90.0], &AtomicBool::new(false), &|_| {}).unwrap_err();
    assert_eq!(fault, "30 to 60 s: no gain_at_0_03_hz");
}

#[test]
fn numbers_are_named_as_means_spreads_and_correlations() {
    let start = start();
    for name in ["T", "T.spread", "T~noise_sd"] {
        let number = FittedNumber::named(name, &start).unwrap();
        assert_eq!(number.to_string(), name);
        let changed = population_at(&start, std::slice::from_ref(&number), &[number.coordinate(0.4)]).unwrap();
        assert!((number.of(&changed) - 0.4).abs() < 1e-12);
        let [low, high] = number.bounds(&start);
        assert!((low..=high).contains(&number.coordinate(number.of(&start))), "{name}");
    }
    let fault = FittedNumber::named("T~nois_sd", &start).unwrap_err();
    assert!(fault.starts_with("T~nois_sd: unknown key `nois_sd`"), "{fault}");
    assert_eq!(start.model, PopulationModel::Idm);
}
