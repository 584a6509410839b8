//! `codrive train` and what it makes, through the program itself.

use assert_cmd::Command;
use std::{fs, path::Path};

/// A training of seconds: small rings, small net.
const SMALL: &str = "vehicles_min = 8\nvehicles_max = 8\ncircumference_min_m = 100\ncircumference_max_m = 100\n\
    warm_up_s = 10\nhorizon_s = 30\nhidden_width = 8\nbatch = 640\nrings = 16\nvalue_batch = 320\njudge_every = 2\n\
    iterations = 2\n";

fn codrive(arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("codrive").unwrap().args(arguments).assert()
}

/// Exit 2 and what was said.
fn refused(arguments: &[&str]) -> String {
    let output = codrive(arguments).code(2).get_output().clone();
    String::from_utf8(output.stderr).unwrap()
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[test]
fn a_training_makes_a_policy_that_drives_and_resumes_to_the_same_bits() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("small.toml");
    fs::write(&config, SMALL).unwrap();
    let (config, whole, parts) = (text(&config), dir.path().join("whole"), dir.path().join("parts"));
    codrive(&["train", "--config", &config, "--iterations", "4", "--out", &text(&whole)]).success();
    codrive(&["train", "--config", &config, "--out", &text(&parts)]).success();
    codrive(&["train", "--resume", "--iterations", "4", "--out", &text(&parts)]).success();
    for name in ["policy.toml", "checkpoint.json", "curve.csv", "curve.svg"] {
        assert!(fs::read(whole.join(name)).unwrap() == fs::read(parts.join(name)).unwrap(), "{name}");
    }
    let policy = text(&whole.join("policy.toml"));
    let drive = ["run", "--traffic", "native", "--policy", &policy, "--duration", "5", "--json"];
    let output = codrive(&drive).success().get_output().clone();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["summary"]["advices"], 5, "one a second");
    codrive(&["evaluate", "--config", &config, "--policy", &policy, "--policy", "none"]).success();

    // Nothing is overwritten, and a training is resumed only as it was.
    let before = fs::read(whole.join("policy.toml")).unwrap();
    let said = refused(&["train", "--config", &config, "--out", &text(&whole)]);
    assert!(said.contains("holds a training already (policy.toml)"), "{said}");
    let said = refused(&["train", "--resume", "--seed", "7", "--out", &text(&whole)]);
    assert!(said.contains("was trained with `seed = 1`, not `seed = 7`"), "{said}");
    assert_eq!(fs::read(whole.join("policy.toml")).unwrap(), before);
}

#[test]
fn bad_configurations_are_named_with_what_is_allowed() {
    let dir = tempfile::tempdir().unwrap();
    let out = text(&dir.path().join("out"));
    let file = dir.path().join("train.toml");
    let said = |content: &str| {
        fs::write(&file, content).unwrap();
        refused(&["train", "--config", &text(&file), "--out", &out])
    };
    assert!(said("hold_s = 1\nhoold_s = 2\n").contains("train.toml:2:1: unknown key `hoold_s`"));
    assert!(said("max_kl = -1").contains("train.toml:1:10: max_kl is -1.0; allowed: a number from 0.000001 to 1 nat"));
    assert!(said("rings = 20").contains("rings is 20; allowed: a multiple of 16"));
    assert!(said("vehicles_max = 40").contains("vehicles_max is 40; allowed: at most 28"));
    assert!(said("hold_s = 0.25").contains("hold_s is 0.25; allowed: a whole number of steps of 0.1 s"));
    assert!(!Path::new(&out).join("train.toml").exists());
}

#[test]
fn a_file_that_is_no_policy_is_refused_before_the_drive() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("foreign.toml");
    let said = |content: Option<&str>| {
        content.inspect(|c| fs::write(&file, c).unwrap());
        refused(&["run", "--traffic", "native", "--policy", &text(&file), "--duration", "5"])
    };
    assert!(said(None).contains("foreign.toml: cannot be read"), "{}", said(None));
    assert!(said(Some("speed = 3")).contains("foreign.toml: is no policy file"));
    assert!(said(Some("format = ")).contains("foreign.toml: is no policy file"));
}
