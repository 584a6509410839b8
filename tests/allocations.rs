//! Allocations in a tick. In a drive of hours an allocating tick sometimes waits for the system, and lists that grow a little in each tick
//! fill the memory overnight. In: drives of the simulated driver. Out: the number of allocations of the thread, counted by the allocator of
//! this test.

use codrive::{
    driver::{SimulatedDriver, preset},
    idm::IdmParams,
    map::{RoadMap, network::Network},
    policy::Action,
    scenario::{AdvisedVehicles, Scenario},
    sim::World,
    space::CAR_LENGTH_M,
    traffic::{
        self, Demand, DemandSetup, EngineChoice, ExternalVehicleState, FixedSetup, ModelMixture, Traffic,
        TrafficDrivers, VehicleReport,
        sumo::{self, SumoTraffic},
    },
    train::{DriverConfig, FollowKind, RingConfig, TrainConfig, environment::VecEnv},
};
use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
    fs,
    process::Command,
    sync::{Arc, Mutex, MutexGuard},
};

/// The system's allocator, with a count of the allocations of each thread.
struct Counting;

thread_local! {
    static ASKED: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    ASKED.set(ASKED.get() + 1);
}

// SAFETY: every call goes to the system's allocator; counting changes a number of this thread only and allocates nothing.
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

/// Returns the number of allocations by `work` in this thread.
fn asked(work: impl FnOnce()) -> u64 {
    let before = ASKED.get();
    work();
    ASKED.get() - before
}

/// Waits for the exclusive use of SUMO in this process.
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
fn a_step_of_either_engine_allocates_no_memory() {
    const STEP_S: f64 = 0.1;
    let _guard = alone();
    for engine in [EngineChoice::Native, EngineChoice::Sumo] {
        let map = Arc::new(RoadMap::load("ring-250").expect("a map that is shipped"));
        let idm = IdmParams { noise: 0.2, ..IdmParams::default() };
        let cars = traffic::start::even(22, map.route.length_m(), idm.s0, 4.362).expect("they fit");
        let setup = FixedSetup {
            map: Arc::clone(&map),
            cars,
            drivers: TrafficDrivers::Alike(idm),
            mixture: ModelMixture::default(),
            step_s: STEP_S,
            seed: 1,
            lateral_accel_mps2: None,
        };
        let mut traffic = traffic::start(&engine, setup).unwrap();
        // After ten minutes there is a wave, and every vehicle has been on every lane. The first step fills lists that stay.
        for step in 0..6000 {
            let ego = traffic.vehicles()[0];
            let s_m = map.route.s_on(ego.lane.expect("on the route"), ego.s_m).expect("on the route");
            let next_mps = 4.0 + (f64::from(step) * 0.01).sin();
            let next_pose = map.route.pose_of_front(s_m + next_mps * STEP_S, CAR_LENGTH_M);
            let pose = ego.pose;
            let report = ExternalVehicleState { pose, speed_mps: ego.speed_mps, next_pose, next_speed_mps: next_mps };
            let times = asked(|| traffic.step(&[VehicleReport::of_ego(report)]).unwrap());
            assert!(step == 0 || times == 0, "{engine:?}, step {step}: {times} times");
        }
    }
}

#[test]
fn a_network_step_without_new_vehicles_allocates_no_memory() {
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
    // Sixty vehicles in the first half minute, and as many in the half minute after the next.
    let ways = [("left0A0", "C2right2"), ("bottom1B0", "B2top1"), ("right1C1", "A1left1")];
    let trip = |k: usize| {
        let (from, to) = ways[k % 3];
        let at = k as f64 / 2.0 + if k < 60 { 0.0 } else { 30.0 };
        format!("<trip id=\"v{k}\" depart=\"{at}\" from=\"{from}\" to=\"{to}\" departLane=\"best\"/>")
    };
    let demand = folder.path().join("trips.rou.xml");
    fs::write(&demand, format!("<routes>{}</routes>", (0..120).map(trip).collect::<String>())).expect("written");
    let setup = DemandSetup {
        network,
        net_file,
        demand: Demand { files: vec![demand], ..Demand::default() },
        egos: Vec::new(),
        first_number: 0,
        drivers: TrafficDrivers::Alike(IdmParams::default()),
        step_s: 0.1,
        until_s: 3600.0,
        seed: 1,
    };
    let mut traffic = SumoTraffic::start_with_demand(&setup).expect("it starts");
    // Steps fill two lists alternately.
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

/// Allocations of rapier 0.36 in a tick of four steps, each with three lists: changed bodies, pairs in contact, and one for its solver.
/// codrive must not add to them.
const RAPIER: u64 = 4 * 3;
/// Ticks in which lists may still grow to their final size: a minute.
const SETTLING_TICKS: u64 = 6_000;
/// Distance within which a vehicle counts as near, m. Vehicles within 15 m of the ego take part in its physics, and rapier allocates lists
/// when one enters or leaves.
const NEAR_M: f64 = 17.0;

/// Number of ticks, and of ticks with more allocations than the physics library makes.
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

/// Drives three minutes and skips the first. Returns the ticks without any vehicle near the ego, and the others.
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
fn a_tick_allocates_no_more_memory_than_its_physics_library() {
    let _guard = alone();
    // A policy is asked alike on both engines.
    let policies = ["none", "auto", "constant", "two-phase", "follower-stopper", "pi"];
    for (traffic, policies) in [(EngineChoice::Native, &policies[..]), (EngineChoice::Sumo, &policies[..2])] {
        for &policy in policies {
            // 30 m for each vehicle.
            let scenario = Scenario {
                traffic: traffic.clone(),
                policy: policy.into(),
                map: "ring-641".into(),
                vehicles: 21,
                hold_s: 1.0,
                duration_s: 0.0,
                ..Scenario::default()
            };
            let [alone, near] = drive(&scenario);
            let seen = format!("{traffic}, policy {policy}: nobody near {alone:?}, somebody near {near:?}");
            // A hundred ticks contain an advice and ten steps.
            assert!(alone.all >= 500, "too few to judge: {seen}");
            assert_eq!(alone.more, 0, "{seen}");
            assert!(100 * near.more <= near.all, "more than now and then: {seen}");
        }
    }
}

#[test]
fn light_agents_allocate_no_memory_in_a_step() {
    let _guard = alone();
    for traffic in [EngineChoice::Native, EngineChoice::Sumo] {
        let advised = AdvisedVehicles::Count(5);
        let [_, near] = drive(&Scenario {
            traffic: traffic.clone(),
            policy: "pi".into(),
            advised,
            duration_s: 0.0,
            ..Scenario::default()
        });
        // As without them: of 100 ticks, in which ten steps of each agent begin, one may have a vehicle that enters the physics.
        assert!(near.all > SETTLING_TICKS && 100 * near.more <= near.all, "{traffic}: {near:?}");
    }
}

#[test]
fn distant_vehicles_cost_the_physics_of_the_ego_nothing() {
    // The paper's ring: two to four vehicles near the ego, seventeen or more beyond. One enters or leaves in less than 1 of 100 ticks.
    let [_, near] = drive(&Scenario { traffic: EngineChoice::Native, duration_s: 0.0, ..Scenario::default() });
    assert!(near.all > SETTLING_TICKS && 100 * near.more <= near.all, "{near:?}");
}

#[test]
fn a_hold_of_fast_rings_with_many_advised_vehicles_allocates_nothing() {
    let ring = RingConfig { advised: AdvisedVehicles::Share(1.0), warm_up_s: 1.0, ..RingConfig::default() };
    let driver = DriverConfig { follow: FollowKind::Driver, leader_reaction_s: 0.5, ..DriverConfig::default() };
    let config = TrainConfig { ring, driver, ..TrainConfig::default() };
    let mut block = VecEnv::new(&config, "test", 0, config.hold());
    let actions = vec![Action::Acceleration(0.1); block.rows()];
    let mut reports = 0;
    // The first hold makes room for the noise.
    block.hold_each(&actions, |_, _, _| reports += 1);
    assert_eq!(asked(|| (0..20).for_each(|_| block.hold_each(&actions, |_, _, _| reports += 1))), 0);
    assert_eq!(reports, 21 * 16 * 22);
}
