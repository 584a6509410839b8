//! Fit to measured people (docs/references.md: people); see `metrics::traffic_moments::measured_people_tests` on the data.

use super::*;
use crate::metrics::traffic_moments::{EXPERIMENT_A, measured_people_tests::measured};

#[test]
fn a_small_fit_of_experiment_a_has_the_known_time_gap_and_beats_its_start() {
    let name = "a_small_fit_of_experiment_a_has_the_known_time_gap_and_beats_its_start";
    let Some(all) = measured("ared/ared_a_10hz.csv.gz", Some(260.0), [module_path!(), name]) else { return };
    let [from_s, to_s] = EXPERIMENT_A.from_to_s;
    // Five numbers, far from the known ones.
    let numbers = ["T", "T.spread", "a", "noise_sd", "noise_memory"];
    let mut start = TrafficPopulation::named("safe-followers").unwrap();
    for (name, mean, spread) in [("T", 1.4, 0.2), ("a", 0.8, 0.0), ("noise_sd", 0.25, 0.0), ("noise_memory", 1.0, 0.0)]
    {
        let parameter = start.parameters.get_mut(name).unwrap();
        (parameter.mean, parameter.spread) = (mean, spread);
    }
    let start = start.checked().unwrap();
    let numbers = numbers.map(|name| FittedNumber::named(name, &start).unwrap()).to_vec();
    let task = FitTask { start, numbers, runs: 8, budget: 60, bootstrap: 0, sample_budget: 0, seed: 1 };
    let fit = task.run(&all.between(from_s, to_s), [from_s, to_s], &AtomicBool::new(false), &|_| {}).unwrap().unwrap();
    // Interval of an analysis of the same data, from the persons' own gaps: 1.62 to 2.18 s. The spread, 0.22 to 0.43, takes more rings and sets of
    // numbers than a test has time for (8 rings and 60 sets find 0.02): docs/people.md has a fit from these numbers that finds it.
    assert!((1.62..=2.18).contains(&fit.values[0]), "{:?}", fit.values);
    let held_out = fit.held_out.unwrap();
    assert!(held_out.model < held_out.start && held_out.model < 0.5 * held_out.ring_study, "{held_out:?}");
}
