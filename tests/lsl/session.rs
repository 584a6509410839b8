//! Tests of a participant's whole session in its two windows (Xvfb), with a study that has `[lsl]`: the streams that a laboratory's program
//! receives, and the samples of a device in the recordings of the trials.

use crate::{
    programs::{self, Program},
    xserver::{Server, wait_for},
};
use codrive::{
    record::{self, Table, TableReader, streams},
    study::{
        ItemOutcome,
        session::{FILE, SessionLog},
    },
    time::TICK_S,
};
use serde_json::Value;
use std::{fs, os::unix::process::ExitStatusExt, process::Command};

/// X key code of Enter.
const ENTER: u8 = 36;

const STUDY: &str = r##"title = "Short"
participants = 2
order = "fixed"
countdown_s = 0.0
least_frames_per_s = 0
[lsl]
outlets = true
source = "session"
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
fn a_session_streams_its_trials_and_records_the_device_in_each() {
    programs::on_loopback();
    let place = tempfile::tempdir().unwrap();
    let (study, out) = (place.path().join("short.toml"), place.path().join("data"));
    fs::write(&study, STUDY).unwrap();
    let mut heart = Program::python("send.py", &["heart", "50", "heart-9"]);
    heart.wait_for("READY", 1);
    let server = Server::start([1300, 1200]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(["study", "session"]).arg(&study).args(["P03", "--out"]).arg(&out).env("RUST_LOG", "error");
    let mut program = server.start_program(&mut command);
    let mut pylsl = Program::python("receive.py", &["session", "codrive.events", "codrive.ego"]);
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
    assert!(log.item_runs.iter().all(|item_run| item_run.outcome == ItemOutcome::Done), "{log:?}");

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
    // One stream for the whole session, with 200 ticks per trial.
    assert_eq!(heard["codrive.ego"]["stamps"].as_array().unwrap().len(), 400);
    for name in names {
        let table = TableReader::parquet(&source.join(name).join(streams::FOLDER).join("heart.parquet")).unwrap();
        let numbers: Vec<f64> = table.numbers("sample").into_iter().flatten().collect();
        assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1.0), "{name}: none lost");
        let inside = table.numbers(streams::TIME).into_iter().flatten().count();
        assert!(inside >= 80, "{name}: {inside} samples of 2 s at 50 Hz");
    }
}

#[test]
fn a_killed_drive_keeps_its_ticks_and_the_samples_of_a_device() {
    programs::on_loopback();
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("drive");
    let mut heart = Program::python("send.py", &["heart", "50", "heart-10"]);
    heart.wait_for("READY", 1);
    let server = Server::start([640, 400]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command
        .args(["drive", "--traffic", "native", "--warm-up", "0", "--quality", "low", "--trees", "0"])
        .args(["--lsl-record", "name='heart'", "--out"])
        .arg(&out)
        .env("RUST_LOG", "error")
        // Twenty flushes to the disk, one each 0.2 s.
        .env("CODRIVE_KILL_AT", "flush.synced:20");
    let killed = server.start_program(&mut command).wait_with_output().unwrap();
    assert_eq!(killed.status.signal(), Some(9), "{killed:?}");
    heart.end();
    let found = record::recover(&out).unwrap();
    assert_eq!((found.was_whole, found.kept), (false, None));
    let ticks = TableReader::parquet(&Table::Ego.parquet(&out)).unwrap().wholes("tick");
    let driven_s = ticks.len() as f64 * TICK_S;
    let heart = TableReader::parquet(&out.join(streams::FOLDER).join("heart.parquet")).unwrap();
    let samples: Vec<f64> = heart.numbers("sample").into_iter().flatten().collect();
    assert!(samples.windows(2).all(|pair| pair[1] == pair[0] + 1.0), "none lost, nothing twice: {samples:?}");
    // The same promise as for the tables of the drive: a cut loses half a second at most. Samples count by the drive's clock.
    let known_s = heart.numbers(streams::TIME).into_iter().flatten().fold(0.0, f64::max);
    assert!(driven_s > 2.0 && known_s > driven_s - 0.5, "{known_s} of {driven_s} s");
    let again = record::recover(&out).unwrap();
    assert!(again.was_whole, "recovered once");
}
