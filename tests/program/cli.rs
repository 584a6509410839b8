//! The command line as users meet it: exit codes and messages of mistakes, and short runs of the commands.

use assert_cmd::Command;
use std::{
    fs,
    path::Path,
    process::{self, Stdio},
};

/// Returns the program's command without the display variables of the test environment.
pub fn codrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    command
}

/// Runs the program and returns the exit code and its standard error.
fn failure(arguments: &[&str]) -> (i32, String) {
    printed(&mut codrive(arguments))
}

fn printed(command: &mut Command) -> (i32, String) {
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

#[track_caller]
fn assert_input_error(arguments: &[&str], parts: &[&str]) {
    let (code, text) = failure(arguments);
    assert_eq!(code, 2, "{arguments:?}: {text}");
    for part in parts {
        assert!(text.contains(part), "{arguments:?} says:\n{text}\nwhich lacks: {part}");
    }
}

fn run(more: &[&str]) -> Vec<String> {
    let mut arguments = vec!["run", "--traffic", "native", "--duration", "1"];
    arguments.extend(more);
    arguments.iter().map(|a| (*a).to_owned()).collect()
}

#[track_caller]
fn assert_run_refused(more: &[&str], parts: &[&str]) {
    let arguments = run(more);
    assert_input_error(&arguments.iter().map(String::as_str).collect::<Vec<_>>(), parts);
}

#[test]
fn an_unknown_map_is_answered_with_those_that_exist() {
    assert_run_refused(&["--map", "ring-251"], &["ring-251", "practice", "ring-250", "ring-641"]);
}

#[test]
fn a_corrupt_network_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("broken.net.xml");
    fs::write(&file, "<net>\n  <edge id=\"e0\"\n</net>\n").unwrap();
    assert_run_refused(&["--map", file.to_str().unwrap()], &["broken.net.xml", "3:1"]);
    fs::write(&file, "<routes/>").unwrap();
    assert_run_refused(&["--map", file.to_str().unwrap()], &["broken.net.xml", "routes"]);
}

/// Runs the program with `input` as standard input, for at most 60 s. Returns the exit code and standard error.
fn said_in_time(arguments: &[&str], input: &[u8]) -> (Option<i32>, String) {
    let mut command = codrive(arguments);
    let output = command.write_stdin(input).timeout(std::time::Duration::from_secs(60)).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_pipe_in_the_place_of_a_file_is_named_and_never_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let study = path("short.toml");
    // A data set that was begun with this study.
    fs::create_dir(folder.path().join("session")).unwrap();
    let segment = "[[segment]]\nkind = \"text\"\nname = \"welcome\"\ntext = \"Hello\"\n";
    fs::write(&study, format!("title = \"Short\"\nparticipants = 1\nseed = 7\n{segment}")).unwrap();
    fs::copy(&study, path("session/study.toml")).unwrap();
    let rehearse = |out: &str| ["study", "rehearse", &study, "--participants", "1", "--out", out].map(str::to_owned);
    let analyse = |folder: &str| ["analyse", folder].map(str::to_owned).to_vec();
    // For each pipe: its path, the command, and the message about it.
    let table: [(&str, Vec<String>, &str); 6] = [
        (
            "train/checkpoint.json",
            vec!["train".into(), "--out".into(), path("train"), "--resume".into()],
            "it is a pipe",
        ),
        ("copy/study.toml", rehearse(&path("copy")).to_vec(), "it is a pipe"),
        ("begun/README.md", rehearse(&path("begun")).to_vec(), "holds README.md and is not the data set"),
        ("list/SHA256SUMS", analyse(&path("list")), "it is a pipe"),
        (
            "taken/lock",
            ["run", "--traffic", "native", "--duration", "1", "--out", &path("taken")].map(str::to_owned).to_vec(),
            "no file is in its place",
        ),
        ("session/sourcedata/sub-R01/lock", rehearse(&path("session")).to_vec(), "no file is in its place"),
    ];
    for (name, arguments, wanted) in table {
        let pipe = folder.path().join(name);
        fs::create_dir_all(pipe.parent().unwrap()).unwrap();
        if name.starts_with("list") {
            fs::write(path("list/dataset_description.json"), "{}").unwrap();
            fs::create_dir(path("list/sub-P01")).unwrap();
            let head = "filename\tsegment\tplace\tcondition\tseed\trecording\tbaseline\n";
            let scans = format!("{head}a\ttrial\t1\tb\t1\tsourcedata/a\tn/a\n");
            fs::write(path("list/sub-P01/sub-P01_scans.tsv"), scans).unwrap();
        }
        nix::unistd::mkfifo(&pipe, nix::sys::stat::Mode::S_IRWXU).unwrap();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (code, text) = said_in_time(&arguments, b"");
        assert!(code.is_some_and(|code| code == 1 || code == 2), "{name}: {code:?} {text}");
        let file = Path::new(name).file_name().unwrap().to_str().unwrap();
        assert!(text.contains(file) && text.contains(wanted), "{name}: {text}");
    }
}

#[test]
fn a_scenario_without_end_on_the_standard_input_is_refused_at_its_limit() {
    let (code, text) = said_in_time(&["evaluate", "--worker"], &vec![b' '; (1 << 20) + 1]);
    assert!(code == Some(2) && text.contains("it holds more than 1 MiB"), "{code:?}: {text}");
}

#[test]
fn cars_that_do_not_fit_are_refused_with_the_number_that_does() {
    assert_run_refused(&["--vehicles", "0"], &["vehicles is 0", "from 2 to 1000"]);
    assert_run_refused(&["--vehicles", "1000"], &["1000 vehicles do not fit on 250 m", "35"]);
}

#[test]
fn negative_and_nan_parameters_are_refused_with_their_limits() {
    assert_run_refused(&["--idm", "T=-1"], &["idm.T is -1", "from 0.1 to 5 s"]);
    assert_run_refused(&["--idm", "a=nan"], &["idm.a is not a finite number", "from 0.1 to 5 m/s2"]);
    assert_run_refused(&["--idm", "T=long"], &["T is `long`", "a number from 0.1 to 5 s"]);
    assert_run_refused(&["--secondary-task", "kind=nback"], &["did you mean n-back?", "detection-response"]);
    assert_run_refused(&["--secondary-task", "n=1.5"], &["n is `1.5`", "a whole number from 0 to 2"]);
    assert_run_refused(&["--idm", "tau=1"], &["`tau` is unknown", "v0, T, a, b, delta, s0, noise"]);
    assert_run_refused(&["--range", "-2"], &["range_mph is -2", "from 0.1 to 50 mph"]);
    assert_run_refused(&["--range", "inf"], &["range_mph is not a finite number"]);
}

#[test]
fn a_hold_of_nothing_or_of_half_a_step_is_refused() {
    assert_run_refused(&["--hold", "0"], &["hold_s is 0", "from 0.01 to 600 s"]);
    assert_run_refused(&["--hold", "0.25"], &["hold_s is 0.25", "whole number of steps of 0.1 s"]);
}

#[test]
fn misspelt_words_are_answered_with_those_that_exist() {
    assert_run_refused(
        &["--policy", "trpo"],
        &["`trpo` is unknown", "none, constant, two-phase, follower-stopper, pi"],
    );
    assert_run_refused(&["--driver", "me"], &["me", "follow", "perfect", "idm"]);
    assert_run_refused(&["--units", "knots"], &["knots", "mph, kmh"]);
    assert_input_error(&["run", "--traffic", "sumoo", "--duration", "1"], &["sumoo", "sumo, native"]);
    assert_input_error(&["dirve"], &["dirve"]);
    assert_run_refused(&["--vehicels", "22"], &["--vehicels", "--vehicles"]);
}

#[test]
fn a_mistake_in_a_scenario_file_is_shown_at_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trial.toml");
    let path = file.to_str().unwrap();
    fs::write(&file, "vehicles = 22\nvehicels = 20\n").unwrap();
    assert_run_refused(
        &["--scenario", path],
        &["trial.toml:2:1: unknown key `vehicels`", "2 | vehicels = 20", "^^^^^^^^"],
    );
    fs::write(&file, "\nvehicles = \"many\"\n").unwrap();
    assert_run_refused(&["--scenario", path], &["trial.toml:2:12: ", "string \"many\""]);
    fs::write(&file, "[idm]\nT = 99.0\n").unwrap();
    assert_run_refused(&["--scenario", path], &["trial.toml:2:5: idm.T is 99", "from 0.1 to 5 s"]);
    assert_run_refused(&["--scenario", "nowhere.toml"], &["nowhere.toml: cannot be read"]);
}

#[test]
fn flags_win_over_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trial.toml");
    fs::write(&file, "vehicles = 20\npolicy = \"none\"\n").unwrap();
    let arguments = run(&["--scenario", file.to_str().unwrap(), "--vehicles", "18", "--json"]);
    let output = codrive(&arguments.iter().map(String::as_str).collect::<Vec<_>>()).output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["scenario"]["vehicles"], &report["scenario"]["policy"]), (&18.into(), &"none".into()));
}

#[test]
fn without_sumo_the_remedy_is_named_and_native_traffic_drives() {
    let nowhere = tempfile::tempdir().unwrap();
    let (code, text) = printed(codrive(&["run", "--duration", "1"]).env("CODRIVE_SUMO_HOME", nowhere.path()));
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("scripts/setup") && text.contains("--traffic native"), "{text}");
    let arguments = run(&[]);
    codrive(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
        .env("CODRIVE_SUMO_HOME", nowhere.path())
        .assert()
        .success();
}

#[test]
fn without_a_display_the_window_says_what_works() {
    let (code, text) = failure(&["drive", "--traffic", "native"]);
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("display") && text.contains("codrive render"), "{text}");
}

#[test]
fn a_persons_own_wheel_profile_is_known_by_its_name() {
    let home = tempfile::tempdir().unwrap();
    let wheels = home.path().join("codrive/wheels");
    fs::create_dir_all(&wheels).unwrap();
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/wheels/g29.toml"), wheels.join("desk-rig.toml"))
        .unwrap();
    let drive = |wheel: &str| {
        let mut command = codrive(&["drive", "--traffic", "native", "--wheel", wheel]);
        printed(command.env("XDG_CONFIG_HOME", home.path()))
    };
    let (code, text) = drive("desk-rik");
    assert_eq!(code, 2, "{text}");
    assert!(
        text.contains("\"desk-rik\" (did you mean desk-rig?); there are g29, g27, g920, g923, desk-rig\n"),
        "{text}"
    );
    // With a known name the drive fails only because there is no display.
    let (code, text) = drive("desk-rig");
    assert!(code == 1 && text.contains("display"), "{text}");
    fs::write(wheels.join("desk-rig.toml"), "name = 3\n").unwrap();
    let (code, text) = drive("desk-rig");
    assert!(code == 2 && text.contains("desk-rig.toml:1:8"), "{text}");
}

#[test]
fn without_an_adapter_the_picture_says_what_to_install() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    let arguments = ["render", "--traffic", "native", "--at", "0", "--size", "64x36", "--out", file.to_str().unwrap()];
    // This backend does not exist here, so no adapter is found.
    let (code, text) = printed(codrive(&arguments).env("WGPU_BACKEND", "dx12"));
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("adapter") && text.contains("mesa-vulkan-drivers"), "{text}");
    assert!(!file.exists());
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_does_not() {
    let hash = |seed: &str| {
        let arguments = ["run", "--duration", "20", "--json", "--seed", seed];
        let output = codrive(&arguments).output().unwrap();
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["summary"]["hash"].as_str().unwrap().to_owned()
    };
    let first = hash("7");
    assert_eq!(first, hash("7"));
    assert_ne!(first, hash("8"));
}

#[test]
fn help_names_unit_and_limits_of_every_setting() {
    let output = codrive(&["run", "--help-all"]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0));
    for part in ["--hold <SECS>", "0.01 to 600 s", "--range <MPH>", "--idm <KEY=X,...>", "default ring-250"] {
        assert!(text.contains(part), "help lacks {part}:\n{text}");
    }
}

#[test]
fn a_ring_of_any_length_can_be_made_and_driven() {
    let folder = tempfile::tempdir().unwrap();
    let ring = folder.path().join("ring");
    let path = ring.to_str().unwrap();
    codrive(&["map", "ring", "--circumference", "321.5", "--out", path]).assert().success();
    codrive(&["run", "--map", path, "--duration", "1"]).assert().success();
    assert_input_error(&["map", "ring", "--circumference", "321.5", "--out", path], &[path, "exists"]);
    let other = folder.path().join("other");
    assert_input_error(
        &["map", "ring", "--circumference", "100", "--out", other.to_str().unwrap()],
        &["circumference", "150 to 5000"],
    );
}

#[test]
fn a_network_is_counted_with_what_its_closed_route_leaves_out() {
    let shown = |name: &str| {
        let file = format!("{}/tests/data/networks/{name}.net.xml", env!("CARGO_MANIFEST_DIR"));
        String::from_utf8(codrive(&["map", "show", &file]).output().unwrap().stdout).unwrap()
    };
    // A loop of four streets, the first with two lanes, a dead end and an island.
    let text = shown("one-way");
    for part in ["6, in 2 unconnected parts", "lanes          7,", "none: flat", "leaves out 3 of 7 lanes"] {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
    assert!(shown("ramps").contains("open path      1300 m; it leaves out 9 of 14 lanes"), "{}", shown("ramps"));
}

/// Returns the commands that print and can be run repeatedly, with all paths that they need.
fn talkative(folder: &Path) -> Vec<Vec<String>> {
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let made = |arguments: &[&str]| _ = codrive(arguments).assert().success();
    let record = file("recording");
    made(&["run", "--traffic", "native", "--duration", "2", "--out", &record]);
    let text = "title = \"Short\"\nparticipants = 1\n[base]\ntraffic = \"native\"\nduration_s = 2.0\n[[segment]]\n\
                kind = \"drive\"\nname = \"drive\"\ntext = \"Drive.\"\n";
    fs::write(file("study.toml"), text).unwrap();
    let (study, data) = (file("study.toml"), file("data"));
    made(&["study", "rehearse", &study, "--participants", "1", "--out", &data]);
    let picture = file("picture.png");
    let words: &[&[&str]] = &[
        &["--version"],
        &["--help"],
        &["help", "run"],
        &["run", "--traffic", "native", "--duration", "1"],
        &["run", "--traffic", "native", "--duration", "1", "--json"],
        &["render", "--traffic", "native", "--at", "0", "--size", "64x36", "--out", &picture],
        &["map", "list"],
        &["schema", "study"],
        &["study", "check", &study],
        &["study", "rehearse", &study, "--participants", "1", "--out", &data],
        &["analyse", &record],
        &["replay", &record],
        &["recover", &record],
        &["evaluate", "--policy", "none", "--over", "2", "--horizon", "1"],
        &["evaluate", "--policy", "none", "--over", "2", "--horizon", "1", "--json"],
    ];
    words.iter().map(|words| words.iter().map(|word| (*word).to_owned()).collect()).collect()
}

/// Runs the program with this standard output. Returns the exit code and standard error.
fn into_output(arguments: &[String], output: impl Into<Stdio>) -> (Option<i32>, String) {
    let mut command = process::Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let done = command.stdout(output).stderr(Stdio::piped()).spawn().unwrap().wait_with_output().unwrap();
    (done.status.code(), String::from_utf8(done.stderr).unwrap())
}

#[test]
fn every_command_ends_quietly_when_its_output_pipe_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in talkative(folder.path()) {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        // 128 and SIGPIPE, as a shell reports for any other tool.
        assert_eq!(into_output(&arguments, writer), (Some(141), String::new()), "{arguments:?}");
    }
}

#[test]
fn on_a_full_disk_every_command_says_that_its_output_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in talkative(folder.path()) {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let (code, text) = into_output(&arguments, full);
        assert_eq!(code, Some(1), "{arguments:?}: {text}");
        assert!(text.contains("the standard output cannot be written: No space left"), "{arguments:?}: {text}");
        assert!(text.contains("remedy: "), "{arguments:?}: {text}");
    }
}

#[test]
fn a_message_that_cannot_be_written_changes_no_exit_code() {
    let mut command = process::Command::new(env!("CARGO_BIN_EXE_codrive"));
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let status = command.args(["run", "--map", "nowhere"]).stderr(full).status().unwrap();
    assert_eq!(status.code(), Some(2));
}

#[test]
fn an_evaluation_is_written_even_if_its_output_pipe_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let words = ["evaluate", "--policy", "none", "--over", "2", "--horizon", "1", "--out", out.to_str().unwrap()];
    assert_eq!(into_output(&words.map(str::to_owned), writer).0, Some(141));
    assert!(out.join("summary.csv").exists());
}

#[test]
fn an_unknown_locale_changes_nothing() {
    for locale in ["C.UTF-8@x", "../x", "xx_YY.KLINGON", "xx_YY.UTF-8"] {
        let mut command = codrive(&["run", "--duration", "1"]);
        let output = command.env("LC_ALL", locale).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{locale}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn without_a_desktop_session_a_picture_is_drawn_without_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    let mut command =
        codrive(&["render", "--traffic", "native", "--at", "0", "--size", "64x36", "--out", file.to_str().unwrap()]);
    let (code, text) = printed(command.env_remove("XDG_RUNTIME_DIR"));
    assert_eq!((code, text.as_str()), (0, ""));
}

/// Returns the arguments of a drive of 1 s on the native engine, unless `more` names another engine.
fn drive_with(more: &[&str]) -> Vec<String> {
    let engine: &[&str] = if more.contains(&"--traffic") { &[] } else { &["--traffic", "native"] };
    [&["run", "--duration", "1"], engine, more].concat().iter().map(|word| (*word).to_owned()).collect()
}

#[test]
fn a_name_with_one_wrong_letter_is_answered_with_the_intended_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("trial.toml", "vehicels = 22\n");
    write("value.toml", "units = \"mhp\"\n");
    write("train.toml", "hold_max = 3\n");
    write("inputs.toml", "sees = \"speed,gapp\"\n");
    write("controller.toml", "action = \"speed\"\nresidual_over = \"linear-feedbck\"\n");
    let good = "title = \"t\"\nparticipants = 1\n[base]\ntraffic = \"native\"\nduration_s = 1.0\n[[condition]]\nname = \"a\"\n\
                [[segment]]\nkind = \"trials\"\nname = \"trial\"\n[[segment]]\nkind = \"questions\"\nname = \"load\"\n\
                questionnaire = \"raw-tlx\"\n";
    let mistakes = [
        ("key", "title", "titel", "title"),
        ("setting", "duration_s = 1.0", "duration_s = 1.0\nvehicels = 3", "vehicles"),
        ("kind", "\"trials\"", "\"trails\"", "trials"),
        ("map", "duration_s = 1.0", "duration_s = 1.0\nmap = \"rign-250\"", "ring-250"),
        ("questionnaire", "raw-tlx", "raw-txl", "raw-tlx"),
    ];
    for (name, from, to, _) in mistakes {
        write(&format!("{name}.toml"), &good.replacen(from, to, 1));
    }
    write("good.toml", good);
    let run = |more: &[&str]| drive_with(more);
    let mut asked: Vec<(Vec<String>, &str)> = vec![
        (run(&["--map", "rign-250"]), "ring-250"),
        (run(&["--map", &path("no/ring.net.xml")]), ""),
        (run(&["--policy", "folower-stopper"]), "follower-stopper"),
        (run(&["--policy", "ring-250-sped"]), "ring-250-speed"),
        (run(&["--driver", "folow"]), "follow"),
        (run(&["--driver", "eror=1"]), "error"),
        (run(&["--traffic", "natvie"]), "native"),
        (run(&["--ego-colour", "rde"]), "red"),
        (run(&["--units", "mhp"]), "mph"),
        (run(&["--vehicels", "3"]), "--vehicles"),
        (run(&["--idm", "nosie=1"]), "noise"),
        (run(&["--sound", "wind_bd=-6"]), "wind_db"),
        (run(&["--scenario", &path("trila.toml")]), "trial.toml"),
        (run(&["--scenario", &path("trial.toml")]), "vehicles"),
        (run(&["--scenario", &path("value.toml")]), "mph"),
    ];
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    asked.extend([
        (words(&["rum"]), "run"),
        (words(&["rnu"]), "run"),
        (words(&["train", "--config", &path("controller.toml"), "--out", &path("out")]), "linear-feedback"),
        (words(&["map", "lsit"]), "list"),
        (words(&["study", "chekc", &path("good.toml")]), "check"),
        (words(&["train", "--config", &path("train.toml"), "--out", &path("out")]), "hold_max_s"),
        (words(&["train", "--config", &path("inputs.toml"), "--out", &path("out")]), "gap"),
        (words(&["evaluate", "--driver", "perfcet"]), "perfect"),
        (words(&["evaluate", "--policy", "two-phsae"]), "two-phase"),
        (words(&["drive", "--wheel", "g290"]), "g29"),
        (words(&["render", "--view", "chsae", "--out", &path("a.png")]), "chase"),
        (words(&["study", "check", &path("godo.toml")]), "good.toml"),
    ]);
    asked.extend(
        mistakes.iter().map(|(name, _, _, meant)| (words(&["study", "check", &path(&format!("{name}.toml"))]), *meant)),
    );
    for (arguments, meant) in &asked {
        let (code, text) = failure(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(code, 2, "{arguments:?}: {text}");
        // clap has its own wording: "a similar argument exists: '--vehicles'".
        let near =
            text.lines().find(|line| line.contains("did you mean") || line.contains("similar")).unwrap_or_default();
        assert!(near.contains(meant) && near.is_empty() == meant.is_empty(), "{arguments:?}: {text}");
    }
    // A unit as near to one as to the other, and a picture in a format that there is not.
    assert_input_error(
        &["run", "--units", "kph"],
        &["invalid value 'kph' for '--units <WORD>'\n  [possible values: mph, kmh]"],
    );
    assert_input_error(&["render", "--out", &path("a.bmp")], &["a.bmp", "allowed: a name that ends in .png"]);
    // A participant's code, and a setting of a replay.
    let data = path("data");
    codrive(&["study", "rehearse", &path("good.toml"), "--out", &data]).assert().success();
    assert_input_error(
        &["study", "exclude", &path("good.toml"), "R10", "--from", &data, "--reason", "x"],
        &["there is no participant R10", "(did you mean R01?)"],
    );
    let drive = format!("{data}/sourcedata/sub-R01/trial-1-a");
    assert_input_error(
        &["replay", &drive, "--what-if", "polcy=none", "--out", &path("instead")],
        &["there is no setting polcy (did you mean policy?)"],
    );
}
