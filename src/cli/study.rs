//! `codrive study`: a whole study from one file.

use super::CliError;
use crate::study::{Study, StudyError};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("study")
        .about("Check a study and print its plan")
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
            Arg::new("participants")
                .long("participants")
                .value_name("N")
                .value_parser(value_parser!(u32).range(1..=1000))
                .help("Plan for so many people instead of those in the file"),
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
    print!("{}", study.table(participants as usize));
    Ok(())
}

impl From<StudyError> for CliError {
    fn from(error: StudyError) -> Self {
        Self::Input(error.0)
    }
}
