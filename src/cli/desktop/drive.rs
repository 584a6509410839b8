//! `codrive drive`: a drive in a window.

use crate::cli::{CliError, flags, out, stop_on_ctrl_c};
use crate::{
    desktop::display::WindowPlacement, drive_window, hud, input::profiles, live_drive::lab::LabSettings, policy,
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("drive")
        .about("Drive in a window (F1 lists the keys)")
        .arg(Arg::new("fullscreen").long("fullscreen").action(ArgAction::SetTrue).help("Fill the screen; with \
            --experimenter this needs a second monitor"))
        .args(place_arguments())
        .arg(
            Arg::new("experimenter")
                .long("experimenter")
                .action(ArgAction::SetTrue)
                .help("Open the experimenter's window; the driver's window then accepts driving keys only"),
        )
        .arg(Arg::new("panel").long("panel").action(ArgAction::SetTrue).help("Show the experimenter's panel at once"))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(PathBuf))
                .help("Folder for a recording of the drive; drives after a restart go to DIR-2, DIR-3, ...; a folder \
                    with a recording is refused"),
        )
        .arg(
            Arg::new("wheel")
                .long("wheel")
                .value_name("NAME|FILE.toml")
                .help("Profile of the steering wheel: one saved by codrive calibrate, or a shipped one [default: the one for the wheel that is found]"),
        )
        .arg(led_argument())
        .args(lab_arguments())
        .arg(
            Arg::new("paused").long("paused").action(ArgAction::SetTrue).help("Wait for Space or Up before the drive \
                begins; drives without --out and --experimenter always wait"),
        )
}

/// Returns `--detection-led DIR`.
pub(super) fn led_argument() -> Arg {
    Arg::new("detection-led").long("detection-led").value_name("DIR").value_parser(value_parser!(PathBuf)).help(
        "LED for the signals of a detection response task with signal=remote-led, such as /sys/class/leds/NAME \
            [default: the wheel's rev lamps]",
    )
}

/// Returns the folder of `--detection-led`, which has to be an LED of the kernel.
pub(super) fn led(matches: &ArgMatches) -> Result<Option<PathBuf>, CliError> {
    let folder = matches.get_one::<PathBuf>("detection-led");
    match folder.filter(|folder| !folder.join("brightness").exists()) {
        Some(folder) => Err(CliError::Input(format!(
            "--detection-led {}: there is no file brightness, so this is no LED\n  remedy: a folder of /sys/class/leds",
            folder.display()
        ))),
        None => Ok(folder.cloned()),
    }
}

/// Returns the flags for lab devices: LSL streams and triggers.
fn lab_arguments() -> [Arg; 3] {
    let outlets = Arg::new("lsl")
        .long("lsl")
        .action(ArgAction::SetTrue)
        .help("Send advice, events, controls, the vehicle's state and frames as streams of the Lab Streaming Layer");
    let record = Arg::new("lsl-record")
        .long("lsl-record")
        .value_name("PREDICATE")
        .action(ArgAction::Append)
        .requires("out")
        .help(
            "Predicate of an LSL stream to record with the drive, such as \"type='EEG'\"; may be given several times",
        );
    let lab = Arg::new("lab")
        .long("lab")
        .value_name("FILE.toml")
        .value_parser(value_parser!(PathBuf))
        .help("File with LSL streams and triggers: tables [lsl] and [triggers], as in a study file");
    [outlets, record, lab]
}

fn lab(matches: &ArgMatches) -> Result<LabSettings, CliError> {
    let file = matches.get_one::<PathBuf>("lab").map(|path| LabSettings::load(path)).transpose();
    let mut lab = file.map_err(|error| CliError::Input(error.to_string()))?.unwrap_or_default();
    lab.lsl.outlets |= matches.get_flag("lsl");
    lab.lsl.record.extend(matches.get_many::<String>("lsl-record").into_iter().flatten().cloned());
    lab.check().map_err(|error| CliError::Input(error.to_string()))?;
    Ok(lab)
}

/// Returns `--monitor N`, `--refresh HZ` and `--task-monitor N`.
pub(super) fn place_arguments() -> [Arg; 3] {
    let monitor = Arg::new("monitor")
        .long("monitor")
        .value_name("N")
        .value_parser(value_parser!(u64).range(1..=64))
        .help("Monitor of the window, from 1 as codrive doctor lists them");
    let refresh = Arg::new("refresh")
        .long("refresh")
        .value_name("HZ")
        .value_parser(value_parser!(f64))
        .help("Refresh rate of the monitor, one of the rates that codrive doctor lists; needs --fullscreen");
    let task = Arg::new("task-monitor")
        .long("task-monitor")
        .value_name("N")
        .value_parser(value_parser!(u64).range(1..=64))
        .help("Monitor of the window of a secondary task with display=window; with --fullscreen the window fills it [default: one that \
            does not show the driver's window]");
    [monitor, refresh, task]
}

/// Returns the placement of the window.
pub(super) fn place(matches: &ArgMatches, fullscreen: bool) -> Result<WindowPlacement, CliError> {
    let refresh_hz = matches.get_one::<f64>("refresh").copied();
    if refresh_hz.is_some() && !fullscreen {
        return Err(CliError::Input(
            "--refresh needs --fullscreen: a window cannot set the refresh rate of its screen".into(),
        ));
    }
    Ok(WindowPlacement { monitor: monitor(matches, "monitor"), fullscreen, refresh_hz })
}

/// Returns the placement of a secondary task's window.
pub(super) fn task_place(matches: &ArgMatches, fullscreen: bool) -> WindowPlacement {
    let monitor = monitor(matches, "task-monitor");
    WindowPlacement { monitor, fullscreen: fullscreen && monitor.is_some(), refresh_hz: None }
}

fn monitor(matches: &ArgMatches, flag: &str) -> Option<usize> {
    matches.get_one::<u64>(flag).and_then(|number| usize::try_from(*number).ok())
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let wheel = matches.get_one::<String>("wheel").map(|name| profiles::named(name));
    let scenario = flags::scenario(matches)?;
    if scenario.policy != policy::NAMES[0] {
        hud::check_range(&scenario).map_err(|fault| CliError::Input(fault.to_string()))?;
    }
    let options = drive_window::WindowOptions {
        wheel: wheel.transpose().map_err(|error| CliError::Input(error.to_string()))?,
        led: led(matches)?,
        lab: lab(matches)?,
        scenario,
        place: place(matches, matches.get_flag("fullscreen"))?,
        task_place: task_place(matches, matches.get_flag("fullscreen")),
        panel: matches.get_flag("panel"),
        experimenter: matches.get_flag("experimenter"),
        paused: matches.get_flag("paused"),
        out: matches.get_one("out").cloned(),
        stop: stop_on_ctrl_c(),
    };
    let (words, ended) = drive_window::run(options)?;
    let printed = out::text(words);
    ended?;
    printed
}
