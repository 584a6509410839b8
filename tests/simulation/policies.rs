//! Shipped policies and their references: baselines of the field (docs/references.md: advice), and the trained policies of
//! `assets/policies`, on rings that neither has seen. 800 s after the warm-up, transients included.

use codrive::{
    driver::Population,
    metrics::EvaluationResult,
    policy::{self, Network, Policy, PolicySettings},
    scenario::AdvisedVehicles,
    settings::Settings,
    train::{AdviceConfig, DriverConfig, FollowKind, RingConfig, TrainConfig, evaluate},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Returns the paper's ring with its wave; the ego follows advice exactly but brakes where it must.
fn paper_ring(hold_s: f64) -> TrainConfig {
    TrainConfig {
        ring: RingConfig { circumference_min_m: 250.0, circumference_max_m: 250.0, ..RingConfig::default() },
        advice: AdviceConfig { hold_s, ..AdviceConfig::default() },
        driver: DriverConfig { brakes_for_leader: true, ..DriverConfig::default() },
        ..TrainConfig::default()
    }
}

/// Returns the paper's ring with a simulated driver of this reaction time and error.
fn driven(hold_s: f64, reaction_s: f64, error_mps: f64) -> TrainConfig {
    TrainConfig {
        driver: DriverConfig {
            follow: FollowKind::Driver,
            random_driver: false,
            reaction_s,
            error_mps,
            ..paper_ring(hold_s).driver
        },
        ..paper_ring(hold_s)
    }
}

fn mean(results: &[EvaluationResult], of: fn(&EvaluationResult) -> f64) -> f64 {
    results.iter().map(of).sum::<f64>() / results.len() as f64
}

/// Evaluates a policy by its name at the saturated wave, on 20 rings.
fn baseline(name: &str, aim_mps: f64, change: TrainConfig) -> Vec<EvaluationResult> {
    let settings = PolicySettings { aim_mps, equilibrium_mps: 4.362, step_s: 0.1 };
    let config = TrainConfig { ring: RingConfig { warm_up_s: 600.0, ..change.ring }, ..change };
    evaluate(&config, "baseline", 20, || policy::build(name, &settings).unwrap())
}

fn calm(results: &[EvaluationResult]) -> usize {
    results.iter().filter(|v| v.last_disturbance_s.is_some()).count()
}

#[test]
fn two_phase_advice_reaches_its_aim_and_calms_every_ring() {
    // docs/references.md: advice: U is reached exactly; calm after 85, 97 and 125 s; without the slow phase 4.43 fails at 3.20 m/s.
    for (aim_mps, calm_s) in [(4.0, 85.0), (4.3, 97.0), (4.43, 125.0)] {
        let results = baseline("two-phase", aim_mps, paper_ring(0.1));
        assert_eq!(calm(&results), 20, "{aim_mps}");
        let (settled, after) =
            (mean(&results, |v| v.settled_speed_mps), mean(&results, |v| v.last_disturbance_s.unwrap()));
        assert!((settled - aim_mps).abs() < 0.005, "{aim_mps}: {settled}");
        assert!((after - calm_s).abs() < 20.0, "{aim_mps}: {after} s");
    }
    let without = baseline("constant", 4.43, paper_ring(0.1));
    assert!(calm(&without) == 0 && (mean(&without, |v| v.mean_speed_mps) - 3.20).abs() < 0.05);
}

#[test]
fn follower_stopper_calms_every_ring_if_its_car_pulls_away_gently() {
    // docs/references.md: follower-stopper: 4.0 calm in 116 s, 4.3 in 159 s. This needs a car that pulls away at 0.3 m/s2. At 1.5 m/s2 it
    // chases the gaps that its own stops make, and 4.3 fails.
    let gentle = TrainConfig {
        driver: DriverConfig { ego_accel_mps2: 0.3, brakes_for_leader: false, ..paper_ring(0.1).driver },
        ..paper_ring(0.1)
    };
    for (aim_mps, latest_s) in [(4.0, 160.0), (4.3, 170.0)] {
        let results = baseline("follower-stopper", aim_mps, gentle.clone());
        assert_eq!(calm(&results), 20, "{aim_mps}");
        let (settled, after) =
            (mean(&results, |v| v.settled_speed_mps), mean(&results, |v| v.last_disturbance_s.unwrap()));
        assert!((settled - aim_mps).abs() < 0.02, "{aim_mps}: {settled}");
        assert!(after < latest_s, "{aim_mps}: {after} s");
    }
    let brisk = TrainConfig { driver: DriverConfig { ego_accel_mps2: 1.5, ..gentle.driver }, ..gentle };
    assert_eq!(calm(&baseline("follower-stopper", 4.3, brisk)), 0);
}

#[test]
fn pi_with_saturation_calms_the_ring_where_it_is_engaged_moving() {
    // docs/references.md: pi: 4.34 m/s when engaged while moving. An ego that keeps the model's own distance reaches it on every ring. One
    // that follows exactly with a vehicle's lag of 1 s settles at the same speed if its gap was below about 5.5 m.
    let settled = |results: &[EvaluationResult]| {
        assert!(results.iter().all(|v| !v.crashed));
        let calmed: Vec<EvaluationResult> =
            results.iter().copied().filter(|v| v.last_disturbance_s.is_some()).collect();
        let settled_mps = mean(&calmed, |v| v.settled_speed_mps);
        assert!((settled_mps - 4.34).abs() < 0.01, "{settled_mps}");
        calmed.len()
    };
    assert_eq!(settled(&baseline("pi", 0.0, driven(0.1, 0.0, 0.0))), 20);
    let calmed = settled(&baseline(
        "pi",
        0.0,
        TrainConfig { driver: DriverConfig { ego_response_s: 1.0, ..paper_ring(0.1).driver }, ..paper_ring(0.1) },
    ));
    assert!(calmed >= 18, "{calmed}");
    // An ego that follows exactly and at once copies its leader for ever (docs/references.md: pi: 3.13 in the jam).
    assert_eq!(calm(&baseline("pi", 0.0, paper_ring(0.1))), 0);
}

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/policies")
}

/// Returns the folders of all shipped policies.
fn shipped() -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> =
        fs::read_dir(assets()).unwrap().map(|e| e.unwrap().path()).filter(|p| p.join("policy.toml").exists()).collect();
    folders.sort();
    assert!(!folders.is_empty());
    folders
}

/// Checks the ONNX files of a policy. With `CODRIVE_WRITE_ONNX` it writes them first, for a policy trained before the format changed.
#[cfg(feature = "onnx")]
fn is_the_same_in_onnx(folder: &Path, network: &Network) {
    use codrive::policy::onnx;
    let mut files = vec![("policy.onnx", onnx::write(network))];
    files.extend(network.estimator.as_ref().map(|estimator| ("estimator.onnx", onnx::write_estimator(estimator))));
    for (name, bytes) in files {
        let file = folder.join(name);
        if std::env::var_os("CODRIVE_WRITE_ONNX").is_some() {
            fs::write(&file, &bytes).unwrap();
        }
        assert!(fs::read(&file).unwrap() == bytes, "{}", file.display());
    }
}

#[test]
fn shipped_policies_are_equal_in_both_formats_and_have_configurations() {
    for folder in shipped() {
        let network = Network::from_file(&folder.join("policy.toml")).unwrap();
        #[cfg(feature = "onnx")]
        is_the_same_in_onnx(&folder, &network);
        let config: TrainConfig = toml::from_str(&fs::read_to_string(folder.join("train.toml")).unwrap()).unwrap();
        config.check().unwrap();
        assert_eq!((network.holds_s, &network.inputs), (config.holds_s(), &config.inputs()));
        assert!(folder.join("curve.csv").exists() && folder.join("curve.svg").exists());
    }
}

/// Evaluates a shipped policy on 20 fresh rings.
fn driven_by(name: &str, config: &TrainConfig) -> Vec<EvaluationResult> {
    driven_on(name, config, 20)
}

fn driven_on(name: &str, config: &TrainConfig, rings: usize) -> Vec<EvaluationResult> {
    let network = Network::from_file(&assets().join(name).join("policy.toml")).unwrap();
    let make = || -> Option<Box<dyn Policy>> { Some(network.clone().policy(0.1)) };
    let results = evaluate(config, "shipped", rings, make);
    assert!(results.iter().all(|v| !v.crashed), "{name}");
    results
}

#[test]
fn speed_advice_reaches_4_2_at_every_hold_up_to_30_s() {
    for hold_s in [0.1, 1.0, 5.0, 10.0, 20.0, 30.0] {
        let results = driven_by("ring-250-speed", &paper_ring(hold_s));
        let speed = mean(&results, |v| v.mean_speed_mps);
        assert!(speed >= 4.2, "hold {hold_s} s: {speed}");
        // This driver also keeps the model's own distance: an even ring would flow at 4.362.
        let results = driven_by("ring-250-speed", &driven(hold_s, 0.0, 0.0));
        let (speed, in_range) = (mean(&results, |v| v.mean_speed_mps), mean(&results, |v| v.time_in_range.unwrap()));
        assert!(speed >= 4.17 && in_range > 0.8, "hold {hold_s} s, driver: {speed}, in range {in_range}");
        let results = driven_by("ring-250-speed", &driven(hold_s, 1.0, 0.5));
        let speed = mean(&results, |v| v.mean_speed_mps);
        assert!(speed >= 4.0, "hold {hold_s} s, late and inexact driver: {speed}");
    }
}

#[test]
fn exact_speed_advice_exceeds_the_published_series_at_every_hold() {
    for [hold_s, published_mps] in codrive::metrics::figures::PUBLISHED.into_iter().filter(|p| p[0] <= 24.0) {
        let speed = mean(&driven_by("ring-250-speed-exact", &paper_ring(hold_s)), |v| v.mean_speed_mps);
        assert!(speed >= published_mps, "hold {hold_s} s: {speed}, published {published_mps}");
    }
}

#[test]
fn acceleration_advice_lets_no_driver_stand_for_ever() {
    // The first shipped policy advised 0.00 m/s for ever to a driver who responded late.
    for hold_s in [0.1, 1.0, 10.0, 30.0] {
        for config in [driven(hold_s, 0.0, 0.0), driven(hold_s, 1.0, 0.5), driven(hold_s, 2.0, 0.5)] {
            let results = driven_by("ring-250-acceleration", &config);
            let slowest = results.iter().map(|v| v.settled_speed_mps).fold(f64::INFINITY, f64::min);
            assert!(slowest > 3.0, "hold {hold_s} s, reaction {} s: {slowest}", config.driver.reaction_s);
        }
    }
}

#[test]
fn shipped_policies_help_on_other_rings_without_training_anew() {
    for (length_m, cars) in [(210.0, 18), (230.0, 24), (270.0, 20), (290.0, 26)] {
        let ring = ring_of(length_m, cars, driven(10.0, 0.0, 0.0));
        let without = mean(&evaluate(&ring, "shipped", 20, || None), |v| v.mean_speed_mps);
        for name in ["ring-250-speed", "ring-250-acceleration"] {
            let with = mean(&driven_by(name, &ring), |v| v.mean_speed_mps);
            assert!(with > without + 0.3, "{name}, {length_m} m, {cars} cars: {with} against {without}");
        }
    }
}

/// Returns a ring of this length with this number of vehicles.
fn ring_of(length_m: f64, cars: u32, base: TrainConfig) -> TrainConfig {
    TrainConfig {
        ring: RingConfig {
            circumference_min_m: length_m,
            circumference_max_m: length_m,
            vehicles_min: cars,
            vehicles_max: cars,
            ..base.ring
        },
        ..base
    }
}

const SHIPPED_FOR_250_M: [&str; 2] = ["ring-250-speed", "ring-250-acceleration"];

#[test]
fn advice_is_never_worse_than_none_on_ten_rings_of_210_to_290_m() {
    // These are the corners, and the densest rings on which advice is given, from 8.7 m of road per vehicle on. There the flow is slow, and
    // a driver with errors wastes part of the little road. On each of them both policies advise and help.
    let corners = [(210.0, 18), (290.0, 18), (290.0, 26)];
    let dense = [(210.0, 24), (230.0, 26)];
    // The gain of 0.01 m/s exceeds rounding and chance over 16 rings. The rings in between must have no loss.
    let gain = corners.into_iter().chain(dense).map(|ring| (ring, 0.01));
    let between = [(227.0, 26), (220.0, 25), (225.0, 25), (215.0, 24), (240.0, 26)];
    for ((length_m, cars), least_mps) in gain.chain(between.map(|ring| (ring, 0.0))) {
        for (hold_s, reaction_s, error_mps) in [(1.0, 1.0, 0.5), (10.0, 0.0, 0.0), (30.0, 1.0, 0.5)] {
            let ring = ring_of(length_m, cars, driven(hold_s, reaction_s, error_mps));
            let without = mean(&evaluate(&ring, "shipped", 16, || None), |v| v.mean_speed_mps);
            for name in SHIPPED_FOR_250_M {
                let results = driven_on(name, &ring, 16);
                let with = mean(&results, |v| v.mean_speed_mps);
                let where_ = format!("{name}, {length_m} m, {cars} cars, {hold_s} s, {error_mps} m/s");
                assert!(results.iter().all(|v| v.time_in_range.is_some()), "{where_}: silent");
                assert!(with > without + least_mps, "{where_}: {with} against {without}");
            }
        }
    }
}

#[test]
fn on_a_ring_too_dense_for_advice_a_policy_changes_no_bit() {
    // There is less than 8.7 m of road per vehicle, of which the vehicle itself takes 5.
    for (length_m, cars) in [(210.0, 26), (220.0, 26), (210.0, 25), (215.0, 25), (225.0, 26)] {
        let ring = ring_of(length_m, cars, driven(10.0, 0.0, 0.0));
        let without = evaluate(&ring, "shipped", 16, || None);
        for name in SHIPPED_FOR_250_M {
            assert_eq!(driven_on(name, &ring, 16), without, "{name}, {length_m} m, {cars} cars");
        }
    }
}

#[test]
fn policies_of_the_long_ring_recover_over_half_of_the_waves_loss() {
    // docs/references.md: ring: 640.9 m, 40 cars, 17.88 m/s: 6.05 m/s in the wave, 8.956 m/s in an even flow.
    let (wave_mps, even_mps) = (6.05, 8.956);
    for (hold_s, reaction_s, error_mps) in [(4.0, 1.0, 0.5), (10.0, 0.0, 0.0), (30.0, 1.0, 0.5)] {
        let base = TrainConfig {
            ring: RingConfig { warm_up_s: 600.0, ..driven(hold_s, reaction_s, error_mps).ring },
            ..driven(hold_s, reaction_s, error_mps)
        };
        let mut ring = ring_of(640.9, 40, base);
        ring.ring.idm.v0 = 17.88;
        let without = mean(&evaluate(&ring, "shipped", 16, || None), |v| v.mean_speed_mps);
        assert!((without - wave_mps).abs() < 0.15, "{without}: that is not the wave");
        for name in ["ring-641-speed", "ring-641-acceleration"] {
            let with = mean(&driven_on(name, &ring, 16), |v| v.mean_speed_mps);
            assert!(with > 0.5 * (wave_mps + even_mps), "{name}, hold {hold_s} s: {with}");
        }
    }
}

#[test]
fn an_observed_late_driver_brings_the_ring_to_4_18_and_stays_in_range() {
    // Advice that does not observe the driver brings the late one to 4.07 m/s (assets/policies/README.md). The goals are 4.18 m/s with 60 % of
    // the time in range, and a probe that costs less than 0.01 m/s.
    let late = driven(1.0, 1.0, 0.5);
    let late = TrainConfig { driver: DriverConfig { leader_reaction_s: 0.7, ..late.driver }, ..late };
    let network = Network::from_file(&assets().join("ring-250-observing/policy.toml")).unwrap();
    let driven_with = |network: &Network| {
        let results = evaluate(&late, "shipped", 64, || Some(network.clone().policy(0.1)));
        assert!(results.iter().all(|v| !v.crashed));
        [mean(&results, |v| v.mean_speed_mps), mean(&results, |v| v.time_in_range.unwrap())]
    };
    let [speed_mps, in_range] = driven_with(&network);
    assert!(speed_mps >= 4.18 && in_range >= 0.6, "{speed_mps}, in range {in_range}");
    assert!(network.probe.is_some(), "the driver is probed");
    let [unprobed_mps, _] = driven_with(&Network { probe: None, ..network });
    assert!(unprobed_mps - speed_mps < 0.01, "the probe costs {} m/s", unprobed_mps - speed_mps);
}

#[test]
fn personal_advice_does_no_harm_to_drivers_whom_generic_advice_harms() {
    // PeRP's drivers are up to 5 m/s slower or faster than advised: a driver 5 m/s below an advice of 4 stands.
    let config = driven(10.0, 0.0, 0.0).driven_by_some_of(Population::Perp);
    let mean_of = |results: &[EvaluationResult]| mean(results, |v| v.mean_speed_mps);
    let without = mean_of(&evaluate(&config, "shipped", 64, || None));
    let generic = mean_of(&driven_on("ring-250-speed", &config, 64));
    let network = Network::from_file(&assets().join("ring-250-personal/policy.toml")).unwrap();
    let personal = evaluate(&config, "shipped", 64, || Some(network.clone().policy(0.1)));
    assert!(personal.iter().all(|v| !v.crashed));
    let personal = mean_of(&personal);
    assert!(generic < without && personal >= without, "none {without}, generic {generic}, personal {personal}");
}

/// Drivers of the other vehicles of a world, and the vehicles on its ring of 260 m, as in the benchmark `worlds`.
const WORLDS: [(&str, u32); 3] = [("ring-study", 21), ("safe-followers", 20), ("gap-closers", 21)];

/// Returns the ring of a world with people in the advised vehicles.
fn people_among(traffic_drivers: &str, vehicles: u32, hold_s: f64) -> TrainConfig {
    let mut config = ring_of(260.0, vehicles, driven(hold_s, 1.0, 0.35)).driven_by_some_of(Population::People);
    config.ring.traffic_drivers = traffic_drivers.into();
    config
}

#[test]
fn advice_for_people_halves_the_waves_of_gap_closers_and_costs_no_speed() {
    // `ring-250-speed`, trained among the ring study's vehicles, takes a tenth of the mean speed of people who close the gap. A policy for
    // people halves the deviation over the vehicles in both worlds with strong waves, and takes no speed there. Among people who follow safely,
    // where no advice gains, it may take 2 % (0.06 m/s): a third of the smallest effect that the study with it asks for.
    for ((traffic_drivers, vehicles), [most_sd, least_mean]) in
        WORLDS.into_iter().zip([[0.5, 1.0], [1.0, 0.98], [0.5, 1.0]])
    {
        let config = people_among(traffic_drivers, vehicles, 5.0);
        let without = evaluate(&config, "shipped", 64, || None);
        let with = driven_on("ring-260-people", &config, 64);
        let share = |of: fn(&EvaluationResult) -> f64| mean(&with, of) / mean(&without, of);
        let shares = [share(|v| v.speed_sd_over_vehicles_mps), share(|v| v.mean_speed_mps)];
        assert!(shares[0] <= most_sd && shares[1] >= least_mean, "{traffic_drivers}: {shares:?}");
    }
}

#[test]
fn at_no_share_is_a_policy_that_was_made_for_it_worse_than_none() {
    // Where many have it, a policy for one vehicle can take three quarters of the mean speed (docs/results.md: several advised vehicles). A
    // loss below 0.01 m/s is less than fifty rings can tell from none.
    let folder = assets().join("../benchmarks/shares");
    let shares = [5, 10, 25, 50, 100];
    for ((world, vehicles), percent) in WORLDS.into_iter().flat_map(|world| shares.map(|percent| (world, percent))) {
        let network = Network::from_file(&folder.join(format!("{world}-{percent}.toml"))).unwrap();
        assert_eq!(network.advised_share, f64::from(percent) / 100.0);
        let mut config = people_among(world, vehicles, 1.0);
        config.ring.advised = AdvisedVehicles::Share(network.advised_share);
        let without = evaluate(&config, "shipped", 16, || None);
        let with = evaluate(&config, "shipped", 16, || Some(network.clone().policy(0.1)));
        assert!(with.iter().all(|drive| !drive.crashed), "{world}, {percent} %");
        let gains: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a.mean_speed_mps - b.mean_speed_mps).collect();
        let gain = gains.iter().sum::<f64>() / 16.0;
        let variance = gains.iter().map(|one| (one - gain).powi(2)).sum::<f64>() / 15.0;
        // Two standard errors below the mean.
        assert!(gain - 2.0 * (variance / 16.0).sqrt() > -0.01, "{world}, {percent} %: {gains:?}");
    }
}
