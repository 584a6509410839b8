//! Drives without a participant: SUMO's vehicles and advised vehicles enter and leave, with no ego of a participant.

use crate::world::one_at_a_time;
use codrive::{
    analysis::RecordedTrial,
    controls::Controls,
    drive_loop::{Drive, evaluation_drive, offline::OfflineDrive},
    map::network::{Edge, EdgeKind, Network},
    record::{self, Table, TableReader},
    replay::Replay,
    rng,
    scenario::{AdvisedBody, AdvisedVehicles, DisplaySettings, PlannedDrive, Scenario},
    sim::{EndReason, Snapshot, World},
    time::Pace,
    traffic::{Demand, EGO, Flow, sumo},
};
use roxmltree::Document;
use std::{fs, process::Command};

/// Returns a scenario of the merge with this share of advised vehicles.
fn merge(advised: f64) -> Scenario {
    Scenario {
        map: "merge".into(),
        participant: false,
        policy: "constant".into(),
        policy_speed_mps: 12.0,
        advised: AdvisedVehicles::Share(advised),
        duration_s: 40.0,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    }
}

/// Runs a drive to its end with the pedals at rest; `look` sees the world after each tick.
fn drive(scenario: &Scenario, mut look: impl FnMut(&World)) -> World {
    let mut world = World::new(scenario).unwrap_or_else(|error| panic!("{error}"));
    while world.ended().is_none() {
        world.tick(&Controls::default()).expect("SUMO goes on");
        look(&world);
    }
    world
}

#[test]
fn a_drive_by_steps_is_the_drive_by_ticks() {
    let _alone = one_at_a_time();
    let scenario = merge(0.5);
    let mut by_ticks = Vec::new();
    let world = drive(&scenario, |world| {
        if world.snapshot().tick.0.is_multiple_of(scenario.step_ticks()) {
            by_ticks.push(hash(world));
        }
    });
    assert!(world.ever_advised().len() > 3, "{:?}", world.ever_advised());
    drop(world);
    let mut world = World::new(&scenario).expect("the merge");
    for (step, expected) in by_ticks.iter().enumerate() {
        world.step().expect("SUMO goes on");
        assert_eq!(hash(&world), *expected, "step {step}");
    }
    assert_eq!(world.ended(), Some(EndReason::Duration));
}

/// Returns a hash of all that a drive depends on: the view of all vehicles, and that of each agent.
fn hash(world: &World) -> u64 {
    let others = world.advised_others().iter().map(|agent| agent.snapshot());
    others.fold(world.snapshot().hash(1), |hash, view| view.hash(hash))
}

/// State of the merge at the end of a step, by SUMO's own program.
struct Written {
    running: usize,
    mean_mps: f64,
    inserted: f64,
    ended: f64,
    waiting: f64,
}

/// Returns the state at the end of each step, by SUMO's own program.
fn sumo_program(steps: usize, scenario: &Scenario) -> Vec<Written> {
    let folder = tempfile::tempdir().expect("a folder");
    let (home, summary) = (sumo::home().expect("SUMO is here"), folder.path().join("summary.xml"));
    let of_map = |file: &str| format!("{}/maps/merge/{file}", env!("CARGO_MANIFEST_DIR"));
    let options = [
        ("--net-file", of_map("net.xml")),
        ("--route-files", of_map("demand.rou.xml")),
        ("--step-length", scenario.step_s.to_string()),
        ("--seed", scenario.seed.to_string()),
        ("--end", (steps as f64 * scenario.step_s).to_string()),
        ("--lanechange.duration", "5".into()),
        ("--time-to-teleport", "-1".into()),
        ("--precision", "9".into()),
        ("--summary-output", summary.to_string_lossy().into_owned()),
    ];
    let mut program = Command::new(home.join("bin/sumo"));
    program.env("SUMO_HOME", &home).args(["--no-step-log", "--no-warnings"]);
    program.args(options.iter().flat_map(|(name, value)| [*name, value.as_str()]));
    let done = program.output().expect("SUMO's program runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let text = fs::read_to_string(&summary).expect("a summary");
    let document = Document::parse(&text).expect("XML");
    let number = |node: roxmltree::Node, name: &str| node.attribute(name).and_then(|text| text.parse::<f64>().ok());
    let of_step = |node| {
        let [running, mean_mps, inserted, ended, waiting] =
            ["running", "meanSpeed", "inserted", "ended", "waiting"].map(|name| number(node, name));
        let (running, mean_mps) = (running? as usize, mean_mps?);
        Some(Written { running, mean_mps, inserted: inserted?, ended: ended?, waiting: waiting? })
    };
    document.descendants().filter_map(of_step).collect()
}

#[test]
fn without_participant_and_advice_all_vehicles_match_sumos_own_program() {
    let _alone = one_at_a_time();
    let scenario = Scenario { policy: "none".into(), ..merge(0.0) };
    let mut driven = Vec::new();
    let world = drive(&scenario, |world| {
        let snapshot = world.snapshot();
        assert!(snapshot.is_without_ego && snapshot.leader.is_none() && snapshot.advice.is_none());
        if snapshot.tick.0.is_multiple_of(scenario.step_ticks()) {
            driven.push((snapshot.cars.len(), snapshot.mean_speed_mps));
        }
    });
    assert_eq!(world.ended(), Some(EndReason::Duration), "nobody comes to the end of a path");
    let expected = sumo_program(driven.len(), &scenario);
    assert!(expected.len() == driven.len() && driven.iter().any(|(cars, _)| *cars > 12), "{driven:?}");
    for (step, (own, sumo)) in driven.iter().zip(&expected).enumerate() {
        assert!(own.0 == sumo.running, "step {step}: {own:?} and {}", sumo.running);
        // An empty road has no mean speed: SUMO writes -1.
        assert!(own.0 == 0 || (own.1 - sumo.mean_mps).abs() < 1e-6, "step {step}: {own:?} and {}", sumo.mean_mps);
    }
}

#[test]
fn an_evaluation_without_advised_vehicles_matches_sumos_own_program() {
    let _alone = one_at_a_time();
    let scenario = Scenario { duration_s: 200.0, advised: AdvisedVehicles::Count(0), ..merge(0.0) };
    let found = evaluation_drive::evaluate(&scenario).expect("a drive");
    let flow = found.network.expect("a network");
    let expected = sumo_program(2000, &scenario);
    let some: Vec<f64> = expected.iter().filter(|step| step.running > 0).map(|step| step.mean_mps).collect();
    let mean_mps = some.iter().sum::<f64>() / some.len() as f64;
    assert!((found.mean_speed_mps - mean_mps).abs() < 1e-6, "{found:?} and {mean_mps}");
    let last = expected.last().expect("steps");
    assert!(
        last.waiting > 0.0 && last.ended > 20.0,
        "a jam before the end: {} wait, {} left",
        last.waiting,
        last.ended
    );
    let per_h = |vehicles: f64| vehicles * 3600.0 / scenario.duration_s;
    assert!((flow.inflow_per_h - per_h(last.inserted)).abs() < 1e-9, "{flow:?} and {}", last.inserted);
    assert!((flow.outflow_per_h - per_h(last.ended)).abs() < 1e-9, "{flow:?} and {}", last.ended);
    assert_eq!(
        (flow.vehicles_refused, flow.advised_vehicles, f64::from(flow.vehicles)),
        (Some(last.waiting), 0, last.inserted)
    );
}

#[test]
fn an_evaluation_of_a_share_states_the_number_of_advised_vehicles() {
    let _alone = one_at_a_time();
    let scenario = Scenario { participant: true, duration_s: 40.0, ..merge(0.5) };
    let found = evaluation_drive::evaluate(&scenario).expect("a drive");
    let flow = found.network.expect("a network");
    // The random streams alone determine the chosen vehicles; numbers start at 1.
    let takes = |id: u32| rng::stream(scenario.seed, &format!("vehicle/{id}/advised")).uniform(0.0, 1.0) < 0.5;
    assert_eq!(flow.advised_vehicles as usize, (1..=flow.vehicles).filter(|id| takes(*id)).count(), "{flow:?}");
    assert!(
        flow.advised_vehicles >= 5 && found.time_in_range.is_some_and(|share| (0.0..=1.0).contains(&share)),
        "{found:?}"
    );
    assert!(
        !found.crashed && found.min_gap_to_neighbours_m > 0.5 && found.min_gap_to_neighbours_m < 100.0,
        "{found:?}"
    );
}

#[test]
fn light_vehicles_are_advised_among_measured_people() {
    let _alone = one_at_a_time();
    for population in ["safe-followers", "gap-closers"] {
        let world = drive(&Scenario { traffic_drivers: population.into(), ..merge(0.5) }, |_| ());
        assert!(world.ever_advised().len() >= 5, "{population}: {:?}", world.ever_advised());
    }
}

#[test]
fn advised_vehicles_see_no_participant_and_means_are_over_vehicles() {
    let _alone = one_at_a_time();
    let mut advised_ticks = 0;
    let full = Scenario { advised_body: AdvisedBody::Full, ..merge(0.5) };
    let world = drive(&full, |world| {
        let snapshot = world.snapshot();
        assert!(snapshot.cars.iter().all(|car| car.id != EGO));
        for agent in world.advised_others() {
            let own = agent.snapshot();
            assert!(!own.is_without_ego && own.cars.iter().all(|car| car.id != EGO && car.id != agent.id()));
            assert_eq!(own.cars.len() + 1, snapshot.cars.len(), "it sees all others");
            advised_ticks += u32::from(own.advice.is_some());
        }
        let sum: f64 = snapshot.cars.iter().map(|car| car.speed_mps).sum();
        let mean_mps = if snapshot.cars.is_empty() { 0.0 } else { sum / snapshot.cars.len() as f64 };
        assert!((snapshot.mean_speed_mps - mean_mps).abs() < 1e-9, "{} and {mean_mps}", snapshot.mean_speed_mps);
        // The parking position is not on the road.
        assert!(snapshot.ego.position.x < -900.0 && snapshot.ego_lane.is_none());
    });
    assert!(world.ever_advised().len() >= 5, "{:?}", world.ever_advised());
    assert!(advised_ticks > 5000, "{advised_ticks} ticks");
    assert_eq!(world.contacts_of_others(), 0);
}

#[test]
fn summary_and_hash_cover_the_other_vehicles_alone() {
    let _alone = one_at_a_time();
    let once = || {
        let mut run = OfflineDrive::new(&Scenario { duration_s: 20.0, ..merge(0.5) }, [0.0, 20.0]).expect("a drive");
        let (mut sum, mut n, mut hash) = (0.0, 0, 0);
        while run.world().ended().is_none() {
            run.until(run.world().time_s() + 0.01).expect("SUMO goes on");
            let cars = &run.world().snapshot().cars;
            if !cars.is_empty() {
                sum += cars.iter().map(|car| car.speed_mps).sum::<f64>() / cars.len() as f64;
                n += 1;
            }
            hash = run
                .world()
                .advised_others()
                .iter()
                .fold(hash, |before, agent| Snapshot::hash(agent.snapshot(), before));
        }
        let summary = run.summary();
        let mean_mps = summary.mean_speed_mps.expect("vehicles came");
        assert!((mean_mps - sum / f64::from(n)).abs() < 1e-9, "{mean_mps}");
        assert_eq!((summary.ego_mean_speed_mps, summary.min_gap_m, summary.advices), (None, None, 0));
        assert!(run.advised().vehicles.iter().all(|id| *id != EGO.0) && !run.advised().vehicles.is_empty());
        (summary.hash, hash)
    };
    assert_eq!(once(), once());
}

#[test]
fn a_drive_without_participant_needs_a_demand_and_no_driver() {
    let _alone = one_at_a_time();
    let ring = Scenario { map: "ring-250".into(), advised: AdvisedVehicles::default(), ..merge(0.0) };
    let printed = World::new(&ring).map(drop).expect_err("a ring").to_string();
    assert!(
        printed.starts_with("participant is false; allowed without a demand: true") && printed.contains("remedy"),
        "{printed}"
    );
    let planned = PlannedDrive::new(&merge(0.0)).expect("a shipped map");
    let printed = Drive::by_participant(planned, Pace::Paused).map(drop).expect_err("nobody drives").to_string();
    assert!(
        printed.starts_with("participant is false: this scenario has no driver") && printed.contains("codrive run"),
        "{printed}"
    );
    // Only a share of the entering vehicles can be advised: a number would select none.
    let several = Scenario { advised: AdvisedVehicles::Count(3), ..merge(0.0) };
    let printed = World::new(&several).map(drop).expect_err("a number").to_string();
    assert!(
        printed.starts_with("advised is 3; allowed on map merge, where vehicles enter and leave: a share"),
        "{printed}"
    );
    let alone = World::new(&Scenario { advised: AdvisedVehicles::Count(1), ..merge(0.0) }).expect("a world");
    assert!(
        alone.policy().to_string().contains("only the participant's vehicle, which this drive does not have"),
        "{}",
        alone.policy()
    );
}

#[test]
fn a_recording_without_participant_is_recovered_and_replayed_to_the_bit() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drive");
    let mut run = OfflineDrive::new(&merge(0.5), [0.0, f64::INFINITY]).expect("a drive");
    run.record(&path).expect("a recording");
    run.until(20.0).expect("SUMO goes on");
    let there = run.world().snapshot().cars.len();
    // The recording is cut off without its tables.
    drop(run);
    record::recover(&path).expect("it is recovered");
    let table = |table: Table| TableReader::parquet(&table.parquet(&path)).expect("a table");
    let (ego, cars, advised) = (table(Table::Ego), table(Table::Cars), table(Table::Advised));
    // 20 s of 10 ms have fingerprints and pedals at rest, but no state of a car.
    assert_eq!((ego.rows(), ego.wholes("hash").len()), (2000, 2000));
    assert!(ego.numbers("throttle").iter().chain(&ego.numbers("brake")).all(|pedal| *pedal == Some(0.0)));
    for column in ["x_m", "z_m", "yaw_rad", "speed_mps", "jerk_mps3", "engine_rpm", "s_m", "lane_offset_m", "gap_m"] {
        assert!(ego.numbers(column).iter().all(Option::is_none), "{column}");
    }
    assert!(cars.ids("car").iter().all(|car| *car != Some(EGO.0)));
    // Every second has all vehicles on the road.
    assert!(cars.wholes("tick").iter().all(|tick| tick.is_multiple_of(100)));
    assert_eq!(cars.wholes("tick").iter().filter(|tick| **tick == 2000).count(), there);
    assert!(advised.rows() > 100, "{} rows", advised.rows());
    let mut replay = Replay::open(&path).expect("it can be driven");
    replay.advance(u64::MAX).expect("SUMO goes on");
    assert!(replay.report().is_proven() && replay.report().ticks == 2000, "{:?}", replay.report());
    let printed = RecordedTrial::open(&path).map(drop).expect_err("nobody drove").to_string();
    assert!(
        printed.contains("the drive has no participant") && printed.contains("remedy: read the tables cars"),
        "{printed}"
    );
}

/// Returns a few flows between connected edges of a network.
fn flows(network: &Network) -> Vec<Flow> {
    let for_cars =
        |edge: &&Edge| edge.kind == EdgeKind::Normal && edge.lanes().any(|lane| network.lane(lane).admits_cars());
    let ways = network.edges().iter().filter(for_cars).filter_map(|edge| {
        let lane = edge.lanes().find(|lane| network.lane(*lane).admits_cars())?;
        let way = network.connections_from(lane).iter().find(|way| network.lane(way.to).admits_cars())?;
        let to = network.edge_of(way.to);
        (to.kind == EdgeKind::Normal).then(|| (edge.id.clone(), to.id.clone()))
    });
    ways.take(4).map(|(from, to)| Flow { from, to, per_hour: 900.0, mix: Vec::new() }).collect()
}

#[test]
fn a_drive_without_a_participant_runs_on_every_network_with_a_demand() {
    let _alone = one_at_a_time();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/networks");
    let mut files: Vec<_> =
        fs::read_dir(folder).expect("networks").map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|file| file.to_string_lossy().ends_with(".net.xml"));
    files.sort();
    assert_eq!(files.len(), 17);
    for file in files {
        let net = file.to_string_lossy().into_owned();
        let flows = flows(&Network::load(&net).unwrap_or_else(|error| panic!("{error}")));
        assert!(!flows.is_empty(), "{net}");
        let scenario = Scenario {
            map: net.clone(),
            participant: false,
            policy: "none".into(),
            demand: Demand { flows, ..Demand::default() },
            warm_up_s: 5.0,
            duration_s: 5.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let mut most = 0;
        let world = drive(&scenario, |world| {
            let cars = &world.snapshot().cars;
            most = most.max(cars.len());
            assert!(cars.iter().all(|car| car.id != EGO), "{net}: nobody has the participant's number");
        });
        assert_eq!(world.ended(), Some(EndReason::Duration), "{net}");
        assert!(most > 0, "{net}: nobody came");
    }
}
