//! Commands in the documents. In: the pages of docs/ and the README. Out: nothing, or each command that the program would refuse, with its
//! page and line.

use super::*;
use std::{fs, path::Path};

/// Returns the Markdown pages of a folder and of those below it.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let pages = entries.flat_map(|path| if path.is_dir() { pages(&path) } else { vec![path] });
    pages.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect()
}

/// Returns the commands of a page with their lines, those of shell blocks and those in the text as code; true for the latter.
fn commands(page: &str) -> Vec<(usize, bool, String)> {
    let mut found = Vec::new();
    let mut block: Option<bool> = None;
    for (number, line) in page.lines().enumerate() {
        if let Some(kind) = line.trim_start().strip_prefix("```") {
            block = block.is_none().then(|| kind.starts_with("sh"));
        } else if block == Some(true) {
            // The shell joins a line that ends with a backslash with the next one.
            match found.last_mut().filter(|(.., before): &&mut (usize, bool, String)| before.ends_with('\\')) {
                Some((.., before)) => before.replace_range(before.len() - 1.., line.trim()),
                None => found.push((number + 1, false, line.trim().to_owned())),
            }
        } else if block.is_none() {
            found.extend(line.split('`').skip(1).step_by(2).map(|code| (number + 1, true, code.to_owned())));
        }
    }
    found.retain(|(.., command)| command.starts_with("codrive "));
    found
}

/// Faults of a command that a text only names.
const IS_NAMED: [ErrorKind; 3] = [
    ErrorKind::MissingRequiredArgument,
    ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand,
    ErrorKind::MissingSubcommand,
];

/// Returns true if the text stands for commands of a kind: with words left out, or a placeholder for a command.
fn is_pattern(command: &str) -> bool {
    command.contains("...") || command.contains("COMMAND") || command.contains('[')
}

#[test]
fn every_command_in_the_documents_is_one_that_the_program_takes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pages = [pages(&root.join("docs")), vec![root.join("README.md"), root.join("CONTRIBUTING.md")]].concat();
    let mut faults = Vec::new();
    let mut taken = 0;
    for page in pages {
        for (line, is_in_text, text) in commands(&fs::read_to_string(&page).unwrap()) {
            let words = shlex::split(&text).unwrap_or_else(|| panic!("{}:{line}: {text}", page.display()));
            // The shell takes the rest of the line: another command, or a file for the output.
            let own = words.into_iter().take_while(|word| !["|", ">", "&&", ";"].contains(&word.as_str()));
            let (listing, arguments) = listing(own.map(OsString::from).collect());
            if is_pattern(&text) {
                continue;
            }
            match command(listing).try_get_matches_from(with_default_command(arguments)) {
                // A text may name a command without what it needs.
                Err(fault) if fault.use_stderr() && !(is_in_text && IS_NAMED.contains(&fault.kind())) => {
                    let why = fault.to_string();
                    faults.push(format!(
                        "{}:{line}: {text}\n  {}",
                        page.display(),
                        why.lines().next().unwrap_or_default()
                    ));
                }
                _ => taken += 1,
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // A test that finds no commands would pass, too.
    assert!(taken > 200, "{taken}");
}
