//! Measurements of this program on this machine. In: a scenario. Out: a [`Report`] of medians and percentiles. Nothing
//! here is ever asserted in a test: timings belong to whoever asks for them.

use super::{AppError, Instruments, offline::Run, quality, view_options};
use crate::{
    ego::{CarParams, Controls, Ego, Everywhere, Obstacle, Surface},
    map::RoadMap,
    render::{Gpu, OFFSCREEN, Renderer, render_to_image},
    scene::{self, Stage, ViewKind},
    sim::{QualityLevel, Scenario, WorldError},
    traffic::{NativeTraffic, Traffic, TrafficError, TrafficSetup, start, sumo::SumoTraffic},
};
use serde::Serialize;
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// Times of one thing, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Smallest.
    pub min_us: f64,
    /// Median.
    pub median_us: f64,
    /// 99th percentile.
    pub p99_us: f64,
    /// Largest.
    pub max_us: f64,
    /// How many were taken.
    pub samples: usize,
}

impl Times {
    /// Of a non-empty list of durations.
    pub fn of(mut samples: Vec<Duration>) -> Self {
        samples.sort();
        let at = |share: f64| samples[((samples.len() - 1) as f64 * share).round() as usize].as_secs_f64() * 1e6;
        Self { min_us: at(0.0), median_us: at(0.5), p99_us: at(0.99), max_us: at(1.0), samples: samples.len() }
    }
}

/// SUMO's step alone, and with the ego told and all states read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SumoTimes {
    /// The engine.
    pub engine: String,
    /// `simulationStep` alone.
    pub bare: Times,
    /// The step as a drive makes it: pose and speed of the ego in, states of all cars out.
    pub full: Times,
    /// Median of full over bare, of blocks taken in turn.
    pub ratio: f64,
}

/// What was measured without graphics.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// SUMO; `None` where it is not here.
    pub sumo_step: Option<SumoTimes>,
    /// A step of the native engine.
    pub native_step: Times,
    /// A tick of the ego's physics among all cars.
    pub ego_tick: Times,
    /// A tick of the whole world, traffic, policy and simulated driver included.
    pub world_tick: Times,
    /// Seconds of simulation in a second of wall time, at full speed.
    pub times_real_time: f64,
}

/// Measures everything that needs no graphics.
///
/// # Errors
/// The scenario cannot be simulated.
pub fn simulation(scenario: &Scenario) -> Result<Report, AppError> {
    let native = Scenario { traffic: "native".into(), ..scenario.clone() };
    let sumo_step = match sumo(scenario) {
        Ok(times) => Some(times),
        Err(WorldError::Traffic(TrafficError::Absent(why))) => {
            log::warn!("no SUMO to measure: {why}");
            None
        }
        Err(error) => return Err(error.into()),
    };
    let (world_tick, times_real_time) = world(&native)?;
    Ok(Report { sumo_step, native_step: native_steps(&native)?, ego_tick: ego(&native)?, world_tick, times_real_time })
}

fn setup(scenario: &Scenario) -> Result<TrafficSetup, WorldError> {
    let map = Arc::new(RoadMap::load(&scenario.map)?);
    let cars = start::even(scenario.vehicles as usize, map.route.length_m(), scenario.idm.s0, 0.0)?;
    Ok(TrafficSetup { map, cars, idm: scenario.idm, step_s: scenario.step_s, seed: scenario.seed })
}

/// Blocks of bare and full steps in turn, so that a change of the machine's speed meets both.
fn sumo(scenario: &Scenario) -> Result<SumoTimes, WorldError> {
    const BLOCKS: usize = 20;
    const STEPS: u32 = 200;
    // Without noise, whose setPreviousSpeed a bare step lacks by its nature.
    let quiet = Scenario { idm: crate::idm::IdmParams { noise: 0.0, ..scenario.idm }, ..scenario.clone() };
    let mut traffic = SumoTraffic::start(setup(&quiet)?)?;
    for _ in 0..STEPS {
        traffic.step(None)?;
    }
    let (mut bare, mut full) = (Vec::new(), Vec::new());
    for _ in 0..BLOCKS {
        bare.push(timed(STEPS, || traffic.bare_step())?);
        full.push(timed(STEPS, || traffic.step(None))?);
    }
    let mut ratios: Vec<f64> = bare.iter().zip(&full).map(|(b, f)| f.as_secs_f64() / b.as_secs_f64()).collect();
    ratios.sort_by(f64::total_cmp);
    let ratio = ratios[BLOCKS / 2];
    Ok(SumoTimes { engine: traffic.describe(), bare: Times::of(bare), full: Times::of(full), ratio })
}

fn native_steps(scenario: &Scenario) -> Result<Times, WorldError> {
    let mut traffic = NativeTraffic::start(setup(scenario)?)?;
    let mut blocks = Vec::new();
    for _ in 0..50 {
        blocks.push(timed(200, || traffic.step(None))?);
    }
    Ok(Times::of(blocks))
}

/// Mean time of one call in a block of `n`.
fn timed<E>(n: u32, mut call: impl FnMut() -> Result<(), E>) -> Result<Duration, E> {
    let start = now();
    for _ in 0..n {
        call()?;
    }
    Ok(start.elapsed() / n)
}

fn ego(scenario: &Scenario) -> Result<Times, AppError> {
    let setup = setup(scenario)?;
    let route = &setup.map.route;
    let length_m = crate::space::CAR_LENGTH_M;
    let obstacles: Vec<Obstacle> = setup.cars[1..]
        .iter()
        .map(|car| Obstacle { pose: route.pose_of_front(car.s_m, length_m), speed_mps: 0.0 })
        .collect();
    let start = route.pose_of_front(setup.cars[0].s_m, length_m);
    let mut ego = Ego::new(&CarParams::default(), start, 0.0, obstacles.len()).map_err(WorldError::from)?;
    let controls = Controls { throttle: 0.05, steering_wheel_rad: 1.0, ..Controls::default() };
    let mut times = Vec::new();
    for _ in 0..3000 {
        let begin = now();
        ego.tick(&controls, &Everywhere(Surface::Asphalt), &obstacles);
        times.push(begin.elapsed());
    }
    Ok(Times::of(times))
}

fn world(scenario: &Scenario) -> Result<(Times, f64), AppError> {
    let mut run = Run::new(scenario, [0.0, f64::INFINITY])?;
    let mut times = Vec::new();
    let begin = now();
    let ticks_per_step = scenario.step_ticks() as u32;
    for _ in 0..600 {
        let step = now();
        run.step()?;
        times.push(step.elapsed() / ticks_per_step);
    }
    let simulated_s = 600.0 * scenario.step_s;
    Ok((Times::of(times), simulated_s / begin.elapsed().as_secs_f64()))
}

/// Sizes of the pictures that are measured, smallest first.
pub const SIZES: [[u32; 2]; 4] = [[640, 360], [1280, 720], [1920, 1080], [3840, 2160]];

/// From nothing to the first picture, milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Startup {
    /// Map, traffic, ego.
    pub world_ms: f64,
    /// Graphics device.
    pub device_ms: f64,
    /// Road, land, trees, models.
    pub stage_ms: f64,
    /// Pipelines, textures, upload.
    pub renderer_ms: f64,
    /// The first picture, read back.
    pub frame_ms: f64,
    /// All of it.
    pub total_ms: f64,
}

/// Times of one view at one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameTimes {
    /// Name of the view.
    pub view: &'static str,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Level of quality.
    pub quality: QualityLevel,
    /// Draw and wait until the device is done.
    pub times: Times,
    /// Last frame's shadow, main, mirror and develop pass on the device, milliseconds, where it has timestamps.
    pub passes: Option<[f32; 4]>,
}

/// A drive ready to be drawn.
pub struct Picture {
    gpu: Gpu,
    run: Run,
    stage: Stage,
    renderer: Renderer,
    instruments: Instruments,
}

/// Starts as `codrive drive` does, up to the first picture.
///
/// # Errors
/// The world cannot start or there is no graphics adapter.
pub fn startup(scenario: &Scenario) -> Result<(Startup, Picture), AppError> {
    let mut laps = vec![now()];
    let run = Run::new(scenario, [0.0, f64::INFINITY])?;
    laps.push(now());
    let gpu = Gpu::headless()?;
    laps.push(now());
    let stage = Stage::build(run.world().map(), scenario.seed);
    laps.push(now());
    let renderer = Renderer::new(&gpu, &stage, OFFSCREEN, quality(scenario.quality, &gpu));
    laps.push(now());
    let instruments = Instruments::new(run.world());
    let mut picture = Picture { gpu, run, stage, renderer, instruments };
    picture.draw(ViewKind::Driver, [1280, 720])?;
    laps.push(now());
    let ms = |from: usize, to: usize| (laps[to] - laps[from]).as_secs_f64() * 1e3;
    let startup = Startup {
        world_ms: ms(0, 1),
        device_ms: ms(1, 2),
        stage_ms: ms(2, 3),
        renderer_ms: ms(3, 4),
        frame_ms: ms(4, 5),
        total_ms: ms(0, 5),
    };
    Ok((startup, picture))
}

impl Picture {
    /// Draws every view at every size `n` times, a step of the drive before each; one more before, not counted, for
    /// everything that is made at a first use.
    ///
    /// # Errors
    /// The drive cannot go on or the device is lost.
    pub fn frames(&mut self, sizes: &[[u32; 2]], n: u32) -> Result<Vec<FrameTimes>, AppError> {
        let views = [
            ("driver", ViewKind::Driver),
            ("mirror", ViewKind::Mirror),
            ("birdseye", ViewKind::Birdseye),
            ("chase", ViewKind::Chase),
        ];
        let mut rows = Vec::new();
        for &size in sizes {
            for (view, kind) in views {
                self.draw(kind, size)?;
                let mut times = Vec::new();
                for _ in 0..n {
                    self.run.step()?;
                    times.push(self.draw(kind, size)?);
                }
                let passes = self.renderer.pass_times().map(|p| [p.shadow_ms, p.main_ms, p.mirror_ms, p.develop_ms]);
                let quality = self.run.world().scenario().quality;
                rows.push(FrameTimes { view, size, quality, times: Times::of(times), passes });
            }
        }
        Ok(rows)
    }

    /// The adapter, in words.
    pub fn adapter(&self) -> String {
        self.gpu.description()
    }

    /// Draws one picture and waits until it has been read back.
    fn draw(&mut self, kind: ViewKind, size: [u32; 2]) -> Result<Duration, AppError> {
        let world = self.run.world();
        let begin = now();
        let mut view = scene::view(world.snapshot(), 1.0, kind, &view_options(world.scenario()), &self.stage);
        view.dial = kind.has_dial().then(|| self.instruments.read(world.snapshot()));
        render_to_image(&self.gpu, &mut self.renderer, &view, size)?;
        Ok(begin.elapsed())
    }
}

/// Largest memory that this process has had, megabytes; `None` where the system does not tell.
pub fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

#[allow(clippy::disallowed_methods, reason = "a measurement of time is what this is")]
pub(super) fn now() -> Instant {
    Instant::now()
}
