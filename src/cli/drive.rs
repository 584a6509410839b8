//! `codrive drive`: the window.

use super::{CliError, flags, stop_on_ctrl_c};
use crate::{
    app::{AppError, window},
    input::profiles,
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("drive")
        .about("Drive in a window (F1 lists the keys)")
        .arg(Arg::new("fullscreen").long("fullscreen").action(ArgAction::SetTrue).help("Fill the screen"))
        .arg(
            Arg::new("screen")
                .long("screen")
                .value_name("N|NAME")
                .help("Screen for the driver's picture: its number, from 1, or part of its name (HDMI)"),
        )
        .arg(
            Arg::new("experimenter")
                .long("experimenter")
                .action(ArgAction::SetTrue)
                .help("Open the experimenter's window beside the driver's, which then obeys driving keys only"),
        )
        .arg(Arg::new("panel").long("panel").action(ArgAction::SetTrue).help("Show the experimenter's panel at once"))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(PathBuf))
                .help("Record the drive there; a folder with a recording is refused"),
        )
        .arg(
            Arg::new("wheel")
                .long("wheel")
                .value_name("NAME|FILE.toml")
                .help("Profile of the steering wheel: one saved by codrive calibrate, or a shipped one; without it the one for the wheel that is found"),
        )
        .arg(
            Arg::new("paused").long("paused").action(ArgAction::SetTrue).help("Wait for Space before the drive begins"),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let wheel = matches.get_one::<String>("wheel").map(|name| profiles::named(name));
    let options = window::WindowOptions {
        wheel: wheel.transpose().map_err(|error| CliError::Input(error.to_string()))?,
        scenario: flags::scenario(matches)?,
        fullscreen: matches.get_flag("fullscreen"),
        screen: matches.get_one("screen").cloned(),
        panel: matches.get_flag("panel"),
        experimenter: matches.get_flag("experimenter"),
        paused: matches.get_flag("paused"),
        out: matches.get_one("out").cloned(),
        stop: stop_on_ctrl_c(),
    };
    window::run(options).map_err(|error: AppError| error.into())
}
