//! Pages of docs/reference that come from the command line and from the settings. In: the commands, the settings of a drive. Out: the
//! committed pages, or a difference; `UPDATE_EXPECT=1 cargo test --lib reference` writes them anew.

use super::*;
use crate::{
    scenario::Scenario,
    settings::{Field, SettingKind},
};
use expect_test::expect_file;
use std::fmt::Write as _;

/// Heading of the flags that a scenario file has, too; the page of settings has them.
const SETTINGS: &str = "Scenario";

fn cell(text: &str) -> String {
    text.trim().replace('\n', " ").replace('|', "\\|")
}

/// Returns a flag or a place of the command line as it is typed, such as `--out <DIR>`.
fn typed(arg: &Arg) -> String {
    let names: Vec<String> = arg.get_value_names().unwrap_or_default().iter().map(|name| format!("<{name}>")).collect();
    let value = if arg.get_action().takes_values() { names.join(" ") } else { String::new() };
    match arg.get_long() {
        Some(long) => format!("--{long} {value}").trim().to_owned(),
        None => value,
    }
}

/// Writes a command and those below it.
fn write_command(page: &mut String, command: &Command, path: &str) {
    let path = format!("{path} {}", command.get_name());
    let _ = write!(page, "\n## {}\n", path.trim());
    if let Some(about) = command.get_about() {
        let _ = write!(page, "\n{about}.\n");
    }
    let shown = |arg: &&Arg| !arg.is_hide_set() && !["help", "version", "data"].contains(&arg.get_id().as_str());
    let args: Vec<&Arg> = command.get_arguments().filter(shown).collect();
    let own: Vec<&&Arg> = args.iter().filter(|arg| arg.get_help_heading() != Some(SETTINGS)).collect();
    if !own.is_empty() {
        page.push_str("\n| flag or argument | meaning |\n|---|---|\n");
    }
    for arg in own {
        let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
        let mut meaning = cell(&help);
        let default: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        if arg.get_action().takes_values() && !default.is_empty() && !meaning.contains("[default") {
            let _ = write!(meaning, " [default: {}]", default.join(" "));
        }
        let words: Vec<String> = arg
            .get_possible_values()
            .iter()
            .filter(|_| !arg.is_hide_possible_values_set())
            .map(|word| word.get_name().to_owned())
            .collect();
        if arg.get_action().takes_values() && !words.is_empty() {
            let _ = write!(meaning, " [{}]", words.join(", "));
        }
        let required = if arg.is_required_set() { "; required" } else { "" };
        let _ = writeln!(page, "| `{}` | {meaning}{required} |", cell(&typed(arg)));
    }
    if args.iter().any(|arg| arg.get_help_heading() == Some(SETTINGS)) {
        page.push_str(
            "\nAnd each [setting of a drive](settings.md) as a flag, and `--scenario <FILE>` for a file of them.\n",
        );
    }
    if let Some(after) =
        command.get_after_help().filter(|_| !args.iter().any(|arg| arg.get_help_heading() == Some(SETTINGS)))
    {
        let _ = write!(page, "\n```text\n{}\n```\n", after.to_string().trim());
    }
    for below in command.get_subcommands().filter(|below| !below.is_hide_set() && below.get_name() != "help") {
        write_command(page, below, &path);
    }
}

#[test]
fn the_page_of_commands_is_the_command_line() {
    let mut page = "# Commands and flags\n\n**Goal:** look up each command of the program with its flags. `codrive COMMAND --help` prints the same.\n\n\
        | purpose | commands |\n|---|---|\n"
        .to_owned();
    for (purpose, names) in GROUPS {
        let links: Vec<String> = names.iter().map(|name| format!("[{name}](#codrive-{name})")).collect();
        let _ = writeln!(page, "| {purpose} | {} |", links.join(", "));
    }
    page.push_str(
        "\nEvery command takes `--data <DIR>`, the folder with maps and assets ([where data lie](../commands.md#where-data-lie)), and \
         `--help`.\n",
    );
    let line = command(HelpListing::Common);
    for name in GROUPS.iter().flat_map(|(_, names)| names.iter()) {
        write_command(&mut page, line.find_subcommand(name).expect("a command of a group"), "codrive");
    }
    expect_file!["../../docs/reference/commands.md"].assert_eq(&page);
}

/// Titles of the settings, each with the first key below it.
const TITLES: [(&str, &str); 5] = [
    ("map", "Road, traffic and start"),
    ("policy", "Advice"),
    ("units", "Picture and screen"),
    ("sound", "Sound, rig and car"),
    ("secondary_task", "Secondary task and automation"),
];

fn row(field: &Field) -> String {
    let allowed = match &field.kind {
        SettingKind::Switch => "`true`, `false`".to_owned(),
        SettingKind::Choice(words) => words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", "),
        SettingKind::Text => "text".to_owned(),
        SettingKind::Whole { .. } | SettingKind::Number { .. } => {
            field.allowed().replacen("a whole number from", "whole,", 1).replacen("a number from ", "", 1)
        }
    };
    let key = field.path.rsplit('.').next().unwrap_or(&field.path);
    let default = match &field.default {
        serde_json::Value::String(text) if text.is_empty() => "empty".to_owned(),
        serde_json::Value::String(text) => format!("`{text}`"),
        other => other.to_string(),
    };
    format!("| `{key}` | {default} | {} | {} |\n", cell(&allowed), cell(&field.doc))
}

#[test]
fn the_page_of_settings_is_the_scenario() {
    let mut page = "# Settings of a drive\n\n**Goal:** look up each key of a scenario file with its default, its limits and its meaning.\n\n\
        The flag of a key is the key without its unit, with dashes: `hold_s = 5.0` is `--hold 5`. A switch takes `true` or `false`; the flag alone \
        means `true`. A table is one flag: `--idm T=1.5,noise=0`. [Scenario files](../commands.md#scenario-files) says how to write a \
        file; `[demand]`, `[[road_user]]` and `[[event]]` are lists of their own ([networks](../commands.md#drives-on-networks), \
        [events](../how-to/let-events-happen.md)).\n"
        .to_owned();
    let head = "| key | default | allowed | meaning |\n|---|---|---|---|\n";
    let fields = Scenario::fields();
    let mut begun = Vec::new();
    let (mut of_tables, mut tables) = (String::new(), Vec::new());
    for field in &fields {
        let first = field.path.split('.').next().unwrap_or_default();
        if let Some((key, title)) = TITLES.iter().find(|(key, _)| *key == first && !begun.contains(key)) {
            begun.push(key);
            let _ = write!(page, "\n## {title}\n\n{head}");
        }
        let Some(table) = field.table() else {
            page.push_str(&row(field));
            continue;
        };
        if !tables.contains(&table) {
            tables.push(table);
            let _ = writeln!(page, "| `[{table}]` | | table | [keys of `{table}`](#keys-of-{table}) |");
            let _ = write!(of_tables, "\n## Keys of `{table}`\n\n{head}");
        }
        of_tables.push_str(&row(field));
    }
    assert_eq!(begun.len(), TITLES.len(), "a title's key is gone");
    page.push_str(&of_tables);
    expect_file!["../../docs/reference/settings.md"].assert_eq(&page);
}
