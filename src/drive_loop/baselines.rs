//! The paired baselines of a participant's trials: the same seed without advice. In: the session's log. Out: a recording
//! beside each trial that came to its end and has none yet. They are made after the session, on a thread of their own, while
//! the participant reads the last page: during it they would take the processor from a drive, and SUMO runs once a process.

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

/// Recordings of trials that want a baseline.
pub fn missing(folder: &Path, plan: &SessionPlan, log: &SessionLog) -> Vec<PathBuf> {
    let trials = plan.items.iter().filter(|planned| planned.run.is_some());
    let recordings = trials.filter_map(|planned| log.done(&planned.name)?.recording.clone());
    let without = recordings.filter(|name| !folder.join(format!("{name}{BASELINE}")).exists());
    without.map(|name| folder.join(name)).collect()
}

/// Drives the baseline of each of these trials, as it was driven, with what it was extended by. `driven` hears of every
/// tick. False if `stop` was set before the last.
///
/// # Errors
/// A drive cannot start or go on, or the disk refuses.
pub fn make(
    code: &ParticipantCode,
    trials: &[PathBuf],
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<bool, RunError> {
    for trial in trials {
        let scenario = inputs::scenario(trial)?;
        if !rehearsal::baseline(code, trial, &scenario, stop, driven)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// How many ticks these trials have.
///
/// # Errors
/// A scenario cannot be read.
pub fn ticks(trials: &[PathBuf]) -> Result<u64, RunError> {
    let of = |trial: &PathBuf| Ok(rehearsal::ticks(&inputs::scenario(trial)?));
    trials.iter().map(of).sum()
}

/// Makes what a session that is over still lacks: baselines that a closed window left out.
///
/// # Errors
/// A drive cannot start or go on, or the disk refuses.
pub fn make_up(
    data: &DataSet,
    study: &crate::study::Study,
    code: &ParticipantCode,
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<usize, RunError> {
    let folder = data.source(code);
    let log = SessionLog::load(&folder.join(session::FILE))?;
    let trials = missing(&folder, &study.plan(log.index), &log);
    if !trials.is_empty() {
        for name in trials.iter().filter_map(|trial| trial.file_name()?.to_str()) {
            data.remakes_baseline(code, name)?;
        }
        make(code, &trials, stop, driven)?;
    }
    data.publish(study, code)?;
    Ok(trials.len())
}

/// Baselines on their way.
pub struct BaselineJob {
    thread: Option<JoinHandle<Result<bool, RunError>>>,
    stop: Arc<AtomicBool>,
    driven: Arc<AtomicU64>,
    ticks: u64,
    trials: usize,
}

impl BaselineJob {
    /// Begins with these.
    ///
    /// # Errors
    /// A scenario cannot be read, or the system gives no thread.
    pub fn begin(code: &ParticipantCode, trials: Vec<PathBuf>) -> Result<Self, RunError> {
        let (stop, driven) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let (ticks, count) = (ticks(&trials)?, trials.len());
        let (code, told, count_ticks) = (code.clone(), Arc::clone(&stop), Arc::clone(&driven));
        let work = move || {
            make(&code, &trials, &told, &|ticks| {
                count_ticks.fetch_add(ticks, Ordering::Relaxed);
            })
        };
        let thread = std::thread::Builder::new().name("baselines".into()).spawn(work);
        let thread = thread.map_err(|why| crate::record::RecordError::File { path: "baselines".into(), why })?;
        Ok(Self { thread: Some(thread), stop, driven, ticks, trials: count })
    }

    /// True while it works.
    pub fn is_busy(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// In words.
    pub fn words(&self) -> String {
        let driven = self.driven.load(Ordering::Relaxed);
        let percent = (100 * driven).checked_div(self.ticks).unwrap_or(100);
        format!(
            "Baselines of {} trials are being driven: {percent} %. Closing the window is safe: run the same command to resume.",
            self.trials
        )
    }

    /// Waits for the end, or ends it now. True if all were made.
    ///
    /// # Errors
    /// A drive could not start or go on, or the disk refused.
    pub fn finish(&mut self, now: bool) -> Result<bool, RunError> {
        self.stop.fetch_or(now, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(made)) => made,
            // A panic was printed already.
            Some(Err(_)) | None => Ok(false),
        }
    }
}

impl Drop for BaselineJob {
    fn drop(&mut self) {
        let _ = self.finish(true);
    }
}
