//! Tests of recordings after a cut, on a full disk and on a disk that hangs.

use super::*;
use crate::{record::TableReader, sim::SummaryAccumulator, traffic::EngineChoice};
use std::{
    collections::BTreeMap,
    fs::{self, File},
};

fn manifest() -> Manifest {
    Manifest { program: "codrive".into(), seed: 1, ..Manifest::default() }
}

fn world() -> World {
    World::new(&Scenario { traffic: EngineChoice::Native, ..Scenario::default() }).expect("a world")
}

/// Drives `ticks` and passes their rows to the writing thread.
fn drive(world: &mut World, recorder: &mut Recorder, ticks: usize) -> Result<(), RecordError> {
    let controls = Controls { throttle: 0.2, ..Controls::default() };
    for _ in 0..ticks {
        world.tick(&controls).expect("the native engine");
        recorder.tick(world, &controls)?;
    }
    recorder.flush()
}

fn ticks_of(recording: &Path) -> Vec<u64> {
    TableReader::parquet(&Table::Ego.parquet(recording)).expect("a table").wholes("tick")
}

/// Makes a recording that was cut after three batches of 50 ticks. Returns its folder and the end of each batch in the journal.
fn cut_drive(folder: &Path) -> (PathBuf, Vec<usize>) {
    let recording = folder.join("whole");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    let stream = journal_of(&recording);
    let mut ends = Vec::new();
    for batch in 0..3 {
        drive(&mut world, &mut recorder, 50).expect("room");
        // The writing thread reports when a batch is on the disk.
        while recorder.writer_status().waiting()[0] > 0 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        ends.push(fs::metadata(&stream).expect("there").len() as usize);
        assert_eq!(ends.len(), batch + 1);
    }
    // The drive ends by an error, so the journal stays.
    drop(recorder);
    (recording, ends)
}

fn journal_of(recording: &Path) -> PathBuf {
    recording.join("journal/rows.blocks")
}

/// Makes a recording with the manifest of another and these bytes as its journal.
fn with_journal(of: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let recording = of.with_file_name(name);
    fs::create_dir_all(recording.join("journal")).expect("a folder");
    for file in ["manifest.json", "scenario.toml"] {
        fs::copy(of.join(file), recording.join(file)).expect("copied");
    }
    fs::write(journal_of(&recording), bytes).expect("written");
    recording
}

#[test]
fn a_journal_cut_at_any_byte_keeps_all_batches_before_the_cut() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, ends) = cut_drive(folder.path());
    let bytes = fs::read(journal_of(&whole)).expect("a journal");
    assert_eq!(*ends.last().expect("three"), bytes.len());
    // `block` tests cuts at every byte; here the borders and some bytes between.
    let cuts = ends.iter().flat_map(|end| [end - 1, *end, end + 1]).chain([0, 1, 60, ends[0] / 2, ends[1] + 2000]);
    for end in cuts.filter(|end| *end <= bytes.len()) {
        let cut = with_journal(&whole, &format!("cut-{end}"), &bytes[..end]);
        let half_written = cut.join("scenario").with_extension(crate::record::BESIDE);
        fs::write(&half_written, "half").expect("written");
        let found = recover::recover(&cut).expect("recovered");
        assert!(!half_written.exists(), "a file that the cut left beside its place is removed");
        let batches = ends.iter().filter(|batch_end| **batch_end <= end).count() as u64;
        assert_eq!(found.rows[0], (Table::Ego, 50 * batches), "cut at {end} of {}", bytes.len());
        assert_eq!(ticks_of(&cut), (1..=50 * batches).collect::<Vec<u64>>());
        let is_between = end > 0 && !ends.contains(&end);
        assert_eq!((found.kept.is_some(), found.missing.len()), (is_between, usize::from(is_between)), "{end}");
        let kept = cut.join("lost+found/journal/rows.blocks");
        assert_eq!(kept.exists(), found.kept.is_some());
        if kept.exists() {
            assert_eq!(fs::read(kept).expect("kept"), &bytes[..end]);
        }
        assert!(!cut.join("journal").exists());
        // A second recovery changes nothing.
        let again = recover::recover(&cut).expect("whole");
        assert!(again.was_whole && again.rows == found.rows);
    }
}

/// Returns the start of each block of a journal, and the end of the journal.
fn blocks(bytes: &[u8]) -> Vec<usize> {
    let magic = &bytes[..8];
    let begins = bytes.windows(8).enumerate().filter(|(_, window)| *window == magic).map(|(at, _)| at);
    begins.chain([bytes.len()]).collect()
}

#[test]
fn a_removed_block_is_reported_also_after_a_damaged_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, _) = cut_drive(folder.path());
    let bytes = fs::read(journal_of(&whole)).expect("a journal");
    let at = blocks(&bytes);
    assert!(at.len() > 6, "two blocks or more of each batch");
    let mut less = bytes.clone();
    // The last byte of the first block is flipped; the fourth block is removed.
    less[at[1] - 1] ^= 1;
    less.drain(at[3]..at[4]);
    let found = recover::recover(&with_journal(&whole, "less", &less)).expect("recovered");
    let places: Vec<[u64; 2]> = found.missing.iter().map(|hole| hole.bytes).collect();
    assert_eq!(places, [[0, at[1] as u64], [at[3] as u64, at[3] as u64]]);
}

#[test]
fn a_journal_is_dropped_only_where_every_table_has_what_it_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, _) = cut_drive(folder.path());
    let bytes = fs::read(journal_of(&whole)).expect("a journal");
    let recovered = with_journal(&whole, "recovered", &bytes);
    let found = recover::recover(&recovered).expect("recovered");
    let ego = found.ticks.iter().find(|(table, _)| *table == Table::Ego).map(|(_, ticks)| *ticks);
    assert_eq!((found.rows[0], ego), ((Table::Ego, 150), Some([Tick(1), Tick(150)])));
    // Cut before the journal was removed: all rows are in the tables.
    let put_back = || {
        fs::create_dir_all(recovered.join("journal")).expect("a folder");
        fs::write(journal_of(&recovered), &bytes).expect("written");
    };
    put_back();
    assert!(recover::recover(&recovered).expect("whole").was_whole && !recovered.join("journal").exists());
    // Complete by its manifest, but a table is missing: its rows are written again from the journal.
    put_back();
    fs::remove_file(Table::Ego.parquet(&recovered)).expect("there");
    assert!(!recover::recover(&recovered).expect("recovered").was_whole);
    assert_eq!(ticks_of(&recovered), (1..=150).collect::<Vec<u64>>());
    // Cut before there was a journal: nothing is missing.
    let before = with_journal(&whole, "before", &[]);
    fs::remove_dir_all(before.join("journal")).expect("there");
    let found = recover::recover(&before).expect("recovered");
    assert_eq!((found.rows[0], found.missing.len(), found.kept), ((Table::Ego, 0), 0, None));
}

#[test]
fn a_waiting_flush_reaches_the_journal() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    world.tick(&Controls::default()).expect("the native engine");
    recorder.tick(&world, &Controls::default()).expect("room");
    recorder.flush_waiting().expect("room");
    while recorder.writer_status().waiting()[0] > 0 {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(fs::metadata(journal_of(&recording)).expect("there").len() > 0);
}

#[test]
fn a_flipped_byte_loses_the_rows_of_its_block_and_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, ends) = cut_drive(folder.path());
    let bytes = fs::read(journal_of(&whole)).expect("a journal");
    // The last batch may never have reached the disk; the next test covers it.
    for at in (0..ends[1]).step_by(ends[2] / 60) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 0x10;
        let damaged = with_journal(&whole, &format!("flip-{at}"), &flipped);
        let found = recover::recover(&damaged).expect("recovered");
        let [hole] = &found.missing[..] else { panic!("byte {at}: {:?}", found.missing) };
        assert!(hole.bytes[0] <= at as u64 && (at as u64) < hole.bytes[1], "byte {at}: {hole}");
        // Each batch has at least a block of the vehicles and one of the ego: 5 steps of 22 vehicles, and 50 ticks.
        let rows: BTreeMap<&str, u64> = found.rows.iter().map(|(table, rows)| (table.name(), *rows)).collect();
        let lost = [150 - rows["ego"], 3 * 5 * 22 - rows["cars"]];
        assert!(matches!(lost, [50, 0] | [0, 110] | [0, 0]), "byte {at}: {lost:?}");
        if let Some(table) = hole.table {
            let batch = ends.iter().take_while(|end| **end <= at).count() as u64;
            let refusal = hole.to_string();
            assert!(refusal.contains(&format!(" rows of {} (", table.name())), "{refusal}");
            if table == Table::Ego {
                assert_eq!(hole.ticks, Some([Tick(50 * batch + 1), Tick(50 * batch + 50)]), "{refusal}");
            }
        }
        assert!(found.kept.is_some_and(|kept| kept.starts_with(damaged.join("lost+found"))));
    }
}

#[test]
fn the_last_batch_ends_at_its_first_missing_block() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, ends) = cut_drive(folder.path());
    let bytes = fs::read(journal_of(&whole)).expect("a journal");
    let of_last: Vec<usize> = blocks(&bytes).into_iter().filter(|at| *at >= ends[1]).collect();
    let count = of_last.len() - 1;
    assert!(count >= 3, "cars, what happened in a network or not, and the ego: {count}");
    let rows_in = |name: &str, bytes: &[u8]| {
        let recording = with_journal(&whole, name, bytes);
        let found = recover::recover(&recording).expect("recovered");
        let total = found.rows.iter().map(|(_, rows)| rows).sum::<u64>();
        assert_eq!(ticks_of(&recording).len() as u64, found.rows[0].1);
        (total, found.missing.len())
    };
    for block in 0..count {
        let [begin, end] = [of_last[block], of_last[block + 1]];
        let (expected, _) = rows_in(&format!("until-{block}"), &bytes[..begin]);
        // A damaged payload, a sector of zeroes, and a removed block.
        let (mut payload, mut zeroes, mut gone) = (bytes.clone(), bytes.clone(), bytes.clone());
        payload[end - 1] ^= 1;
        zeroes[begin..end].fill(0);
        gone.drain(begin..end);
        for (kind, bytes, least) in
            [("payload", payload, count - block), ("zeroes", zeroes, count - block), ("gone", gone, count - block - 1)]
        {
            let (rows, missing) = rows_in(&format!("{kind}-{block}"), &bytes);
            assert_eq!(rows, expected, "{kind} {block}: rows behind the hole");
            assert!(missing >= least, "{kind} {block}: each block that is left out is told");
        }
    }
}

#[test]
fn a_recording_in_progress_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    drive(&mut world, &mut recorder, 50).expect("room");
    let refused = |error: RecordError| {
        let text = error.to_string();
        assert!(matches!(error, RecordError::Running(_)) && text.contains("still running"), "{text}");
    };
    refused(recover::recover(&recording).expect_err("it runs"));
    refused(recover::open(&recording).expect_err("it runs"));
    refused(Recorder::begin(&recording, world.scenario(), manifest()).expect_err("it runs"));
    drive(&mut world, &mut recorder, 50).expect("room");
    recorder.finish(&SummaryAccumulator::new([0.0, f64::INFINITY]).to_summary()).expect("finished");
    assert!(recover::open(&recording).is_ok_and(|manifest| manifest.is_complete()));
    assert_eq!(ticks_of(&recording).len(), 100);
}

#[test]
fn recovery_never_replaces_a_table_by_one_with_fewer_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    drive(&mut world, &mut recorder, 50).expect("room");
    recorder.finish(&SummaryAccumulator::new([0.0, f64::INFINITY]).to_summary()).expect("finished");
    // Killed while it removed the journal: its file is still there, or gone.
    for left in [&["rows.blocks"][..], &[]] {
        fs::create_dir(recording.join("journal")).expect("a folder");
        left.iter().for_each(|name| fs::write(recording.join("journal").join(name), "").expect("written"));
        let found = recover::recover(&recording).expect("whole");
        assert!(found.was_whole && found.rows[0] == (Table::Ego, 50), "{found:?}");
        assert!(!recording.join("journal").exists());
    }
    // The same if the manifest does not say that the tables are whole.
    let mut manifest = Manifest::load(&recording).expect("there");
    (manifest.state, manifest.ended) = (RecordingState::Running, None);
    manifest.save(&recording).expect("saved");
    fs::create_dir(recording.join("journal")).expect("a folder");
    let found = recover::recover(&recording).expect("recovered");
    assert_eq!(found.rows[0], (Table::Ego, 50));
    assert_eq!(ticks_of(&recording).len(), 50);
}

#[test]
fn foreign_files_in_the_journals_folder_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let (whole, _) = cut_drive(folder.path());
    let bytes = fs::read(journal_of(&whole)).expect("a journal");
    let other = with_journal(&whole, "other", &bytes);
    fs::write(other.join("journal/notes.txt"), "of value").expect("written");
    let found = recover::recover(&other).expect("recovered");
    assert_eq!(found.rows[0], (Table::Ego, 150));
    assert_eq!(fs::read_to_string(other.join("lost+found/journal/notes.txt")).expect("kept"), "of value");
    // Opening a pipe would wait forever; a folder is no journal.
    for make in [
        |path: &Path| fs::create_dir(path),
        |path: &Path| nix::unistd::mkfifo(path, nix::sys::stat::Mode::S_IRUSR).map_err(Into::into),
    ] {
        let none = with_journal(&whole, "none", b"");
        fs::remove_file(journal_of(&none)).expect("removed");
        make(&journal_of(&none)).expect("made");
        let error = recover::recover(&none).expect_err("no file").to_string();
        assert!(error.contains("rows.blocks: it is a "), "{error}");
        assert!(journal_of(&none).exists());
        fs::remove_dir_all(&none).expect("removed");
    }
}

/// Disk that notes the calls made to it.
#[derive(Clone, Default)]
struct NotedDisk(Arc<std::sync::Mutex<Vec<&'static str>>>);

impl std::io::Write for NotedDisk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().expect("held by nobody who panicked").push("write");
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl DurableFile for NotedDisk {
    fn sync(&mut self) -> std::io::Result<()> {
        self.0.lock().expect("held by nobody who panicked").push("sync");
        Ok(())
    }
}

#[test]
fn a_batch_is_reported_done_after_one_write_and_one_sync() {
    let disk = NotedDisk::default();
    let (queue, batches) = mpsc::sync_channel(QUEUE);
    for first in [1, 51, 101] {
        let frames = (first..first + 50).map(|tick| FrameRow { tick: Tick(tick), ..FrameRow::default() }).collect();
        queue.send(RowBatch { frames, ..RowBatch::default() }).expect("room");
    }
    // An empty batch needs neither write nor sync.
    queue.send(RowBatch::default()).expect("room");
    drop(queue);
    let shared = disk.clone();
    let done = || shared.0.lock().expect("held by nobody who panicked").push("done");
    Journal::over("rows.blocks".into(), disk.clone()).write(&batches, done).expect("room");
    let noted = disk.0.lock().expect("held by nobody who panicked").join(" ");
    assert_eq!(noted, "write sync done write sync done write sync done done");
}

#[test]
fn a_full_disk_ends_the_recording_with_its_reason_and_keeps_what_is_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let open = |folder: &Path| {
        let path = folder.join("rows.blocks");
        let file = File::options().write(true).open("/dev/full").map_err(RecordError::file(&path))?;
        Ok(Journal::over(path, file))
    };
    let failed = Recorder::begin_with(&recording, world.scenario(), manifest(), open)
        .and_then(|mut recorder| (0..200).try_for_each(|_| drive(&mut world, &mut recorder, 10)));
    let message = failed.expect_err("the disk is full").to_string();
    assert!(message.contains("rows.blocks") && message.contains("make room on the disk"), "{message}");
    let ended = || Manifest::load(&recording).expect("a manifest").ended;
    let reason = Some("recording failed: No space left on device (os error 28)".to_owned());
    assert_eq!(ended(), reason);
    let found = recover::recover(&recording).expect("what is there can be read");
    assert_eq!(found.rows.len(), Table::OF_EVERY_DRIVE.len());
    assert_eq!(ended(), reason, "recovery keeps the reason");
}

#[test]
fn a_disk_that_hangs_ends_the_recording_instead_of_holding_up_the_drive() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut world = world();
    let mut recorder =
        Recorder::begin(folder.path().join("p1").as_path(), world.scenario(), manifest()).expect("begun");
    // A thread that takes no batch, in place of the writing thread.
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
    assert!(message.contains("the disk writer stalled"), "{message}");
    drop(let_go);
}

#[test]
fn the_recorded_hash_equals_the_hash_of_the_summary() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    let controls = Controls::default();
    for _ in 0..30 {
        world.tick(&controls).expect("the native engine");
        summary.add(world.snapshot(), world.events());
        recorder.tick(&world, &controls).expect("room");
    }
    recorder.event(Tick(30), "mark", "by hand");
    recorder.finish(&summary.to_summary()).expect("finished");
    let hashes = TableReader::parquet(&Table::Ego.parquet(&recording)).expect("a table").wholes("hash");
    assert_eq!(format!("{:016x}", hashes[29]), summary.to_summary().hash);
    let events = TableReader::parquet(&Table::Events.parquet(&recording)).expect("a table");
    assert_eq!((events.words("event"), events.words("detail")), (vec!["mark".to_owned()], vec!["by hand".to_owned()]));
}

#[test]
fn the_force_is_in_the_rows_from_the_tick_at_which_it_was_set() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("p1");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    for force in [None, Some(0.75), Some(-1.25), None] {
        recorder.force(force);
        drive(&mut world, &mut recorder, 2).expect("room");
    }
    recorder.finish(&SummaryAccumulator::new([0.0, f64::INFINITY]).to_summary()).expect("finished");
    let ego = TableReader::parquet(&Table::Ego.parquet(&recording)).expect("a table");
    let expected = [None, None, Some(0.75), Some(0.75), Some(-1.25), Some(-1.25), None, None];
    assert_eq!(ego.numbers("wheel_force_nm"), expected);
}

#[test]
fn a_drive_that_ends_by_an_error_keeps_its_gathered_ticks() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("ended");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    for _ in 0..7 {
        world.tick(&Controls::default()).expect("the native engine");
        recorder.tick(&world, &Controls::default()).expect("room");
    }
    drop(recorder);
    let found = recover::recover(&recording).expect("recovered");
    assert_eq!((found.rows[0], found.missing.len()), ((Table::Ego, 7), 0));
}

#[test]
fn the_free_space_agrees_with_df() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("gauged");
    let mut world = world();
    let mut recorder = Recorder::begin(&recording, world.scenario(), manifest()).expect("begun");
    drive(&mut world, &mut recorder, 5).expect("room");
    while recorder.writer_status().waiting()[0] > 0 {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let df = std::process::Command::new("df").args(["--output=avail", "-B1"]).arg(folder.path()).output().expect("df");
    let refusal = String::from_utf8_lossy(&df.stdout);
    let free: u64 = refusal.lines().last().and_then(|line| line.trim().parse().ok()).expect("a number of bytes");
    let gauged = recorder.writer_status().free_bytes().expect("this system tells");
    // Other programs write meanwhile: within a tenth.
    assert!(gauged.abs_diff(free) < free / 10, "{gauged} and {free}");
    assert_eq!(recorder.writer_status().waiting(), [0, QUEUE]);
}
