//! Data sets without a finished drive, checked by the BIDS validator.

use super::{
    bids::errors,
    common::{codrive, text},
};
use codrive::study::{
    DataSet, ParticipantCode, Session, Study,
    session::{ParticipantKind, TimedAnswer, as_map},
};
use std::{fs, path::Path};

/// A study with consent, a questionnaire, and trials in two conditions.
const STUDY: &str = r#"title = "Unfinished"
participants = 2
[base]
traffic = "native"
warm_up_s = 0.0
duration_s = 5.0
[[condition]]
name = "narrow"
set = { range_mph = 0.75 }
[[condition]]
name = "wide"
[[segment]]
kind = "consent"
name = "consent"
text = "You will drive."
[[segment]]
kind = "questions"
name = "screening"
questionnaire = "driving-experience"
[[segment]]
kind = "trials"
name = "trial"
after = ["raw-tlx"]
fms_every_s = 60.0
"#;

/// Makes a data set in `folder` with participants who only answer the question of consent.
fn answered(folder: &Path, people: &[(&str, bool)]) -> (Study, DataSet) {
    let study = Study::parse(STUDY.into(), Path::new("unfinished.toml")).unwrap();
    let data = DataSet::open(folder, &study).unwrap();
    for (index, (name, agrees)) in people.iter().enumerate() {
        let code = ParticipantCode::new(name).unwrap();
        let mut session =
            Session::open(&data, &study, &code, ParticipantKind::Person, index, "2026-05-03T10:00:00Z").unwrap();
        session.begin("2026-05-03T10:00:01Z").unwrap();
        let answers = vec![TimedAnswer { question: "agree".into(), answer: (*agrees).into(), time_s: 3.5 }];
        let ending = study.ending(&session.plan().items[0], &as_map(&answers));
        assert_eq!(ending.is_some(), !agrees);
        session.end_answered(answers, ending.as_ref(), "2026-05-03T10:00:05Z").unwrap();
        drop(session);
        data.publish(&study, &code).unwrap();
    }
    (study, data)
}

#[track_caller]
fn assert_valid(data: &Path, participants: usize) {
    let (found, subjects, _) = errors(data);
    assert!(found.is_empty(), "{found:#?}");
    assert_eq!(subjects, participants);
}

#[test]
fn a_data_set_without_a_finished_drive_is_valid() {
    let place = tempfile::tempdir().unwrap();
    let data = place.path().join("agreed");
    answered(&data, &[("P1", true)]);
    assert_valid(&data, 1);
    let data = place.path().join("declined");
    answered(&data, &[("P1", false)]);
    assert_valid(&data, 1);
    let data = place.path().join("excluded");
    let (study, set) = answered(&data, &[("P1", true), ("P2", false)]);
    set.exclude(&study, &ParticipantCode::new("P1").unwrap(), "fell asleep", "2026-05-03T11:00:00Z").unwrap();
    assert_valid(&data, 2);
    assert!(fs::read_to_string(data.join("participants.tsv")).unwrap().contains("\texcluded\n"));
    // No participant has begun.
    let data = place.path().join("empty");
    answered(&data, &[]);
    assert_valid(&data, 0);
}

#[test]
fn a_rehearsal_that_a_rule_ends_before_the_first_trial_is_valid() {
    let place = tempfile::tempdir().unwrap();
    let (file, data) = (place.path().join("study.toml"), place.path().join("data"));
    // Simulated participants report no symptoms: a limit below zero ends every session.
    let text_of = STUDY.replace(
        "questionnaire = \"driving-experience\"",
        "questionnaire = \"ssq\"\nstop_above = { score = \"total\", value = -1.0 }",
    );
    fs::write(&file, text_of).unwrap();
    let output = codrive(
        &["study", "rehearse", file.to_str().unwrap(), "--participants", "1", "--out", data.to_str().unwrap()],
        "warn",
    );
    assert!(output.status.success(), "{}", text(&output));
    assert!(!data.join("sub-R01/motion").exists(), "a drive was finished");
    assert_valid(&data, 1);
}
