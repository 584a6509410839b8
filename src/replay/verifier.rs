//! The replay's thread: it drives a recording again as fast as it can, verifies every tick, and keeps what is to be seen.
//! In: a recording. Out: [`ReplayHeader`] once, then what is [`VerificationProgress`] so far, at any time. Nothing waits in
//! between: where nobody looks, as while a window is hidden, the proof goes on, and the film takes no more memory than it
//! may.

use super::{Replay, ReplayReport, snapshot_timeline::SnapshotTimeline};
use crate::{drive_loop::RunError, hud::Speedometer, map::RoadMap, scenario::Scenario, time::Tick};
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
pub struct ReplayHeader {
    /// What was driven.
    pub scenario: Scenario,
    /// Its road.
    pub map: Arc<RoadMap>,
    /// Its speedometer.
    pub instruments: Speedometer,
    /// Length of the recording.
    pub end: Tick,
}

/// What has been driven again so far.
pub struct VerificationProgress {
    /// What there is to be seen.
    pub film: SnapshotTimeline,
    /// What the proof has found.
    pub verdict: ReplayReport,
    /// Why it ended before the recording does.
    pub failure: Option<RunError>,
}

/// The thread, and what it knows. Dropped, it ends.
pub struct Verifier {
    known: Arc<Mutex<VerificationProgress>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Verifier {
    /// Opens a recording on a thread of its own.
    ///
    /// # Errors
    /// As [`Replay::open`].
    pub fn start(recording: &Path) -> Result<(Self, ReplayHeader), RunError> {
        let (opened, first) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let (theirs, folder): (_, PathBuf) = (Arc::clone(&stop), recording.into());
        let thread = std::thread::spawn(move || match Replay::open(&folder) {
            Err(error) => drop(opened.send(Err(error))),
            Ok(replay) => {
                let world = replay.world();
                let facts = ReplayHeader {
                    scenario: world.scenario().clone(),
                    map: Arc::clone(world.map()),
                    instruments: Speedometer::new(world),
                    end: Tick(replay.len()),
                };
                let film = SnapshotTimeline::new(world.snapshot().clone(), world.scenario().step_s);
                let known = VerificationProgress { film, verdict: replay.verdict().clone(), failure: None };
                let known = Arc::new(Mutex::new(known));
                if opened.send(Ok((facts, Arc::clone(&known)))).is_ok() {
                    drive(replay, &known, &theirs);
                }
            }
        });
        let opened = first.recv().unwrap_or_else(|_| Err(RunError::Ended("the replay's thread".into())));
        let (opened, known) = opened?;
        Ok((Self { known, stop, thread: Some(thread) }, opened))
    }

    /// What is known now. The thread waits while this is held: look, and let it go.
    pub fn known(&self) -> MutexGuard<'_, VerificationProgress> {
        lock(&self.known)
    }

    /// True when nothing more will be known.
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl Drop for Verifier {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(known: &Mutex<VerificationProgress>) -> MutexGuard<'_, VerificationProgress> {
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

fn drive(mut replay: Replay, known: &Mutex<VerificationProgress>, stop: &AtomicBool) {
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
