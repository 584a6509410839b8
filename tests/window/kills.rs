//! Drives in a window that are killed at a point of their recording: what is left is recovered and replays.

use crate::xserver::Server;
use codrive::record::{Reader, Table, recover};
use std::{
    os::unix::process::ExitStatusExt,
    process::{Command, Output},
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
    // The point, and how many rows are on the disk by then at least.
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
        assert_eq!((found.was_whole, found.kept), (false, None), "{point}");
        let ticks = Reader::parquet(&Table::Ego.parquet(&drive)).unwrap().wholes("tick");
        assert_eq!(ticks, (1..=ticks.len() as u64).collect::<Vec<_>>(), "{point}: no hole, nothing twice");
        assert!(ticks.len() >= least, "{point}: {ticks:?}");
        if !ticks.is_empty() {
            let replayed = codrive(&["replay", out], &server, None);
            assert!(replayed.status.success(), "{point}: {replayed:?}");
        }
    }
}
