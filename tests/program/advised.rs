//! Several advised vehicles from the command line: a run that says which, and the curve over their share.

use assert_cmd::Command;
use std::fs;

fn codrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

/// Exit code and all that was said.
fn said(command: &mut Command) -> (i32, String) {
    let output = command.output().expect("it runs");
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    (output.status.code().expect("it ends by itself"), text)
}

#[test]
fn a_curve_over_advised_vehicles_begins_with_nobody_on_the_same_seeds_and_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let words = [
        "evaluate",
        "--traffic",
        "native",
        "--policy",
        "pi",
        "--policy",
        "constant",
        "--driver",
        "perfect",
        "--over",
        "2",
        "--horizon",
        "4",
        "--warm-up",
        "3",
        "--advised",
        "50%,3,0",
        "--out",
    ];
    let (code, text) = said(codrive(&words).arg(&out));
    assert!(code == 0 && text.contains("11/22"), "{text}");
    let rings = fs::read_to_string(out.join("rings.csv")).unwrap();
    let rows: Vec<Vec<&str>> = rings.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
    let (policy, ring, speed, advised) =
        (column("policy"), column("ring"), column("mean_speed_mps"), column("advised_vehicles"));
    let found: Vec<_> = rows[1..].iter().map(|row| (row[policy], row[advised], row[ring])).collect();
    let of = |policy: &'static str| {
        ["0", "3", "11"].into_iter().flat_map(move |advised| ["0", "1"].map(|ring| (policy, advised, ring)))
    };
    assert_eq!(found, of("pi").chain(of("constant")).collect::<Vec<_>>());
    // Nobody is advised by either policy in the same drives; with somebody advised they differ.
    let speeds = |policy_is: &str, advised_is: &str| -> Vec<&str> {
        rows[1..]
            .iter()
            .filter(|row| row[policy] == policy_is && row[advised] == advised_is)
            .map(|row| row[speed])
            .collect()
    };
    assert_eq!(speeds("pi", "0"), speeds("constant", "0"));
    assert_ne!(speeds("pi", "0")[0], speeds("pi", "0")[1], "each ring has a seed of its own");
    assert_ne!(speeds("pi", "0"), speeds("pi", "11"));
    let figure = fs::read_to_string(out.join("speed-against-share.svg")).unwrap();
    assert!(figure.contains("advised vehicles, % of all") && !figure.contains("NaN"));

    for (wrong, why) in [
        (["--engine", "ring", "--advised", "5%"], "engine ring has one advised car"),
        (["--engine", "native", "--advised", "23"], "allowed: 0 to 22"),
        (["--engine", "native", "--advised", "1.5"], "5% or 0.05 (100% is all)"),
    ] {
        let (code, text) = said(codrive(&["evaluate", "--over", "2"]).args(wrong));
        assert!(code == 2 && text.contains(why), "{text}");
    }
}

#[test]
fn a_run_with_a_share_of_the_vehicles_advised_says_which_and_how_fast_all_are() {
    let arguments = ["run", "--traffic", "native", "--duration", "2", "--policy", "pi", "--advised", "20%"];
    let (code, text) = said(&mut codrive(&arguments));
    assert!(code == 0 && text.contains("advised                  4 of 22 (18.2 %): cars 0, 5, 11, 16\n"), "{text}");
    assert!(text.contains("mean speed, all cars"), "{text}");
    let output = codrive(&arguments).arg("--json").output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["advised"]["vehicles"], serde_json::json!([0, 5, 11, 16]));
    assert_eq!(report["scenario"]["advised"], "0.2");
}
