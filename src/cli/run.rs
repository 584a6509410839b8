//! `codrive run`: a whole drive by a simulated driver, without a window, at full speed.

use super::{CliError, flags, out, progress::progress, stop_on_ctrl_c};
use crate::drive_loop::offline;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::json;
use std::{path::PathBuf, sync::atomic::Ordering};

pub(super) fn command() -> Command {
    Command::new("run")
        .about("Run a drive by a simulated driver, without a window, at full speed")
        .arg(Arg::new("out").long("out").value_name("DIR").value_parser(value_parser!(PathBuf)).help(
            "Folder for a recording of the drive (tables as Parquet, manifest, summary); a folder with a recording is \
             refused",
        ))
        .arg(
            Arg::new("window-from")
                .long("window-from")
                .value_name("SECS")
                .default_value("0")
                .value_parser(value_parser!(f64))
                .help("Start of the time window for means; the window lasts to the end of the drive"),
        )
        .arg(
            Arg::new("real-time")
                .long("real-time")
                .action(ArgAction::SetTrue)
                .help("Run in real time, like a drive by a person"),
        )
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print the summary as JSON"))
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let scenario = flags::scenario(matches)?;
    let from_s = matches.get_one::<f64>("window-from").copied().unwrap_or_default();
    if scenario.duration_s <= 0.0 && scenario.traffic.log_file().is_none() {
        return Err(CliError::Input("--duration is 0; a run without a window needs an end, for example 300".into()));
    }
    let drive = flags::planned(matches, &scenario)?;
    let scenario = drive.scenario().clone();
    if !(0.0..scenario.duration_s).contains(&from_s) {
        let text =
            format!("--window-from is {from_s}; allowed: from 0 to below the duration of {} s", scenario.duration_s);
        return Err(CliError::Input(text));
    }
    let stop = stop_on_ctrl_c();
    let ticks = crate::time::Tick::at_seconds(scenario.duration_s).0;
    let bar = progress(ticks, format!("{} s on {}", scenario.duration_s, scenario.map));
    let mut run = offline::OfflineDrive::of(drive, [from_s, scenario.duration_s])?;
    if let Some(folder) = matches.get_one::<PathBuf>("out") {
        run.record(folder)?;
    }
    while !stop.load(Ordering::Relaxed) && run.world().ended().is_none() {
        match run.step() {
            Err(error) if error.is_interruption() => break,
            other => other?,
        }
        if matches.get_flag("real-time") {
            run.keep_time();
        }
        bar.set_position(run.world().snapshot().tick.0);
    }
    run.finish_recording()?;
    bar.finish_and_clear();
    let summary = run.summary();
    let report = json!({
        "program": concat!("codrive ", env!("CARGO_PKG_VERSION")),
        "traffic": run.world().traffic_engine(),
        "scenario": scenario,
        "policy": { "name": run.world().policy().name, "why": run.world().policy().why },
        "advised": run.advised(),
        "summary": summary,
    });
    if matches.get_flag("json") {
        out::line(format_args!("{report:#}"))?;
    } else {
        out::text(run.summary_text())?;
    }
    Ok(())
}
