//! `codrive recover`: makes the tables of recordings that were cut.

use super::{CliError, out};
use crate::{
    record::{self, RecoveryReport},
    time::Tick,
};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("recover").about("Make tables of recordings that were cut by a crash or a power failure").arg(
        Arg::new("recording").value_name("DIR").required(true).num_args(1..).value_parser(value_parser!(PathBuf)).help(
            "Recordings to recover. Complete recordings and running drives are not changed. Unreadable parts move to \
             lost+found/ in the recording",
        ),
    )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    for folder in matches.get_many::<PathBuf>("recording").into_iter().flatten() {
        out::text(recovery_text(&folder.display().to_string(), &record::recover(folder)?))?;
    }
    Ok(())
}

/// Returns the findings as text: rows of each table, their time span, and missing rows.
fn recovery_text(name: &str, found: &RecoveryReport) -> String {
    let state = if found.was_whole { "is whole" } else { "recovered" };
    let rows = found.rows.iter().map(|(table, rows)| {
        let span = found.ticks.iter().find(|(of, _)| of == table).map(|(_, ticks)| ticks.map(Tick::seconds));
        let span = span.map_or(String::new(), |[from, to]| format!(" ({from:.2} to {to:.2} s)"));
        format!("{} {rows}{span}", table.name())
    });
    let mut text = format!("{name}: {state}; rows: {}\n", rows.collect::<Vec<_>>().join(", "));
    for hole in &found.missing {
        text += &format!("  could not be read: {hole}\n");
    }
    if let Some(kept) = &found.kept {
        text += &format!("  the journal is kept in {}; nothing was deleted\n", kept.display());
    }
    text
}
