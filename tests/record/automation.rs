//! Drives with an automation by the simulated driver: a replay repeats them to the bit, and finds a press that was forged.

use super::{
    resealed::{replayed, tampered},
    resealing::{read_json, reseal},
    tampering::{rows, write},
};
use arrow_array::{ArrayRef, BooleanArray, RecordBatch};
use codrive::{
    analysis::{data::RecordedTrial, measures::DriveTotals},
    drive_loop::offline::OfflineDrive,
    scenario::Scenario,
};
use std::{path::Path, sync::Arc};

/// Records half a minute with a system, and a takeover request at 10 s, in `folder`.
fn record(system: &str, folder: &Path) {
    let text = format!(
        "traffic = \"native\"\nvehicles = 6\nduration_s = 30\nextra_delay_s = 0.05\n[automation]\nsystem = \"{system}\"\n\
         [[event]]\nname = \"ask\"\ntrigger = {{ time_s = 10 }}\nactions = [{{ takeover_request = {{ lead_s = 9 }} }}]\n"
    );
    let scenario = Scenario::from_toml(&text, "automation.toml").unwrap_or_else(|fault| panic!("{fault}"));
    let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).unwrap();
    run.record(folder).unwrap();
    run.until(30.0).unwrap();
    run.finish_recording().unwrap();
}

#[test]
fn a_drive_with_each_system_is_replayed_to_the_bit() {
    for system in ["adaptive-cruise-control", "lane-keeping", "cruise-and-lane-keeping", "traffic-jam-pilot", "policy"]
    {
        let folder = tempfile::tempdir().unwrap();
        let drive = folder.path().join("drive");
        record(system, &drive);
        let summary = read_json(&drive.join("summary.json"));
        assert_eq!(
            (summary["takeover_requests"].as_u64(), summary["takeovers"].as_u64()),
            (Some(1), Some(1)),
            "{system}"
        );
        let report = replayed(&drive).unwrap();
        assert!(report.is_proven() && report.ticks == 3000, "{system}: {report:?}");
    }
}

#[test]
fn an_analysis_has_the_takeover_scores_of_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("drive");
    record("traffic-jam-pilot", &drive);
    let summary = read_json(&drive.join("summary.json"));
    let trial = RecordedTrial::open(&drive).unwrap();
    let (totals, _) = DriveTotals::of(&trial, None, &[], |_| ()).unwrap();
    let scores = serde_json::to_value(totals.takeovers.scores().expect("a request")).unwrap();
    assert!(scores["takeover_time_s"].as_f64().is_some_and(|time_s| time_s > 0.5), "{scores}");
    for (name, value) in scores.as_object().unwrap() {
        assert_eq!(summary.get(name), Some(value), "{name}");
    }
}

#[test]
fn a_forged_press_of_a_button_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("drive");
    record("cruise-and-lane-keeping", &whole);
    for button in ["automation_button", "gap_button"] {
        let (_folder, drive) = tampered(&whole, |drive| {
            let path = drive.join("ego.parquet");
            let table = rows(&path);
            let pressed: Vec<bool> = (0..table.num_rows()).map(|row| row == 500).collect();
            let at = table.schema().index_of(button).unwrap();
            let mut columns = table.columns().to_vec();
            columns[at] = Arc::new(BooleanArray::from(pressed)) as ArrayRef;
            write(&path, &RecordBatch::try_new(table.schema(), columns).unwrap());
            reseal(drive);
        });
        assert!(!replayed(&drive).unwrap().is_proven(), "{button}");
    }
}
