//! Episodes, rewards and drivers that follow advice.

use super::{
    ActionKind, AdviceConfig, DriverConfig, FollowKind, Learner, NetworkConfig, RewardConfig, RewardKind, RingConfig,
    TrainConfig,
    drawn_ring::{draw_ring, episode_stream},
    environment::VecEnv,
    outcome::{Ending, Outcome},
    simd::LANES,
};
use crate::{
    metrics::DrivenBy,
    policy::{
        Action, Advisor, Controller, ControllerKind, CorrectedAdvice, Hold, Network, NetworkLayer, Policy, TwoPhase,
    },
    time::Tick,
};

fn config() -> TrainConfig {
    TrainConfig { ring: RingConfig { horizon_s: 60.0, ..RingConfig::default() }, ..TrainConfig::default() }
}

fn block(config: &TrainConfig) -> VecEnv {
    VecEnv::new(config, "test", 0, config.hold())
}

fn all(action: Action) -> [Action; LANES] {
    [action; LANES]
}

/// Drive beside a training: the same rings, each advised through an advisor.
struct Drive {
    config: TrainConfig,
    env: VecEnv,
    advisors: Vec<Advisor>,
    steps: u64,
}

impl Drive {
    fn of(config: &TrainConfig, policy: impl Fn() -> Box<dyn Policy>) -> Self {
        let advisors = (0..LANES).map(|_| Advisor::new(Some(policy()), config.hold(), 0.4)).collect();
        Self { config: config.clone(), env: block(config), advisors, steps: 0 }
    }

    /// Drives one hold; `check` gets the number of the ring and its new advice, m/s.
    fn hold(&mut self, mut check: impl FnMut(usize, f64)) {
        let hold = self.config.hold();
        for _ in 0..hold.steps() {
            for (l, advisor) in self.advisors.iter_mut().enumerate() {
                let seen = self.env.observe(l);
                if let Some(advice) = advisor.step(Tick(self.steps * 10), &seen, self.config.ring.idm.v0) {
                    check(l, advice.target_mps);
                    self.env.advise(l, Some(Action::Speed(advice.target_mps)), hold);
                }
            }
            self.env.step();
            self.steps += 1;
        }
    }
}

#[test]
fn an_acceleration_is_kept_exactly_for_the_hold() {
    let mut block = block(&config());
    let before = block.observe(3).speed_mps;
    let outcomes = block.hold(&all(Action::Acceleration(0.25)));
    assert!((outcomes[3].last_seen.speed_mps - before - 0.25).abs() < 1e-5);
    let after = block.hold(&all(Action::Acceleration(-0.1)));
    assert!((after[3].last_seen.speed_mps - before - 0.15).abs() < 1e-5);
}

#[test]
fn rings_too_dense_for_advice_are_lengthened_and_others_unchanged() {
    let dense = TrainConfig {
        ring: RingConfig { vehicles_min: 18, vehicles_max: 26, horizon_s: 60.0, warm_up_s: 1.0, ..config().ring },
        ..config()
    };
    let bounded = TrainConfig { ring: RingConfig { least_spacing_m: 9.6, ..dense.ring.clone() }, ..dense.clone() };
    let mut longer = 0;
    for index in 0..4 {
        let [free, bounded] =
            [&dense, &bounded].map(|config| VecEnv::new(config, "test", index, Hold::of_steps(10, config.ring.step_s)));
        for l in 0..LANES {
            let (free, bounded) = (free.observe(l), bounded.observe(l));
            let least_m = 9.6 * f64::from(free.vehicles);
            assert_eq!(bounded.vehicles, free.vehicles);
            assert!((bounded.circumference_m - free.circumference_m.max(least_m)).abs() < 1e-4);
            longer += usize::from(free.circumference_m < least_m);
        }
    }
    assert!((5..40).contains(&longer), "{longer} of 64");
}

#[test]
fn trucks_shorten_the_gaps_and_rings_without_trucks_are_unchanged() {
    let ring = RingConfig { circumference_min_m: 290.0, circumference_max_m: 290.0, warm_up_s: 0.0, ..config().ring };
    let of = |ring: RingConfig| block(&TrainConfig { ring, ..config() });
    let room_m = |block: &VecEnv, l: usize| -> f32 { (0..22).map(|k| block.rings().gaps_m(k)[l]).sum() };
    let plain = of(ring.clone());
    assert!((0..LANES).all(|l| (room_m(&plain, l) - (290.0 - 22.0 * 5.0)).abs() < 0.01));
    let all_trucks = of(RingConfig { truck_share: 1.0, ..ring.clone() });
    // By hand: 21 trucks of 7.1 m and the ego of 5 m.
    assert!((0..LANES).all(|l| (room_m(&all_trucks, l) - (290.0 - 21.0 * 7.1 - 5.0)).abs() < 0.01));
    let some = of(RingConfig { truck_share: 0.3, ..ring });
    let taken: f32 = (0..LANES).map(|l| (290.0 - 110.0 - room_m(&some, l)) / 2.1).sum();
    // 336 vehicles, of which 101 are expected to be trucks: within four standard deviations.
    assert!((taken - 100.8).abs() < 34.0, "{taken}");
}

#[test]
fn a_controller_without_correction_advises_in_training_as_in_a_drive() {
    let config = TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 2.0, ..config().advice },
        driver: DriverConfig { follow: FollowKind::Driver, ..config().driver },
        ..config()
    };
    let settings = config.policy_settings(0.0);
    for controller in [
        Controller::by_name(ControllerKind::Pi, &settings),
        Controller::by_name(ControllerKind::FollowerStopper, &settings),
        Controller::TwoPhase(TwoPhase { slow_mps: 2.0, slow_s: 20.0, then_mps: 4.0 }),
    ] {
        let kind = controller.kind();
        let mut training = block(&config);
        training.correct(&CorrectedAdvice::Controller(controller));
        let mut drive = Drive::of(&config, || controller.policy(config.ring.step_s));
        for decision in 0..29 {
            drive.hold(|l, advised_mps| {
                assert_eq!(training.observe(l).corrected_mps, Some(advised_mps), "{kind:?}, {decision}");
            });
            training.hold(&all(Action::Speed(0.0)));
        }
        assert_eq!(training.rings().ego_mps(), drive.env.rings().ego_mps(), "{kind:?}");
        // The minute is over: a ring that starts again has a newly engaged controller.
        let outcomes = training.hold(&all(Action::Speed(0.0)));
        assert_eq!(outcomes[0].ending, Ending::Horizon);
        if kind == ControllerKind::TwoPhase {
            assert_eq!(outcomes[0].last_seen.corrected_mps, Some(4.0));
            assert_eq!(training.observe(0).corrected_mps, Some(2.0));
        }
    }
}

#[test]
fn a_corrected_network_advises_in_training_as_in_a_drive() {
    let config = TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 2.0, ..config().advice },
        driver: DriverConfig { follow: FollowKind::Driver, ..config().driver },
        ..config()
    };
    // Its advice depends on everything that moves, on the hold, and on the mean speed and the deviation, which the drive computes itself.
    let alone = TrainConfig {
        network: NetworkConfig {
            sees: "speed,leader_speed,gap,spacing,mean_speed,log_hold,observed_deviation".into(),
            ..NetworkConfig::default()
        },
        ..config.clone()
    };
    let mut corrected = Learner::new(&alone).best().0;
    for (i, weights) in corrected.layers[2].weights.iter_mut().enumerate() {
        // The initial weights of the last layer are so small that the advice would hardly change.
        weights.iter_mut().for_each(|w| *w = if i % 2 == 0 { 0.15 } else { -0.1 });
    }
    let advice = CorrectedAdvice::Network(Box::new(corrected));
    let correction = 0.3_f32;
    let whole = Network { corrected: Some(advice.clone()), ..constant_correction(&config, correction) };
    let mut training = block(&config);
    training.correct(&advice);
    let mut drive = Drive::of(&config, || whole.clone().policy(config.ring.step_s));
    let mut seen_mps = Vec::new();
    for decision in 0..29 {
        drive.hold(|l, advised_mps| {
            let trained_mps = training.observe(l).corrected_mps.unwrap();
            // The drive computes the mean speed in double precision.
            let apart_mps = trained_mps + f64::from(correction) - advised_mps;
            assert!(apart_mps.abs() < 1e-3, "{decision}: {trained_mps}, {advised_mps}");
            seen_mps.push(trained_mps);
        });
        training.hold(&all(Action::Speed(f64::from(correction))));
    }
    let spread = seen_mps.iter().fold(0.0_f64, |a, v| a.max(*v)) - seen_mps.iter().fold(99.0_f64, |a, v| a.min(*v));
    assert!(seen_mps.len() == 29 * LANES && spread > 0.5, "{spread}");
    let apart = training.rings().ego_mps().iter().zip(drive.env.rings().ego_mps()).map(|(a, b)| (a - b).abs());
    assert!(apart.clone().all(|apart| apart < 1e-3), "{:?}", apart.collect::<Vec<_>>());
    // The minute is over: the corrected network sees the ring that starts again.
    let CorrectedAdvice::Network(network) = &advice else { unreachable!("made above") };
    let outcomes = training.hold(&all(Action::Speed(0.0)));
    for (l, outcome) in outcomes.iter().enumerate() {
        assert_eq!(outcome.ending, Ending::Horizon);
        for seen in [outcome.last_seen, training.observe(l)] {
            assert_eq!(seen.corrected_mps, Some(network.speed_mps(&seen)));
        }
    }
    assert!((0..LANES).any(|l| outcomes[l].last_seen.corrected_mps != training.observe(l).corrected_mps));
}

#[test]
fn drivers_are_probed_in_training_as_in_a_drive() {
    let config = TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 2.0, probe_mps: 0.25, ..config().advice },
        driver: DriverConfig { follow: FollowKind::Driver, ..config().driver },
        ..config()
    };
    let mut constant = Learner::new(&config).best().0;
    let weights = vec![vec![0.0]; constant.inputs.len()];
    // The limits are 0 and 10 m/s, and an output of -0.25 is 3.75 m/s.
    constant.layers = vec![NetworkLayer { bias: vec![-0.25], weights }];
    let mut training = block(&config);
    let mut drive = Drive::of(&config, || constant.clone().policy(config.ring.step_s));
    for decision in 0..29 {
        // The period of 4 s is two holds.
        drive.hold(|_, advised_mps| assert_eq!(advised_mps, if decision % 2 == 0 { 4.0 } else { 3.5 }, "{decision}"));
        training.hold(&all(Action::Speed(3.75)));
        assert_eq!(training.rings().ego_mps(), drive.env.rings().ego_mps(), "{decision}");
    }
}

/// Returns a policy that always adds `correction_mps` to the corrected advice.
fn constant_correction(config: &TrainConfig, correction_mps: f32) -> Network {
    let advice = AdviceConfig { residual_over: "set below".into(), ..config.advice.clone() };
    let mut network = Learner::new(&TrainConfig { advice, ..config.clone() }).best().0;
    let most = network.limits[1] as f32;
    let weights = vec![vec![0.0]; network.inputs.len()];
    network.layers = vec![NetworkLayer { bias: vec![correction_mps / most], weights }];
    network
}

#[test]
fn a_speed_is_reached_within_the_egos_acceleration() {
    let config = TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, ..config().advice },
        driver: DriverConfig { ego_accel_mps2: 1.5, ..config().driver },
        ..config()
    };
    let mut block = block(&config);
    let before: Vec<f64> = (0..LANES).map(|l| block.observe(l).speed_mps).collect();
    let outcomes = block.hold(&all(Action::Speed(before[5] + 1.0)));
    assert!((outcomes[5].last_seen.speed_mps - before[5] - 1.0).abs() < 1e-4);
    let far = block.hold(&all(Action::Speed(30.0)));
    assert!(far.iter().zip(outcomes).all(|(a, b)| a.last_seen.speed_mps - b.last_seen.speed_mps < 1.5 + 1e-4));
}

#[test]
fn an_accelerating_ego_crashes_unless_guarded_and_a_braking_one_never() {
    let endings = |brakes_for_leader: bool, action: Action| {
        let mut block =
            block(&TrainConfig { driver: DriverConfig { brakes_for_leader, ..config().driver }, ..config() });
        let run = |_| block.hold(&all(action)).into_iter().map(|o| o.ending).collect::<Vec<Ending>>();
        (0..40).flat_map(run).collect::<Vec<Ending>>()
    };
    let crashes = |endings: &[Ending]| endings.iter().filter(|e| **e == Ending::Crash).count();
    assert_eq!(crashes(&endings(false, Action::Acceleration(-0.5))), 0);
    assert!(crashes(&endings(false, Action::Acceleration(0.5))) >= LANES);
    assert_eq!(crashes(&endings(true, Action::Acceleration(0.5))), 0);
}

#[test]
fn an_episode_ends_at_its_horizon_and_another_ring_takes_its_place() {
    let mut block = block(&config());
    for hold in 1..=60 {
        let before: Vec<f64> = (0..LANES).map(|l| block.observe(l).circumference_m).collect();
        let outcomes = block.hold(&all(Action::Acceleration(-0.2)));
        let ended = outcomes.iter().all(|o| o.ending == Ending::Horizon);
        assert_eq!(ended, hold == 60, "hold {hold}");
        let renewed = (0..LANES).filter(|l| block.observe(*l).circumference_m != before[*l]).count();
        assert_eq!(renewed, if ended { LANES } else { 0 });
    }
}

#[test]
fn unused_rings_of_a_block_never_end_and_take_no_episode() {
    // All vehicles crash: exact compliance at full acceleration.
    let ahead = all(Action::Acceleration(0.5));
    let lengths_m = |rings: usize| {
        let mut block = block(&config()).with_rings(rings);
        let mut seen = vec![block.observe(0).circumference_m];
        while seen.len() < 3 {
            let outcomes = block.hold(&ahead);
            assert!(outcomes[rings..].iter().all(|outcome| outcome.ending == Ending::None));
            if outcomes[0].ending == Ending::Crash {
                seen.push(block.observe(0).circumference_m);
            }
        }
        seen
    };
    let drawn = |number: u64| drawn_m(&config(), number);
    let alone = lengths_m(1);
    // Ring 0 of the first stock, then rings 0 and 1 of the second.
    for (seen, drawn) in alone.iter().zip([drawn(0), drawn(1 << 32), drawn(1 | 1 << 32)]) {
        assert!((seen - drawn).abs() < 1e-4, "{seen} is not {drawn}");
    }
    assert_eq!(lengths_m(LANES)[0], alone[0]);
    // Each new episode takes the next ring of the stock.
    let mut block = block(&config()).with_rings(1);
    block.begin_episode(0);
    assert!((block.observe(0).circumference_m - drawn(1 << 32)).abs() < 1e-4);
}

/// Returns the length of the ring of episode `number` of the block, m.
fn drawn_m(config: &TrainConfig, number: u64) -> f64 {
    draw_ring(config, &config.ring.traffic_drivers()[0], &mut episode_stream(config.seed, "test", number)).length_m
}

#[test]
fn the_reward_is_the_speed_less_the_penalties() {
    let reward = |change: TrainConfig, action: Action| -> Outcome { block(&change).hold(&all(action))[0] };
    let plain = reward(config(), Action::Acceleration(0.25));
    assert_eq!(plain.reward, plain.mean_mps);
    let penalised = reward(
        TrainConfig { reward: RewardConfig { action_penalty: 2.0, ..config().reward }, ..config() },
        Action::Acceleration(0.25),
    );
    assert!((plain.reward - penalised.reward - 1.0).abs() < 1e-6);
    let ego = reward(
        TrainConfig { reward: RewardConfig { kind: RewardKind::Ego, ..config().reward }, ..config() },
        Action::Acceleration(0.0),
    );
    assert!((f64::from(ego.reward) - ego.last_seen.speed_mps).abs() < 1e-5);
    let headway = reward(
        TrainConfig { reward: RewardConfig { headway_penalty: 1.0, ..config().reward }, ..config() },
        Action::Acceleration(0.25),
    );
    assert!(headway.reward <= plain.reward);
}

/// Returns the speeds of ring 0's ego under one speed advice, one per step, with holds of 0.1 s.
fn driven(change: TrainConfig, advice_mps: f64, steps: usize) -> Vec<f64> {
    let base = TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 0.1, ..change.advice },
        driver: DriverConfig { follow: FollowKind::Driver, random_driver: false, ..change.driver },
        ring: RingConfig {
            // Two vehicles on a long ring do not get in each other's way.
            vehicles_min: 2,
            vehicles_max: 2,
            circumference_min_m: 1000.0,
            circumference_max_m: 1000.0,
            warm_up_s: 0.0,
            horizon_s: 3000.0,
            ..change.ring
        },
        ..change
    };
    let mut block = block(&base);
    (0..steps).map(|_| block.hold(&all(Action::Speed(advice_mps)))[0].last_seen.speed_mps).collect()
}

#[test]
fn a_simulated_driver_responds_after_the_reaction_time() {
    let change =
        TrainConfig { driver: DriverConfig { reaction_s: 1.5, error_mps: 0.0, ..config().driver }, ..config() };
    let speeds = driven(change.clone(), 0.0, 400);
    // The model drives until the advice to stop is perceived: 15 steps.
    let fastest = speeds.iter().position(|v| *v >= speeds[14] - 1e-9).unwrap();
    assert_eq!(fastest, 14, "{:?}", &speeds[..20]);
    assert!(speeds[15] < speeds[14] && speeds[399] < 1e-3);
}

#[test]
fn a_driver_notices_withdrawn_advice_after_the_reaction_time() {
    let config = TrainConfig {
        ring: RingConfig { warm_up_s: 0.0, horizon_s: 3000.0, ..config().ring },
        advice: AdviceConfig { action: ActionKind::Speed, hold_s: 0.1, ..config().advice },
        driver: DriverConfig {
            follow: FollowKind::Driver,
            random_driver: false,
            reaction_s: 1.5,
            error_mps: 0.0,
            ..config().driver
        },
        ..config()
    };
    let mut block = block(&config);
    let hold = config.hold();
    (0..LANES).for_each(|l| block.advise(l, Some(Action::Speed(0.0)), hold));
    (0..600).for_each(|_| block.step());
    assert!(block.observe(0).speed_mps < 1e-3 && block.observe(0).advised_mps == Some(0.0));
    let speeds: Vec<f64> = (0..20)
        .map(|_| {
            block.advise(0, None, hold);
            block.step();
            block.observe(0).speed_mps
        })
        .collect();
    assert_eq!(block.observe(0).advised_mps, None);
    // The ego is stopped with an open road ahead: for 15 steps as advised, then with about the model's 1 m/s².
    assert!(speeds[14] < 1e-3 && (speeds[15] - 0.1).abs() < 0.03, "{speeds:?}");
    assert!(block.driven_by()[0] == DrivenBy::Model);
}

#[test]
fn a_simulated_driver_wanders_around_the_target_with_a_constant_bias() {
    let change = TrainConfig {
        driver: DriverConfig {
            error_mps: 0.4,
            speed_bias_mps: 0.5,
            error_time_s: 5.0,
            reaction_s: 0.0,
            ..config().driver
        },
        ..config()
    };
    let speeds = driven(change, 5.0, 20_000);
    let settled = &speeds[500..];
    let mean = settled.iter().sum::<f64>() / settled.len() as f64;
    let sd = (settled.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / settled.len() as f64).sqrt();
    assert!((mean - 5.5).abs() < 0.08, "{mean}");
    // The vehicle smooths an error with a time constant of 5 s by its own 1.5 s: sqrt(5 / 6.5) of 0.4.
    assert!((sd - 0.351).abs() < 0.04, "{sd}");
}

#[test]
fn drawn_drivers_differ_from_ring_to_ring() {
    let config = TrainConfig {
        driver: DriverConfig { follow: FollowKind::Driver, speed_bias_mps: 1.0, ..config().driver },
        advice: AdviceConfig { action: ActionKind::Speed, ..config().advice },
        ..config()
    };
    let mut block = block(&config);
    let mut outcomes = block.hold(&all(Action::Speed(2.0)));
    (0..20).for_each(|_| outcomes = block.hold(&all(Action::Speed(2.0))));
    let speeds: Vec<f64> = outcomes.iter().map(|o| o.last_seen.speed_mps).collect();
    let spread = speeds.iter().fold(0.0_f64, |a, v| a.max(*v)) - speeds.iter().fold(9.0_f64, |a, v| a.min(*v));
    assert!(spread > 0.3, "{speeds:?}");
}

#[test]
fn a_penalty_for_differences_of_speed_is_their_standard_deviation() {
    let with = |speed_sd_penalty: f64| TrainConfig {
        reward: RewardConfig { speed_sd_penalty, ..config().reward },
        ..config()
    };
    let one_step = Hold::of_steps(1, config().ring.step_s);
    let mut blocks = [0.0, 0.5].map(|penalty| VecEnv::new(&with(penalty), "test", 0, one_step));
    let [free, fined] = blocks.each_mut().map(|block| block.hold(&all(Action::Acceleration(0.0))));
    for l in 0..LANES {
        let speeds: Vec<f32> = blocks[1].rings().speeds_mps(l).collect();
        let mean = speeds.iter().sum::<f32>() / speeds.len() as f32;
        let sd = (speeds.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / speeds.len() as f32).sqrt();
        // Rewards of some m/s in single precision keep 1e-4. A deviation of 0.5 m/s is 2,500 times that, so that a lost penalty is seen; the
        // bunched start has 2 to 4 m/s.
        assert!((free[l].reward - fined[l].reward - 0.5 * sd).abs() < 1e-4 && sd > 0.5, "{sd}");
    }
}

#[test]
fn blocks_of_rings_have_the_named_populations_in_turn() {
    let of = |traffic_drivers: &str| TrainConfig {
        ring: RingConfig { traffic_drivers: traffic_drivers.into(), warm_up_s: 30.0, ..config().ring },
        ..config()
    };
    let block = |config: &TrainConfig, index| VecEnv::new(config, "test", index, config.hold());
    let both = of("ring-study, gap-closers");
    for (index, alone) in ["ring-study", "gap-closers", "ring-study"].into_iter().enumerate() {
        let [mixed, alone] = [block(&both, index), block(&of(alone), index)];
        assert_eq!(mixed.rings(), alone.rings(), "{index}");
    }
    assert_ne!(block(&both, 1).rings(), block(&of("ring-study"), 1).rings());
}
