//! `codrive replay`: drives a recording again and proves that it is the same, or drives it with changes. Pictures and sound are
//! the desktop's part.

use super::{CliError, desktop::replay as desktop, out, progress::progress, stop_on_ctrl_c};
use crate::{
    record::{self, LOST_AND_FOUND, Table},
    replay::{self, Replay, ReplayReport, evidence},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::{
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

/// Help text on the proof.
const PROOF: &str = "Every column of every table of the drive is compared bit by bit.\n\
    Every value of manifest.json and summary.json that follows from the drive is compared, too.\n\
    Every other file is compared by its SHA-256. A table names the kind of proof of each file.\n\
    The exit code is 1 if anything differs, or if the recording has no tick.\n\n\
    Checksums prove consistency, not authenticity: a person who changes a file can write new checksums.\n\
    A signature proves authenticity: codrive sign DIR --key lab-key, then codrive replay DIR --signer lab-key.pub.";

pub(super) fn command() -> Command {
    let path =
        |name, value, help| Arg::new(name).long(name).value_name(value).value_parser(value_parser!(PathBuf)).help(help);
    Command::new("replay")
        .about(desktop::ABOUT)
        .after_help(format!("{PROOF}{}", desktop::DRAWS))
        .arg(
            Arg::new("recording")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("A recording"),
        )
        .arg(Arg::new("what-if").long("what-if").value_name("SETTING=VALUE").action(ArgAction::Append).help(
            "Drive the same seed and scenario by a simulated driver with this setting changed, and print the \
             differences: policy=NAME, driver=perfect, hold_s=5; none: no advice, driven by the car-following model. \
             May be given several times",
        ))
        .arg(path("out", "DIR", "Folder of the recording of --what-if [default: DIR-what-if-... beside the recording]"))
        .arg(super::sign::signer_argument())
        .args(desktop::arguments())
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let path = |name: &str| matches.get_one::<PathBuf>(name);
    let Some(recording) = path("recording") else { return Ok(()) };
    if let Some(asked) = matches.get_many::<String>("what-if") {
        return instead(recording, &asked.cloned().collect::<Vec<_>>(), path("out"));
    }
    if let Some(played) = desktop::play(recording, matches) {
        let (found, all) = played?;
        return print_report(recording, &found, all, matches);
    }
    let mut replay = Replay::open(recording)?;
    let mut outputs = desktop::Outputs::begin(recording, &replay, matches)?;
    let stop = stop_on_ctrl_c();
    let bar = progress(replay.len(), "driving again".into());
    while !replay.over() && !stop.load(Ordering::Relaxed) {
        replay.advance(1)?;
        outputs.tick(&replay)?;
        bar.set_position(replay.world().snapshot().tick.0);
    }
    bar.finish_and_clear();
    outputs.end(&replay)?;
    print_report(recording, replay.report(), replay.len(), matches)
}

/// Prints the result of the proof.
fn print_report(recording: &Path, found: &ReplayReport, all: u64, matches: &ArgMatches) -> Result<(), CliError> {
    let (name, ticks) = (recording.display(), found.ticks);
    if !found.is_proven() {
        return Err(CliError::Failed(fault(recording, found)));
    }
    if ticks < all {
        let driven = format!("{name}: {ticks} of {all} ticks were driven again, and all are the same to the bit");
        return out::line(format_args!("{driven}; results of the whole drive were not compared"));
    }
    out::text(evidence::table(&found.files))?;
    out::line(format_args!("{name}: all {all} ticks are the same to the bit; every file agrees with its checksum"))?;
    out::line(format_args!("{}", super::sign::signature(recording, matches)?))
}

/// Lists the differences from the recording, one a line.
fn fault(recording: &Path, found: &ReplayReport) -> String {
    let name = recording.display();
    let mut lines = vec![format!("{name}: differs from the recording")];
    if found.is_empty {
        lines =
            vec![format!("{name}: nothing was compared: ego.parquet has no tick, so there is nothing to drive again")];
    }
    lines.extend(found.difference.as_ref().map(|first| format!("first difference: {first}")));
    if found.cells > 1 {
        lines.push(format!("cells and rows that differ: {} in {} ticks", found.cells, found.ticks));
    }
    lines.extend(found.hole.map(|tick| format!("ego.parquet: rows are missing from {:.2} s on", tick.seconds())));
    lines.extend(found.facts.iter().map(ToString::to_string));
    lines.extend(found.changes.iter().map(ToString::to_string));
    if recording.join(LOST_AND_FOUND).exists() {
        lines.push(format!(
            "some rows could not be read during the recovery: {LOST_AND_FOUND}/ in the recording holds their data"
        ));
    } else if found.changes.is_empty() && !found.is_empty {
        lines.push(
            "All files agree with their checksums. Possible causes: another version of the program or of SUMO, another \
             map, or checksums that a person wrote again; compare manifest.json"
                .into(),
        );
    }
    lines.join("\n  ")
}

/// Drives the recorded scenario with changes and prints the differences.
fn instead(recording: &Path, asked: &[String], out: Option<&PathBuf>) -> Result<(), CliError> {
    let changes = replay::changes(asked).map_err(|e| CliError::Input(e.to_string()))?;
    let words = replay::changes_text(&changes);
    let beside = || {
        let slug: String = words.chars().map(|c| if c.is_alphanumeric() || c == '.' { c } else { '-' }).collect();
        let mut name = recording.file_name().unwrap_or_default().to_owned();
        name.push(format!("-what-if-{}", slug.replace("--", "-")));
        recording.with_file_name(name)
    };
    let out = out.cloned().unwrap_or_else(beside);
    let stop = stop_on_ctrl_c();
    let ticks = record::count(recording, Table::Ego).unwrap_or(0);
    let bar = progress(2 * ticks, format!("what if {words}"));
    let pair = replay::what_if(recording, &changes, &out, &stop, &|ticks| bar.inc(ticks));
    bar.finish_and_clear();
    let Some(pair) = pair? else {
        return Err(CliError::Failed(format!("stopped; {} holds the drive up to here", out.display())));
    };
    out::line(format_args!("{}, instead with {words}", recording.display()))?;
    if asked.iter().any(|word| word == "none") {
        out::line(format_args!("none means both: no advice, and the car-following model instead of the driver"))?;
    }
    if !pair.is_proven {
        out::line(format_args!(
            "the recorded drive could not be reproduced to the bit; codrive replay {} lists the differences",
            recording.display()
        ))?;
    }
    out::text(pair.table())?;
    out::line(format_args!("recorded in              {}", out.display()))?;
    Ok(())
}
