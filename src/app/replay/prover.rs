//! The replay's own thread: it drives a recording again as fast as it can, proves every tick, and keeps what is to be seen. In:
//! a recording. Out: [`Opened`] once, then what is [`Known`] so far, at any time. Nothing waits in between: where nobody looks,
//! as while a window is hidden, the proof goes on, and the film takes no more memory than it may.

use super::{Replay, Verdict, film::Film};
use crate::{
    app::{AppError, Instruments},
    map::RoadMap,
    sim::Scenario,
    time::Tick,
};
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc,
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
    /// Length of the recording.
    pub end: Tick,
}

/// What has been driven again so far.
pub struct Known {
    /// What there is to be seen.
    pub film: Film,
    /// What the proof has found.
    pub verdict: Verdict,
    /// Why it ended before the recording does.
    pub failure: Option<AppError>,
}

/// The thread, and what it knows. Dropped, it ends.
pub struct Prover {
    known: Arc<Mutex<Known>>,
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
                    end: Tick(replay.len()),
                };
                let film = Film::new(world.snapshot().clone(), world.scenario().step_s);
                let known = Known { film, verdict: replay.verdict().clone(), failure: None };
                let known = Arc::new(Mutex::new(known));
                if opened.send(Ok((facts, Arc::clone(&known)))).is_ok() {
                    drive(replay, &known, &theirs);
                }
            }
        });
        let opened = first.recv().unwrap_or_else(|_| Err(AppError::Ended("the replay's thread".into())));
        let (opened, known) = opened?;
        Ok((Self { known, stop, thread: Some(thread) }, opened))
    }

    /// What is known now. The thread waits while this is held: look, and let it go.
    pub fn known(&self) -> MutexGuard<'_, Known> {
        lock(&self.known)
    }

    /// True when nothing more will be known.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
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

fn lock(known: &Mutex<Known>) -> MutexGuard<'_, Known> {
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

fn drive(mut replay: Replay, known: &Mutex<Known>, stop: &AtomicBool) {
    let step = replay.world().scenario().step_ticks();
    while !replay.over() && !stop.load(Ordering::Relaxed) {
        // Driven first: whoever looks meanwhile does not wait for it.
        let driven = replay.advance(step);
        let snapshot = replay.world().snapshot().clone();
        let mut known = lock(known);
        known.verdict.clone_from(replay.verdict());
        match driven {
            Ok(()) => known.film.push(snapshot),
            Err(error) => {
                known.failure = Some(error);
                return;
            }
        }
    }
}
