//! The analysis that a preregistration announces, against the analysis of a rehearsal's data.

use super::{
    bids::root,
    common::{codrive, table, text},
};
use std::fs;

/// Returns a shipped study with short drives that begin at once on the native engine; plan and conditions stay.
fn short(name: &str) -> String {
    let file = root().join("assets/studies").join(format!("{name}.toml"));
    let text = fs::read_to_string(file).unwrap();
    let line = |line: &str| -> String {
        let set = [
            ("warm_up_s = ", "0.0"),
            ("wave_sd_mps = ", "0.0"),
            ("standing_start = ", "false"),
            ("duration_s = ", "4.0"),
        ];
        match set.iter().find(|(key, _)| line.starts_with(key)) {
            Some((key, value)) => format!("{key}{value}"),
            // Duration of the practice, which is one of several settings on its line.
            None => line.replace("duration_s = 420.0", "duration_s = 4.0"),
        }
    };
    // No symptom score ends a session.
    let lines = text.lines().filter(|line| !line.starts_with("stop_above"));
    let short = lines.map(line).collect::<Vec<_>>().join("\n");
    short.replacen("[base]", "[base]\ntraffic = \"native\"", 1)
}

/// Returns the number before these words.
fn number_before(text: &str, words: &str) -> usize {
    let at = text.find(words).unwrap_or_else(|| panic!("{words}: {text}"));
    let before = text[..at].trim_end().rsplit(' ').next().unwrap();
    before.parse().unwrap_or_else(|e| panic!("{before}: {e}"))
}

/// Returns tests and trials of the preregistration, tests of the report, and rows of contrasts in its table.
fn counted(study: &str) -> [usize; 4] {
    let place = tempfile::tempdir().unwrap();
    let [file, data, plan] =
        ["study.toml", "data", "plan.md"].map(|name| place.path().join(name).to_str().unwrap().to_owned());
    fs::write(&file, study).unwrap();
    for arguments in [
        vec!["study", "preregister", &file, "--participants", "4", "--out", &plan],
        vec!["study", "rehearse", &file, "--participants", "4", "--out", &data],
        vec!["analyse", &data],
    ] {
        let output = codrive(&arguments, "warn");
        assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    }
    let plan = fs::read_to_string(plan).unwrap();
    let results = place.path().join("data/derivatives/codrive");
    let report = fs::read_to_string(results.join("report.html")).unwrap();
    let rows = table(&results.join("models.csv")).into_iter().filter(|row| row["kind"] == "contrast").count();
    [
        number_before(&plan, "tests of the plan"),
        number_before(&plan, "trials, one in each"),
        number_before(&report, "tests by Holm"),
        rows,
    ]
}

#[test]
fn plan_and_analysis_test_no_outcome_of_advice_against_no_advice() {
    let study = short("congestion-short").replace("\"fuel_l_100km\"]", "\"fuel_l_100km\", \"speed_error_mps\"]");
    // Twelve less two: without advice there is no target speed.
    assert_eq!(counted(&study), [10, 3, 10, 10]);
}
