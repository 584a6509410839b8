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
        // The fast ring does not have the practice circuit.
        let traffic = if map == "practice" { "native" } else { "ring" };
        let short = ["--warm-up", "1", "--horizon", "2", "--over", "2", "--traffic", traffic];
        let (code, _, text) = printed(&[&["evaluate", "--policy", "auto", "--map", map][..], &short].concat());
        assert_eq!((code, text.as_str()), (0, ""), "{map}");
    }
    // A hold that the user set is reported.
    let (_, text) = run(&["--traffic", "native", "--map", "ring-641", "--hold", "2"]);
    assert!(text.contains("the hold is 2 s; the policy was trained for holds of 4 to 30 s"), "{text}");
}

/// Evaluates a second of drives with these flags. Returns the exit code, standard output and standard error.
fn evaluated(more: &[&str]) -> (i32, String, String) {
    printed(&[&["evaluate", "--warm-up", "1", "--horizon", "1", "--over", "2", "--json"], more].concat())
}

#[test]
fn an_evaluation_drives_the_road_that_is_named_or_refuses_it() {
    // The larger ring has its own traffic: 40 vehicles on 640.9 m.
    for (map, vehicles, length_m) in
        [("ring-641", 40, 640.9), ("maps/ring-641/net.xml", 40, 640.9), ("ring-250", 22, 250.0)]
    {
        let (code, json, text) = evaluated(&["--map", map, "--policy", "none"]);
        assert_eq!((code, text.as_str()), (0, ""));
        let config = &serde_json::from_str::<serde_json::Value>(&json).unwrap()["config"];
        assert_eq!(config["vehicles_min"], vehicles, "{map}");
        assert_eq!(config["circumference_min_m"], length_m, "{map}");
    }
    for map in ["practice", "tests/data/networks/town.net.xml"] {
        let (code, _, text) = evaluated(&["--map", map]);
        assert!(code == 2 && text.contains("--traffic native or --traffic sumo"), "{code}: {text}");
    }
}

#[test]
fn whole_drives_refuse_settings_that_only_the_fast_ring_has() {
    for (setting, value, why) in [
        ("--circumference-max", "260", "--circumference-max is for traffic ring; the road of whole drives is a map"),
        ("--truck-share", "0.2", "--truck-share is for traffic ring"),
        ("--vehicles-max", "26", "--vehicles-max is 26 and --vehicles-min 22; whole drives have the same number"),
    ] {
        let (code, _, text) = evaluated(&["--traffic", "native", "--policy", "none", setting, value]);
        assert!(code == 2 && text.contains(why) && text.contains("remedy: "), "{code}: {text}");
    }
}

#[test]
fn a_policy_that_was_trained_for_other_roads_is_said_and_driven() {
    // 22 vehicles have 29.1 m each on the larger ring; the policy knows 8 to 16 m.
    let (code, text) = run(&["--traffic", "native", "--map", "ring-641", "--policy", "ring-250-speed"]);
    assert!(
        code == 0 && text.contains("`spacing` is 29.1 m on this road; the policy was trained around 8 to 16 m"),
        "{text}"
    );
    let (code, text) = run(&["--traffic", "native", "--policy", "ring-250-speed"]);
    assert_eq!((code, text.as_str()), (0, ""));
}

#[test]
fn an_evaluation_refuses_a_policy_that_its_road_lacks_before_it_drives() {
    let on_merge = ["--map", "merge", "--traffic", "sumo", "--advised", "50%", "--policy"];
    for (policy, why) in [
        ("ring-250-speed", "codrive: policy ring-250-speed needs a closed route"),
        ("constant", "codrive: policy constant needs a closed route"),
        // As in `codrive run`, auto is no advice there.
        ("auto", "--policy auto has no policy there\n  remedy: --policy pi"),
    ] {
        let (code, _, text) = evaluated(&[&on_merge[..], &[policy]].concat());
        assert!(code == 2 && text.contains(why), "{policy}, {code}: {text}");
    }
    let of_speed = ["--policy", "constant", "--policy-speed", "8"];
    let (code, _, text) = evaluated(&[&on_merge[..6], &of_speed].concat());
    assert_eq!((code, text.as_str()), (0, ""));
}

#[test]
fn a_setting_without_effect_on_the_road_is_said_and_the_drive_goes_on() {
    let (code, text) = run(&["--map", "merge", "--vehicles", "5"]);
    let begin = "codrive: warning: vehicles is 5: it has no effect on map merge";
    assert!(code == 0 && text.starts_with(begin), "{code}: {text}");
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

#[test]
fn a_map_in_the_working_folder_is_named_by_its_path() {
    let place = tempfile::tempdir().unwrap();
    let here = |arguments: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_codrive")).args(arguments).current_dir(place.path()).output().unwrap();
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert!(here(&["map", "ring", "--circumference", "300", "--out", "mine"]).0);
    let (is_found, message) = here(&["map", "show", "mine"]);
    assert!(!is_found && message.contains("named by its path: ./mine"), "{message}");
    assert!(here(&["map", "show", "./mine"]).0);
}
