//! Several advised vehicles from the command line: a run that lists them, and the curve over their share.

use assert_cmd::Command;
use codrive::rng;
use std::fs;

pub fn codrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

/// Returns the exit code and the output of a command.
pub fn printed(command: &mut Command) -> (i32, String) {
    let output = command.output().expect("it runs");
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    (output.status.code().expect("it ends by itself"), text)
}

#[test]
fn a_curve_over_the_advised_share_begins_at_zero_on_the_same_seeds() {
    for engine in ["native", "ring"] {
        check_curve(engine);
    }
    for (wrong, why) in [
        (["--traffic", "ring", "--advised", "23"], "allowed: 0 to 22"),
        (["--traffic", "native", "--advised", "23"], "allowed: 0 to 22"),
        (["--traffic", "native", "--advised", "1.5"], "5% or 0.05 (100% is all)"),
    ] {
        let (code, text) = printed(codrive(&["evaluate", "--over", "2"]).args(wrong));
        assert!(code == 2 && text.contains(why), "{text}");
    }
    let mixed = ["evaluate", "--over", "2", "--vehicles-min", "18", "--advised", "4"];
    let (code, text) = printed(&mut codrive(&mixed));
    assert!(code == 2 && text.contains("--advised is 4; allowed: 1, as rings have 18 to 22 vehicles"), "{text}");
}

fn check_curve(engine: &str) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let words = [
        "evaluate",
        "--traffic",
        engine,
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
    let (code, text) = printed(codrive(&words).arg(&out));
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
    let ignores = "driven whole; ignores advice";
    assert_eq!(found, of("pi").chain(of("constant")).chain(of(ignores)).collect::<Vec<_>>());
    // With no vehicle advised, the drives of both policies are equal; with advised vehicles they differ.
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
    // Drivers who ignore the advice drive the same vehicles on the same seeds, but unlike advised drivers and unlike the engine's own.
    assert_eq!(speeds(ignores, "0"), speeds("pi", "0"));
    assert!(speeds(ignores, "11") != speeds("pi", "11") && speeds(ignores, "11") != speeds("pi", "0"));
    let drivers: Vec<&str> =
        rows[1..].iter().filter(|row| row[policy] == ignores).map(|row| row[column("driver")]).collect();
    assert_eq!(drivers, ["\"idm\""; 6]);
    let figure = fs::read_to_string(out.join("speed-against-share.svg")).unwrap();
    assert!(figure.contains("advised vehicles, % of all") && !figure.contains("NaN"));
    assert!(figure.contains(ignores) && figure.contains("even ring"), "its line has a name, and the ring its level");
}

#[test]
fn a_run_with_advised_vehicles_lists_them_and_the_mean_speed_of_all() {
    let arguments = ["run", "--traffic", "native", "--duration", "2", "--policy", "pi", "--advised", "20%"];
    let (code, text) = printed(&mut codrive(&arguments));
    assert!(code == 0 && text.contains("advised                  4 of 22 (18.2 %): vehicles 0, 5, 11, 16\n"), "{text}");
    assert!(text.contains("mean speed, all vehicles"), "{text}");
    let output = codrive(&arguments).arg("--json").output().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["advised"]["vehicles"], serde_json::json!([0, 5, 11, 16]));
    assert_eq!(report["scenario"]["advised"], "0.2");
}

#[test]
fn a_curve_on_a_network_counts_vehicles_entered_left_and_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let words = "evaluate --map merge --traffic sumo --policy pi --over 2 --horizon 30 --warm-up 0 --advised 50% --out";
    let (code, text) = printed(codrive(&words.split(' ').collect::<Vec<_>>()).arg(&out));
    assert!(code == 0 && text.contains("50.0 %") && text.contains("vehicles/h"), "{text}");
    let rings = fs::read_to_string(out.join("rings.csv")).unwrap();
    let rows: Vec<Vec<&str>> = rings.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
    let of = |name: &str| -> Vec<&str> { rows[1..].iter().map(|row| row[column(name)]).collect() };
    let ignores = "driven whole; ignores advice";
    assert_eq!(of("policy"), ["pi", "pi", "pi", "pi", ignores, ignores, ignores, ignores]);
    assert_eq!(of("advised_share"), ["0", "0", "0.5", "0.5", "0", "0", "0.5", "0.5"]);
    // The seeds and vehicles are the same, so the same number of vehicles is advised.
    let advised = of("advised_vehicles");
    assert_eq!(advised[..2], ["0", "0"]);
    assert_eq!(advised[2..4], advised[6..8]);
    // The random streams alone determine which of the 18 entering vehicles are advised.
    let chosen = |seed: u64| {
        let takes = |id: &u32| rng::stream(seed, &format!("vehicle/{id}/advised")).uniform(0.0, 1.0) < 0.5;
        (1..=18).filter(takes).count().to_string()
    };
    let seed: u64 = of("seed")[0].parse().unwrap();
    assert_eq!(advised[2..4], [chosen(seed), chosen(seed + 1)]);
    assert_ne!(advised[2], "11", "as many as of 22 cars of a ring would prove nothing");
    // In 30 s, one vehicle every 1.8 s and one every 36 s, from 0 on: 17 and 1 enter, and the free road has room for them.
    assert_eq!((of("inflow_per_h"), of("vehicles_refused")), (vec!["2160"; 8], vec!["0"; 8]));
    assert!(of("mean_speed_mps").iter().all(|speed| speed.parse::<f64>().is_ok_and(|mps| mps > 5.0)), "{rings}");
    let figure = fs::read_to_string(out.join("speed-against-share.svg")).unwrap();
    assert!(figure.contains(ignores) && !figure.contains("even ring") && !figure.contains("NaN"));
    assert!(figure.contains("vehicles that left, 1/h: pi 0 %: "), "a high speed of few vehicles is no gain");

    for (wrong, why) in [
        ("--traffic native --policy pi --advised 10%", "remedy: --traffic sumo"),
        ("--traffic sumo --policy pi", "remedy: --advised 10%,25%"),
        ("--traffic sumo --advised 10%", "remedy: --policy pi"),
        ("--traffic sumo --policy pi --advised 3", "--advised is 3; allowed on a network"),
    ] {
        let wrong: Vec<&str> = wrong.split(' ').collect();
        let (code, text) = printed(codrive(&["evaluate", "--map", "merge", "--over", "2"]).args(wrong));
        assert!(code == 2 && text.contains(why), "{text}");
    }
}
