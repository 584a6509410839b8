//! Observers of drivers on fast rings: reaction time and time gap of simulated people after a minute of probed advice, in the three worlds,
//! against their true traits.

use super::{
    AdviceConfig, DriverConfig, FollowKind, NetworkConfig, RingConfig, TrainConfig, environment::VecEnv, simd::LANES,
};
use crate::{
    driver::{DriverParams, Population},
    idm::IdmParams,
    metrics::correlation,
    optimal_velocity::OptimalVelocityParams,
    policy::{
        Action, Probe,
        driver_observer::{LEADER_REACTION_S, RELAXATION_S, SAFE_FOLLOWERS},
    },
    traffic::{CarFollowing, TrafficDrivers},
    train::ActionKind,
};

/// Rings of a world, with people who are advised there.
fn world(traffic_drivers: &str, circumference_m: f64, vehicles: u32) -> TrainConfig {
    TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 1.0, ..AdviceConfig::default() },
        ring: RingConfig {
            traffic_drivers: traffic_drivers.into(),
            circumference_min_m: circumference_m,
            circumference_max_m: circumference_m,
            vehicles_min: vehicles,
            vehicles_max: vehicles,
            ..RingConfig::default()
        },
        driver: DriverConfig { follow: FollowKind::Driver, population: Population::People, ..DriverConfig::default() },
        network: NetworkConfig {
            sees: "observed_reaction,observed_time_gap_factor".into(),
            ..NetworkConfig::default()
        },
        ..TrainConfig::default()
    }
}

/// Returns the correlations of observed with true reaction times and time gaps after a minute in which `speed_mps` was advised, less in the
/// first third, with a square wave of this amplitude.
fn correlations(config: &TrainConfig, speed_mps: f64, amplitude_mps: f64) -> [f64; 2] {
    let probe = Probe { amplitude_mps, period_s: 4.0, duration_s: 60.0 };
    let (mut reactions, mut time_gaps) = (Vec::new(), Vec::new());
    for index in 0..12 {
        let mut block = VecEnv::new(config, "observed", index, config.hold());
        for second in 0..60 {
            let steady_mps = if second < 20 { speed_mps - 0.7 } else { speed_mps };
            let advice = probe.added_to(Action::Speed(steady_mps), f64::from(second), 1.0);
            block.hold(&[advice; LANES]);
        }
        for l in 0..LANES {
            let (seen, truth) = (block.observe(l).observed, block.drivers()[l]);
            reactions.push((truth.reaction_s, seen.reaction_s));
            time_gaps.push((truth.time_gap_factor, seen.time_gap_factor));
        }
    }
    [reactions, time_gaps].map(|pairs| correlation(&pairs).expect("people differ"))
}

#[test]
fn the_observer_assumes_the_drivers_that_there_are() {
    let CarFollowing::Idm(idm) = TrafficDrivers::named("safe-followers", IdmParams::default()).unwrap().typical().model
    else {
        panic!("people who follow safely have an IDM");
    };
    assert_eq!(SAFE_FOLLOWERS, (idm.t, idm.a));
    assert_eq!(RELAXATION_S, DriverParams::default().speed_relaxation_s);
    assert_eq!(LEADER_REACTION_S, DriverParams::default().leader_reaction_s);
    let CarFollowing::OptimalVelocity(model) =
        TrafficDrivers::named("gap-closers", IdmParams::default()).unwrap().typical().model
    else {
        panic!("people who close the gap have the optimal velocity model");
    };
    assert_eq!(model, OptimalVelocityParams::default());
}

#[test]
fn a_probe_tells_reaction_and_time_gap_of_people_within_a_minute() {
    // A trait counts as identified at a correlation of 0.8. The noise of people who follow safely hides their time gap: 0.5 is what is asked
    // there, more than three times what 192 people without any relation show by chance.
    for (drivers, circumference_m, vehicles, speed_mps, least) in [
        ("ring-study", 250.0, 22, 4.0, 0.8),
        ("safe-followers", 260.0, 20, 3.2, 0.5),
        ("gap-closers", 260.0, 21, 5.7, 0.8),
    ] {
        let config = world(drivers, circumference_m, vehicles);
        let [reaction, time_gap] = correlations(&config, speed_mps, 0.2);
        assert!(reaction > 0.8 && time_gap > least, "{drivers}: {reaction} {time_gap}");
        let [steady, _] = correlations(&config, speed_mps, 0.0);
        assert!(steady < reaction - 0.1, "{drivers}: steady advice hides the reaction time: {steady} {reaction}");
    }
}
