//! The command line. In: arguments. Out: an exit code.
//!
//! - 0: done.
//! - 1: failed, with one message.
//! - 2: bad input; the message names the fault and the allowed values.
//! - 130: ended by a person before a drive began.
//! - 141: the reader of the standard output has gone (128 + SIGPIPE).

mod analyse;
mod check_network;
mod completions;
#[cfg(feature = "desktop")]
mod desktop;
#[cfg(not(feature = "desktop"))]
#[path = "headless.rs"]
mod desktop;
mod environment;
mod error;
mod evaluate;
#[cfg(feature = "tune")]
mod fit;
#[cfg(not(feature = "tune"))]
#[path = "without_fit.rs"]
mod fit;
mod flags;
mod man;
mod map;
mod out;
mod own_program;
mod progress;
mod recover;
mod replay;
mod run;
mod scenario;
pub mod schema;
mod sign;
mod stop;
mod study;
mod sweep;
mod train;
#[cfg(feature = "tune")]
mod tune;
#[cfg(not(feature = "tune"))]
#[path = "without_tune.rs"]
mod tune;
mod validate;
mod version;

pub use environment::prepare as prepare_environment;
pub use error::CliError;
pub(crate) use stop::stop_on_ctrl_c;

use crate::{data_folders, toml_text::nearest, traffic::sumo};
use clap::{
    Arg, ArgAction, Command,
    error::{ContextKind, ContextValue, ErrorKind},
    value_parser,
};
pub use flags::HelpListing;
pub use out::visible;
use std::{ffi::OsString, io::Write, path::PathBuf};

/// Runs the program with these arguments, the program's name first. Returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let (listing, arguments) = listing(arguments.into_iter().collect());
    if version::is_verbose(&arguments) {
        return out::text(version::report()).map_or_else(|error| print_error(&error), |()| 0);
    }
    let arguments = with_default_command(arguments);
    let matches = match command(listing).try_get_matches_from(&arguments) {
        Ok(matches) => matches,
        Err(mut error) => {
            suggest_command(&mut error, &command(listing), &arguments);
            // Help and version go to stdout and are no failure; every other error of clap is bad input.
            let plain = error.render().to_string();
            if error.use_stderr() && out::visible(&plain) != plain {
                // The echo of the user's own argument is printed without clap's styles and with control characters escaped.
                out::status_line(plain.trim_end());
                return 2;
            }
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            return match printed {
                _ if error.use_stderr() => 2,
                Ok(()) => 0,
                Err(error) => print_error(&out::fault(&error)),
            };
        }
    };
    // clap passes `--data` on to the command, whether it stands before or after it.
    let given = matches.subcommand().and_then(|(_, m)| m.get_one::<PathBuf>("data"));
    let checked = given.map_or_else(data_folders::check_environment, |folder| data_folders::give(folder));
    // These commands work without the data folder; the doctor reports a missing one in a line of its own.
    let without =
        ["analyse", "validate", "recover", "sign", "calibrate", "doctor", "completions", "man", check_network::NAME];
    let needs = matches.subcommand_name().is_some_and(|name| !without.contains(&name));
    let checked = checked.and_then(|()| if needs { data_folders::require() } else { Ok(()) });
    if let Err(why) = checked {
        return print_error(&CliError::Input(why.to_string()));
    }
    // `check-network` runs as a child process and prints faults only.
    if let Some((variable, folder)) = data_folders::named_by_environment().filter(|_| needs) {
        out::status_line(format_args!("codrive: maps and policies come from {} ({variable})", folder.display()));
    }
    sumo::tell_waits_by(|text| out::status_line(format_args!("codrive: {text}")));
    let done = match matches.subcommand() {
        Some(("run", m)) => run::main(m),
        Some(("study", m)) => study::main(m),
        Some(("analyse", m)) => analyse::main(m),
        Some(("replay", m)) => replay::main(m),
        Some(("recover", m)) => recover::main(m),
        Some(("sign", m)) => sign::main(m),
        Some(("map", m)) => map::main(m),
        Some(("scenario", m)) => scenario::main(m),
        // With all flags, also those that only `--help-all` lists.
        Some(("completions", m)) => completions::main(m, shown_command(HelpListing::All)),
        Some(("man", m)) => man::main(m, shown_command(HelpListing::All)),
        Some(("schema", m)) => schema::main(m),
        Some((check_network::NAME, m)) => check_network::main(m),
        Some(("train", m)) => train::main(m),
        Some(("tune", m)) => tune::main(m),
        Some(("evaluate", m)) => evaluate::main(m),
        Some(("sweep", m)) => sweep::main(m),
        Some(("validate", m)) => validate::main(m),
        Some((name, m)) => desktop::run(name, m).unwrap_or_else(|| unreachable!("clap knows the commands")),
        None => unreachable!("clap requires a command and with_default_command adds one"),
    };
    let code = match done {
        Ok(()) => 0,
        Err(error) => print_error(&error),
    };
    stop::end_if_starting(code);
    code
}

/// Suggests the nearest command where clap finds none: its measure misses two swapped letters in a short word. Lists all commands of the
/// level if none is near.
fn suggest_command(error: &mut clap::Error, program: &Command, arguments: &[OsString]) {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return };
    if error.kind() != ErrorKind::InvalidSubcommand || error.get(ContextKind::SuggestedSubcommand).is_some() {
        return;
    }
    let parents = arguments.iter().take_while(|argument| *argument != word.as_str());
    let parent = parents.fold(program, |parent, name| parent.find_subcommand(name).unwrap_or(parent));
    let shown = parent.get_subcommands().filter(|command| !command.is_hide_set());
    let known: Vec<&str> = shown.map(Command::get_name).collect();
    match nearest(word, &known) {
        Some(near) => error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![near.into()])),
        None => error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(vec![format!("the commands are {}", known.join(", ")).into()]),
        ),
    };
}

/// Prints an error. Returns the exit code.
fn print_error(error: &CliError) -> u8 {
    let code = match error {
        CliError::Input(_) => 2,
        CliError::Failed(_) => 1,
        // 128 + SIGPIPE, as a shell reports other tools. The signal itself stays ignored: SUMO, ffmpeg and the display are at
        // the other ends of pipes, and a drive must outlive them.
        CliError::Unread => return 141,
        CliError::Interrupted(_) => stop::INTERRUPTED,
    };
    out::status_line(format_args!("codrive: {error}"));
    code
}

/// Replaces `--help-all` by `--help` and returns the listing that was asked for.
fn listing(mut arguments: Vec<OsString>) -> (HelpListing, Vec<OsString>) {
    let mut listing = HelpListing::Common;
    for argument in &mut arguments {
        if argument == "--help-all" {
            *argument = "--help".into();
            listing = HelpListing::All;
        }
    }
    (listing, arguments)
}

/// Commands by purpose, as in `--help`.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Drive", &["drive", "run", "render", "replay"]),
    ("Study", &["study", "calibrate", "doctor"]),
    ("Analyse", &["analyse", "evaluate", "sweep", "validate"]),
    ("Train", &["train", "tune"]),
    ("Maintain", &["map", "scenario", "schema", "recover", "sign", "bench", "completions", "man"]),
];

const TUNE_ABOUT: &str = "Tune a controller's parameters on the fast ring by CMA-ES";

/// Returns the whole command line, for `--help` and tests.
pub fn command(listing: HelpListing) -> Command {
    shown_command(listing).subcommand(check_network::command())
}

/// Returns the command line without the command that the program calls itself: clap's completions have hidden commands, too.
fn shown_command(listing: HelpListing) -> Command {
    let add = |command: Command| flags::add(command, listing);
    let command = Command::new("codrive")
        .version(env!("CARGO_PKG_VERSION"))
        .long_version(version::long())
        .disable_version_flag(true)
        .about("A driving simulator for studies of people in traffic.\nWithout a command: codrive drive.")
        .subcommand_required(true)
        .max_term_width(110)
        .arg(Arg::new("data").long("data").value_name("DIR").global(true).value_parser(value_parser!(PathBuf)).help(
            "Folder with the program's maps and assets [default: found automatically; codrive doctor shows where]",
        ))
        .arg(
            Arg::new("version")
                .short('V')
                .long("version")
                .action(ArgAction::Version)
                .help("Print the version; with --verbose everything that a report of a fault needs"),
        )
        .arg(
            Arg::new("verbose")
                .short('v')
                .long("verbose")
                .action(ArgAction::SetTrue)
                .requires("version")
                .help("Print more, with --version"),
        )
        .subcommand(add(run::command()))
        .subcommand(study::command())
        .subcommand(analyse::command())
        .subcommand(replay::command())
        .subcommand(recover::command())
        .subcommand(sign::command())
        .subcommand(train::command())
        .subcommand(tune::command())
        .subcommand(evaluate::command())
        .subcommand(sweep::command())
        .subcommand(validate::command())
        .subcommand(map::command())
        .subcommand(scenario::command())
        .subcommand(completions::command())
        .subcommand(man::command())
        .subcommand(schema::command())
        .subcommands(desktop::commands(listing));
    let groups = groups(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{groups}\nOptions:\n{{options}}{{after-help}}"
    ))
}

/// Returns the list of commands under the headings of [`GROUPS`].
fn groups(command: &Command) -> String {
    let line = |name: &&str| {
        let shown = command.find_subcommand(name).filter(|command| !command.is_hide_set())?;
        let about = shown.get_about().map(ToString::to_string).unwrap_or_default();
        Some(format!("  {name:<11} {about}\n"))
    };
    let group = |(title, names): &(&str, &[&str])| {
        let lines: String = names.iter().filter_map(line).collect();
        format!("\n{title}:\n{lines}")
    };
    GROUPS.iter().map(group).collect()
}

/// Inserts `drive` where no command is named: `codrive` and `codrive --map x` mean `codrive drive`.
fn with_default_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    // Only `--data` may stand before a command.
    let word = |i: usize| arguments.get(i).map(|a| a.to_string_lossy().into_owned());
    let skipped = match word(1) {
        Some(a) if a == "--data" => 2,
        Some(a) if a.starts_with("--data=") => 1,
        _ => 0,
    };
    let first = word(1 + skipped);
    let asks_the_program = |a: &str| ["-h", "--help", "-V", "--version"].contains(&a);
    if first.is_none_or(|a| a.starts_with('-') && !asks_the_program(&a)) {
        arguments.insert((1 + skipped).min(arguments.len()), "drive".into());
    }
    arguments
}

#[cfg(test)]
mod documents_tests;
#[cfg(test)]
mod reference_tests;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    #[test]
    fn the_command_line_is_sound() {
        command(HelpListing::Common).debug_assert();
        command(HelpListing::All).debug_assert();
    }

    #[test]
    fn every_command_is_in_one_group_and_every_setting_in_the_whole_help() {
        let line = command(HelpListing::Common);
        let shown: Vec<&str> =
            line.get_subcommands().filter(|command| !command.is_hide_set()).map(Command::get_name).collect();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        assert!(shown.iter().all(|name| grouped.contains(name)), "{grouped:?}");
        grouped.sort_unstable();
        assert!(grouped.windows(2).all(|pair| pair[0] != pair[1]) && grouped.len() == shown.len());
        let help = |listing| {
            let mut line = command(listing);
            line.find_subcommand_mut("drive").unwrap().render_help().to_string()
        };
        let (common, all) = (help(HelpListing::Common), help(HelpListing::All));
        assert!(
            common.contains("example: --hold 5") && !common.contains("--mirror-yaw") && !common.contains("--driver")
        );
        assert!(common.contains("codrive drive --help-all lists"), "{common}");
        assert!(
            Scenario::fields().iter().filter(|s| s.table().is_none()).all(|s| all.contains(&format!("--{}", s.flag())))
        );
        assert!(all.contains("--idm") && all.contains("Limits: ") && all.lines().count() > 2 * common.lines().count());
        // Settings that the help does not list are still accepted.
        let words = ["codrive", "drive", "--mirror-yaw", "5"];
        assert!(command(HelpListing::Common).try_get_matches_from(words).is_ok());
        let (listing, arguments) = listing(["codrive", "drive", "--help-all"].map(Into::into).to_vec());
        assert_eq!((listing, arguments[2].as_os_str()), (HelpListing::All, std::ffi::OsStr::new("--help")));
    }

    #[test]
    fn no_command_means_drive() {
        let full = |words: &[&str]| -> Vec<OsString> { with_default_command(words.iter().map(Into::into).collect()) };
        assert_eq!(full(&["codrive"]), ["codrive", "drive"]);
        assert_eq!(full(&["codrive", "--map", "practice"]), ["codrive", "drive", "--map", "practice"]);
        assert_eq!(full(&["codrive", "--help"]), ["codrive", "--help"]);
        assert_eq!(full(&["codrive", "run"]), ["codrive", "run"]);
    }
}
