//! Recordings of drives behind the vehicles of a file: the file is in the recording, and the replay has the same bits without it.

use super::{codrive, printed as printed_of, record};
use std::{fs, path::Path};

#[test]
fn a_drive_behind_a_log_carries_its_file_and_replays_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (log, drive) = (folder.path().join("leader.csv"), folder.path().join("p1"));
    let rows: String = (0..=100).map(|k| format!("{},{}\n", f64::from(k) / 5.0, 12.0 + f64::from(k % 9))).collect();
    fs::write(&log, format!("time_s,speed_mps\n{rows}")).unwrap();
    let scenario = "map = \"lane-10km\"\ntraffic = \"leader.csv\"\nvehicles = 8\nadvised = \"30%\"\n";
    fs::write(folder.path().join("trial.toml"), scenario).unwrap();
    let [file, out] = [folder.path().join("trial.toml"), drive.clone()].map(|path| path.to_str().unwrap().to_owned());
    let policy = ["--policy", "follower-stopper", "--traffic-drivers", "safe-followers", "--duration", "0"];
    codrive(&[&["run", "--scenario", &file, "--out", &out], &policy[..]].concat()).assert().success();

    let carried = drive.join("inputs/traffic/leader.csv");
    assert_eq!(fs::read(&carried).unwrap(), fs::read(&log).unwrap());
    let sums = fs::read_to_string(drive.join("checksums.json")).unwrap();
    assert!(sums.contains("inputs/traffic/leader.csv"), "{sums}");
    let kept = fs::read_to_string(drive.join("scenario.toml")).unwrap();
    assert!(kept.contains("traffic = \"inputs/traffic/leader.csv\"") && kept.contains("duration_s = 20.0"), "{kept}");
    let manifest = fs::read_to_string(drive.join("manifest.json")).unwrap();
    assert!(manifest.contains("native with a log"), "{manifest}");

    // The recording needs no other file.
    fs::remove_file(&log).unwrap();
    let (code, text) = printed_of(&mut codrive(&["replay", &out]));
    assert_eq!(code, 0, "{text}");
    // A changed file is found before the replay.
    let changed = fs::read_to_string(&carried).unwrap().replace("\n1,17\n", "\n1,18\n");
    fs::write(&carried, changed).unwrap();
    let (code, text) = printed_of(&mut codrive(&["replay", &out]));
    assert!(code == 1 && text.contains("inputs/traffic/leader.csv"), "{text}");
}

#[test]
fn a_recording_becomes_a_log_of_all_its_vehicles() {
    let folder = tempfile::tempdir().unwrap();
    let [drive, log] = ["p1", "ring.csv"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    record(Path::new(&drive), "30");
    codrive(&["analyse", &drive, "--trajectories", &log]).assert().success();
    let text = fs::read_to_string(&log).unwrap();
    assert!(
        text.starts_with("time_s,vehicle,s_m,speed_mps\n0.10,0,") && text.lines().count() == 1 + 300 * 22,
        "{text:.80}"
    );
    // Of 22 vehicles on the ring, vehicle 21 ended it, just behind the ego a lap on: on the lane it is the first.
    let behind = [
        "run",
        "--map",
        "lane-10km",
        "--traffic",
        &log,
        "--duration",
        "0",
        "--policy",
        "none",
        "--vehicles",
        "2",
        "--json",
    ];
    let output = codrive(&behind).output().unwrap();
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["scenario"]["vehicles"], 23);
    assert!((printed["summary"]["duration_s"].as_f64().unwrap() - 29.9).abs() < 0.05, "{printed}");
    let (code, text) = printed_of(&mut codrive(&["analyse", &drive, "--trajectories", &log]));
    assert!(code == 2 && text.contains("ring.csv: cannot be written"), "{text}");
}
