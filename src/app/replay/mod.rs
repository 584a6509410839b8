//! A recorded drive once more. In: a recording. Out: the same world tick by tick, with the proof that it is the same: the
//! fingerprint of every snapshot; in a [`window`], too, or with something changed ([`what_if`]).

pub mod film;
mod prover;
mod what_if;
pub mod window;

pub use prover::{Found, Opened, Prover};
pub use what_if::{Pair, changes, what_if, words};

use super::{AppError, Drive, Instruments, quality, view_options};
use crate::{
    ego::{Controls, Selector},
    record::{self, Manifest, Reader, Table, tables},
    render::{Gpu, OFFSCREEN, Renderer, render_to_image},
    scene::{self, Stage, ViewKind},
    sim::{HASH_START, QualityLevel, Scenario, World},
    time::Pace,
};
use std::{path::Path, time::Duration};

/// What a replay found.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Ticks that were driven again.
    pub ticks: u64,
    /// The first tick whose world differs from the recorded one; `None` if all bits are equal.
    pub first_difference: Option<u64>,
    /// How far speed and place of the ego differ there, m/s and metres.
    pub by: Option<[f64; 2]>,
}

/// A recording being driven again.
pub struct Replay {
    drive: Drive,
    inputs: Vec<Controls>,
    hashes: Vec<u64>,
    speeds: Vec<Option<f64>>,
    places: Vec<Option<f64>>,
    hash: u64,
    verdict: Verdict,
}

impl Replay {
    /// Puts the recorded world at its start.
    ///
    /// # Errors
    /// The folder holds no recording that has ended, or its scenario cannot be driven here.
    pub fn open(recording: &Path) -> Result<Self, AppError> {
        Manifest::load(recording)?;
        let scenario = Scenario::from_file(&recording.join("scenario.toml"))?;
        let path = Table::Ego.parquet(recording);
        if !path.exists() {
            return Err(AppError::CutRecording(recording.into()));
        }
        let table = Reader::parquet(&path)?;
        let inputs = inputs(&table).ok_or_else(|| record::RecordError::Table {
            path,
            why: "columns throttle, brake, steering_wheel_rad or selector are not as this program writes them".into(),
        })?;
        Ok(Self {
            drive: Drive::new(&scenario, Pace::Paused)?,
            inputs,
            hashes: table.wholes("hash"),
            speeds: table.numbers("speed_mps"),
            places: table.numbers("s_m"),
            hash: HASH_START,
            verdict: Verdict { ticks: 0, first_difference: None, by: None },
        })
    }

    /// How many ticks were recorded.
    pub fn len(&self) -> u64 {
        self.inputs.len() as u64
    }

    /// True if nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty()
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.drive.world
    }

    /// True when all recorded ticks have been driven.
    pub fn over(&self) -> bool {
        self.verdict.ticks >= self.len()
    }

    /// Drives `ticks` on, or to the end of the recording.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn advance(&mut self, ticks: u64) -> Result<(), AppError> {
        for _ in 0..ticks.min(self.len() - self.verdict.ticks) {
            let at = self.verdict.ticks as usize;
            let controls = self.inputs[at];
            self.drive.clock.single_step(1);
            self.drive.frame(Duration::ZERO, |_| controls, |_, _| ())?;
            let snapshot = self.drive.world.snapshot();
            self.hash = snapshot.hash(self.hash);
            self.verdict.ticks += 1;
            if self.verdict.first_difference.is_none() && self.hashes.get(at) != Some(&self.hash) {
                let difference = |recorded: Option<f64>, now: f64| recorded.map_or(f64::NAN, |was| now - was);
                self.verdict.first_difference = Some(snapshot.tick.0);
                self.verdict.by = Some([
                    difference(self.speeds[at], snapshot.ego.speed_mps),
                    difference(self.places[at], snapshot.ego_s_m),
                ]);
            }
        }
        Ok(())
    }

    /// The controls of the last tick; at rest before the first.
    pub fn controls(&self) -> Controls {
        let last = (self.verdict.ticks as usize).checked_sub(1);
        last.and_then(|at| self.inputs.get(at)).copied().unwrap_or_default()
    }

    /// What was found so far.
    pub fn verdict(&self) -> &Verdict {
        &self.verdict
    }
}

/// Draws a replay.
pub struct Easel {
    gpu: Gpu,
    stage: Stage,
    renderer: Renderer,
    instruments: Instruments,
    kind: ViewKind,
    size: [u32; 2],
}

impl Easel {
    /// For one view at one size, in the quality that the scenario names (medium for auto: nobody waits).
    ///
    /// # Errors
    /// No graphics adapter.
    pub fn new(replay: &Replay, kind: ViewKind, size: [u32; 2]) -> Result<Self, AppError> {
        let world = replay.world();
        let gpu = Gpu::headless()?;
        let stage = Stage::build(world.map(), world.scenario().seed);
        let level = match world.scenario().quality {
            QualityLevel::Auto => QualityLevel::Medium,
            level => level,
        };
        let renderer = Renderer::new(&gpu, &stage, OFFSCREEN, quality(level, &gpu));
        let instruments = Instruments::new(world);
        Ok(Self { gpu, stage, renderer, instruments, kind, size })
    }

    /// The picture of the present tick.
    ///
    /// # Errors
    /// The device is lost.
    pub fn draw(&mut self, replay: &Replay) -> Result<image::RgbaImage, AppError> {
        let world = replay.world();
        let options = view_options(world.scenario());
        let mut view = scene::view(world.snapshot(), 1.0, self.kind, &options, &self.stage);
        view.dial = self.kind.has_dial().then(|| self.instruments.read(world.snapshot()));
        Ok(render_to_image(&self.gpu, &mut self.renderer, &view, self.size)?)
    }
}

/// The controls of every tick.
fn inputs(table: &Reader) -> Option<Vec<Controls>> {
    let [throttle, brake, wheel] = ["throttle", "brake", "steering_wheel_rad"].map(|name| table.numbers(name));
    let words = table.words("selector");
    let selectors = [Selector::Drive, Selector::Neutral, Selector::Reverse];
    (words.len() == table.rows()).then_some(())?;
    (0..table.rows())
        .map(|i| {
            let selector = selectors.into_iter().find(|s| tables::selector_word(*s) == words[i])?;
            Some(Controls {
                throttle: throttle[i]? as f32,
                brake: brake[i]? as f32,
                steering_wheel_rad: wheel[i]? as f32,
                selector,
            })
        })
        .collect()
}
