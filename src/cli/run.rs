//! `codrive run`: a whole drive by a simulated driver, without a window, as fast as the machine can.

use super::{CliError, flags, stop_on_ctrl_c};
use crate::{app::offline, sim::Scenario};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::json;
use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

pub(super) fn command() -> Command {
    Command::new("run")
        .about("Run a drive by a simulated driver, without a window, at full speed")
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(PathBuf))
                .help("Write summary.json, scenario.toml and steps.csv there; a folder with a drive in it is refused"),
        )
        .arg(
            Arg::new("from")
                .long("from")
                .value_name("SECS")
                .default_value("0")
                .value_parser(value_parser!(f64))
                .help("Begin of the window that means are taken over; it lasts to the end of the drive"),
        )
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print the summary as JSON"))
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let scenario = flags::scenario(matches)?;
    let from_s = matches.get_one::<f64>("from").copied().unwrap_or_default();
    if scenario.duration_s <= 0.0 {
        return Err(CliError::Input("--duration is 0; a run without a window needs an end, for example 300".into()));
    }
    if !(0.0..scenario.duration_s).contains(&from_s) {
        let text = format!("--from is {from_s}; allowed: from 0 to below the duration of {} s", scenario.duration_s);
        return Err(CliError::Input(text));
    }
    let mut out = matches.get_one::<PathBuf>("out").map(|dir| Output::create(dir, &scenario)).transpose()?;
    let stop = stop_on_ctrl_c();
    let ticks = crate::time::Tick::at_seconds(scenario.duration_s).0;
    let bar = super::progress(ticks, format!("{} s on {}", scenario.duration_s, scenario.map));
    let mut run = offline::Run::new(&scenario, [from_s, scenario.duration_s])?;
    while !stop.load(Ordering::Relaxed) && run.world().ended().is_none() {
        run.step()?;
        if let Some(out) = &mut out {
            out.step(&run)?;
        }
        bar.set_position(run.world().snapshot().tick.0);
    }
    bar.finish_and_clear();
    let summary = run.summary();
    let report = json!({
        "program": concat!("codrive ", env!("CARGO_PKG_VERSION")),
        "traffic": run.world().traffic_engine(),
        "scenario": scenario,
        "summary": summary,
    });
    if let Some(out) = out {
        out.finish(&report)?;
    }
    if matches.get_flag("json") {
        println!("{report:#}");
    } else {
        print!("{}", run.words());
    }
    Ok(())
}

/// The folder that a run writes to.
struct Output {
    dir: PathBuf,
    steps: BufWriter<File>,
}

impl Output {
    /// Makes the folder and writes what is known before the drive. Nothing is ever overwritten.
    fn create(dir: &Path, scenario: &Scenario) -> Result<Self, CliError> {
        let fault = |e: std::io::Error, path: &Path| CliError::Failed(format!("{}: {e}", path.display()));
        fs::create_dir_all(dir).map_err(|e| fault(e, dir))?;
        let taken = ["scenario.toml", "steps.csv", "summary.json"].iter().find(|name| dir.join(name).exists());
        if let Some(name) = taken {
            let text = format!("{} holds a drive already ({name}); name another folder with --out", dir.display());
            return Err(CliError::Input(text));
        }
        let new = |name: &str| {
            let path = dir.join(name);
            File::create_new(&path).map_err(|e| fault(e, &path))
        };
        new("scenario.toml")?.write_all(scenario.to_toml().as_bytes()).map_err(|e| fault(e, dir))?;
        let mut steps = BufWriter::new(new("steps.csv")?);
        writeln!(steps, "{}", offline::STEP_COLUMNS).map_err(|e| fault(e, dir))?;
        Ok(Self { dir: dir.to_owned(), steps })
    }

    fn step(&mut self, run: &offline::Run) -> Result<(), CliError> {
        let written = writeln!(self.steps, "{}", run.step_row());
        written.map_err(|e| CliError::Failed(format!("{}: {e}", self.dir.join("steps.csv").display())))
    }

    fn finish(mut self, report: &serde_json::Value) -> Result<(), CliError> {
        let path = self.dir.join("summary.json");
        let mut write = || -> std::io::Result<()> {
            self.steps.flush()?;
            writeln!(File::create_new(&path)?, "{report:#}")
        };
        write().map_err(|e| CliError::Failed(format!("{}: {e}", path.display())))
    }
}
