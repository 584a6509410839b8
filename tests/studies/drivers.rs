//! Estimated driver traits: the analysis recovers the known traits of a rehearsal's participants, and another rehearsal drives with them.
//! In: a small study on the native engine. Out: estimates near the true values, within what drives can tell.

use crate::common::{codrive, table, text};
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

/// A study with one advised drive of 400 s per participant, on a ring with a wave.
const STUDY: &str = r#"title = "Who drove"
participants = 8
seed = 3
[base]
traffic = "native"
warm_up_s = 60.0
start = "bunched"
duration_s = 400.0
hold_s = 5.0
policy = "ring-250-speed"
[[segment]]
kind = "drive"
name = "drive"
"#;

/// Driver traits of eight participants. The last two lack some: a missing reaction time or error is drawn, a missing time gap factor is
/// not.
const PEOPLE: &str = r#"format = "codrive drivers 1"
study = "A laboratory's"
[[driver]]
reaction_s = 0.6
error_mps = 0.45
speed_bias_mps = -0.5
time_gap_factor = 1.0
[[driver]]
reaction_s = 1.9
error_mps = 0.25
speed_bias_mps = 0.4
time_gap_factor = 0.8
[[driver]]
reaction_s = 1.1
error_mps = 0.3
speed_bias_mps = 0.1
time_gap_factor = 1.5
[[driver]]
reaction_s = 0.8
error_mps = 0.2
speed_bias_mps = -0.2
time_gap_factor = 1.2
[[driver]]
reaction_s = 1.5
error_mps = 0.5
speed_bias_mps = 0.6
time_gap_factor = 1.1
[[driver]]
reaction_s = 1.3
error_mps = 0.35
speed_bias_mps = 0.25
time_gap_factor = 0.9
[[driver]]
time_gap_factor = 1.35
[[driver]]
reaction_s = 0.7
speed_bias_mps = 0.3
"#;

type Row = BTreeMap<String, String>;

/// Writes this study and the named files into a temporary folder. Returns it and the path of the data set.
fn place(study: &str, files: &[(&str, &str)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("study.toml", study)].iter().chain(files) {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let out = folder.path().join("data");
    (folder, out)
}

fn run(arguments: &[&str]) -> (i32, String) {
    let output = codrive(arguments, "error");
    (output.status.code().unwrap(), text(&output))
}

fn rehearse(folder: &Path, out: &Path, participants: &str, drivers: Option<&Path>) -> (i32, String) {
    let study = folder.join("study.toml");
    let mut arguments = vec!["study", "rehearse", study.to_str().unwrap(), "--participants", participants];
    arguments.extend(["--out", out.to_str().unwrap()]);
    if let Some(drivers) = drivers {
        arguments.extend(["--drivers", drivers.to_str().unwrap()]);
    }
    run(&arguments)
}

fn number(row: &Row, name: &str) -> Option<f64> {
    row.get(name).and_then(|cell| cell.parse().ok())
}

/// Returns true value, estimate and ends of the interval of each participant that has all four.
fn pairs(truth: &[Row], found: &[Row], true_name: &str, names: [&str; 3]) -> Vec<[f64; 4]> {
    let pair = |(truth, found): (&Row, &Row)| {
        assert_eq!(truth["participant_id"], found["participant"]);
        let [value, low, high] = names.map(|name| number(found, name));
        Some([number(truth, true_name)?, value?, low?, high?])
    };
    truth.iter().zip(found).filter_map(pair).collect()
}

/// Returns Pearson's correlation of true values and estimates.
fn correlation(pairs: &[[f64; 4]]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |k: usize| pairs.iter().map(|pair| pair[k]).sum::<f64>() / n;
    let (a, b) = (mean(0), mean(1));
    let sum = |of: &dyn Fn(&[f64; 4]) -> f64| pairs.iter().map(of).sum::<f64>();
    let squares = [sum(&|pair| (pair[0] - a).powi(2)), sum(&|pair| (pair[1] - b).powi(2))];
    sum(&|pair| (pair[0] - a) * (pair[1] - b)) / (squares[0] * squares[1]).sqrt()
}

fn is_within(pair: &[f64; 4]) -> bool {
    (pair[2]..=pair[3]).contains(&pair[0])
}

#[test]
fn estimated_drivers_match_the_true_ones_and_drive_the_next_rehearsal() {
    let (folder, out) = place(STUDY, &[("people.toml", PEOPLE)]);
    let (code, printed) = rehearse(folder.path(), &out, "8", Some(&folder.path().join("people.toml")));
    assert!(code == 0 && printed.contains("8 of 8 participants"), "{printed}");
    let (code, printed) = run(&["analyse", out.to_str().unwrap()]);
    assert!(code == 0, "{printed}");
    let truth = table(&out.join("participants.tsv"));
    let report = out.join("derivatives/codrive");
    let found = table(&report.join("drivers.csv"));
    assert_eq!((truth.len(), found.len()), (8, 8));
    assert_eq!(truth[0]["true_reaction_s"], "0.6", "as the file has it");
    let drawn = number(&truth[6], "true_reaction_s").unwrap();
    assert!((0.6..1.6).contains(&drawn) && truth[7]["true_time_gap_factor"] == "n/a", "{truth:?}");

    let of = |true_name: &str, names: [&str; 3]| pairs(&truth, &found, true_name, names);
    let reactions = of("true_reaction_s", ["reaction_s", "reaction_low_s", "reaction_high_s"]);
    let biases = of("true_overspeed_mps", ["speed_bias_mps", "speed_bias_low_mps", "speed_bias_high_mps"]);
    let errors = of("true_error_mps", ["error_mps", "error_low_mps", "error_high_mps"]);
    let gaps = of("true_time_gap_factor", ["time_gap_factor", "time_gap_factor_low", "time_gap_factor_high"]);
    assert_eq!([reactions.len(), biases.len(), errors.len()], [8; 3], "{found:?}");
    assert!(gaps.len() >= 4, "on a ring with a wave most are behind somebody for half a minute: {gaps:?}");
    for pair in &reactions {
        // The limit is smaller than the spread of reaction times between people (docs/references.md: drivers), so that participants can be
        // told apart.
        assert!((pair[1] - pair[0]).abs() < 0.25, "{pair:?}");
    }
    for pair in &biases {
        // The mean of an error of 0.35 m/s with a correlation time of 5 s has a standard error of 0.07 m/s over the 270 s in which the
        // advice decides.
        assert!((pair[1] - pair[0]).abs() < 0.15 || is_within(pair), "{pair:?}");
    }
    for pair in &errors {
        // 270 s are 27 independent samples of that error: a standard error of 14 %; the limit is twice that.
        assert!((pair[1] / pair[0] - 1.0).abs() < 0.3, "{pair:?}");
    }
    for pair in &gaps {
        // The limit is half the step to the next driver of this study.
        assert!((pair[1] - pair[0]).abs() < 0.1, "{pair:?}");
    }
    for (pairs, least) in [(&reactions, 0.95), (&biases, 0.95), (&errors, 0.9), (&gaps, 0.95)] {
        assert!(correlation(pairs) > least, "{} of {pairs:?}", correlation(pairs));
    }
    // 95 % of 28 or more values should lie in their intervals; by chance fewer than 80 % of 28 do in one of 500 studies.
    let all: Vec<&[f64; 4]> = [&reactions, &biases, &errors, &gaps].into_iter().flatten().collect();
    let share = all.iter().filter(|pair| is_within(pair)).count() as f64 / all.len() as f64;
    assert!(share >= 0.8, "{share}: {all:?}");

    let methods = fs::read_to_string(report.join("methods.txt")).unwrap();
    assert!(
        methods.contains("Each participant was described by the parameters of codrive's simulated driver"),
        "{methods}"
    );
    let html = fs::read_to_string(report.join("report.html")).unwrap();
    assert!(html.contains("<h2>Drivers</h2>") && html.contains("<code>reaction_rests_on_s</code>"));

    // The next rehearsal drives with the estimates: its true values are those of the file, in turn.
    let (next, next_out) = place(&STUDY.replace("400.0", "10.0"), &[]);
    let (code, printed) = rehearse(next.path(), &next_out, "9", Some(&report.join("drivers.toml")));
    assert!(code == 0, "{printed}");
    let driven = table(&next_out.join("participants.tsv"));
    for (i, row) in driven.iter().enumerate() {
        let [now, found] = [number(row, "true_reaction_s"), number(&found[i % 8], "reaction_s")].map(Option::unwrap);
        assert!((now - found).abs() < 0.001, "participant {i}: {now}, {found}");
    }
}

#[test]
fn a_rehearsal_continues_with_the_same_drivers_only() {
    let other = PEOPLE.replace("reaction_s = 0.6", "reaction_s = 0.65");
    let longer = PEOPLE.to_owned() + "[[driver]]\n";
    let study = STUDY.replace("400.0", "5.0");
    let (folder, out) = place(&study, &[("people.toml", PEOPLE), ("other.toml", &other), ("longer.toml", &longer)]);
    let go = |participants: &str, drivers: Option<&str>| {
        rehearse(folder.path(), &out, participants, drivers.map(|name| folder.path().join(name)).as_deref())
    };
    assert_eq!(go("1", Some("people.toml")).0, 0);
    for drivers in [None, Some("other.toml")] {
        let (code, printed) = go("2", drivers);
        assert!(code != 0 && printed.contains("participant R01 began as another driver"), "{drivers:?}: {printed}");
        assert!(
            printed.contains("reaction_s was 0.6 ") && printed.contains("repeat the earlier --drivers"),
            "{printed}"
        );
    }
    assert!(!out.join("sourcedata/sub-R02").exists(), "nobody drove meanwhile");
    assert_eq!(go("2", Some("people.toml")).0, 0);
    assert_eq!(go("2", Some("longer.toml")).0, 0, "both drive as they did");
}

#[test]
fn a_faulty_driver_file_is_reported_and_nothing_is_written() {
    let slip = PEOPLE.replacen("reaction_s", "reacton_s", 1);
    let far = PEOPLE.replacen("time_gap_factor = 1.0", "time_gap_factor = 10", 1);
    let (folder, out) = place(STUDY, &[("slip.toml", &slip), ("far.toml", &far)]);
    for (name, parts) in [
        ("slip.toml", ["slip.toml:4:1: unknown key `reacton_s`", "did you mean `reaction_s`?"]),
        ("far.toml", ["far.toml:7:19: time_gap_factor is 10", "allowed: a number from 0.2 to 5"]),
        ("slipp.toml", ["slipp.toml: cannot be read", "did you mean slip.toml?"]),
    ] {
        let (code, printed) = rehearse(folder.path(), &out, "1", Some(&folder.path().join(name)));
        assert!(code == 2 && parts.iter().all(|part| printed.contains(part)), "{name}: {code} {printed}");
    }
    assert!(!out.exists());
    let study = folder.path().join("study.toml");
    let (code, printed) = run(&["study", "check", study.to_str().unwrap(), "--drivers", "slip.toml"]);
    assert!(code == 2 && printed.contains("unexpected argument '--drivers'"), "{printed}");
}
