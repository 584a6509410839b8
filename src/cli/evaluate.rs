//! `codrive evaluate`: policies side by side on the same rings of the native engine, whole horizons, transients included.

use super::{CliError, flags};
use crate::{
    policy::{self, Policy, PolicySettings},
    sim::{fields_of, settings_from_file, settings_with},
    space::CAR_LENGTH_M,
    train::{TrainConfig, Verdict, judge, mean_and_interval},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::json;
use std::path::PathBuf;

pub(super) fn command() -> Command {
    let command = Command::new("evaluate")
        .about("Drive policies over whole horizons on rings of the native engine and compare them")
        .arg(
            Arg::new("policy")
                .long("policy")
                .value_name("NAME|FILE.toml")
                .action(ArgAction::Append)
                .help("Policy to drive; may be given several times [default: all that are known by name]"),
        )
        .arg(
            Arg::new("aim")
                .long("aim")
                .value_name("MPS")
                .value_parser(value_parser!(f64))
                .default_value("0")
                .help("Speed that the policies known by name aim for; 0 takes 98.5 % of the equilibrium speed"),
        )
        .arg(
            Arg::new("over")
                .long("over")
                .value_name("N")
                .value_parser(value_parser!(u32).range(2..=100_000))
                .default_value("20")
                .help("Rings to drive on, each with a seed of its own"),
        )
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print as JSON, ring by ring"))
        .arg(
            Arg::new("config")
                .long("config")
                .value_name("FILE")
                .value_parser(value_parser!(PathBuf))
                .help("Configuration (TOML) as of train; flags beside it win over what it says"),
        );
    flags::add_fields(command, &fields_of::<TrainConfig>(), "Configuration")
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let base = match matches.get_one::<PathBuf>("config") {
        Some(path) => settings_from_file(path)?,
        None => paper_ring(),
    };
    let config: TrainConfig = settings_with(&base, &flags::changes(matches, &fields_of::<TrainConfig>()))?;
    let names: Vec<String> = match matches.get_many::<String>("policy") {
        Some(names) => names.cloned().collect(),
        None => policy::NAMES.iter().map(|name| (*name).to_owned()).collect(),
    };
    let rings = matches.get_one::<u32>("over").copied().unwrap_or(20) as usize;
    let settings = settings(&config, matches.get_one::<f64>("aim").copied().unwrap_or_default());
    let mut report = Vec::new();
    for name in &names {
        policy::build(name, &settings).map_err(|e| CliError::Input(e.to_string()))?;
        let make = || -> Option<Box<dyn Policy>> { policy::build(name, &settings).ok().flatten() };
        let verdicts = judge(&config, "evaluate", rings, make);
        if !matches.get_flag("json") {
            println!("{}", words(name, &verdicts));
        }
        report.push(json!({ "policy": name, "rings": verdicts }));
    }
    if matches.get_flag("json") {
        let whole = json!({ "config": config, "aim_mps": settings.aim_or_automatic_mps(), "policies": report });
        println!("{whole:#}");
    }
    Ok(())
}

/// HC22's ring with the wave on it, for an evaluation that names no configuration.
fn paper_ring() -> TrainConfig {
    TrainConfig { circumference_min_m: 250.0, circumference_max_m: 250.0, bunched_share: 1.0, ..TrainConfig::default() }
}

/// What the policies known by name are built from: the middle of the configuration's rings.
fn settings(config: &TrainConfig, aim_mps: f64) -> PolicySettings {
    let length_m = (config.circumference_min_m + config.circumference_max_m) / 2.0;
    let cars = f64::from(config.vehicles_min + config.vehicles_max) / 2.0;
    let equilibrium_mps = config.idm.equilibrium_speed_mps(length_m / cars - CAR_LENGTH_M);
    PolicySettings { aim_mps, equilibrium_mps, step_s: config.step_s }
}

fn words(name: &str, verdicts: &[Verdict]) -> String {
    let (mean, interval) = mean_and_interval(verdicts);
    let crashes = verdicts.iter().filter(|v| v.crashed).count();
    let least = verdicts.iter().map(|v| v.least_gap_m).fold(f64::INFINITY, f64::min);
    let calm: Vec<f64> = verdicts.iter().filter_map(|v| v.calm_s).collect();
    let calm_mean = if calm.is_empty() { 0.0 } else { calm.iter().sum::<f64>() / calm.len() as f64 };
    let calmed = if calm.is_empty() { String::new() } else { format!(" after {calm_mean:.0} s") };
    format!(
        "{name:<24} {mean:.3} +-{interval:.3} m/s  calm {} of {}{calmed}  least gap {least:.2} m  crashes {crashes}",
        calm.len(),
        verdicts.len()
    )
}
