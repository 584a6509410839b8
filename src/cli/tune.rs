//! `codrive tune`: searches the parameters of a controller on the fast ring, with as much effort as a network's training. In:
//! controller, driver, rings. Out: a file for `--policy`. Ctrl-C ends the search and writes the best parameters so far.

use super::{
    CliError,
    evaluate::plan::{self, FollowingDriver},
    flags, out, stop_on_ctrl_c,
};
use crate::{
    policy::{self, CONTROLLERS, ControllerKind},
    private,
    settings::{self, Settings, fields_of},
    train::{TrainConfig, tuning::TuningTask},
};
use clap::{Arg, ArgMatches, Command, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

pub(super) fn command() -> Command {
    let option =
        |id: &'static str, name: &'static str, help: &'static str| Arg::new(id).long(id).value_name(name).help(help);
    let kinds = CONTROLLERS.map(ControllerKind::name).join(", ");
    let command = Command::new("tune")
        .about(super::TUNE_ABOUT)
        .after_help(
            "Example: codrive tune --policy two-phase --driver reaction=1,error=0.5 --holds 1,10 --out mine.toml\n         \
             codrive evaluate --policy mine.toml --policy two-phase --driver reaction=1,error=0.5 --holds 1,10",
        )
        .arg(
            Arg::new("policy")
                .long("policy")
                .value_name("KIND|FILE.toml")
                .required(true)
                .help(format!("Controller to tune: {kinds}, or the file of a controller to start from")),
        )
        .arg(
            option("out", "FILE.toml", "File of the tuned controller; an existing file is not replaced")
                .required(true)
                .value_parser(super::flags::file_with_ending("toml")),
        )
        .arg(
            option(
                "driver",
                "NAME|reaction=S,error=MPS,...",
                "Driver that follows the advice, as for codrive evaluate [default: the driver of --config, else \
                 follow]",
            )
            .value_parser(plan::driver),
        )
        .arg(
            option("holds", "SECS,...", "Holds to tune for; the mean over them is optimized [default: the \
                configuration's]")
                .value_delimiter(',')
                .value_parser(value_parser!(f64)),
        )
        .arg(
            option("budget", "N", "Parameter sets to try")
                .value_parser(value_parser!(u32).range(2..=1_000_000))
                .default_value("400"),
        )
        .arg(
            option("over", "N", "Number of rings on which each parameter set is tried")
                .value_parser(value_parser!(u32).range(2..=100_000))
                .default_value("64"),
        )
        .arg(
            option("config", "FILE", "Configuration file (TOML), as for train; flags take precedence")
                .value_parser(value_parser!(PathBuf)),
        );
    flags::add_fields(command, &fields_of::<TrainConfig>(), "Configuration")
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(path) = matches.get_one::<PathBuf>("out") else { return Ok(()) };
    let task = task(matches)?;
    flags::claim(path, "--out")?;
    let stop = stop_on_ctrl_c();
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {elapsed} {msg}  {eta} left");
    let bar = ProgressBar::new(u64::from(task.budget));
    let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let best = Mutex::new(f64::NEG_INFINITY);
    let result = task.run(&stop, |mean_mps| {
        let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
        *best = best.max(mean_mps);
        bar.set_message(format!("best {:.3} m/s", *best));
        bar.inc(1);
    });
    bar.finish_and_clear();
    let Some(before_mps) = result.before_mps else {
        return Err(CliError::Failed("stopped before anything was tried; nothing was written".into()));
    };
    private::replace(path, task.file(&result).as_bytes())
        .map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))?;
    out::line(format_args!(
        "{}: {:.3} m/s, {before_mps:.3} before; {} of {} parameter sets tried on {} rings",
        path.display(),
        result.after_mps,
        result.tried,
        task.budget,
        task.rings
    ))
}

/// Returns the tuning task that the command line asks for.
fn task(matches: &ArgMatches) -> Result<TuningTask, CliError> {
    let base = match matches.get_one::<PathBuf>("config") {
        Some(path) => settings::from_file(path)?,
        None => TrainConfig::paper_ring(),
    };
    let config: TrainConfig = settings::changed(&base, &flags::changes(matches, &fields_of::<TrainConfig>()))?;
    let driver = match matches.get_one::<FollowingDriver>("driver") {
        Some(driver) => driver.clone(),
        None if plan::says_who_follows(matches) => FollowingDriver::Configured,
        None => plan::default_driver()?,
    };
    let holds_s: Vec<f64> = match matches.get_many::<f64>("holds") {
        Some(holds) => holds.copied().collect(),
        None => vec![config.advice.hold_s],
    };
    for hold_s in &holds_s {
        config.held(*hold_s).check().map_err(|(_, fault)| CliError::Input(fault))?;
    }
    let start_name = matches.get_one::<String>("policy").cloned().unwrap_or_default();
    let start =
        policy::controller(&start_name, &config.policy_settings(0.0)).map_err(|e| CliError::Input(e.to_string()))?;
    let number = |id: &str| matches.get_one::<u32>(id).copied().unwrap_or_default();
    Ok(TuningTask {
        config: driver.of(&config),
        driver: driver.label(),
        holds_s,
        rings: number("over") as usize,
        budget: number("budget"),
        start,
        start_name,
    })
}
