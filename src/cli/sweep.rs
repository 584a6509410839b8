//! `codrive sweep`: runs a plan on this machine's cores, as one part of a job array, or on a Ray cluster through the Python
//! package. Finished runs are kept: a second start makes the missing ones.

use super::{CliError, out, stop_on_ctrl_c};
use crate::sweep::{SweepError, SweepPlan, SweepRun, results::SweepFolder};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Stdio},
    sync::{
        Mutex,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    time::{Duration, Instant},
};

/// Interval between checks of the stop flag while waiting for a run.
const LOOK: Duration = Duration::from_millis(100);
/// Module of the Python package that uses Ray.
const RAY_MODULE: &str = "codrive.sweep";
/// Maximum number of failures printed; the others are counted.
const LISTED_FAILURES: usize = 10;

pub(super) fn command() -> Command {
    Command::new("sweep")
        .about("Carry out all runs of a plan: drives, rings, trainings, rehearsals")
        .long_about(
            "Carry out all runs of a plan: drives, rings, trainings, rehearsals.\n\nEach run is a part of its own in --out, written once and known \
             by what was run: after Ctrl-C, a fault or a power cut the same command makes what is missing. When all are there they are \
             put into one table a kind (Parquet).",
        )
        .arg(
            Arg::new("plan")
                .value_name("PLAN.toml")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("The plan: tables [[rings]], [[drives]], [[trainings]], [[rehearsals]]; see docs/sweeps.md"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .required_unless_present("list")
                .value_parser(value_parser!(PathBuf))
                .help("Folder of the results; what is there already is not made again"),
        )
        .arg(
            Arg::new("on")
                .long("on")
                .value_name("WORD")
                .default_value("local")
                .value_parser(["local", "ray"])
                .help("Who carries it out: this machine, or a Ray cluster (needs the Python package: pip install './python[ray]')"),
        )
        .arg(
            Arg::new("workers")
                .long("workers")
                .value_name("N")
                .value_parser(value_parser!(u16).range(1..=1024))
                .help("Runs at a time [default: the cores of this machine]"),
        )
        .arg(
            Arg::new("retries")
                .long("retries")
                .value_name("N")
                .default_value("1")
                .value_parser(value_parser!(u8).range(0..=100))
                .help("How often a run that failed is tried again, after all others"),
        )
        .arg(
            Arg::new("part")
                .long("part")
                .value_name("K/N")
                .value_parser(part)
                .help("Carry out the K-th of N parts of the plan alone, as one job of an array: --part $SLURM_ARRAY_TASK_ID/64"),
        )
        .arg(
            Arg::new("collect")
                .long("collect")
                .action(ArgAction::SetTrue)
                .conflicts_with_all(["part", "list"])
                .help("Run nothing; put the runs that are there into tables, and say how many are missing"),
        )
        .arg(
            Arg::new("list")
                .long("list")
                .action(ArgAction::SetTrue)
                .help("Run nothing; print every run, and which are there"),
        )
        .arg(Arg::new("worker").long("worker").action(ArgAction::SetTrue).hide(true))
}

/// Parses `3/64` as the part, from 1, and the number of parts.
fn part(text: &str) -> Result<[usize; 2], String> {
    let fault = || format!("{text:?} is no part; allowed: K/N with K from 1 to N, such as 3/64");
    let (part, parts) = text.split_once('/').ok_or_else(fault)?;
    let part: [usize; 2] = [part.trim().parse().map_err(|_| fault())?, parts.trim().parse().map_err(|_| fault())?];
    if (1..=part[1]).contains(&part[0]) { Ok(part) } else { Err(fault()) }
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(path) = matches.get_one::<PathBuf>("plan") else { return Ok(()) };
    let out = matches.get_one::<PathBuf>("out");
    if matches.get_one::<String>("on").is_some_and(|on| on == "ray") {
        return on_ray(path, matches);
    }
    let plan = SweepPlan::read(path)?;
    if matches.get_flag("list") {
        return list(&plan, out.map(PathBuf::as_path));
    }
    let Some(root) = out else { return Ok(()) };
    let folder = SweepFolder::open(root)?;
    if matches.get_flag("worker") {
        return worker(&plan, &folder);
    }
    if matches.get_flag("collect") {
        return collect(&plan, &folder);
    }
    let [part, parts] = matches.get_one::<[usize; 2]>("part").copied().unwrap_or([1, 1]);
    let missing = folder.missing(&plan.runs)?;
    let pending: Vec<usize> =
        missing.iter().map(|run| run.number).filter(|number| number % parts == part - 1).collect();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let workers = matches.get_one::<u16>("workers").map_or(cores, |workers| usize::from(*workers));
    let retries = matches.get_one::<u8>("retries").copied().unwrap_or_default();
    let pool = WorkerPool { plan: &plan, folder: &folder, workers: workers.min(pending.len()), retries };
    let done_count = (0..plan.runs.len()).filter(|number| number % parts == part - 1).count() - pending.len();
    let failed = pool.run(&pending, done_count, &stop_on_ctrl_c())?;
    if parts == 1 && failed.is_empty() {
        return collect(&plan, &folder);
    }
    failures(&plan, &failed)
}

/// Prints every run of the plan and whether it is done.
fn list(plan: &SweepPlan, root: Option<&Path>) -> Result<(), CliError> {
    let folder = root.filter(|root| root.is_dir()).map(SweepFolder::open).transpose()?;
    for run in &plan.runs {
        let name = run.part_name()?;
        let is_there = folder.as_ref().is_some_and(|folder| folder.part(&name).is_file());
        out::line(format_args!(
            "{:>7}  {}  {name}  {}",
            run.number,
            if is_there { "done" } else { "open" },
            run_text(run)
        ))?;
    }
    Ok(())
}

/// Returns the table and the varied settings of a run.
fn run_text(run: &SweepRun) -> String {
    let varied: Vec<String> = run.varied.iter().map(|(name, value)| format!("{name} {value}")).collect();
    format!("{}: {}", run.table, varied.join(", "))
}

/// Collects the finished runs into tables. Fails if runs are missing.
fn collect(plan: &SweepPlan, folder: &SweepFolder) -> Result<(), CliError> {
    let missing = folder.missing(&plan.runs)?.len();
    for table in folder.collect(plan)? {
        out::line(format_args!("{}: {} runs, {} rows", table.path.display(), table.runs, table.rows))?;
    }
    if missing == 0 {
        return Ok(());
    }
    Err(CliError::Failed(format!(
        "{missing} of {} runs are missing\n  remedy: the same command without --collect makes them",
        plan.runs.len()
    )))
}

/// Fails with the runs that failed and their reasons.
fn failures(plan: &SweepPlan, failed: &[(usize, String)]) -> Result<(), CliError> {
    if failed.is_empty() {
        return Ok(());
    }
    let mut text = format!("{} runs failed; the same command tries them again", failed.len());
    for (number, why) in failed.iter().take(LISTED_FAILURES) {
        text += &format!("\n  run {number}, {}: {}", run_text(&plan.runs[*number]), why.trim().replace('\n', "\n    "));
    }
    if failed.len() > LISTED_FAILURES {
        text += &format!("\n  and {} more", failed.len() - LISTED_FAILURES);
    }
    Err(CliError::Failed(text))
}

/// Pool of worker processes of this program: SUMO runs once per process, and a crash ends one run only.
struct WorkerPool<'a> {
    plan: &'a SweepPlan,
    folder: &'a SweepFolder,
    workers: usize,
    retries: u8,
}

impl WorkerPool<'_> {
    /// Carries out the runs due. Returns those that failed in every attempt.
    fn run(&self, pending: &[usize], done_count: usize, stop: &AtomicBool) -> Result<Vec<(usize, String)>, CliError> {
        let style = ProgressStyle::with_template("{bar:32} {pos}/{len} runs  {elapsed}  {eta} left  {msg}");
        let bar = ProgressBar::new((pending.len() + done_count) as u64);
        let bar =
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_position(done_count as u64);
        bar.reset_eta();
        let mut pending = pending.to_vec();
        let mut failed = Vec::new();
        for attempt in 0..=self.retries {
            failed = self.attempt(&pending, &bar, stop)?;
            if failed.is_empty() || attempt == self.retries {
                break;
            }
            pending = failed.iter().map(|(number, _)| *number).collect();
            bar.set_message(format!("{} failed, tried again", pending.len()));
        }
        bar.finish_and_clear();
        Ok(failed)
    }

    /// Carries out each run of a list once. Returns those that failed.
    fn attempt(
        &self,
        pending: &[usize],
        bar: &ProgressBar,
        stop: &AtomicBool,
    ) -> Result<Vec<(usize, String)>, CliError> {
        let queue = Mutex::new(pending.iter().copied());
        let failed = Mutex::new(Vec::new());
        let next = || queue.lock().ok()?.next();
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..self.workers)
                .map(|_| {
                    scope.spawn(|| -> Result<(), CliError> {
                        let mut worker = None;
                        while let Some(number) = next() {
                            let done = self.one(&mut worker, number, stop)?;
                            match done {
                                Ok(()) => bar.inc(1),
                                Err(why) => {
                                    failed.lock().map(|mut failed| failed.push((number, why))).unwrap_or_default()
                                }
                            }
                        }
                        Ok(())
                    })
                })
                .collect();
            let done: Vec<_> = workers.into_iter().map(std::thread::ScopedJoinHandle::join).collect();
            done.into_iter()
                .try_for_each(|done| done.unwrap_or_else(|_| Err(CliError::Failed("a thread broke down".into()))))
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
    ) -> Result<Result<(), String>, CliError> {
        let at_work = match worker {
            Some(at_work) => at_work,
            None => worker.insert(Worker::start(self)?),
        };
        let limit_s = self.plan.runs[number].limit_s;
        Ok(match at_work.run(number, limit_s.map(Duration::from_secs_f64), stop)? {
            WorkerAnswer::Message(answer) if answer.is_empty() => Ok(()),
            WorkerAnswer::Message(why) => Err(why),
            WorkerAnswer::Ended => {
                let end = worker.take().map(Worker::end).unwrap_or_default();
                Err(format!("its process ended ({end})"))
            }
            WorkerAnswer::TooLong => {
                // Dropping the worker ends it.
                *worker = None;
                Err(format!("it was not done after limit_s, {} s", limit_s.unwrap_or_default()))
            }
        })
    }
}

/// Process that carries out one run after the other. It writes an empty line when it has read the plan. It then reads a number
/// and writes an empty line or a fault, as JSON strings.
struct Worker {
    child: Child,
    stdin: ChildStdin,
    answers: mpsc::Receiver<String>,
    is_ready: bool,
}

/// Outcome of a run.
enum WorkerAnswer {
    /// Message of the worker: empty if the run is done, else the reason why it failed.
    Message(String),
    /// End of the worker's process.
    Ended,
    /// Time limit exceeded; the worker is still running.
    TooLong,
}

impl Worker {
    fn start(pool: &WorkerPool<'_>) -> Result<Self, CliError> {
        let failed = |why: &dyn std::fmt::Display| CliError::Failed(format!("a worker cannot be started: {why}"));
        let program = std::env::current_exe().map_err(|why| failed(&why))?;
        let mut command = std::process::Command::new(program);
        command.arg("sweep").arg(&pool.plan.path).arg("--out").arg(pool.folder.root()).arg("--worker");
        // As many processes as cores, each with one thread.
        if pool.workers > 1 {
            command.env("RAYON_NUM_THREADS", "1");
        }
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().map_err(|why| failed(&why))?;
        let (Some(stdin), Some(stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(failed(&"it has no standard input and output"));
        };
        let (tell, answers) = mpsc::channel();
        std::thread::spawn(move || read_answers(stdout, &tell));
        Ok(Self { child, stdin, answers, is_ready: false })
    }

    /// Sends a run to the worker and waits for it. The limit starts when the plan has been read.
    ///
    /// # Errors
    /// The sweep was stopped.
    fn run(&mut self, number: usize, limit: Option<Duration>, stop: &AtomicBool) -> Result<WorkerAnswer, CliError> {
        if !self.is_ready {
            match self.answer(None, stop)? {
                WorkerAnswer::Message(_) => self.is_ready = true,
                ended => return Ok(ended),
            }
        }
        // A worker that has ended is noticed by the closed channel, not by this write.
        let _ = writeln!(self.stdin, "{number}").and_then(|()| self.stdin.flush());
        self.answer(limit, stop)
    }

    /// Waits for the worker's next message.
    #[allow(clippy::disallowed_methods, reason = "a limit is of the clock on the wall")]
    fn answer(&mut self, limit: Option<Duration>, stop: &AtomicBool) -> Result<WorkerAnswer, CliError> {
        let start = Instant::now();
        loop {
            if stop.load(Ordering::Relaxed) {
                let _ = self.child.kill();
                return Err(CliError::Failed("stopped; the same command makes what is missing".into()));
            }
            let left = limit.map(|limit| limit.saturating_sub(start.elapsed()));
            match self.answers.recv_timeout(left.map_or(LOOK, |left| left.min(LOOK))) {
                Ok(answer) => return Ok(WorkerAnswer::Message(answer)),
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
fn read_answers(stdout: ChildStdout, tell: &mpsc::Sender<String>) {
    for line in BufReader::new(stdout).lines().map_while(Result::ok) {
        let Ok(answer) = serde_json::from_str::<String>(&line) else { return };
        if tell.send(answer).is_err() {
            return;
        }
    }
}

/// Carries out the runs whose numbers come on the standard input. Ctrl-C is left to the parent process.
fn worker(plan: &SweepPlan, folder: &SweepFolder) -> Result<(), CliError> {
    let _ = stop_on_ctrl_c();
    let answer = |text: String| out::line(format_args!("{}", serde_json::Value::String(text)));
    answer(String::new())?;
    for line in std::io::stdin().lines() {
        let line = line.map_err(|why| CliError::Failed(format!("the standard input: {why}")))?;
        let run = line.trim().parse().ok().and_then(|number: usize| plan.runs.get(number));
        let run = run.ok_or_else(|| CliError::Input(format!("the standard input: no run has the number {line:?}")))?;
        let made = run.execute().and_then(|bytes| folder.put(&run.part_name()?, &bytes));
        answer(made.map_or_else(|why| why.to_string(), |()| String::new()))?;
    }
    Ok(())
}

/// Python's `-m MODULE ARGUMENTS` without the working folder in the module path: a file ray.py among the user's data must not
/// be imported.
const WITHOUT_WORKING_FOLDER: &str = "import sys; sys.path[:] = [p for p in sys.path if p]; del sys.argv[0]; \
    import importlib.util, runpy; importlib.util.find_spec('codrive') or sys.exit('python3: there is no package codrive'); \
    runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)";

/// Carries out the plan on a Ray cluster, through the Python package.
fn on_ray(plan: &Path, matches: &ArgMatches) -> Result<(), CliError> {
    let Some(root) = matches.get_one::<PathBuf>("out") else { return Ok(()) };
    let mut command = std::process::Command::new("python3");
    command.args(["-c", WITHOUT_WORKING_FOLDER, RAY_MODULE]).arg(plan).arg("--out").arg(root);
    for (name, value) in [
        ("--workers", matches.get_one::<u16>("workers").map(ToString::to_string)),
        ("--retries", matches.get_one::<u8>("retries").map(ToString::to_string)),
    ] {
        command.args(value.iter().flat_map(|value| [name, value]));
    }
    let status = command.status().map_err(|why| {
        CliError::Input(format!(
            "--on ray needs Python and the package codrive: python3: {why}\n  remedy: pip install './python[ray]'"
        ))
    })?;
    match status.code() {
        Some(0) => Ok(()),
        Some(code) => Err(CliError::Failed(format!(
            "python3 -m {RAY_MODULE} ended with exit status {code}\n  remedy: where it says that there is no such package, pip install './python[ray]'"
        ))),
        None => Err(CliError::Failed(format!("python3 -m {RAY_MODULE} was ended: {status}"))),
    }
}

impl From<SweepError> for CliError {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Plan(text) => Self::Input(text),
            SweepError::Run(text) => Self::Failed(text),
            SweepError::Drive(error) => error.into(),
            SweepError::Record(error) => error.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_lies_between_one_and_the_number_of_parts() {
        assert_eq!(part("3/64"), Ok([3, 64]));
        assert_eq!(part(" 1 / 1 "), Ok([1, 1]));
        for wrong in ["0/4", "5/4", "4", "a/b", "1/0", "-1/4"] {
            let message = part(wrong).expect_err(wrong);
            assert!(message.contains("allowed: K/N with K from 1 to N"), "{message}");
        }
    }
}
