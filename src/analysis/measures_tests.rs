//! Measures against values that were computed by hand.

use super::*;
use crate::{
    analysis::trial::{Ego, Issued, Step},
    time::Tick,
};

/// `n` ticks; two cars, the ego first.
fn trial(n: u64, speed: impl Fn(f64) -> f64, other: impl Fn(f64) -> f64) -> Trial {
    let tick: Vec<u64> = (1..=n).collect();
    let of = |f: &dyn Fn(f64) -> f64| tick.iter().map(|t| f(Tick(*t).seconds())).collect::<Vec<f64>>();
    let rows = n as usize;
    let steps = tick.iter().filter(|t| t.is_multiple_of(10)).map(|t| {
        let at_s = Tick(*t).seconds();
        Step { tick: *t, s_m: vec![10.0, 20.0], speed_mps: vec![speed(at_s), other(at_s)] }
    });
    Trial {
        step_s: 0.1,
        route_m: 100.0,
        steps: steps.collect(),
        ego: Ego {
            throttle: vec![0.1; rows],
            brake: vec![0.0; rows],
            wheel_rad: vec![0.0; rows],
            speed_mps: of(&speed),
            accel_mps2: vec![0.0; rows],
            lane_offset_m: vec![0.0; rows],
            gap_m: vec![None; rows],
            headway_m: vec![None; rows],
            ttc_s: vec![None; rows],
            target_mps: vec![None; rows],
            in_range: vec![None; rows],
            mean_speed_mps: of(&|t| (speed(t) + other(t)) / 2.0),
            tick,
        },
        ..Trial::default()
    }
}

fn get(measures: &Measures, name: &str) -> f64 {
    measures.get(name).unwrap_or_else(|| panic!("{name}"))
}

fn near(measures: &Measures, name: &str, wanted: f64) {
    let found = get(measures, name);
    assert!((found - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{name}: {found}, by hand {wanted}");
}

#[test]
fn mean_speed_and_its_gain_are_means_over_cars_and_ticks() {
    let with = trial(1000, |_| 4.0, |_| 5.0);
    let without = trial(1000, |_| 3.0, |_| 3.5);
    let found = Measures::of(&with, Some(&without));
    near(&found, "mean_speed_mps", 4.5);
    near(&found, "baseline_speed_mps", 3.25);
    near(&found, "speed_gain_mps", 1.25);
    near(&found, "ego_speed_mps", 4.0);
    // Two cars at 4 and 5 m/s: 0.5 m/s about their mean (N).
    assert!((get(&found, "sd_over_cars_mps") - 0.5).abs() < 1e-6);
    let alone = Measures::of(&with, None);
    assert_eq!((alone.get("speed_gain_mps"), alone.get("fuel_saved_l_100km")), (None, None));
}

#[test]
fn fuel_of_a_cruise_is_that_of_the_polynomial() {
    // Kamal et al. at 10 m/s: 0.1569 + 0.245 - 0.07415 + 0.05975 = 0.3875 ml/s, 0.03875 ml/m, 3.875 l / 100 km.
    let found = Measures::of(&trial(1000, |_| 10.0, |_| 10.0), None);
    assert!((get(&found, "ego_fuel_l_100km") - 3.875).abs() < 1e-4, "{}", get(&found, "ego_fuel_l_100km"));
    assert!((get(&found, "fuel_l_100km") - 3.875).abs() < 1e-4);
}

#[test]
fn range_and_error_count_only_where_there_is_advice() {
    let mut drive = trial(1000, |_| 4.0, |_| 4.0);
    for i in 200..1000 {
        // 600 ticks at an error of -0.5, 200 at +1.
        let target = if i < 800 { 4.5 } else { 3.0 };
        drive.ego.target_mps[i] = Some(target);
        drive.ego.in_range[i] = Some(i < 800);
    }
    let found = Measures::of(&drive, None);
    near(&found, "time_in_range", 0.75);
    near(&found, "speed_error_mps", (600.0 * 0.5 + 200.0) / 800.0);
    near(&found, "speed_bias_mps", (-600.0 * 0.5 + 200.0) / 800.0);
    assert_eq!(Measures::of(&trial(100, |_| 4.0, |_| 4.0), None).get("time_in_range"), None);
}

#[test]
fn minima_are_over_what_is_there() {
    let mut drive = trial(100, |_| 4.0, |_| 4.0);
    drive.ego.gap_m[3] = Some(4.0);
    drive.ego.gap_m[50] = Some(2.5);
    drive.ego.headway_m[50] = Some(7.5);
    drive.ego.ttc_s[7] = Some(9.0);
    drive.ego.ttc_s[8] = Some(3.25);
    let found = Measures::of(&drive, None);
    near(&found, "min_gap_m", 2.5);
    near(&found, "min_headway_m", 7.5);
    near(&found, "min_ttc_s", 3.25);
}

#[test]
fn sdlp_is_that_of_a_sample() {
    let mut drive = trial(4, |_| 4.0, |_| 4.0);
    drive.ego.lane_offset_m = vec![0.1, 0.2, 0.3, 0.4];
    // Squares about 0.25: 2 (0.15^2 + 0.05^2) = 0.05, over N-1 = 3.
    near(&Measures::of(&drive, None), "sdlp_m", (0.05f64 / 3.0).sqrt());
}

#[test]
fn reversals_below_the_gap_size_do_not_count() {
    let count = |angles: &[f64]| reversals(angles.iter().copied(), 3.0);
    assert_eq!(count(&[0.0, 5.0, 0.0, 5.0, 0.0]), 3);
    assert_eq!(count(&[0.0, 2.9, 0.0, 2.9, 0.0]), 0);
    // Small turns on the way do not count, nor does a slow drift that never turns back.
    assert_eq!(count(&[0.0, 4.0, 2.0, 8.0, 6.0, 12.0, 8.0]), 1);
    assert_eq!(count(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), 0);
    assert_eq!(count(&[0.0, -1.5, 1.5, -1.5, 1.5]), 2);
    // A sine of 4 degrees and 2 s for 60 s: a turning point at every odd half second.
    let mut drive = trial(6000, |_| 4.0, |_| 4.0);
    let angle = |t: &u64| (4.0 * (std::f64::consts::PI * Tick(*t).seconds()).sin()).to_radians();
    drive.ego.wheel_rad = drive.ego.tick.iter().map(angle).collect();
    near(&Measures::of(&drive, None), "reversals_per_min", 60.0);
}

#[test]
fn jerk_is_between_means_of_steps() {
    let mut drive = trial(100, |_| 4.0, |_| 4.0);
    // Acceleration grows by 0.02 m/s2 a step and trembles within a step, which its mean leaves out.
    drive.ego.accel_mps2 = (0..100).map(|i| 0.02 * f64::from(i / 10) + if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    near(&Measures::of(&drive, None), "rms_jerk_mps3", 0.2);
}

#[test]
fn medians_of_responses_are_in_the_measures() {
    let mut drive = trial(3000, |_| 4.0, |_| 4.0);
    drive.advice.push(Issued { tick: 1, seen_tick: 1, target_mps: 4.0, range_mps: [3.8, 4.2] });
    for (k, (tick, reaction)) in [(500u64, 70usize), (1000, 90), (1500, 110)].into_iter().enumerate() {
        let target_mps = 5.0 + k as f64;
        let range_mps = [target_mps - 0.2, target_mps + 0.2];
        drive.advice.push(Issued { tick, seen_tick: tick, target_mps, range_mps });
        for value in &mut drive.ego.throttle[tick as usize - 1 + reaction..] {
            *value += 0.1;
        }
    }
    let found = Measures::of(&drive, None);
    near(&found, "changes", 3.0);
    near(&found, "responded", 1.0);
    near(&found, "reaction_s", 0.9);
    assert_eq!(found.get("enter_range_s"), None);
}

#[test]
fn every_measure_has_a_name_with_its_unit_and_a_definition() {
    let mut names: Vec<&str> = MEASURES.iter().map(|m| m.name).collect();
    for measure in MEASURES {
        let ending = match measure.unit {
            "m/s" => "_mps",
            "m/s3" => "_mps3",
            "s" => "_s",
            "m" => "_m",
            "steps" => "_steps",
            "1/min" => "_per_min",
            "l/100 km" => "_l_100km",
            _ => "",
        };
        assert!(measure.name.ends_with(ending) && measure.about.len() > 15, "{}", measure.name);
    }
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), MEASURES.len());
}

#[test]
fn latency_is_median_and_nearest_rank_of_the_frames_that_have_one() {
    let of = |latencies_s: Vec<f64>| Measures::of(&Trial { latencies_s, step_s: 0.1, ..Trial::default() }, None);
    let measured = of((1..=200).rev().map(|ms| f64::from(ms) / 1e3).collect());
    assert!((measured.get("latency_median_s").unwrap() - 0.1005).abs() < 1e-12);
    assert_eq!(measured.get("latency_p99_s"), Some(0.198));
    assert_eq!(of(vec![0.03]).get("latency_p99_s"), Some(0.03));
    assert_eq!(of(Vec::new()).get("latency_p99_s"), None, "a keyboard tells no times");
}
