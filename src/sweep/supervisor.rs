//! Supervision of a sweep on this machine. In: a plan, its folder and the numbers of the runs due. Out: their parts, made by worker
//! processes, and the runs that failed. SUMO runs once per process, and a crash ends one run only.
//!
//! The protocol: a worker writes an empty answer when it has read the plan. It then reads numbers of runs, and writes for each an empty
//! answer or the reason of the failure, and before it reports about the run's checkpoint. Each message is one line: an answer is a JSON
//! string, a report is {"report": "text"}. The Python package's workers on a Ray cluster speak the same protocol and take the texts of
//! failures from here.

use super::{
    SweepError, SweepPlan,
    results::{CheckpointFile, SweepFolder},
};
use serde::{Deserialize, Serialize};
use std::{
    io::{BufRead, BufReader, Write},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    sync::{
        Mutex,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    time::{Duration, Instant},
};

/// Interval between checks of the stop flag while waiting for a run.
const LOOK: Duration = Duration::from_millis(100);
/// Maximum number of failures in a report; the others are counted.
const LISTED_FAILURES: usize = 10;
/// Message of a sweep that was stopped.
pub const STOPPED: &str = "stopped; run the same command again to make the missing runs";

/// Reason of a failure that a worker cannot report itself.
#[derive(Debug, thiserror::Error)]
pub enum WorkerFault {
    /// Time limit exceeded, s.
    #[error("the run was not done after limit_s, {0} s")]
    TimedOut(f64),
    /// End of the process, with its exit status.
    #[error("the process of the run ended ({0})")]
    Ended(String),
}

/// A run that failed in every attempt.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FailedRun {
    /// Number of the run in the plan.
    pub number: usize,
    /// Reason of the last failure.
    pub why: String,
}

/// Progress of a sweep.
#[derive(Clone, Debug)]
pub enum SweepProgress {
    /// One more run is done.
    Done,
    /// All runs were tried; this number failed and is tried again.
    Retry(usize),
    /// Report of a run about its checkpoint.
    Report(String),
}

/// Message of a worker.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum WorkerMessage {
    /// Answer to a run: empty if it is done, else the reason why it failed.
    Answer(String),
    /// Report about the run in progress.
    Report { report: String },
}

/// Pool of worker processes.
pub struct WorkerPool<'a> {
    /// Plan of the runs.
    pub plan: &'a SweepPlan,
    /// Command that starts a worker process, which calls [`serve`].
    pub command: &'a (dyn Fn() -> std::io::Result<Command> + Sync),
    /// Maximum number of processes at a time.
    pub workers: usize,
    /// Number of further attempts for a failed run, after all others.
    pub retries: u8,
    /// Callback with the progress of the runs.
    pub progress: &'a (dyn Fn(SweepProgress) + Sync),
}

impl WorkerPool<'_> {
    /// Carries out the runs with these numbers. Returns those that failed in every attempt.
    ///
    /// # Errors
    /// The sweep was stopped, or a worker cannot be started.
    pub fn run(&self, mut pending: Vec<usize>, stop: &AtomicBool) -> Result<Vec<FailedRun>, SweepError> {
        for _ in 0..self.retries {
            let failed = self.attempt(&pending, stop)?;
            if failed.is_empty() {
                return Ok(failed);
            }
            pending = failed.iter().map(|run| run.number).collect();
            (self.progress)(SweepProgress::Retry(pending.len()));
        }
        self.attempt(&pending, stop)
    }

    /// Carries out each run of a list once. Returns those that failed.
    fn attempt(&self, pending: &[usize], stop: &AtomicBool) -> Result<Vec<FailedRun>, SweepError> {
        let queue = Mutex::new(pending.iter().copied());
        let failed = Mutex::new(Vec::new());
        let next = || queue.lock().ok()?.next();
        std::thread::scope(|scope| {
            let work = || -> Result<(), SweepError> {
                let mut worker = None;
                while let Some(number) = next() {
                    match self.one(&mut worker, number, stop)? {
                        Ok(()) => (self.progress)(SweepProgress::Done),
                        Err(why) => {
                            failed.lock().map(|mut failed| failed.push(FailedRun { number, why })).unwrap_or_default();
                        }
                    }
                }
                Ok(())
            };
            let workers: Vec<_> = (0..self.workers.min(pending.len())).map(|_| scope.spawn(work)).collect();
            let done: Vec<_> = workers.into_iter().map(std::thread::ScopedJoinHandle::join).collect();
            done.into_iter()
                .try_for_each(|done| done.unwrap_or_else(|_| Err(SweepError::Run("a thread failed".into()))))
        })?;
        let mut failed = failed.into_inner().unwrap_or_default();
        failed.sort();
        Ok(failed)
    }

    /// Carries out one run by a worker, which is started if there is none. Returns the reason if it failed.
    fn one(
        &self,
        worker: &mut Option<Worker>,
        number: usize,
        stop: &AtomicBool,
    ) -> Result<Result<(), String>, SweepError> {
        let at_work = match worker {
            Some(at_work) => at_work,
            None => worker.insert(Worker::start(self)?),
        };
        let limit_s = self.plan.runs[number].limit_s;
        let report = |text| (self.progress)(SweepProgress::Report(text));
        let fault = match at_work.run(number, limit_s.map(Duration::from_secs_f64), stop, &report)? {
            WorkerAnswer::Text(answer) if answer.is_empty() => return Ok(Ok(())),
            WorkerAnswer::Text(why) => return Ok(Err(why)),
            WorkerAnswer::Ended => WorkerFault::Ended(worker.take().map(Worker::end).unwrap_or_default()),
            WorkerAnswer::TooLong => {
                // Dropping the worker ends it.
                *worker = None;
                WorkerFault::TimedOut(limit_s.unwrap_or_default())
            }
        };
        Ok(Err(fault.to_string()))
    }
}

/// Handle of a worker process, which carries out one run after the other.
struct Worker {
    child: Child,
    stdin: ChildStdin,
    messages: mpsc::Receiver<WorkerMessage>,
    is_ready: bool,
}

/// Outcome of a run.
enum WorkerAnswer {
    /// Answer of the worker: empty if the run is done, else the reason why it failed.
    Text(String),
    /// End of the worker's process.
    Ended,
    /// Time limit exceeded; the worker is still running.
    TooLong,
}

impl Worker {
    fn start(pool: &WorkerPool<'_>) -> Result<Self, SweepError> {
        let failed = |why: &dyn std::fmt::Display| SweepError::Run(format!("a worker cannot be started: {why}"));
        let mut command = (pool.command)().map_err(|why| failed(&why))?;
        // As many processes as cores, each with one thread.
        if pool.workers > 1 {
            command.env("RAYON_NUM_THREADS", "1");
        }
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(|why| failed(&why))?;
        let (Some(stdin), Some(stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(failed(&"the process has no standard input and output"));
        };
        let (tell, messages) = mpsc::channel();
        std::thread::spawn(move || read_messages(stdout, &tell));
        Ok(Self { child, stdin, messages, is_ready: false })
    }

    /// Sends a run to the worker and waits for it; `report` takes its reports. The limit starts when the plan has been read.
    ///
    /// # Errors
    /// The sweep was stopped.
    fn run(
        &mut self,
        number: usize,
        limit: Option<Duration>,
        stop: &AtomicBool,
        report: &dyn Fn(String),
    ) -> Result<WorkerAnswer, SweepError> {
        if !self.is_ready {
            match self.answer(None, stop, report)? {
                WorkerAnswer::Text(_) => self.is_ready = true,
                ended => return Ok(ended),
            }
        }
        // A worker that has ended is noticed by the closed channel, not by this write.
        let _ = writeln!(self.stdin, "{number}").and_then(|()| self.stdin.flush());
        self.answer(limit, stop, report)
    }

    /// Waits for the worker's next answer.
    #[allow(clippy::disallowed_methods, reason = "a limit is of the clock on the wall")]
    fn answer(
        &mut self,
        limit: Option<Duration>,
        stop: &AtomicBool,
        report: &dyn Fn(String),
    ) -> Result<WorkerAnswer, SweepError> {
        let start = Instant::now();
        loop {
            if stop.load(Ordering::Relaxed) {
                let _ = self.child.kill();
                return Err(SweepError::Run(STOPPED.into()));
            }
            let left = limit.map(|limit| limit.saturating_sub(start.elapsed()));
            match self.messages.recv_timeout(left.map_or(LOOK, |left| left.min(LOOK))) {
                Ok(WorkerMessage::Answer(answer)) => return Ok(WorkerAnswer::Text(answer)),
                Ok(WorkerMessage::Report { report: text }) => report(text),
                Err(mpsc::RecvTimeoutError::Timeout) if left.is_some_and(|left| left.is_zero()) => {
                    return Ok(WorkerAnswer::TooLong);
                }
                Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => return Ok(WorkerAnswer::Ended),
            }
        }
    }

    /// Waits for the end of the process. Returns its exit status as text.
    fn end(mut self) -> String {
        self.child.wait().map_or_else(|why| why.to_string(), |status| status.to_string())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Nothing is left unwritten: a part is written whole or not at all.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Forwards the worker's messages, one a line.
fn read_messages(stdout: ChildStdout, tell: &mpsc::Sender<WorkerMessage>) {
    for line in BufReader::new(stdout).lines().map_while(Result::ok) {
        let Ok(message) = serde_json::from_str(&line) else { return };
        if tell.send(message).is_err() {
            return;
        }
    }
}

/// Carries out the runs whose numbers come on the standard input, as a worker. `send` sends one message as JSON.
///
/// # Errors
/// `send` failed, or the input names no run of the plan.
pub fn serve<E: From<SweepError>>(
    plan: &SweepPlan,
    folder: &SweepFolder,
    send: impl Fn(serde_json::Value) -> Result<(), E>,
) -> Result<(), E> {
    let message = |message: WorkerMessage| send(serde_json::to_value(message).unwrap_or_default());
    let report = |report: &str| drop(message(WorkerMessage::Report { report: report.into() }));
    message(WorkerMessage::Answer(String::new()))?;
    for line in std::io::stdin().lines() {
        let line = line.map_err(|why| SweepError::Run(format!("the standard input: {why}")))?;
        let run = line.trim().parse().ok().and_then(|number: usize| plan.runs.get(number));
        let run = run.ok_or_else(|| SweepError::Plan(format!("the standard input: no run has the number {line:?}")))?;
        let made = run.part_name().and_then(|name| {
            let part = run.execute(&CheckpointFile { path: folder.checkpoint(&name), report: &report })?;
            folder.put(&run.part_name()?, &part)
        });
        message(WorkerMessage::Answer(made.map_or_else(|why| why.to_string(), |()| String::new())))?;
    }
    Ok(())
}

/// Returns the report of the failed runs, with the reasons of the first ones.
pub fn failure_report(plan: &SweepPlan, failed: &[FailedRun]) -> String {
    let mut text = format!("{} runs failed; run the same command again to repeat them", failed.len());
    for FailedRun { number, why } in failed.iter().take(LISTED_FAILURES) {
        text += &format!("\n  run {number}, {}: {}", plan.runs[*number], why.trim().replace('\n', "\n    "));
    }
    if failed.len() > LISTED_FAILURES {
        text += &format!("\n  and {} more", failed.len() - LISTED_FAILURES);
    }
    text
}
