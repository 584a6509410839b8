//! `codrive completions`: completions of commands and flags for a shell. In: the shell's name. Out: its script on the standard output.

use super::{CliError, out};
use clap::{Arg, ArgMatches, Command, builder::EnumValueParser};
use clap_complete::Shell;

pub(super) fn command() -> Command {
    Command::new("completions")
        .about("Print the completions of commands and flags for a shell")
        .after_help(
            "The packages bring the completions along. For a program that you have built:\n  \
             codrive completions bash > ~/.local/share/bash-completion/completions/codrive\n  \
             codrive completions zsh > DIR/_codrive, where DIR is a folder of $fpath\n  \
             codrive completions fish > ~/.config/fish/completions/codrive.fish",
        )
        .arg(
            Arg::new("shell")
                .value_name("SHELL")
                .required(true)
                .value_parser(EnumValueParser::<Shell>::new())
                .help("Shell that reads the completions"),
        )
}

/// Prints the completions of `program`, the whole command line.
pub(super) fn main(matches: &ArgMatches, program: Command) -> Result<(), CliError> {
    let Some(shell) = matches.get_one::<Shell>("shell") else { return Ok(()) };
    out::text(String::from_utf8_lossy(&script(*shell, program)))
}

/// Returns the script for a shell.
fn script(shell: Shell, mut program: Command) -> Vec<u8> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut program, "codrive", &mut text);
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{HelpListing, shown_command};
    use std::process;

    /// Returns the words that bash offers after a line, which begins with `codrive`.
    fn offered(line: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("codrive.bash");
        std::fs::write(&file, script(Shell::Bash, shown_command(HelpListing::All))).unwrap();
        let ask = r#". "$0" || exit; COMP_WORDS=($1 "$2"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
            _codrive codrive "$2" "${COMP_WORDS[COMP_CWORD - 1]}"; printf '%s ' "${COMPREPLY[@]}""#;
        let (begun, word) = line.rsplit_once(' ').unwrap();
        let output = process::Command::new("bash").args(["-c", ask]).arg(&file).args([begun, word]).output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).trim().into()
    }

    #[test]
    fn bash_completes_commands_flags_and_words() {
        #[cfg(feature = "desktop")]
        assert_eq!(offered("codrive dr"), "drive");
        assert_eq!(offered("codrive stu"), "study");
        assert_eq!(offered("codrive study reh"), "rehearse");
        // Only --help-all lists this flag.
        assert_eq!(offered("codrive run --mirror-y"), "--mirror-yaw");
        assert_eq!(offered("codrive run --start b"), "bunched");
    }

    #[test]
    fn each_shell_gets_a_script_without_hidden_commands() {
        for (shell, part) in [
            (Shell::Bash, "complete -F _codrive"),
            (Shell::Zsh, "#compdef codrive"),
            (Shell::Fish, "complete -c codrive"),
        ] {
            let text = String::from_utf8(script(shell, shown_command(HelpListing::All))).unwrap();
            assert!(text.contains(part) && !text.contains(crate::cli::check_network::NAME), "{shell}");
        }
    }
}
