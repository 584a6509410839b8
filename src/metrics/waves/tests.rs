//! Closed forms of waves: a pattern that travels at a known speed, a filter with a known gain, and a wave with known growth.

use super::*;
use crate::rng;
use std::f64::consts::TAU;

const STEP_S: f64 = 0.1;
const RING_M: f64 = 260.0;

/// Returns the sums of 20 vehicles that drive evenly at 3 m/s through `speed_mps`, a function of place and time.
fn ring(minutes: usize, speed_mps: impl Fn(f64, f64) -> f64) -> WaveTotals {
    let mut totals = WaveTotals::on_ring(STEP_S, RING_M);
    for step in 0..minutes * 600 {
        let time_s = step as f64 * STEP_S;
        let sample = |i: usize| {
            let position_m = i as f64 * 13.0 + 3.0 * time_s;
            VehicleSample { speed_mps: speed_mps(position_m, time_s), position_m }
        };
        totals.add((0..20).map(sample));
    }
    totals
}

#[test]
fn a_sine_wave_against_the_traffic_has_its_speed_and_all_the_variance() {
    let wave = ring(3, |x, t| 3.0 + (TAU * 2.0 * (x + 4.25 * t) / RING_M).sin()).wave().unwrap();
    assert_eq!(wave.speed_mps, -4.25);
    assert!(wave.share > 0.99, "{wave:?}");
    let forward = ring(2, |x, t| 3.0 + (TAU * 3.0 * (x - 2.5 * t) / RING_M).sin()).wave().unwrap();
    assert!(forward.speed_mps == 2.5 && forward.share > 0.98, "{forward:?}");
}

#[test]
fn noise_of_half_the_variance_halves_the_share() {
    // Independent of place and time: 20 vehicles, interpolated, lose a third of the noise's variance.
    let mut stream = rng::stream(1, "waves");
    let mut totals = WaveTotals::on_ring(STEP_S, RING_M);
    for step in 0..1800 {
        let time_s = step as f64 * STEP_S;
        let row: Vec<VehicleSample> = (0..20)
            .map(|i| {
                let position_m = f64::from(i) * 13.0;
                let wave_mps = (TAU * (position_m + 4.0 * time_s) / RING_M).sin();
                let noise_mps = stream.normal() * (0.5f64 * 1.5).sqrt();
                VehicleSample { speed_mps: 3.0 + wave_mps + noise_mps, position_m }
            })
            .collect();
        totals.add(row.into_iter());
    }
    let wave = totals.wave().unwrap();
    assert!(wave.speed_mps == -4.0 && (wave.share - 0.5).abs() < 0.05, "{wave:?}");
}

#[test]
fn no_wave_without_differences_positions_or_a_whole_window() {
    assert_eq!(ring(2, |_, _| 3.0).wave(), None);
    assert_eq!(ring(0, |x, _| x).wave(), None);
    let mut unknown = WaveTotals::on_ring(STEP_S, RING_M);
    (0..1200).for_each(|i| {
        unknown.add((0..3).map(|k| VehicleSample { speed_mps: f64::from(i % 7 + k), position_m: f64::NAN }));
    });
    assert_eq!(unknown.wave(), None);
}

#[test]
fn the_growth_of_an_exponential_wave_is_its_rate() {
    let growth =
        ring(6, |x, t| 3.0 + 0.1 * (0.5 * t / 60.0).exp() * (TAU * x / RING_M).sin()).growth_per_min().unwrap();
    assert!((growth - 0.5).abs() < 0.01, "{growth}");
    assert_eq!(ring(6, |_, _| 3.0).growth_per_min(), None);
}

#[test]
fn the_gain_of_a_first_order_filter_is_its_closed_form_despite_noise() {
    // The leader's speed is an AR(1) process; the follower's goes after it with a time constant of 2 s, with noise of its own.
    const TIME_CONSTANT_S: f64 = 2.0;
    let mut stream = rng::stream(2, "waves");
    let mut totals = WaveTotals::with_leaders(STEP_S, None, vec![None, Some(0)]);
    let (mut leader_mps, mut filtered_mps) = (0.0, 0.0);
    for _ in 0..100 * 600 {
        leader_mps = 0.98 * leader_mps + 0.2 * stream.normal();
        filtered_mps += STEP_S / TIME_CONSTANT_S * (leader_mps - filtered_mps);
        let speeds_mps = [leader_mps, filtered_mps + 0.3 * stream.normal()];
        totals.add(speeds_mps.into_iter().map(|v| VehicleSample { speed_mps: 10.0 + v, position_m: f64::NAN }));
    }
    for hz in [0.03, 0.06, 0.10, 0.15] {
        let expected = 1.0 / (1.0 + (TAU * hz * TIME_CONSTANT_S).powi(2)).sqrt();
        let gain = totals.gain(hz).unwrap();
        assert!((gain - expected).abs() < 0.03, "{hz} Hz: {gain}, expected {expected}");
    }
    assert_eq!((totals.gain(0.005), totals.wave()), (None, None));
}

#[test]
fn on_a_ring_each_vehicle_follows_the_next_one_ahead() {
    let row = [20.0, 255.0, 5.0].map(|position_m| VehicleSample { speed_mps: 1.0, position_m });
    assert_eq!(leaders_by_position(&row, Some(RING_M)), [Some(1), Some(2), Some(0)]);
}
