//! Drives with a secondary task by the simulated driver: a replay repeats them to the bit, and finds a press that was taken away or forged.

use super::{
    resealed::{replayed, tampered},
    resealing::{read_json, reseal},
    tampering::{rows, write},
};
use arrow_array::{Array, ArrayRef, RecordBatch, StringArray};
use codrive::{
    drive_loop::offline::OfflineDrive,
    scenario::{Scenario, SecondaryTask, SecondaryTaskKind},
    traffic::EngineChoice,
};
use std::{path::Path, sync::Arc};

/// Records a minute with a task in `folder`.
fn record(kind: SecondaryTaskKind, folder: &Path) {
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        vehicles: 3,
        duration_s: 60.0,
        secondary_task: SecondaryTask { kind, self_paced: true, ..SecondaryTask::default() },
        ..Scenario::default()
    };
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).unwrap();
    run.record(folder).unwrap();
    run.until(60.0).unwrap();
    run.finish_recording().unwrap();
}

/// Returns the words of a column of a table.
fn words(table: &RecordBatch, column: &str) -> Vec<String> {
    let column = table.column_by_name(column).unwrap().as_any().downcast_ref::<StringArray>().unwrap();
    (0..column.len()).map(|row| column.value(row).to_owned()).collect()
}

#[test]
fn a_drive_with_each_task_is_replayed_to_the_bit() {
    let number = |folder: &Path, key: &str| read_json(&folder.join("summary.json"))[key].as_f64().unwrap_or(f64::NAN);
    // In a minute: signals every 4 s on average; two blocks of ten digits; displays of about 3 s; a self-paced shutter that
    // opens about every 3 s.
    for (kind, key, [least, most]) in [
        (SecondaryTaskKind::DetectionResponse, "detection_signals", [11.0, 19.0]),
        (SecondaryTaskKind::NBack, "n_back_digits", [20.0, 20.0]),
        (SecondaryTaskKind::SurrogateReference, "search_displays", [10.0, 30.0]),
        (SecondaryTaskKind::Occlusion, "shutter_openings", [12.0, 28.0]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let drive = folder.path().join("drive");
        record(kind, &drive);
        let count = number(&drive, key);
        assert!((least..=most).contains(&count), "{key}: {count}");
        let report = replayed(&drive).unwrap();
        assert!(report.is_proven() && report.ticks == 6000, "{kind:?}: {report:?}");
    }
}

#[test]
fn a_press_that_was_taken_away_or_forged_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("drive");
    record(SecondaryTaskKind::DetectionResponse, &whole);
    let pressed = words(&rows(&whole.join("ego.parquet")), "task_button");
    let first = pressed.iter().position(|button| button == "respond").unwrap();
    for (row, button) in [(first, "none"), (first + 5, "respond")] {
        let (_folder, drive) = tampered(&whole, |drive| {
            let path = drive.join("ego.parquet");
            let table = rows(&path);
            let mut changed = pressed.clone();
            changed[row] = button.into();
            let at = table.schema().index_of("task_button").unwrap();
            let mut columns = table.columns().to_vec();
            columns[at] = Arc::new(StringArray::from(changed)) as ArrayRef;
            write(&path, &RecordBatch::try_new(table.schema(), columns).unwrap());
            reseal(drive);
        });
        let report = replayed(&drive).unwrap();
        assert!(!report.is_proven(), "{button} in row {row}");
    }
}
