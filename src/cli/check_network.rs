//! `codrive check-network`, hidden in the help: tries whether SUMO survives a network and a demand. The program runs itself
//! this way before it loads foreign ones into its own process.

use super::CliError;
use crate::traffic::{TrafficError, sumo};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::path::PathBuf;

pub(super) const NAME: &str = sumo::CHECK_NETWORK;

pub(super) fn command() -> Command {
    Command::new(NAME)
        .hide(true)
        .about("Drive some vehicles on a network to test that SUMO does not crash")
        .arg(Arg::new("trial").value_name("TRIAL.JSON").required(true).value_parser(value_parser!(PathBuf)))
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(file) = matches.get_one::<PathBuf>("trial") else { return Ok(()) };
    sumo::try_network(file).map_err(|error| match error {
        TrafficError::Setup(text) => CliError::Input(text),
        other => CliError::Failed(other.to_string()),
    })
}
