//! Several advised vehicles in one world, all full agents: each with its own body, driver, policy and view.

use crate::world::one_at_a_time;
use codrive::{
    controls::Controls,
    driver::{SimulatedDriver, preset},
    idm::IdmParams,
    scenario::{AdvisedBody, AdvisedVehicles, DisplaySettings, OnContact, Scenario},
    sim::{EndReason, EventKind, Snapshot, World},
    space::CAR_LENGTH_M,
};

fn scenario(traffic: &str, advised: u32) -> Scenario {
    Scenario {
        traffic: traffic.parse().expect("an engine"),
        advised: AdvisedVehicles::Count(advised),
        advised_body: AdvisedBody::Full,
        policy: "pi".into(),
        duration_s: 0.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    }
}

/// Runs a drive with the simulated driver; `look` sees the world after each tick.
fn drive(scenario: &Scenario, seconds: f64, look: impl FnMut(&World)) -> World {
    drive_by(&scenario.driver, scenario, seconds, look)
}

/// Runs a drive with another driver in the participant's vehicle.
fn drive_by(driver: &str, scenario: &Scenario, seconds: f64, mut look: impl FnMut(&World)) -> World {
    let mut world = World::new(scenario).unwrap_or_else(|error| panic!("{error}"));
    let params = preset(driver).expect("a preset");
    let mut driver = SimulatedDriver::new(&params, world.ego_params(), scenario.seed).expect("a driver");
    for _ in 0..(seconds * 100.0) as usize {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("the engine goes on");
        look(&world);
    }
    world
}

fn numbers(world: &World) -> Vec<u32> {
    world.advised_others().iter().map(|agent| agent.id().0).collect()
}

#[test]
fn each_advised_vehicle_sees_all_others_and_is_seen_at_its_body() {
    // Of 22 vehicles, four are advised: 0, 22/4, 44/4, 66/4, rounded down.
    let mut advised_s = [0; 3];
    let world = drive(&scenario("native", 4), 20.0, |world| {
        for (agent, ticks) in world.advised_others().iter().zip(&mut advised_s) {
            *ticks += u32::from(agent.snapshot().advice.is_some());
        }
    });
    assert_eq!(numbers(&world), [5, 11, 16]);
    assert!(advised_s.iter().all(|ticks| *ticks > 1900), "each is advised from the start: {advised_s:?}");
    let (ego, route) = (world.snapshot(), &world.map().route);
    for agent in world.advised_others() {
        let own = agent.snapshot();
        assert_eq!(own.tick, ego.tick);
        assert!(own.ego.speed_mps > 0.5 && agent.controls() != &Controls::default(), "it drives");
        // The others are sorted by number, without the vehicle itself, the participant's first.
        let seen: Vec<u32> = own.cars.iter().map(|car| car.id.0).collect();
        assert_eq!(seen, (0..22).filter(|id| *id != agent.id().0).collect::<Vec<_>>());
        let participant = &own.cars[0];
        assert_eq!((participant.s_m, participant.speed_mps), (Some(ego.ego_s_m), ego.ego.speed_mps));
        // The next vehicle in driving order is the leader, at the position that the participant sees.
        let place = |id: u32| ego.cars[id as usize - 1];
        let (itself, next) = (place(agent.id().0), place(agent.id().0 + 1));
        assert_eq!((itself.s_m, itself.speed_mps), (Some(own.ego_s_m), own.ego.speed_mps));
        assert!(itself.pose.position.distance(own.ego.pose().position) < 1e-9);
        assert_eq!(itself.lamps.brake, own.ego.braking);
        let leader = own.leader.expect("a leader");
        assert_eq!(leader.id, next.id);
        let gap_m = route.ahead(own.ego_s_m, next.s_m.expect("on the ring")) - CAR_LENGTH_M;
        assert!((leader.gap_m - gap_m).abs() < 1e-9, "{leader:?} and {gap_m}");
        assert!((own.mean_speed_mps - ego.mean_speed_mps).abs() < 1e-9, "one mean of all");
        // The wheel angle follows the distance from the start, which is a standstill.
        let start_m = 250.0 / 22.0 * f64::from(agent.id().0);
        assert!((itself.odometer_m - route.ahead(start_m, own.ego_s_m)).abs() < 0.3, "{}", itself.odometer_m);
    }
}

#[test]
fn traffic_keeps_behind_vehicles_that_are_advised_to_crawl() {
    let _guard = one_at_a_time();
    for engine in ["native", "sumo"] {
        let slow = Scenario { policy: "constant".into(), policy_speed_mps: 2.0, ..scenario(engine, 3) };
        let (mut least_m, mut contacts) = (f64::INFINITY, 0);
        // The participant ignores advice: two other vehicles alone slow all vehicles down.
        let world = drive_by("idm", &slow, 60.0, |world| {
            let snapshot = world.snapshot();
            let mut places: Vec<f64> = snapshot.cars.iter().filter_map(|car| car.s_m).collect();
            places.push(snapshot.ego_s_m);
            assert_eq!(places.len(), 22);
            places.sort_by(f64::total_cmp);
            least_m = places.windows(2).map(|pair| pair[1] - pair[0] - CAR_LENGTH_M).fold(least_m, f64::min);
            contacts += world.events().iter().filter(|event| matches!(event.kind, EventKind::Contact { .. })).count();
        });
        assert!(least_m > 1.0, "{engine}: {least_m} m");
        assert!(contacts == 0 && world.advised_others().iter().all(|agent| agent.contact_count() == 0), "{engine}");
        // No vehicle passes: all slow down to the advice of these two, within the drivers' errors of 0.3 m/s.
        let mean_mps = world.snapshot().mean_speed_mps;
        assert!((1.6..2.4).contains(&mean_mps), "{engine}: {mean_mps} m/s");
    }
}

/// Returns the hashes of every tick of all views, the participant's first.
fn hashes(scenario: &Scenario, seconds: f64) -> Vec<u64> {
    let mut chain = vec![0; scenario.advised.of(scenario.vehicles) as usize];
    drive(scenario, seconds, |world| {
        let views = std::iter::once(world.snapshot()).chain(world.advised_others().iter().map(|a| a.snapshot()));
        for (hash, view) in chain.iter_mut().zip(views) {
            *hash = Snapshot::hash(view, *hash);
        }
    });
    chain
}

#[test]
fn same_seed_same_bits_with_several_advised_vehicles_on_both_engines() {
    let _guard = one_at_a_time();
    for engine in ["native", "sumo"] {
        let first = hashes(&scenario(engine, 3), 20.0);
        assert_eq!(first, hashes(&scenario(engine, 3), 20.0), "{engine}");
        assert_ne!(first, hashes(&Scenario { seed: 2, ..scenario(engine, 3) }, 20.0), "{engine}");
    }
}

#[test]
fn the_engines_agree_on_a_drive_with_several_advised_vehicles() {
    let _guard = one_at_a_time();
    let [native, sumo] = ["native", "sumo"].map(|engine| {
        let still = Scenario { idm: IdmParams { noise: 0.0, ..IdmParams::default() }, ..scenario(engine, 4) };
        let mut speeds = Vec::new();
        drive(&still, 30.0, |world| {
            speeds.push(world.snapshot().cars.iter().map(|car| car.speed_mps).collect::<Vec<_>>())
        });
        speeds
    });
    let pairs = native.iter().flatten().zip(sumo.iter().flatten());
    let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Only rounding differs (tests/traffic: contract), amplified by the physics in 32 bits.
    assert!(most < 0.01, "{most} m/s");
}

#[test]
fn drivers_of_advised_vehicles_have_streams_of_their_own() {
    // Two vehicles are opposite to each other on an even ring without noise: any difference comes from their drivers' errors.
    let even = Scenario { idm: IdmParams { noise: 0.0, ..IdmParams::default() }, ..scenario("native", 4) };
    let world = drive(&even, 10.0, |_| ());
    let speeds: Vec<f64> = world.advised_others().iter().map(|agent| agent.snapshot().ego.speed_mps).collect();
    let apart = |a: usize, b: usize| (speeds[a] - speeds[b]).abs();
    assert!(apart(0, 1) > 1e-3 && apart(1, 2) > 1e-3 && apart(0, 2) > 1e-3, "{speeds:?}");
    // The driver of a vehicle does not depend on the number of other advised vehicles, and neither do its first controls.
    let first = |advised: u32| {
        let world = drive(&scenario("native", advised), 0.01, |_| ());
        world.advised_others().iter().find(|agent| agent.id().0 == 11).map(|agent| *agent.controls())
    };
    assert!(first(2).is_some());
    assert_eq!(first(2), first(4));
}

#[test]
fn a_contact_of_two_advised_vehicles_is_reported_for_both() {
    let crawl = Scenario {
        vehicles: 2,
        policy: "constant".into(),
        policy_speed_mps: 2.0,
        contact: OnContact::End,
        ..scenario("native", 2)
    };
    let mut world = World::new(&crawl).expect("a world");
    let mut driver =
        SimulatedDriver::new(&preset("follow").expect("a preset"), world.ego_params(), 1).expect("a driver");
    let mut touched = None;
    while world.ended().is_none() {
        // Steers like the simulated driver, and does not brake.
        let steered = driver.controls(&world.perceived_by(&driver));
        let controls = Controls { throttle: 0.4, brake: 0.0, ..steered };
        world.tick(&controls).expect("the engine goes on");
        let tick = world.snapshot().tick;
        assert!(tick.seconds() < 60.0, "120 m at 2 m/s");
        touched = touched.or((world.advised_others()[0].contact_count() > 0).then_some(tick));
    }
    assert_eq!(world.ended(), Some(EndReason::Contact));
    let contact = world.events().iter().find_map(|event| match event.kind {
        EventKind::Contact { car, closing_mps, car_speed_mps, .. } => Some((car.0, closing_mps, car_speed_mps)),
        _ => None,
    });
    let (car, closing_mps, car_speed_mps) = contact.expect("the contact");
    assert!(car == 1 && closing_mps > 3.0 && (1.0..3.0).contains(&car_speed_mps), "{closing_mps} {car_speed_mps}");
    assert_eq!(touched, Some(world.snapshot().tick), "the other knows it at the same tick");
    let back = world.advised_others()[0].events().iter().find_map(|event| match event.kind {
        EventKind::Contact { car, closing_mps, .. } => Some((car.0, closing_mps)),
        _ => None,
    });
    let (car, back_mps) = back.expect("its contact");
    assert!(car == 0 && (back_mps - closing_mps).abs() < 0.5, "{back_mps} and {closing_mps} m/s");
}

#[test]
fn a_drive_without_a_policy_keeps_the_drivers_and_share_0_has_none() {
    // A driver who ignores advice drives the same with a policy and without one.
    let of = |policy: &str, advised: u32| Scenario {
        policy: policy.into(),
        driver: "idm".into(),
        ..scenario("native", advised)
    };
    let driven = |scenario: &Scenario| {
        let world = drive(scenario, 20.0, |_| ());
        let speeds_mps: Vec<(u32, f64)> = world.snapshot().numbered_speeds_mps().collect();
        (numbers(&world), world.ever_advised().len(), speeds_mps)
    };
    let (with, without, alone) = (driven(&of("pi", 4)), driven(&of("none", 4)), driven(&of("none", 0)));
    assert_eq!((&with.0, with.1), (&vec![5, 11, 16], 3));
    assert_eq!((&without.0, without.1), (&vec![5, 11, 16], 0), "no vehicle had advice");
    assert_eq!(without.2, with.2, "as with advice that is ignored");
    assert!(alone.0.is_empty() && alone.2 != without.2, "the engine drives otherwise");
    let unadvised = drive(&scenario("native", 0), 1.0, |world| assert_eq!(world.snapshot().advice, None));
    assert_eq!(unadvised.policy().name, "none");
    assert!(unadvised.policy().to_string().contains("no vehicle is advised"), "{}", unadvised.policy());
}
