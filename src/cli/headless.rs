//! Substitutes for the commands that need a window, a graphics card or devices, in a build without the feature `desktop`. In:
//! arguments. Out: a refusal with the remedy.

use super::{CliError, HelpListing};
use clap::{Arg, ArgAction, ArgMatches, Command};

/// Returns the refusal of `what`.
fn refusal(what: &str) -> CliError {
    CliError::Input(format!(
        "{what} needs windows, pictures and devices; this program was built without them (the cargo feature \
         `desktop`)\n  remedy: build it with cargo build --profile first; codrive --help lists the commands of this program"
    ))
}

/// Image formats of figures.
pub(super) const FIGURES: &str = "SVG";

/// Returns a hidden command that takes any arguments, so that the refusal can explain what is missing.
fn refused(name: &'static str) -> Command {
    let anything = Arg::new("anything").num_args(0..).trailing_var_arg(true).allow_hyphen_values(true);
    Command::new(name).hide(true).disable_help_flag(true).arg(anything)
}

/// Returns the commands that are refused.
pub(super) fn commands(_: HelpListing) -> Vec<Command> {
    ["drive", "render", "calibrate", "doctor", "bench"].map(refused).into()
}

/// Refuses a command of [`commands`]; `None` for every other.
pub(super) fn run(name: &str, _: &ArgMatches) -> Option<Result<(), CliError>> {
    commands(HelpListing::All)
        .iter()
        .any(|command| command.get_name() == name)
        .then(|| Err(refusal(&format!("codrive {name}"))))
}

/// Draws no PNG: figures are SVG only.
pub(super) fn png(_: &str) -> Option<Result<Vec<u8>, std::convert::Infallible>> {
    None
}

/// Returns hidden flags that are accepted in order to be refused.
fn flags(names: &[&'static str]) -> Vec<Arg> {
    let flag = |name: &&'static str| {
        Arg::new(*name).long(*name).hide(true).num_args(0..=1).allow_hyphen_values(true).action(ArgAction::Append)
    };
    names.iter().map(flag).collect()
}

fn refuse(names: &[&'static str], matches: &ArgMatches) -> Result<(), CliError> {
    let given = |name: &&&'static str| matches.value_source(name) == Some(clap::parser::ValueSource::CommandLine);
    names.iter().find(given).map_or(Ok(()), |name| Err(refusal(&format!("--{name}"))))
}

/// Desktop part of `codrive replay`: window, pictures, video and sound.
pub(super) mod replay {
    use super::{ArgMatches, CliError};
    use crate::replay::{Replay, ReplayReport};
    use clap::Arg;
    use std::path::Path;

    pub(in crate::cli) const ABOUT: &str =
        "Drive a recording again from its inputs and prove that every tick is the same";

    pub(in crate::cli) const DRAWS: &str = "";

    const FLAGS: [&str; 9] = ["window", "png", "frames-dir", "video", "wav", "at", "view", "size", "rate"];

    pub(in crate::cli) fn arguments() -> Vec<Arg> {
        super::flags(&FLAGS)
    }

    pub(in crate::cli) fn play(_: &Path, matches: &ArgMatches) -> Option<Result<(ReplayReport, u64), CliError>> {
        super::refuse(&FLAGS, matches).err().map(Err)
    }

    /// Empty stand-in for the desktop's outputs of a replay.
    pub(in crate::cli) struct Outputs;

    impl Outputs {
        pub(in crate::cli) fn begin(_: &Path, _: &Replay, matches: &ArgMatches) -> Result<Self, CliError> {
            super::refuse(&FLAGS, matches).map(|()| Self)
        }

        #[allow(clippy::unused_self, clippy::unnecessary_wraps, reason = "stands in for the desktop's")]
        pub(in crate::cli) fn tick(&mut self, _: &Replay) -> Result<(), CliError> {
            Ok(())
        }

        #[allow(clippy::unused_self, clippy::unnecessary_wraps, reason = "stands in for the desktop's")]
        pub(in crate::cli) fn end(self, _: &Replay) -> Result<(), CliError> {
            Ok(())
        }
    }
}

/// Desktop part of `codrive study`: a participant's session.
pub(super) mod session {
    use super::{ArgMatches, CliError, Command};

    pub(in crate::cli) fn command() -> Command {
        super::refused("session")
    }

    pub(in crate::cli) fn main(_: &ArgMatches) -> Result<(), CliError> {
        Err(super::refusal("codrive study session"))
    }
}

/// Returns the graphics card that draws: none in this build.
pub(super) fn graphics() -> String {
    "none: built without windows".into()
}
