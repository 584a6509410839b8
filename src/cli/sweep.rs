//! `codrive sweep`: runs a plan on this machine's cores, as one part of a job array, or on a Ray cluster through the Python
//! package. Finished runs are kept: a second start makes the missing ones.

use super::{CliError, out, own_program::own_program, stop_on_ctrl_c};
use crate::sweep::{
    SweepError, SweepPlan,
    results::SweepFolder,
    supervisor::{self, FailedRun, SweepProgress, WorkerPool},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};

/// Module of the Python package that uses Ray.
const RAY_MODULE: &str = "codrive_sim.sweep";

pub(super) fn command() -> Command {
    Command::new("sweep")
        .about("Carry out all runs of a plan: drives, rings, trainings, rehearsals")
        .long_about(
            "Carry out all runs of a plan: drives, rings, trainings, rehearsals.\n\n\
             Each run has its own part in --out, named after its settings. After Ctrl-C, a fault or a power cut, run \
             the same command: it makes the missing parts. A training continues from its last checkpoint, at most a \
             minute old. The complete results become one table for each kind of run (Parquet).",
        )
        .arg(
            Arg::new("plan")
                .value_name("PLAN.toml")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Plan with tables [[rings]], [[drives]], [[trainings]], [[rehearsals]]; see docs/sweeps.md"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .required_unless_present("list")
                .value_parser(value_parser!(PathBuf))
                .help("Folder of the results; existing results are not made again"),
        )
        .arg(Arg::new("on").long("on").value_name("WORD").default_value("local").value_parser(["local", "ray"]).help(
            "Place of the runs: this machine, or a Ray cluster (needs the Python package: pip install './python[ray]')",
        ))
        .arg(
            Arg::new("workers")
                .long("workers")
                .value_name("N")
                .value_parser(value_parser!(u16).range(1..=1024))
                .help("Number of runs at the same time [default: the cores of this machine]"),
        )
        .arg(
            Arg::new("retries")
                .long("retries")
                .value_name("N")
                .default_value("1")
                .value_parser(value_parser!(u8).range(0..=100))
                .help("Number of further attempts at a failed run, after all other runs"),
        )
        .arg(
            Arg::new("part")
                .long("part")
                .value_name("K/N")
                .value_parser(part)
                .help("Carry out only part K of N of the plan, as one job of an array: --part $SLURM_ARRAY_TASK_ID/64"),
        )
        .arg(
            Arg::new("collect")
                .long("collect")
                .action(ArgAction::SetTrue)
                .conflicts_with_all(["part", "list"])
                .help("Run nothing; make tables of the finished runs, and print the number of missing runs"),
        )
        .arg(
            Arg::new("list")
                .long("list")
                .action(ArgAction::SetTrue)
                .help("Run nothing; list all runs, and mark the finished ones"),
        )
        .arg(Arg::new("worker").long("worker").action(ArgAction::SetTrue).hide(true))
}

/// Parses `3/64` as the part, from 1, and the number of parts.
fn part(text: &str) -> Result<[usize; 2], String> {
    let fault = || format!("{text:?} is not a part; allowed: K/N with K from 1 to N, such as 3/64");
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
        // Ctrl-C is left to the parent process.
        let _ = stop_on_ctrl_c();
        return supervisor::serve(&plan, &folder, |message| out::line(format_args!("{message}")));
    }
    if matches.get_flag("collect") {
        return collect(&plan, &folder);
    }
    let [part, parts] = matches.get_one::<[usize; 2]>("part").copied().unwrap_or([1, 1]);
    let missing = folder.missing(&plan.runs)?;
    let pending: Vec<usize> =
        missing.iter().map(|run| run.number).filter(|number| number % parts == part - 1).collect();
    let done_count = (0..plan.runs.len()).filter(|number| number % parts == part - 1).count() - pending.len();
    let failed = make(&plan, &folder, pending, done_count, matches)?;
    match (failed.is_empty(), parts) {
        (true, 1) => collect(&plan, &folder),
        (true, _) => Ok(()),
        (false, _) => Err(CliError::Failed(supervisor::failure_report(&plan, &failed))),
    }
}

/// Prints every run of the plan and whether it is done.
fn list(plan: &SweepPlan, root: Option<&Path>) -> Result<(), CliError> {
    let folder = root.filter(|root| root.is_dir()).map(SweepFolder::open).transpose()?;
    for run in &plan.runs {
        let name = run.part_name()?;
        let is_there = folder.as_ref().is_some_and(|folder| folder.part(&name).is_file());
        out::line(format_args!("{:>7}  {}  {name}  {}", run.number, if is_there { "done" } else { "open" }, run))?;
    }
    Ok(())
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
        "{missing} of {} runs are missing\n  remedy: run the same command without --collect",
        plan.runs.len()
    )))
}

/// Makes the runs with these numbers by workers of this program, under a progress bar. Returns those that failed.
fn make(
    plan: &SweepPlan,
    folder: &SweepFolder,
    pending: Vec<usize>,
    done_count: usize,
    matches: &ArgMatches,
) -> Result<Vec<FailedRun>, CliError> {
    let style = ProgressStyle::with_template("{bar:32} {pos}/{len} runs  {elapsed}  {eta} left  {msg}");
    let bar = ProgressBar::new((pending.len() + done_count) as u64);
    let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())).with_position(done_count as u64);
    bar.reset_eta();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let pool = WorkerPool {
        plan,
        command: &|| {
            let mut command = own_program()?;
            command.arg("sweep").arg(&plan.path).arg("--out").arg(folder.root()).arg("--worker");
            Ok(command)
        },
        workers: matches.get_one::<u16>("workers").map_or(cores, |workers| usize::from(*workers)).min(pending.len()),
        retries: matches.get_one::<u8>("retries").copied().unwrap_or_default(),
        progress: &|progress| match progress {
            SweepProgress::Done => bar.inc(1),
            SweepProgress::Retry(failed) => bar.set_message(format!("{failed} failed, next attempt")),
            SweepProgress::Report(text) => bar.suspend(|| out::status_line(&text)),
        },
    };
    let failed = pool.run(pending, &stop_on_ctrl_c());
    bar.finish_and_clear();
    Ok(failed?)
}

/// Python's `-m MODULE ARGUMENTS` without the working folder in the module path: a file ray.py among the user's data must not
/// be imported. The package index has another project under the name codrive, which old texts told users to install.
const WITHOUT_WORKING_FOLDER: &str = "import sys; sys.path[:] = [p for p in sys.path if p]; del sys.argv[0]; import \
    importlib.util, runpy; is_there = importlib.util.find_spec; is_there('codrive_sim') or sys.exit('python3: the package \
    codrive_sim is missing' + bool(is_there('codrive')) * '; the package codrive there is another project'); \
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
            "--on ray needs Python and the package codrive_sim: python3: {why}\n  remedy: pip install './python[ray]'"
        ))
    })?;
    match status.code() {
        Some(0) => Ok(()),
        Some(code) => Err(CliError::Failed(format!(
            "python3 -m {RAY_MODULE} ended with exit status {code}\n  remedy: if a package is missing, pip install \
             './python[ray]'"
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
