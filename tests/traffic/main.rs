//! The contract of the traffic engines. `contract` covers both engines, `imposed` an externally driven ego, `several` several of them, and
//! `noise` its strength. `sumo` covers SUMO alone, `network` roads that vehicles enter and leave, `network_ego` an ego there, and
//! `networks` networks that are not shipped. `forks` covers lanes that lead to several, and `fuel` the emission model. `demand` covers
//! additional files, begin and persons, `long_vehicles` buses and lorries. `gate`
//! and `gate_program` cover files that would make SUMO write. Metres, m/s, steps of 0.1 s.
//!
//! libsumo runs one simulation per process, so every test holds [`alone`].

mod contract;
mod demand;
mod forks;
mod fuel;
mod gate;
mod gate_program;
mod imposed;
mod long_vehicles;
mod network;
mod network_ego;
mod networks;
mod noise;
mod people;
mod several;
mod sumo;

use codrive::{
    idm::IdmParams,
    map::RoadMap,
    space::{CAR_LENGTH_M, Pose},
    traffic::{
        self, EngineChoice, ExternalVehicleState, FixedSetup, InitialVehicle, ModelMixture, Traffic, TrafficDrivers,
        VehicleId, VehicleReport, VehicleState, start,
    },
};
use std::sync::{Arc, Mutex, MutexGuard};

/// Length of a step, seconds.
const STEP_S: f64 = 0.1;
/// Speed of the even ring of 22 cars on 250 m, m/s (docs/references.md: ring).
const EVEN_MPS: f64 = 4.362;
const ENGINES: [EngineChoice; 2] = [EngineChoice::Native, EngineChoice::Sumo];

/// A vehicle of a fixed number, on its route.
#[derive(Clone, Copy, Debug)]
struct CarState {
    id: VehicleId,
    /// Front bumper along the route, metres.
    s_m: f64,
    speed_mps: f64,
    accel_mps2: f64,
    braking: bool,
    pose: Pose,
}

/// Returns all vehicles of an engine on their route.
fn cars(map: &RoadMap, traffic: &mut dyn Traffic) -> Vec<CarState> {
    let on_route = |vehicle: &VehicleState| CarState {
        id: vehicle.id,
        s_m: vehicle.lane.and_then(|lane| map.route.s_on(lane, vehicle.s_m)).expect("on the route"),
        speed_mps: vehicle.speed_mps,
        accel_mps2: vehicle.accel_mps2,
        braking: vehicle.lamps.brake,
        pose: vehicle.pose,
    };
    traffic.vehicles().iter().map(on_route).collect()
}

/// All vehicles at every step, the start first.
type History = Vec<Vec<CarState>>;

/// Takes the right to use SUMO in this process.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn model(noise: f64) -> IdmParams {
    IdmParams { noise, ..IdmParams::default() }
}

/// Returns a setup of `n` vehicles evenly spaced on a map.
fn even(map: &str, n: usize, idm: IdmParams, speed_mps: f64) -> FixedSetup {
    let map = Arc::new(RoadMap::load(map).expect("the map is in the project"));
    let cars = start::even(n, map.route.length_m(), idm.s0, speed_mps).expect("they fit");
    let mixture = ModelMixture::default();
    let drivers = TrafficDrivers::Alike(idm);
    FixedSetup { map, cars, drivers, mixture, step_s: STEP_S, seed: 1, lateral_accel_mps2: None }
}

/// Returns the setup of the paper's ring: 22 vehicles at its equilibrium speed.
fn ring(noise: f64) -> FixedSetup {
    even("ring-250", 22, model(noise), EVEN_MPS)
}

/// Returns the report of an ego on the centre line whose next speed is `next_mps`.
fn report(map: &RoadMap, ego: &CarState, next_mps: f64) -> ExternalVehicleState {
    ExternalVehicleState {
        pose: ego.pose,
        speed_mps: ego.speed_mps,
        next_pose: map.route.pose_of_front(ego.s_m + next_mps * STEP_S, CAR_LENGTH_M),
        next_speed_mps: next_mps,
    }
}

/// Runs `steps`; `drive` returns the ego's report for each step, or `None` for its own model.
fn run(
    map: &RoadMap,
    traffic: &mut dyn Traffic,
    steps: usize,
    mut drive: impl FnMut(usize, &[CarState]) -> Option<ExternalVehicleState>,
) -> History {
    run_reported(map, traffic, steps, |step, cars| drive(step, cars).map(VehicleReport::of_ego).into_iter().collect())
}

/// Runs `steps` with reports of any vehicles.
fn run_reported(
    map: &RoadMap,
    traffic: &mut dyn Traffic,
    steps: usize,
    mut drive: impl FnMut(usize, &[CarState]) -> Vec<VehicleReport>,
) -> History {
    let mut history = vec![cars(map, traffic)];
    for step in 0..steps {
        let reports = drive(step, &history[step]);
        traffic.step(&reports).expect("the step is taken");
        history.push(cars(map, traffic));
    }
    history
}

/// Starts `engine` and runs it without externally driven vehicles.
fn run_free(engine: &EngineChoice, setup: FixedSetup, steps: usize) -> History {
    let map = setup.map.clone();
    let mut traffic = traffic::start(engine, setup).expect("the engine starts");
    run(&map, traffic.as_mut(), steps, |_, _| None)
}

/// Runs the setup with an ego that is braked to 0.5 m/s from 60 s to 62 s.
fn run_kicked(engine: &EngineChoice, setup: FixedSetup, steps: usize) -> History {
    let map = setup.map.clone();
    let mut traffic = traffic::start(engine, setup).expect("the engine starts");
    run(&map, traffic.as_mut(), steps, |step, cars| {
        (600..620).contains(&step).then(|| report(&map, &cars[0], (cars[0].speed_mps - 0.9).max(0.5)))
    })
}

/// Returns mean speed and standard deviation across vehicles, both averaged over the time from `from_s` to `to_s`.
fn mean_and_spread(history: &History, from_s: f64, to_s: f64) -> (f64, f64) {
    let window = &history[(from_s / STEP_S) as usize..(to_s / STEP_S) as usize];
    let (mut means, mut spreads) = (0.0, 0.0);
    for cars in window {
        let n = cars.len() as f64;
        let mean = cars.iter().map(|car| car.speed_mps).sum::<f64>() / n;
        means += mean;
        spreads += (cars.iter().map(|car| (car.speed_mps - mean).powi(2)).sum::<f64>() / n).sqrt();
    }
    (means / window.len() as f64, spreads / window.len() as f64)
}

/// Returns the smallest gap between any two vehicles, bumper to bumper, and the smallest distance that a vehicle moved in a step, metres.
fn smallest_gap_and_way(map: &RoadMap, history: &History) -> (f64, f64) {
    let (mut gap_m, mut way_m) = (f64::INFINITY, f64::INFINITY);
    for (step, cars) in history.iter().enumerate() {
        for (i, car) in cars.iter().enumerate() {
            let leader = &cars[(i + 1) % cars.len()];
            // The shorter way round makes an overlap a negative gap, not nearly a lap.
            gap_m = gap_m.min(map.route.difference(car.s_m, leader.s_m) - CAR_LENGTH_M);
            if step > 0 {
                way_m = way_m.min(map.route.difference(history[step - 1][i].s_m, car.s_m));
            }
        }
    }
    (gap_m, way_m)
}

/// Returns the largest differences between two histories in speed, position along the route, and position of the centre.
fn differences(map: &RoadMap, a: &History, b: &History) -> (f64, f64, f64) {
    assert_eq!(a.len(), b.len());
    let mut most = (0.0_f64, 0.0_f64, 0.0_f64);
    for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
        assert_eq!(x.id, y.id);
        most.0 = most.0.max((x.speed_mps - y.speed_mps).abs());
        most.1 = most.1.max(map.route.difference(x.s_m, y.s_m).abs());
        most.2 = most.2.max(x.pose.position.distance(y.pose.position));
    }
    most
}

/// Returns every number of a history as bits.
fn bits(history: &History) -> Vec<[u64; 3]> {
    let of = |car: &CarState| [car.s_m, car.speed_mps, car.accel_mps2].map(f64::to_bits);
    history.iter().flatten().map(of).collect()
}

/// Returns vehicles at rest at the given positions.
fn standing_at(places_m: &[f64]) -> Vec<InitialVehicle> {
    places_m.iter().map(|&s_m| InitialVehicle { s_m, speed_mps: 0.0 }).collect()
}
