//! `codrive validate --fit`: fits a population of drivers to a measured ring. In: flags and the measured part of a file. Out: a population's
//! file with intervals and sources, and tables of numbers, moments and held-out distances.

use super::{CliError, flags, out, progress::progress, stop_on_ctrl_c};
use crate::{
    metrics::traffic_moments::{MOMENTS, VehicleTrajectories},
    private,
    traffic::TrafficPopulation,
    train::population_fit::{FITTED_MOMENTS, FitTask, FittedNumber, PopulationFit, USUAL_NUMBERS, USUAL_SAMPLE_BUDGET},
};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::{
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError, atomic::Ordering},
};

/// Population from which a fit starts.
const START: &str = "safe-followers";

/// Adds the flags of a fit.
pub(super) fn with_flags(command: Command) -> Command {
    let option = |id: &'static str, name: &'static str, help: &'static str| {
        Arg::new(id).long(id).value_name(name).help(help).requires("fit")
    };
    let count = || value_parser!(u32).range(0..=1000);
    command
        .arg(
            Arg::new("fit")
                .long("fit")
                .value_name("OUT.toml")
                .value_parser(flags::file_with_ending("toml"))
                .requires("ring")
                .conflicts_with_all(["traffic-drivers", "people", "json", "out"])
                .help("Fit a population of drivers to the ring of the file; an existing file is not replaced"),
        )
        .arg(
            option(
                "fitted",
                "NAME,...",
                "Numbers to fit: T is a mean, T.spread a spread between persons, T~noise_sd a \
                correlation; others stay as in --start",
            )
            .value_delimiter(',')
            .default_value(USUAL_NUMBERS.join(",")),
        )
        .arg(option("start", "NAME|FILE.toml", "Population from which the fit starts").default_value(START))
        .arg(
            option("bootstrap", "N", "Samples of persons for 95 % intervals; 0: no intervals")
                .value_parser(count())
                .default_value("20"),
        )
        .arg(
            option("budget", "N", "Sets of numbers to try in each of two fits, to half of the minutes and to all")
                .value_parser(value_parser!(u32).range(2..=100_000))
                .default_value("200"),
        )
        .arg(
            option("rings", "N", "Simulated rings for each set of numbers")
                .value_parser(value_parser!(u32).range(1..=1000))
                .default_value("16"),
        )
        .arg(
            option("seed", "N", "Seed of the search and of the rings")
                .value_parser(value_parser!(u64))
                .default_value("1"),
        )
}

/// Returns true if a fit is asked for.
pub(super) fn is_wanted(matches: &ArgMatches) -> bool {
    matches.contains_id("fit")
}

/// Fits to the measured part of a file.
pub(super) fn main(matches: &ArgMatches, file: &Path, people: &VehicleTrajectories) -> Result<(), CliError> {
    let Some(path) = matches.get_one::<PathBuf>("fit") else { return Ok(()) };
    if matches.get_many::<PathBuf>("file").is_some_and(|files| files.len() > 1) {
        return Err(CliError::Input("--fit: allowed: one file".into()));
    }
    if people.positions_m().is_none() {
        let text =
            "the vehicles do not form one ring; allowed with --fit: each vehicle has a leader, all the way round";
        return Err(CliError::Input(format!("{}: {text}", file.display())));
    }
    let task = task(matches)?;
    flags::claim(path, "--fit")?;
    let from_s = matches.get_one::<f64>("from").copied().unwrap_or(0.0);
    let to_s = from_s + people.steps() as f64 * people.step_s;
    let stop = stop_on_ctrl_c();
    let bar = progress(u64::from(task.most_tried()), "sets of numbers".into());
    let best = Mutex::new(f64::INFINITY);
    let fit = task.run(people, [from_s, to_s], &stop, &|distance: f64| {
        let mut best = best.lock().unwrap_or_else(PoisonError::into_inner);
        *best = best.min(distance);
        bar.set_message(format!("nearest {:.3}", *best));
        bar.inc(1);
    });
    bar.finish_and_clear();
    let fit = fit.map_err(|fault| {
        CliError::Input(format!("{}: {fault}\n  remedy: two halves of some minutes of driving", file.display()))
    })?;
    let stopped = || CliError::Failed("stopped before anything was tried; nothing was written".into());
    let mut fit = fit.ok_or_else(stopped)?;
    let is_stopped = stop.load(Ordering::Relaxed);
    describe(&mut fit, &task, file, [from_s, to_s], is_stopped);
    let text = format!("# {}\n{}", "Written by codrive validate --fit.", fit.population.to_toml());
    private::replace(path, text.as_bytes()).map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))?;
    out::text(tables(&fit, &task))?;
    let ended = if is_stopped { "stopped; the best so far, " } else { "" };
    out::line(format_args!(
        "{}: {ended}distance {:.3}, {} sets of numbers tried",
        path.display(),
        fit.distance,
        fit.tried
    ))
}

fn task(matches: &ArgMatches) -> Result<FitTask, CliError> {
    let text = |id: &str| matches.get_one::<String>(id).map(String::as_str).unwrap_or_default();
    let number = |id: &str| matches.get_one::<u32>(id).copied().unwrap_or_default();
    let start = TrafficPopulation::named(text("start")).map_err(|error| CliError::Input(error.0))?;
    let names = matches.get_many::<String>("fitted").into_iter().flatten();
    let numbers = names.map(|name| FittedNumber::named(name, &start)).collect::<Result<Vec<_>, _>>();
    Ok(FitTask {
        numbers: numbers.map_err(|fault| CliError::Input(format!("--fitted {fault}")))?,
        start,
        runs: number("rings") as usize,
        budget: number("budget"),
        bootstrap: number("bootstrap"),
        sample_budget: USUAL_SAMPLE_BUDGET,
        seed: matches.get_one::<u64>("seed").copied().unwrap_or(1),
    })
}

/// Writes title and sources of the fitted population.
fn describe(fit: &mut PopulationFit, task: &FitTask, file: &Path, [from_s, to_s]: [f64; 2], is_stopped: bool) {
    let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let before = if is_stopped { "; stopped before its end" } else { "" };
    fit.population.title = format!("People of {name}");
    fit.population.source = format!(
        "Fit of {} moments to {name}, {from_s:.0} to {to_s:.0} s, by CMA-ES on {} simulated rings, seed {}, codrive {}{before}; numbers \
         without a source of their own are those of: {}",
        FITTED_MOMENTS.len(),
        task.runs,
        task.seed,
        env!("CARGO_PKG_VERSION"),
        task.start.title
    );
    for parameter in fit.population.parameters.values_mut().filter(|parameter| parameter.source.is_empty()) {
        parameter.source.clone_from(&task.start.source);
    }
    for (name, parameter) in &mut fit.population.parameters {
        let of_parameter = |number: &FittedNumber| !is_correlation(number) && number.parameters() == [name.as_str()];
        let numbers: Vec<String> = (0..task.numbers.len())
            .filter(|k| of_parameter(&task.numbers[*k]))
            .map(|k| number_text(fit.intervals.as_deref(), &task.numbers[k], fit.values[k], k))
            .collect();
        if !numbers.is_empty() {
            parameter.source = format!("Fit: {}", numbers.join(", "));
        }
    }
    for correlation in &mut fit.population.correlations {
        let k =
            task.numbers.iter().position(|number| is_correlation(number) && number.parameters() == correlation.between);
        if let Some(k) = k {
            correlation.source =
                format!("Fit: {}", number_text(fit.intervals.as_deref(), &task.numbers[k], fit.values[k], k));
        }
    }
}

fn is_correlation(number: &FittedNumber) -> bool {
    matches!(number, FittedNumber::Correlation(_))
}

/// Returns a number with its interval.
fn number_text(intervals: Option<&[[f64; 2]]>, number: &FittedNumber, value: f64, k: usize) -> String {
    let interval = intervals.map(|all| format!(" ({:.3} to {:.3})", all[k][0], all[k][1]));
    format!("{number} {value:.3}{}", interval.unwrap_or_default())
}

/// Returns the tables of numbers, moments and held-out distances.
fn tables(fit: &PopulationFit, task: &FitTask) -> String {
    let mut text = String::new();
    for (k, number) in task.numbers.iter().enumerate() {
        text += &format!("{}\n", number_text(fit.intervals.as_deref(), number, fit.values[k], k));
    }
    let [people, model] = &fit.moments;
    text += &format!("\n{:<50}{:>10}{:>10}\n", "moment", "people", "model");
    for (k, name) in FITTED_MOMENTS.iter().enumerate() {
        let measure = MOMENTS.iter().find(|measure| measure.name == *name);
        let title = measure.map_or_else(String::new, |measure| format!("{}, {}", measure.title, measure.unit));
        text += &format!("{:<50}{:>10.3}{:>10.3}\n", title.trim_end_matches(", "), people[k], model[k]);
    }
    if let Some(held_out) = fit.held_out {
        text += &format!(
            "\nDistance to the second half of the minutes: fit to the first half {:.2}, people in the first half {:.2}, start {:.2}, \
             ring study {:.2}\n",
            held_out.model, held_out.people, held_out.start, held_out.ring_study
        );
    }
    text
}
