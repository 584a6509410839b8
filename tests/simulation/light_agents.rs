//! Light agents: advised vehicles without a person inside, steered by the traffic engine. Expected: the ways of full agents behind the same
//! advice.

use crate::{agents_network, driver::advice, world::one_at_a_time};
use codrive::{
    controls::Controls,
    driver::{Perception, SeenLeader, SimulatedDriver, preset},
    ego::{CarParams, EgoCar, GroundSurface, LongitudinalCar, UniformGround},
    idm::IdmParams,
    scenario::{AdvisedBody, AdvisedVehicles, DisplaySettings, Scenario},
    sim::{Agent, EventKind, World},
    space::Pose,
    time::{TICK_S, Tick},
    traffic::{Demand, Flow},
};

/// Returns what a driver sees on a straight road behind a leader.
fn seen(speed_mps: f64, leader: Option<SeenLeader>, advised_mps: Option<f64>) -> Perception {
    let advice = advised_mps.map(|target_mps| advice(Tick(0), target_mps));
    Perception { speed_mps, leader, advice, speed_limit_mps: 30.0, ..Perception::default() }
}

#[test]
fn a_light_car_keeps_gaps_and_speeds_of_the_full_one() {
    for name in ["perfect", "follow", "sloppy"] {
        let driver = preset(name).expect("a preset");
        let params = CarParams::default();
        let make = || SimulatedDriver::new(&driver, &params, 3).expect("a driver");
        let (mut by_full, mut by_light) = (make(), make());
        let mut full = EgoCar::new(&params, Pose::default(), 4.0, 0).expect("a car");
        let mut light = LongitudinalCar::new(&params, 4.0).expect("a car");
        let mut gaps_m = [12.0; 2];
        let mut most = [0.0_f64; 2];
        for tick in 0..30_000 {
            let time_s = f64::from(tick) * TICK_S;
            // A wave with a stop every minute, and advice below it that changes each second.
            let leader_mps = (4.0 - 5.0 * (time_s * std::f64::consts::TAU / 60.0).sin()).max(0.0);
            let advised = 4.0 + 1.5 * (f64::from(tick / 100) * 0.7).sin();
            let ahead = |gap_m: f64| Some(SeenLeader { gap_m, speed_mps: leader_mps });
            let speeds = [full.state().speed_mps, light.speed_mps()];
            let controls = by_full.controls(&seen(speeds[0], ahead(gaps_m[0]), Some(advised)));
            let at = full.state().position.x;
            full.tick(&Controls { steering_wheel_rad: 0.0, ..controls }, &UniformGround(GroundSurface::Asphalt), &[]);
            let way_m = full.state().position.x - at;
            let controls = by_light.pedals(&seen(speeds[1], ahead(gaps_m[1]), Some(advised)));
            let ways = [way_m, light.tick(&controls, 0.0)];
            for (gap_m, way_m) in gaps_m.iter_mut().zip(ways) {
                *gap_m += leader_mps * TICK_S - way_m;
            }
            most[0] = most[0].max((gaps_m[0] - gaps_m[1]).abs());
            most[1] = most[1].max((full.state().speed_mps - light.speed_mps()).abs());
        }
        // What one car's driver cannot tell from the other's: below 1 % of a gap and of a speed in a jam.
        assert!(most[0] < 0.05 && most[1] < 0.05, "{name}: {} m, {} m/s", most[0], most[1]);
    }
}

#[test]
fn a_light_car_accelerates_and_brakes_as_the_full_one() {
    // By the pedals alone: a floored accelerator through all gears, coasting, a light and a hard brake to a stop, and creep.
    let pedals = [(1.0, 0.0, 15), (0.0, 0.0, 5), (0.0, 0.2, 5), (0.3, 0.0, 15), (0.0, 0.6, 10), (0.0, 0.0, 10)];
    let params = CarParams::default();
    let mut full = EgoCar::new(&params, Pose::default(), 0.0, 0).expect("a car");
    let mut light = LongitudinalCar::new(&params, 0.0).expect("a car");
    let mut fastest_mps: f64 = 0.0;
    for (throttle, brake, seconds) in pedals {
        for _ in 0..seconds * 100 {
            let controls = Controls { throttle, brake, ..Controls::default() };
            full.tick(&controls, &UniformGround(GroundSurface::Asphalt), &[]);
            light.tick(&controls, 0.0);
            let speed_mps = full.state().speed_mps;
            fastest_mps = fastest_mps.max(speed_mps);
            let apart_mps = (speed_mps - light.speed_mps()).abs();
            // As behind a leader; and a body on springs and tyres takes a force up later, by less than a third of the time that a foot needs to
            // leave a pedal.
            let allowed_mps = 0.05 + 0.03 * full.state().accel_mps2.abs();
            assert!(apart_mps < allowed_mps, "{throttle} {brake}: {speed_mps} and {} m/s", light.speed_mps());
        }
    }
    assert!(fastest_mps > 35.0, "{fastest_mps} m/s");
}

/// Returns a ring with three advised vehicles, one of them the participant's.
fn ring(traffic: &str, body: AdvisedBody) -> Scenario {
    Scenario {
        traffic: traffic.parse().expect("an engine"),
        advised: AdvisedVehicles::Count(3),
        advised_body: body,
        policy: "constant".into(),
        policy_speed_mps: 3.0,
        idm: IdmParams { noise: 0.0, ..IdmParams::default() },
        duration_s: 300.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    }
}

/// Runs a drive to its end; `look` sees the world at the end of each step.
fn drive(scenario: &Scenario, mut look: impl FnMut(&World)) -> World {
    agents_network::drive(scenario, |world| {
        if world.snapshot().tick.0.is_multiple_of(10) {
            look(world);
        }
    })
}

/// Returns speed and gap of each advised vehicle but the participant's, m/s and m, at the end of each step.
fn ways(scenario: &Scenario) -> Vec<[f64; 2]> {
    let mut ways = Vec::new();
    drive(scenario, |world| {
        for agent in world.advised_others() {
            let view = agent.snapshot();
            ways.push([view.ego.speed_mps, view.leader.expect("a leader").gap_m]);
        }
    });
    ways
}

#[test]
fn light_and_full_agents_drive_alike_behind_the_same_advice() {
    let _guard = one_at_a_time();
    // A driver who does not wander in the lane: on the inner side of a bend a car is ahead of one in the middle.
    let of = |traffic: &str, body| Scenario { driver: "perfect".into(), ..ring(traffic, body) };
    let full = ways(&of("native", AdvisedBody::Full));
    assert_eq!(full.len(), 6000);
    for traffic in ["native", "sumo"] {
        let light = ways(&of(traffic, AdvisedBody::Light));
        assert_eq!(light.len(), full.len());
        for (k, what) in ["speeds, m/s", "gaps, m"].into_iter().enumerate() {
            let apart = light.iter().zip(&full).map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max);
            // 1 % of the speed of a ring and of a gap in a jam: no driver could tell one from the other.
            assert!(apart < 0.05, "{traffic}: {what} differ by {apart}");
        }
    }
}

#[test]
fn a_light_agent_that_runs_into_its_leader_touches_it_and_does_not_pass() {
    // The driver looks at nothing but the advice of 8 m/s, where the ring allows 4.4.
    for traffic in ["native", "sumo"] {
        let _guard = one_at_a_time();
        let blind = Scenario {
            policy_speed_mps: 8.0,
            driver: "exact".into(),
            duration_s: 60.0,
            ..ring(traffic, AdvisedBody::Light)
        };
        let (mut least_m, mut events) = (f64::INFINITY, 0);
        let mut world = World::new(&blind).expect("a world");
        let mut driver =
            SimulatedDriver::new(&preset("idm").expect("a preset"), world.ego_params(), 1).expect("a driver");
        while world.ended().is_none() {
            let controls = driver.controls(&world.perceived_by(&driver));
            world.tick(&controls).expect("the engine goes on");
            for agent in world.advised_others() {
                let touches = |kind: &EventKind| matches!(kind, EventKind::Contact { .. });
                events += agent.events().iter().filter(|event| touches(&event.kind)).count();
                let leader = agent.snapshot().leader.expect("a leader");
                assert_eq!(leader.id.0, (agent.id().0 + 1) % 22, "{traffic}: the order is kept");
                least_m = least_m.min(leader.gap_m);
            }
        }
        // Bumper to bumper, but for what the leader does within a step against its acceleration before: 0.1 s and 1 m/s².
        assert!((-0.01..0.1).contains(&least_m), "{traffic}: {least_m} m");
        assert!(events >= 2 && world.contacts_of_others() == events as u32, "{traffic}: {events} contacts");
    }
}

/// Returns the grid with signals and 1,200 cars an hour, half of them advised.
fn grid(body: AdvisedBody) -> Scenario {
    let flow = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 400.0, mix: Vec::new() };
    Scenario {
        map: "tests/data/networks/grid-signals.net.xml".into(),
        demand: Demand {
            flows: vec![flow("A0B0", "B2C2"), flow("C2C1", "A1A0"), flow("A2A1", "C0B0")],
            ..Demand::default()
        },
        participant: false,
        advised: AdvisedVehicles::Share(0.5),
        advised_body: body,
        policy: "pi".into(),
        duration_s: 300.0,
        ..Scenario::default()
    }
}

#[test]
fn light_agents_on_a_network_come_and_go_as_full_ones_do() {
    let _guard = one_at_a_time();
    let [light, full] = [AdvisedBody::Light, AdvisedBody::Full].map(|body| {
        let mut way_m = 0.0;
        let world = drive(&grid(body), |world| {
            let all = world.snapshot();
            for agent in world.advised_others() {
                let view = agent.snapshot();
                let image = all.cars.iter().find(|car| car.id == agent.id()).expect("it is there");
                assert!(image.pose.position.distance(view.ego.position.truncate()) < 1e-6, "one place in all views");
                assert_eq!((view.tick, image.speed_mps), (all.tick, view.ego.speed_mps));
                way_m += 0.1 * view.ego.speed_mps;
            }
        });
        assert_eq!(world.contacts_of_others(), 0);
        let there: Vec<_> = world.snapshot().cars.iter().map(|car| car.id).collect();
        let left = world.ever_advised().iter().filter(|id| !there.contains(id)).count();
        (world.ever_advised().to_vec(), way_m, left)
    });
    // Streams of their numbers choose the vehicles; how many enter depends on the room that those before them leave.
    let alike = light.0.len().min(full.0.len());
    assert_eq!(light.0[..alike], full.0[..alike]);
    assert!(light.2.abs_diff(full.2) <= 2 && light.2 > 20, "{} and {} have left", light.2, full.2);
    // Signals decide when a vehicle goes on: a cycle of 90 s is a tenth of what all of them drive in.
    assert!((light.1 / full.1 - 1.0).abs() < 0.1, "{} and {} m", light.1, full.1);
}

#[test]
fn a_drive_with_light_agents_on_a_network_has_the_same_bits_again() {
    let _guard = one_at_a_time();
    let hash = || {
        let mut hash = 0;
        drive(&Scenario { duration_s: 40.0, ..grid(AdvisedBody::Light) }, |world| {
            let views = std::iter::once(world.snapshot()).chain(world.advised_others().iter().map(Agent::snapshot));
            hash = views.fold(hash, |before, view| view.hash(before));
        });
        hash
    };
    let first = hash();
    assert!(first != 0 && first == hash());
}
