//! The analysis that a preregistration announces, against the analysis of a rehearsal's data: numbers, and each test line by line.

use super::{
    bids::root,
    common::{codrive, table, text},
};
use std::{collections::BTreeMap, fs};

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
            // The practice has its settings on one line. Only SUMO drives a town.
            None => line
                .replace(
                    "duration_s = 420.0, warm_up_s = 120.0",
                    "traffic = \"sumo\", duration_s = 4.0, warm_up_s = 0.0",
                )
                .replace("duration_s = 180.0", "duration_s = 4.0"),
        }
    };
    // Nothing is to be measured of events in so short a drive: another outcome stands for theirs.
    let of_events = |line: &str, key: &str| {
        ["event_", "takeover_"]
            .iter()
            .any(|of| line.starts_with(&format!("{key} = \"{of}")) || line.starts_with(&format!("{key} = [\"{of}")))
    };
    let outcome =
        |line: String| if of_events(&line, "primary") { "primary = \"ego_mean_speed_mps\"".into() } else { line };
    // No symptom score ends a session.
    let lines = text.lines().filter(|line| !line.starts_with("stop_above") && !of_events(line, "secondary"));
    let short = lines.map(line).map(outcome).map(|line| early(&line)).collect::<Vec<_>>().join("\n");
    // The native engine drives no motorway, and a ring starts at once.
    short.replace("map = \"motorway\"", "map = \"ring-250\"").replacen("[base]", "[base]\ntraffic = \"native\"", 1)
}

/// Returns a line of a study whose triggers on times come true in the first second.
fn early(line: &str) -> String {
    let mut parts = line.split("{ time_s = ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let rest = part.trim_start_matches(|letter: char| letter.is_ascii_digit() || letter == '.');
        text + "{ time_s = 1.0" + rest
    })
}

/// Returns the number before these words.
fn number_before(text: &str, words: &str) -> usize {
    let at = text.find(words).unwrap_or_else(|| panic!("{words}: {text}"));
    let before = text[..at].trim_end().rsplit(' ').next().unwrap();
    before.parse().unwrap_or_else(|e| panic!("{before}: {e}"))
}

/// Preregistration, report and table of the contrasts of a rehearsed study.
struct Rehearsed {
    plan: String,
    report: String,
    contrasts: Vec<BTreeMap<String, String>>,
}

/// Preregisters a study, rehearses it with this number of participants, and analyses the data.
fn rehearsed(study: &str, participants: &str) -> Rehearsed {
    let place = tempfile::tempdir().unwrap();
    let [file, data, plan] =
        ["study.toml", "data", "plan.md"].map(|name| place.path().join(name).to_str().unwrap().to_owned());
    fs::write(&file, study).unwrap();
    for arguments in [
        vec!["study", "preregister", &file, "--participants", participants, "--out", &plan],
        vec!["study", "rehearse", &file, "--participants", participants, "--out", &data],
        vec!["analyse", &data],
    ] {
        let output = codrive(&arguments, "warn");
        assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    }
    let results = place.path().join("data/derivatives/codrive");
    Rehearsed {
        plan: fs::read_to_string(plan).unwrap(),
        report: fs::read_to_string(results.join("report.html")).unwrap(),
        contrasts: table(&results.join("models.csv")).into_iter().filter(|row| row["kind"] == "contrast").collect(),
    }
}

/// Returns tests and trials of the preregistration, tests of the report, and rows of contrasts in its table.
fn counted(study: &str) -> [usize; 4] {
    let Rehearsed { plan, report, contrasts } = rehearsed(study, "4");
    [
        number_before(&plan, "tests of the plan"),
        number_before(&plan, "trials, one in each"),
        number_before(&report, "tests by Holm"),
        contrasts.len(),
    ]
}

/// Returns the tests that a preregistration lists: role, outcome, condition and reference.
fn planned_tests(plan: &str) -> Vec<[String; 4]> {
    let begins = "| test | role | outcome | condition | reference |\n";
    let rows = plan.split_once(begins).unwrap_or_else(|| panic!("{plan}")).1.lines().skip(1);
    let cells = |row: &str| -> Vec<String> { row.split('|').map(|cell| cell.trim().replace('`', "")).collect() };
    let rows = rows.take_while(|row| row.starts_with('|')).map(cells);
    rows.enumerate()
        .map(|(i, row)| {
            assert_eq!(row[1], (i + 1).to_string());
            [2, 3, 4, 5].map(|k| row[k].clone())
        })
        .collect()
}

/// Returns p by Holm (1979) for a family of tests: sorted from the smallest, the k-th of n times n - k + 1, never below one before it.
fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let (mut corrected, mut most) = (vec![0.0; p.len()], 0.0_f64);
    for (rank, test) in order.into_iter().enumerate() {
        most = most.max((p[test] * (p.len() - rank) as f64).min(1.0));
        corrected[test] = most;
    }
    corrected
}

#[test]
fn each_shipped_study_is_analysed_by_the_tests_of_its_preregistration() {
    let studies: Vec<_> =
        fs::read_dir(root().join("assets/studies")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let studies = studies.iter().filter(|path| path.extension().is_some_and(|end| end == "toml"));
    let names: Vec<&str> = studies.map(|path| path.file_stem().unwrap().to_str().unwrap()).collect();
    assert!(names.len() >= 3, "{names:?}");
    for name in names {
        // Three participants are enough for a model with the conditions as terms and the participant as random intercept.
        let Rehearsed { plan, contrasts, .. } = rehearsed(&short(name), "3");
        let made: Vec<[String; 4]> = contrasts
            .iter()
            .map(|row| ["role", "outcome", "condition", "reference"].map(|key| row[key].clone()))
            .collect();
        let planned = planned_tests(&plan);
        assert_eq!(planned.len(), made.len(), "{name}: {made:?}");
        for (line, (planned, made)) in planned.iter().zip(&made).enumerate() {
            assert_eq!(planned, made, "{name}: test {}", line + 1);
        }
        // All of these tests are one family of Holm's correction.
        let number = |row: &BTreeMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
        let corrected = holm(&contrasts.iter().map(|row| number(row, "p")).collect::<Vec<_>>());
        for (row, corrected) in contrasts.iter().zip(corrected) {
            assert_eq!(row["holm_tests"], planned.len().to_string(), "{name}: {row:?}");
            assert!((number(row, "p_holm") - corrected).abs() <= 1e-9, "{name}: {row:?} {corrected}");
        }
    }
}

#[test]
fn plan_and_analysis_test_no_outcome_of_advice_against_no_advice() {
    let study = short("congestion-short").replace("\"fuel_l_100km\"]", "\"fuel_l_100km\", \"speed_error_mps\"]");
    // Twelve less two: without advice there is no target speed.
    assert_eq!(counted(&study), [10, 3, 10, 10]);
}
