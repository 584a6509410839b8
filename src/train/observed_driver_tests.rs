//! Observers of drivers on fast rings: reaction time and time gap of simulated people after a minute of probed advice, in the three worlds,
//! against their true traits.

use super::{
    AdviceConfig, DriverConfig, FollowKind, NetworkConfig, RingConfig, TrainConfig, environment::VecEnv, simd::LANES,
};
use crate::{
    driver::Population,
    metrics::correlation,
    policy::{Action, Probe},
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
fn a_probe_tells_reaction_and_time_gap_of_people_within_a_minute() {
    // A trait counts as identified at a correlation of 0.8.
    for (drivers, circumference_m, vehicles, speed_mps) in
        [("ring-study", 250.0, 22, 4.0), ("safe-followers", 260.0, 20, 3.2)]
    {
        let config = world(drivers, circumference_m, vehicles);
        let [reaction, time_gap] = correlations(&config, speed_mps, 0.2);
        assert!(reaction > 0.8 && time_gap > 0.8, "{drivers}: {reaction} {time_gap}");
        let [steady, _] = correlations(&config, speed_mps, 0.0);
        assert!(steady < reaction - 0.1, "{drivers}: steady advice hides the reaction time: {steady} {reaction}");
    }
    // Advice of 5.7 m/s holds most people back among those who close the gap. They seldom show their time gap there.
    let [reaction, time_gap] = correlations(&world("gap-closers", 260.0, 21), 5.7, 0.2);
    assert!(reaction > 0.8 && time_gap > 0.5, "{reaction} {time_gap}");
}
