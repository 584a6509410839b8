//! Commands that need a window, a graphics card or devices, and what other commands show with them. In: arguments. Out: an
//! exit code. Without the feature `desktop`, `headless.rs` stands here.

mod bench;
mod calibrate;
mod doctor;
mod drive;
mod render;
pub(super) mod replay;
pub(super) mod session;

use super::{CliError, HelpListing, flags};
use clap::{ArgMatches, Command};

/// Kinds of files that a figure becomes.
pub(super) const FIGURES: &str = "SVG, PNG";

/// The commands, in the order of the help.
pub(super) fn commands(listing: HelpListing) -> Vec<Command> {
    let add = |command: Command| flags::add(command, listing);
    vec![
        add(drive::command()),
        add(render::command()),
        calibrate::command(),
        add(doctor::command()),
        add(bench::command()),
    ]
}

/// Runs a command, if it is one of these.
pub(super) fn run(name: &str, matches: &ArgMatches) -> Option<Result<(), CliError>> {
    match name {
        "drive" => Some(drive::main(matches)),
        "render" => Some(render::main(matches)),
        "calibrate" => Some(calibrate::main(matches)),
        "doctor" => Some(doctor::main(matches)),
        "bench" => Some(bench::main(matches)),
        _ => None,
    }
}

/// A figure as PNG; `None` where the program draws none.
pub(super) fn png(svg: &str) -> Option<Result<Vec<u8>, crate::plot::PngError>> {
    Some(crate::plot::png(svg))
}
