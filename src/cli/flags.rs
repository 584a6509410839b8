//! Flags made from a struct's list of settings: help, unit, limits and defaults are written once. In: the command line. Out: a
//! checked [`Scenario`], or the changes to another struct of settings.

use super::CliError;
use crate::{
    file::{SETTINGS_BYTES, read_text},
    map::{self, is_path, quickest_way_through, scenario_file},
    scenario::{PlanError, PlannedDrive, Scenario},
    settings::{Field, SettingKind},
    sim::WorldError,
    toml_text::{self, KeyPart, did_you_mean},
};
use clap::{
    Arg, ArgAction, ArgMatches, Command,
    builder::{PossibleValue, TypedValueParser},
    error::ErrorKind,
    value_parser,
};
use serde_json::Value;
use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
};

const HEADING: &str = "Scenario";

/// Settings that people change from drive to drive, each with an example. `--help` lists these, `--help-all` lists all.
const COMMON: [(&str, &str); 12] = [
    ("map", "practice"),
    ("vehicles", "18"),
    ("traffic", "native"),
    ("start", "bunched"),
    ("warm_up_s", "120"),
    ("duration_s", "600"),
    ("seed", "7"),
    ("policy", "follower-stopper"),
    ("advised", "20%"),
    ("hold_s", "5"),
    ("range_mph", "2"),
    ("units", "kmh"),
];

/// Settings listed by `--help`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HelpListing {
    /// Settings that people change from drive to drive.
    Common,
    /// All settings of the scenario.
    All,
}

/// Adds `--scenario FILE` and a flag for each setting.
pub fn add(command: Command, listing: HelpListing) -> Command {
    let file = Arg::new("scenario")
        .long("scenario")
        .value_name("FILE")
        .value_parser(value_parser!(PathBuf))
        .help("Scenario file (TOML, at most 1 MiB, or a .sumocfg of SUMO), or the name of a map with one; flags take precedence")
        .help_heading(HEADING);
    let name = command.get_name().to_owned();
    let command = command.arg(file).args(places().map(|arg| arg.help_heading(HEADING).conflicts_with("path")));
    let all = add_fields(command, &Scenario::fields(), HEADING);
    if listing == HelpListing::All {
        let limits = format!("Limits: {}; {}.", crate::map::limits::IN_WORDS, crate::policy::onnx::limits::IN_WORDS);
        return all.after_help(limits);
    }
    let mut hidden = 0;
    let short = all.mut_args(|arg| {
        let id = arg.get_id().as_str().to_owned();
        let example = COMMON.iter().find(|(path, _)| *path == id);
        // `--driver` matters only in commands without a person at the wheel.
        let is_shown = example.is_some() || id == "scenario" || (id == "driver" && name != "drive");
        if arg.get_help_heading() != Some(HEADING) || is_shown {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            let flag = arg.get_long().unwrap_or_default().to_owned();
            return match example {
                Some((_, value)) => arg.help(format!("{help}; example: --{flag} {value}")),
                None => arg,
            };
        }
        hidden += 1;
        arg.hide(true)
    });
    short.after_help(format!(
        "codrive {name} --help-all lists {hidden} more settings of the scenario, and the limits of files."
    ))
}

/// Adds a flag for each setting outside tables, and one flag for each table.
pub fn add_fields(command: Command, fields: &[Field], heading: &'static str) -> Command {
    fields.iter().fold(command, |command, field| match field.table() {
        None => command.arg(argument(field).help_heading(heading)),
        Some(table) if command.get_arguments().any(|arg| arg.get_id() == table) => command,
        Some(table) => command.arg(table_argument(table, fields).help_heading(heading)),
    })
}

/// Returns the flags for a path by places: `--from`, `--via` and `--to`. A point may have a negative coordinate.
pub(super) fn places() -> [Arg; 3] {
    let place = |id: &'static str, help: &'static str| {
        Arg::new(id)
            .long(id)
            .value_name("PLACE")
            .value_parser(value_parser!(String))
            .allow_hyphen_values(true)
            .help(help)
    };
    [
        place("from", "Start of the path").requires("to"),
        place("via", "Place on the way; may be given several times, in driving order")
            .action(ArgAction::Append)
            .requires("from"),
        place("to", "End of the path").requires("from"),
    ]
}

/// Returns the path through the places of [`places`]; `None` without them.
pub(super) fn way(matches: &ArgMatches) -> Option<String> {
    let one = |id: &str| matches.get_one::<String>(id).map(String::as_str);
    let via = matches.get_many::<String>("via").into_iter().flatten().map(String::as_str);
    let places: Vec<&str> = one("from").into_iter().chain(via).chain(one("to")).collect();
    (!places.is_empty()).then(|| quickest_way_through(&places))
}

fn argument(field: &Field) -> Arg {
    let default = match &field.default {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let unit = if field.unit.is_empty() { String::new() } else { format!(" {}", field.unit) };
    let limits = match &field.kind {
        SettingKind::Whole { min, max } if *max < u64::from(u32::MAX) => format!("{min} to {max}{unit}; "),
        SettingKind::Number { min, max } => format!("{min} to {max}{unit}; "),
        _ => String::new(),
    };
    let arg =
        Arg::new(field.path.clone()).long(field.flag()).help(format!("{} [{limits}default {default}]", field.doc));
    let checked = field.clone();
    match &field.kind {
        SettingKind::Switch => arg
            .value_name("BOOL")
            .num_args(0..=1)
            .default_missing_value("true")
            .value_parser(value_parser!(bool))
            .hide_possible_values(true),
        SettingKind::Whole { .. } => arg.value_name("N").value_parser(move |text: &str| {
            let value: u64 = text.parse().map_err(|_| format!("allowed: {}", checked.allowed()))?;
            checked.fault(&value.into()).map_or(Ok(value), Err)
        }),
        SettingKind::Number { .. } => {
            arg.value_name(value_name(&field.unit)).allow_negative_numbers(true).value_parser(move |text: &str| {
                let value: f64 = text.parse().map_err(|_| format!("allowed: {}", checked.allowed()))?;
                checked.fault(&value.into()).map_or(Ok(value), Err)
            })
        }
        SettingKind::Choice(words) => arg.value_name("WORD").value_parser(WordParser(words.clone())),
        SettingKind::Text => arg.value_name("NAME").value_parser(value_parser!(String)),
    }
}

/// Returns a parser of the name of a file to write, which must have this ending: another ending would promise another format.
#[cfg(any(feature = "desktop", feature = "tune"))]
pub(super) fn file_with_ending(ending: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    clap::builder::PathBufValueParser::new().try_map(move |path| {
        let is_right = path.extension().is_some_and(|has| has.eq_ignore_ascii_case(ending));
        if is_right { Ok(path) } else { Err(format!("allowed: a name that ends in .{ending}")) }
    })
}

/// Checks that the file of a flag can be written at the end, which may be hours away. Makes its folder.
#[cfg(feature = "tune")]
pub(super) fn claim(path: &Path, flag: &str) -> Result<(), CliError> {
    let refused = |why: &str| Err(CliError::Input(format!("{}: {why}", path.display())));
    if path.exists() {
        return refused(&format!("exists\n  remedy: name another file with {flag}"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or(Ok(()), crate::private::folder).map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))
}

/// Parser of a choice of words. It suggests the nearest word also for short words, unlike clap's own parser.
#[derive(Clone)]
struct WordParser(Vec<String>);

impl TypedValueParser for WordParser {
    type Value = String;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<String, clap::Error> {
        let text = value.to_string_lossy();
        if self.0.iter().any(|word| *word == text) {
            return Ok(text.into_owned());
        }
        let flag = arg.map(ToString::to_string).unwrap_or_default();
        let near = did_you_mean(&text, &self.0);
        let message =
            format!("invalid value '{text}' for '{flag}'{near}\n  [possible values: {}]\n", self.0.join(", "));
        Err(command.clone().error(ErrorKind::InvalidValue, message))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(self.0.iter().map(PossibleValue::new)))
    }
}

fn value_name(unit: &str) -> &'static str {
    match unit {
        "s" => "SECS",
        "mph" => "MPH",
        "m" => "METRES",
        "m/s" => "MPS",
        _ => "X",
    }
}

/// Returns the one flag of all settings of a table, such as `--idm v0=30,T=1`.
fn table_argument(table: &str, fields: &[Field]) -> Arg {
    let name = table.to_owned();
    let keys: Vec<Field> = fields.iter().filter(|field| field.table() == Some(table)).cloned().collect();
    let help: Vec<String> = keys
        .iter()
        .map(|field| format!("  {} {}: {} [default {}]", key(field), field.doc, field.allowed(), field.default))
        .collect();
    Arg::new(name.clone())
        .long(name.replace('_', "-"))
        .value_name("KEY=X,...")
        .help(format!("{}\n{}", table_help(table), help.join("\n")))
        .value_parser(move |text: &str| parse_table(text, &keys))
}

fn table_help(table: &str) -> &'static str {
    match table {
        "idm" => "Car-following model of the other vehicles, for example T=1.5,noise=0",
        "automation" => "Automation of the participant's vehicle, for example system=traffic-jam-pilot,time_gap_s=2",
        "secondary_task" => "Secondary task of the participant, for example kind=n-back,n=2",
        "sound" => "Sound levels in dB, for example master_db=-6,wind_db=-60; -60 is silence",
        _ => "Scaling of the observation",
    }
}

fn key(field: &Field) -> &str {
    field.path.split_once('.').map_or(field.path.as_str(), |(_, key)| key)
}

fn parse_table(text: &str, known: &[Field]) -> Result<Vec<(Field, Value)>, String> {
    text.split(',')
        .map(|pair| {
            let (name, text) = pair.split_once('=').ok_or(format!("`{pair}` is not KEY=VALUE"))?;
            let field = known.iter().find(|field| key(field) == name.trim()).ok_or_else(|| {
                let names: Vec<&str> = known.iter().map(key).collect();
                format!(
                    "`{}` is unknown{}; known are {}",
                    name.trim(),
                    did_you_mean(name.trim(), &names),
                    names.join(", ")
                )
            })?;
            let text = text.trim();
            let value = match field.kind {
                SettingKind::Switch => text.parse().map(Value::Bool).ok(),
                SettingKind::Whole { .. } => text.parse::<u64>().map(Value::from).ok(),
                SettingKind::Number { .. } => text.parse::<f64>().map(Value::from).ok(),
                SettingKind::Choice(_) | SettingKind::Text => Some(text.into()),
            };
            let value = value.ok_or_else(|| format!("{} is `{text}`; allowed: {}", key(field), field.allowed()))?;
            field.fault(&value).map_or(Ok((field.clone(), value)), Err)
        })
        .collect()
}

/// Returns the scenario that the command line asks for.
///
/// # Errors
/// A wrong file, or a wrong combination of settings; the message is complete.
pub fn scenario(matches: &ArgMatches) -> Result<Scenario, CliError> {
    let base = match matches.get_one::<PathBuf>("scenario") {
        Some(path) => Scenario::from_file(&scenario_place(path)?)?,
        None => Scenario::default(),
    };
    let base = match way(matches) {
        Some(path) => Scenario { path, ..base },
        None => base,
    };
    Ok(base.with(&changes(matches, &Scenario::fields()))?)
}

/// Plans the drive of a scenario that the command line asks for.
///
/// # Errors
/// The road does not allow a setting; the message names the line of the scenario's file that has it.
pub fn planned(matches: &ArgMatches, scenario: &Scenario) -> Result<PlannedDrive, CliError> {
    PlannedDrive::new(scenario).map_err(|error| {
        let named = matches.get_one::<PathBuf>("scenario").and_then(|path| scenario_place(path).ok());
        let (PlanError::Setting { key, part, message }, Some(file)) = (&error, named) else {
            return WorldError::from(error).into();
        };
        let (text, key) = (read_text(&file, SETTINGS_BYTES).unwrap_or_default(), format!("{key}{part}"));
        match toml_text::has(&text, &key) {
            true => CliError::Input(toml_text::at(&text, &file.display().to_string(), &key, KeyPart::Value, message)),
            false => WorldError::from(error).into(),
        }
    })
}

/// Returns the file of `--scenario`: that of a map by the map's name, or the named one.
fn scenario_place(named: &Path) -> Result<PathBuf, CliError> {
    let name = named.to_string_lossy();
    match scenario_file(named) {
        Some(file) => Ok(file),
        None if named.exists() || is_path(&name) || name.contains('.') => Ok(named.into()),
        None => {
            let known: Vec<String> = map::list().into_iter().map(|map| map.name).collect();
            let near = did_you_mean(&name, &known);
            Err(CliError::Input(format!(
                "--scenario {name}: there is no such file, and no map of this name has a scenario{near}\n  remedy: the path \
                 of a file, or the name of a map: {}",
                known.join(", ")
            )))
        }
    }
}

/// Returns the settings named on the command line, among those that [`add_fields`] made flags for.
pub fn changes(matches: &ArgMatches, fields: &[Field]) -> Vec<(Field, Value)> {
    let mut changes: Vec<(Field, Value)> = Vec::new();
    let mut tables: Vec<&str> = Vec::new();
    for field in fields {
        let id = field.path.as_str();
        if let Some(table) = field.table() {
            if !tables.contains(&table) {
                tables.push(table);
                let named = matches.get_one::<Vec<(Field, Value)>>(table);
                changes.extend(named.into_iter().flatten().cloned());
            }
            continue;
        }
        let value = match &field.kind {
            SettingKind::Switch => matches.get_one::<bool>(id).map(|v| Value::from(*v)),
            SettingKind::Whole { .. } => matches.get_one::<u64>(id).map(|v| Value::from(*v)),
            SettingKind::Number { .. } => matches.get_one::<f64>(id).map(|v| Value::from(*v)),
            SettingKind::Choice(_) | SettingKind::Text => {
                matches.get_one::<String>(id).map(|v| Value::from(v.as_str()))
            }
        };
        changes.extend(value.map(|value| (field.clone(), value)));
    }
    changes
}
