//! Corrected advice: its files, what is refused, and the sum.

use super::*;
use crate::policy::{
    Action, DriverEstimator, ExpectedGain, Feature, NetworkInput, NetworkLayer, PiParameters, PolicySettings, Probe,
};

/// Returns a network that advises half of the leader's speed, within 0 to 10 m/s.
fn half_the_leaders() -> Network {
    let inputs = vec![NetworkInput { feature: Feature::LeaderSpeed, from: 0.0, to: 10.0 }];
    // Maps the leader's -1..1 to -1..0 of the advice.
    Network::advising_speed(inputs, vec![NetworkLayer { bias: vec![-0.5], weights: vec![vec![0.5]] }])
}

/// Returns a network whose correction is 1 m/s minus a tenth of the corrected speed, within 2 m/s either way.
fn correction(corrected: CorrectedAdvice) -> Network {
    Network {
        limits: [-2.0, 2.0],
        inputs: vec![NetworkInput { feature: Feature::ControllerSpeed, from: 0.0, to: 10.0 }],
        layers: vec![NetworkLayer { bias: vec![0.25], weights: vec![vec![-0.25]] }],
        corrected: Some(corrected),
        ..half_the_leaders()
    }
}

fn over(network: Network) -> Network {
    correction(CorrectedAdvice::Network(network.into()))
}

#[test]
fn corrected_advice_survives_the_round_trip_through_files() {
    // A number without a short decimal form.
    let mut network = half_the_leaders();
    network.layers[0].weights[0][0] = 1.0 / 3.0;
    for corrected in
        [CorrectedAdvice::Network(network.into()), CorrectedAdvice::Controller(Controller::Pi(PiParameters::default()))]
    {
        let whole = correction(corrected.clone());
        assert_eq!(Network::from_toml(&whole.to_toml()).unwrap(), whole);
        // As in a checkpoint, and as in the description of an ONNX network.
        let checkpoint = serde_json::to_string(&corrected).unwrap();
        assert_eq!(serde_json::from_str::<CorrectedAdvice>(&checkpoint).unwrap(), corrected);
        let described = toml::to_string(&whole).unwrap();
        assert_eq!(Network::from_toml(&described).unwrap(), whole);
    }
}

#[test]
fn the_correction_is_added_to_what_the_network_advises() {
    let mut policy = over(half_the_leaders()).policy(0.1);
    for (leader_mps, corrected_mps) in [(0.0, 0.0), (4.0, 2.0), (10.0, 5.0)] {
        let seen = Observation { leader_speed_mps: leader_mps, speed_mps: 7.0, ..Observation::default() };
        let Action::Speed(advised_mps) = policy.act(0.0, &seen) else { panic!("a speed policy") };
        let expected_mps = corrected_mps + 1.0 - 0.1 * corrected_mps;
        assert!((advised_mps - expected_mps).abs() < 1e-5, "{leader_mps}: {advised_mps}");
    }
}

#[test]
fn a_corrected_network_sees_an_untrained_hold_as_the_nearest_trained_one() {
    let log_hold = NetworkInput { feature: Feature::LogHold, from: 0.0, to: 4.0_f64.ln() };
    let network = Network { holds_s: [4.0, 30.0], inputs: vec![log_hold], ..half_the_leaders() };
    let corrected = EngagedAdvice::new(&CorrectedAdvice::Network(network.into()), 0.1);
    let at = |hold_s: f64| corrected.speed_mps(0.0, &Observation { hold_s, ..Observation::default() });
    assert_eq!(at(0.1), at(4.0));
    assert!(at(8.0) > at(4.0));
}

#[test]
fn a_network_that_does_not_stand_alone_is_refused_by_name_with_the_remedy() {
    let layers = vec![NetworkLayer { bias: vec![0.0], weights: vec![vec![1.0]] }];
    let spacing = NetworkInput { feature: Feature::Spacing, from: 8.0, to: 16.0 };
    let gain = ExpectedGain { silent_below_mps: 0.0, inputs: vec![spacing], layers };
    let input = NetworkInput { feature: Feature::Reaction, from: 0.0, to: 2.0 };
    let alone = half_the_leaders;
    for (network, expected) in [
        (over(alone()), "corrects another advice itself\n  remedy: name a speed policy that stands alone"),
        (Network { inputs: vec![input], ..alone() }, "needs the driver's traits\n  remedy"),
        (Network { expected_gain: Some(gain), ..alone() }, "withholds advice where it expects no gain\n  remedy"),
        (Network { action: NetworkOutput::Acceleration, ..alone() }, "advises an acceleration"),
        (
            Network { least_spacing_m: 8.7, ..alone() },
            "below 8.7 m of road per vehicle, its correction below 0 m\n  remedy: train the correction with \
             least_spacing_m = 8.7 or more",
        ),
        (Network { limits: [1.0, 1.0], ..alone() }, ": limits are 1 to 1"),
    ] {
        // Serialised in full, as another program could write it: our own writer leaves out what cannot be read.
        let text = toml::to_string(&over(network)).unwrap();
        let refused = Network::from_toml(&text).unwrap_err().to_string();
        assert!(refused.contains(": the network that is corrected"), "{refused}");
        assert!(refused.contains(expected), "{refused}");
    }
    let bounded = Network { least_spacing_m: 8.7, ..alone() };
    let both = Network { least_spacing_m: 8.7, ..over(bounded) };
    assert!(Network::from_toml(&both.to_toml()).is_ok());
    let of_acceleration = Network { action: NetworkOutput::Acceleration, ..over(alone()) };
    let refused = of_acceleration.check().unwrap_err().to_string();
    assert_eq!(refused, "only a policy whose action is \"speed\" can correct a controller or a network");
    let probe = Some(Probe { amplitude_mps: 0.2, period_s: 4.0, duration_s: 60.0 });
    assert_eq!(stands_alone(&Network { probe, ..alone() }), Err(NotCorrectable::Probes));
    let estimator: Option<DriverEstimator> = Network::from_file(&shipped_file("ring-250-personal")).unwrap().estimator;
    let asks = Network { estimator, ..alone() };
    assert_eq!(stands_alone(&asks), Err(NotCorrectable::AsksWhoDrives));
}

fn shipped_file(name: &str) -> std::path::PathBuf {
    crate::policy::file_of(name).unwrap()
}

#[test]
fn corrected_advice_is_found_by_name_or_file_or_refused_by_name() {
    let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps: 8.956, step_s: 0.1 };
    let read = |name: &str| CorrectedAdvice::read(name, &settings);
    assert!(matches!(read("pi"), Ok(CorrectedAdvice::Controller(Controller::Pi(_)))));
    let by_name = read("ring-641-speed").unwrap();
    assert!(matches!(by_name, CorrectedAdvice::Network(_)));
    assert_eq!(read(&shipped_file("ring-641-speed").display().to_string()).unwrap(), by_name);
    for (name, expected) in [
        ("ring-641-sped", "`ring-641-sped` is unknown (did you mean ring-641-speed?); allowed: constant, two-phase,"),
        ("none", "`none` is unknown"),
        ("ring-641-acceleration", "policy ring-641-acceleration advises an acceleration"),
        ("ring-250-personal", "policy ring-250-personal corrects another advice itself\n  remedy: name a speed policy"),
        ("policy.onnx", "remedy: name its policy.toml"),
        ("not-there.toml", "not-there.toml: cannot be read"),
    ] {
        let refused = read(name).unwrap_err().to_string();
        assert!(refused.contains(expected), "{refused}");
    }
}
