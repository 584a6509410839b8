//! A drive on a road network: vehicles enter and leave around the ego, which follows its path, stops at signals and ends with the path.

use super::world::one_at_a_time;
use codrive::{
    controls::Controls,
    driver::{SimulatedDriver, preset},
    map::{
        Manoeuvre,
        network::{Network, SignalId, SignalLight},
    },
    scenario::Scenario,
    sim::{EndReason, EventKind, SummaryAccumulator, VehicleSnapshot, World},
    space::CAR_LENGTH_M,
    traffic::{Demand, EngineChoice, Flow, VehicleId},
};
use std::collections::{BTreeMap, BTreeSet};

pub(super) const GRID: &str = "tests/data/networks/grid-signals.net.xml";

/// Returns flows across the grid, 2,400 vehicles an hour in total.
pub(super) fn flows() -> Demand {
    let flow = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 600.0, mix: Vec::new() };
    let flows = vec![flow("A0B0", "B2C2"), flow("C2C1", "A1A0"), flow("A2A1", "C0B0"), flow("B0B1", "B1B2")];
    Demand { flows, ..Demand::default() }
}

pub(super) fn scenario(path: &str, demand: Demand) -> Scenario {
    Scenario { map: GRID.into(), path: path.into(), demand, duration_s: 120.0, ..Scenario::default() }
}

pub(super) fn driver(world: &World) -> SimulatedDriver {
    let params = preset(&world.scenario().driver).expect("a driver");
    SimulatedDriver::new(&params, world.ego_params(), world.scenario().seed).expect("a driver")
}

/// Runs a drive to its end; `see` gets the world after each tick. Returns the summary.
pub(super) fn drive(scenario: &Scenario, mut see: impl FnMut(&World)) -> codrive::sim::Summary {
    let mut world = World::new(scenario).unwrap_or_else(|error| panic!("{error}"));
    let mut driver = driver(&world);
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    while world.ended().is_none() {
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("a tick");
        summary.add(world.snapshot(), world.events());
        see(&world);
    }
    summary.to_summary()
}

#[test]
fn a_drive_on_a_path_is_guided_from_turn_to_turn() {
    let _alone = one_at_a_time();
    // Right into B1C1, left into C1C2 (`src/map/route/guidance.rs` has the distances).
    let mut turns: Vec<Manoeuvre> = Vec::new();
    let mut last_m = f64::INFINITY;
    drive(&scenario("B0B1 B1C1 C1C2", Demand::default()), |world| {
        let next = world.snapshot().next_manoeuvre;
        let ahead_m = next.map_or(f64::INFINITY, |next| next.ahead_m);
        if ahead_m > last_m + 1.0 || turns.is_empty() {
            turns.extend(next.map(|next| next.manoeuvre));
        }
        last_m = ahead_m;
    });
    assert_eq!(turns, [Manoeuvre::Right, Manoeuvre::Left]);
}

const ROUND: &str = "A0B0 B0B1 B1C1 C1C2 C2B2 B2A2 A2A1 A1A0 A0B0 B0B1 B1B2";

#[test]
fn vehicles_enter_and_leave_at_steps_and_move_evenly_in_between() {
    let _alone = one_at_a_time();
    let scenario = Scenario { warm_up_s: 30.0, ..scenario(ROUND, flows()) };
    let step_ticks = scenario.step_ticks();
    let mut ever: BTreeMap<VehicleId, u32> = BTreeMap::new();
    let (mut here, mut gone): (BTreeSet<VehicleId>, BTreeSet<VehicleId>) = Default::default();
    let (mut on_path, mut lanes) = (0, BTreeSet::new());
    let first = drive(&scenario, |world| {
        let snapshot = world.snapshot();
        let now: BTreeSet<VehicleId> = snapshot.cars.iter().map(|car| car.id).collect();
        assert_eq!(now.len(), snapshot.cars.len());
        assert!(snapshot.cars.is_sorted_by_key(|car| car.id) && !now.contains(&VehicleId(0)));
        if now != here && snapshot.tick.0 > 1 {
            assert_eq!(snapshot.tick.0 % step_ticks, 0, "they come and go at the end of a step");
        }
        gone.extend(here.difference(&now));
        assert!(gone.is_disjoint(&now), "nobody comes back");
        here = now;
        for car in &snapshot.cars {
            *ever.entry(car.id).or_default() += 1;
            // The front bumper moves by its speed, and somewhat more during a lane change in a bend. (The heading is SUMO's, which rotates
            // a car at once if it begins a lane change right behind a bend.)
            let [from, to] = [car.pose_before, car.pose].map(|pose| pose.front(car.body.length_m));
            let way_m = from.distance(to);
            assert!(way_m <= 1.5 * car.speed_mps * 0.01 + 0.01, "{way_m} m in a tick at {} m/s", car.speed_mps);
            assert!((0.0..40.0).contains(&car.speed_mps));
            on_path += usize::from(car.s_m.is_some());
            lanes.extend(car.lane.map(|at| at.lane));
        }
        if let Some(place) = snapshot.ego_lane {
            let net = &world.map().network;
            // The lane position is that of the front bumper.
            let front = snapshot.ego.pose().front(CAR_LENGTH_M);
            assert!(net.pose(place).position.truncate().distance(front) < 1.0, "{place:?} {front}");
        }
    });
    println!("{} vehicles, {} gone, {on_path} on the path, {} lanes; {first:?}", ever.len(), gone.len(), lanes.len());
    assert!(ever.len() > 40 && gone.len() > 20 && on_path > 1000 && lanes.len() > 20);
    assert_eq!((first.contact_count, first.left_road), (0, 0));
    assert!(first.ego_mean_speed_mps > Some(3.0), "{first:?}");
    let again = drive(&scenario, |_| ());
    assert_eq!(first, again);
    let other = drive(&Scenario { seed: 2, duration_s: 20.0, ..scenario }, |_| ());
    assert_ne!(first.hash, other.hash);
}

#[test]
fn a_drive_ends_at_the_end_of_its_path_and_reports_it() {
    let _alone = one_at_a_time();
    let (mut ends, mut last_s_m, mut length_m) = (Vec::new(), 0.0, 0.0);
    let summary = drive(&scenario("A0B0 B0C0", Demand::default()), |world| {
        let ended = world.events().iter().filter(|event| matches!(event.kind, EventKind::Ended(_)));
        ends.extend(ended.map(|event| event.kind));
        (last_s_m, length_m) = (world.snapshot().ego_s_m, world.map().route.length_m());
    });
    assert_eq!(ends, [EventKind::Ended(EndReason::PathEnd)]);
    assert_eq!((summary.ended, summary.end_text()), (Some(EndReason::PathEnd), "end of the path".into()));
    // The length is that of the two edges and the junction between, as declared by SUMO.
    let net = Network::load(GRID).expect("a network");
    let streets = ["A0B0_0", "B0C0_0"].map(|lane| net.lane_named(lane).expect("a lane"));
    let [from, to] = streets;
    let lanes = [from].into_iter().chain(net.lanes_between(from, to)).chain([to]);
    let declared_m: f64 = lanes.map(|lane| net.lane(lane).length_m).sum();
    assert!((length_m - declared_m).abs() < 1e-6);
    // The end is at most one tick late, at 14 m/s.
    assert!((0.0..0.2).contains(&(last_s_m - length_m)), "{last_s_m} {length_m}");
    assert!(summary.duration_s < 60.0 && summary.left_road == 0, "{summary:?}");
}

#[test]
fn the_ego_stops_before_a_red_signal_and_goes_when_it_is_green() {
    let _alone = one_at_a_time();
    // The route round the grid passes a signal at every crossing.
    let (mut crossed, mut stood_at_red, mut was) = (Vec::new(), 0, 0.0);
    drive(&scenario(ROUND, Demand::default()), |world| {
        let (snapshot, map) = (world.snapshot(), world.map());
        let lanes = map.route.lanes();
        for pair in lanes.windows(2) {
            let line_m = pair[0].start_s_m + pair[0].length_m;
            let net = &map.network;
            let [from, to] = [&pair[0], &pair[1]].map(|lane| lane.lane.expect("a lane"));
            // Where the path changes lanes, a section has the lane by which the path leaves it.
            let way = net.connections_from(from).iter().find(|way| way.next() == to);
            let Some(ruled) = way.and_then(|way| way.signal) else { continue };
            let light = snapshot.signals.light(ruled.signal, ruled.index.expect("a link")).expect("a light");
            let is_red = matches!(light, SignalLight::Red | SignalLight::RedYellow);
            if was < line_m && snapshot.ego_s_m >= line_m {
                crossed.push((snapshot.tick.0, light));
            }
            let to_line_m = line_m - snapshot.ego_s_m;
            stood_at_red += u32::from(is_red && snapshot.ego.speed_mps.abs() < 0.05 && (0.0..5.0).contains(&to_line_m));
        }
        was = snapshot.ego_s_m;
    });
    println!("{crossed:?}, {stood_at_red} ticks at red");
    assert!(crossed.len() >= 3 && stood_at_red > 100);
    assert!(crossed.iter().all(|(_, light)| !matches!(light, SignalLight::Red | SignalLight::RedYellow)));
}

#[test]
fn the_ego_enters_traffic_where_there_is_room() {
    let _alone = one_at_a_time();
    let busy = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 1500.0, mix: Vec::new() };
    let demand = Demand { flows: vec![busy("A0B0", "B0C0"), busy("A1A0", "A0B0")], ..Demand::default() };
    for seed in 1..=4 {
        let scenario = Scenario { warm_up_s: 40.0, seed, path_start_m: 60.0, ..scenario("A0B0 B0C0", demand.clone()) };
        let mut world = World::new(&scenario).unwrap_or_else(|error| panic!("{error}"));
        let nearest_m = |world: &World| {
            let ego = world.snapshot().ego.pose().position;
            world.snapshot().cars.iter().map(|car| car.pose.position.distance(ego)).fold(f64::INFINITY, f64::min)
        };
        println!("{:?}, {} cars, nearest {}", world.hand_over(), world.snapshot().cars.len(), nearest_m(&world));
        assert!(world.snapshot().cars.len() > 3 && nearest_m(&world) > 3.0);
        // Vehicles behind the ego need not brake hard for it (SUMO's comfortable deceleration here is 1.5 m/s2), and neither does the ego.
        let mut driver = driver(&world);
        for _ in 0..400 {
            let controls = driver.controls(&world.perceived_by(&driver));
            world.tick(&controls).expect("a tick");
            assert!(world.events().iter().all(|event| !matches!(event.kind, EventKind::Contact { .. })));
            for car in
                world.snapshot().cars.iter().filter(|car| car.s_m.is_some_and(|s_m| s_m < world.snapshot().ego_s_m))
            {
                assert!(car.accel_mps2 > -4.5, "{car:?}");
            }
        }
    }
}

/// The merge's main road begins where the ego starts: SUMO let a car depart into the ego in the same step in which the ego started.
#[test]
fn no_vehicle_departs_into_an_ego_that_enters_in_the_same_step() {
    let _alone = one_at_a_time();
    for (seed, warm_up_s) in [(6, 34.2), (24, 46.8), (43, 34.2), (1, 0.0), (1, 0.1)] {
        let scenario = Scenario { map: "merge".into(), warm_up_s, seed, duration_s: 5.0, ..Scenario::default() };
        let summary = drive(&scenario, |_| ());
        assert!(summary.contacts.is_empty(), "seed {seed} after {warm_up_s} s: {:?}", summary.contacts);
    }
}

#[test]
fn an_impossible_drive_is_refused_with_fault_place_and_remedy() {
    let _alone = one_at_a_time();
    let refused = |scenario: &Scenario| World::new(scenario).err().expect("it is refused").to_string();
    for (path, words) in [
        ("A0B0 C9C8", ["path: edge \"C9C8\" does not exist", "remedy: name ids"]),
        ("A0B0 A1A2", ["edge \"A0B0\" does not lead to edge \"A1A2\"", "remedy: name every edge"]),
    ] {
        let text = refused(&scenario(path, Demand::default()));
        assert!(text.contains("grid-signals.net.xml") && words.iter().all(|word| text.contains(word)), "{text}");
    }
    let far = Scenario { path_start_m: 5000.0, ..scenario("A0B0", Demand::default()) };
    let text = refused(&far);
    assert!(text.contains("starts 5000 m along its path; allowed: less than") && text.contains("remedy"), "{text}");
    let strange = Flow { from: "A0B0".into(), to: "Z".into(), per_hour: 100.0, mix: Vec::new() };
    let text = refused(&scenario("A0B0", Demand { flows: vec![strange], ..Demand::default() }));
    assert!(text.contains("flow 1: to is \"Z\""), "{text}");
    for policy in ["two-phase", "constant", "ring-250-speed"] {
        let text = refused(&Scenario { policy: policy.into(), ..scenario("A0B0", Demand::default()) });
        assert!(text.contains(policy) && text.contains("remedy: choose --policy none"), "{text}");
    }
    let text =
        Scenario::from_toml("traffic = \"native\"\npath = \"A0B0\"\n", "town.toml").expect_err("refused").message;
    assert!(text.starts_with("town.toml:1:11: traffic is") && text.contains("remedy: traffic sumo"), "{text}");
}

/// Writes a policy that sees one feature from `from` to `to` and advises between 2 and 8 m/s. Returns its file.
pub(super) fn policy_that_sees(folder: &std::path::Path, feature: &str, from: f64, to: f64) -> String {
    let file = folder.join(format!("{feature}.toml"));
    let text = format!(
        "format = \"codrive policy 2\"\naction = \"speed\"\nlimits = [2.0, 8.0]\nspeed_change_mps = 0.0\nlevels = 0\n\
         holds_s = [1.0, 1.0]\ninputs = [{{ feature = \"{feature}\", from = {from:?}, to = {to:?} }}]\n\
         [[layer]]\nbias = [0.0]\nweights = [[1.0]]\n"
    );
    std::fs::write(&file, text).expect("written");
    file.display().to_string()
}

#[test]
fn a_policy_gets_the_road_features_that_it_names_if_they_exist() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    let policy = policy_that_sees(folder.path(), "signal_green", 0.0, 1.0);
    let on_grid = Scenario { policy: policy.clone(), hold_s: 1.0, ..scenario("B0B1 B1B2", Demand::default()) };
    let mut world = World::new(&on_grid).unwrap_or_else(|error| panic!("{error}"));
    let mut driver = driver(&world);
    let (mut fast, mut slow) = (0, 0);
    while world.ended().is_none() {
        let net = &world.map().network;
        let edge = world.snapshot().ego_lane.map(|at| net.edge_of(at.lane).id.clone());
        // In the file, the connections straight on from B0B1 have the links 11 and 12 of signal B1.
        let b1 = net.signals().iter().position(|signal| signal.id == "B1").expect("a signal");
        let b1 = SignalId::from_index(b1);
        let letter = world.snapshot().signals.letters(b1)[11];
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls).expect("a tick");
        if edge.as_deref() != Some("B0B1") {
            continue;
        }
        for event in world.events() {
            let EventKind::Advice(advice) = event.kind else { continue };
            let is_green = letter.eq_ignore_ascii_case(&b'g');
            assert_eq!(advice.target_mps, if is_green { 8.0 } else { 2.0 }, "{:?} {}", event.tick, letter as char);
            *(if is_green { &mut fast } else { &mut slow }) += 1;
        }
    }
    assert!(fast > 3 && slow > 3, "it sees both: {fast} {slow}");
    let on_ring = Scenario { policy, traffic: EngineChoice::Native, ..Scenario::default() };
    let text = World::new(&on_ring).err().expect("a ring has no signals").to_string();
    assert!(text.contains("sees `signal_green`") && text.contains("remedy: name another policy"), "{text}");
}

#[test]
fn a_policy_sees_the_end_of_its_path_a_free_road_and_the_limit() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    // Feature, its range, and the advice at the start, with 20 m of the first edge behind the front bumper: 2 m/s at the lower end of the
    // range, 8 at the upper one.
    let length_m = {
        let world = World::new(&scenario("B0B1 B1B2", Demand::default())).expect("a world");
        world.map().route.length_m()
    };
    for (feature, range, advised_mps) in [
        ("path_left", [0.0, 2.0 * (length_m - 20.0)], 5.0),
        ("gap", [0.0, 2000.0], 5.0),
        // In grid-signals.net.xml the limit is 13.89 m/s on all lanes.
        ("speed_limit", [0.0, 2.0 * 13.89], 5.0),
        ("follower_gap", [0.0, 4000.0], 3.5),
    ] {
        let policy = policy_that_sees(folder.path(), feature, range[0], range[1]);
        let scenario = Scenario {
            policy,
            hold_s: 1.0,
            path_start_m: 20.0,
            standing_start: true,
            ..scenario("B0B1 B1B2", Demand::default())
        };
        let mut world = World::new(&scenario).unwrap_or_else(|error| panic!("{error}"));
        world.tick(&Controls::default()).expect("a tick");
        let advice = world.snapshot().advice.expect("advice");
        assert!((advice.target_mps - advised_mps).abs() < 0.01, "{feature}: {advice:?}");
    }
}

#[test]
fn a_demand_is_part_of_the_scenario_file_with_its_files_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("town.toml");
    let text = "map = \"town\"\npath = \"a b\"\n\n[demand]\nfiles = [\"trips.rou.xml\"]\n\n[[demand.flows]]\nfrom = \"a\"\nto = \"b\"\n\
                per_hour = 300.0\nmix = [{ kind = \"truck\", share = 1.0 }]\n";
    std::fs::write(&file, text).expect("written");
    let scenario = Scenario::from_file(&file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scenario.demand.files, [folder.path().join("trips.rou.xml")]);
    assert_eq!((scenario.demand.flows[0].per_hour, &scenario.traffic), (300.0, &EngineChoice::Sumo));
    assert_eq!(Scenario::from_toml(&scenario.to_toml(), "x").expect("its own file"), scenario);
    // A drive without a demand does not mention it, so older files stay unchanged.
    assert!(!Scenario::default().to_toml().contains("demand"));
    let text_of_file = text;
    let typo = text.replace("per_hour", "per_hours");
    let text = Scenario::from_toml(&typo, "town.toml").expect_err("refused").message;
    assert!(text.starts_with("town.toml:10:1: unknown key `per_hours`"), "{text}");
    let typo = text_of_file.replace("300.0", "-4.0");
    let text = Scenario::from_toml(&typo, "town.toml").expect_err("refused").message;
    assert!(text.starts_with("town.toml:4:1: flow 1: per_hour is -4; allowed: a number above 0"), "{text}");
}

#[test]
fn an_ego_that_leaves_its_path_drives_on_and_other_vehicles_see_it() {
    let _alone = one_at_a_time();
    let flow = Flow { from: "A0B0".into(), to: "B1C1".into(), per_hour: 700.0, mix: Vec::new() };
    let demand = Demand { flows: vec![flow], ..Demand::default() };
    let mut world =
        World::new(&Scenario { path_start_m: 20.0, ..scenario("A0B0 B0C0 C0C1", demand) }).expect("a world");
    // The ego turns left at B0, where its path goes straight on.
    let other =
        codrive::map::RoadMap::load_along(GRID, &["A0B0", "B0B1", "B1C1", "C1C2", "C2B2"]).expect("a way").route;
    let mut driver = driver(&world);
    let mut s_m = 20.0;
    let (mut lanes, mut nearest_m, mut stood, mut left) = (BTreeSet::new(), f64::INFINITY, 0, Vec::new());
    for _ in 0..12_000 {
        let ego = world.snapshot().ego;
        s_m = other.project(ego.pose().front(CAR_LENGTH_M), Some(s_m)).s_m;
        let mut seen = world.perceived_by(&driver);
        (seen.lane, seen.leader, seen.stop_ahead_m) = (driver.look(&other, &ego, Some(s_m)), None, None);
        // The ego stops on the road that is not its path.
        let stands = (190.0..230.0).contains(&s_m) && stood < 3000;
        stood += u32::from(stands && ego.speed_mps < 0.1);
        let controls = driver.controls(&seen);
        let controls = if stands { Controls { throttle: 0.0, brake: 0.4, ..controls } } else { controls };
        world.tick(&controls).expect("a tick");
        lanes.extend(world.snapshot().ego_lane.map(|at| world.map().network.lane(at.lane).id.clone()));
        // Vehicles behind it in its lane while it stands; others pass in the lane beside.
        let ego = world.snapshot().ego.pose();
        let behind = world
            .snapshot()
            .cars
            .iter()
            .map(|car| ego.position - car.pose.position)
            .filter(|way| stands && way.dot(ego.forward()) > 0.0 && way.dot(ego.left()).abs() < 1.0);
        nearest_m = behind.map(|way| way.length()).fold(nearest_m, f64::min);
        for event in world.events() {
            let strange =
                matches!(event.kind, EventKind::Contact { .. } | EventKind::LeftRoad { .. } | EventKind::Ended(_));
            assert!(!strange, "{event:?} at {s_m} m");
            left.extend(matches!(event.kind, EventKind::LeftPath { .. }).then_some(event.kind));
        }
        if s_m > other.length_m() - 20.0 {
            break;
        }
    }
    println!("{s_m} of {} m, {lanes:?}, nearest {nearest_m}, stood {stood}", other.length_m());
    assert!(s_m > other.length_m() - 20.0 && stood == 3000);
    assert!(["B0B1_0", "B1C1_0", "C1C2_1"].iter().all(|lane| lanes.contains(*lane)), "{lanes:?}");
    // A vehicle came up behind it and stopped.
    assert!((5.5..15.0).contains(&nearest_m), "{nearest_m}");
    // A0B0 has 73.2 m, and the way straight on in the junction 13.6 m. The ego never came back.
    assert!(matches!(left[..], [EventKind::LeftPath { s_m }] if (73.0..87.0).contains(&s_m)), "{left:?}");
}

#[test]
fn after_a_wrong_turn_the_drive_goes_on_to_the_end_of_its_path() {
    let _alone = one_at_a_time();
    let path = "A0B0 B0C0 C0C1 C1B1 B1B2";
    let mut world = World::new(&Scenario { path_start_m: 20.0, ..scenario(path, Demand::default()) }).expect("a world");
    // The ego turns left at B0, where its path goes straight on, and meets it again at B1.
    let other = codrive::map::RoadMap::load_along(GRID, &["A0B0", "B0B1", "B1B2"]).expect("a way").route;
    let mut driver = driver(&world);
    let (mut s_m, mut events, mut shown) = (20.0, Vec::new(), Vec::new());
    while world.ended().is_none() && world.snapshot().tick.0 < 12_000 {
        let ego = world.snapshot().ego;
        s_m = other.project(ego.pose().front(CAR_LENGTH_M), Some(s_m)).s_m;
        let mut seen = world.perceived_by(&driver);
        (seen.lane, seen.leader, seen.stop_ahead_m) = (driver.look(&other, &ego, Some(s_m)), None, None);
        world.tick(&driver.controls(&seen)).expect("a tick");
        let of_path = |kind: &EventKind| matches!(kind, EventKind::LeftPath { .. } | EventKind::BackOnPath { .. });
        events.extend(world.events().iter().map(|event| event.kind).filter(of_path));
        if let [EventKind::LeftPath { .. }] = events[..] {
            shown.extend(world.snapshot().next_manoeuvre);
        }
    }
    let [EventKind::LeftPath { .. }, EventKind::BackOnPath { s_m: back_m }] = events[..] else { panic!("{events:?}") };
    let lane = world.map().route.lanes().iter().find(|lane| lane.edge_id(&world.map().network) == "B1B2");
    let start_m = lane.expect("on the path").start_s_m;
    assert!((start_m..start_m + 5.0).contains(&back_m), "{back_m} m, where B1B2 begins at {start_m} m");
    // Left at B1 and round the block, 215.6 m, is less than straight on, 69.2 m, and the 288.8 m of the path that this leaves out.
    assert!(shown.iter().all(|next| next.manoeuvre == Manoeuvre::Left && next.ahead_m < 69.2), "{:?}", shown.first());
    assert_eq!(world.ended(), Some(EndReason::PathEnd));
}

#[test]
fn a_path_may_begin_beside_a_pavement() {
    let _alone = one_at_a_time();
    // In the file, lane 0 of "ce" and "wc" is for pedestrians alone; "eend" has no such lane.
    let town = Scenario { map: "tests/data/networks/town.net.xml".into(), ..scenario("wc ce eend", Demand::default()) };
    let found = drive(&town, |_| {});
    assert_eq!((found.ended, found.left_road), (Some(EndReason::PathEnd), 0), "{found:?}");
}

#[test]
fn the_ego_gives_way_at_a_roundabout_and_drives_in_where_there_is_a_gap() {
    let _alone = one_at_a_time();
    let flow = |from: &str, per_hour: f64| Flow { from: from.into(), to: "eE".into(), per_hour, mix: Vec::new() };
    // Both flows pass the entry from the south; one of them comes from half-way round the ring.
    let demand = Demand { flows: vec![flow("Ww", 500.0), flow("Nn", 200.0)], ..Demand::default() };
    let mut stood_ticks = 0;
    for seed in 1..=6 {
        let map = "tests/data/networks/roundabout.net.xml".into();
        let scenario = Scenario { map, warm_up_s: 30.0, seed, ..scenario("Ss se eE", demand.clone()) };
        let (mut others, mut hardest_mps2) = (BTreeSet::new(), 0.0f64);
        let found = drive(&scenario, |world| {
            let (snapshot, net) = (world.snapshot(), &world.map().network);
            // The line is at the end of Ss, which is 124.07 m long in the file.
            let is_at_line = (119.0..124.07).contains(&snapshot.ego_s_m) && snapshot.ego.speed_mps.abs() < 0.1;
            stood_ticks += u32::from(is_at_line);
            for car in &snapshot.cars {
                let lane = car.lane.map(|at| net.lane(at.lane).id.as_str());
                if is_at_line && lane == Some(":s_2_0") {
                    others.insert(car.id);
                }
                // Vehicles on the ring before the entry, while the ego enters.
                if (124.07..140.0).contains(&snapshot.ego_s_m) && matches!(lane, Some("ws_0" | ":s_2_0" | "se_0")) {
                    hardest_mps2 = hardest_mps2.min(car.accel_mps2);
                }
            }
        });
        println!(
            "seed {seed}: {} went first, others braked {hardest_mps2} m/s2, {stood_ticks} ticks; {found:?}",
            others.len()
        );
        assert_eq!((found.ended, found.contact_count, found.left_road), (Some(EndReason::PathEnd), 0, 0));
        assert_eq!(found.near_misses, 0);
        // The limit is the model's comfortable deceleration.
        assert!(hardest_mps2 > -1.5, "{hardest_mps2}");
    }
    assert!(stood_ticks > 100);
}

#[test]
fn a_simulated_driver_takes_the_exit_of_the_motorway_in_its_traffic() {
    let _alone = one_at_a_time();
    let scenario = Scenario { map: "motorway".into(), path_start_m: 7000.0, ..Scenario::default() };
    // Traffic takes 240 s to the exit.
    let (mut most, mut slowest_mps) = (0, f64::INFINITY);
    let summary = drive(&Scenario { duration_s: 120.0, warm_up_s: 260.0, ..scenario }, |world| {
        most = most.max(world.snapshot().cars.len());
        let network = &world.map().network;
        let is_on_motorway = |car: &&VehicleSnapshot| {
            car.lane.is_some_and(|at| !["on_0", "off_0"].contains(&&*network.lane(at.lane).id))
        };
        let there = world.snapshot().cars.iter().filter(is_on_motorway).map(|car| car.speed_mps);
        slowest_mps = there.fold(slowest_mps, f64::min);
    });
    assert_eq!((summary.ended, summary.contact_count), (Some(EndReason::PathEnd), 0));
    // A vehicle that missed its lane would stand where the exit leaves. Lorries do 24 m/s, and who leaves slows down to 17 m/s.
    assert!(most > 400 && slowest_mps > 10.0, "{most} vehicles, {slowest_mps} m/s");
}

#[test]
fn a_simulated_driver_drives_through_the_town_in_seven_minutes() {
    let _alone = one_at_a_time();
    let mut kinds = std::collections::BTreeSet::new();
    let scenario = Scenario { map: "town".into(), warm_up_s: 120.0, duration_s: 600.0, ..Scenario::default() };
    let summary = drive(&scenario, |world| kinds.extend(world.snapshot().cars.iter().map(|car| car.body.kind.name())));
    assert_eq!((summary.ended, summary.contact_count, summary.left_road), (Some(EndReason::PathEnd), 0, 0));
    // Familiarisation takes seven minutes, and signals and traffic a minute or two more or less.
    assert!((360.0..540.0).contains(&summary.duration_s), "{} s", summary.duration_s);
    for kind in ["car", "van", "truck", "bus", "bicycle", "pedestrian"] {
        assert!(kinds.contains(kind), "no {kind} among {kinds:?}");
    }
}
