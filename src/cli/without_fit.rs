//! Substitute for `codrive validate --fit` in a build without the feature `tune`. In: arguments. Out: a refusal with the remedy.

use super::CliError;
use crate::metrics::traffic_moments::VehicleTrajectories;
use clap::{Arg, ArgMatches, Command};
use std::path::Path;

/// Returns the command with the hidden flag, so that the refusal can explain what is missing.
pub(super) fn with_flags(command: Command) -> Command {
    command.arg(Arg::new("fit").long("fit").hide(true))
}

/// Checks whether a fit is asked for.
pub(super) fn is_wanted(matches: &ArgMatches) -> bool {
    matches.contains_id("fit")
}

/// Refuses the fit with the remedy.
pub(super) fn main(_: &ArgMatches, _: &Path, _: &VehicleTrajectories) -> Result<(), CliError> {
    let text = "--fit needs the parameter search; this program was built without it (the cargo feature `tune`)\n  \
        remedy: build it with cargo build --profile first";
    Err(CliError::Input(text.into()))
}
