//! Tests of the comparison: notes of people are no difference, deviations of the world are.

use super::*;
use crate::{
    metrics::{AutomationChange, SwitchedOffBy},
    record::{AlteredFile, Checksums, Manifest, Recorder, TableReader, changes},
    scenario::{Automation, AutomationSystem, Scenario},
    sim::SummaryAccumulator,
    traffic::EngineChoice,
};

const TICKS: u64 = 120;

fn world() -> World {
    world_with(Automation::default())
}

fn world_with(automation: Automation) -> World {
    let scenario = Scenario {
        automation,
        traffic: EngineChoice::Native,
        policy: "constant".into(),
        vehicles: 3,
        hold_s: 0.5,
        duration_s: 0.01 * TICKS as f64,
        ..Scenario::default()
    };
    World::new(&scenario).expect("a world")
}

fn controls(tick: u64) -> Controls {
    let hand_torque_nm = (!tick.is_multiple_of(3)).then_some(0.01 * tick as f32);
    Controls { throttle: 0.1 + 0.001 * tick as f32, gap_button: tick == 50, hand_torque_nm, ..Controls::default() }
}

/// Records a drive to its end; `write` is called after each tick.
fn recorded(folder: &Path, write: impl Fn(&mut Recorder, u64)) -> std::path::PathBuf {
    recorded_of(world(), controls, folder, write)
}

fn recorded_of(
    mut world: World,
    given: fn(u64) -> Controls,
    folder: &Path,
    write: impl Fn(&mut Recorder, u64),
) -> std::path::PathBuf {
    let mut recorder = Recorder::begin(&folder.join("drive"), world.scenario(), Manifest::default()).expect("begun");
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    for tick in 1..=TICKS {
        world.tick(&given(tick)).expect("the native engine");
        summary.add(world.snapshot(), world.events());
        recorder.tick(&world, &given(tick)).expect("room");
        write(&mut recorder, tick);
    }
    assert!(world.ended().is_some());
    recorder.finish(&summary.to_summary()).expect("finished")
}

/// Compares a recording with a drive with these controls. Returns the number of differing cells and the first of them.
fn compared(recording: &Path, driven: impl Fn(u64) -> Controls) -> (u64, Option<CellDifference>) {
    compared_of(world(), controls, recording, driven)
}

fn compared_of(
    mut world: World,
    given: fn(u64) -> Controls,
    recording: &Path,
    driven: impl Fn(u64) -> Controls,
) -> (u64, Option<CellDifference>) {
    let mut comparison = TableComparison::open(recording, &world).expect("a recording");
    assert_eq!(comparison.controls(Tick(2)).expect("rows"), None, "the row that comes next is of another tick");
    for tick in 1..=TICKS {
        let recorded = comparison.controls(Tick(tick)).expect("rows").expect("no hole");
        assert_eq!(recorded, given(tick));
        world.tick(&driven(tick)).expect("the native engine");
        comparison.tick(&world, &driven(tick)).expect("rows");
    }
    assert_eq!(comparison.controls(Tick(TICKS + 1)).expect("rows"), None, "the recording ends");
    comparison.end(Tick(TICKS), false).expect("rows");
    (comparison.cells(), comparison.first().cloned())
}

#[test]
fn a_time_gap_and_a_takeover_by_hands_are_repeated() {
    // The gap goes from 1.5 to 2 s at 0.3 s, and hands of 1.2 N m take over at 0.6 s.
    let given = |tick: u64| Controls {
        gap_button: tick == 30,
        hand_torque_nm: Some(if tick < 60 { 0.1 } else { 1.2 }),
        ..Controls::default()
    };
    let automation = Automation { system: AutomationSystem::CruiseAndLaneKeeping, ..Automation::default() };
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded_of(world_with(automation), given, folder.path(), |_, _| ());
    assert_eq!(compared_of(world_with(automation), given, &drive, given), (0, None));
    let mut world = world_with(automation);
    let mut changes = Vec::new();
    for tick in 1..=TICKS {
        world.tick(&given(tick)).expect("the native engine");
        changes.extend(world.events().iter().filter_map(|event| match event.kind {
            EventKind::Automation(change) => Some((event.tick.0, change)),
            _ => None,
        }));
    }
    let expected =
        [(30, AutomationChange::TimeGap { time_gap_s: 2.0 }), (60, AutomationChange::Off(SwitchedOffBy::Wheel))];
    assert_eq!(changes[1..], expected);
    // Without them the drive is another one, beside the two columns of the controls themselves.
    let (cells, _) = compared_of(world_with(automation), given, &drive, |_| Controls::default());
    assert!(cells > 2 * TICKS, "{cells}");
}

#[test]
fn marks_and_notes_between_events_are_no_difference() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |recorder, tick| {
        // At every tick, so that they lie before and after every event of the world.
        recorder.event(Tick(tick), "mark", "by hand");
        recorder.event(Tick(tick), "note", "coughs");
    });
    assert_eq!(compared(&drive, controls), (0, None));
}

#[test]
fn an_event_that_the_world_did_not_make_is_surplus() {
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
fn a_missing_row_after_surplus_rows_is_counted_with_them() {
    // Two contacts that never happened, and the end of the drive replaced by an event of another kind.
    let folder = tempfile::tempdir().expect("a folder");
    let mut cursor = {
        let drive = recorded(folder.path(), |recorder, tick| {
            if [20, 21].contains(&tick) {
                recorder.event(Tick(tick), "contact", "never");
            }
        });
        TableCursor::open(&drive, Table::Events).expect("a table")
    };
    let later = EventRow {
        tick: Tick(50),
        kind: "left_road".into(),
        detail: String::new(),
        car: None,
        value: None,
        angle_rad: None,
    };
    let mut found = Differences::default();
    cursor.compare(EVENTS, &later, &mut found).expect("rows");
    assert_eq!((found.cells, found.first.map(|first| first.tick)), (3, Some(Tick(20))), "two too many and one missing");
    // The end of the drive is still to be compared.
    assert_eq!((cursor.has_row().expect("rows"), cursor.tick()), (true, Tick(TICKS)));
}

#[test]
fn a_table_is_read_column_by_column_and_part_by_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |_, _| ());
    let cars = TableReader::parquet(&Table::Cars.parquet(&drive)).expect("a table");
    // Three vehicles at each of twelve steps.
    let ids: Vec<Option<u32>> = (0..36).map(|row| Some(row % 3)).collect();
    assert_eq!((cars.rows(), cars.ids("car")), (36, ids));
    assert_eq!(cars.wholes("tick"), (0..36).map(|row| 10 * (row / 3 + 1)).collect::<Vec<u64>>());
    let parts = TableReader::parts(&Table::Cars.parquet(&drive), &["tick"]).expect("a table");
    assert_eq!(parts.map(|part| part.expect("rows").rows()).sum::<usize>(), 36);
}

#[test]
fn a_changed_control_is_reported_by_its_column_and_not_by_the_hash() {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |_, _| ());
    assert_eq!(compared(&drive, controls), (0, None));
    let other = |tick: u64| if tick == 57 { Controls { throttle: 0.5, ..Controls::default() } } else { controls(tick) };
    let (cells, first) = compared(&drive, other);
    let first = first.expect("a difference");
    assert_eq!((first.table, first.row, first.tick), (Table::Ego, 56, Tick(57)));
    assert_eq!((first.column.as_str(), first.driven.as_str()), ("throttle", "0.5"));
    // Control, speed and hash of that tick; speed and hash of each of the 63 later ticks, and more.
    assert!(cells > 2 * 63, "{cells}");
}

/// Returns the alterations found in a fresh recording after `tamper` changed its folder.
fn alterations_by(tamper: impl Fn(&Path)) -> Vec<AlteredFile> {
    let folder = tempfile::tempdir().expect("a folder");
    let drive = recorded(folder.path(), |_, _| ());
    tamper(&drive);
    changes(&drive).expect("readable")
}

#[track_caller]
fn assert_alteration(tamper: impl Fn(&Path), file: &str, has: &str) {
    let found = alterations_by(tamper);
    assert!(found.len() == 1 && found[0].file == file && found[0].what.contains(has), "{found:?}");
}

fn edit(path: &Path, change: impl Fn(String) -> String) {
    let text = std::fs::read_to_string(path).expect("there");
    std::fs::write(path, change(text)).expect("written");
}

#[test]
fn every_altered_file_of_a_recording_is_reported() {
    let gone = |name: &'static str| move |drive: &Path| std::fs::remove_file(drive.join(name)).expect("there");
    assert_eq!(alterations_by(|_| ()), []);
    for name in ["scenario.toml", "summary.json"] {
        assert_alteration(gone(name), name, "is missing");
        let found = alterations_by(|drive| edit(&drive.join(name), |text| text + "\n"));
        let differs = found.iter().any(|change| change.what.contains("its SHA-256 differs"));
        assert!(differs && found.iter().all(|change| change.file == name), "{found:?}");
    }
    assert_alteration(gone("checksums.json"), "checksums.json", "is missing");
    assert_alteration(gone("cars.parquet"), "cars.parquet", "is missing");
    assert_alteration(
        |drive| edit(&drive.join("checksums.json"), |text| text + "\n"),
        "checksums.json",
        "manifest.json has another SHA-256 of it",
    );
    assert_alteration(
        |drive| edit(&drive.join("manifest.json"), |text| text.replacen("\"seed\": 0", "\"seed\": 1", 1)),
        "manifest.json",
        "its own SHA-256 differs",
    );
    assert_alteration(
        |drive| std::fs::write(drive.join("ego.parquet"), "no").expect("room"),
        "ego.parquet",
        "cannot be read",
    );
    // All seals are renewed, without the sum of one column.
    let unsealed = |drive: &Path| {
        let (mut sums, mut manifest) = (Checksums::load(drive).expect("there"), Manifest::load(drive).expect("there"));
        sums.tables.get_mut("ego").expect("a table").columns.remove("throttle").expect("a column");
        manifest.checksums = Some(sums.save(drive).expect("room"));
        manifest.seal(drive).expect("room");
    };
    assert_alteration(unsealed, "ego.parquet", "checksums.json has no SHA-256 of column throttle");
    // A table replaced by another one: other rows, other columns.
    let swapped = alterations_by(|drive| {
        std::fs::copy(drive.join("cars.parquet"), drive.join("events.parquet")).expect("room");
    });
    assert!(swapped.iter().all(|change| change.file == "events.parquet"), "{swapped:?}");
    for has in ["rows; 1 were written", "column detail is missing", "column s_m is new"] {
        assert!(swapped.iter().any(|change| change.what.contains(has)), "{has}: {swapped:?}");
    }
}
