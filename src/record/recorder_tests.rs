//! What a cut, a full disk and a disk that hangs leave behind.

use super::*;
use crate::{
    record::{Reader, manifest::Hashed},
    sim::Tally,
};
use std::fs;

fn manifest() -> Manifest {
    let nothing = || Hashed { name: "none".into(), sha256: None };
    Manifest {
        program: "codrive".into(),
        build: "test".into(),
        traffic: "native".into(),
        seed: 1,
        map: nothing(),
        policy: nothing(),
        driver: "nobody".into(),
        participant: None,
        began: "2026-01-01T00:00:00Z".into(),
        machine: "any".into(),
        graphics: None,
        display_m: [1.0, 1.0],
        screen: None,
        ended: None,
        hash: None,
    }
}

fn world() -> World {
    World::new(&Scenario { traffic: "native".into(), ..Scenario::default() }).expect("a world")
}

/// Drives `ticks` and hands them over.
fn drive(world: &mut World, recorder: &mut Recorder, ticks: usize) -> Result<(), RecordError> {
    let controls = Controls { throttle: 0.2, ..Controls::default() };
    for _ in 0..ticks {
        world.tick(&controls).expect("the native engine");
        recorder.tick(world, &controls)?;
    }
    recorder.flush()
}

fn ticks_of(recording: &Path) -> Vec<u64> {
    Reader::parquet(&Table::Ego.parquet(recording)).expect("a table").wholes("tick")
}

#[test]
fn a_journal_cut_at_every_byte_of_its_last_batch_keeps_all_batches_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("whole");
    let mut world = world();
    let mut recorder = Recorder::begin(&whole, world.scenario(), manifest()).expect("begun");
    let stream = whole.join("journal/ego.arrows");
    let mut ends = Vec::new();
    for _ in 0..3 {
        drive(&mut world, &mut recorder, 50).expect("room");
        // The writing thread is done when the file has grown and rests.
        let mut size = 0;
        while size <= ends.last().copied().unwrap_or(0) || fs::metadata(&stream).expect("there").len() != size {
            size = fs::metadata(&stream).expect("there").len();
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        ends.push(size);
    }
    // Ended by an error: the journal stays.
    drop(recorder);
    let bytes = fs::read(&stream).expect("a stream");
    for end in 0..=bytes.len() {
        let kept = 50 * ends.iter().filter(|batch_end| **batch_end <= end as u64).count();
        assert_eq!(recover::whole_rows(&bytes[..end]), kept, "cut at byte {end} of {}", bytes.len());
    }
    // The same through files, with streams that are not there at all.
    let cut = folder.path().join("cut");
    fs::create_dir_all(cut.join("journal")).expect("a folder");
    fs::copy(whole.join("manifest.json"), cut.join("manifest.json")).expect("copied");
    fs::write(cut.join("journal/ego.arrows"), &bytes[..ends[2] as usize - 1]).expect("written");
    let found = recover::recover(&cut).expect("recovered");
    assert_eq!(found.rows[0], (Table::Ego, 100));
    assert!(found.rows[1..].iter().all(|(_, rows)| *rows == 0));
    assert_eq!(ticks_of(&cut), (1..=100).collect::<Vec<u64>>());
}

#[test]
fn a_full_disk_ends_the_recording_with_its_reason_and_keeps_what_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    // The ego's stream has room, that of the cars is on a disk without any.
    let open = |path: &Path| {
        if path.ends_with("cars.arrows") {
            return File::options().write(true).open("/dev/full").map_err(RecordError::file(path));
        }
        journal::new_stream(path)
    };
    let failed = Recorder::begin_with(&recording, world.scenario(), manifest(), open)
        .and_then(|mut recorder| (0..200).try_for_each(|_| drive(&mut world, &mut recorder, 10)));
    let message = failed.expect_err("the disk is full").to_string();
    assert!(message.contains("cars.arrows") && message.contains("make room on the disk"), "{message}");
    let found = recover::recover(&recording).expect("what is there can be read");
    assert_eq!(found.rows.len(), Table::ALL.len());
}

#[test]
fn a_disk_that_hangs_ends_the_recording_instead_of_holding_up_the_drive() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut world = world();
    let mut recorder =
        Recorder::begin(folder.path().join("p1").as_path(), world.scenario(), manifest()).expect("begun");
    // In place of the writing thread one that takes nothing.
    let (queue, batches) = mpsc::sync_channel(QUEUE);
    let (let_go, gate) = mpsc::channel::<()>();
    recorder.queue = Some(queue);
    recorder.writer = Some(std::thread::spawn(move || {
        let _ = gate.recv();
        drop(batches);
        Ok(())
    }));
    let mut handed = 0;
    let failed = (0..10 * QUEUE).find_map(|_| {
        handed += 1;
        drive(&mut world, &mut recorder, 10).err()
    });
    assert_eq!(handed, QUEUE + 1);
    let message = failed.expect("the queue is full").to_string();
    assert!(message.contains("the disk takes nothing any more"), "{message}");
    drop(let_go);
}

#[test]
fn the_recorded_hash_is_that_of_the_summary() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    let mut tally = Tally::new([0.0, f64::INFINITY]);
    let controls = Controls::default();
    for _ in 0..30 {
        world.tick(&controls).expect("the native engine");
        tally.add(world.snapshot(), world.events());
        recorder.tick(&world, &controls).expect("room");
    }
    recorder.event(Tick(30), "mark", "by hand");
    recorder.finish(&tally.summary()).expect("finished");
    let hashes = Reader::parquet(&Table::Ego.parquet(&recording)).expect("a table").wholes("hash");
    assert_eq!(format!("{:016x}", hashes[29]), tally.summary().hash);
    let events = Reader::parquet(&Table::Events.parquet(&recording)).expect("a table");
    assert_eq!((events.words("event"), events.words("detail")), (vec!["mark".to_owned()], vec!["by hand".to_owned()]));
}

#[test]
fn the_force_is_in_the_rows_from_where_it_was_told_and_empty_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    for force in [None, Some(0.75), Some(-1.25), None] {
        recorder.force(force);
        drive(&mut world, &mut recorder, 2).expect("room");
    }
    recorder.finish(&Tally::new([0.0, f64::INFINITY]).summary()).expect("finished");
    let ego = Reader::parquet(&Table::Ego.parquet(&recording)).expect("a table");
    let expected = [None, None, Some(0.75), Some(0.75), Some(-1.25), Some(-1.25), None, None];
    assert_eq!(ego.numbers("wheel_force_nm"), expected);
}
