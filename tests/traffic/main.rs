//! The contract of the traffic engines. `contract` runs over both engines, `imposed` is about an ego that somebody drives, `several` about several of them,
//! `noise` about its strength, `sumo` about SUMO alone, `network` about roads on which vehicles come and go, `network_ego` about an ego there, `networks` about networks that do not come with the program,
//! `forks` about lanes that lead to several, `fuel` about the emission model.
//! `gate` and `gate_program` are about files that would make SUMO write.
//! Metres, m/s, steps of 0.1 s.
//!
//! libsumo runs one simulation in a process, so every test holds [`alone`].

mod contract;
mod forks;
mod fuel;
mod gate;
mod gate_program;
mod imposed;
mod network;
mod network_ego;
mod networks;
mod noise;
mod several;
mod sumo;

use codrive::{
    idm::IdmParams,
    map::RoadMap,
    space::CAR_LENGTH_M,
    traffic::{
        self, CarState, EngineChoice, ExternalVehicleState, InitialVehicle, ModelMixture, Traffic, TrafficSetup,
        VehicleReport, start,
    },
};
use std::sync::{Arc, Mutex, MutexGuard};

/// Length of a step, seconds.
const STEP_S: f64 = 0.1;
/// Speed of the even ring of 22 cars on 250 m, m/s (docs/references.md: ring).
const EVEN_MPS: f64 = 4.362;
/// Both engines.
const ENGINES: [EngineChoice; 2] = [EngineChoice::Native, EngineChoice::Sumo];

/// All cars at every step, the start first.
type History = Vec<Vec<CarState>>;

/// The right to use SUMO in this process.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn model(noise: f64) -> IdmParams {
    IdmParams { noise, ..IdmParams::default() }
}

/// `n` cars evenly spaced on a map.
fn even(map: &str, n: usize, idm: IdmParams, speed_mps: f64) -> TrafficSetup {
    let map = Arc::new(RoadMap::load(map).expect("the map is in the project"));
    let cars = start::even(n, map.route.length_m(), idm.s0, speed_mps).expect("they fit");
    let mixture = ModelMixture::default();
    TrafficSetup { map, cars, idm, mixture, step_s: STEP_S, seed: 1, lateral_accel_mps2: None }
}

/// The paper's ring: 22 cars at its speed.
fn ring(noise: f64) -> TrafficSetup {
    even("ring-250", 22, model(noise), EVEN_MPS)
}

/// A report of an ego on the centre line whose next speed is `next_mps`.
fn report(map: &RoadMap, ego: &CarState, next_mps: f64) -> ExternalVehicleState {
    ExternalVehicleState {
        pose: ego.pose(&map.route),
        speed_mps: ego.speed_mps,
        next_pose: map.route.pose_of_front(ego.s_m + next_mps * STEP_S, CAR_LENGTH_M),
        next_speed_mps: next_mps,
    }
}

/// Runs `steps`; `drive` says for each step what the ego does, `None` for its own model.
fn run(
    traffic: &mut dyn Traffic,
    steps: usize,
    mut drive: impl FnMut(usize, &[CarState]) -> Option<ExternalVehicleState>,
) -> History {
    run_reported(traffic, steps, |step, cars| drive(step, cars).map(VehicleReport::of_ego).into_iter().collect())
}

/// The same with reports of any cars.
fn run_reported(
    traffic: &mut dyn Traffic,
    steps: usize,
    mut drive: impl FnMut(usize, &[CarState]) -> Vec<VehicleReport>,
) -> History {
    let mut history = vec![traffic.cars().to_vec()];
    for step in 0..steps {
        let reports = drive(step, traffic.cars());
        traffic.step(&reports).expect("the step is taken");
        history.push(traffic.cars().to_vec());
    }
    history
}

/// Starts `engine` and runs it with nobody at the wheel.
fn run_free(engine: EngineChoice, setup: TrafficSetup, steps: usize) -> History {
    let mut traffic = traffic::start(engine, setup).expect("the engine starts");
    run(traffic.as_mut(), steps, |_, _| None)
}

/// The even ring whose ego is braked to 0.5 m/s from 60 s to 62 s.
fn run_kicked(engine: EngineChoice, setup: TrafficSetup, steps: usize) -> History {
    let map = setup.map.clone();
    let mut traffic = traffic::start(engine, setup).expect("the engine starts");
    run(traffic.as_mut(), steps, |step, cars| {
        (600..620).contains(&step).then(|| report(&map, &cars[0], (cars[0].speed_mps - 0.9).max(0.5)))
    })
}

/// Mean speed and standard deviation across cars, both averaged over the time from `from_s` to `to_s`.
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

/// The smallest gap between any two cars, bumper to bumper, metres, and the smallest way a car went in a step.
fn smallest_gap_and_way(map: &RoadMap, history: &History) -> (f64, f64) {
    let (mut gap_m, mut way_m) = (f64::INFINITY, f64::INFINITY);
    for (step, cars) in history.iter().enumerate() {
        for (i, car) in cars.iter().enumerate() {
            let leader = &cars[(i + 1) % cars.len()];
            // The shorter way round, so that an overlap is a negative gap and not nearly a lap.
            gap_m = gap_m.min(map.route.difference(car.s_m, leader.s_m) - CAR_LENGTH_M);
            if step > 0 {
                way_m = way_m.min(map.route.difference(history[step - 1][i].s_m, car.s_m));
            }
        }
    }
    (gap_m, way_m)
}

/// The largest differences between two histories in speed, place along the route, and position of the centre.
fn differences(map: &RoadMap, a: &History, b: &History) -> (f64, f64, f64) {
    assert_eq!(a.len(), b.len());
    let mut most = (0.0_f64, 0.0_f64, 0.0_f64);
    for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
        assert_eq!(x.id, y.id);
        most.0 = most.0.max((x.speed_mps - y.speed_mps).abs());
        most.1 = most.1.max(map.route.difference(x.s_m, y.s_m).abs());
        most.2 = most.2.max(x.pose(&map.route).position.distance(y.pose(&map.route).position));
    }
    most
}

/// Every number of a history as bits.
fn bits(history: &History) -> Vec<[u64; 3]> {
    let of = |car: &CarState| [car.s_m, car.speed_mps, car.accel_mps2].map(f64::to_bits);
    history.iter().flatten().map(of).collect()
}

/// Cars at rest at the places given.
fn standing_at(places_m: &[f64]) -> Vec<InitialVehicle> {
    places_m.iter().map(|&s_m| InitialVehicle { s_m, speed_mps: 0.0 }).collect()
}
