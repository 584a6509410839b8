//! Paired baselines of a participant's trials: the same seed without advice. In: the session's log. Out: a recording
//! beside each completed trial that has none yet. They are made after the session, on a thread of their own, while the
//! participant reads the last page. During the session they would slow down the drives, and SUMO runs once per process.

use super::{RunError, rehearsal};
use crate::{
    record::inputs,
    study::{
        DataSet, ParticipantCode, SessionPlan,
        dataset::BASELINE,
        session::{self, SessionLog},
    },
};
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread::JoinHandle,
};

/// Returns the recordings of trials that lack a baseline.
pub fn missing(folder: &Path, plan: &SessionPlan, log: &SessionLog) -> Vec<PathBuf> {
    let trials = plan.items.iter().filter(|planned| planned.run.is_some());
    let recordings = trials.filter_map(|planned| log.done(&planned.name)?.recording.clone());
    let without = recordings.filter(|name| !folder.join(format!("{name}{BASELINE}")).exists());
    // A lost or damaged recording has no scenario to drive; an analysis names it.
    without.map(|name| folder.join(name)).filter(|trial| inputs::scenario(trial).is_ok()).collect()
}

/// Drives the baseline of each of these trials, with the trial's scenario and its extensions. `driven` is called with
/// the number of ticks after each step. Returns the number of baselines that were made: fewer than trials if `stop` was set
/// before the end.
///
/// # Errors
/// A drive cannot start or go on, or a recording cannot be written.
pub fn make(
    code: &ParticipantCode,
    trials: &[PathBuf],
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<usize, RunError> {
    for (made, trial) in trials.iter().enumerate() {
        let scenario = inputs::scenario(trial)?;
        if !rehearsal::baseline(code, trial, &scenario, stop, driven)? {
            return Ok(made);
        }
    }
    Ok(trials.len())
}

/// Returns the number of ticks of these trials.
///
/// # Errors
/// A scenario cannot be read.
pub fn ticks(trials: &[PathBuf]) -> Result<u64, RunError> {
    let of = |trial: &PathBuf| Ok(rehearsal::ticks(&inputs::scenario(trial)?));
    trials.iter().map(of).sum()
}

/// Makes the baselines that a finished session still lacks, because the window was closed. Returns how many of how many
/// were made: fewer if `stop` was set before the end.
///
/// # Errors
/// A drive cannot start or go on, or a recording cannot be written.
pub fn make_up(
    data: &DataSet,
    study: &crate::study::Study,
    code: &ParticipantCode,
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<[usize; 2], RunError> {
    let folder = data.source(code);
    let log = SessionLog::load(&folder.join(session::FILE))?;
    let trials = missing(&folder, &study.plan(log.index), &log);
    for name in trials.iter().filter_map(|trial| trial.file_name()?.to_str()) {
        data.remakes_baseline(code, name)?;
    }
    let made = make(code, &trials, stop, driven);
    // Lists also the baselines that were made before an error.
    data.publish(study, code)?;
    Ok([made?, trials.len()])
}

/// Baselines that are being driven on a thread.
pub struct BaselineJob {
    thread: Option<JoinHandle<Result<usize, RunError>>>,
    stop: Arc<AtomicBool>,
    driven: Arc<AtomicU64>,
    ticks: u64,
    trials: usize,
}

impl BaselineJob {
    /// Starts driving the baselines of these trials.
    ///
    /// # Errors
    /// A scenario cannot be read, or the system cannot start a thread.
    pub fn begin(code: &ParticipantCode, trials: Vec<PathBuf>) -> Result<Self, RunError> {
        let (stop, driven) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let (ticks, count) = (ticks(&trials)?, trials.len());
        let (code, stopped, count_ticks) = (code.clone(), Arc::clone(&stop), Arc::clone(&driven));
        let work = move || {
            make(&code, &trials, &stopped, &|ticks| {
                count_ticks.fetch_add(ticks, Ordering::Relaxed);
            })
        };
        let thread = std::thread::Builder::new().name("baselines".into()).spawn(work);
        let thread = thread.map_err(|why| crate::record::RecordError::File { path: "baselines".into(), why })?;
        Ok(Self { thread: Some(thread), stop, driven, ticks, trials: count })
    }

    /// Checks whether baselines are still being driven.
    pub fn is_busy(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// Returns the progress as text.
    pub fn progress_text(&self) -> String {
        let driven = self.driven.load(Ordering::Relaxed);
        let percent = (100 * driven).checked_div(self.ticks).unwrap_or(100);
        format!(
            "Baselines of {} trials are being driven: {percent} %. Closing the window is safe: run the same command to resume.",
            self.trials
        )
    }

    /// Waits for the end, or stops at once if `now` is set. Returns the number of baselines that were made.
    ///
    /// # Errors
    /// A drive could not start or go on, or a recording could not be written.
    pub fn finish(&mut self, now: bool) -> Result<usize, RunError> {
        self.stop.fetch_or(now, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(made)) => made,
            // The panic was reported already.
            Some(Err(_)) | None => Ok(0),
        }
    }
}

impl Drop for BaselineJob {
    fn drop(&mut self) {
        let _ = self.finish(true);
    }
}
