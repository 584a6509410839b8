//! Tests of a world: observations of policies, lane help, put-back, sham advice, and a world whose engine was released.

use super::{
    advice::{limited_idm, policy_settings},
    agent::AgentBody,
    derived_state::update_derived,
    perception::LANE_HINT_SPAN_M,
    sham::other_drive,
    *,
};
use crate::{
    controls::Indicator,
    driver::{DriverParams, SimulatedDriver},
    ego::EgoCar,
    scenario::{PlanError, StartLayout},
    sim::VehicleSnapshot,
    space::{CAR_LENGTH_M, Pose},
    traffic::{EngineChoice, VehicleBody, VehicleId},
};
use std::f64::consts::{PI, TAU};

fn ring() -> World {
    World::new(&Scenario { traffic: EngineChoice::Native, ..Scenario::default() }).expect("the shipped ring")
}

/// Returns the participant's vehicle.
fn ego(world: &mut World) -> &mut Agent {
    world.observer.participant_mut().expect("a participant")
}

fn drive(world: &mut World, ticks: usize) {
    let controls = Controls { throttle: 0.3, steering_wheel_rad: 0.9, ..Controls::default() };
    for _ in 0..ticks {
        world.tick(&controls).expect("the native engine");
    }
}

#[test]
fn a_policy_observes_its_own_car_the_one_ahead_and_the_ring() {
    let mut world = ring();
    drive(&mut world, 250);
    let plan = world.drive().clone();
    let seen = ego(&mut world).observe(&plan);
    let snapshot = world.snapshot();
    assert!(seen.speed_mps > 0.5, "it drives: {seen:?}");
    assert_eq!(world.time_s(), 2.5, "250 ticks of 10 ms");
    assert_eq!(seen.speed_mps, snapshot.ego.speed_mps);
    // HC22: a ring of 250 m with 22 vehicles, the ego included; ids ascend in the direction of travel; vehicles are 5 m long.
    assert_eq!((seen.vehicles, seen.circumference_m.round()), (22, 250.0));
    let ahead = snapshot.cars.iter().find(|car| car.id.0 == 1).expect("the car ahead");
    assert_eq!(seen.leader_speed_mps, ahead.speed_mps);
    let gap_m = (ahead.s_m.unwrap() - snapshot.ego_s_m).rem_euclid(seen.circumference_m) - 5.0;
    assert!((seen.gap_m - gap_m).abs() < 1e-9, "{} and {gap_m}", seen.gap_m);
    // Vehicle 21, the last of the others, is behind the ego.
    let behind = snapshot.cars.iter().find(|car| car.id.0 == 21).expect("the car behind");
    let gap_m = (snapshot.ego_s_m - behind.s_m.unwrap()).rem_euclid(seen.circumference_m) - 5.0;
    let follower = seen.road.follower.expect("a follower");
    assert!((follower.gap_m - gap_m).abs() < 1e-9, "{follower:?} and {gap_m}");
    assert_eq!(follower.speed_mps, behind.speed_mps);
    // A circle of 250 m, without signals and without an end.
    assert!((seen.road.bend_per_m - TAU / 250.0).abs() < 0.02 * TAU / 250.0, "{:?}", seen.road);
    assert_eq!((seen.road.signal, seen.road.path_left_m), (None, None));
}

#[test]
fn lane_help_sees_the_bend_ahead_and_the_cars_offset_and_heading() {
    let mut world = ring();
    let hint = world.lane_hint();
    // A circle of 250 m bends by one turn over its length. Both bumpers start in the middle of the lane, so that the car's centre is inside
    // by 2.5 m squared over the circle's diameter.
    assert!((hint.curvature - TAU / 250.0).abs() < 0.02 * TAU / 250.0, "{}", hint.curvature);
    let inside_m = 2.5 * 2.5 / (250.0 / PI);
    assert!((hint.offset_m - inside_m).abs() < 0.01 && hint.heading_error_rad.abs() < 0.02, "{hint:?}");
    // Straight on in a left bend: the lane turns away to the left, the car is right of its centre line and points to the right of it.
    for _ in 0..300 {
        world.tick(&Controls { throttle: 0.3, ..Controls::default() }).expect("the native engine");
    }
    let hint = world.lane_hint();
    assert!(hint.offset_m < 0.0 && hint.heading_error_rad < -0.05, "{hint:?}");
    assert_eq!(hint.offset_m, world.snapshot().lane_offset_m);
}

#[test]
fn lane_help_looks_a_fifth_of_a_second_ahead() {
    let mut world =
        World::new(&Scenario { traffic: EngineChoice::Native, map: "practice".into(), ..Scenario::default() })
            .expect("the shipped circuit");
    let route = Arc::clone(world.map()).route.clone();
    // Start of the first bend: the road is straight before it and bent after it.
    let bent = |s_m: f64| route.curvature_at(s_m, LANE_HINT_SPAN_M).abs() > 0.01;
    let mut begins_m = 20.0;
    while bent(begins_m) || !bent(begins_m + 2.0) {
        begins_m += 0.5;
    }
    // 1 m before the bend a stopped car does not see it; at 20 m/s, 4 m ahead, it does.
    ego(&mut world).view.ego_s_m = begins_m - 1.0 + CAR_LENGTH_M / 2.0;
    ego(&mut world).view.ego.speed_mps = 0.0;
    assert!(world.lane_hint().curvature.abs() < 0.01);
    // Nor in reverse, at any speed.
    ego(&mut world).view.ego.speed_mps = -20.0;
    assert!(world.lane_hint().curvature.abs() < 0.01);
    ego(&mut world).view.ego.speed_mps = 20.0;
    assert!(world.lane_hint().curvature.abs() > 0.01);
}

#[test]
fn a_released_engine_keeps_its_name_and_makes_no_further_step() {
    let mut world = ring();
    drive(&mut world, 20);
    world.stop_traffic();
    assert_eq!(world.traffic_engine(), "native IDM", "a summary says which it was");
    let ends = (0..20).find_map(|_| world.tick(&Controls::default()).err()).expect("no step follows");
    assert!(ends.to_string().contains("this drive was stopped"), "{ends}");
}

#[test]
fn only_a_drive_with_an_end_can_be_extended() {
    let mut world = World::new(&Scenario { traffic: EngineChoice::Native, duration_s: 60.0, ..Scenario::default() })
        .expect("a world");
    world.extend(30.0);
    assert_eq!(world.scenario().duration_s, 90.0);
    let mut endless = World::new(&Scenario { traffic: EngineChoice::Native, duration_s: 0.0, ..Scenario::default() })
        .expect("a world");
    endless.extend(30.0);
    assert_eq!(endless.scenario().duration_s, 0.0, "0 is without an end");
}

#[test]
fn a_policys_equilibrium_speed_is_that_of_the_ring_with_even_gaps() {
    let world = ring();
    // docs/references.md: ring: 22 cars on 250 m flow at 4.362 m/s.
    let settings = policy_settings(world.drive());
    assert!((settings.equilibrium_mps - 4.362).abs() < 0.005, "{settings:?}");
    // The drivers' desired speed is capped by the road's limit.
    let quick =
        Scenario { idm: crate::idm::IdmParams { v0: 500.0, ..world.scenario().idm }, ..world.scenario().clone() };
    let limit_mps = world.map().route.speed_limit_mps(0.0);
    assert_eq!(limited_idm(&quick, &world.map().route).v0, limit_mps);
    let slow = Scenario { idm: crate::idm::IdmParams { v0: 5.0, ..world.scenario().idm }, ..world.scenario().clone() };
    assert_eq!(limited_idm(&slow, &world.map().route).v0, 5.0);
}

#[test]
fn vehicles_move_evenly_within_a_step_and_their_odometers_match() {
    let mut world = ring();
    let start: Vec<f64> = world.snapshot().cars.iter().map(|car| car.s_m.unwrap()).collect();
    drive(&mut world, 305);
    let length_m = world.map().route.length_m();
    let step = world.scenario().step_ticks();
    let fraction = f64::from((world.snapshot().tick.0 % step) as u32) / step as f64;
    let (begin_mps, end_mps) = world.traffic.speeds_mps();
    let speeds = begin_mps.iter().zip(&end_mps);
    for ((car, from), (begin_mps, end_mps)) in world.snapshot().cars.iter().zip(&start).zip(speeds) {
        let way_m = (car.s_m.unwrap() - from).rem_euclid(length_m);
        // The front drives on the circle; the centre, which counts the distance, is on a chord of 5 m and moves inside it.
        let inside = (1.0 - (TAU * 2.5 / length_m).powi(2)).sqrt();
        assert!((car.odometer_m - way_m * inside).abs() < 1e-3, "{} and {way_m}", car.odometer_m);
        let speed = begin_mps + fraction * (end_mps - begin_mps);
        assert!((car.speed_mps - speed).abs() < 1e-9, "{} and {speed} at {fraction} of the step", car.speed_mps);
    }
}

#[test]
fn the_ego_creeps_if_the_scenario_says_so() {
    for creep in [false, true] {
        let scenario = Scenario { traffic: EngineChoice::Native, creep, ..Scenario::default() };
        assert_eq!(World::new(&scenario).expect("a world").ego_params().gearbox.creep, creep);
    }
}

#[test]
fn an_error_names_the_settings_it_depends_on_the_most_likely_first() {
    assert_eq!(WorldError::NoParticipant.settings(), ["participant"]);
    let setting = |key| WorldError::Plan(PlanError::Setting { key, part: String::new(), message: String::new() });
    assert_eq!(setting("participant").settings(), ["participant", "demand", "map"]);
    let scenario = Scenario { traffic: EngineChoice::Native, vehicles: 1, ..Scenario::default() };
    let error = World::new(&scenario).err().expect("an ego alone on a ring");
    assert_eq!(error.settings(), ["vehicles", "map", "idm"], "{error}");
}

#[test]
fn the_egos_odometer_is_the_distance_that_it_drove() {
    let mut world = ring();
    let mut way_m = 0.0;
    for _ in 0..300 {
        drive(&mut world, 1);
        way_m += world.snapshot().ego.speed_mps * TICK_S;
    }
    let found_m = ego(&mut world).image.odometer_m;
    assert!(way_m > 1.0 && (found_m - way_m).abs() < 1e-9, "{found_m} and {way_m}");
}

#[test]
fn a_vehicle_that_turns_off_leads_until_its_rear_has_left_the_lane() {
    let world = ring();
    let route = &world.map().route;
    let (tail_m, turned_rad) = (130.0, PI / 3.0);
    let leader = |beside_m: f64| {
        let yaw_rad = route.yaw_at(tail_m) + turned_rad;
        let tail = route.point_at(tail_m) + glam::DVec2::from_angle(route.yaw_at(tail_m)).perp() * beside_m;
        let pose = Pose::new(tail + glam::DVec2::from_angle(yaw_rad) * (CAR_LENGTH_M / 2.0), yaw_rad);
        let body = VehicleBody::CAR;
        let car = VehicleSnapshot { id: VehicleId(7), pose, body, speed_mps: 4.0, ..VehicleSnapshot::default() };
        let mut snapshot = Snapshot { ego_s_m: 110.0, cars: vec![car], ..world.snapshot().clone() };
        update_derived(&mut snapshot, route);
        snapshot.leader
    };
    // At 60 degrees, half of 4 m/s is along the lane. Both vehicles are 1.8 m wide.
    for beside_m in [0.0, 1.7] {
        let found = leader(beside_m).expect("a leader");
        assert!((found.gap_m - 20.0).abs() < 0.1 && (found.speed_mps - 2.0).abs() < 0.01, "{found:?}");
    }
    assert!(leader(1.9).is_none() && leader(-1.9).is_none());
}

#[test]
fn a_car_that_is_put_back_is_one_metre_ahead_of_the_vehicle_behind() {
    let mut world = ring();
    let car = |id: u32, s_m: f64, speed_mps: f64| VehicleSnapshot {
        id: VehicleId(id),
        s_m: Some(s_m),
        speed_mps,
        body: VehicleBody::CAR,
        ..VehicleSnapshot::default()
    };
    let scenario = world.scenario().clone();
    let agent = ego(&mut world);
    // The ego's front is 3 m ahead of the vehicle behind; the ego needs its length of 5 m and a gap of 1 m.
    agent.view.cars = vec![car(1, 130.0, 4.0), car(2, 97.0, 3.0)];
    agent.view.ego_s_m = 100.0;
    agent.wants_back = true;
    agent.place_on_lane(&scenario).expect("there is room");
    assert_eq!(agent.view.ego_s_m, 103.0);
}

#[test]
fn the_ego_is_back_on_the_road_only_0_2_m_inside_the_edge() {
    let mut world = ring();
    // Asphalt: a lane of 3.6 m, and a shoulder of 0.4 m.
    let half_m = 3.6 / 2.0 + 0.4;
    let on_lane = Pose::new(world.map().route.point_at(30.0), world.map().route.yaw_at(30.0));
    let agent = ego(&mut world);
    let mut watch = |offset_m: f64| {
        let pose = Pose { position: on_lane.position + on_lane.left() * offset_m, ..on_lane };
        let car = EgoCar::new(&CarParams::default(), pose, 0.0, 21).expect("a car");
        agent.view.ego = *car.state();
        agent.body = AgentBody::Full(Box::new(car));
        agent.events.clear();
        agent.locate();
        agent.update_derived();
        agent.events.first().map(|event| event.kind)
    };
    assert_eq!(watch(half_m - 0.01), None, "at the edge the ego is still on the road");
    let left = watch(-half_m - 0.01);
    assert!(matches!(left, Some(EventKind::LeftRoad { .. })), "{left:?}");
    // No repeated events at the edge.
    assert_eq!([half_m + 0.1, half_m - 0.1, half_m - 0.19].map(&mut watch), [None, None, None]);
    assert_eq!(watch(half_m - 0.21), Some(EventKind::BackOnRoad));
}

/// Returns every advice of a drive by the simulated driver: issue time, s, and target, m/s.
fn advised(scenario: &Scenario) -> Vec<(f64, f64)> {
    let mut world = World::new(scenario).expect("the shipped ring");
    let mut driver =
        SimulatedDriver::new(&DriverParams::default(), world.ego_params(), scenario.seed).expect("a usual driver");
    let mut list = Vec::new();
    while world.ended().is_none() {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("the native engine");
        list.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Advice(advice) => Some((event.tick.seconds(), advice.target_mps)),
            _ => None,
        }));
    }
    list
}

#[test]
fn sham_advice_comes_from_another_drive_and_ignores_this_traffic() {
    let own = Scenario {
        traffic: EngineChoice::Native,
        policy: "follower-stopper".into(),
        start: StartLayout::Bunched,
        warm_up_s: 60.0,
        duration_s: 30.0,
        hold_s: 2.0,
        ..Scenario::default()
    };
    let sham = Scenario { sham_advice: true, ..own.clone() };
    let (with_own, with_sham) = (advised(&own), advised(&sham));
    let times = |list: &[(f64, f64)]| list.iter().map(|(time_s, _)| *time_s).collect::<Vec<_>>();
    assert_eq!((times(&with_own), with_own.len()), (times(&with_sham), 15), "as often, at the same times");
    // The same targets as in the source drive, from another starting point.
    let targets = |list: &[(f64, f64)]| list.iter().map(|(_, target_mps)| *target_mps).collect::<Vec<_>>();
    let (of_other, shown) = (targets(&advised(&other_drive(&sham))), targets(&with_sham));
    let begins = (0..of_other.len()).find(|n| [&of_other[*n..], &of_other[..*n]].concat() == shown);
    assert!(begins.is_some_and(|n| (4..=11).contains(&n)), "in the middle half of 15: {of_other:?} {shown:?}");
    // A driver who stays stopped gets the same advice.
    let mut world = World::new(&sham).expect("the shipped ring");
    let mut standing = Vec::new();
    while world.ended().is_none() {
        world.tick(&Controls { brake: 1.0, ..Controls::default() }).expect("the native engine");
        standing.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Advice(advice) => Some((event.tick.seconds(), advice.target_mps)),
            _ => None,
        }));
    }
    assert_eq!(standing, with_sham);
    assert_eq!(with_sham, advised(&sham), "the same bits again");
}

#[test]
fn a_standing_start_begins_in_the_jam_with_the_brake_on() {
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        policy: "none".into(),
        start: StartLayout::Bunched,
        warm_up_s: 200.0,
        wave_sd_mps: 2.0,
        standing_start: true,
        duration_s: 60.0,
        ..Scenario::default()
    };
    let mut world = World::new(&scenario).expect("the shipped ring");
    let hand_over = world.hand_over();
    assert!(hand_over.is_as_asked && hand_over.speed_mps < 0.08 && hand_over.speed_sd_mps >= 2.0, "{hand_over:?}");
    let driver = SimulatedDriver::new(&DriverParams::default(), world.ego_params(), 1).expect("a usual driver");
    let mut driver = driver.with_foot_on_brake();
    let first = driver.controls(&world.perceived_by(&driver));
    assert!(first.brake >= 0.08 && first.throttle == 0.0, "{first:?}");
    let (mut stood_s, mut top_mps) = (0.0, 0.0_f64);
    while world.ended().is_none() {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("the native engine");
        let speed_mps = world.snapshot().ego.speed_mps;
        top_mps = top_mps.max(speed_mps);
        if top_mps < 0.3 {
            stood_s += TICK_S;
        }
    }
    assert!(stood_s > 0.3 && top_mps > 3.0, "it stands {stood_s} s, then drives up to {top_mps} m/s");
}

#[test]
fn indicators_are_an_event_when_they_change_and_lamps_while_they_are_on() {
    use Indicator::{Left, Off, Right};
    let scenario = Scenario { traffic: EngineChoice::Native, extra_delay_s: 0.0, ..Scenario::default() };
    let mut world = World::new(&scenario).expect("the native engine");
    let (mut changes, mut lamps) = (Vec::new(), Vec::new());
    for indicator in [Off, Left, Left, Right, Off] {
        world.tick(&Controls { indicator, ..Controls::default() }).expect("the native engine");
        let of = |event: &Event| matches!(event.kind, EventKind::Indicator(_)).then_some(*event);
        changes.extend(world.events().iter().filter_map(of));
        let lit = world.snapshot().ego_lamps();
        lamps.push((lit.left, lit.right));
    }
    let event = |tick, side| Event { tick: Tick(tick), kind: EventKind::Indicator(side) };
    assert_eq!(changes, [event(2, Left), event(4, Right), event(5, Off)]);
    assert_eq!(lamps, [(false, false), (true, false), (true, false), (false, true), (false, false)]);
}
