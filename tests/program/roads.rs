//! Defaults and roads on the command line: what `auto` says, settings without effect, and paths between places.

use assert_cmd::Command;

/// Runs the program without a display. Returns the exit code, standard output and standard error.
fn printed(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let output = command.output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Runs a second of a drive with these flags. Returns the exit code and standard error.
fn run(more: &[&str]) -> (i32, String) {
    let (code, _, error) = printed(&[&["run", "--duration", "1"], more].concat());
    (code, error)
}

#[test]
fn auto_does_not_warn_about_defaults() {
    for map in ["ring-250", "ring-641", "practice"] {
        let (code, text) = run(&["--traffic", "native", "--map", map]);
        assert_eq!((code, text.as_str()), (0, ""), "{map}");
        let short = ["--warm-up", "1", "--horizon", "2", "--over", "2"];
        let (code, _, text) = printed(&[&["evaluate", "--policy", "auto", "--map", map][..], &short].concat());
        assert_eq!((code, text.as_str()), (0, ""), "{map}");
    }
    // A hold that the user set is reported.
    let (_, text) = run(&["--traffic", "native", "--map", "ring-641", "--hold", "2"]);
    assert!(text.contains("the hold is 2 s; the policy was trained for holds of 4 to 30 s"), "{text}");
}

#[test]
fn a_setting_without_effect_on_the_road_is_said_and_the_drive_goes_on() {
    let (code, text) = run(&["--map", "merge", "--vehicles", "5"]);
    assert!(code == 0 && text.contains("vehicles is 5: it has no effect on map merge"), "{code}: {text}");
}

#[test]
fn a_path_between_places_is_printed_and_can_be_driven() {
    let town = "tests/data/networks/town.net.xml";
    let (code, text, error) = printed(&["map", "path", town, "--from", "eend", "--via", "180,126.8", "--to", "wn"]);
    assert_eq!((code, error.as_str()), (0, ""));
    assert!(text.contains("path           eend ende ec cw wn\n"), "{text}");
    let (code, text) = run(&["--map", town, "--path", "eend ... wn"]);
    assert_eq!((code, text.as_str()), (0, ""));
    let (code, _, text) = printed(&["map", "path", town, "--from", "eend", "--to", "wnn"]);
    assert!(code == 2 && text.contains("edge \"wnn\" does not exist (did you mean wn?)"), "{code}: {text}");
}
