//! `codrive doctor`: checks whether this rig is fit for a study, and prints the findings on one page.

use super::drive;
use crate::cli::{CliError, flags, out};
use crate::{
    desktop::display,
    doctor::{self, DoctorOptions, FindingGrade},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("doctor")
        .about("Check this rig: graphics, wheel, force, sound, SUMO, disk, clock, power; exit 1 on a fault")
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print as JSON, for a manifest"))
        .arg(
            Arg::new("display")
                .long("display")
                .action(ArgAction::SetTrue)
                .help("Show a ruler and a circle on the screen instead, for a check with a tape measure; Esc ends"),
        )
        .args(drive::place_arguments())
        .arg(
            Arg::new("size")
                .long("size")
                .value_name("WxH")
                .default_value("1920x1080")
                .value_parser(size)
                .help("Size of the measured picture, pixels"),
        )
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .default_value(".")
                .value_parser(value_parser!(PathBuf))
                .help("Folder of the recordings; its disk is checked"),
        )
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides
        .filter(|sides: &[u32; 2]| sides.iter().all(|side| (16..=8192).contains(side)))
        .ok_or_else(|| "allowed: WIDTHxHEIGHT, each from 16 to 8192".into())
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let scenario = flags::scenario(matches)?;
    if matches.get_flag("display") {
        return Ok(display::check(&scenario, drive::place(matches, true)?)?);
    }
    let options = DoctorOptions {
        monitors: display::monitors().map_err(Into::into),
        scenario,
        size: matches.get_one("size").copied().unwrap_or([1920, 1080]),
        recordings: matches.get_one("out").cloned().unwrap_or_default(),
    };
    let lines = doctor::examine(&options);
    if matches.get_flag("json") {
        out::line(format_args!("{:#}", doctor::json(&lines)))?;
    } else {
        out::text(doctor::text(&lines))?;
    }
    match lines.iter().filter(|line| line.grade == FindingGrade::Fault).count() {
        0 => Ok(()),
        1 => Err(CliError::Failed("this rig has a fault; its line names the remedy".into())),
        n => Err(CliError::Failed(format!("this rig has {n} faults; their lines name the remedies"))),
    }
}
