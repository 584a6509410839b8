//! The estimator in a drive: hand-computed arithmetic, update rate, file, and inconsistent parts.

use super::*;
use crate::policy::{Feature, Network, NetworkLayer, Observation};

/// Returns an estimator with `units` units and irregular weights.
fn small(units: usize) -> DriverEstimator {
    let numbers =
        |n: usize, salt: usize| -> Vec<f32> { (0..n).map(|i| ((i * 7 + salt) % 11) as f32 / 9.0 - 0.5).collect() };
    let matrix = |n: usize, m: usize, salt: usize| (0..n).map(|i| numbers(m, salt + 3 * i)).collect();
    let traits = DriverTraits::NAMES.map(|name| EstimatedTrait { name: name.into(), centre: 1.0, spread: 0.5 });
    DriverEstimator {
        traits: traits.to_vec(),
        bias: numbers(GATES * units, 1),
        state_bias: numbers(GATES * units, 2),
        weights: matrix(INPUTS, GATES * units, 3),
        state_weights: matrix(units, GATES * units, 4),
        readout: NetworkLayer { bias: numbers(2 * TRAITS, 5), weights: matrix(units, 2 * TRAITS, 6) },
    }
}

fn seen(speed_mps: f64) -> Observation {
    let advised_mps = Some(4.0);
    Observation { speed_mps, leader_speed_mps: 4.0, gap_m: 10.0, advised_mps, ..Observation::default() }
}

#[test]
fn one_unit_steps_as_the_published_equations_say() {
    let mut estimator = small(1);
    estimator.weights = vec![vec![0.0; GATES]; INPUTS];
    estimator.weights[0] = vec![0.5, -0.25, 1.0];
    estimator.state_weights = vec![vec![0.3, 0.2, -0.7]];
    estimator.bias = vec![0.1, 0.2, 0.3];
    estimator.state_bias = vec![0.4, 0.5, 0.6];
    let mut unit = estimator.begin();
    let mut inputs = vec![0.0; INPUTS];
    inputs[0] = 1.0;
    estimator.step(&inputs, &mut unit);
    // By hand, h = 0: r = s(0.6 + 0.4) = 0.731059, z = s(-0.05 + 0.5) = 0.610639, n = tanh(1.3 + 0.731059 x 0.6) = 0.940068; h = (1 - z)
    // n = 0.366026.
    assert!((unit.state()[0] - 0.366_026).abs() < 2e-6, "{}", unit.state()[0]);
    estimator.step(&inputs, &mut unit);
    // r = s(1.0 + 0.3 h) = 0.752093, z = s(0.45 + 0.2 h) = 0.627897, n = tanh(1.3 + r (0.6 - 0.7 h)) = 0.915186; (1 - z) n + z h =
    // 0.570370.
    assert!((unit.state()[0] - 0.570_370).abs() < 2e-6, "{}", unit.state()[0]);
}

#[test]
fn the_estimate_changes_once_a_second_for_any_step_length() {
    for (step_s, steps_per_s) in [(0.1, 10), (0.2, 5), (0.05, 20)] {
        let mut driver = Identification::new(small(3));
        let begin = driver.clone();
        let speed = |k: u64| 3.0 + (k as f64 * step_s).sin();
        for k in 0..steps_per_s {
            driver.watch(&seen(speed(k)), step_s);
            assert_eq!(driver.who_drives(), begin.who_drives(), "not before a second has passed");
        }
        driver.watch(&seen(speed(steps_per_s)), step_s);
        assert_ne!(driver.who_drives(), begin.who_drives());
    }
}

#[test]
fn an_estimator_survives_the_round_trip_through_its_file() {
    let estimator = small(3);
    assert_eq!(estimator.check(), Ok(()));
    let mut text = String::new();
    estimator.write(&mut text);
    #[derive(serde::Deserialize)]
    struct File {
        estimator: DriverEstimator,
    }
    assert_eq!(toml::from_str::<File>(&text).map(|file| file.estimator), Ok(estimator));
}

#[test]
fn an_inconsistent_estimator_is_refused_with_the_part() {
    let fault = |change: fn(&mut DriverEstimator)| {
        let mut estimator = small(3);
        change(&mut estimator);
        estimator.check().unwrap_err().to_string()
    };
    assert!(
        fault(|e| e.traits.truncate(4))
            .starts_with("the estimator's traits are reaction_s, speed_bias_mps, error_mps, time")
    );
    assert!(fault(|e| e.traits[1].spread = 0.0).contains("trait speed_bias_mps has no valid centre and spread"));
    assert_eq!(fault(|e| _ = e.weights.pop()), "the estimator's weights are 20 x 9 numbers; allowed: 21 x 9");
    assert_eq!(fault(|e| _ = e.weights[2].pop()), "the estimator's weights are 21 x 8 numbers; allowed: 21 x 9");
    assert_eq!(
        fault(|e| e.readout.bias[0] = f32::NAN),
        "the estimator's readout.bias hold a number that is not finite"
    );
    assert!(fault(|e| e.state_weights.clear()).starts_with("the estimator's bias are 1 x"));
}

#[test]
fn latents_are_read_out_unscaled_and_leave_the_traits_alone() {
    let mut estimator = small(3);
    estimator.traits = vec![EstimatedTrait::latent(0), EstimatedTrait::latent(1)];
    let fault = estimator.check().unwrap_err().to_string();
    assert_eq!(fault, "the estimator's readout.bias are 1 x 10 numbers; allowed: 1 x 4");
    estimator.readout = NetworkLayer { bias: vec![0.5, -2.0, 0.0, -9.0], weights: vec![vec![0.0; 4]; 3] };
    assert_eq!(estimator.check(), Ok(()));
    let message = Identification::new(estimator.clone()).who_drives();
    let latents = message.latents().expect("latents");
    assert_eq!((latents.count, latents.mean), (2, [0.5, -2.0, 0.0, 0.0]));
    // The logarithm of a standard deviation is clamped to its bounds, here -3.
    assert!((latents.sd[0] - 1.0).abs() < 1e-6 && (latents.sd[1] - (-3.0_f64).exp()).abs() < 1e-6, "{latents:?}");
    assert_eq!(message.traits(), None);
    let truth = DriverTraits::default();
    let seen = message.complete_observation(&Observation { driver: Some(truth), ..seen(3.0) });
    assert_eq!((seen.latents, seen.driver), ([0.5, -2.0, 0.0, 0.0], Some(truth)));
    estimator.traits.swap(0, 1);
    let fault = estimator.check().unwrap_err().to_string();
    assert!(fault.starts_with("the estimator's traits are latent_2, latent_1; allowed: reaction_s, "), "{fault}");
    assert!(fault.ends_with("willingness, or latent_1 to at most latent_4"), "{fault}");
}

#[test]
fn a_policy_with_an_input_that_its_estimator_lacks_is_refused() {
    let traits = small(3);
    let mut latents = small(3);
    latents.traits = vec![EstimatedTrait::latent(0), EstimatedTrait::latent(1)];
    let fault = |estimator: &DriverEstimator, features: &[Feature]| {
        estimator.check_tells(features.iter().copied()).map_err(|fault| fault.to_string())
    };
    assert_eq!(fault(&traits, &[Feature::Speed, Feature::Reaction, Feature::Willingness]), Ok(()));
    assert_eq!(fault(&latents, &[Feature::Gap, Feature::Latent1, Feature::Latent2]), Ok(()));
    let message = fault(&traits, &[Feature::Reaction, Feature::Latent1]).unwrap_err();
    assert!(
        message
            .starts_with("the policy sees latent_1, which its estimator does not estimate; it estimates reaction_s, "),
        "{message}"
    );
    let message = fault(&latents, &[Feature::Latent2, Feature::Latent3]).unwrap_err();
    assert!(message.starts_with(
        "the policy sees latent_3, which its estimator does not estimate; it estimates latent_1, latent_2"
    ));
    assert!(fault(&latents, &[Feature::SpeedBias]).unwrap_err().starts_with("the policy sees speed_bias, "));
    let file = concat!(env!("CODRIVE_ROOT"), "/assets/benchmarks/ring/variational/seed-1.toml");
    let text = std::fs::read_to_string(file).unwrap();
    assert!(Network::from_toml(&text).is_ok());
    let message = Network::from_toml(&text.replacen("\"latent_2\"", "\"willingness\"", 1)).unwrap_err().to_string();
    assert!(message.contains(": the policy sees willingness, which its estimator does not estimate"), "{message}");
}
