//! Promises that hold after a run under faults. In: the files and messages that the program left. Out: the first broken promise, as text.
//! No faults are injected during these checks.

use super::{
    live,
    plan::{Fault, Plan},
    program::{Outcome, Workplace, contents},
    scenario::{BATCH, CUTS, FIXTURES, Scenario},
    study_checks,
};
use codrive::{
    record::{Manifest, Table, TableReader, manifest::RecordingState},
    rng,
};
use std::{fs, path::Path};

/// Result of a promise: it holds, or the error says which part is broken.
pub type Held = Result<(), String>;

/// Returns `words` as the error unless `is` holds.
pub fn holds(is: bool, words: impl FnOnce() -> String) -> Held {
    if is { Ok(()) } else { Err(words()) }
}

pub fn check(scenario: Scenario, work: &Workplace, plan: &Plan, outcome: &Outcome, seed: u64) -> Held {
    ended_well(work, plan, outcome)?;
    match scenario {
        Scenario::Drive => drive(work, outcome, seed)?,
        Scenario::Live => live(work, outcome)?,
        Scenario::Recovery => {
            let (.., acknowledged) = CUTS[(seed / 10) as usize % CUTS.len()];
            let is_done =
                outcome.code != Some(0) || hashes(&work.file("p1")).is_ok_and(|now| now.len() as u64 >= acknowledged);
            holds(is_done, || format!("exit code 0, and rows are missing: {}", outcome.text))?;
            recovered(work, scenario, acknowledged)?;
        }
        Scenario::Replay => replay(work, outcome)?,
        Scenario::Study | Scenario::ResumedStudy => study_checks::rehearsal(work, scenario, outcome, seed)?,
        Scenario::Analysis => study_checks::analysis(work, scenario, outcome)?,
        Scenario::Erasure => study_checks::erasure(work, scenario, outcome)?,
        Scenario::Exclusion => study_checks::exclusion(work, scenario, outcome)?,
    }
    // The recording of an earlier run is unchanged.
    same_files(&FIXTURES.folder("whole"), &work.file("p0"))
}

/// Checks that the exit code is a documented one, and that the message names the file and the fault.
fn ended_well(work: &Workplace, plan: &Plan, outcome: &Outcome) -> Held {
    let Outcome { code, signal, text, .. } = outcome;
    holds(!outcome.hung, || format!("it did not end: {text}"))?;
    holds(!text.contains("panicked"), || format!("it panicked: {text}"))?;
    if signal.is_some() {
        let is_ours = outcome.is_killed() && plan.0.iter().any(|fault| fault.is_death());
        return holds(is_ours, || format!("signal {signal:?} ended it: {text}"));
    }
    let is_ordinary = plan.0.iter().all(Fault::is_ordinary);
    holds(!is_ordinary || *code == Some(0), || format!("it broke off without a fault of the disk or the net: {text}"))?;
    holds(matches!(code, Some(0..=2)), || format!("exit code {code:?}: {text}"))?;
    if *code == Some(0) {
        return Ok(());
    }
    let root = work.root();
    let names = [root.to_str().unwrap(), "LSL stream heart"];
    let is_named = names.iter().any(|name| text.contains(name));
    holds(is_named, || format!("exit code {code:?} without a word on a file or a stream: {text:?}"))?;
    let refusals = || plan.0.iter().filter(|fault| fault.is_refusal());
    let is_full = refusals().count() > 0 && refusals().all(|fault| fault.action.starts_with("ENOSPC"));
    // A lack of space on a real disk does not fail the sync or the reading of a folder, so these are exempt.
    let is_written = refusals().all(|fault| fault.kind == "write");
    holds(!(is_full && is_written) || text.contains("make room on the disk"), || format!("no remedy: {text}"))
}

/// Runs the program without faults. Returns its outcome if it exits with this code.
pub fn runs(work: &Workplace, arguments: &[&str], code: i32) -> Result<Outcome, String> {
    let outcome = work.run(arguments);
    let is = outcome.code == Some(code) && !outcome.text.contains("panicked");
    holds(is, || format!("{}: exit code {:?}, not {code}: {}", outcome.command, outcome.code, outcome.text))?;
    Ok(outcome)
}

/// Returns the fingerprint of each tick of a recording.
pub fn hashes(recording: &Path) -> Result<Vec<u64>, String> {
    let table = TableReader::parquet(&Table::Ego.parquet(recording)).map_err(|why| why.to_string())?;
    let ticks = table.wholes("tick");
    holds(ticks.iter().copied().eq(1..=ticks.len() as u64), || "a tick is missing or there twice".into())?;
    Ok(table.wholes("hash"))
}

/// Checks that every file of `before` is in `after`, byte by byte.
pub fn same_files(before: &Path, after: &Path) -> Held {
    for (path, bytes) in contents(before) {
        let now = after.join(path.strip_prefix(before).unwrap());
        holds(fs::read(&now).is_ok_and(|now| now == bytes), || format!("{} is not as it was", now.display()))?;
    }
    Ok(())
}

/// Checks that a recording has this state, every table, and no leftovers from its making.
pub fn is_whole(recording: &Path, state: RecordingState) -> Held {
    let name = recording.display();
    let manifest = Manifest::load(recording).map_err(|why| why.to_string())?;
    holds(manifest.state == state, || format!("{name}: its state is {:?}, not {state:?}", manifest.state))?;
    for table in ["ego", "cars", "advice", "frames", "events"] {
        let file = recording.join(format!("{table}.parquet"));
        TableReader::parquet(&file).map_err(|why| format!("{name} says that it is whole: {why}"))?;
    }
    let left = contents(recording).into_iter().map(|(path, _)| path);
    let left = left.into_iter().find(|path| {
        path.extension().is_some_and(|ending| ending == "new")
            || path.components().any(|part| part.as_os_str() == "journal")
    });
    holds(left.is_none(), || format!("{} is left in a recording that says that it is whole", left.unwrap().display()))
}

fn drive(work: &Workplace, outcome: &Outcome, seed: u64) -> Held {
    let (recording, all) = (work.file("p1"), FIXTURES.hashes());
    let batches = outcome.count("sync", "p1/journal/rows.blocks") as u64;
    let acknowledged = (batches * BATCH).min(all.len() as u64);
    if outcome.code == Some(0) {
        is_whole(&recording, RecordingState::Complete)?;
        holds(hashes(&recording)? == all, || "exit code 0, but rows are missing or differ".into())?;
        proven(work, "@p1")?;
    } else if recording.join("manifest.json").exists() {
        recovered(work, Scenario::Drive, acknowledged)?;
    } else {
        holds(acknowledged == 0, || format!("{acknowledged} ticks were on the disk, and there is no manifest"))?;
        runs(work, Scenario::Drive.arguments(), 0)?;
        holds(hashes(&recording)? == all, || "the same command drove otherwise".into())?;
    }
    if seed.is_multiple_of(3) {
        flipped(work, &recording, seed)?;
    }
    Ok(())
}

/// Checks a drive in real time. There is no reference drive for it, so the replay proves it.
fn live(work: &Workplace, outcome: &Outcome) -> Held {
    let recording = work.file("p1");
    // Each batch on the disk has a tick, except those that only report devices while the drive is paused: at its start, and until the wheel
    // is back.
    let acknowledged = (outcome.count("sync", "p1/journal/rows.blocks") as u64).saturating_sub(8);
    if outcome.code == Some(0) {
        is_whole(&recording, RecordingState::Complete)?;
        live::is_whole(&recording)?;
        return proven(work, "@p1");
    }
    if recording.join("manifest.json").exists() {
        return recovered(work, Scenario::Live, acknowledged);
    }
    holds(acknowledged == 0, || "rows were on the disk, and there is no manifest".into())
}

/// Checks that the replay of a recording succeeds and every file agrees with its checksum.
fn proven(work: &Workplace, name: &str) -> Held {
    let printed = runs(work, &["replay", name], 0)?.text;
    holds(printed.contains("every file agrees with its checksum"), || format!("not proven: {printed}"))
}

/// Checks that `recover` completes an interrupted recording, and that a second `recover` changes nothing.
fn recovered(work: &Workplace, scenario: Scenario, acknowledged: u64) -> Held {
    let recording = work.file("p1");
    let printed = runs(work, &["recover", "@p1"], 0)?.text;
    let found = hashes(&recording)?;
    let ticks = found.len() as u64;
    holds(ticks >= acknowledged, || format!("{ticks} ticks of {acknowledged} that the disk had: {printed}"))?;
    holds(scenario == Scenario::Live || FIXTURES.hashes().starts_with(&found), || {
        format!("recovered rows are not those that were driven: {printed}")
    })?;
    let state = Manifest::load(&recording).map_err(|why| why.to_string())?.state;
    is_whole(&recording, state).or_else(|why| {
        // Unreadable data is kept in `lost+found`.
        let is_kept = why.contains("lost+found");
        if is_kept { Ok(()) } else { Err(why) }
    })?;
    let before = contents(&recording);
    let again = runs(work, &["recover", "@p1"], 0)?.text;
    holds(again.contains("is whole") && contents(&recording) == before, || format!("recovered twice: {again}"))?;
    if ticks > 0 { proven(work, "@p1") } else { Ok(()) }
}

/// Checks that a replay changes no file, and that it does not call a sound recording altered.
fn replay(work: &Workplace, outcome: &Outcome) -> Held {
    same_files(&FIXTURES.folder("whole"), &work.file("p1"))?;
    let is_accused = outcome.text.contains("differs from the recording");
    holds(!is_accused, || format!("a sound recording is said to be altered: {}", outcome.text))?;
    let is_reported_proven = outcome.text.contains("every file agrees with its checksum");
    let is_proven = outcome.code == Some(0);
    holds(!is_proven || is_reported_proven, || format!("a sound recording is proven by half: {}", outcome.text))?;
    holds(!(is_proven && outcome.was_refused()), || {
        format!("proven, but something could not be read: {}", outcome.text)
    })?;
    proven(work, "@p1")
}

/// Checks that a flipped bit in any file of a recording is found.
fn flipped(work: &Workplace, recording: &Path, seed: u64) -> Held {
    let mut random = rng::stream(seed, "flip");
    let files = [
        "ego.parquet",
        "cars.parquet",
        "advice.parquet",
        "events.parquet",
        "manifest.json",
        "checksums.json",
        "scenario.toml",
    ];
    let path = recording.join(files[random.index(files.len())]);
    let Ok(mut bytes) = fs::read(&path) else { return Ok(()) };
    let at = random.index(bytes.len());
    bytes[at] ^= 1 << random.index(8);
    fs::write(&path, bytes).unwrap();
    let printed = work.run(&["replay", "@p1"]);
    let is_found = matches!(printed.code, Some(1 | 2)) && !printed.text.contains("panicked");
    holds(is_found, || format!("byte {at} of {} is another one: {:?} {}", path.display(), printed.code, printed.text))
}
