//! Whole drives over crossings without signals: an all-way stop, and a road with priority. The ego comes from the south.

use super::{
    network::{drive, scenario},
    world::one_at_a_time,
};
use codrive::{
    scenario::Scenario,
    sim::{EndReason, Summary, VehicleSnapshot},
    traffic::{Demand, Flow, VehicleId},
};
use std::{collections::BTreeSet, fs};

/// Position of the line on the ego's path, metres: 200 m to the centre of the crossing, less half of it (7.2 m).
const LINE_M: f64 = 192.8;

/// Behaviour of an ego at the crossing.
#[derive(Debug, Default)]
struct Passage {
    /// Number of stops before the line.
    stops: u32,
    /// Vehicles that cross their lines while the ego stands.
    went_before: BTreeSet<VehicleId>,
    /// Hardest braking between its first stop and the other side, m/s2.
    braking_mps2: f64,
}

fn flow(from: &str, to: &str, per_hour: f64) -> Flow {
    Flow { from: from.into(), to: to.into(), per_hour, mix: Vec::new() }
}

fn pass(network: &str, path: &str, flows: Vec<Flow>, seed: u64) -> (Summary, Passage) {
    let map = format!("tests/data/networks/{network}.net.xml");
    let demand = Demand { flows, ..Demand::default() };
    let scenario = scenario(path, demand);
    let scenario = Scenario { map, warm_up_s: 60.0, seed, duration_s: 180.0, path_start_m: 60.0, ..scenario };
    let (mut passage, mut goes, mut inside) = (Passage::default(), true, BTreeSet::new());
    let summary = drive(&scenario, |world| {
        let (at_m, ego, network) = (world.snapshot().ego_s_m, &world.snapshot().ego, &world.map().network);
        let is_inside = |car: &&VehicleSnapshot| car.lane.is_some_and(|at| network.lane(at.lane).id.starts_with(":C"));
        let now: BTreeSet<VehicleId> = world.snapshot().cars.iter().filter(is_inside).map(|car| car.id).collect();
        if !goes {
            passage.went_before.extend(now.difference(&inside));
        }
        inside = now;
        if !(LINE_M - 5.0..LINE_M + 20.0).contains(&at_m) {
            return;
        }
        if goes && ego.speed_mps < 0.1 {
            passage.stops += 1;
            goes = false;
        }
        goes |= ego.speed_mps > 0.5;
        if passage.stops > 0 {
            passage.braking_mps2 = passage.braking_mps2.max(-ego.accel_mps2);
        }
    });
    (summary, passage)
}

/// Checks that the ego crossed without a contact or a near miss.
fn check_peace(summary: &Summary, case: &str) {
    assert_eq!(summary.ended, Some(EndReason::PathEnd), "{case}: it stood to the end");
    assert_eq!((summary.contact_count, summary.near_misses), (0, 0), "{case}");
}

#[test]
fn at_an_all_way_stop_the_ego_stops_once_and_goes_in_its_turn() {
    let _alone = one_at_a_time();
    // With 1,600 vehicles an hour on the three other arms, another vehicle nearly always arrives before the ego.
    let others = || {
        let straight = [flow("NC", "CS", 500.0), flow("EC", "CW", 500.0), flow("WC", "CE", 500.0)];
        straight
            .into_iter()
            .chain([flow("SC", "CE", 100.0), flow("NC", "CE", 125.0), flow("EC", "CS", 125.0)])
            .collect()
    };
    for path in ["SC CN", "SC CW", "SC CE"] {
        for seed in 1..=3 {
            let case = format!("{path}, seed {seed}");
            let (summary, passage) = pass("allway", path, others(), seed);
            check_peace(&summary, &case);
            assert_eq!(passage.stops, 1, "{case}: the law asks for one stop");
            assert!(
                passage.went_before.len() <= 3,
                "{case}: who comes first goes first, one of each other arm: {passage:?}"
            );
            // A vehicle that brakes in the crossing blocks all others; the engine alone slows the car by less than 1 m/s2.
            assert!(passage.braking_mps2 < 1.0, "{case}: {passage:?}");
        }
    }
}

#[test]
fn a_priority_road_is_crossed_and_entered_in_gaps_of_sufficient_size() {
    let _alone = one_at_a_time();
    // A vehicle comes every 4.5 s on average, at random: less than the critical gap of drivers (docs/references.md: yield), so some egos
    // wait.
    let others = || vec![flow("EC", "CW", 400.0), flow("WC", "CE", 400.0)];
    let mut waited = 0;
    for path in ["SC CN", "SC CW", "SC CE"] {
        for seed in [2, 3, 5] {
            let case = format!("{path}, seed {seed}");
            let (summary, passage) = pass("crossing", path, others(), seed);
            check_peace(&summary, &case);
            assert!(passage.stops <= 1 && passage.braking_mps2 < 1.0, "{case}: {passage:?}");
            waited += passage.stops;
        }
    }
    assert!((1..9).contains(&waited), "{waited} of 9 waited: neither always nor never");
}

#[test]
fn a_driver_with_right_of_way_brakes_for_a_vehicle_within_the_crossing() {
    let _alone = one_at_a_time();
    // On the benchmark's figure-eight one of the 14 starts within the crossing and slowly goes through it, while the ego comes from the side
    // with right of way. The ways around it are drawn shorter than the file declares.
    let folder = tempfile::tempdir().expect("a folder");
    let benchmark = "python/codrive_sim/benchmarks/networks/flow-figure-eight.net.xml";
    fs::copy(benchmark, folder.path().join("net.xml")).expect("a copy");
    fs::copy("maps/figure-eight/map.toml", folder.path().join("map.toml")).expect("a copy");
    let map = folder.path().to_str().expect("a path").to_owned();
    let scenario = Scenario { map, vehicles: 14, policy: "none".into(), seed: 1, ..Scenario::default() };
    let summary = drive(&Scenario { duration_s: 30.0, warm_up_s: 0.0, ..scenario }, |_| {});
    assert_eq!(summary.contact_count, 0);
}

#[test]
fn simulated_drivers_pass_two_zippers_among_2500_vehicles_an_hour() {
    let _alone = one_at_a_time();
    for seed in [1, 2] {
        let scenario = Scenario { map: "bottleneck".into(), policy: "none".into(), seed, ..Scenario::default() };
        let summary = drive(&Scenario { duration_s: 180.0, warm_up_s: 60.0, ..scenario }, |_| {});
        check_peace(&summary, &format!("seed {seed}"));
    }
}
