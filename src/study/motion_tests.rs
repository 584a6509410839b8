//! Tests of motion tables: every row of a recorded drive, rounded; gaps; channels and frames of reference.

use super::*;
use crate::{
    controls::Controls,
    record::{Manifest, Recorder},
    scenario::Scenario,
    sim::{SummaryAccumulator, World},
    traffic::EngineChoice,
};
use glam::{Mat3, Quat};
use std::{fs, path::PathBuf};

/// Records a drive of `ticks` ticks that accelerates, brakes and turns. Ticks for which `is_lost` is true are missing from the recording.
/// Returns its folder, and the rotation of the ego at the end.
fn drive(folder: &Path, ticks: u64, is_lost: fn(u64) -> bool) -> (PathBuf, Quat) {
    let scenario = Scenario { traffic: EngineChoice::Native, ..Scenario::default() };
    let mut world = World::new(&scenario).unwrap();
    let mut recorder = Recorder::begin(&folder.join("drive"), &scenario, Manifest::default()).unwrap();
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    for tick in 1..=ticks {
        let (throttle, brake) = if tick < 300 { (0.8, 0.0) } else { (0.0, 0.9) };
        let controls = Controls { throttle, brake, steering_wheel_rad: 1.25, ..Controls::default() };
        world.tick(&controls).unwrap();
        summary.add(world.snapshot(), world.events());
        if !is_lost(tick) {
            recorder.tick(&world, &controls).unwrap();
        }
    }
    let rotation = world.snapshot().ego.rotation;
    (recorder.finish(&summary.to_summary()).unwrap(), rotation)
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split('\t').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn every_tick_is_a_row_with_the_recorded_values_rounded() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, rotation) = drive(folder.path(), 350, |_| false);
    let path = folder.path().join("motion.tsv");
    let span = write(&recording, &path).unwrap().unwrap();
    assert_eq!(span, MotionSpan { samples: 350, first: 1, last: 350 });
    let rows = rows(&path);
    assert_eq!(rows.len(), 350);
    let ego = TableReader::parquet(&Table::Ego.parquet(&recording)).unwrap();
    // Column of the recording for each column of the table, and half a unit of its last digit: 0.1 mm, 1 urad.
    let columns = [
        ("x_m", 5e-5),
        ("y_m", 5e-5),
        ("z_m", 5e-5),
        ("roll_rad", 5e-7),
        ("pitch_rad", 5e-7),
        ("yaw_rad", 5e-7),
        ("speed_mps", 5e-5),
        ("accel_mps2", 5e-5),
        ("lateral_accel_mps2", 5e-5),
        ("yaw_rate_radps", 5e-7),
        ("throttle", 5e-5),
        ("brake", 5e-5),
        ("steering_wheel_rad", 5e-6),
    ];
    for (i, (name, half)) in columns.into_iter().enumerate() {
        let recorded = ego.numbers(name);
        for (row, value) in rows.iter().zip(recorded) {
            assert!((row[i + 1] - value.unwrap()).abs() < half * 1.001, "{name}: {} {value:?}", row[i + 1]);
        }
    }
    for (i, row) in rows.iter().enumerate() {
        assert!((row.len(), row[0]) == (14, i as f64 / 100.0), "{row:?}");
    }
    // Rotations about fixed axes: x first, then y, then z. Another order is off by about 0.01.
    let frames: Value = serde_json::from_str(&reference_frames()).unwrap();
    assert_eq!(frames["reference_frame"]["Levels"]["world"]["RotationOrder"], "XYZ");
    let [roll, pitch, yaw] = [4, 5, 6].map(|i: usize| rows[349][i] as f32);
    let by_angles = Mat3::from_rotation_z(yaw) * Mat3::from_rotation_y(pitch) * Mat3::from_rotation_x(roll);
    assert!(by_angles.abs_diff_eq(Mat3::from_quat(rotation), 1e-5), "{by_angles} {rotation}");
    assert!(pitch.abs() > 0.005 && roll.abs() > 0.001 && yaw.abs() > 0.1, "it braked in a bend: {roll} {pitch} {yaw}");
    assert!(!path.with_extension(record::BESIDE).exists());
    assert!(!fs::read_to_string(&path).unwrap().contains("-0\t"), "a zero has no sign");
}

#[test]
fn lost_ticks_leave_a_time_step_and_lower_the_effective_rate() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, _) = drive(folder.path(), 101, |tick| (41..=60).contains(&tick));
    let path = folder.path().join("motion.tsv");
    let span = write(&recording, &path).unwrap().unwrap();
    let rows = rows(&path);
    assert_eq!((rows.len(), rows[39][0], rows[40][0], rows[80][0]), (81, 0.39, 0.6, 1.0));
    let written = sidecar(span, json!({ "TaskName": "trial" }));
    // 80 steps from the first sample to the last, in 1 s.
    assert_eq!((&written["SamplingFrequency"], &written["SamplingFrequencyEffective"]), (&json!(100.0), &json!(80.0)));
    assert_eq!((&written["RecordingDuration"], &written["TaskName"]), (&json!(0.81), &json!("trial")));
}

#[test]
fn no_ticks_give_no_table_and_an_unreadable_recording_changes_none() {
    let folder = tempfile::tempdir().unwrap();
    let (recording, _) = drive(folder.path(), 3, |_| true);
    let path = folder.path().join("motion.tsv");
    assert_eq!(write(&recording, &path).unwrap(), None);
    assert!(!path.exists());
    fs::write(&path, "0\t1\n").unwrap();
    fs::write(Table::Ego.parquet(&recording), "no Parquet").unwrap();
    let message = write(&recording, &path).unwrap_err().to_string();
    assert!(message.contains("ego.parquet") && message.contains("no Parquet file"), "{message}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "0\t1\n");
    let one = sidecar(MotionSpan { samples: 1, first: 7, last: 7 }, json!({}));
    assert_eq!(one["SamplingFrequencyEffective"], 100.0);
}

#[test]
fn channels_are_counted_by_type_and_each_names_a_described_frame() {
    let text = channels();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split('\t').collect()).collect();
    // Order of columns that BIDS requires (Motion-BIDS, channels description).
    assert_eq!(rows[0][..6], ["name", "component", "type", "tracked_point", "units", "reference_frame"]);
    let written = sidecar(MotionSpan { samples: 2, first: 1, last: 2 }, json!({}));
    for kind in ["POS", "ORNT", "VEL", "ACCEL", "ANGACCEL", "GYRO", "JNTANG", "MAGN", "LATENCY", "MISC"] {
        let count = rows[1..].iter().filter(|row| row[2] == kind).count();
        assert_eq!(written[format!("{kind}ChannelCount")], count, "{kind}");
    }
    assert_eq!(written["MotionChannelCount"], rows.len() - 1);
    assert_eq!((&written["TrackedPointsCount"], &written["SamplingFrequencyEffective"]), (&json!(4), &json!(100.0)));
    let frames: Value = serde_json::from_str(&reference_frames()).unwrap();
    let mut names = std::collections::BTreeSet::new();
    for row in &rows[1..] {
        assert!(row.len() == 7 && names.insert(row[0]), "{row:?}");
        let frame = &frames["reference_frame"]["Levels"][row[5]];
        assert!(row[5] == "n/a" || frame["RotationRule"] == "right-hand", "{row:?}");
    }
}
