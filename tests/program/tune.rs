//! `codrive tune` as users meet it: the file that it writes can drive, and mistakes are reported before anything runs.

use assert_cmd::Command;
use std::fs;

fn codrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

/// Runs the program. Returns the exit code, standard output and standard error.
fn printed(arguments: &[&str]) -> (i32, String, String) {
    let output = codrive(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Options of a search that takes about a second.
const SHORT: [&str; 10] =
    ["--budget", "8", "--over", "4", "--horizon", "20", "--warm-up", "5", "--driver", "reaction=1,error=0.5"];

#[test]
fn a_tuned_controller_is_a_file_that_drives_and_can_be_tuned_further() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (first, second, again) = (path("new/first.toml"), path("second.toml"), path("again.toml"));
    let tune = |policy: &str, out: &str| {
        let (code, message, error) = printed(&[&["tune", "--policy", policy, "--out", out][..], &SHORT].concat());
        assert_eq!(code, 0, "{error}");
        assert!(
            message.starts_with(out) && message.contains(" before; 8 of 8 parameter sets tried on 4 rings"),
            "{message}"
        );
        fs::read_to_string(out).unwrap()
    };
    let text = tune("two-phase", &first);
    assert!(text.contains("\nkind = \"two-phase\"\n") && text.contains("reaction 1 s, error 0.5 m/s"), "{text}");
    assert_eq!(text, tune("two-phase", &again), "the same seed");
    assert!(tune(&first, &second).contains(&format!(" before ({first})")));
    let words = ["evaluate", "--policy", &first, "--over", "2", "--horizon", "5", "--warm-up", "5"];
    let (code, table, error) = printed(&words);
    assert!(code == 0 && table.contains("first.toml"), "{table}{error}");
    let (code, _, error) = printed(&["run", "--traffic", "native", "--duration", "2", "--policy", &first]);
    assert_eq!(code, 0, "{error}");
}

#[test]
fn mistakes_are_reported_before_anything_is_driven() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("mine.toml");
    let out = out.to_str().unwrap();
    let refused = |arguments: &[&str], parts: &[&str]| {
        let (code, _, text) = printed(&[&["tune"][..], arguments].concat());
        assert_eq!(code, 2, "{arguments:?}: {text}");
        for part in parts {
            assert!(text.contains(part), "{arguments:?} says:\n{text}\nwhich lacks: {part}");
        }
    };
    refused(&["--policy", "two-phsae", "--out", out], &["did you mean two-phase?", "constant, two-phase"]);
    refused(
        &["--policy", "ring-250-speed", "--out", out],
        &["controller `ring-250-speed` is unknown", "or the FILE.toml"],
    );
    refused(
        &["--policy", "pi", "--out", "mine"],
        &["invalid value 'mine' for '--out", "allowed: a name that ends in .toml"],
    );
    refused(&["--policy", "pi", "--holds", "0.25", "--out", out], &["hold_s is 0.25", "0.1 s"]);
    refused(&["--policy", "pi", "--driver", "folow", "--out", out], &["did you mean follow"]);
    refused(&["--policy", "pi", "--budget", "1", "--out", out], &["--budget"]);
    fs::write(out, "format = \"codrive controller 1\"\nkind = \"pi\"\nmean = 38\n").unwrap();
    refused(&["--policy", "pi", "--out", out], &["mine.toml: is there already", "--out"]);
    let other = folder.path().join("other.toml");
    refused(
        &["--policy", out, "--out", other.to_str().unwrap()],
        &["mine.toml:3:1: unknown key `mean`", "did you mean `mean_s`?"],
    );
    assert!(!other.exists());
}
