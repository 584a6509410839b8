//! Promises of a study's data set after a run under faults. In: the files that the program left. Out: the first broken promise, as text.

use super::{
    checks::{Held, holds, is_whole, runs, same_files},
    program::{Outcome, Workplace, contents},
    scenario::{FIXTURES, Scenario},
};
use codrive::record::manifest::RecordingState;
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

const PEOPLE: [&str; 2] = ["sub-R01", "sub-R02"];

/// Returns a participant's log; `None` if there is none yet.
fn session(data: &Path, subject: &str) -> Result<Option<Value>, String> {
    let path = data.join("sourcedata").join(subject).join("session.json");
    let Ok(text) = fs::read_to_string(&path) else { return Ok(None) };
    serde_json::from_str(&text).map(Some).map_err(|why| format!("{}: {why}", path.display()))
}

fn item_runs(log: Option<&Value>) -> Vec<Value> {
    log.map_or(Vec::new(), |log| log["item_runs"].as_array().cloned().expect("its runs of items"))
}

/// Completed items of a participant, with their files.
struct Settled {
    subject: &'static str,
    item_runs: Vec<Value>,
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Settled {
    fn of(data: &Path, subject: &'static str) -> Result<Self, String> {
        let item_runs = item_runs(session(data, subject)?.as_ref());
        let folder = data.join("sourcedata").join(subject);
        let files = item_runs.iter().filter_map(|item_run| item_run["recording"].as_str());
        let files = files.flat_map(|recording| contents(&folder.join(recording))).collect();
        Ok(Self { subject, item_runs, files })
    }

    /// Checks that the items and their files are unchanged.
    fn is_kept(&self, data: &Path) -> Held {
        let now = item_runs(session(data, self.subject)?.as_ref());
        holds(now.starts_with(&self.item_runs), || format!("{}: what was done is not in its log", self.subject))?;
        for (path, bytes) in &self.files {
            holds(fs::read(path).is_ok_and(|now| now == *bytes), || format!("{} is not as it was", path.display()))?;
        }
        Ok(())
    }
}

/// Returns the number of saves of a participant's log that reached the disk; one counts when its folder was synced after the rename.
fn saves(outcome: &Outcome, subject: &str) -> usize {
    let folder = format!("sourcedata/{subject}");
    let log = format!("{folder}/session.json");
    let (mut saves, mut is_renamed) = (0, false);
    for call in outcome.trace.iter().filter(|call| call.result == "ok") {
        if call.kind == "rename" && call.name.ends_with(&log) {
            is_renamed = true;
        } else if call.kind == "sync" && call.name.ends_with(&folder) && is_renamed {
            (saves, is_renamed) = (saves + 1, false);
        }
    }
    saves
}

/// Number of completed items after each save of a log: it is opened, gets its traits, each of three items begins and ends, it is closed.
const DONE: [usize; 10] = [0, 0, 0, 0, 1, 1, 2, 2, 3, 3];

pub fn rehearsal(work: &Workplace, scenario: Scenario, outcome: &Outcome, seed: u64) -> Held {
    let data = work.file("data");
    for subject in PEOPLE.into_iter().filter(|_| scenario == Scenario::Study) {
        let (log, saves) = (session(&data, subject)?, saves(outcome, subject));
        let done = item_runs(log.as_ref()).len();
        let is_kept = saves == 0 || (log.is_some() && done >= DONE[saves.min(9)]);
        holds(is_kept, || format!("{subject}: the log has {done} items after {saves} saves that the disk had"))?;
    }
    let settled: Vec<Settled> =
        PEOPLE.into_iter().map(|subject| Settled::of(&data, subject)).collect::<Result<_, _>>()?;
    if outcome.code == Some(0) {
        is_complete(work, &data)?;
    }
    let printed = runs(work, scenario.arguments(), 0)?.text;
    holds(printed.contains("2 of 2 participants completed"), || format!("the same command does not go on: {printed}"))?;
    settled.iter().try_for_each(|settled| settled.is_kept(&data))?;
    is_complete(work, &data)?;
    if seed.is_multiple_of(4) {
        runs(work, &["analyse", "@data"], 0)?;
    }
    Ok(())
}

/// Checks that all participants are done, every recording is complete, and the list of files is right.
fn is_complete(work: &Workplace, data: &Path) -> Held {
    for subject in PEOPLE {
        let log = session(data, subject)?.ok_or_else(|| format!("{subject} has no log"))?;
        holds(log["end"]["complete"] == true, || format!("{subject} is not through: {}", log["end"]))?;
        let folder = data.join("sourcedata").join(subject);
        let done: Vec<Value> =
            item_runs(Some(&log)).into_iter().filter(|item_run| item_run["outcome"] == "done").collect();
        holds(done.len() == 3, || format!("{subject}: {} of 3 items are done", done.len()))?;
        for recording in done.iter().filter_map(|item_run| item_run["recording"].as_str()) {
            is_whole(&folder.join(recording), RecordingState::Complete)?;
            is_whole(&folder.join(format!("{recording}-baseline")), RecordingState::Complete)?;
        }
    }
    let recording = done_drive(data)?;
    let name = recording.strip_prefix(work.root()).unwrap().to_str().unwrap().to_owned();
    runs(work, &["replay", &format!("@{name}")], 0)?;
    sums_are_right(data)
}

/// Returns the recording of a completed trial.
fn done_drive(data: &Path) -> Result<PathBuf, String> {
    let log = session(data, "sub-R02")?;
    let done = item_runs(log.as_ref());
    let done = done.iter().rev().find(|item_run| item_run["outcome"] == "done" && item_run["recording"].is_string());
    let done = done.and_then(|item_run| item_run["recording"].as_str()).ok_or("no drive of sub-R02 is done")?;
    Ok(data.join("sourcedata/sub-R02").join(done))
}

/// Checks the list of files with `sha256sum`, and that the list names the existing files.
fn sums_are_right(data: &Path) -> Held {
    let checked =
        Command::new("sha256sum").args(["--check", "--quiet", "SHA256SUMS"]).current_dir(data).output().unwrap();
    holds(checked.status.success(), || format!("SHA256SUMS: {}", String::from_utf8_lossy(&checked.stdout)))?;
    let list = fs::read_to_string(data.join("SHA256SUMS")).map_err(|why| why.to_string())?;
    for name in ["participants.tsv", "sourcedata/sub-R02/session.json", "sub-R02/sub-R02_scans.tsv"] {
        holds(list.contains(&format!("  {name}\n")), || format!("SHA256SUMS does not list {name}"))?;
    }
    let table = fs::read_to_string(data.join("participants.tsv")).map_err(|why| why.to_string())?;
    let listed = list.lines().filter(|line| line.ends_with("/session.json")).count();
    holds(table.lines().count() == 1 + listed, || format!("{listed} sessions, and participants.tsv:\n{table}"))?;
    let left =
        contents(data).into_iter().map(|(path, _)| path).find(|path| path.extension().is_some_and(|e| e == "new"));
    holds(left.is_none(), || format!("{} is left behind", left.unwrap().display()))
}

/// Checks that an analysis changes no data and can be repeated.
pub fn analysis(work: &Workplace, scenario: Scenario, outcome: &Outcome) -> Held {
    let data = work.file("data");
    same_files(&FIXTURES.folder("study"), &data)?;
    let report = |data: &Path| contents(&data.join("derivatives"));
    let under_faults = (outcome.code == Some(0)).then(|| report(&data));
    runs(work, scenario.arguments(), 0)?;
    let now = report(&data);
    holds(!now.is_empty(), || "there is no report".into())?;
    let is_same = under_faults.is_none_or(|before| {
        let names = |files: &[(PathBuf, Vec<u8>)]| files.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>();
        names(&before) == names(&now)
    });
    holds(is_same, || format!("exit code 0, but the report is another one: {}", outcome.text))
}

pub fn erasure(work: &Workplace, scenario: Scenario, outcome: &Outcome) -> Held {
    let data = work.file("data");
    if outcome.code != Some(0) {
        // The erasure was complete, or is completed by the repeated command.
        let again = work.run(scenario.arguments());
        let is = matches!(again.code, Some(0)) || again.text.contains("was erased");
        holds(is, || format!("it cannot be erased: {:?} {}", again.code, again.text))?;
    }
    let left = contents(&data).into_iter().map(|(path, _)| path).find(|path| path.to_string_lossy().contains("R01"));
    holds(left.is_none(), || format!("{} is left of who was erased", left.unwrap().display()))?;
    let table = fs::read_to_string(data.join("participants.tsv")).map_err(|why| why.to_string())?;
    holds(!table.contains("R01"), || format!("participants.tsv has a row of who was erased:\n{table}"))?;
    let ledger = fs::read_to_string(data.join("erased.tsv")).map_err(|why| why.to_string())?;
    holds(ledger.contains("sub-R01\tasked for\t"), || format!("erased.tsv: {ledger}"))?;
    let other = "sourcedata/sub-R02";
    same_files(&FIXTURES.folder("study").join(other), &data.join(other))?;
    sums_are_right(&data)
}

pub fn exclusion(work: &Workplace, scenario: Scenario, outcome: &Outcome) -> Held {
    let data = work.file("data");
    if outcome.code != Some(0) {
        let again = work.run(scenario.arguments());
        let is = again.code == Some(0) || again.text.contains("excluded");
        holds(is, || format!("it cannot be excluded: {:?} {}", again.code, again.text))?;
    }
    let log = session(&data, "sub-R01")?.ok_or("sub-R01 has no log")?;
    holds(log["end"]["excluded"] == "slept", || format!("sub-R01 is not excluded: {}", log["end"]))?;
    let table = fs::read_to_string(data.join("participants.tsv")).map_err(|why| why.to_string())?;
    let row = table.lines().find(|line| line.starts_with("sub-R01")).unwrap_or_default();
    holds(row.contains("excluded"), || format!("participants.tsv does not say so: {row}"))?;
    for name in fs::read_dir(FIXTURES.folder("study").join("sourcedata/sub-R01")).unwrap().flatten() {
        if name.file_type().unwrap().is_dir() {
            let within = Path::new("sourcedata/sub-R01").join(name.file_name());
            same_files(&FIXTURES.folder("study").join(&within), &data.join(&within))?;
        }
    }
    sums_are_right(&data)
}
