//! A rehearsed study with consent, screening, a limit and questionnaires after every trial: its plan, data set and analysis. Then one
//! participant's data are exported, and another participant is erased.

use crate::common::{codrive, table, text};
use std::{collections::BTreeSet, fs, path::Path};

const STUDY: &str = r#"title = "People"
participants = 3
seed = 7
[base]
traffic = "native"
warm_up_s = 0.0
duration_s = 4.0
hold_s = 2.0
[factors]
range = [{ name = "narrow", set = { range_mph = 0.75 } }, { name = "wide", set = { range_mph = 2.0 } }]
[[segment]]
kind = "consent"
name = "consent"
text = "You will drive a car."
[[segment]]
kind = "questions"
name = "screening"
questionnaire = "screening"
ends_if = ["{licence} = false", "{vision} = 'uncorrected'", "{seizures} = true", "{medication} = true", "{unwell} = true"]
[[segment]]
kind = "questions"
name = "about-you"
questionnaire = "sample"
[[segment]]
kind = "trials"
name = "trial"
rest_s = 10.0
after = ["trust", "nasa-tlx"]
[[segment]]
kind = "questions"
name = "acceptance"
questionnaire = "van-der-laan"
"#;

fn study(folder: &Path, from: &str, to: &str) -> String {
    assert!(STUDY.contains(from), "{from}");
    let path = folder.join("people.toml");
    fs::write(&path, STUDY.replacen(from, to, 1)).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Runs the program and returns its exit code and output.
fn printed(arguments: &[&str]) -> (i32, String) {
    let output = codrive(arguments, "warn");
    (output.status.code().unwrap_or(-1), text(&output))
}

#[test]
fn questionnaires_after_trials_have_trial_and_condition_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let file = study(folder.path(), "seed = 7", "seed = 7");
    let data = folder.path().join("data");
    let out = data.to_str().unwrap();

    let (code, plan) = printed(&["study", "check", &file]);
    assert!(
        code == 0 && plan.contains("trial-2-wide-nasa-tlx") && plan.contains(" 0.7 min  questions: trust"),
        "{plan}"
    );
    let (code, words) = printed(&["study", "rehearse", &file, "--out", out]);
    // Simulated participants consent and pass the screening.
    assert!(code == 0 && words.contains("3 of 3 participants completed the study"), "{words}");
    assert!(table(&data.join("phenotype/consent.tsv")).iter().all(|row| row["agree"] == "true"));

    // One table per place: each participant meets both conditions, at places 1 and 2.
    let tlx: Vec<_> =
        [1, 2].iter().flat_map(|i| table(&data.join(format!("phenotype/trial_{i}_nasa_tlx.tsv")))).collect();
    let key: BTreeSet<[&str; 2]> = tlx.iter().map(|row| [&*row["participant_id"], &*row["condition"]]).collect();
    assert_eq!((tlx.len(), key.len()), (6, 6));
    let names = ["mental", "physical", "temporal", "performance", "effort", "frustration"];
    for row in &tlx {
        // The weights are counted from the pairs and sum to 15.
        let count =
            |name: &str| row.iter().filter(|(key, value)| key.contains("-or-") && *value == name).count() as f64;
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert_eq!(names.iter().map(|name| count(name)).sum::<f64>(), 15.0);
        let wanted = names.iter().map(|name| count(name) * number(name)).sum::<f64>() / 15.0;
        assert!((number("score_weighted-tlx") - wanted).abs() < 1e-5, "{row:?}");
    }
    let scans = table(&data.join("sub-R02/sub-R02_scans.tsv"));
    // The list of scans has questionnaires about a trial with the place and condition of the trial.
    let of_trial = |name: &str| scans.iter().filter(|scan| scan["filename"].contains(name)).collect::<Vec<_>>();
    let places =
        |name: &str| of_trial(name).iter().map(|s| [s["place"].clone(), s["condition"].clone()]).collect::<Vec<_>>();
    assert_eq!(places("_task-trialTrust_"), places("_task-trial_"));
    for scan in of_trial("_task-trial_") {
        let place = &scan["place"];
        let answers = table(&data.join(format!("sub-R02/beh/sub-R02_task-trialTrust_run-{place}_beh.tsv")));
        assert_eq!(answers.len(), 4);
        assert!(
            answers.iter().all(|row| row["place"] == *place && row["condition"] == scan["condition"]),
            "{answers:?}"
        );
    }

    let (code, words) = printed(&["analyse", out]);
    assert_eq!(code, 0, "{words}");
    let scores = table(&data.join("derivatives/codrive/scores.csv"));
    let trust = |row: &&std::collections::BTreeMap<String, String>| row["questionnaire"] == "trial_trust";
    assert_eq!(scores.iter().filter(trust).count(), 6);
    for row in scores.iter().filter(trust) {
        let phenotype = table(&data.join(format!("phenotype/trial_{}_trust.tsv", row["place"])));
        let same =
            phenotype.iter().find(|p| p["participant_id"] == row["participant"] && p["place"] == row["place"]).unwrap();
        assert_eq!((&same["score_trust"], &same["condition"]), (&row["value"], &row["condition"]));
    }
    let report = fs::read_to_string(data.join("derivatives/codrive/report.html")).unwrap();
    for has in ["trial trust, narrow", "trial nasa tlx, wide", "<td>acceptance</td>"] {
        assert!(report.contains(has), "{has}");
    }

    // One participant's data are exported; another is erased, and the analysis continues with the rest.
    let mine = folder.path().join("mine");
    let (code, words) = printed(&["study", "export", &file, "R02", "--from", out, "--to", mine.to_str().unwrap()]);
    assert!(code == 0 && words.contains("all that"), "{words}");
    assert_eq!(table(&mine.join("derivatives/codrive/trials.csv")).len(), 2);
    assert!(
        mine.join("sourcedata/sub-R02/trial-1-narrow/manifest.json").exists()
            || mine.join("sourcedata/sub-R02/trial-1-wide/manifest.json").exists()
    );
    let (code, words) = printed(&["study", "erase", &file, "R01", "--from", out, "--reason", "withdrew consent"]);
    assert!(
        code == 0 && words.contains("participant R01 and all results of codrive analyse there are erased"),
        "{words}"
    );
    assert!(!data.join("sub-R01").exists() && !data.join("sourcedata/sub-R01").exists());
    assert_eq!(table(&data.join("erased.tsv"))[0]["reason"], "withdrew consent");
    let (code, words) = printed(&["analyse", out]);
    assert!(code == 0 && words.contains("4 drives"), "{words}");
    for [step, wrong @ ..] in [["erase", "R01", "--reason", "x"], ["export", "P9", "--to", "nowhere"]] {
        let (code, words) = printed(&[&["study", step, &file, "--from", out], &wrong[..]].concat());
        assert!(code != 0 && (words.contains("was erased") || words.contains("there are: R02, R03")), "{words}");
    }
    for (step, missing) in [("erase", "--reason"), ("export", "--to")] {
        let (code, words) = printed(&["study", step, &file, "R02", "--from", out]);
        assert!(code == 2 && words.contains(missing), "{words}");
    }
    let (found, subjects, _) = crate::bids::errors(&data);
    assert!(found.is_empty() && subjects == 2, "{found:#?}");
}

#[test]
fn a_limit_stops_a_rehearsal_as_it_would_stop_a_participant() {
    let folder = tempfile::tempdir().unwrap();
    // No response is below 1: the mean of four exceeds 0 for every participant.
    let file = study(
        folder.path(),
        "after = [\"trust\", \"nasa-tlx\"]",
        "after = [\"trust\"]\nstop_above = { score = \"trust.trust\", value = 0.0 }",
    );
    let data = folder.path().join("data");
    let (code, words) = printed(&["study", "rehearse", &file, "--out", data.to_str().unwrap()]);
    // Who was stopped did not complete the study.
    assert!(code == 0 && words.contains("0 of 3 participants completed the study"), "{words}");
    assert!(words.contains("stopped by a rule of the study (ends_if or stop_above): 3 participants"), "{words}");
    let participants = table(&data.join("participants.tsv"));
    assert!(participants.iter().all(|row| row["state"] == "withdrawn"), "{participants:?}");
    assert!(
        fs::read_to_string(data.join("sourcedata/sub-R01/session.json"))
            .unwrap()
            .contains("\"cause\": \"score_limit\"")
    );
    assert!(!data.join("sub-R01/beh/sub-R01_task-acceptance_beh.tsv").exists(), "nothing comes after the end");
}

const MINOR: &str = r#"title = "Age"
participants = 2
[base]
traffic = "native"
warm_up_s = 0.0
duration_s = 4.0
[[condition]]
name = "only"
[[segment]]
kind = "questions"
name = "about"
questionnaire = "age.json"
ends_if = ["{age} < 18"]
[[segment]]
kind = "trials"
name = "trial"
"#;

#[test]
fn a_limit_on_a_typed_number_ends_the_session_of_every_minor() {
    let folder = tempfile::tempdir().unwrap();
    let question = |input: &str| {
        let text = format!(
            r#"{{ "title": "You", "pages": [ {{ "elements": [ {{ "type": "text", "name": "age", {input} }} ] }} ] }}"#
        );
        fs::write(folder.path().join("age.json"), text).unwrap();
    };
    let file = folder.path().join("minor.toml").to_str().unwrap().to_owned();
    fs::write(&file, MINOR).unwrap();
    for (range, state) in [(r#""min": 1, "max": 17"#, "not_eligible"), (r#""min": 18, "max": 80"#, "complete")] {
        question(&format!(r#""title": "Age", "inputType": "number", {range}"#));
        let data = folder.path().join(state);
        let (code, words) = printed(&["study", "rehearse", &file, "--out", data.to_str().unwrap()]);
        assert_eq!(code, 0, "{words}");
        let states: Vec<String> =
            table(&data.join("participants.tsv")).into_iter().map(|row| row["state"].clone()).collect();
        assert_eq!(states, [state, state], "{words}");
    }
    // Without a type, no answer has an order: the mistake is found before a participant comes.
    question(r#""title": "Age""#);
    let (code, words) = printed(&["study", "check", &file]);
    assert!(code != 0 && words.contains("minor.toml:13:"), "{words}");
    assert!(words.contains("\"{age} < 18\" does not fit") && words.contains("\"inputType\": \"number\""), "{words}");
}
