//! Substitute for `codrive tune` in a build without the feature `tune`. In: arguments. Out: a refusal with the remedy.

use super::CliError;
use clap::{Arg, ArgMatches, Command};

/// Returns the hidden command, so that the refusal can explain what is missing.
pub(super) fn command() -> Command {
    let anything = Arg::new("anything").num_args(0..).trailing_var_arg(true).allow_hyphen_values(true);
    Command::new("tune").about(super::TUNE_ABOUT).hide(true).disable_help_flag(true).arg(anything)
}

/// Refuses the command with the remedy.
pub(super) fn main(_: &ArgMatches) -> Result<(), CliError> {
    let text = "codrive tune needs the parameter search; this program was built without it (the cargo feature \
        `tune`)\n  remedy: build it with cargo build --profile first";
    Err(CliError::Input(text.into()))
}
