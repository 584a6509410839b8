//! The observer of drivers with known reaction times, deviations and time gaps.

use super::*;

const STEP_S: f64 = 0.1;

/// Returns what is observed of a driver on a free road after 60 s of a square wave of 0.2 m/s around 4 m/s, and the largest error of the
/// deviation in the last 30 s, m/s. The deviation is a sine of 40 s.
fn probed(reaction_s: f64, mean_mps: f64) -> (ObservedDriver, f64) {
    let (mut observer, mut advised) = (DriverObserver::default(), VecDeque::new());
    let mut seen = Observation { speed_mps: 4.0, leader_speed_mps: 4.0, gap_m: 1000.0, ..Observation::default() };
    let mut worst_mps = 0.0_f64;
    for step in 0..600 {
        let time_s = f64::from(step) * STEP_S;
        let deviation_mps = mean_mps + 0.3 * (time_s * std::f64::consts::TAU / 40.0).sin();
        let shown_mps = if step / 20 % 2 == 0 { 4.2 } else { 3.8 };
        advised.push_back(shown_mps);
        if advised.len() > (reaction_s / STEP_S).round() as usize {
            let sought_mps = advised.pop_front().unwrap() + deviation_mps;
            seen.speed_mps += (sought_mps - seen.speed_mps) / RELAXATION_S * STEP_S;
        }
        observer.watch(&seen, Some(shown_mps), STEP_S);
        let observed = observer.observed();
        if step >= 300 {
            worst_mps = worst_mps.max((observed.deviation_mps - deviation_mps).abs());
        }
    }
    (observer.observed(), worst_mps)
}

#[test]
fn a_probe_tells_the_reaction_time_and_with_it_the_deviation() {
    for (reaction_s, mean_mps) in [(0.0, 0.2), (0.4, -0.5), (0.7, 0.0), (1.0, 0.6), (1.5, 0.1), (2.2, -0.3)] {
        let (observed, worst_mps) = probed(reaction_s, mean_mps);
        // Half of the distance between two candidates.
        assert!((observed.reaction_s - reaction_s).abs() < 0.1, "{reaction_s}: {observed:?}");
        // The smoothed deviation is late by 0.35 s, in which the sine changes by up to 0.017 m/s. Between two candidates a step of the advice
        // of 0.4 m/s is taken for a deviation for a moment, less after the smoothing.
        assert!(worst_mps < 0.15, "{reaction_s}: {worst_mps}");
    }
}

#[test]
fn steady_advice_tells_nothing_and_people_are_assumed() {
    let mut observer = DriverObserver::default();
    let seen = Observation { speed_mps: 5.0, leader_speed_mps: 5.0, gap_m: 1000.0, ..Observation::default() };
    (0..300).for_each(|_| observer.watch(&seen, Some(4.0), STEP_S));
    let ObservedDriver { deviation_mps, reaction_s, time_gap_factor } = observer.observed();
    // The candidates from 0 to 2.4 s, weighted by the normal distribution of people alone, have a mean of 1.06 s.
    assert!(
        (deviation_mps - 1.0).abs() < 0.01 && (reaction_s - 1.0).abs() < 0.1 && (time_gap_factor - 1.0).abs() < 0.1
    );
    // Far off the advice: a driver who does not follow it.
    let fast = Observation { speed_mps: 9.0, ..seen };
    (0..100).for_each(|_| observer.watch(&fast, Some(4.0), STEP_S));
    assert_eq!(observer.observed().deviation_mps, 2.0);
    observer.watch(&fast, None, STEP_S);
    assert_eq!(observer.observed().deviation_mps, 0.0, "without advice there is no deviation");
}
