//! Advised vehicles on a network: a share of the vehicles that enter is fully simulated, along the routes of the demand.

use crate::world::one_at_a_time;
use codrive::{
    driver::{SimulatedDriver, preset},
    rng,
    scenario::{AdvisedBody, AdvisedVehicles, DisplaySettings, Scenario},
    sim::{EventKind, Snapshot, World},
    traffic::{Demand, Flow, VehicleId},
};
use std::collections::{BTreeMap, BTreeSet};

const GRID: &str = "tests/data/networks/grid-signals.net.xml";

/// Returns a scenario with 1,200 cars an hour in total across the grid; the ego drives round.
fn scenario(advised: f64) -> Scenario {
    let flow = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 400.0, mix: Vec::new() };
    let flows = vec![flow("A0B0", "B2C2"), flow("C2C1", "A1A0"), flow("A2A1", "C0B0")];
    Scenario {
        map: GRID.into(),
        path: "B0B1 B1C1 C1C2 C2B2 B2A2 A2A1 A1A0".into(),
        demand: Demand { flows, ..Demand::default() },
        advised: AdvisedVehicles::Share(advised),
        advised_body: AdvisedBody::Full,
        policy: "pi".into(),
        warm_up_s: 20.0,
        duration_s: 120.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    }
}

/// Runs a drive to its end, with the scenario's driver in the participant's vehicle; `look` sees the world after each tick.
pub fn drive(scenario: &Scenario, mut look: impl FnMut(&World)) -> World {
    let mut world = World::new(scenario).unwrap_or_else(|error| panic!("{error}"));
    let params = preset(&scenario.driver).expect("a preset");
    let mut driver = SimulatedDriver::new(&params, world.ego_params(), scenario.seed).expect("a driver");
    while world.ended().is_none() {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("SUMO goes on");
        look(&world);
    }
    world
}

/// Observations of an advised vehicle.
#[derive(Default)]
struct Seen {
    ticks: u32,
    advised_ticks: u32,
    /// Ticks off the lane of its route.
    beside_ticks: u32,
    way_m: f64,
    last: Option<glam::DVec2>,
}

#[test]
fn a_share_of_cars_is_advised_along_its_routes_and_leaves_at_the_end() {
    let _alone = one_at_a_time();
    let scenario = scenario(0.5);
    let mut all: BTreeSet<VehicleId> = BTreeSet::new();
    let mut seen: BTreeMap<VehicleId, Seen> = BTreeMap::new();
    let (mut met, mut contacts) = (0, 0);
    let world = drive(&scenario, |world| {
        let snapshot = world.snapshot();
        all.extend(snapshot.cars.iter().map(|car| car.id));
        contacts += world.events().iter().filter(|event| matches!(event.kind, EventKind::Contact { .. })).count();
        for agent in world.advised_others() {
            let own = agent.snapshot();
            let of = seen.entry(agent.id()).or_default();
            of.ticks += 1;
            of.advised_ticks += u32::from(own.advice.is_some());
            assert_eq!((own.tick, own.cars.len()), (snapshot.tick, snapshot.cars.len()), "it sees as many others");
            // The participant sees it at the position of its body, from the moment when SUMO no longer drives it.
            let image = snapshot.cars.iter().find(|car| car.id == agent.id()).expect("it is there");
            let place = own.ego.position.truncate();
            assert!(image.pose.position.distance(place) < 1e-6, "{} m", image.pose.position.distance(place));
            assert!(image.lane == own.ego_lane && own.ego_lane.is_some(), "on a lane at {place}");
            let step_m = of.last.map_or(0.0, |last| last.distance(place));
            assert!(step_m <= 1.2 * own.ego.speed_mps.abs() * 0.01 + 0.005, "{step_m} m in a tick");
            of.way_m += step_m;
            of.last = Some(place);
            // The vehicle stays on its route. Where the route changes lanes, the offset from it passes smoothly over one lane of 3.2 m, and
            // a driver changes when there is a gap.
            assert!(own.lane_offset_m.abs() < 3.2, "{} m beside its way", own.lane_offset_m);
            of.beside_ticks += u32::from(own.lane_offset_m.abs() >= 1.6);
            met += u32::from(own.leader.is_some_and(|leader| leader.gap_m < 30.0));
        }
    });
    // The random streams alone determine the chosen vehicles; SUMO keeps those that stood in a junction when the ego started.
    let of_streams =
        |id: &VehicleId| rng::stream(scenario.seed, &format!("vehicle/{}/advised", id.0)).uniform(0.0, 1.0) < 0.5;
    let chosen: BTreeSet<VehicleId> = all.iter().copied().filter(of_streams).collect();
    let advised: BTreeSet<VehicleId> = world.ever_advised().iter().copied().collect();
    assert!(advised.is_subset(&chosen) && advised.len() + 3 >= chosen.len(), "{advised:?} of {chosen:?}");
    assert!(advised.len() >= 8 && all.len() >= 16, "{} of {}", advised.len(), all.len());
    assert_eq!(seen.keys().copied().collect::<BTreeSet<_>>(), advised);
    let there: BTreeSet<VehicleId> = world.snapshot().cars.iter().map(|car| car.id).collect();
    let gone: Vec<_> = advised.difference(&there).collect();
    assert!(gone.len() >= 2, "{gone:?} have left");
    // The routes lead from A0B0 or a similar edge to the second or third crossing: 300 m and more, less the distance driven before the
    // start.
    let farthest = gone.iter().map(|id| seen[id].way_m).fold(0.0, f64::max);
    assert!(farthest > 250.0, "{farthest} m");
    for (id, of) in &seen {
        // One lane change on streets of 90 m: at most a tenth of 900 m.
        assert!(
            of.beside_ticks * 10 <= of.ticks,
            "{id:?} was beside its lane in {} of {} ticks",
            of.beside_ticks,
            of.ticks
        );
        assert!(of.advised_ticks + 100 >= of.ticks, "{id:?} was advised {} of {} ticks", of.advised_ticks, of.ticks);
    }
    assert!(met > 1000, "they follow others: {met} ticks");
    assert_eq!((contacts, world.contacts_of_others()), (0, 0));
}

#[test]
fn a_drive_with_advised_vehicles_on_a_network_has_the_same_bits_again() {
    let _alone = one_at_a_time();
    let hashes = || {
        let (mut hash, mut others) = (0, 0);
        drive(&Scenario { duration_s: 40.0, ..scenario(0.5) }, |world| {
            hash = Snapshot::hash(world.snapshot(), hash);
            others = world.advised_others().iter().fold(others, |before, agent| agent.snapshot().hash(before));
        });
        (hash, others)
    };
    let first = hashes();
    assert!(first.1 != 0);
    assert_eq!(first, hashes());
}
