//! Thread of a replay: drives a recording again at full speed, verifies every tick and keeps the snapshots. In: a recording.
//! Out: [`ReplayHeader`] once, then the [`VerificationProgress`] at any time. The thread never waits for a reader: the proof
//! goes on while a window is hidden. The timeline's memory is bounded.

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

/// Facts of a recording known before the first tick.
pub struct ReplayHeader {
    /// Recorded scenario, as driven here.
    pub scenario: Scenario,
    /// Map of the drive.
    pub map: Arc<RoadMap>,
    /// Speedometer of the drive.
    pub instruments: Speedometer,
    /// Last tick of the recording.
    pub end: Tick,
}

/// Progress of the replay so far.
pub struct VerificationProgress {
    /// Snapshots of the drive for display.
    pub timeline: SnapshotTimeline,
    /// Result of the proof so far.
    pub report: ReplayReport,
    /// Failure that ended the replay before the end of the recording.
    pub failure: Option<RunError>,
}

/// Thread of a replay and its progress. Dropping it ends the thread.
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
                let timeline = SnapshotTimeline::new(world.snapshot().clone(), world.scenario().step_s);
                let known = VerificationProgress { timeline, report: replay.report().clone(), failure: None };
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

    /// Locks the progress. The thread waits while the guard is held, so release it soon.
    pub fn known(&self) -> MutexGuard<'_, VerificationProgress> {
        lock(&self.known)
    }

    /// Checks whether the thread has ended.
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
        // The tick is driven before the lock is taken, so that readers do not wait for it.
        let driven = replay.advance(step);
        let snapshot = replay.world().snapshot().clone();
        let mut known = lock(known);
        known.report.clone_from(replay.report());
        match driven {
            Ok(()) => known.timeline.push(snapshot),
            Err(error) => {
                known.failure = Some(error);
                return;
            }
        }
    }
}
