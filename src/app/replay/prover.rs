//! The replay's own thread: it drives a recording again as fast as it can, proves every tick, and hands out what was to be
//! seen. In: a recording. Out: [`Opened`] once, then a stream of [`Found`]. Whoever looks at it never waits for it.

use super::{Replay, Verdict};
use crate::{
    app::{AppError, Instruments},
    map::RoadMap,
    sim::{Scenario, Snapshot},
    time::Tick,
};
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, Sender},
    },
    thread::JoinHandle,
};

/// What is known before the first tick.
pub struct Opened {
    /// What was driven.
    pub scenario: Scenario,
    /// Its road.
    pub map: Arc<RoadMap>,
    /// Its speedometer.
    pub instruments: Instruments,
    /// The world at the start.
    pub first: Snapshot,
    /// Length of the recording.
    pub end: Tick,
}

/// What comes while it drives.
pub enum Found {
    /// A step further: the world there, and what was found up to it.
    Step(Box<Snapshot>, Verdict),
    /// The engine failed.
    Failed(AppError),
}

/// The thread, and what it has to tell. Dropped, it ends.
pub struct Prover {
    /// What it found, in order; ends with the recording.
    pub found: Receiver<Found>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Prover {
    /// Opens a recording on a thread of its own.
    ///
    /// # Errors
    /// As [`Replay::open`].
    pub fn start(recording: &Path) -> Result<(Self, Opened), AppError> {
        let (opened, first) = mpsc::channel();
        let (told, found) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let (theirs, folder): (_, PathBuf) = (Arc::clone(&stop), recording.into());
        let thread = std::thread::spawn(move || match Replay::open(&folder) {
            Err(error) => drop(opened.send(Err(error))),
            Ok(replay) => {
                let world = replay.world();
                let facts = Opened {
                    scenario: world.scenario().clone(),
                    map: Arc::clone(world.map()),
                    instruments: Instruments::new(world),
                    first: world.snapshot().clone(),
                    end: Tick(replay.len()),
                };
                if opened.send(Ok(facts)).is_ok() {
                    drive(replay, &told, &theirs);
                }
            }
        });
        let opened = first.recv().unwrap_or_else(|_| Err(AppError::Ended("the replay's thread".into())))?;
        Ok((Self { found, stop, thread: Some(thread) }, opened))
    }
}

impl Drop for Prover {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn drive(mut replay: Replay, told: &Sender<Found>, stop: &AtomicBool) {
    let step = replay.world().scenario().step_ticks();
    while !replay.over() && !stop.load(Ordering::Relaxed) {
        let found = match replay.advance(step) {
            Ok(()) => Found::Step(Box::new(replay.world().snapshot().clone()), replay.verdict().clone()),
            Err(error) => Found::Failed(error),
        };
        let failed = matches!(found, Found::Failed(_));
        if told.send(found).is_err() || failed {
            return;
        }
    }
}
