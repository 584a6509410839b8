//! Tests of the rules that end a session: answers that end it, texts, and errors in a rule with their place.

use super::*;
use serde_json::json;
use std::path::Path;

const STUDY: &str = r#"title = "Rules"
participants = 2
[base]
traffic = "native"
duration_s = 10.0
[[condition]]
name = "a"
[[segment]]
kind = "consent"
name = "consent"
text = "What we ask of you."
[[segment]]
kind = "questions"
name = "screening"
questionnaire = "driving-experience"
ends_if = ["{licence} = false", "{jams} = 'rarely'"]
stop_text = "You cannot drive today."
[[segment]]
kind = "questions"
name = "before"
questionnaire = "ssq"
stop_above = { score = "total", value = 20.0 }
[[segment]]
kind = "trials"
name = "trial"
after = ["raw-tlx", "ssq"]
stop_above = { score = "ssq.total", value = 30.0 }
"#;

fn parsed(from: &str, to: &str) -> Result<Study, String> {
    assert!(STUDY.contains(from), "{from}");
    Study::parse(STUDY.replacen(from, to, 1), Path::new("rules.toml")).map_err(|error| error.0)
}

fn ending(study: &Study, item: &str, answers: &[(&str, serde_json::Value)]) -> Option<SessionEnding> {
    let plan = study.plan(0);
    let planned = plan.items.iter().find(|planned| planned.name == item).expect(item);
    study.ending(planned, &answers.iter().map(|(name, answer)| ((*name).to_owned(), answer.clone())).collect())
}

/// Returns answers in which all sixteen symptoms have this strength.
fn symptoms(study: &Study, strength: u8) -> Vec<(&str, serde_json::Value)> {
    let element = |e: &super::super::questions::QuestionElement| e.answer_names();
    let names = study.questionnaires["ssq"].pages.iter().flat_map(|page| &page.elements).flat_map(element);
    names.map(|name| (&*name.leak(), json!(strength))).collect()
}

#[test]
fn declined_consent_ends_the_session_with_thanks() {
    let study = parsed("participants = 2", "participants = 2").unwrap();
    assert_eq!(ending(&study, "consent", &[("agree", json!(true))]), None);
    for answers in [vec![("agree", json!(false))], vec![]] {
        let ending = ending(&study, "consent", &answers).expect("no consent");
        assert_eq!((ending.cause, &ending.words), (EndCause::Declined, &study.file.texts.declined));
        assert!(ending.reason.contains("did not agree"), "{}", ending.reason);
    }
    assert!(study.is_consent(&study.plan(0).items[0]) && !study.is_consent(&study.plan(0).items[1]));
}

#[test]
fn each_condition_of_a_screening_ends_the_session_and_is_named() {
    let study = parsed("participants = 2", "participants = 2").unwrap();
    let fine = [("licence", json!(true)), ("jams", json!("daily"))];
    assert_eq!(ending(&study, "screening", &fine), None);
    for (answers, condition) in [
        ([("licence", json!(false)), ("jams", json!("daily"))], "{licence} = false"),
        ([("licence", json!(true)), ("jams", json!("rarely"))], "{jams} = 'rarely'"),
    ] {
        let ending = ending(&study, "screening", &answers).expect(condition);
        assert_eq!((ending.cause, ending.words.as_str()), (EndCause::NotEligible, "You cannot drive today."));
        assert_eq!(ending.reason, format!("screening: {condition} (ends_if)"));
    }
}

#[test]
fn a_score_above_its_limit_ends_the_session_and_one_at_it_does_not() {
    // Equal symptoms count 21 times in the total: strength s gives 3.74 * 21 s = 78.54 s (Kennedy et al. 1993).
    let study = parsed("value = 20.0", "value = 78.54").unwrap();
    assert_eq!(ending(&study, "before", &symptoms(&study, 1)), None, "at the limit");
    let above = ending(&study, "before", &symptoms(&study, 2)).expect("157.08 is above");
    assert_eq!(above.cause, EndCause::ScoreLimit);
    assert_eq!(above.reason, "before: total is 157.08, above 78.54 (stop_above)");
    assert_eq!(above.words, study.file.texts.score_limit);
    assert_eq!(ending(&study, "before", &symptoms(&study, 2)[1..]), None, "a score that lacks an answer is none");
    // The limit of a trial applies only to the named questionnaire.
    let trial = ending(&study, "trial-1-a-ssq", &symptoms(&study, 1)).expect("78.54 is above 30");
    assert_eq!(trial.reason, "trial-1-a-ssq: ssq.total is 78.54, above 30 (stop_above)");
    assert_eq!(ending(&study, "trial-1-a-raw-tlx", &[("mental", json!(100))]), None);
}

#[test]
fn a_mistake_in_a_rule_is_named_with_its_line() {
    for (from, to, line, has) in [
        ("\"total\"", "\"totl\"", 22, "(did you mean total?)"),
        ("\"ssq.total\"", "\"total\"", 27, "allowed here: raw-tlx.raw-tlx, ssq.nausea"),
        ("value = 20.0", "value = nan", 22, "value is NaN; allowed: a finite number"),
        ("{licence} = false", "{licence} is false", 16, "is not a condition; allowed: {name} = 'word'"),
        (
            "{licence} = false",
            "{license} = false",
            16,
            "names \"license\", but no question of \"driving-experience\" has this name",
        ),
        (
            "{licence} = false",
            "{licence} = 0",
            16,
            "\"{licence} = 0\" does not fit: an answer to \"licence\" is yes or no",
        ),
        ("{jams} = 'rarely'", "{jams} = 'rarly'", 16, "(did you mean rarely?)"),
        ("{jams} = 'rarely'", "{jams} < 3", 16, "is one of its choices"),
        (
            "text = \"What we ask of you.\"",
            "questionnaire = \"ssq\"\ntext = \"x\"",
            11,
            "no required question \"agree\"",
        ),
        ("text = \"What we ask of you.\"\n", "", 9, "a segment of kind \"consent\" needs `text`"),
        ("after = [\"raw-tlx\", \"ssq\"]", "after = [\"ssq\", \"ssq\"]", 26, "the questionnaire \"ssq\" occurs twice"),
        ("after = [\"raw-tlx\", \"ssq\"]", "after = [\"sqs\", \"ssq\"]", 26, "there is no such questionnaire"),
        ("name = \"before\"", "name = \"trial-ssq\"", 20, "belongs to an item of the segment \"trial\""),
        ("name = \"before\"", "name = \"trial-1-a-ssq\"", 20, "belongs to an item of the segment \"trial\""),
    ] {
        let message = parsed(from, to).expect_err(to);
        assert!(message.starts_with(&format!("rules.toml:{line}:")) && message.contains(has), "{to}: {message}");
    }
    let message = parsed("name = \"a\"", "name = \"a\"\n[[condition]]\nname = \"a-ssq\"").expect_err("two of one name");
    assert!(message.contains("\"trial-1-a-ssq\" belongs to a drive and to a questionnaire after a drive"), "{message}");
    let alone = "stop_above = { score = \"total\", value = 20.0 }";
    let message = parsed(alone, "stop_text = \"x\"").expect_err("nothing stops");
    assert!(message.contains("no rule ends the session here"), "{message}");
}

const RATED: &str = "fms_every_s = 60\nstop_above = { score = \"fms\", value = 10.0 }";

#[test]
fn a_rating_above_its_limit_while_driving_ends_the_session() {
    let study = parsed("stop_above = { score = \"ssq.total\", value = 30.0 }", RATED).unwrap();
    let plan = study.plan(0);
    let trial = plan.items.iter().find(|planned| planned.name == "trial-1-a").unwrap();
    let answered = |study: &Study| ending(study, "trial-1-a-ssq", &symptoms(study, 3));
    let ending = |value: Option<u8>| {
        study.ending_of_rating(trial, &FmsRating { time_s: 60.0, value, answer_s: value.map(|_| 2.0) })
    };
    assert_eq!([ending(None), ending(Some(0)), ending(Some(10))], [None, None, None], "at the limit");
    let above = ending(Some(11)).expect("11 is above 10");
    assert_eq!((above.cause, &above.words), (EndCause::ScoreLimit, &study.file.texts.score_limit));
    assert_eq!(above.reason, "trial-1-a: fms is 11, above 10 (stop_above)");
    // The limit does not apply to the questionnaires after the trial.
    assert_eq!(answered(&study), None);
    for (rule, line, has) in [
        ("stop_above = { score = \"fms\", value = 10.0 }", 27, "set fms_every_s = 60 in the segment"),
        ("fms_every_s = 60\nstop_above = { score = \"fms\", value = 20.0 }", 28, "from 0 to below 20"),
        ("fms_every_s = 60\nstop_above = { score = \"fsm\", value = 10.0 }", 28, "(did you mean fms?)"),
        ("fms_every_s = 5", 27, "fms_every_s is 5; allowed: a number from 20 to 3600 s"),
    ] {
        let message = parsed("stop_above = { score = \"ssq.total\", value = 30.0 }", rule).expect_err(rule);
        assert!(message.starts_with(&format!("rules.toml:{line}:")) && message.contains(has), "{rule}: {message}");
    }
    let message = parsed("questionnaire = \"ssq\"", "questionnaire = \"ssq\"\nfms_every_s = 60").expect_err("no drive");
    assert!(message.contains("a segment of kind \"questions\" has no `fms_every_s`"), "{message}");
}
