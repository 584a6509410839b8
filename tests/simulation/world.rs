//! The whole world without a window: determinism, events, and the ego among vehicles that SUMO moves.

use codrive::{
    controls::Controls,
    driver::{SimulatedDriver, preset},
    policy::{self, ExpectedGain, Feature, Network, NetworkInput, NetworkLayer},
    scenario::{DisplaySettings, OnContact, Scenario},
    sim::{EndReason, EventKind, NotPutBack, Snapshot, World},
    space::CAR_LENGTH_M,
};
use std::{
    fs,
    sync::{Mutex, MutexGuard},
};

/// libsumo's state belongs to the process: one world with SUMO at a time.
static SUMO: Mutex<()> = Mutex::new(());

pub fn one_at_a_time() -> MutexGuard<'static, ()> {
    SUMO.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn scenario(traffic: &str) -> Scenario {
    Scenario { traffic: traffic.parse().unwrap(), duration_s: 0.0, ..Scenario::default() }
}

const STANDING: Controls = Controls {
    throttle: 0.0,
    brake: 1.0,
    steering_wheel_rad: 0.0,
    selector: codrive::controls::Selector::Drive,
    indicator: codrive::controls::Indicator::Off,
    main_beam: false,
    task_button: codrive::controls::TaskButton::None,
    automation_button: false,
    gap_button: false,
    hand_torque_nm: None,
};

/// Returns every snapshot of `seconds` of a drive by the simulated driver.
fn drive(scenario: &Scenario, seconds: f64) -> Vec<Snapshot> {
    let mut world = World::new(scenario).unwrap();
    let params = preset(&scenario.driver).unwrap();
    let mut driver = SimulatedDriver::new(&params, world.ego_params(), scenario.seed).unwrap();
    (0..(seconds * 100.0) as usize)
        .map(|_| {
            let controls = driver.controls(&world.perceived_by(&driver));
            world.tick(&controls).unwrap();
            world.snapshot().clone()
        })
        .collect()
}

#[test]
fn a_car_off_the_road_is_put_back_into_its_gap_without_a_contact() {
    let mut world = World::new(&Scenario {
        vehicles: 8,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..scenario("native")
    })
    .unwrap();
    assert_eq!(world.put_back(), Err(NotPutBack::OnLane));
    let away = Controls { throttle: 0.6, steering_wheel_rad: 4.0, ..Controls::default() };
    for _ in 0..3000 {
        world.tick(&away).unwrap();
        if world.snapshot().lane_offset_m.abs() > 6.0 {
            break;
        }
    }
    assert!(world.is_astray() && world.snapshot().lane_offset_m.abs() > 6.0);
    let left_at_m = world.snapshot().ego_s_m;
    // Other vehicles may pass the position: then there is no room at first, but later there is.
    let waited = (0..3000).find(|_| {
        let done = world.put_back();
        assert!(done != Err(NotPutBack::OnLane) && done != Err(NotPutBack::Over), "{done:?}");
        world.tick(&STANDING).unwrap();
        done.is_ok()
    });
    assert!(waited.is_some(), "30 s without a gap of seven metres among eight cars on 250 m");
    let put: Vec<f64> = world
        .events()
        .iter()
        .filter_map(|event| if let EventKind::PutBack { s_m } = event.kind { Some(s_m) } else { None })
        .collect();
    let [s_m] = put[..] else { panic!("{:?}", world.events()) };
    let snapshot = world.snapshot();
    assert!(!world.is_astray() && snapshot.lane_offset_m.abs() < 0.1, "{} m beside the lane", snapshot.lane_offset_m);
    let route = &world.map().route;
    assert!((snapshot.ego_s_m - s_m).abs() < 0.5 && route.difference(left_at_m, s_m).abs() < 40.0);
    let leader = snapshot.leader.unwrap();
    let behind_m =
        snapshot.cars.iter().map(|car| route.ahead(car.s_m.unwrap(), s_m) - CAR_LENGTH_M).fold(f64::MAX, f64::min);
    assert!(leader.gap_m > 0.5 && behind_m > 0.5, "{} m ahead, {behind_m} m behind", leader.gap_m);
    assert!(snapshot.ego.speed_mps <= leader.speed_mps + 0.2, "not faster than who is ahead");
    for _ in 0..300 {
        world.tick(&STANDING).unwrap();
        assert!(!world.events().iter().any(|event| matches!(event.kind, EventKind::Contact { .. })), "a contact");
    }
}

/// Returns the first tick at which two drives differ, found by bisection over chained hashes, with the field and both values.
fn first_difference(a: &[Snapshot], b: &[Snapshot]) -> Option<(u64, String, f64, f64)> {
    let chain = |snapshots: &[Snapshot]| -> Vec<u64> {
        snapshots
            .iter()
            .scan(0, |hash, snapshot| {
                *hash = snapshot.hash(*hash);
                Some(*hash)
            })
            .collect()
    };
    let (ha, hb) = (chain(a), chain(b));
    let (mut same, mut different) = (0, ha.len().min(hb.len()));
    if ha == hb {
        return None;
    }
    while same < different {
        let middle = (same + different) / 2;
        if ha[middle] == hb[middle] { same = middle + 1 } else { different = middle }
    }
    let (name, mine, theirs) = a[same].first_difference(&b[same]).expect("their hashes differ");
    Some((a[same].tick.0, name, mine, theirs))
}

#[test]
fn same_seed_and_inputs_give_the_same_bits_with_both_engines() {
    let _guard = one_at_a_time();
    for engine in ["sumo", "native"] {
        let (a, b) = (drive(&scenario(engine), 40.0), drive(&scenario(engine), 40.0));
        assert_eq!(first_difference(&a, &b), None, "{engine}: first differing tick, field and values");
    }
}

#[test]
fn another_input_is_found_at_its_very_tick() {
    let run = |touched: Option<usize>| -> Vec<Snapshot> {
        let mut world = World::new(&scenario("native")).unwrap();
        (0..500)
            .map(|tick| {
                let throttle = if touched == Some(tick) { 0.201 } else { 0.2 };
                world.tick(&Controls { throttle, ..Controls::default() }).unwrap();
                world.snapshot().clone()
            })
            .collect()
    };
    let (tick, ..) = first_difference(&run(None), &run(Some(321))).unwrap();
    assert_eq!(tick, 322, "the tick that ends after the 322nd input");
}

#[test]
fn sumo_and_the_native_engine_move_21_cars_alike() {
    let _guard = one_at_a_time();
    let quiet = |engine| {
        let mut s = scenario(engine);
        s.idm.noise = 0.0;
        s.driver = "perfect".into();
        s
    };
    let (sumo, native) = (drive(&quiet("sumo"), 60.0), drive(&quiet("native"), 60.0));
    let farthest = sumo
        .iter()
        .zip(&native)
        .flat_map(|(a, b)| a.cars.iter().zip(&b.cars).map(|(a, b)| (a.speed_mps - b.speed_mps).abs()))
        .fold(0.0, f64::max);
    assert_eq!(sumo[0].cars.len(), 21);
    assert!(farthest < 0.02, "speeds of the engines differ by up to {farthest} m/s");
}

#[test]
fn traffic_matches_the_engine_at_each_step_and_moves_evenly_between() {
    let mut world = World::new(&scenario("native")).unwrap();
    let mut before: Vec<f64> = world.snapshot().cars.iter().map(|car| car.s_m.unwrap()).collect();
    let route = world.map().route.clone();
    for step in 0..100 {
        let moved: Vec<Vec<f64>> = (0..10)
            .map(|_| {
                world.tick(&Controls { throttle: 0.15, ..Controls::default() }).unwrap();
                let now: Vec<f64> = world.snapshot().cars.iter().map(|car| car.s_m.unwrap()).collect();
                let way = now.iter().zip(&before).map(|(now, then)| route.difference(*then, *now)).collect();
                before = now;
                way
            })
            .collect();
        for later in &moved[1..] {
            for (car, (way, first)) in later.iter().zip(&moved[0]).enumerate() {
                assert!((way - first).abs() < 1e-9, "car {car} jumps by {} m in step {step}", way - first);
            }
        }
    }
}

#[test]
fn a_silent_policy_shows_no_advice_and_causes_an_event() {
    // The policy expects a gain of 2 m/s at a standstill, and 1 m/s less per m/s of speed.
    let mut network = Network::from_file(&policy::file_of("ring-250-speed").unwrap()).unwrap();
    network.expected_gain = Some(ExpectedGain {
        silent_below_mps: 0.0,
        inputs: vec![NetworkInput { feature: Feature::Speed, from: 1.0, to: 3.0 }],
        layers: vec![NetworkLayer { bias: vec![0.0], weights: vec![vec![-1.0]] }],
    });
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("policy.toml");
    fs::write(&file, network.to_toml()).unwrap();
    let scenario = Scenario { policy: file.display().to_string(), ..scenario("native") };
    let mut world = World::new(&scenario).unwrap();
    let mut driver = SimulatedDriver::new(&preset("perfect").unwrap(), world.ego_params(), 1).unwrap();
    let (mut withheld, mut issued) = (Vec::new(), Vec::new());
    for _ in 0..3000 {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).unwrap();
        for event in world.events() {
            match event.kind {
                EventKind::Advice(_) => issued.push(event.tick),
                EventKind::AdviceWithheld => withheld.push((event.tick, world.snapshot().ego.speed_mps)),
                _ => {}
            }
        }
        assert_eq!(world.snapshot().advice.is_some(), withheld.is_empty() && !issued.is_empty());
    }
    // Advice is withheld once, in the first second at more than 2 m/s; the silence lasts for ten minutes.
    let [(tick, speed_mps)] = withheld[..] else { panic!("{withheld:?}") };
    assert!(tick.0.is_multiple_of(100) && (2.0..3.6).contains(&speed_mps), "{withheld:?}");
    assert!(issued.iter().all(|issued| *issued < tick) && issued.len() > 1);
}

#[test]
fn the_queue_stands_behind_a_stopped_ego_and_no_vehicle_passes() {
    let _guard = one_at_a_time();
    for engine in ["sumo", "native"] {
        let mut world = World::new(&scenario(engine)).unwrap();
        let start = world.snapshot().ego.position;
        for _ in 0..12_000 {
            world.tick(&STANDING).unwrap();
            assert!(world.events().iter().all(|e| matches!(e.kind, EventKind::Advice(_))), "{:?}", world.events());
        }
        let snapshot = world.snapshot();
        assert!((snapshot.ego.position - start).length() < 0.001, "{engine}: the ego stood");
        let fastest = snapshot.cars.iter().map(|car| car.speed_mps).fold(0.0, f64::max);
        assert!(fastest < 0.05, "{engine}: a car still moves at {fastest} m/s");
        // The last vehicle is the ego's follower, the first its leader: all stand in order, with gaps.
        let route = &world.map().route;
        let mut ahead = snapshot.ego_s_m;
        for car in snapshot.cars.iter().rev() {
            let gap_m = route.ahead(car.s_m.unwrap(), ahead) - CAR_LENGTH_M;
            assert!((1.0..4.5).contains(&gap_m), "{engine}: car {} stands {gap_m} m behind", car.id.0);
            ahead = car.s_m.unwrap();
        }
    }
}

#[test]
fn a_contact_with_the_leader_is_an_event_and_can_end_the_drive() {
    for (contact, ends) in [(OnContact::Continue, false), (OnContact::End, true)] {
        let mut world = World::new(&Scenario { contact, ..scenario("native") }).unwrap();
        let mut contacts = Vec::new();
        for _ in 0..1500 {
            let hint = world.lane_hint();
            let steer = (2.8 * hint.curvature).atan() - 0.9 * hint.heading_error_rad - 0.06 * hint.offset_m;
            let throttle: f32 = if contacts.is_empty() { 0.6 } else { 0.0 };
            let brake = 0.5 - throttle.min(0.5);
            let controls = Controls { throttle, brake, steering_wheel_rad: 15.0 * steer as f32, ..Controls::default() };
            world.tick(&controls).unwrap();
            contacts.extend(world.events().iter().filter(|e| matches!(e.kind, EventKind::Contact { .. })).copied());
        }
        let EventKind::Contact { car, ego_speed_mps, car_speed_mps, closing_mps, angle_rad, .. } = contacts[0].kind
        else {
            panic!("only contacts were kept")
        };
        assert_eq!(car.0, 1, "the leader");
        assert!(ego_speed_mps > car_speed_mps && closing_mps > 0.5, "{:?}", contacts[0]);
        // On the ring of 39.8 m radius, the leader 5 m ahead points 0.126 rad further to the left.
        assert!((angle_rad - 0.126).abs() < 0.05, "{angle_rad}");
        assert!(contacts[0].tick.seconds() > 0.5);
        assert_eq!(world.ended() == Some(EndReason::Contact), ends);
        if ends {
            assert_eq!(world.snapshot().tick, contacts[0].tick, "the drive stands where it ended");
        } else {
            assert_eq!(world.snapshot().tick.0, 1500);
            let gap_m = world.snapshot().leader.unwrap().gap_m;
            assert!(gap_m > 0.0, "the ego is behind its leader, not inside it: {gap_m} m");
        }
    }
}

#[test]
fn leaving_the_road_is_an_event_grass_is_slow_and_coming_back_is_an_event() {
    let mut world = World::new(&scenario("native")).unwrap();
    let mut kinds = Vec::new();
    let mut tick = |world: &mut World, controls: &Controls| {
        world.tick(controls).unwrap();
        let edges = |k: &EventKind| matches!(k, EventKind::LeftRoad { .. } | EventKind::BackOnRoad);
        kinds.extend(world.events().iter().map(|e| e.kind).filter(edges));
    };
    // The ego drives straight on, out of the bend.
    for _ in 0..800 {
        tick(&mut world, &Controls { throttle: 0.25, ..Controls::default() });
    }
    assert!(world.snapshot().lane_offset_m < -3.0, "a left-hand bend is left to the right");
    // It returns by steering left, slowly.
    for _ in 0..4000 {
        let slow = world.snapshot().ego.speed_mps < 3.0;
        let steer = if world.snapshot().lane_offset_m < -1.0 { 5.0 } else { 1.05 };
        let throttle = if slow { 0.5 } else { 0.0 };
        tick(&mut world, &Controls { throttle, steering_wheel_rad: steer, ..Controls::default() });
        if world.snapshot().lane_offset_m.abs() < 0.5 {
            break;
        }
    }
    assert!(matches!(kinds[0], EventKind::LeftRoad { offset_m, .. } if offset_m < -1.8), "{kinds:?}");
    assert_eq!(kinds[1], EventKind::BackOnRoad, "{kinds:?}");
}

#[test]
fn a_warm_up_hands_a_moving_ego_over_in_the_middle_of_the_wave() {
    let _guard = one_at_a_time();
    let world = World::new(&Scenario { warm_up_s: 400.0, ..scenario("sumo") }).unwrap();
    let snapshot = world.snapshot();
    let speeds: Vec<f64> = snapshot.cars.iter().map(|car| car.speed_mps).collect();
    let slowest = speeds.iter().copied().fold(f64::INFINITY, f64::min);
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    // docs/references.md: ring: the saturated wave ranges from 0 to 9.6 m/s.
    assert!(slowest < 0.5 && fastest > 7.5, "{slowest} to {fastest} m/s");
    assert_eq!(snapshot.tick.0, 0);
    let gap_m = snapshot.leader.unwrap().gap_m;
    assert!(gap_m > 1.0, "{gap_m}");
}

#[test]
fn the_saturated_wave_runs_on_with_the_ego_on_rapier_and_advice_calms_it() {
    let _guard = one_at_a_time();
    let mean = |policy: &str, driver: &str| {
        let wave = Scenario { warm_up_s: 400.0, policy: policy.into(), driver: driver.into(), ..scenario("sumo") };
        let late = &drive(&wave, 300.0)[15_000..];
        late.iter().map(|snapshot| snapshot.mean_speed_mps).sum::<f64>() / late.len() as f64
    };
    // docs/references.md: ring: 3.00 m/s without advice. docs/references.md: advice: two-phase reaches its aim, here 98.5 % of 4.362 m/s.
    let without = mean("none", "idm");
    let with = mean("two-phase", "perfect");
    assert!((without - 3.0).abs() < 0.08, "{without}");
    assert!((with - 4.297).abs() < 0.08, "{with}");
}

#[test]
fn controls_come_later_by_the_extra_delay_to_the_tick() {
    let asked = |tick: usize| Controls {
        throttle: if tick % 70 < 40 { 0.6 } else { 0.0 },
        brake: if tick % 70 > 55 { 0.4 } else { 0.0 },
        steering_wheel_rad: 0.9 + 0.2 * (tick as f32 * 0.03).sin(),
        ..Controls::default()
    };
    let drive = |extra_delay_s: f64, controls: &dyn Fn(usize) -> Controls| -> Vec<Snapshot> {
        let mut world = World::new(&Scenario { extra_delay_s, ..scenario("native") }).unwrap();
        let tick = |tick| {
            world.tick(&controls(tick)).unwrap();
            world.snapshot().clone()
        };
        (0..400).map(tick).collect()
    };
    let later = |tick: usize| tick.checked_sub(15).map_or(Controls::default(), asked);
    assert_eq!(first_difference(&drive(0.15, &asked), &drive(0.0, &later)), None);
    assert!(first_difference(&drive(0.15, &asked), &drive(0.0, &asked)).is_some());
}

#[test]
fn a_drive_ends_at_its_duration_and_stays_there() {
    let mut world = World::new(&Scenario { duration_s: 1.5, ..scenario("native") }).unwrap();
    for _ in 0..400 {
        world.tick(&STANDING).unwrap();
    }
    assert_eq!((world.snapshot().tick.0, world.ended()), (150, Some(EndReason::Duration)));
}

#[test]
fn every_shipped_map_can_be_driven_a_lap_by_the_simulated_driver() {
    for (map, vehicles) in [("ring-250", 8), ("ring-641", 10), ("practice", 6)] {
        let free = Scenario { map: map.into(), vehicles, policy: "none".into(), ..scenario("native") };
        let snapshots = drive(&free, 240.0);
        let length_m = World::new(&free).unwrap().map().route.length_m();
        let way_m: f64 = snapshots.iter().map(|s| s.ego.speed_mps * 0.01).sum();
        let off_m = snapshots.iter().map(|s| s.lane_offset_m.abs()).fold(0.0, f64::max);
        assert!(way_m > length_m, "{map}: {way_m} of {length_m} m");
        assert!(off_m < 0.6, "{map}: {off_m} m off the centre line");
    }
}

#[cfg(feature = "desktop")]
#[test]
fn a_person_with_four_keys_and_slow_thumbs_holds_4_mps_in_the_lane() {
    use codrive::input::{DriveKey, Keyboard};
    let mut world = World::new(&Scenario { policy: "none".into(), ..scenario("native") }).unwrap();
    let mut keyboard = Keyboard::default();
    // This person looks at the dial five times a second, sees the trend of the needle, and acts 0.4 s later.
    let mut seen = std::collections::VecDeque::from([0.0, 0.0]);
    let (mut speeds, mut offsets) = (Vec::new(), Vec::new());
    for tick in 0..9000 {
        if tick % 20 == 0 {
            let ego = &world.snapshot().ego;
            seen.push_back(ego.speed_mps + 0.6 * ego.accel_mps2);
            let soon_mps = seen.pop_front().unwrap();
            keyboard.set(DriveKey::Throttle, soon_mps < 4.0);
            keyboard.set(DriveKey::Brake, soon_mps > 5.2);
        }
        let controls = keyboard.tick(world.snapshot().ego.speed_mps, Some(world.lane_hint()));
        world.tick(&controls).unwrap();
        if tick > 2000 {
            speeds.push(world.snapshot().ego.speed_mps);
            offsets.push(world.snapshot().lane_offset_m.abs());
        }
    }
    let (low, high) = speeds.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
    let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
    // The limit is half the width of the 250 m ring's useful band (+-1 mph, docs/references.md: band), on either side of the person's own
    // mean.
    assert!(high - low < 0.9 && (mean - 4.0).abs() < 0.3, "{low} to {high} m/s, mean {mean}");
    let off_m = offsets.iter().copied().fold(0.0, f64::max);
    assert!(off_m < 0.5, "{off_m} m off the centre line");
}

#[test]
fn a_policy_that_needs_driver_traits_is_refused_without_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("teacher.toml");
    let personal = policy::file_of("ring-250-personal").expect("it ships");
    let teacher = Network { estimator: None, ..Network::from_file(&personal).unwrap() };
    fs::write(&file, teacher.to_toml()).unwrap();
    let asked = |policy: String| World::new(&Scenario { policy, ..scenario("native") }).map_err(|e| e.to_string());
    let Err(printed) = asked(file.display().to_string()) else { panic!("it drives") };
    let words =
        "needs the driver's traits (reaction, speed_bias, tracking_error, time_gap_factor, willingness, latent_1, ";
    assert!(printed.contains("teacher.toml") && printed.contains(words) && printed.contains("remedy: "), "{printed}");
    // With its estimator, the policy infers the driver by itself.
    assert!(asked("ring-250-personal".into()).is_ok());
}

#[test]
fn a_policy_that_sees_the_whole_ring_is_refused_in_a_drive() {
    let policy = "assets/benchmarks/worlds/limit/gap-closers-people-1.toml";
    let drive = World::new(&Scenario { policy: policy.into(), ..scenario("native") });
    let printed = drive.map(|_| ()).unwrap_err().to_string();
    let words = "sees `ring_mean_speed`, which is known only while training and in codrive evaluate on fast rings";
    assert!(printed.contains(words) && printed.contains("remedy: "), "{printed}");
}
