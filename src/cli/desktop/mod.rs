//! Commands that need a window, a graphics card or devices, and the desktop parts of other commands. In: arguments. Out: an
//! exit code. A build without the feature `desktop` has `headless.rs` instead.

mod bench;
mod calibrate;
mod doctor;
mod drive;
mod render;
pub(super) mod replay;
pub(super) mod session;

use super::{CliError, HelpListing, flags};
use clap::{ArgMatches, Command};

/// Image formats of figures.
pub(super) const FIGURES: &str = "SVG, PNG";

/// Returns the commands in the order of the help.
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

/// Runs a command of [`commands`]; `None` for every other.
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

/// Draws a figure as PNG. Always `Some` here; `None` in a build without the feature `desktop`.
pub(super) fn png(svg: &str) -> Option<Result<Vec<u8>, crate::plot::PngError>> {
    Some(crate::plot::png(svg))
}

/// Returns adapter, driver and interface of the graphics card that draws, or the reason why none does.
pub(super) fn graphics() -> String {
    crate::render::Gpu::headless().map_or_else(|why| format!("none: {why}"), |gpu| gpu.description())
}
