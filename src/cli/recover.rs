//! `codrive recover`: tables of a recording that was cut.

use super::CliError;
use crate::record;
use clap::{Arg, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("recover").about("Make tables of recordings that were cut by a crash or a power failure").arg(
        Arg::new("recording")
            .value_name("DIR")
            .required(true)
            .num_args(1..)
            .value_parser(value_parser!(PathBuf))
            .help("Recordings; one that is whole stays as it is"),
    )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    for folder in matches.get_many::<PathBuf>("recording").into_iter().flatten() {
        let found = record::recover(folder)?;
        let rows: Vec<String> = found.rows.iter().map(|(table, n)| format!("{} {n}", table.name())).collect();
        let state = if found.was_whole { "is whole" } else { "recovered" };
        println!("{}: {state}; rows: {}", folder.display(), rows.join(", "));
    }
    Ok(())
}
