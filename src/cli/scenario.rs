//! `codrive scenario`: imports scenarios of other programs. In: an OpenSCENARIO file. Out: a scenario of codrive with its road beside it.

use super::{CliError, out};
use crate::{
    map::{self, import::ImportOptions},
    private,
    scenario::openscenario::{ImportedScenario, OpenScenario, OpenScenarioError, ParticipantChoice, Unsupported},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::{Path, PathBuf};

/// Remedy for a scenario that has more than codrive.
const PARTLY: &str = "remedy: import the rest with --partly, or remove these parts from the file";

pub(super) fn command() -> Command {
    let path = value_parser!(PathBuf);
    Command::new("scenario").about("Import scenarios of other programs").subcommand_required(true).subcommand(
        Command::new("import")
            .about("Import an OpenSCENARIO XML 1.x file (.xosc) with its OpenDRIVE road as a scenario")
            .after_help(
                "The road is imported as a map into the folder NAME-road beside the scenario. Without --partly the \
                 import fails if the file has anything that codrive does not have, and lists all such places.\n\n\
                 Example: codrive scenario import cut-in.xosc --out cut-in.toml",
            )
            .arg(Arg::new("file").required(true).value_name("FILE").value_parser(path.clone()))
            .arg(
                Arg::new("out")
                    .long("out")
                    .value_name("FILE")
                    .value_parser(path)
                    .help("File of the scenario [default: the name of the file, with .toml, in this folder]"),
            )
            .arg(Arg::new("participant").long("participant").value_name("NAME").help(
                "Entity whose place the participant takes, or none [default: the entity named Ego; none without it]",
            ))
            .arg(
                Arg::new("partly")
                    .long("partly")
                    .action(ArgAction::SetTrue)
                    .help("Leave out what codrive does not have, and list it"),
            ),
    )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    match matches.subcommand() {
        Some(("import", m)) => import(m),
        _ => unreachable!("clap requires a command"),
    }
}

impl From<OpenScenarioError> for CliError {
    fn from(error: OpenScenarioError) -> Self {
        Self::Input(error.to_string())
    }
}

fn import(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(file) = matches.get_one::<PathBuf>("file") else { return Ok(()) };
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let out = matches.get_one::<PathBuf>("out").cloned().unwrap_or_else(|| format!("{stem}.toml").into());
    let choice = match matches.get_one::<String>("participant").map(String::as_str) {
        None => ParticipantChoice::Ego,
        Some("none") => ParticipantChoice::None,
        Some(name) => ParticipantChoice::Named(name.to_owned()),
    };
    let is_partly = matches.get_flag("partly");
    let scenario = OpenScenario::read(file)?;
    check_whole(file, scenario.unsupported(), is_partly)?;
    let folder = out.parent().unwrap_or(Path::new(""));
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' };
    let name = out.file_stem().unwrap_or_default().to_string_lossy().chars().map(plain).collect::<String>() + "-road";
    let road = folder.join(&name);
    if let Some(taken) = [&out, &road].into_iter().find(|path| path.exists()) {
        return Err(CliError::Input(format!(
            "{}: there is such a file or folder already\n  remedy: remove it, or name another file with --out",
            taken.display()
        )));
    }
    let stop = super::stop_on_ctrl_c();
    let (seconds, memory_mib) = (map::import::SECONDS, map::import::MEMORY_MIB);
    let options = ImportOptions { seconds, memory_mib, stop: &stop, side: None };
    map::import_within(folder, scenario.road_file(), &name, &options)?;
    let written = scenario
        .on(&road.join("net.xml").to_string_lossy(), &choice)
        .map_err(CliError::from)
        .and_then(|imported| check_whole(file, &imported.unsupported, is_partly).map(|()| imported))
        .and_then(|imported| write(imported, (&format!("{name}/net.xml"), file, &out)));
    if written.is_err() {
        // The map was made for this scenario alone.
        let _ = std::fs::remove_dir_all(&road);
    }
    written
}

/// Refuses a scenario of which something is left out, unless the user wants the rest.
fn check_whole(file: &Path, left_out: &[Unsupported], is_partly: bool) -> Result<(), CliError> {
    if is_partly || left_out.is_empty() {
        return Ok(());
    }
    let list: String = left_out.iter().map(|part| format!("\n  {part}")).collect();
    let count = left_out.len();
    Err(CliError::Input(format!("{}: codrive does not have {count} of its parts{list}\n  {PARTLY}", file.display())))
}

/// Writes the scenario and prints what it has.
fn write(mut imported: ImportedScenario, (map, file, out): (&str, &Path, &Path)) -> Result<(), CliError> {
    imported.scenario.map = map.to_owned();
    let source = file.file_name().unwrap_or_default().to_string_lossy();
    let failed = |error: std::io::Error| CliError::Failed(format!("{} cannot be written: {error}", out.display()));
    private::replace(out, imported.to_toml(&source).as_bytes()).map_err(failed)?;
    let ImportedScenario { scenario, unsupported, notes } = &imported;
    for (title, lines) in [("left out", unsupported.iter().map(ToString::to_string).collect()), ("note", notes.clone())]
    {
        for line in lines {
            out::line(format_args!("{title:<14} {line}"))?;
        }
    }
    let driven = if scenario.participant { "with a participant" } else { "without a participant" };
    let (users, events, end_s) = (scenario.road_users.len(), scenario.events.len(), scenario.duration_s);
    out::line(format_args!("scenario       {driven}; road users: {users}, events: {events}, at most {end_s} s"))?;
    out::line(format_args!("written        {}, with its road in {}", out.display(), map.trim_end_matches("/net.xml")))?;
    let command = if scenario.participant { "drive" } else { "run" };
    out::line(format_args!("drive it with: codrive {command} --scenario {}", out.display()))
}
