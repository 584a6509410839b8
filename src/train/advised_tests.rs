//! Several advised vehicles of a ring: against a plain simulation in double precision, by symmetry, and against one advised vehicle.

use super::{
    ActionKind, AdviceConfig, DriverConfig, FollowKind, Learner, NetworkConfig, RewardConfig, RingConfig, RunConfig,
    TrainConfig,
    environment::VecEnv,
    evaluate, evaluate_jointly,
    learner_tests::bits,
    outcome::{Ending, Outcome},
    simd::LANES,
};
use crate::{
    idm::IdmParams,
    policy::{Action, ConstantSpeed, Observation, Policy, WholeRing},
    scenario::AdvisedVehicles,
    settings::{Settings, from_toml},
    space::CAR_LENGTH_M,
};
use std::convert::Infallible;

const VEHICLES: usize = 22;

/// Rings of 22 vehicles on 250 m without noise, on which speeds are advised.
fn config(advised: u32) -> TrainConfig {
    TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 0.1, ..AdviceConfig::default() },
        ring: RingConfig {
            advised: AdvisedVehicles::Count(advised),
            circumference_min_m: 250.0,
            circumference_max_m: 250.0,
            idm: IdmParams { noise: 0.0, ..IdmParams::default() },
            warm_up_s: 60.0,
            horizon_s: 600.0,
            ..RingConfig::default()
        },
        ..TrainConfig::default()
    }
}

fn evenly(config: TrainConfig) -> TrainConfig {
    TrainConfig { ring: RingConfig { bunched_share: 0.0, ..config.ring.clone() }, ..config }
}

fn block(config: &TrainConfig) -> VecEnv {
    config.check().unwrap();
    VecEnv::new(config, "test", 0, config.hold())
}

fn speeds_mps(block: &VecEnv, l: usize) -> Vec<f32> {
    block.rings().speeds_mps(l).collect()
}

/// Returns the speed that a vehicle advises itself: between its own and its leader's, slower the closer it is.
fn own_advice_mps(speed_mps: f64, leader_mps: f64, gap_m: f64) -> f64 {
    0.5 * speed_mps + 0.5 * leader_mps + 0.2 * (gap_m - 6.0)
}

#[test]
fn advised_vehicles_drive_as_in_a_plain_simulation_of_places() {
    for (advised, slots) in [(4, vec![0, 5, 11, 16]), (22, (0..22).collect::<Vec<usize>>()), (1, vec![0])] {
        let mut block = block(&config(advised));
        assert_eq!(block.advised_slots().collect::<Vec<_>>(), slots);
        let (l, idm, step_s) = (7, config(advised).ring.idm, 0.1);
        // The front bumpers along an open line, the ego first: a vehicle's leader is the one before it, and the ego's is the last one a
        // length of the ring ahead.
        let mut speed: Vec<f64> = speeds_mps(&block, l).into_iter().map(f64::from).collect();
        let mut place = [0.0; VEHICLES];
        for k in 1..VEHICLES {
            place[k] = place[k - 1] - CAR_LENGTH_M - f64::from(block.rings().gaps_m(k)[l]);
        }
        for step in 0..300 {
            let ahead = |k: usize| {
                if k == 0 { (place[VEHICLES - 1] + 250.0, speed[VEHICLES - 1]) } else { (place[k - 1], speed[k - 1]) }
            };
            let next = |k: usize| {
                let (leader_m, leader_mps) = ahead(k);
                let gap_m = leader_m - place[k] - CAR_LENGTH_M;
                let accel = if slots.contains(&k) {
                    let advice = own_advice_mps(speed[k], leader_mps, gap_m).max(0.0);
                    ((advice - speed[k]) / step_s).clamp(-4.5, 1.5)
                } else {
                    idm.acceleration(speed[k], leader_mps, gap_m)
                };
                (speed[k] + accel * step_s).max(0.0)
            };
            let after: Vec<f64> = (0..VEHICLES).map(next).collect();
            let seen: Vec<Observation> = (0..block.rows()).map(|row| block.observe(row)).collect();
            let advice = |seen: &Observation| own_advice_mps(seen.speed_mps, seen.leader_speed_mps, seen.gap_m);
            block.hold(&seen.iter().map(|seen| Action::Speed(advice(seen))).collect::<Vec<_>>());
            speed = after;
            place.iter_mut().zip(&speed).for_each(|(place, speed)| *place += speed * step_s);
            // Single against double precision, over half a minute of a wave. The model's own bound at a standstill is below 0.02 m/s.
            for (k, own_mps) in speeds_mps(&block, l).into_iter().enumerate() {
                assert!((f64::from(own_mps) - speed[k]).abs() < 0.02, "{advised}, {step}, {k}: {own_mps} {}", speed[k]);
            }
        }
        let spread = speed.iter().fold(0.0_f64, |a, v| a.max(*v)) - speed.iter().fold(99.0_f64, |a, v| a.min(*v));
        assert!(spread > 0.1, "a ring without a wave shows nothing: {spread}");
    }
}

#[test]
fn vehicles_whose_drivers_ignore_advice_drive_as_the_model_does() {
    // A road on which no vehicle stops: there the model has a bound of its own.
    for advised in [4, 22] {
        let base = config(advised);
        let ring = RingConfig { circumference_min_m: 330.0, circumference_max_m: 330.0, ..base.ring.clone() };
        let driver = DriverConfig { follow: FollowKind::Ignore, ..base.driver.clone() };
        let mut block = block(&TrainConfig { ring, driver, ..base });
        let mut alone = block.rings().clone();
        for _ in 0..300 {
            block.hold(&vec![Action::Speed(0.0); block.rows()]);
            alone.run(1);
        }
        for l in 0..LANES {
            assert_eq!(speeds_mps(&block, l), alone.speeds_mps(l).collect::<Vec<_>>(), "{advised}");
        }
        assert!(speeds_mps(&block, 0).iter().all(|speed| *speed > 1.0));
    }
}

#[test]
fn equally_advised_vehicles_stay_evenly_spaced() {
    let mut block = block(&evenly(config(22)));
    for _ in 0..200 {
        block.hold(&vec![Action::Speed(3.0); block.rows()]);
    }
    for l in 0..LANES {
        assert!(speeds_mps(&block, l).iter().all(|speed| (speed - 3.0).abs() < 1e-6));
        let gaps_m: Vec<f32> = (0..VEHICLES).map(|k| block.rings().gaps_m(k)[l]).collect();
        // 250 m less 22 vehicles of 5 m, over 22.
        assert!(gaps_m.iter().all(|gap_m| *gap_m == gaps_m[0] && (gap_m - 140.0 / 22.0).abs() < 1e-3), "{gaps_m:?}");
    }
}

#[test]
fn one_slow_vehicle_has_the_same_effect_from_every_place() {
    let base = evenly(config(22));
    let driver = DriverConfig {
        follow: FollowKind::Driver,
        random_driver: false,
        reaction_s: 0.5,
        error_mps: 0.0,
        ..base.driver.clone()
    };
    let base = TrainConfig { driver, ..base };
    let driven = |slow: usize| {
        let mut block = block(&base);
        let actions: Vec<Action> =
            (0..block.rows()).map(|row| Action::Speed(if row % VEHICLES == slow { 1.0 } else { 6.0 })).collect();
        (0..200).for_each(|_| drop(block.hold(&actions)));
        speeds_mps(&block, 3)
    };
    let first = driven(0);
    assert!(first[0] < 1.1 && first[VEHICLES - 1] > 1.2 && first[1] < first[VEHICLES - 1], "{first:?}");
    for slow in [1, 9, 21] {
        let there = driven(slow);
        let turned: Vec<f32> = (0..VEHICLES).map(|k| there[(k + slow) % VEHICLES]).collect();
        assert_eq!(turned, first, "{slow}");
    }
}

#[test]
fn a_collision_ends_the_ring_for_all_and_fines_those_that_touch() {
    let base = evenly(config(4));
    let reward = RewardConfig { collision_penalty: 50.0, kind: crate::train::RewardKind::Ego, ..base.reward.clone() };
    let mut block = block(&TrainConfig { reward, ..base });
    // The third advised vehicle of ring 5 drives into its leader; all others of all rings keep about the speed of the even ring, 4.36 m/s.
    let (l, number) = (5, 2);
    let row = l * 4 + number;
    let actions: Vec<Action> =
        (0..block.rows()).map(|other| Action::Speed(if other == row { 30.0 } else { 4.3 })).collect();
    for hold in 0..300 {
        let (mut outcomes, mut begun): (Vec<Outcome>, Vec<usize>) = (Vec::new(), Vec::new());
        block.hold_each(&actions, |_, at, outcome| match outcome {
            Some(outcome) => {
                assert_eq!(at, outcomes.len());
                outcomes.push(outcome);
            }
            None => begun.push(at),
        });
        let ended: Vec<usize> = (0..outcomes.len()).filter(|row| outcomes[*row].ending != Ending::None).collect();
        assert_eq!(begun, ended);
        if ended.is_empty() {
            continue;
        }
        assert_eq!(ended, [20, 21, 22, 23], "{hold}");
        assert!(ended.iter().all(|row| outcomes[*row].ending == Ending::Crash));
        // A reward without a fine is the own speed, below 30 m/s.
        let fined: Vec<usize> = ended.into_iter().filter(|row| outcomes[*row].reward < -20.0).collect();
        assert_eq!(fined, [row]);
        assert!((f64::from(outcomes[row].reward) - outcomes[row].last_seen.speed_mps + 50.0).abs() < 1e-4);
        // The next episode has begun, and its vehicles have no advice yet.
        assert!((20..24).all(|row| block.observe(row).advised_mps.is_none() && block.observe(row).gap_m > 0.0));
        assert!(block.observe(19).advised_mps.is_some());
        return;
    }
    panic!("no collision");
}

#[test]
fn each_vehicle_has_a_driver_of_its_own_and_the_egos_stays() {
    let base = config(1);
    let driver = DriverConfig { follow: FollowKind::Driver, speed_bias_mps: 1.0, ..base.driver.clone() };
    let [one, four] = [1, 4].map(|advised| {
        let ring = RingConfig { advised: AdvisedVehicles::Count(advised), car_spread: 0.2, ..base.ring.clone() };
        block(&TrainConfig { ring, driver: driver.clone(), ..base.clone() })
    });
    for l in 0..LANES {
        let traits: Vec<_> = (0..4).map(|number| four.observe(4 * l + number).driver).collect();
        assert_eq!(traits[0], one.observe(l).driver);
        assert!((0..4).all(|k| (0..k).all(|other| traits[k] != traits[other])), "{traits:?}");
    }
}

#[test]
fn each_vehicle_sees_the_whole_ring_from_its_own_place() {
    let sees = "speed,ring_mean_speed,wave_cos_1,wave_sin_1";
    let network = NetworkConfig { sees: sees.into(), ..NetworkConfig::default() };
    let driver = DriverConfig { error_mps: 0.0, ..DriverConfig::default() };
    let block = block(&TrainConfig { network, driver, ..config(4) });
    let speeds: Vec<f64> = speeds_mps(&block, 2).into_iter().map(f64::from).collect();
    for (number, slot) in [0, 5, 11, 16].into_iter().enumerate() {
        let from_here: Vec<f64> = (0..VEHICLES).map(|k| speeds[(slot + k) % VEHICLES]).collect();
        assert_eq!(block.observe(8 + number).ring, Some(WholeRing::of(from_here.into_iter(), 0.0)));
        assert_eq!(block.observe(8 + number).speed_mps, speeds[slot]);
    }
}

#[test]
fn a_constant_speed_of_all_is_the_mean_speed_of_their_evaluation() {
    let base = evenly(config(22));
    let base = TrainConfig { ring: RingConfig { horizon_s: 20.0, warm_up_s: 10.0, ..base.ring.clone() }, ..base };
    let constant = || Some(Box::new(ConstantSpeed { speed_mps: 2.5 }) as Box<dyn Policy>);
    let results = evaluate(&base, "test", 3, constant);
    // All vehicles have 2.5 m/s after the start, and all of them count as advised.
    for result in &results {
        assert!((result.settled_speed_mps - 2.5).abs() < 1e-5 && !result.crashed, "{result:?}");
        assert!(result.time_in_range.is_some_and(|share| share > 0.95), "{result:?}");
    }
    let jointly = evaluate_jointly(&base, "test", 3, |seen| {
        assert_eq!(seen.len(), 3 * VEHICLES);
        Ok::<_, Infallible>(vec![Action::Speed(2.5); seen.len()])
    });
    assert_eq!(jointly, Ok(results));
}

#[test]
fn a_training_counts_decisions_of_vehicles_and_steps_of_rings() {
    let small = |advised| TrainConfig {
        ring: RingConfig { warm_up_s: 5.0, horizon_s: 60.0, ..config(advised).ring },
        advice: AdviceConfig { hold_s: 1.0, ..config(advised).advice },
        network: NetworkConfig { hidden_width: 8, ..NetworkConfig::default() },
        run: RunConfig { batch: 640, rings: 32, iterations: 2 },
        ..config(advised)
    };
    let [one, four] = [1, 4].map(|advised| Learner::new(&small(advised)).iterate());
    // 640 decisions: 20 s of each of 32 rings, or 5 s of each with four vehicles.
    assert_eq!([one.env_steps, four.env_steps], [32 * 200, 32 * 50]);
    let driven = || {
        let mut learner = Learner::new(&small(4));
        let _ = [learner.iterate(), learner.iterate()];
        bits(&learner)
    };
    assert_eq!(driven(), driven());
}

#[test]
fn a_number_of_advised_vehicles_fits_the_rings() {
    let fault = |text: &str| from_toml::<TrainConfig>(text, "x").expect_err(text).message;
    for (text, words) in [
        ("advised = 0", "advised is 0; allowed: 1 to 22"),
        ("advised = 23", "advised is 23; allowed: 1 to 22, as many as there are vehicles, or a share such as 20%"),
        ("advised = \"half\"", "advised is \"half\"; allowed: a share"),
        ("advised = 4\nvehicles_min = 20", "advised is 4; allowed: 1, as rings have 20 to 22 vehicles"),
        (
            "advised = 4\nsilence_rings = 16\nsees = \"speed,spacing\"",
            "advised is 4; allowed: 1 if silence_rings is above 0",
        ),
    ] {
        assert!(fault(text).contains(words), "{text}: {}", fault(text));
    }
    let slots = |text: &str| from_toml::<TrainConfig>(text, "x").unwrap().ring.advised_slots().collect::<Vec<_>>();
    assert_eq!(slots("advised = \"20%\""), [0, 5, 11, 16]);
    assert_eq!(slots("vehicles_min = 18\nadvised = \"1\""), [0]);
    assert_eq!(slots("advised = \"100%\"").len(), 22);
}
