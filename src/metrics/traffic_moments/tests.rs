//! Closed forms of the moments: vehicles whose speeds and gaps are known functions of time.

use super::*;
use crate::rng;
use std::f64::consts::TAU;

const STEP_S: f64 = 0.1;

/// Returns vehicles in a platoon, each with speed and gap as functions of its index and the step.
fn platoon(vehicles: usize, steps: usize, of: impl Fn(usize, usize) -> [f64; 2]) -> VehicleTrajectories {
    let vehicle = |i: usize| VehicleTrajectory {
        name: i.to_string(),
        leader: i.checked_sub(1),
        length_m: None,
        speed_mps: (0..steps).map(|step| of(i, step)[0]).collect(),
        gap_m: if i > 0 { (0..steps).map(|step| of(i, step)[1]).collect() } else { Vec::new() },
        s_m: Vec::new(),
    };
    VehicleTrajectories { step_s: STEP_S, ring_m: None, vehicles: (0..vehicles).map(vehicle).collect() }
}

fn near(found: &TrafficMoments, name: &str, wanted: f64, tolerance: f64) {
    let value = found.get(name).unwrap_or_else(|| panic!("{name}"));
    assert!((value - wanted).abs() <= tolerance, "{name}: {value}, closed form {wanted}");
}

#[test]
fn lag_and_gain_of_followers_that_repeat_a_random_leader_are_exact() {
    // An AR(1) process; vehicle i repeats it 1.5 s times i later.
    let mut stream = rng::stream(4, "moments");
    let mut process = vec![0.0];
    for _ in 0..4000 {
        process.push(0.95 * process[process.len() - 1] + 0.3 * stream.normal());
    }
    let found = moments(&platoon(4, 3600, |i, step| [10.0 + process[step + 100 - 15 * i], 20.0]));
    near(&found, "lag_s", 1.5, 1e-3);
    near(&found, "shortest_person_lag_s", 1.5, 1e-3);
    // The window cuts off 1.5 of 60 s, which leaves a few per cent of error at slow and fast frequencies.
    near(&found, "gain_at_0_03_hz", 1.0, 0.05);
    near(&found, "gain_at_0_15_hz", 1.0, 0.05);
    assert_eq!(found.get("wave_speed_mps"), None, "a platoon has no ring");
}

#[test]
fn the_acceleration_of_a_sine_is_its_chord_over_one_second() {
    // 3 + A sin(w t): over 1 s, 2 A sin(w / 2) cos(...), whose SD is sqrt(2) A sin(w / 2) and whose kurtosis is 1.5.
    let (amplitude, hz) = (1.5, 0.2);
    let found = moments(&platoon(1, 6010, |_, step| [3.0 + amplitude * (TAU * hz * step as f64 * STEP_S).sin(), 0.0]));
    let chord = amplitude * (TAU * hz / 2.0).sin();
    near(&found, "accel_sd_mps2", 2f64.sqrt() * chord, 1e-3);
    near(&found, "accel_kurtosis", 1.5, 1e-3);
    near(&found, "accel_p99_mps2", 2.0 * chord * (TAU * 0.005).cos(), 0.01);
    // One braking below -1 m/s² in each period of 5 s and 15 m.
    near(&found, "brakings_per_km", 1000.0 / 15.0, 0.2);
    near(&found, "standing_share", 0.0, 0.0);
}

#[test]
fn persons_with_own_time_gaps_keep_them_in_both_halves() {
    let time_gap_s = [0.0, 1.0, 2.0, 4.0, 8.0];
    let found = moments(&platoon(5, 1200, |i, step| {
        let speed_mps = 5.0 + (step as f64 * 0.05).sin();
        [speed_mps, time_gap_s[i] * speed_mps]
    }));
    near(&found, "person_time_gap_s", 3.0, 1e-9);
    near(&found, "shortest_person_time_gap_s", 1.0, 1e-9);
    near(&found, "longest_person_time_gap_s", 8.0, 1e-9);
    // Logarithms 0, 1, 2, 3 times ln 2: SD of a sample sqrt(5/3) ln 2.
    near(&found, "person_time_gap_ln_sd", (5.0f64 / 3.0).sqrt() * 2f64.ln(), 1e-9);
    near(&found, "time_gap_split_half_r", 1.0, 1e-9);
}

#[test]
fn noise_is_what_gap_and_speeds_do_not_explain() {
    // Two kinds of persons with accelerations of known noise, and gaps and leaders that explain the rest.
    let mut stream = rng::stream(5, "moments");
    let random: Vec<[f64; 3]> = (0..7300).map(|_| std::array::from_fn(|_| stream.normal())).collect();
    let found = moments(&platoon(6, 7200, |i, step| {
        // White noise of the speed: the next second's change is predicted by the present speed alone, up to the new noise.
        [10.0 + (1.0 + i as f64) * 0.1 * random[(step + 7 * i) % 7200][0], 20.0 + random[step][1]]
    }));
    near(&found, "noise_split_half_r", 1.0, 0.02);
    near(&found, "accel_split_half_r", 1.0, 0.02);
}

#[test]
fn a_ring_rebuilt_from_gaps_has_its_wave() {
    // Ten vehicles of 5 m at even places of 200 m that do not move apart: only the speeds carry a wave of -4 m/s.
    let steps = 1800;
    let of = |i: usize, step: usize| {
        let place_m = 3.0 * step as f64 * STEP_S - 20.0 * i as f64;
        3.0 + 0.2 * (TAU * (place_m + 4.0 * step as f64 * STEP_S) / 200.0).sin()
    };
    let vehicle = |i: usize| VehicleTrajectory {
        name: i.to_string(),
        leader: Some((i + 9) % 10),
        length_m: (i == 0).then_some(5.0),
        speed_mps: (0..steps).map(|step| of(i, step)).collect(),
        gap_m: vec![15.0; steps],
        s_m: Vec::new(),
    };
    let ring = VehicleTrajectories { step_s: STEP_S, ring_m: Some(200.0), vehicles: (0..10).map(vehicle).collect() };
    let found = moments(&ring);
    near(&found, "wave_speed_mps", -4.0, 0.0);
    near(&found, "wave_share", 1.0, 0.02);
    near(&found, "speed_sd_growth_per_min", 0.0, 0.01);
    near(&found, "smallest_gap_m", 15.0, 0.0);
    let unknown = moments(&VehicleTrajectories { ring_m: None, ..ring });
    assert_eq!((unknown.get("wave_speed_mps"), unknown.get("gain_at_0_03_hz").is_some()), (None, true));
}

#[test]
fn deviations_down_a_platoon_are_in_its_order() {
    let mut all = platoon(3, 1000, |i, step| [20.0 + (3.0 - i as f64) * (TAU * step as f64 / 100.0).sin(), 20.0]);
    all.vehicles.swap(0, 2);
    all.vehicles[0].leader = Some(1);
    all.vehicles[1].leader = Some(2);
    let wanted = [3.0, 2.0, 1.0].map(|amplitude| amplitude / 2f64.sqrt());
    let found = platoon_speed_sd_mps(&all);
    assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-9), "{found:?}");
}

#[test]
fn parts_in_time_are_cut_at_steps_and_nothing_has_no_moments() {
    let all = platoon(2, 100, |_, step| [step as f64, 5.0]);
    let part = all.between(1.0, 3.0);
    assert_eq!((part.steps(), part.vehicles[1].speed_mps[0], part.vehicles[1].gap_m.len()), (20, 10.0, 20));
    assert_eq!(all.between(9.0, 99.0).steps(), 10);
    assert_eq!(all.halves().map(|half| half.steps()), [50, 50]);
    let nothing = moments(&VehicleTrajectories { step_s: STEP_S, ..VehicleTrajectories::default() });
    assert!(nothing.values.iter().all(Option::is_none));
    let cut = moments(&all.between(0.0, 0.1));
    assert_eq!((cut.get("lag_s"), cut.get("brakings_per_km")), (None, None));
}
