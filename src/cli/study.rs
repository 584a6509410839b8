//! `codrive study`: the steps of a study, one subcommand each: check, rehearse, preregister, lead a participant, and exclude, export or
//! erase one participant's data. In: arguments. Out: text, a data set.

use super::{CliError, desktop::session, evaluate::report::put_figure, out, progress::progress, stop_on_ctrl_c};
use crate::{
    analysis::{analyse, find},
    drive_loop::{RunError, recording_manifest, rehearsal::Rehearsal},
    driver::{DriversFile, Population},
    record,
    scenario::{PlannedDrive, event_chart},
    study::{
        Completion, DataSet, ParticipantCode, PlanItem, Study, StudyError,
        preregistration::{self, OutcomeSpread, PreregistrationError},
    },
};
use clap::{Arg, ArgMatches, Command, builder::NonEmptyStringValueParser, value_parser};
use std::path::{Path, PathBuf};

pub(super) fn command() -> Command {
    Command::new("study")
        .about("Carry out a study, from its check and rehearsal to its participants' data")
        .subcommand_required(true)
        .subcommand(check_command())
        .subcommand(rehearse_command())
        .subcommand(preregister_command())
        .subcommand(session::command())
        .subcommand(exclude_command())
        .subcommand(export_command())
        .subcommand(erase_command())
}

fn check_command() -> Command {
    Command::new("check")
        .about("Check every scenario and questionnaire, and print each participant's order of conditions")
        .after_help(
            "Example: codrive study check assets/studies/congestion.toml\n\
             Example: codrive study check assets/studies/lead-braking.toml --pictures events/",
        )
        .args([file(), participants()])
        .arg(path_flag(
            "pictures",
            "DIR",
            "Draw the events of each drive there, as SVG and PNG: a timeline, and the route with the places of triggers",
        ))
}

fn rehearse_command() -> Command {
    Command::new("rehearse")
        .about("Take simulated participants through the whole plan at full speed")
        .after_help(
            "The rehearsal includes questions and baselines. Ctrl-C stops it; run the same command to resume.\n\n\
             Example: codrive study rehearse assets/studies/congestion.toml --population people --participants 6 --out \
             rehearsed/",
        )
        .args([file(), data_set(), participants()])
        .arg(path_flag(
            "drivers",
            "FILE.toml",
            "Drivers from an analysed study (drivers.toml of `codrive analyse`), used in turn; missing parameters are \
             drawn",
        ))
        .arg(Arg::new("population").long("population").value_name("NAME").conflicts_with("drivers").help(
            "Draw each participant from this population: people (reaction, error, bias, time gap and compliance as in \
             docs/references.md: drivers), perp or anyone",
        ))
}

fn preregister_command() -> Command {
    Command::new("preregister")
        .about("Write a preregistration (Markdown), with the power for several numbers of participants")
        .after_help("Example: codrive study preregister my.toml --rehearsed rehearsed/ --out plan.md")
        .args([file(), participants()])
        .arg(path_flag(
            "rehearsed",
            "DIR",
            "Data set of a rehearsal or pilot: source of the standard deviations between and within participants for \
             the power",
        ))
        .arg(path_flag(
            "out",
            "FILE.md",
            "File to write; an existing file is not overwritten [default: the standard output]",
        ))
}

fn exclude_command() -> Command {
    Command::new("exclude")
        .about("Leave a participant's data out of the analysis; nothing is deleted")
        .after_help(
            "Close the windows of the session first. The session may be unfinished.\n\n\
             Example: codrive study exclude my.toml P03 --from data/ --reason \"fell asleep\"",
        )
        .args([file(), participant(), from(), reason()])
}

fn export_command() -> Command {
    Command::new("export")
        .about("Copy all data of a participant to a folder, for the participant")
        .after_help("Example: codrive study export my.toml P03 --from data/ --to p03/")
        .args([file(), participant(), from()])
        .arg(path_flag("to", "FOLDER", "Folder of the copy: a new or empty folder outside the data set").required(true))
}

fn erase_command() -> Command {
    Command::new("erase")
        .about("Erase all data of a participant for good")
        .after_help(
            "Erased: recordings, answers, log, rows of all tables, and all results of codrive analyse in the data \
             set.\n\
             Kept: code, reason and time, in erased.tsv.\n\n\
             Example: codrive study erase my.toml P03 --from data/ --reason \"asked for it on 3 May\"",
        )
        .args([file(), participant(), from(), reason()])
}

pub(super) fn file() -> Arg {
    Arg::new("file")
        .value_name("FILE.toml")
        .required(true)
        .value_parser(value_parser!(PathBuf))
        .help("The study, for example assets/studies/congestion.toml")
}

pub(super) fn participant() -> Arg {
    Arg::new("participant")
        .value_name("CODE")
        .required(true)
        .help("The participant's code, for example P03: letters and digits, never a name")
}

/// Returns `--out`: the data set that a session or a rehearsal begins or continues.
pub(super) fn data_set() -> Arg {
    let help =
        "Folder of the data set (BIDS): a new folder, or the data set of this study; nothing in it is overwritten";
    path_flag("out", "DIR", help).required(true)
}

/// Returns `--from`: the data set that has the participant's data.
fn from() -> Arg {
    path_flag("from", "DIR", "Folder of the study's data set").required(true)
}

fn path_flag(name: &'static str, value_name: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).value_name(value_name).value_parser(value_parser!(PathBuf)).help(help)
}

fn reason() -> Arg {
    Arg::new("reason")
        .long("reason")
        .value_name("TEXT")
        .required(true)
        .value_parser(NonEmptyStringValueParser::new())
        .help("Reason. The data set keeps it, so write nothing that identifies the participant")
}

fn participants() -> Arg {
    Arg::new("participants")
        .long("participants")
        .value_name("N")
        .value_parser(value_parser!(u32).range(1..=1000))
        .help("Number of participants, instead of the number in the file")
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    match matches.subcommand() {
        Some(("check", m)) => check(m),
        Some(("rehearse", m)) => rehearse(m),
        Some(("preregister", m)) => preregister(m),
        Some(("session", m)) => session::main(m),
        Some(("exclude", m)) => exclude(m),
        Some(("export", m)) => export(m),
        Some(("erase", m)) => erase(m),
        _ => unreachable!("clap requires a subcommand"),
    }
}

/// Returns the path that a required argument names.
pub(super) fn path<'a>(matches: &'a ArgMatches, name: &str) -> &'a Path {
    matches.get_one::<PathBuf>(name).map_or(Path::new(""), PathBuf::as_path)
}

/// Reads the study. A fault in its ranges is a warning if the data set has begun.
pub(super) fn load(matches: &ArgMatches, data: Option<&Path>) -> Result<Study, CliError> {
    let file = path(matches, "file");
    let study = Study::load(file)?;
    match study.check_ranges(&file.display().to_string()) {
        Err(fault) if data.is_some_and(Path::exists) => {
            log::warn!("{fault}\n  The data set was begun with this study, so the session continues.");
        }
        checked => checked?,
    }
    for (key, placeholder) in study.file.texts.without_controls() {
        log::warn!(
            "{}: texts.{key} names no control, so it does not name the keys of a keyboard\n  remedy: write {placeholder} where \
             it names a pedal",
            file.display()
        );
    }
    Ok(study)
}

pub(super) fn code(matches: &ArgMatches) -> Result<ParticipantCode, CliError> {
    let code = matches.get_one::<String>("participant").map_or("", String::as_str);
    ParticipantCode::new(code).map_err(|error| CliError::Input(error.to_string()))
}

/// Returns the number of participants: `--participants`, or the number in the file.
fn participant_count(study: &Study, matches: &ArgMatches) -> usize {
    matches.get_one::<u32>("participants").copied().unwrap_or(study.file.participants) as usize
}

fn check(matches: &ArgMatches) -> Result<(), CliError> {
    let study = load(matches, None)?;
    out::text(study.table(participant_count(&study, matches)))?;
    let Some(folder) = matches.get_one::<PathBuf>("pictures") else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|error| CliError::Failed(format!("{}: {error}", folder.display())))?;
    let mut drawn = 0;
    for planned in study.plan(0).items {
        let PlanItem::Drive { scenario, .. } = planned.item else { continue };
        let drive = PlannedDrive::new(&scenario).map_err(|error| CliError::Input(error.to_string()))?;
        let Some(svg) = event_chart(&drive) else { continue };
        put_figure(folder, &format!("events-{}.svg", planned.name), &svg)?;
        drawn += 1;
    }
    out::line(format_args!("\n{}: events of {drawn} drives of the first participant, as SVG and PNG", folder.display()))
}

/// Opens the data set of `--from`. Returns it with the study and the participant's code.
fn existing(matches: &ArgMatches) -> Result<(Study, DataSet, ParticipantCode), CliError> {
    let root = path(matches, "from");
    let study = load(matches, Some(root))?;
    let code = code(matches)?;
    if !root.exists() {
        return Err(CliError::Input(format!("{}: the data set does not exist", root.display())));
    }
    let data = DataSet::open(root, &study).map_err(RunError::from)?;
    Ok((study, data, code))
}

fn given_reason(matches: &ArgMatches) -> &str {
    matches.get_one::<String>("reason").map_or("", String::as_str)
}

fn export(matches: &ArgMatches) -> Result<(), CliError> {
    let (_, data, code) = existing(matches)?;
    let to = path(matches, "to");
    let files = data.export(&code, to).map_err(RunError::from)?;
    out::line(format_args!(
        "{}: {files} files, all that {} holds of participant {code}",
        to.display(),
        data.root().display()
    ))
}

fn erase(matches: &ArgMatches) -> Result<(), CliError> {
    let (_, data, code) = existing(matches)?;
    let left = data.erase(&code, given_reason(matches), &recording_manifest::now()).map_err(RunError::from)?;
    out::line(format_args!(
        "{}: participant {code} and all results of codrive analyse there are erased (run codrive analyse again); \
         erased.tsv keeps code, reason and time\n  not erased: copies, backups and results elsewhere",
        data.root().display()
    ))?;
    for folder in &left.others {
        out::line(format_args!(
            "  {}: made by another program. Parts that name {code} are erased, but means and models may include the \
             data: make them again",
            folder.display()
        ))?;
    }
    for file in &left.naming {
        out::line(format_args!("  {}: still names {code}; remove that by hand", file.display()))?;
    }
    Ok(())
}

fn exclude(matches: &ArgMatches) -> Result<(), CliError> {
    let (study, data, code) = existing(matches)?;
    data.exclude(&study, &code, given_reason(matches), &recording_manifest::now()).map_err(RunError::from)?;
    let meaning = Completion::Excluded.meaning();
    out::line(format_args!("{}: participant {code} excluded: {meaning}", data.root().display()))
}

fn rehearse(matches: &ArgMatches) -> Result<(), CliError> {
    let root = path(matches, "out");
    let study = load(matches, Some(root))?;
    let drivers = matches.get_one::<PathBuf>("drivers").map(|path| DriversFile::load(path)).transpose();
    let drivers = drivers.map_err(|why| CliError::Input(why.0))?.map_or(Vec::new(), |file| file.driver);
    let population = matches.get_one::<String>("population").map(|name| Population::named(name)).transpose();
    let population = population.map_err(|why| CliError::Input(why.to_string()))?.unwrap_or_default();
    let participants = participant_count(&study, matches);
    let rehearsal = Rehearsal::open(&study, root, participants)?.with_drivers(drivers).out_of(population);
    let bar = progress(rehearsal.ticks(), format!("{participants} participants"));
    let found = rehearsal.run(&stop_on_ctrl_c(), &|ticks| bar.inc(ticks));
    bar.finish_and_clear();
    let found = found?;
    out::line(format_args!(
        "{}: {} of {} participants completed the study",
        root.display(),
        found.complete - found.stopped,
        found.participants
    ))?;
    if found.stopped > 0 {
        out::line(format_args!(
            "stopped by a rule of the study (ends_if or stop_above): {} participants, see participants.tsv",
            found.stopped
        ))?;
    }
    if found.complete < found.participants {
        return Err(CliError::Failed("stopped; all drives so far are kept: run the same command to resume".into()));
    }
    out::line(format_args!("look at it with: codrive analyse {}", root.display()))?;
    Ok(())
}

/// Writes the preregistration to `--out` or the standard output.
fn preregister(matches: &ArgMatches) -> Result<(), CliError> {
    let study = load(matches, None)?;
    let participants = participant_count(&study, matches);
    let spread = match matches.get_one::<PathBuf>("rehearsed") {
        Some(folder) => {
            let found = find(folder)?;
            let bar = progress(found.found.len() as u64, "drives".into());
            let drives = analyse(&found.found, &[], &|| bar.inc(1));
            bar.finish_and_clear();
            OutcomeSpread::rehearsed(&study, &found.title, &drives?, &found.people)?
        }
        None => OutcomeSpread::Unknown,
    };
    let bar = progress(1, "simulated studies for the power".into());
    let row_done = |rows| {
        bar.set_length(rows);
        bar.inc(1);
    };
    let text = preregistration::text(&study, participants, &spread, &row_done);
    bar.finish_and_clear();
    let text = text?;
    let period = study.file.order.period(study.conditions.len());
    if !participants.is_multiple_of(period) {
        log::warn!(
            "{participants} participants do not balance the orders, which repeat after {period}; {} participants do",
            participants.next_multiple_of(period)
        );
    }
    match matches.get_one::<PathBuf>("out") {
        Some(path) if path.exists() => Err(CliError::Input(format!(
            "{}: the file exists\n  remedy: name another file; a registered plan is not overwritten",
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
