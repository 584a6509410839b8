//! Simulation without graphics: steps of the traffic engines, ticks of the ego and of the whole world. In: a scenario. Out: a
//! [`SimulationReport`].

use super::{
    TimeStatistics,
    network::{NetworkLoading, network_loading, network_step},
    now,
};
use crate::{
    controls::Controls,
    drive_loop::{RunError, offline::OfflineDrive},
    ego::{CarParams, EgoCar, GroundSurface, Obstacle, ObstacleId, UniformGround},
    scenario::{PlannedDrive, Scenario},
    sim::WorldError,
    traffic::{
        FixedSetup, ModelMixture, NativeTraffic, Traffic, TrafficDrivers, TrafficError, start, sumo::SumoTraffic,
    },
};
use serde::Serialize;
use std::{sync::Arc, time::Duration};

/// Times of SUMO's step: alone, and with the ego's pose sent and all states read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SumoTimes {
    /// Traffic engine and its version.
    pub engine: String,
    /// Times of `simulationStep` alone.
    pub bare: TimeStatistics,
    /// Times of a step as in a drive: pose and speed of the ego in, states of all vehicles out.
    pub full: TimeStatistics,
    /// Median ratio of full to bare, of blocks taken in turn.
    pub ratio: f64,
}

/// Results of the measurements without graphics.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulationReport {
    /// Times of SUMO on a ring; `None` if SUMO is not on this machine.
    pub sumo_step: Option<SumoTimes>,
    /// Times of SUMO on a network of ten by ten junctions, and the mean number of vehicles; `None` if SUMO is not on this
    /// machine.
    pub network_step: Option<(SumoTimes, f64)>,
    /// Time to read a network of ten thousand edges; `None` if SUMO is not on this machine to make one.
    pub network_loading: Option<NetworkLoading>,
    /// Time of a step of the native engine.
    pub native_step: TimeStatistics,
    /// Time of a tick of the ego's physics among all vehicles.
    pub ego_tick: TimeStatistics,
    /// Time of a tick of the whole world, including traffic, policy and simulated driver.
    pub world_tick: TimeStatistics,
    /// Simulated seconds per second of wall time, at full speed.
    pub times_real_time: f64,
}

/// Measures everything that needs no graphics. On a path through a network the world's tick is that of the drive itself; engines and the
/// ego's physics are measured on the ring, as they need a closed route.
///
/// # Errors
/// The scenario cannot be simulated.
pub fn simulation(scenario: &Scenario) -> Result<SimulationReport, RunError> {
    let native = native_of(scenario)?;
    let is_open = native.map != scenario.map;
    let sumo_step = if_here(sumo(&native))?;
    let network_step = if_here(network_step().map_err(WorldError::from))?;
    let network_loading = if_here(network_loading().map_err(WorldError::from))?;
    let (world_tick, times_real_time) = world(if is_open { scenario } else { &native })?;
    Ok(SimulationReport {
        sumo_step,
        network_step,
        network_loading,
        native_step: native_steps(&native)?,
        ego_tick: ego(&native)?,
        world_tick,
        times_real_time,
    })
}

/// Returns the scenario with the native engine; for a path through a network, which needs SUMO, the default one on a ring.
///
/// # Errors
/// The scenario cannot be planned.
pub(super) fn native_of(scenario: &Scenario) -> Result<Scenario, WorldError> {
    let is_open = PlannedDrive::new(scenario)?.is_open();
    let closed = if is_open { Scenario::default() } else { scenario.clone() };
    Ok(Scenario { traffic: closed.traffic.without_sumo(), ..closed })
}

/// Passes on a measurement of SUMO; `None`, with a warning, if SUMO is not on this machine.
fn if_here<T>(times: Result<T, WorldError>) -> Result<Option<T>, WorldError> {
    match times {
        Ok(times) => Ok(Some(times)),
        Err(WorldError::Traffic(TrafficError::Absent(why))) => {
            log::warn!("no SUMO to measure: {why}");
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

fn setup(scenario: &Scenario) -> Result<FixedSetup, WorldError> {
    let map = Arc::clone(PlannedDrive::new(scenario)?.map());
    let cars = start::even(scenario.vehicles as usize, map.route.length_m(), scenario.idm.s0, 0.0)?;
    Ok(FixedSetup {
        map,
        cars,
        drivers: TrafficDrivers::Alike(scenario.idm),
        mixture: ModelMixture::default(),
        step_s: scenario.step_s,
        seed: scenario.seed,
        lateral_accel_mps2: None,
    })
}

/// Measures bare and full steps in alternating blocks, so that changes of machine speed affect both. The blocks are short, so
/// that most end before another program gets the processor.
fn sumo(scenario: &Scenario) -> Result<SumoTimes, WorldError> {
    const BLOCKS: usize = 2000;
    const STEPS: u32 = 10;
    // Without noise: a bare step lacks the noise's setPreviousSpeed.
    let quiet = Scenario { idm: crate::idm::IdmParams { noise: 0.0, ..scenario.idm }, ..scenario.clone() };
    let mut traffic = SumoTraffic::start(setup(&quiet)?)?;
    for _ in 0..20 * STEPS {
        traffic.step(&[])?;
    }
    let (mut bare, mut full) = (Vec::new(), Vec::new());
    for _ in 0..BLOCKS {
        bare.push(timed(STEPS, || traffic.bare_step())?);
        // A bare step leaves all subscriptions out of date; the next step reads them anew. In a drive all steps are full, so
        // this one is not measured.
        traffic.step(&[])?;
        full.push(timed(STEPS, || traffic.step(&[]))?);
    }
    let mut ratios: Vec<f64> = bare.iter().zip(&full).map(|(b, f)| f.as_secs_f64() / b.as_secs_f64()).collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = ratios[BLOCKS / 2];
    Ok(SumoTimes {
        engine: traffic.name_and_version(),
        bare: TimeStatistics::of(bare),
        full: TimeStatistics::of(full),
        ratio,
    })
}

fn native_steps(scenario: &Scenario) -> Result<TimeStatistics, WorldError> {
    let mut traffic = NativeTraffic::start(setup(scenario)?)?;
    let mut blocks = Vec::new();
    for _ in 0..50 {
        blocks.push(timed(200, || traffic.step(&[]))?);
    }
    Ok(TimeStatistics::of(blocks))
}

/// Returns the mean time of one call in a block of `n`.
fn timed<E>(n: u32, mut call: impl FnMut() -> Result<(), E>) -> Result<Duration, E> {
    let start = now();
    for _ in 0..n {
        call()?;
    }
    Ok(start.elapsed() / n)
}

fn ego(scenario: &Scenario) -> Result<TimeStatistics, RunError> {
    let setup = setup(scenario)?;
    let route = &setup.map.route;
    let length_m = crate::space::CAR_LENGTH_M;
    let obstacles: Vec<Obstacle> = setup.cars[1..]
        .iter()
        .zip(1..)
        .map(|(car, id)| Obstacle {
            id: ObstacleId::Vehicle(id),
            pose: route.pose_of_front(car.s_m, length_m),
            ..Obstacle::default()
        })
        .collect();
    let start = route.pose_of_front(setup.cars[0].s_m, length_m);
    let mut ego = EgoCar::new(&CarParams::default(), start, 0.0, obstacles.len()).map_err(WorldError::from)?;
    let controls = Controls { throttle: 0.05, steering_wheel_rad: 1.0, ..Controls::default() };
    let mut times = Vec::new();
    for _ in 0..3000 {
        let begin = now();
        ego.tick(&controls, &UniformGround(GroundSurface::Asphalt), &obstacles);
        times.push(begin.elapsed());
    }
    Ok(TimeStatistics::of(times))
}

fn world(scenario: &Scenario) -> Result<(TimeStatistics, f64), RunError> {
    let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY])?;
    let mut times = Vec::new();
    let begin = now();
    let ticks_per_step = scenario.step_ticks() as u32;
    for _ in 0..600 {
        let step = now();
        run.step()?;
        times.push(step.elapsed() / ticks_per_step);
    }
    let simulated_s = 600.0 * scenario.step_s;
    Ok((TimeStatistics::of(times), simulated_s / begin.elapsed().as_secs_f64()))
}
