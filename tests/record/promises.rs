//! Promises of recordings about cuts and what-ifs, each in a case that would show a fault.

use codrive::{
    drive_loop::offline::OfflineDrive,
    record::{Table, TableReader, recover},
    replay,
    scenario::Scenario,
    traffic::EngineChoice,
};
use std::{fs, path::Path, sync::atomic::AtomicBool, time::Duration};

fn scenario() -> Scenario {
    Scenario { traffic: EngineChoice::Native, vehicles: 3, duration_s: 20.0, hold_s: 1.0, ..Scenario::default() }
}

fn ticks(drive: &Path) -> usize {
    TableReader::parquet(&Table::Ego.parquet(drive)).unwrap().rows()
}

#[test]
fn a_what_if_of_a_stopped_recording_is_as_long_as_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let (drive, out) = (folder.path().join("p1"), folder.path().join("instead"));
    let mut run = OfflineDrive::new(&scenario(), [0.0, f64::INFINITY]).unwrap();
    run.record(&drive).unwrap();
    run.until(4.0).unwrap();
    run.finish_recording().unwrap();
    drop(run);
    let changes = replay::changes(&["none".into()]).unwrap();
    let pair = replay::what_if(&drive, &changes, &out, &AtomicBool::new(false), &|_| ()).unwrap().unwrap();
    assert_eq!((ticks(&drive), ticks(&out)), (400, 400));
    assert!(pair.is_proven && pair.recorded.duration_s == 4.0 && pair.instead.duration_s == 4.0, "{pair:?}");
}

/// Returns the number of ticks that recovery finds in a copy of the files that are on the disk now.
fn ticks_if_cut(drive: &Path, copy: &Path) -> usize {
    let _ = fs::remove_dir_all(copy);
    fs::create_dir_all(copy.join("journal")).unwrap();
    for name in ["manifest.json", "scenario.toml", "journal/rows.blocks"] {
        fs::copy(drive.join(name), copy.join(name)).unwrap();
    }
    recover(copy).unwrap();
    ticks(copy)
}

#[test]
fn a_cut_of_a_drive_without_a_window_loses_half_a_second_at_most() {
    let folder = tempfile::tempdir().unwrap();
    let (drive, copy) = (folder.path().join("p1"), folder.path().join("cut"));
    let mut run = OfflineDrive::new(&scenario(), [0.0, f64::INFINITY]).unwrap();
    run.record(&drive).unwrap();
    for _ in 0..15 {
        run.step().unwrap();
        run.keep_time();
        let driven = run.world().snapshot().tick.0 as usize;
        // The writing thread may be late on a loaded machine; ticks that it never received would never arrive.
        let mut waits = 0;
        while ticks_if_cut(&drive, &copy) + 50 < driven {
            waits += 1;
            assert!(waits < 1000, "{} of {driven} ticks are on the disk", ticks(&copy));
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
