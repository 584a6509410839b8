//! Sickness ratings while driving, rehearsed: recordings, data set and analysis agree on each question, and a rating above its limit ends a
//! session.

use crate::common::{codrive, table, text};
use codrive::replay::Replay;
use std::{fs, path::Path};

const STUDY: &str = r#"title = "Sickness"
participants = 2
seed = 7
[base]
traffic = "native"
warm_up_s = 0.0
duration_s = 60.0
[[condition]]
name = "narrow"
set = { range_mph = 0.75 }
[[condition]]
name = "wide"
[[segment]]
kind = "trials"
name = "trial"
fms_every_s = 20.0
"#;

fn rehearsed(folder: &Path, study: &str) -> String {
    let file = folder.join("sickness.toml");
    fs::write(&file, study).unwrap();
    let [file, out] = [file, folder.join("data")].map(|path| path.to_str().unwrap().to_owned());
    let output = codrive(&["study", "rehearse", &file, "--out", &out], "warn");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    text(&output)
}

#[test]
fn every_question_is_in_the_recording_the_data_set_and_the_analysis() {
    let folder = tempfile::tempdir().unwrap();
    rehearsed(folder.path(), STUDY);
    let data = folder.path().join("data");
    let output = codrive(&["analyse", data.to_str().unwrap()], "warn");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    let analysed = table(&data.join("derivatives/codrive/fms.csv"));
    // Two participants, two drives of a minute, asked at 20 and 40 s: a question at 60 s could not be answered.
    assert_eq!(analysed.len(), 8);
    let times: Vec<&str> = analysed.iter().map(|row| row["time_s"].as_str()).collect();
    assert_eq!(times, ["20", "40"].repeat(4));
    for (i, row) in analysed.iter().enumerate() {
        let (participant, place) = (&row["participant"], &row["place"]);
        let events = table(&data.join(format!("{participant}/beh/{participant}_task-trial_run-{place}_events.tsv")));
        let of = |kind: &str| events.iter().filter(|event| event["trial_type"] == kind).collect::<Vec<_>>();
        let k = i % 2;
        let asked = of("fms_asked")[k];
        assert_eq!(asked["tick"].parse::<u32>().unwrap(), 2000 * (k as u32 + 1));
        if row["value"].is_empty() {
            assert!(row["answer_s"].is_empty() && !of("fms_unanswered").is_empty());
            continue;
        }
        let answers = of("fms");
        let answered =
            answers.iter().find(|event| event["onset"].parse::<f64>().unwrap() > 20.0 * (k as f64 + 1.0)).unwrap();
        assert_eq!(answered["value"], row["value"], "{answered:?}");
        let took_s = answered["onset"].parse::<f64>().unwrap() - asked["onset"].parse::<f64>().unwrap();
        assert!((took_s - row["answer_s"].parse::<f64>().unwrap()).abs() < 0.006, "{row:?} {took_s}");
        assert!((0.0..=20.0).contains(&row["value"].parse::<f64>().unwrap()));
    }
    // A rating is not a control of the vehicle.
    let recording = data.join("sourcedata/sub-R01").join(&analysed[0]["recording"]);
    let mut replay = Replay::open(&recording).unwrap();
    replay.advance(10_000).unwrap();
    assert_eq!((replay.report().ticks, replay.report().first_difference), (6000, None));
    let report = fs::read_to_string(data.join("derivatives/codrive/report.html")).unwrap();
    for has in ["<h2>Sickness while driving</h2>", "fast motion sickness scale (Keshavarz and Hecht, 2011"] {
        assert!(report.contains(has), "{has}");
    }
    assert!(data.join("derivatives/codrive/figures/sickness.svg").exists());
    let (found, subjects, _) = crate::bids::errors(&data);
    assert!(found.is_empty() && subjects == 2, "{found:#?}");
}

#[test]
fn a_rating_above_its_limit_ends_a_rehearsed_session_and_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    // Most ratings of the first minutes are 0. With a limit of 0 and twenty minutes, some participant exceeds it.
    let study = STUDY
        .replace("duration_s = 60.0", "duration_s = 600.0")
        .replace("fms_every_s = 20.0", "fms_every_s = 60.0\nstop_above = { score = \"fms\", value = 0.0 }");
    let words = rehearsed(folder.path(), &study);
    assert!(words.contains("stopped by a rule of the study"), "{words}");
    let data = folder.path().join("data");
    let stopped = table(&data.join("participants.tsv")).into_iter().find(|row| row["state"] == "withdrawn").unwrap();
    let participant = &stopped["participant_id"];
    let ratings = table(&data.join(format!("{participant}/beh/{participant}_task-fmsRatings_beh.tsv")));
    let (last, before) = ratings.split_last().unwrap();
    assert!(last["value"].parse::<f64>().unwrap() > 0.0, "{ratings:?}");
    assert!(before.iter().all(|row| ["0", "n/a"].contains(&row["value"].as_str())), "{ratings:?}");
    let log = fs::read_to_string(data.join("sourcedata").join(participant).join("session.json")).unwrap();
    assert!(log.contains("\"cause\": \"score_limit\"") && log.contains("above 0 (stop_above)"), "{log}");
}
