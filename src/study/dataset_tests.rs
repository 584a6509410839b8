//! Tests of the tables of a data set: cells by hand, refusals, entries of the checksum list.

use super::*;
use crate::study::{Questionnaire, session::TimedAnswer};
use std::fs;

const STUDY_TEXT: &str = r#"title = "Two ranges"
participants = 2
[base]
traffic = "native"
duration_s = 10.0
[factors]
range = [{ name = "narrow", set = { range_mph = 0.5, map = "/home/ann/maps/ring.net.xml" } }, { name = "wide" }]
[[segment]]
kind = "questions"
name = "ssq-before"
questionnaire = "raw-tlx"
"#;

const QUESTIONS: &str = r#"{ "title": "Three", "pages": [ { "elements": [
  { "type": "rating", "name": "a", "title": "How much?", "description": "Today", "rateMin": 0, "rateMax": 1, "rateStep": 0.1,
    "minRateDescription": "none", "maxRateDescription": "all" },
  { "type": "rating", "name": "b", "title": "And now?", "rateMin": 0, "rateMax": 1, "rateStep": 0.1 },
  { "type": "matrix", "name": "often", "title": "How often in", "columns": [{"value": 0, "text": "never"}, {"value": 1, "text": "often"}],
    "rows": ["rain", "fog"] },
  { "type": "radiogroup", "name": "car", "title": "Which?", "choices": ["small", "large"] },
  { "type": "checkbox", "name": "uses", "title": "Uses?", "choices": [{"value": "w", "text": "work"}, {"value": "h", "text": "home"}] },
  { "type": "boolean", "name": "glasses", "title": "Glasses?" },
  { "type": "comment", "name": "more" },
  { "type": "html", "name": "thanks", "html": "Thanks" } ] } ],
  "scores": [{ "name": "both", "method": "sum", "of": ["a", "b"], "weight": 3 },
             { "name": "mean", "method": "mean", "of": ["a", "b"] }] }"#;

fn study() -> Study {
    // The author's map does not exist on this machine, and its path is only text here.
    let text = STUDY_TEXT.replace(", map = \"/home/ann/maps/ring.net.xml\"", "");
    Study::parse(text, Path::new("two.toml")).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the log of a participant's session, extended by `more`.
fn log(code: &str, index: usize, more: Value) -> SessionLog {
    let mut log =
        json!({ "participant": code, "index": index, "kind": "person", "order": ["wide", "narrow"], "item_runs": [] });
    log.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    serde_json::from_value(log).unwrap()
}

fn answered(question: &str, answer: Value, time_s: f64) -> Value {
    json!({ "question": question, "answer": answer, "time_s": time_s })
}

fn item_run(item: &str, outcome: &str) -> Value {
    json!({ "item": item, "outcome": outcome, "began": "t0", "ended": "t1" })
}

/// Writes a session file to its place in the data set.
fn save(data: &DataSet, log: &SessionLog) {
    let folder = data.source(&log.participant);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(session_log::FILE), serde_json::to_string(log).unwrap()).unwrap();
}

fn cells(table: &TsvTable) -> Vec<Vec<String>> {
    table.text().lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect()
}

#[test]
fn each_participant_has_one_row_of_answers_and_rounded_scores() {
    let questionnaire = Questionnaire::parse(QUESTIONS, "three.json").unwrap();
    let all = [
        answered("a", json!(0.1), 1.0),
        answered("b", json!(0.2), 2.0),
        answered("often.rain", json!(1), 3.0),
        answered("often.fog", json!(0), 3.5),
        answered("car", json!("large"), 4.0),
        answered("uses", json!(["w", "h"]), 5.0),
        answered("glasses", json!(false), 6.0),
        answered("more", json!("a\tb"), 7.0),
    ];
    let done = |code: &str, index: usize, outcome: &str, answers: &[Value]| {
        log(code, index, json!({ "item_runs": [item_run("q", outcome)], "answers": { "q": answers } }))
    };
    let logs = [
        done("P1", 0, "done", &all),
        // Only some answers; a session that did not get this far; a session that skipped the questionnaire.
        done("P2", 1, "done", &all[1..2]),
        log("P3", 2, json!({})),
        done("P4", 3, "skipped", &all),
    ];
    let table = phenotype(&questionnaire, "q", &logs);
    let row = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(
        cells(&table),
        [
            row("participant_id a b often.rain often.fog car uses glasses more score_both score_mean"),
            // As doubles, three times (0.1 + 0.2) is 0.9000000000000001, and its half is 0.15000000000000002.
            "sub-P1|0.1|0.2|1|0|large|w;h|false|a b|0.9|0.15".split('|').map(str::to_owned).collect(),
            row("sub-P2 n/a 0.2 n/a n/a n/a n/a n/a n/a n/a n/a"),
        ]
    );
    let about = |name: &str| table.columns.iter().find(|column| column.name == name).unwrap();
    assert_eq!(about("a").about, "How much? Today From 0 (none) to 1 (all)");
    assert_eq!((about("b").about.as_str(), about("b").levels.len()), ("And now? From 0 to 1", 0));
    let words = |list: &[(&str, &str)]| list.iter().map(|(w, t)| ((*w).into(), (*t).into())).collect::<Vec<_>>();
    assert_eq!(about("often.fog").about, "How often in fog");
    assert_eq!(about("often.rain").levels, words(&[("0", "never"), ("1", "often")]));
    assert_eq!(about("car").levels, words(&[("small", "small"), ("large", "large")]));
    assert_eq!(about("uses").about, "Uses? Any of these, joined by semicolons: w: work; h: home");
    assert!(about("uses").levels.is_empty(), "a cell may have several of them");
    assert_eq!(about("glasses").levels, words(&[("true", "yes"), ("false", "no")]));
    assert_eq!(about("score_both").about, "score: 3 times the sum of a, b");
}

#[test]
fn a_score_is_rounded_to_six_decimals() {
    // One third and two thirds, of both signs; and a value that is exact to six decimals.
    for (answers, expected) in [
        ([1.0, 0.0, 0.0], "0.333333"),
        ([1.0, 1.0, 0.0], "0.666667"),
        ([-1.0, -1.0, 0.0], "-0.666667"),
        ([3.0, 0.0, 0.000_003], "1.000001"),
    ] {
        let text = r#"{ "title": "T", "pages": [ { "elements": [ {"type":"text","name":"a"}, {"type":"text","name":"b"},
            {"type":"text","name":"c"} ] } ], "scores": [{ "name": "m", "method": "mean", "of": ["a", "b", "c"] }] }"#;
        let questionnaire = Questionnaire::parse(text, "third.json").unwrap();
        let given: Vec<Value> =
            ["a", "b", "c"].iter().zip(answers).map(|(name, value)| answered(name, json!(value), 1.0)).collect();
        let log = log("P1", 0, json!({ "item_runs": [item_run("q", "done")], "answers": { "q": given } }));
        assert_eq!(phenotype(&questionnaire, "q", &[log]).rows[0][4], expected);
    }
}

#[test]
fn every_answer_of_a_form_has_its_time() {
    let list: Vec<TimedAnswer> = [answered("car", json!("large"), 2.25), answered("uses", json!(["w", "h"]), 13.5)]
        .into_iter()
        .map(|one| serde_json::from_value(one).unwrap())
        .collect();
    let study = study();
    let table = timed(&study, &study.plan(0).items[0], &list);
    assert_eq!(table.text(), "question\tanswer\tresponse_time\ncar\tlarge\t2.25\nuses\tw;h\t13.5\n");
    assert_eq!(table.columns[2].unit, "s");
}

#[test]
fn participants_are_listed_with_number_order_state_and_traits() {
    let end = |complete: bool| json!({ "end": { "complete": complete, "reason": "", "at": "t" } });
    let mut drawn = end(true);
    let traits = json!({ "level": 0.5, "error_mps": 0.2, "reaction_s": 1.25 });
    drawn
        .as_object_mut()
        .unwrap()
        .extend(json!({ "kind": "simulated", "traits": traits }).as_object().unwrap().clone());
    let mut skipped = end(true);
    skipped["item_runs"] = json!([item_run("ssq-before", "skipped")]);
    let mut excluded = end(true);
    excluded["end"]["excluded"] = "fell asleep".into();
    let mut shown = end(true);
    shown["frames_per_s"] = json!(59.5);
    let logs = [
        log("P1", 0, shown),
        log("P2", 1, end(false)),
        log("P3", 2, json!({})),
        log("P4", 3, skipped),
        log("P5", 4, excluded),
        log("R1", 9, drawn),
    ];
    let table = participants(&logs);
    let expected = "participant_id\tnumber\tframes_per_s\tkind\torder\tstate\ttrue_error_mps\ttrue_level\ttrue_reaction_s\n\
                    sub-P1\t1\t59.5\tperson\twide,narrow\tcomplete\tn/a\tn/a\tn/a\n\
                    sub-P2\t2\tn/a\tperson\twide,narrow\twithdrawn\tn/a\tn/a\tn/a\n\
                    sub-P3\t3\tn/a\tperson\twide,narrow\topen\tn/a\tn/a\tn/a\n\
                    sub-P4\t4\tn/a\tperson\twide,narrow\tpartial\tn/a\tn/a\tn/a\n\
                    sub-P5\t5\tn/a\tperson\twide,narrow\texcluded\tn/a\tn/a\tn/a\n\
                    sub-R1\t10\tn/a\tsimulated\twide,narrow\tcomplete\t0.2\t0.5\t1.25\n";
    assert_eq!(table.text(), expected);
    let units: Vec<&str> = table.columns[6..].iter().map(|column| column.unit.as_str()).collect();
    assert_eq!(units, ["m/s", "", "s"]);
}

#[test]
fn factor_levels_are_described_by_their_settings_without_folders() {
    let mut study = study();
    study.file = toml::from_str(STUDY_TEXT).unwrap();
    let table = scans::table(&study);
    let names: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    assert_eq!(
        names,
        ["filename", "acq_time", "segment", "place", "condition", "range", "seed", "recording", "baseline"]
    );
    let described: Vec<(&str, &str)> =
        table.columns[5].levels.iter().map(|(word, about)| (word.as_str(), about.as_str())).collect();
    assert_eq!(
        described,
        [("narrow", "map = \"ring.net.xml\", range_mph = 0.5"), ("wide", "as in the base of the study")]
    );
}

#[test]
fn the_lowest_free_number_is_next_and_sessions_come_by_number() {
    let folder = tempfile::tempdir().unwrap();
    let data = DataSet::open(folder.path(), &study()).unwrap();
    assert_eq!(data.next_index().unwrap(), 0);
    for (code, index) in [("Z9", 0), ("A1", 3), ("B2", 1), ("C3", 1)] {
        save(&data, &log(code, index, json!({})));
    }
    let logs = data.logs().unwrap();
    let order: Vec<(&str, usize)> = logs.iter().map(|log| (log.participant.as_str(), log.index)).collect();
    assert_eq!(order, [("Z9", 0), ("B2", 1), ("C3", 1), ("A1", 3)]);
    assert_eq!(data.next_index().unwrap(), 2, "nobody has it");
    // The replacement of a participant who does not count takes the same order.
    let end = |complete: bool| json!({ "end": { "at": "t1", "complete": complete, "reason": "" } });
    let mut excluded = end(true);
    excluded["end"]["excluded"] = "fell asleep".into();
    for (more, next) in [(json!({}), 2), (excluded, 0), (end(false), 0), (end(true), 2)] {
        save(&data, &log("Z9", 0, more));
        assert_eq!(data.next_index().unwrap(), next);
    }
    // Two codes share a folder on systems that ignore case.
    let refused = |code: &str| data.check_new_code(&ParticipantCode::new(code).unwrap()).map_err(|e| e.to_string());
    assert_eq!(refused("Z9"), Ok(()), "the same participant goes on");
    assert_eq!(refused("Z8"), Ok(()));
    assert!(refused("z9").unwrap_err().contains("z9 differs from Z9 only by capital letters"));
}

#[test]
fn a_baseline_being_remade_is_unlisted_until_publication() {
    let folder = tempfile::tempdir().unwrap();
    let study = study();
    let data = DataSet::open(folder.path(), &study).unwrap();
    let over = log("P1", 0, json!({ "end": { "complete": false, "reason": "sick", "at": "t" } }));
    save(&data, &over);
    let drive = data.source(&over.participant).join("trial-1-wide");
    for name in ["trial-1-wide", "trial-1-wide-baseline"] {
        fs::create_dir_all(drive.with_file_name(name)).unwrap();
        fs::write(drive.with_file_name(name).join("ego.parquet"), "x").unwrap();
    }
    data.publish(&study, &over.participant).unwrap();
    let list = || fs::read_to_string(folder.path().join(checksums::FILE)).unwrap();
    let on_list = |list: &str| ["", BASELINE].map(|end| list.contains(&format!("trial-1-wide{end}/ego.parquet")));
    assert_eq!(on_list(&list()), [true, true]);
    data.remakes_baseline(&over.participant, "trial-1-wide").unwrap();
    assert_eq!(on_list(&list()), [true, false]);
    data.publish(&study, &over.participant).unwrap();
    assert_eq!(on_list(&list()), [true, true]);
    let phenotype = fs::read_to_string(folder.path().join("phenotype/ssq_before.tsv")).unwrap();
    assert!(phenotype.starts_with("participant_id\tmental"), "a name of BIDS has no hyphen: {phenotype}");
}

#[test]
fn a_session_that_is_not_over_is_not_on_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let study = study();
    let data = DataSet::open(folder.path(), &study).unwrap();
    let [over, open] = [("P1", json!({ "end": { "complete": true, "reason": "", "at": "t" } })), ("P2", json!({}))]
        .map(|(code, more)| log(code, 0, more));
    save(&data, &over);
    save(&data, &open);
    for one in [&over, &open] {
        data.publish(&study, &one.participant).unwrap();
    }
    let list = fs::read_to_string(folder.path().join(checksums::FILE)).unwrap();
    assert!(list.contains("sub-P1/session.json") && !list.contains("sub-P2"), "{list}");
}

#[test]
fn a_cut_data_set_is_completed_and_a_foreign_folder_is_refused() {
    let study = study();
    let texts = [("README.md", readme(&study)), ("dataset_description.json", description(&study))];
    let begun = |name: &str, text: &str| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), text).unwrap();
        let opened = DataSet::open(folder.path(), &study);
        assert_eq!(opened.is_ok(), folder.path().join(STUDY).exists(), "{name}");
        opened.is_ok()
    };
    for (name, text) in &texts {
        let beside = Path::new(name).with_extension(record::BESIDE);
        for name in [*name, beside.to_str().unwrap()] {
            assert!(begun(name, text) && begun(name, &text[..7]) && begun(name, ""), "{name}");
            // One byte longer, and of the same length with other bytes.
            assert!(!begun(name, &format!("{text}\n")) && !begun(name, &text.replace(':', ";")), "{name}");
        }
    }
    assert!(!begun("notes.txt", "") && !begun("notes.txt", &texts[0].1), "no name of ours");
}

#[test]
fn links_in_place_of_participants_folders_are_refused() {
    let study = study();
    for (link, refused) in
        [("sub-P1", true), ("sourcedata", true), ("phenotype", true), ("sourcedata/sub-P1", true), ("figures", false)]
    {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let data = DataSet::open(folder.path(), &study).unwrap();
        let at = folder.path().join(link);
        fs::create_dir_all(at.parent().unwrap()).unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), &at).unwrap();
        for found in [DataSet::open(folder.path(), &study).map(|_| ()), data.logs().map(|_| ())] {
            let written = found.map_err(|e| e.to_string());
            let names_it =
                written.as_ref().is_err_and(|text| text.contains(&format!("{} is a symbolic link", at.display())));
            assert!(if refused { names_it } else { written.is_ok() }, "{link}: {written:?}");
        }
    }
}

#[test]
fn publishing_writes_answer_times_for_that_participant_only() {
    let folder = tempfile::tempdir().unwrap();
    let study = study();
    let data = DataSet::open(folder.path(), &study).unwrap();
    let given = json!({ "ssq-before": [answered("mental", json!(35), 2.25)] });
    let logs = ["P1", "P2"]
        .map(|code| log(code, 0, json!({ "item_runs": [item_run("ssq-before", "done")], "answers": given.clone() })));
    logs.iter().for_each(|log| save(&data, log));
    let table = |code: &str| folder.path().join(format!("sub-{code}/beh/sub-{code}_task-ssqBefore_beh.tsv"));
    data.publish(&study, &logs[0].participant).unwrap();
    assert_eq!(fs::read_to_string(table("P1")).unwrap(), "question\tanswer\tresponse_time\nmental\t35\t2.25\n");
    assert!(!table("P2").exists());
    let about: Value = serde_json::from_slice(&fs::read(table("P1").with_extension("json")).unwrap()).unwrap();
    assert_eq!(about["TaskName"], "ssqBefore");
    // Without drives the list holds only the answers. The time of asking is unknown in this log.
    assert_eq!(
        fs::read_to_string(folder.path().join("sub-P1/sub-P1_scans.tsv")).unwrap().lines().nth(1),
        Some("beh/sub-P1_task-ssqBefore_beh.tsv\tn/a\tssq-before\tn/a\tn/a\tn/a\tn/a\tn/a\tn/a")
    );
    // The common table holds both.
    let all = fs::read_to_string(folder.path().join("phenotype/ssq_before.tsv")).unwrap();
    assert_eq!(
        all.lines().map(|line| line.split('\t').next().unwrap()).collect::<Vec<_>>(),
        ["participant_id", "sub-P1", "sub-P2"]
    );
}

#[test]
fn no_tables_for_answers_and_drives_that_left_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("data");
    let study = study();
    let data = DataSet::open(&root, &study).unwrap();
    let answers = json!({ "ssq-before": [answered("mental", json!(50), 1.0)] });
    let code = ParticipantCode::new("P1").unwrap();
    let there = |name: &str| root.join("sub-P1").join(name).exists();
    let tables = ["sub-P1_scans.tsv", "beh/sub-P1_task-ssqBefore_beh.tsv", "beh/sub-P1_task-ssqBefore_beh.json"];
    let item_runs = [item_run("ssq-before", "done")];
    save(&data, &log("P1", 0, json!({ "item_runs": item_runs, "answers": answers })));
    data.publish(&study, &code).unwrap();
    assert!(tables.iter().all(|table| there(table)));
    // A table of a drive that is no longer part of the session.
    fs::create_dir_all(root.join("sub-P1/motion")).unwrap();
    fs::write(root.join("sub-P1/motion/sub-P1_task-trial_tracksys-codrive_run-1_motion.tsv"), "0\n").unwrap();
    data.publish(&study, &code).unwrap();
    assert!(tables.iter().all(|table| there(table)));
    assert!(!there("motion/sub-P1_task-trial_tracksys-codrive_run-1_motion.tsv"));
    // The item was begun again and then skipped.
    save(&data, &log("P1", 0, json!({ "item_runs": [item_run("ssq-before", "skipped")], "answers": answers })));
    data.publish(&study, &code).unwrap();
    assert!(!tables.iter().any(|table| there(table)));
}
