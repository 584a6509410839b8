//! Allocations in a tick. A drive of hours makes nothing anew: a tick that asks the system for memory waits now and then for
//! it, and what grows by a little in each tick fills the machine at night. In: drives of the simulated driver. Out: the
//! number of times that the thread asked for memory, counted by the allocator of this test.

use codrive::{
    driver::{SimulatedDriver, preset},
    idm::IdmParams,
    map::{RoadMap, network::Network},
    scenario::Scenario,
    sim::World,
    space::CAR_LENGTH_M,
    traffic::{
        self, Demand, EngineChoice, ExternalVehicleState, ModelMixture, TrafficSetup, VehicleReport,
        sumo::{self, NetworkSetup, SumoNetwork},
    },
};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    fs,
    process::Command,
    sync::{Arc, Mutex, MutexGuard},
};

/// The system's allocator, and how often each thread asked it for memory.
struct Counting;

thread_local! {
    static ASKED: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    ASKED.set(ASKED.get() + 1);
}

// SAFETY: everything is the system's; counting touches a number of this thread alone and asks for no memory itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// How often `work` asked for memory.
fn asked(work: impl FnOnce()) -> u64 {
    let before = ASKED.get();
    work();
    ASKED.get() - before
}

/// The right to use SUMO in this process.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

#[test]
fn the_allocator_of_this_test_counts() {
    assert_eq!(asked(|| drop(std::hint::black_box(Box::new(1)))), 1);
    assert_eq!(asked(|| drop(std::hint::black_box(vec![0u8; 1000]))), 1);
    assert_eq!(asked(|| ()), 0);
}

#[test]
fn a_step_of_either_engine_asks_for_no_memory() {
    const STEP_S: f64 = 0.1;
    let _guard = alone();
    for engine in [EngineChoice::Native, EngineChoice::Sumo] {
        let map = Arc::new(RoadMap::load("ring-250").expect("a map that is shipped"));
        let idm = IdmParams { noise: 0.2, ..IdmParams::default() };
        let cars = traffic::start::even(22, map.route.length_m(), idm.s0, 4.362).expect("they fit");
        let setup = TrafficSetup {
            map: Arc::clone(&map),
            cars,
            idm,
            mixture: ModelMixture::default(),
            step_s: STEP_S,
            seed: 1,
            lateral_accel_mps2: None,
        };
        let mut traffic = traffic::start(engine, setup).unwrap();
        // Ten minutes: by then a wave is there, and every car has been on every lane. The first step fills lists that stay.
        for step in 0..6000 {
            let ego = traffic.cars()[0];
            let next_mps = 4.0 + (f64::from(step) * 0.01).sin();
            let next_pose = map.route.pose_of_front(ego.s_m + next_mps * STEP_S, CAR_LENGTH_M);
            let pose = ego.pose(&map.route);
            let report = ExternalVehicleState { pose, speed_mps: ego.speed_mps, next_pose, next_speed_mps: next_mps };
            let times = asked(|| traffic.step(&[VehicleReport::of_ego(report)]).unwrap());
            assert!(step == 0 || times == 0, "{engine:?}, step {step}: {times} times");
        }
    }
}

#[test]
fn a_step_on_a_network_in_which_nobody_comes_asks_for_no_memory() {
    let _guard = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let home = sumo::home().expect("SUMO is here");
    let net_file = folder.path().join("grid.net.xml");
    let made = Command::new(home.join("bin/netgenerate"))
        .env("SUMO_HOME", &home)
        .args([
            "--grid",
            "--grid.number",
            "3",
            "--grid.attach-length",
            "100",
            "-L",
            "2",
            "--tls.guess",
            "--output-file",
        ])
        .arg(&net_file)
        .output()
        .expect("SUMO's programs run");
    assert!(made.status.success());
    let network = Arc::new(Network::load(net_file.to_str().expect("plain")).expect("it can be read"));
    // Sixty vehicles in half a minute, and as many in the half minute after the next.
    let ways = [("left0A0", "C2right2"), ("bottom1B0", "B2top1"), ("right1C1", "A1left1")];
    let trip = |k: usize| {
        let (from, to) = ways[k % 3];
        let at = k as f64 / 2.0 + if k < 60 { 0.0 } else { 30.0 };
        format!("<trip id=\"v{k}\" depart=\"{at}\" from=\"{from}\" to=\"{to}\" departLane=\"best\"/>")
    };
    let demand = folder.path().join("trips.rou.xml");
    fs::write(&demand, format!("<routes>{}</routes>", (0..120).map(trip).collect::<String>())).expect("written");
    let setup = NetworkSetup {
        network,
        net_file,
        demand: Demand { files: vec![demand], flows: Vec::new() },
        egos: Vec::new(),
        first_number: 0,
        idm: IdmParams::default(),
        step_s: 0.1,
        until_s: 3600.0,
        seed: 1,
    };
    let mut traffic = SumoNetwork::start(&setup).expect("it starts");
    // Steps fill two lists in turn.
    let (mut most, mut most_gone, mut quiet, mut gone) = ([0; 2], 0, 0, 0);
    for step in 0..2400 {
        let times = asked(|| traffic.step(&[]).unwrap());
        let now = traffic.vehicles().len();
        let gone_now = traffic.changes().arrived.len();
        gone += gone_now;
        if now <= most[step % 2] && gone_now <= most_gone && traffic.changes().departed.is_empty() {
            assert_eq!(times, 0, "step {step}: {times} times, {now} vehicles");
            quiet += 1;
        }
        most[step % 2] = most[step % 2].max(now);
        most_gone = most_gone.max(gone_now);
    }
    println!("{quiet} steps, at most {} vehicles, {gone} arrived", most[0]);
    assert!(quiet > 1500 && most[0] > 30 && gone > 60);
}

/// What rapier 0.36 makes anew in each of its steps, of which a tick has four: the list of changed bodies, one of the pairs
/// that push each other, and one for its solver. Nothing of ours may add to that.
const RAPIER: u64 = 4 * 3;
/// Ticks in which lists may still grow to the size that they keep: a minute.
const SETTLING_TICKS: u64 = 6_000;
/// Cars within 15 m of the ego take part in its physics, where rapier makes lists of its own when one comes or goes.
const NEAR_M: f64 = 17.0;

/// How many of some ticks asked for more memory than the physics library does.
#[derive(Debug, Default)]
struct Ticks {
    all: u64,
    more: u64,
}

impl Ticks {
    fn count(&mut self, times: u64) {
        self.all += 1;
        self.more += u64::from(times > RAPIER);
    }
}

/// The ticks of two minutes after the first one: those with nobody near the ego, and the others.
fn drive(scenario: &Scenario) -> [Ticks; 2] {
    let mut world = World::new(scenario).unwrap();
    let params = preset(&scenario.driver).unwrap();
    let mut driver = SimulatedDriver::new(&params, world.ego_params(), scenario.seed).unwrap();
    let mut ticks = <[Ticks; 2]>::default();
    for tick in 0..3 * SETTLING_TICKS {
        let controls = driver.controls(&world.perceived_by(&driver));
        let times = asked(|| world.tick(&controls).unwrap());
        let snapshot = world.snapshot();
        let here = snapshot.ego.position.truncate();
        let near = snapshot.cars.iter().any(|car| car.pose.position.distance(here) < NEAR_M);
        if tick >= SETTLING_TICKS {
            ticks[usize::from(near)].count(times);
        }
    }
    ticks
}

#[test]
fn a_tick_of_the_world_asks_for_no_more_memory_than_its_physics_library() {
    let _guard = alone();
    for traffic in [EngineChoice::Native, EngineChoice::Sumo] {
        for policy in ["none", "constant", "auto", "two-phase", "follower-stopper", "pi"] {
            // 30 m for each car.
            let scenario = Scenario {
                traffic,
                policy: policy.into(),
                map: "ring-641".into(),
                vehicles: 21,
                hold_s: 1.0,
                duration_s: 0.0,
                ..Scenario::default()
            };
            let [alone, near] = drive(&scenario);
            let seen = format!("{traffic}, policy {policy}: nobody near {alone:?}, somebody near {near:?}");
            // A hundred ticks hold an advice and ten steps.
            assert!(alone.all >= 500, "too few to judge: {seen}");
            assert_eq!(alone.more, 0, "{seen}");
            assert!(100 * near.more <= near.all, "more than now and then: {seen}");
        }
    }
}

#[test]
fn cars_that_are_far_from_the_ego_cost_its_physics_nothing() {
    // The paper's ring: two to four others near by, seventeen or more beyond. One comes or goes in less than 1 of 100 ticks.
    let [_, near] = drive(&Scenario { traffic: EngineChoice::Native, duration_s: 0.0, ..Scenario::default() });
    assert!(near.all > SETTLING_TICKS && 100 * near.more <= near.all, "{near:?}");
}
