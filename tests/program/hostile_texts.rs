//! Texts from outside with control sequences of a terminal: they are shown escaped and have no effect.

use std::{fs, path::Path, process::Command};

/// Control sequences that clear the screen in two ways, set the title, return to the start of the line, and reverse the writing direction.
const HOSTILE: &str = "a\u{1b}[2Jb\u{9b}2Jc\u{1b}]0;mine\u{7}\rd\u{202e}e";
const SEEN: &str = r"a\u001b[2Jb\u009b2Jc\u001b]0;mine\u0007\u000dd\u202ee";

/// Runs the program with `home` as the user's home. Returns both outputs.
fn printed(home: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env("HOME", home).env_remove("XDG_DATA_HOME").env_remove("XDG_CONFIG_HOME");
    let output = command.output().unwrap();
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
}

#[track_caller]
fn assert_seen(printed: &str) {
    assert!(printed.contains(SEEN), "{printed:?}");
    assert_harmless(printed);
}

#[track_caller]
fn assert_harmless(printed: &str) {
    let commands = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
    assert!(!printed.contains(commands), "{printed:?}");
}

#[test]
fn the_title_of_a_map_cannot_command_the_terminal() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join(".local/share/codrive/maps/mine");
    fs::create_dir_all(&folder).unwrap();
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/maps/ring-250/net.xml"), folder.join("net.xml")).unwrap();
    let title = toml::Value::String(HOSTILE.into());
    fs::write(folder.join("map.toml"), format!("title = {title}\n")).unwrap();
    assert_seen(&printed(home.path(), &["map", "list"]));
}

#[test]
fn the_name_of_a_file_cannot_command_the_terminal() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join(format!("{HOSTILE}.net.xml"));
    let name = file.to_str().unwrap();
    assert_seen(&printed(home.path(), &["run", "--map", name]));
    fs::write(&file, "<net>").unwrap();
    assert_seen(&printed(home.path(), &["run", "--map", name]));
    // Arguments that clap refuses come from typing or from a shell pattern; clap itself removes escape sequences.
    let refused = printed(home.path(), &["run", HOSTILE]);
    assert!(refused.contains(r"b\u009b2Jc"), "{refused:?}");
    assert_harmless(&refused);
    assert_seen(&printed(home.path(), &["replay", name]));
}

#[test]
fn a_line_of_the_log_cannot_command_the_terminal() {
    let home = tempfile::tempdir().unwrap();
    let (name, scenario) = (format!("{HOSTILE}.rou.xml"), home.path().join("drive.toml"));
    let demand = "<routes><vType id=\"t\" colour=\"sky\"/>\
                  <trip id=\"a\" type=\"t\" depart=\"0\" from=\"inflow_highway\" to=\"center\"/></routes>";
    fs::write(home.path().join(&name), demand).unwrap();
    let files = toml::Value::String(name);
    let text = format!("map = \"merge\"\nparticipant = false\nduration_s = 0.5\n[demand]\nfiles = [{files}]\n");
    fs::write(&scenario, text).unwrap();
    let printed = printed(home.path(), &["run", "--scenario", scenario.to_str().unwrap()]);
    assert!(
        printed.contains("not passed to SUMO, because codrive does not use it: 1 x colour of vType"),
        "{printed:?}"
    );
    assert_seen(&printed);
}
