//! `codrive man`: manual pages of the commands. In: a folder. Out: `codrive.1`, and one file for each command, such as `codrive-map-list.1`.

use super::{CliError, out};
use clap::{Arg, ArgMatches, Command, value_parser};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

pub(super) fn command() -> Command {
    Command::new("man")
        .about("Write the manual pages of all commands")
        .after_help(
            "The packages bring the pages along.\n\nExample:\n  codrive man pages && man -l pages/codrive-drive.1",
        )
        .arg(
            Arg::new("folder")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("Folder of the pages; it is made if needed"),
        )
}

/// Writes the pages of `program`, the whole command line.
pub(super) fn main(matches: &ArgMatches, program: Command) -> Result<(), CliError> {
    let Some(folder) = matches.get_one::<PathBuf>("folder") else { return Ok(()) };
    let failed =
        |error: io::Error| CliError::Failed(format!("{}: {error}\n  remedy: name a writable folder", folder.display()));
    let count = write(folder, program).map_err(failed)?;
    out::line(format_args!("{}: {count} pages", folder.display()))
}

/// Writes the pages into a folder. Returns their number.
fn write(folder: &Path, program: Command) -> io::Result<usize> {
    fs::create_dir_all(folder)?;
    let mut program = program.long_version(env!("CARGO_PKG_VERSION")).disable_help_subcommand(true);
    program.build();
    write_of(&program, folder)
}

fn write_of(command: &Command, folder: &Path) -> io::Result<usize> {
    let mut count = 1;
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        count += write_of(below, folder)?;
    }
    // The name of a page has the names of all commands above, as clap joins them.
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let page = clap_mangen::Man::new(command.clone())
        .title(name.to_uppercase())
        .source(concat!("codrive ", env!("CARGO_PKG_VERSION")))
        .manual("codrive")
        .date("");
    let mut text = Vec::new();
    page.render(&mut text)?;
    fs::write(folder.join(format!("{name}.1")), text)?;
    Ok(count)
}
