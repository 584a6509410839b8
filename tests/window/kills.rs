//! Tests of drives and sessions in windows that are killed at a point of their recording: the recording is recovered and replays, and the
//! same command continues the session.

use crate::xserver::{Server, wait_for};
use codrive::{
    record::{Table, TableReader, recover},
    study::session::{FILE, SessionLog},
};
use std::{
    fs,
    os::unix::process::ExitStatusExt,
    process::{Command, Output, Stdio},
};

fn codrive(arguments: &[&str], server: &Server, point: Option<&str>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env("RUST_LOG", "error").env("DISPLAY", &server.display).env_remove("WAYLAND_DISPLAY");
    command.envs(point.map(|point| ("CODRIVE_KILL_AT", point)));
    command.output().unwrap()
}

#[test]
fn a_drive_in_a_window_killed_at_any_point_is_recovered() {
    let server = Server::start([640, 400]);
    let folder = tempfile::tempdir().unwrap();
    // Engine, point of the kill, and minimum number of rows on the disk at that point.
    let kills = [
        ("native", "begin.manifest", 0),
        ("native", "tick:40", 0),
        ("sumo", "flush.written:2", 1),
        ("sumo", "flush.synced:3", 3),
    ];
    for (engine, point, least) in kills {
        let drive = folder.path().join(point.replace(':', "-"));
        let out = drive.to_str().unwrap();
        let arguments =
            ["drive", "--traffic", engine, "--warm-up", "0", "--quality", "low", "--trees", "0", "--out", out];
        let killed = codrive(&arguments, &server, Some(point));
        assert_eq!(killed.status.signal(), Some(9), "{point} was not reached: {killed:?}");
        let found = recover(&drive).unwrap_or_else(|e| panic!("{point}: {e}"));
        // A tick may end while another thread writes a block of the journal. That block is then torn and kept separately.
        let torn = usize::from(point.starts_with("tick") && found.kept.is_some());
        assert_eq!(
            (found.was_whole, found.missing.len(), found.kept.iter().len()),
            (false, torn, torn),
            "{point}: {found:?}"
        );
        let ticks = TableReader::parquet(&Table::Ego.parquet(&drive)).unwrap().wholes("tick");
        assert_eq!(ticks, (1..=ticks.len() as u64).collect::<Vec<_>>(), "{point}: no hole, nothing twice");
        assert!(ticks.len() >= least, "{point}: {ticks:?}");
        if !ticks.is_empty() {
            let replayed = codrive(&["replay", out], &server, None);
            assert!(replayed.status.success(), "{point}: {replayed:?}");
        }
    }
}

const STUDY: &str = r#"title = "Short"
participants = 2
least_frames_per_s = 0
[base]
traffic = "native"
vehicles = 6
trees = 0
quality = "low"
[[condition]]
name = "narrow"
[[segment]]
kind = "text"
name = "welcome"
text = "Welcome"
[[segment]]
kind = "trials"
name = "trial"
"#;

#[test]
fn a_session_killed_at_its_start_opens_again_by_the_same_command() {
    let server = Server::start([1300, 820]);
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("short.toml");
    fs::write(&study, STUDY).unwrap();
    // Four saves make the data set; the next two write the session's file, before the first item begins.
    let saves = (1..=6).map(|save| format!("replace.written:{save}"));
    for point in saves.chain(["replace.renamed:5", "replace.renamed:6", "session.begin:1"].map(str::to_owned)) {
        let out = folder.path().join(point.replace(':', "-"));
        let arguments = ["study", "session", study.to_str().unwrap(), "P03", "--out", out.to_str().unwrap()];
        let killed = codrive(&arguments, &server, Some(&point));
        assert_eq!(killed.status.signal(), Some(9), "{point} was not reached: {killed:?}");
        let mut again = Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(arguments)
            .env("RUST_LOG", "error")
            .env("DISPLAY", &server.display)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let file = out.join("sourcedata/sub-P03").join(FILE);
        let opened = wait_for("the session", || {
            let log = SessionLog::load(&file).ok();
            // A new session begins at once; after a cut the experimenter decides when it continues.
            let is_open = log.is_some_and(|log| log.running.is_some() || !log.item_runs.is_empty());
            (is_open || again.try_wait().unwrap().is_some()).then_some(is_open)
        });
        again.kill().unwrap();
        let output = again.wait_with_output().unwrap();
        assert!(opened, "{point}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
