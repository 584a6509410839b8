//! `codrive study`: a whole study from one file: its plan, a participant's session, a rehearsal, or one participant's data.

use super::{CliError, desktop::session as desktop, out, stop_on_ctrl_c};
use crate::{
    analysis::{analyse, find},
    drive_loop::{RunError, recording_manifest, rehearsal::Rehearsal},
    driver::{DriversFile, FittedDriver, Population},
    record,
    study::{
        Completion, DataSet, ParticipantCode, Study, StudyError,
        preregistration::{self, OutcomeSpread, PreregistrationError},
    },
};
use clap::{Arg, ArgAction, ArgGroup, ArgMatches, Command, builder::NonEmptyStringValueParser, value_parser};
use std::path::{Path, PathBuf};

pub(super) fn command() -> Command {
    Command::new("study")
        .about(desktop::ABOUT)
        .arg(
            Arg::new("file")
                .value_name("FILE.toml")
                .required_unless_present("schema")
                .value_parser(value_parser!(PathBuf))
                .help("The study, for example assets/studies/congestion.toml"),
        )
        .arg(
            Arg::new("check")
                .long("check")
                .action(ArgAction::SetTrue)
                .help("Check every scenario and questionnaire in it and print each participant's order of conditions"),
        )
        .args(desktop::arguments())
        .arg(
            Arg::new("rehearse").long("rehearse").action(ArgAction::SetTrue).requires("out").conflicts_with("check").help(
                "Take simulated participants through the whole plan at full speed, questions and baselines included; \
                 Ctrl-C stops it; run the same command to resume",
            ),
        )
        .arg(
            Arg::new("drivers")
                .long("drivers")
                .value_name("FILE.toml")
                .requires("rehearse")
                .value_parser(value_parser!(PathBuf))
                .help(
                    "Drivers of the rehearsal, as `codrive analyse` found them in a study (drivers.toml), in turn; numbers that are \
                     not in it are drawn",
                ),
        )
        .arg(
            Arg::new("population")
                .long("population")
                .value_name("NAME")
                .requires("rehearse")
                .conflicts_with("drivers")
                .help(
                    "Draw each participant of the rehearsal from this population: people (reaction, error, bias, time gap and \
                     compliance as in docs/references.md: drivers), perp or anyone",
                ),
        )
        .arg(
            Arg::new("plan")
                .long("plan")
                .action(ArgAction::SetTrue)
                .conflicts_with_all(["check", "rehearse", "exclude"])
                .help(
                    "Write a preregistration (Markdown) of the study and of its [analysis], with the power against the number of \
                     participants; to the file --out or the standard output",
                ),
        )
        .arg(
            Arg::new("rehearsed")
                .long("rehearsed")
                .value_name("DIR")
                .requires("plan")
                .value_parser(value_parser!(PathBuf))
                .help("Data set of a rehearsal (or pilot) whose deviations between and within participants the power takes"),
        )
        .arg(
            Arg::new("exclude")
                .long("exclude")
                .value_name("CODE")
                .requires("out")
                .requires("reason")
                .conflicts_with_all(["check", "rehearse", "participants", "participant"])
                .help(
                    "Exclude this participant's data from the study, also after the session; codrive analyse leaves them out, \
                     nothing is deleted",
                ),
        )
        .arg(
            Arg::new("reason")
                .long("reason")
                .value_name("TEXT")
                .requires("without")
                .value_parser(NonEmptyStringValueParser::new())
                .help("Why the data are excluded or erased; the data set keeps it, so write nothing that says who it is"),
        )
        .arg(
            Arg::new("erase")
                .long("erase")
                .value_name("CODE")
                .requires("out")
                .requires("reason")
                .conflicts_with_all(["check", "rehearse", "participants", "participant", "exclude"])
                .help(
                    "Erase everything of this participant for good: recordings, answers, log, rows of all tables, and all results of \
                     codrive analyse in the data set; erased.tsv keeps code, reason and time",
                ),
        )
        .arg(
            Arg::new("export")
                .long("export")
                .value_name("CODE")
                .requires("out")
                .requires("to")
                .conflicts_with_all(["check", "rehearse", "participants", "participant", "exclude", "erase"])
                .help("Copy everything of this participant to a folder, to be given to them; nothing of anybody else is in it"),
        )
        .arg(
            Arg::new("to")
                .long("to")
                .value_name("FOLDER")
                .requires("export")
                .value_parser(value_parser!(PathBuf))
                .help("Where the copy goes: a new or an empty folder outside of the data set"),
        )
        .group(ArgGroup::new("without").args(["exclude", "erase"]))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(PathBuf))
                .help("Folder of the data set (BIDS): a new one, or that of this study; nothing in it is overwritten"),
        )
        .arg(
            Arg::new("participants")
                .long("participants")
                .value_name("N")
                .value_parser(value_parser!(u32).range(1..=1000))
                .help("Number of participants, instead of the number in the file"),
        )
        .arg(
            Arg::new("schema")
                .long("schema")
                .action(ArgAction::SetTrue)
                .help("Print the JSON Schema of study files, for editors"),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    if matches.get_flag("schema") {
        out::line(format_args!("{:#}", Study::schema()))?;
        return Ok(());
    }
    let Some(file) = matches.get_one::<PathBuf>("file") else { return Ok(()) };
    let study = Study::load(file)?;
    let begun = matches.get_one::<PathBuf>("out").is_some_and(|root| root.exists());
    match study.check_ranges(&file.display().to_string()) {
        Err(fault) if begun => log::warn!("{fault}\n  The data set has begun with it, so it goes on."),
        checked => checked?,
    }
    let drivers = matches.get_one::<PathBuf>("drivers").map(|path| DriversFile::load(path)).transpose();
    let drivers = drivers.map_err(|why| CliError::Input(why.0))?.map_or(Vec::new(), |file| file.driver);
    if let Some(code) = matches.get_one::<String>("participant") {
        let root = matches.get_one::<PathBuf>("out").map_or(Path::new(""), PathBuf::as_path);
        let code = ParticipantCode::new(code).map_err(|error| CliError::Input(error.to_string()))?;
        return desktop::lead(study, code, root, matches);
    }
    if let (Some(code), Some(root)) = (matches.get_one::<String>("exclude"), matches.get_one::<PathBuf>("out")) {
        let reason = matches.get_one::<String>("reason").map_or("", String::as_str);
        return exclude(&study, code, root, reason);
    }
    if let (Some(code), Some(root)) = (matches.get_one::<String>("erase"), matches.get_one::<PathBuf>("out")) {
        let reason = matches.get_one::<String>("reason").map_or("", String::as_str);
        return erase(&study, code, root, reason);
    }
    if let [Some(root), Some(to)] = ["out", "to"].map(|name| matches.get_one::<PathBuf>(name))
        && let Some(code) = matches.get_one::<String>("export")
    {
        let (data, code) = there(&study, code, root)?;
        let files = data.export(&code, to).map_err(RunError::from)?;
        out::line(format_args!(
            "{}: {files} files, all that {} holds of participant {code}",
            to.display(),
            root.display()
        ))?;
        return Ok(());
    }
    let participants = matches.get_one::<u32>("participants").copied().unwrap_or(study.file.participants);
    if matches.get_flag("plan") {
        return plan(&study, participants as usize, matches);
    }
    match matches.get_one::<PathBuf>("out") {
        Some(root) if matches.get_flag("rehearse") => {
            let population = matches.get_one::<String>("population").map(|name| Population::named(name)).transpose();
            let population = population.map_err(|why| CliError::Input(why.to_string()))?.unwrap_or_default();
            rehearse(&study, root, participants as usize, drivers, population)
        }
        _ => {
            out::text(study.table(participants as usize))?;
            Ok(())
        }
    }
}

/// Opens the data set. Returns it with the checked participant code.
fn there(study: &Study, code: &str, root: &Path) -> Result<(DataSet, ParticipantCode), CliError> {
    let code = ParticipantCode::new(code).map_err(|error| CliError::Input(error.to_string()))?;
    if !root.exists() {
        return Err(CliError::Input(format!("{}: there is no such data set", root.display())));
    }
    Ok((DataSet::open(root, study).map_err(RunError::from)?, code))
}

fn erase(study: &Study, code: &str, root: &Path, reason: &str) -> Result<(), CliError> {
    let (data, code) = there(study, code, root)?;
    let left = data.erase(&code, reason, &recording_manifest::now()).map_err(RunError::from)?;
    out::line(format_args!(
        "{}: participant {code} erased, and all results of codrive analyse there (run it again); erased.tsv keeps code, reason and \
         time\n  not erased: copies, backups and results elsewhere",
        root.display()
    ))?;
    for folder in &left.others {
        out::line(format_args!(
            "  {}: of another program; what names {code} is gone, but its means and models may hold the data: make them again",
            folder.display()
        ))?;
    }
    for file in &left.naming {
        out::line(format_args!("  {}: still names {code}; take that out by hand", file.display()))?;
    }
    Ok(())
}

fn exclude(study: &Study, code: &str, root: &Path, reason: &str) -> Result<(), CliError> {
    let (data, code) = there(study, code, root)?;
    data.exclude(study, &code, reason, &recording_manifest::now()).map_err(RunError::from)?;
    let meaning = Completion::Excluded.meaning();
    out::line(format_args!("{}: participant {code} excluded: {meaning}", root.display()))?;
    Ok(())
}

fn rehearse(
    study: &Study,
    root: &Path,
    participants: usize,
    drivers: Vec<FittedDriver>,
    population: Population,
) -> Result<(), CliError> {
    let rehearsal = Rehearsal::open(study, root, participants)?.with_drivers(drivers).out_of(population);
    let bar = super::progress(rehearsal.ticks(), format!("{participants} participants"));
    let found = rehearsal.run(&stop_on_ctrl_c(), &|ticks| bar.inc(ticks));
    bar.finish_and_clear();
    let found = found?;
    out::line(format_args!(
        "{}: {} of {} participants completed the study",
        root.display(),
        found.complete,
        found.participants
    ))?;
    if found.stopped > 0 {
        out::line(format_args!(
            "{} of them stopped by a rule of the study (ends_if or stop_above): see participants.tsv",
            found.stopped
        ))?;
    }
    if found.complete < found.participants {
        return Err(CliError::Failed("stopped; all that was driven is kept: run the same command to resume".into()));
    }
    out::line(format_args!("look at it with: codrive analyse {}", root.display()))?;
    Ok(())
}

/// Writes the preregistration to `--out` or the standard output.
fn plan(study: &Study, participants: usize, matches: &ArgMatches) -> Result<(), CliError> {
    let spread = match matches.get_one::<PathBuf>("rehearsed") {
        Some(folder) => {
            let found = find(folder)?;
            let bar = super::progress(found.found.len() as u64, "drives".into());
            let drives = analyse(&found.found, &[], &|| bar.inc(1));
            bar.finish_and_clear();
            OutcomeSpread::rehearsed(study, &found.title, &drives?, &found.people)?
        }
        None => OutcomeSpread::Unknown,
    };
    let text = preregistration::text(study, participants, &spread)?;
    let period = study.file.order.period(study.conditions.len());
    if !participants.is_multiple_of(period) {
        log::warn!(
            "{participants} participants do not balance the orders, which repeat after {period}; with {} they do",
            participants.next_multiple_of(period)
        );
    }
    match matches.get_one::<PathBuf>("out") {
        Some(path) if path.exists() => Err(CliError::Input(format!(
            "{}: there is such a file already\n  remedy: name another one; a registered plan is not overwritten",
            path.display()
        ))),
        Some(path) => Ok(record::replace(path, text.as_bytes())?),
        None => out::text(text),
    }
}

impl From<PreregistrationError> for CliError {
    fn from(error: PreregistrationError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<StudyError> for CliError {
    fn from(error: StudyError) -> Self {
        Self::Input(error.0)
    }
}
