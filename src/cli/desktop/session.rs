//! `codrive study --participant`: leads a participant through a study, in windows.

use super::drive::{place, place_arguments};
use crate::{
    cli::{CliError, out, stop_on_ctrl_c},
    input::profiles,
    session::window::{self, SessionOptions, SessionOutcome},
    study::{ParticipantCode, Study},
};
use clap::{Arg, ArgAction, ArgMatches};
use std::path::Path;

pub(in crate::cli) const ABOUT: &str =
    "Lead a participant through a study, check it and print its plan, or rehearse it with simulated participants";

pub(in crate::cli) fn arguments() -> Vec<Arg> {
    let mut arguments = vec![
        Arg::new("participant")
            .long("participant")
            .value_name("CODE")
            .requires("out")
            .conflicts_with_all(["check", "rehearse", "participants"])
            .help(
                "Lead this participant through the whole plan, in a window for them and one for the experimenter; a code \
                 of letters and digits, never a name. After a closed window or a crash, run the same command to resume",
            ),
        Arg::new("fullscreen")
            .long("fullscreen")
            .action(ArgAction::SetTrue)
            .requires("participant")
            .help("Fill the participant's screen"),
    ];
    arguments.extend(place_arguments().map(|arg| arg.requires("participant")));
    arguments.push(
        Arg::new("wheel")
            .long("wheel")
            .value_name("NAME|FILE.toml")
            .requires("participant")
            .help("Profile of the steering wheel, as in codrive drive"),
    );
    arguments
}

/// Leads a participant through the study and prints where it ended.
pub(in crate::cli) fn lead(
    study: Study,
    code: ParticipantCode,
    root: &Path,
    matches: &ArgMatches,
) -> Result<(), CliError> {
    let wheel = matches.get_one::<String>("wheel").map(|name| profiles::named(name)).transpose();
    let left = window::run(SessionOptions {
        study,
        out: root.into(),
        code: code.clone(),
        place: place(matches, matches.get_flag("fullscreen"))?,
        wheel: wheel.map_err(|error| CliError::Input(error.to_string()))?,
        stop: stop_on_ctrl_c(),
    })?;
    let state = match left {
        SessionOutcome::Over(completion) => format!("{}: {}", completion, completion.meaning()),
        SessionOutcome::Open(item) => format!("is at {item}: run the same command to resume"),
    };
    out::line(format_args!("{}: participant {code} {state}", root.display()))?;
    out::line(format_args!("look at the data with: codrive analyse {}", root.display()))?;
    Ok(())
}
