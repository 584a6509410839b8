//! Substitute for `codrive validate --fit` in a build without the feature `tune`. In: arguments. Out: the command without the flags.

use super::CliError;
use crate::metrics::traffic_moments::VehicleTrajectories;
use clap::{ArgMatches, Command};
use std::path::Path;

/// Returns the command unchanged.
pub(super) fn with_flags(command: Command) -> Command {
    command
}

/// Returns false: no fit can be asked for.
pub(super) fn is_wanted(_: &ArgMatches) -> bool {
    false
}

/// Does nothing, as no fit can be asked for.
pub(super) fn main(_: &ArgMatches, _: &Path, _: &VehicleTrajectories) -> Result<(), CliError> {
    Ok(())
}
