//! A recording beside the same drive: what people wrote down is no difference, what the world did not do is.

use super::*;
use crate::{
    record::{Manifest, Recorder},
    sim::{Scenario, Tally},
};

const TICKS: u64 = 120;

fn world() -> World {
    let scenario = Scenario {
        traffic: "native".into(),
        policy: "constant".into(),
        vehicles: 3,
        hold_s: 0.5,
        duration_s: 0.01 * TICKS as f64,
        ..Scenario::default()
    };
    World::new(&scenario).expect("a world")
}

fn controls(tick: u64) -> Controls {
    Controls { throttle: 0.1 + 0.001 * tick as f32, ..Controls::default() }
}

/// The recording of a drive to its end; `write` is asked after each tick.
fn recorded(folder: &Path, write: impl Fn(&mut Recorder, u64)) -> std::path::PathBuf {
    let mut world = world();
    let mut recorder = Recorder::begin(&folder.join("drive"), world.scenario(), Manifest::default()).expect("begun");
    let mut tally = Tally::new([0.0, f64::INFINITY]);
    for tick in 1..=TICKS {
        world.tick(&controls(tick)).expect("the native engine");
        tally.add(world.snapshot(), world.events());
        recorder.tick(&world, &controls(tick)).expect("room");
        write(&mut recorder, tick);
    }
    assert!(world.ended().is_some());
    recorder.finish(&tally.summary()).expect("finished")
}

/// That recording compared with a drive with these controls. How many cells differ, and the first.
fn compared(recording: &Path, driven: impl Fn(u64) -> Controls) -> (u64, Option<Difference>) {
    let mut world = world();
    let mut comparison = Comparison::open(recording).expect("a recording");
    for tick in 1..=TICKS {
        let recorded = comparison.controls(Tick(tick)).expect("rows").expect("no hole");
        assert_eq!(recorded, controls(tick));
        world.tick(&driven(tick)).expect("the native engine");
        comparison.tick(&world, &driven(tick)).expect("rows");
    }
    assert_eq!(comparison.controls(Tick(TICKS + 1)).expect("rows"), None, "the recording ends");
    comparison.end(Tick(TICKS)).expect("rows");
    (comparison.cells(), comparison.first().cloned())
}

#[test]
fn marks_and_notes_stand_between_the_worlds_events_and_are_no_difference() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |recorder, tick| {
        // At every tick, so that they stand before and after whatever the world does.
        recorder.event(Tick(tick), "mark", "by hand");
        recorder.event(Tick(tick), "note", "coughs");
    });
    assert_eq!(compared(&drive, controls), (0, None));
}

#[test]
fn an_event_that_the_world_did_not_make_is_one_too_many() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |recorder, tick| {
        if [20, 21, TICKS].contains(&tick) {
            recorder.event(Tick(tick), "left_road", "never");
        }
    });
    let (cells, first) = compared(&drive, controls);
    let first = first.expect("a difference");
    assert_eq!(cells, 3);
    assert_eq!((first.table, first.row, first.tick, first.column.as_str()), (Table::Events, 0, Tick(20), "tick"));
    assert_eq!((first.recorded.as_str(), first.driven.as_str()), ("20", ""));
    assert_eq!(first.to_string(), "events.parquet, row 0 (0.20 s), column tick: recorded 20, driven again nothing");
}

#[test]
fn events_after_the_last_one_of_the_drive_are_counted_one_by_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |recorder, tick| {
        if tick == TICKS {
            recorder.event(Tick(tick), "contact", "never");
            recorder.event(Tick(tick), "mark", "by hand");
            recorder.event(Tick(tick), "contact", "nor this");
        }
    });
    let (cells, first) = compared(&drive, controls);
    assert_eq!(cells, 2, "{first:?}");
    // Row 0 is the end of the drive.
    assert_eq!(first.map(|first| (first.table, first.row)), Some((Table::Events, 1)));
}

#[test]
fn another_control_is_found_at_its_tick_under_its_name_and_not_as_a_fingerprint() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |_, _| ());
    assert_eq!(compared(&drive, controls), (0, None));
    let other = |tick: u64| if tick == 57 { Controls { throttle: 0.5, ..Controls::default() } } else { controls(tick) };
    let (cells, first) = compared(&drive, other);
    let first = first.expect("a difference");
    assert_eq!((first.table, first.row, first.tick), (Table::Ego, 56, Tick(57)));
    assert_eq!((first.column.as_str(), first.driven.as_str()), ("throttle", "0.5"));
    // Control, speed and fingerprint of that tick; speed and fingerprint of each of the 63 after it, and more.
    assert!(cells > 2 * 63, "{cells}");
}
