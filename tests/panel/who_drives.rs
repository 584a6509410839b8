//! Driver of the ego, as a policy estimates and observes them, in the experimenter's window.

use crate::experimenter::{Bench, harness};
use codrive::policy::{Advice, DriverEstimate, DriverTraits, ObservedDriver};
use egui_kittest::kittest::Queryable;

#[test]
fn the_driver_estimate_is_shown_with_its_uncertainty_if_there_is_one() {
    let mut bench = Bench::after(600);
    let mut panel = harness(Bench::after(600), [1400.0, 1900.0], 1.0);
    panel.run();
    assert!(panel.query_by_label_contains("as estimated by the policy").is_none());
    let mean =
        DriverTraits { reaction_s: 1.25, speed_bias_mps: -0.5, error_mps: 0.3, time_gap_factor: 1.1, willingness: 0.9 };
    let sd =
        DriverTraits { reaction_s: 0.5, speed_bias_mps: 0.25, error_mps: 0.1, time_gap_factor: 0.2, willingness: 0.05 };
    bench.now.advice = bench.now.advice.map(|advice| Advice { driver: Some(DriverEstimate { mean, sd }), ..advice });
    let mut panel = harness(bench, [1400.0, 1900.0], 1.0);
    panel.run();
    panel.get_by_label_contains("as estimated by the policy");
    for words in ["1.25 ± 0.50 s", "-0.50 ± 0.25 m/s", "0.30 ± 0.10 m/s", "1.10 ± 0.20", "90 ± 5 %"] {
        panel.get_by_label_contains(words);
    }
}

#[test]
fn the_observed_driver_is_shown_if_the_policy_observes() {
    let mut bench = Bench::after(600);
    let mut panel = harness(Bench::after(600), [1400.0, 1900.0], 1.0);
    panel.run();
    assert!(panel.query_by_label_contains("as observed").is_none());
    let observed = Some(ObservedDriver { deviation_mps: -0.25, reaction_s: 1.5, time_gap_factor: 0.9 });
    bench.now.advice = bench.now.advice.map(|advice| Advice { observed, ..advice });
    let mut panel = harness(bench, [1400.0, 1900.0], 1.0);
    panel.run();
    panel.get_by_label_contains("as observed from speed and advice");
    for words in ["1.50 s", "-0.25 m/s now", "0.90 × the others"] {
        panel.get_by_label_contains(words);
    }
}
