//! Whole drives advised from outside, hold by hold: equal to the bit to drives whose policy gives the same advice, with rewards as computed
//! by hand. `python/tests/test_drive.py` also runs the last of them.

use crate::world::one_at_a_time;
use codrive::{
    drive_loop::{
        episode::{Episode, EpisodeError, HoldOutcome},
        episode_config::EpisodeConfig,
        offline::OfflineDrive,
    },
    policy::{Observation, PolicySettings, PolicySource},
    rng,
    scenario::{PlannedDrive, Scenario},
    settings::{Field, SettingsError},
    sim::{HASH_START, OutsideSettings, World},
    traffic::{Demand, EGO, Flow, VehicleId},
};
use serde_json::{Value, json};
use std::{collections::BTreeSet, fmt::Write};

const GRID: &str = "tests/data/networks/grid-signals.net.xml";
/// Expected result of Rust and Python. After an intended change of drives, replace it by the output of the test.
const EXPECTED: &str = include_str!("../../python/tests/drive.txt");

fn config_of(map: &str, driver: Option<&str>, demand: Demand, set: Value) -> Result<EpisodeConfig, SettingsError> {
    let fields = EpisodeConfig::fields();
    let Value::Object(set) = set else { panic!("settings: {set}") };
    let field = |key: &str| fields.iter().find(|field| field.path == key).unwrap_or_else(|| panic!("no {key}")).clone();
    let changes: Vec<(Field, Value)> = set.into_iter().map(|(key, value)| (field(&key), value)).collect();
    EpisodeConfig::new(map, driver, demand, &changes)
}

fn on_ring(set: Value) -> EpisodeConfig {
    config_of("ring-250", Some("follow"), Demand::default(), set).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns a configuration with 1,200 cars an hour in total across the grid; the ego drives round.
fn on_grid(mut set: Value) -> EpisodeConfig {
    let flow = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 400.0, mix: Vec::new() };
    let flows = vec![flow("A0B0", "B2C2"), flow("C2C1", "A1A0"), flow("A2A1", "C0B0")];
    set["path"] = "B0B1 B1C1 C1C2 C2B2 B2A2 A2A1 A1A0".into();
    if set["warm_up_s"].is_null() {
        set["warm_up_s"] = 20.into();
    }
    set["advised"] = "50%".into();
    config_of(GRID, None, Demand { flows, ..Demand::default() }, set).unwrap_or_else(|error| panic!("{error}"))
}

fn begin(config: &EpisodeConfig, seed: u64) -> Episode {
    Episode::begin(config, seed).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs one hold with the same action for every agent.
fn hold(episode: &mut Episode, action: f32) -> HoldOutcome {
    let actions = vec![action; episode.agents().len()];
    episode.hold(&actions).unwrap_or_else(|error| panic!("{error}"))
}

fn agents(episode: &Episode) -> Vec<u32> {
    episode.agents().map(|id| id.0).collect()
}

/// Adds one more step to the chained hash of a drive's states.
fn chained(world: &World, before: u64) -> u64 {
    let own = world.snapshot().hash(before);
    world.advised_others().iter().fold(own, |hash, agent| agent.snapshot().hash(hash))
}

/// Runs a drive of `steps` steps whose policy always advises `speed_mps`. Returns its fingerprint.
fn by_policy(config: &EpisodeConfig, speed_mps: f64, seed: u64, steps: usize) -> u64 {
    let scenario = Scenario {
        policy: "constant".into(),
        policy_speed_mps: speed_mps,
        duration_s: 0.0,
        seed,
        ..config.scenario.clone()
    };
    let mut drive = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    (0..steps).fold(HASH_START, |hash, _| {
        drive.step().expect("the engine goes on");
        chained(drive.world(), hash)
    })
}

#[test]
fn outside_advice_equals_the_same_advice_of_a_policy_to_the_bit() {
    let _guard = one_at_a_time();
    for traffic in ["native", "sumo"] {
        // Level 4 of eleven levels from 0 to 10 m/s.
        let config = on_ring(json!({
            "traffic": traffic, "advised": 4.to_string(), "action": "speed", "levels": 11, "warm_up_s": 20.0,
        }));
        let mut episode = begin(&config, 3);
        assert_eq!(agents(&episode), [0, 5, 11, 16]);
        for _ in 0..12 {
            let outcome = hold(&mut episode, 4.0);
            assert!(outcome.agents.iter().all(|agent| !agent.is_terminated) && !outcome.is_truncated);
        }
        assert_eq!(agents(&episode), [0, 5, 11, 16], "nobody comes or goes on a ring");
        let fingerprint = episode.fingerprint();
        drop(episode);
        assert_eq!(fingerprint, by_policy(&config, 4.0, 3, 120), "{traffic}");
        // The advice and the seed change the result.
        assert_ne!(fingerprint, by_policy(&config, 4.5, 3, 120));
        assert_ne!(fingerprint, by_policy(&config, 4.0, 4, 120));
    }
}

#[test]
fn a_controller_outside_the_world_drives_as_inside_to_the_bit() {
    // It returns its own speed for each agent's observation at each hold, and observes nothing in between.
    let scenario = Scenario {
        traffic: "native".parse().expect("an engine"),
        advised: "4".parse().expect("a number"),
        policy: "linear-feedback".into(),
        warm_up_s: 30.0,
        duration_s: 0.0,
        ..Scenario::default()
    };
    let mut within = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).expect("a drive");
    let mut outside = OfflineDriveFromOutside::new(&scenario);
    for step in 0..200 {
        within.step().expect("the engine goes on");
        outside.step(step % 10 == 0);
        let difference = within.world().snapshot().first_difference(outside.world.snapshot());
        assert_eq!(difference, None, "step {step}");
        for (one, other) in within.world().advised_others().iter().zip(outside.world.advised_others()) {
            assert_eq!(one.snapshot().first_difference(other.snapshot()), None, "car {:?}, step {step}", one.id());
        }
    }
    let aims: BTreeSet<u64> =
        within.world().agents().filter_map(|agent| agent.snapshot().advice.map(|a| a.target_mps.to_bits())).collect();
    assert!(aims.len() > 1, "they are advised differently: {aims:?}");
}

/// Drive as made by [`OfflineDrive`], with policies outside the world.
struct OfflineDriveFromOutside {
    world: World,
    driver: codrive::driver::SimulatedDriver,
    policies: Vec<Box<dyn codrive::policy::Policy>>,
    steps: u32,
}

impl OfflineDriveFromOutside {
    fn new(scenario: &Scenario) -> Self {
        let world = {
            let drive = PlannedDrive::new(scenario).expect("a road");
            World::advised_from_outside(drive, OutsideSettings::default()).expect("a world")
        };
        let params = codrive::driver::preset(&scenario.driver).expect("a preset");
        let driver =
            codrive::driver::SimulatedDriver::new(&params, world.ego_params(), scenario.seed).expect("a driver");
        let equilibrium_mps = world.expected_speeds().equilibrium_mps;
        let settings = PolicySettings { aim_mps: 0.0, equilibrium_mps, step_s: 0.1 };
        let source = PolicySource::read(&scenario.policy, &settings).expect("a controller");
        let policies = world.agents().map(|_| source.engage().expect("it advises")).collect();
        Self { world, driver, policies, steps: 0 }
    }

    fn step(&mut self, is_due: bool) {
        self.world.sync_agents_now().expect("the engine goes on");
        let observations: Vec<Observation> =
            self.world.agents().map(|agent| self.world.complete_observation(agent)).collect();
        for (index, (policy, observation)) in self.policies.iter_mut().zip(&observations).enumerate() {
            policy.watch(observation);
            if is_due {
                let action = policy.act(f64::from(self.steps) * 0.1, observation);
                self.world.advise(index, action);
            }
        }
        for _ in 0..10 {
            let controls = self.driver.controls(&self.world.perceived_by(&self.driver));
            self.world.tick(&controls).expect("the engine goes on");
        }
        self.steps += 1;
    }
}

#[test]
fn advice_to_agents_on_a_network_equals_a_policys_to_the_bit() {
    let _alone = one_at_a_time();
    // With a hold of one step, both advise an entering vehicle at once.
    let set = json!({
        "action": "speed", "levels": 11, "top_speed_mps": 10.0, "hold_s": 0.1, "horizon_s": 90.0,
    });
    let config = on_grid(set);
    let mut episode = begin(&config, 1);
    let mut ever: BTreeSet<u32> = agents(&episode).into_iter().collect();
    let mut gone: BTreeSet<u32> = BTreeSet::new();
    while !episode.is_over() {
        let before = agents(&episode);
        assert_eq!(before[0], EGO.0);
        let outcome = hold(&mut episode, 7.0);
        assert_eq!(outcome.agents.iter().map(|agent| agent.id.0).collect::<Vec<_>>(), before);
        ever.extend(agents(&episode));
        let left: Vec<u32> = outcome.agents.iter().filter(|a| a.is_terminated).map(|a| a.id.0).collect();
        if !episode.is_over() {
            let now: BTreeSet<u32> = agents(&episode).into_iter().collect();
            assert!(before.iter().all(|id| now.contains(id) != left.contains(id)), "{before:?}, {now:?}, {left:?}");
        }
        gone.extend(left);
        for agent in &outcome.agents {
            assert!(agent.reward.is_finite() && agent.last_seen.speed_mps > -0.5, "{agent:?}");
        }
    }
    // The random streams alone determine the vehicles that may be chosen.
    let may = |id: &u32| *id == 0 || rng::stream(1, &format!("vehicle/{id}/advised")).uniform(0.0, 1.0) < 0.5;
    assert!(ever.iter().all(may), "{ever:?}");
    assert!(ever.len() >= 6 && !gone.is_empty(), "{ever:?} were advised, {gone:?} have left");
    let (fingerprint, steps) = (episode.fingerprint(), episode.world().snapshot().tick.0 / 10);
    assert_eq!((steps, episode.world().contacts_of_others()), (900, 0), "to the horizon, without a contact");
    drop(episode);
    assert_eq!(fingerprint, by_policy(&config, 7.0, 1, 900));
}

#[test]
fn a_vehicle_that_enters_within_a_hold_is_advised_from_the_next() {
    let _alone = one_at_a_time();
    let config = on_grid(json!({ "action": "speed", "levels": 11, "hold_s": 5.0, "horizon_s": 60.0 }));
    assert_eq!(config.learning.network.sees, "speed,leader_speed,gap,speed_limit");
    // The grid's limit of 13.89 m/s is the highest advice, action 1.
    assert!((config.learning.action_limits()[1] - 13.89).abs() < 0.01, "{:?}", config.learning.action_limits());
    let mut episode = begin(&config, 1);
    let mut late = 0;
    while !episode.is_over() {
        let known = agents(&episode);
        let outcome = hold(&mut episode, 5.0);
        if episode.is_over() {
            break;
        }
        let new: Vec<VehicleId> = episode.agents().filter(|id| !known.contains(&id.0)).collect();
        late += new.len();
        for agent in episode.world().agents() {
            assert_eq!(agent.snapshot().advice.is_none(), new.contains(&agent.id()), "{:?}", agent.id());
        }
        let seen = episode.observations();
        for (id, seen) in episode.agents().zip(&seen) {
            let before = outcome.agents.iter().find(|agent| agent.id == id);
            assert!(before.is_none_or(|agent| agent.last_seen == *seen), "what was seen last is seen now");
        }
    }
    assert!(late >= 4, "{late} came within holds");
}

#[test]
fn without_a_participant_a_drive_waits_for_the_first_advised_vehicle() {
    let _alone = one_at_a_time();
    let config = on_grid(json!({ "participant": false, "warm_up_s": 0.0, "hold_s": 2.0, "horizon_s": 60.0 }));
    let mut episode = begin(&config, 1);
    // The roads are empty at the beginning.
    let waited_s = episode.world().time_s();
    assert!(waited_s > 0.0 && (waited_s / 2.0).fract().abs() < 1e-9, "{waited_s} s are whole holds");
    let (mut holds, mut most) = (0, 0);
    while !episode.is_over() {
        let there = agents(&episode);
        assert!(!there.is_empty() && !there.contains(&EGO.0), "{there:?}");
        most = most.max(there.len());
        hold(&mut episode, 0.5);
        holds += 1;
    }
    assert!(most >= 3, "{most} at once");
    assert_eq!(waited_s + 2.0 * f64::from(holds), 60.0, "what was waited counts, too");
}

#[test]
fn rewards_are_the_mean_speeds_of_the_hold_less_penalties() {
    let penalties = json!({
        "traffic": "native", "advised": "2", "levels": 3, "warm_up_s": 20.0, "action_penalty": 0.75,
    });
    let of = |kind: &str| {
        let mut set = penalties.clone();
        set["reward"] = kind.into();
        let mut episode = begin(&on_ring(set), 5);
        let first = hold(&mut episode, 2.0);
        (first, hold(&mut episode, 1.0))
    };
    // The reference applies the same advice step by step and reads the speeds: 0.5 m/s2, then none.
    let set = json!({ "traffic": "native", "advised": "2", "levels": 3, "warm_up_s": 20.0, "hold_s": 1.0 });
    let config = on_ring(set);
    let scenario = Scenario { duration_s: 0.0, seed: 5, ..config.scenario.clone() };
    let mut outside = OfflineDriveFromOutside::new(&Scenario { policy: "constant".into(), ..scenario });
    let (mut all, mut own) = ([0.0; 2], [[0.0; 2]; 2]);
    for hold in 0..2 {
        for index in 0..2 {
            outside.world.advise(index, codrive::policy::Action::Acceleration([0.5, 0.0][hold]));
        }
        for _ in 0..10 {
            outside.step(false);
            let snapshot = outside.world.snapshot();
            let speeds: Vec<f64> = snapshot.speeds_mps().collect();
            all[hold] += speeds.iter().sum::<f64>() / 22.0 / 10.0;
            for (own, agent) in own[hold].iter_mut().zip(outside.world.agents()) {
                *own += agent.snapshot().ego.speed_mps / 10.0;
            }
        }
    }
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} and {b}");
    let (first, second) = of("all");
    near(first.mean_speed_mps(), all[0]);
    for agent in 0..2 {
        // The largest acceleration costs the whole penalty, none costs nothing.
        near(first.agents[agent].reward, all[0] - 0.75);
        near(second.agents[agent].reward, all[1]);
    }
    let (first, second) = of("ego");
    for (agent, own_mps) in first.agents.iter().zip(own[0]) {
        near(agent.reward, own_mps - 0.75);
    }
    for (agent, own_mps) in second.agents.iter().zip(own[1]) {
        near(agent.reward, own_mps);
    }
    assert!((own[1][0] - own[1][1]).abs() > 0.01, "two vehicles with speeds of their own: {own:?}");
}

#[test]
fn the_horizon_ends_an_episode_and_so_does_a_contact_with_its_penalty() {
    let ends = on_ring(json!({ "traffic": "native", "warm_up_s": 0.0, "hold_s": 2.0, "horizon_s": 6.0 }));
    let mut episode = begin(&ends, 1);
    let truncated: Vec<bool> = (0..3).map(|_| hold(&mut episode, 0.0).is_truncated).collect();
    assert_eq!(truncated, [false, false, true]);
    assert!(episode.is_over() && episode.agents().len() == 0 && episode.observations().is_empty());
    assert!(matches!(episode.hold(&[]), Err(EpisodeError::Over)));
    // The driver follows the advice of 15 m/s exactly, whatever is ahead; the leader starts at a standstill.
    let set = json!({
        "traffic": "native", "vehicles": 10, "warm_up_s": 0.0, "start": "even", "hold_s": 5.0, "horizon_s": 100.0, "advised": "2",
        "action": "speed", "levels": 2, "top_speed_mps": 15.0, "collision_penalty": 40.0,
    });
    let crash = config_of("ring-250", Some("exact"), Demand::default(), set).expect("settings");
    let mut episode = begin(&crash, 1);
    let mut outcome = hold(&mut episode, 1.0);
    while !episode.is_over() {
        assert!(outcome.agents.iter().all(|agent| !agent.is_terminated));
        outcome = hold(&mut episode, 1.0);
    }
    assert!(outcome.agents.iter().all(|agent| agent.is_terminated) && !outcome.is_truncated, "{outcome:?}");
    let world = episode.world();
    for (agent, rewarded) in world.agents().zip(&outcome.agents) {
        let penalty = if agent.contact_count() > 0 { 40.0 } else { 0.0 };
        assert!((rewarded.reward - (outcome.mean_speed_mps() - penalty)).abs() < 1e-9, "{rewarded:?}");
    }
    assert!(world.agents().any(|agent| agent.contact_count() > 0));
    // All vehicles stand for the rest of the hold, which lowers its mean by that part.
    let driven = world.snapshot().tick.0 % 500 / 10;
    assert!(driven > 0 && outcome.mean_speed_mps() < world.snapshot().mean_speed_mps.max(15.0) * driven as f64 / 50.0);
}

#[test]
fn drawn_drivers_differ_from_seed_to_seed_and_are_the_same_again() {
    let config = |driver: &str| {
        let set = json!({ "traffic": "native", "advised": "3", "warm_up_s": 5.0 });
        config_of("ring-250", Some(driver), Demand::default(), set).expect("settings")
    };
    let print = |driver: &str, seed: u64| {
        let mut episode = begin(&config(driver), seed);
        (0..5).for_each(|_| drop(hold(&mut episode, 0.5)));
        episode.fingerprint()
    };
    for driver in ["late", "people"] {
        assert_eq!(print(driver, 1), print(driver, 1), "{driver}");
        assert_ne!(print(driver, 1), print(driver, 2), "{driver}");
    }
    let all: BTreeSet<u64> = ["late", "people", "follow", "reaction=0.2"].map(|driver| print(driver, 1)).into();
    assert_eq!(all.len(), 4);
}

#[test]
fn unsuitable_settings_are_refused_with_the_allowed_values() {
    let fault_message =
        |map: &str, set: Value| config_of(map, None, Demand::default(), set).expect_err("no settings").message;
    for (set, begins) in [
        (json!({ "sees": "speed,signal_distance" }), "sees names `signal_distance`; this closed route has none"),
        (json!({ "sees": "speed,gapp" }), "sees names `gapp` (did you mean gap?); allowed: "),
        (json!({ "sees": "reaction" }), "sees names `reaction`, which whole drives do not have: the kind of driver"),
        (
            json!({ "sees": "controller_speed" }),
            "sees names `controller_speed`, which whole drives do not have: there is no controller",
        ),
        (json!({ "levels": 1 }), "levels is 1; allowed: 0"),
        (json!({ "horizon_s": 0.5 }), "horizon_s is 0.5; allowed: a number from 1 to 36000 s"),
        (json!({ "horizon_s": 10.0, "hold_s": 20.0 }), "hold_s is 20; allowed: at most the horizon of 10 s"),
        (json!({ "advised": "0" }), "advised is 0; allowed: at least one vehicle"),
        (json!({ "advised": "23" }), "advised is 23; allowed: 0 to 22"),
        (json!({ "traffic": "native", "path": "a b" }), "traffic is native; allowed with a path"),
        (json!({ "hold_s": 0.25 }), "hold_s is 0.25; allowed: a whole number of steps"),
    ] {
        let fault_message = fault_message("ring-250", set);
        assert!(fault_message.starts_with(begins), "{fault_message}");
    }
    assert!(fault_message("rnig-250", json!({})).contains("rnig-250"));
    assert!(fault_message("ring-250", json!({ "path": "nowhere" })).contains("nowhere"));
    for (key, word) in [
        ("residual_over", "the action is the whole advice"),
        ("residual_mps", "the action is the whole advice"),
        ("policy", "the actions of an episode are its advice"),
        ("sham_advice", "the actions of an episode are its advice"),
        ("duration_s", "horizon_s"),
        ("truck_share", "rings"),
    ] {
        assert!(EpisodeConfig::why_not(key).expect(key).contains(word), "{key}");
        assert!(EpisodeConfig::fields().iter().all(|field| field.path != key));
    }
    assert_eq!((EpisodeConfig::why_not("hold_s"), EpisodeConfig::why_not("nothing")), (None, None));
    let mut episode = begin(&on_ring(json!({ "traffic": "native", "advised": "2", "warm_up_s": 0.0 })), 1);
    let why = episode.hold(&[0.0]).expect_err("one of two").to_string();
    assert_eq!(why, "1 actions; allowed: 2, one for each present advised vehicle");
    let why = episode.hold(&[0.0, f32::NAN]).expect_err("no number").to_string();
    assert_eq!(why, "the action of vehicle_11 is NaN; allowed: a finite number; -1 to 1 spans the limits");
    assert!(!episode.is_over() && episode.hold(&[0.0, 0.5]).is_ok(), "what was refused has changed nothing");
}

#[test]
fn the_drive_of_python_is_that_of_rust() {
    let set = json!({
        "traffic": "native", "advised": "3", "action": "speed", "hold_s": 2.0, "horizon_s": 20.0, "warm_up_s": 30.0,
    });
    let config = config_of("ring-250", Some("late"), Demand::default(), set).expect("settings");
    let mut episode = begin(&config, 7);
    let mut text = String::from(
        "hold, reward of the first and of the last agent, FNV-1a of the observations (f32); hash of all states so far\n",
    );
    for hold in 0..10 {
        let drawn = |k: usize| ((k * 7 + hold * 3) % 11) as f32 / 5.0 - 1.0;
        let actions: Vec<f32> = (0..3).map(drawn).collect();
        let outcome = episode.hold(&actions).expect("a hold");
        let seen = episode.scaled(outcome.agents.iter().map(|agent| agent.last_seen));
        let seen = seen.iter().fold(rng::FNV_START, |hash, number| rng::fnv_1a(hash, &number.to_le_bytes()));
        let rewards = [0, 2].map(|k| outcome.agents[k].reward);
        let states = episode.fingerprint();
        let _ = writeln!(text, "{hold} {:?} {:?} {seen:016x} {states:016x}", rewards[0], rewards[1]);
    }
    assert!(episode.is_over());
    assert!(text == EXPECTED, "python/tests/drive.txt is not what drives do now, which is:\n{text}");
}

#[test]
fn the_circumference_is_an_input_if_its_scale_suits_the_road() {
    let config = |map: &str, set: Value| config_of(map, None, Demand::default(), set);
    let seen = |map: &str, set: Value| {
        let inputs = config(map, set).expect("settings").inputs();
        inputs.iter().map(|input| input.feature.name()).collect::<Vec<_>>().join(",")
    };
    for ring in ["ring-250", "ring-641"] {
        assert_eq!(seen(ring, json!({})), "speed,leader_speed,gap,circumference", "{ring}");
        // On a ring the circumference is an input, whatever scale is set.
        let far = json!({ "scaling.circumference_from_m": 1.0, "scaling.circumference_to_m": 2.0 });
        assert_eq!(seen(ring, far), "speed,leader_speed,gap,circumference", "{ring}");
    }
    assert_eq!(seen("practice", json!({})), "speed,leader_speed,gap,speed_limit");
    let why = config("practice", json!({ "sees": "speed,circumference" })).expect_err("beyond the scale").message;
    assert!(why.starts_with("sees names `circumference`, which is 17") && why.contains("200 to 300 m"), "{why}");
    assert!(why.contains("remedy: set scaling.circumference_from_m"), "{why}");
    let about_it = json!({ "scaling.circumference_from_m": 1500.0, "scaling.circumference_to_m": 2000.0 });
    assert_eq!(seen("practice", about_it), "speed,leader_speed,gap,circumference");
}
