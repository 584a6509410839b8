//! `codrive study`: a whole study from one file: its plan, or a rehearsal of it.

use super::{CliError, stop_on_ctrl_c};
use crate::{
    app::rehearsal::Rehearsal,
    study::{Study, StudyError},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::{Path, PathBuf};

pub(super) fn command() -> Command {
    Command::new("study")
        .about("Check a study and print its plan, or rehearse it with simulated participants")
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
                .help("Check every scenario and questionnaire in it and print who meets which condition when"),
        )
        .arg(
            Arg::new("rehearse").long("rehearse").action(ArgAction::SetTrue).requires("out").conflicts_with("check").help(
                "Take simulated participants through the whole plan at full speed, questions and baselines included; \
                 Ctrl-C stops it, the same command goes on",
            ),
        )
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
                .help("So many people instead of those in the file"),
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
        println!("{:#}", Study::schema());
        return Ok(());
    }
    let Some(file) = matches.get_one::<PathBuf>("file") else { return Ok(()) };
    let study = Study::load(file)?;
    let participants = matches.get_one::<u32>("participants").copied().unwrap_or(study.file.participants);
    match matches.get_one::<PathBuf>("out") {
        Some(root) if matches.get_flag("rehearse") => rehearse(&study, root, participants as usize),
        _ => {
            print!("{}", study.table(participants as usize));
            Ok(())
        }
    }
}

fn rehearse(study: &Study, root: &Path, participants: usize) -> Result<(), CliError> {
    let rehearsal = Rehearsal::open(study, root, participants)?;
    let bar = super::progress(rehearsal.ticks(), format!("{participants} participants"));
    let found = rehearsal.run(&stop_on_ctrl_c(), &|ticks| bar.inc(ticks));
    bar.finish_and_clear();
    let found = found?;
    println!("{}: {} of {} participants are through the study", root.display(), found.complete, found.participants);
    if found.complete < found.participants {
        return Err(CliError::Failed("stopped; all that was driven is kept, the same command goes on".into()));
    }
    println!("look at it with: codrive analyse {}", root.display());
    Ok(())
}

impl From<StudyError> for CliError {
    fn from(error: StudyError) -> Self {
        Self::Input(error.0)
    }
}
