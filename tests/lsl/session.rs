//! A participant's whole session in its two windows (Xvfb), with a study that has `[lsl]`: what a laboratory's program hears of it, and
//! what the recordings of its trials have of a device.

use crate::{
    programs::{self, Program},
    xserver::{Server, wait_for},
};
use codrive::{
    record::{TableReader, streams},
    study::{
        ItemOutcome,
        session::{FILE, SessionLog},
    },
};
use serde_json::Value;
use std::{fs, process::Command};

/// Enter, as X numbers it.
const ENTER: u8 = 36;

const STUDY: &str = r##"title = "Short"
participants = 2
order = "fixed"
countdown_s = 0.0
[lsl]
outlets = true
record = ["name='heart'"]
[base]
traffic = "native"
vehicles = 6
warm_up_s = 0.0
duration_s = 2.0
quality = "low"
trees = 0
policy = "constant"
[[condition]]
name = "narrow"
set = { range_mph = 0.75 }
[[condition]]
name = "wide"
[[segment]]
kind = "trials"
name = "trial"
"##;

#[test]
fn a_session_tells_of_its_trials_with_their_conditions_and_records_the_device_in_each() {
    programs::on_loopback();
    let place = tempfile::tempdir().unwrap();
    let (study, out) = (place.path().join("short.toml"), place.path().join("data"));
    fs::write(&study, STUDY).unwrap();
    let mut heart = Program::python("send.py", &["heart", "50", "heart-9"]);
    heart.wait_for("READY", 1);
    let server = Server::start([1300, 1200]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.arg("study").arg(&study).args(["--participant", "P03", "--out"]).arg(&out).env("RUST_LOG", "error");
    let mut program = server.start_program(&mut command);
    let mut pylsl = Program::python("receive.py", &["P03", "codrive.events", "codrive.ego"]);
    pylsl.wait_for("READY", 1);
    let participant = server.window("codrive: Short");
    server.window("Experimenter: P03");
    let source = out.join("sourcedata/sub-P03");
    let log = wait_for("the end of the session", || {
        server.strike(participant, &[ENTER]);
        SessionLog::load(&source.join(FILE)).ok().filter(|log| log.end.is_some())
    });
    let heard: Value = serde_json::from_str(&pylsl.end()).unwrap();
    program.kill().unwrap();
    program.wait().unwrap();
    heart.end();
    assert!(log.passages.iter().all(|passage| passage.outcome == ItemOutcome::Done), "{log:?}");

    let events = heard["codrive.events"]["values"].as_array().unwrap();
    let trials: Vec<String> =
        events.iter().map(|event| format!("{} {}", event[0].as_str().unwrap(), event[1].as_str().unwrap())).collect();
    let trials: Vec<&str> = trials.iter().map(String::as_str).filter(|words| words.starts_with("trial_")).collect();
    let names = ["trial-1-narrow", "trial-2-wide"];
    assert_eq!(
        trials,
        [
            "trial_start trial-1-narrow",
            "trial_end trial-1-narrow",
            "trial_start trial-2-wide",
            "trial_end trial-2-wide"
        ]
    );
    // One stream for the whole session: 200 ticks of each trial.
    assert_eq!(heard["codrive.ego"]["stamps"].as_array().unwrap().len(), 400);
    for name in names {
        let table = TableReader::parquet(&source.join(name).join(streams::FOLDER).join("heart.parquet")).unwrap();
        let numbers: Vec<f64> = table.numbers("sample").into_iter().flatten().collect();
        assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1.0), "{name}: none lost");
        let inside = table.numbers(streams::TIME).into_iter().flatten().count();
        assert!(inside >= 80, "{name}: {inside} samples of 2 s at 50 Hz");
    }
}
