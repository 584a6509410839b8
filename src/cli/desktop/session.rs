//! `codrive study session`: leads a participant through a study, in windows.

use super::drive::{led, led_argument, place, place_arguments, task_place};
use crate::{
    cli::{CliError, out, stop_on_ctrl_c, study as arguments},
    input::profiles,
    session::window::{self, SessionOptions, SessionOutcome},
};
use clap::{Arg, ArgAction, ArgMatches, Command};

pub(in crate::cli) fn command() -> Command {
    Command::new("session")
        .about("Lead a participant through the study, in a window for them and one for the experimenter")
        .after_help(
            "After a closed window or a crash, run the same command to resume.\n\nExample: codrive study session \
             assets/studies/congestion.toml P03 --out data/ --fullscreen --monitor 2",
        )
        .args([arguments::file(), arguments::participant(), arguments::data_set()])
        .arg(Arg::new("fullscreen").long("fullscreen").action(ArgAction::SetTrue).help("Fill the participant's screen"))
        .args(place_arguments())
        .arg(
            Arg::new("wheel")
                .long("wheel")
                .value_name("NAME|FILE.toml")
                .help("Profile of the steering wheel, as in codrive drive"),
        )
        .arg(led_argument())
}

/// Leads a participant through the study and prints where it ended.
pub(in crate::cli) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let root = arguments::path(matches, "out");
    let study = arguments::load(matches, Some(root))?;
    let code = arguments::code(matches)?;
    let wheel = matches.get_one::<String>("wheel").map(|name| profiles::named(name)).transpose();
    let left = window::run(SessionOptions {
        study,
        out: root.into(),
        code: code.clone(),
        place: place(matches, matches.get_flag("fullscreen"))?,
        task_place: task_place(matches, matches.get_flag("fullscreen")),
        wheel: wheel.map_err(|error| CliError::Input(error.to_string()))?,
        led: led(matches)?,
        stop: stop_on_ctrl_c(),
    })?;
    let state = match left {
        SessionOutcome::Over(completion) => format!("{}: {}", completion, completion.meaning()),
        SessionOutcome::Open(item) => format!("is at {item}: run the same command to resume"),
    };
    out::line(format_args!("{}: participant {code} {state}", root.display()))?;
    out::line(format_args!("look at the data with: codrive analyse {}", root.display()))
}
