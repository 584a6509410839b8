//! Whole commands under faults from outside: the n-th write, sync, rename, read or connection fails, is short or slow, the
//! process dies, the power is cut, the clock jumps, a wheel and a stream of Lab Streaming Layer go and come back. In: a seed,
//! which draws all of it. Out: every promise that was broken, with the seed, the smallest plan that breaks it, and the command
//! lines.
//!
//! 30 seeds in a usual run; `scripts/faults SEEDS [FIRST]` for a night. The plan says which call of a kind fails; threads of
//! the program may still reach it in another order, so that a rare fault may need its seed more than once.

mod checks;
mod draw;
mod live;
mod plan;
mod program;
mod scenario;
mod shrink;
mod study_checks;

use scenario::Scenario;
use std::{
    fs,
    io::Write,
    path::PathBuf,
    sync::{
        Mutex,
        atomic::{AtomicU64, Ordering},
    },
    thread,
};

/// Seeds of a usual run.
const SEEDS: u64 = 30;

/// Number of the environment, or this one.
fn number(name: &str, otherwise: u64) -> u64 {
    let Ok(text) = std::env::var(name) else { return otherwise };
    text.parse().unwrap_or_else(|_| panic!("{name} is {text:?}; allowed: a whole number"))
}

/// Runs one seed. The words of a reader if it breaks a promise.
fn seed(seed: u64) -> Option<String> {
    let (scenario, visit) = Scenario::of(seed);
    let plan = scenario.census().draw(seed, visit);
    let broken = scenario.check(&plan, seed).err()?;
    Some(shrink::report(scenario, seed, &plan, broken))
}

/// Plans that have broken a promise, each of its own kind; a seed where the command has variants.
const BROKEN_ONCE: [(Scenario, &str, u64); 13] = [
    // The log said that a participant is excluded, the tables never did: the same command was refused.
    (Scenario::Exclusion, "open _scans.new 1 EIO", 0),
    (Scenario::Exclusion, "sync ssq_before.new 1 kill-after", 0),
    // Folders whose own names were not synced: a participant's whole session was gone after a power cut.
    (Scenario::Study, "write _channels.new 1 power", 0),
    (Scenario::Study, "write session.new 2 power-after", 0),
    // Half a baseline stayed in the data set, and was listed with its files.
    (Scenario::Study, "open checksums.new 2 kill-after", 0),
    (Scenario::ResumedStudy, "rename cars.parquet 1 EROFS", 0),
    // A folder with half a manifest stayed.
    (Scenario::Study, "sync manifest.new 1 kill-after", 0),
    // A disk that is full while tables are written is a full disk, and not a table that is no table.
    (Scenario::Drive, "write ego.new 2 ENOSPC", 0),
    // A lock that cannot be looked at is no free one.
    (Scenario::Replay, "stat lock 1 ESTALE", 0),
    // A table that cannot be read now is not replaced by one from a journal that is gone.
    (Scenario::Recovery, "read ego.parquet 1 EIO+", 30),
    (Scenario::Recovery, "open ego.parquet 1 EIO+", 30),
    // A signal amid a read is no fault of the file.
    (Scenario::ResumedStudy, "read _beh.json 1 EINTR", 0),
    // A stream that could not be recorded was told to the experimenter and to no reader of the recording.
    (Scenario::Live, "write heart.blocks 1 EDQUOT", 16),
];

/// Threads that run programs.
fn threads() -> u64 {
    number("CODRIVE_FAULTS_THREADS", thread::available_parallelism().map_or(1, |n| n.get() as u64))
}

/// Checks these, several at a time. Words on each that broke a promise.
fn broken(count: u64, check: impl Fn(u64) -> Option<String> + Sync) -> Vec<String> {
    let (next, found) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    let work = || {
        loop {
            let this = next.fetch_add(1, Ordering::Relaxed);
            if this >= count {
                return;
            }
            if let Some(words) = check(this) {
                eprintln!("{words}");
                found.lock().unwrap().push(words);
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads() {
            scope.spawn(work);
        }
    });
    found.into_inner().unwrap()
}

/// Words on a plan that breaks a promise.
fn breaks(scenario: Scenario, plan: &str, seed: u64) -> Option<String> {
    let plan = plan.parse().unwrap();
    let broken = scenario.check(&plan, seed).err()?;
    Some(shrink::report(scenario, seed, &plan, broken))
}

/// None of these plans breaks a promise.
fn hold(scenario: Scenario, plans: &[String]) {
    let found = broken(plans.len() as u64, |place| breaks(scenario, &plans[place as usize], 0));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn what_has_broken_a_promise_once_does_not_again() {
    let found = broken(BROKEN_ONCE.len() as u64, |place| {
        let (scenario, plan, seed) = BROKEN_ONCE[place as usize];
        breaks(scenario, plan, seed)
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Kinds of call that change what a disk has.
const CHANGES: [&str; 4] = ["sync", "rename", "unlink", "mkdir"];

#[test]
fn a_drive_outlives_a_power_cut_after_any_change_on_the_disk() {
    let mut plans = Vec::new();
    for (kind, name, count) in Scenario::Drive.census().calls(&CHANGES) {
        // In the journal each batch is as the one before.
        let at = if name == "rows.blocks" && count > 1 { vec![1, count] } else { (1..=count).collect() };
        plans.extend(at.into_iter().map(|at| format!("{kind} {name} {at} power-after")));
    }
    assert!(plans.len() > 40, "{plans:?}");
    hold(Scenario::Drive, &plans);
}

#[test]
fn a_power_cut_amid_a_batch_costs_that_batch_alone() {
    // Each leaves other parts of the batch: none, its begin, or all but one sector.
    let plans: Vec<String> = (1..=12).map(|seed| format!("sync rows.blocks 12 power {seed}")).collect();
    hold(Scenario::Drive, &plans);
}

#[test]
fn a_recovery_that_is_cut_is_taken_up_by_the_next() {
    let mut plans = Vec::new();
    for (kind, name, count) in Scenario::Recovery.census().calls(&["rename"]) {
        for at in 1..=count {
            plans.extend(["kill", "power-after"].map(|death| format!("{kind} {name} {at} {death}")));
        }
    }
    assert!(plans.len() > 12, "{plans:?}");
    hold(Scenario::Recovery, &plans);
}

#[test]
fn a_study_that_is_cut_at_any_save_of_a_session_goes_on() {
    let calls = Scenario::Study.census().calls(&["rename"]);
    let saves = calls.iter().find(|(_, name, _)| *name == "session.json").unwrap().2;
    // A session opens, gets its traits, begins and ends three items, and is over: 9 saves for each of two participants.
    assert_eq!(saves, 2 * 9);
    let at = |save: u32| format!("rename session.json {save} {}", ["kill", "power-after"][save as usize % 2]);
    let mut plans: Vec<String> = (1..=saves / 2).map(at).collect();
    // The data set itself is made before.
    plans.extend(["dataset_description.json", "README.md", "study.toml"].map(|name| format!("rename {name} 1 power")));
    hold(Scenario::Study, &plans);
}

#[test]
fn nothing_is_lost_and_nobody_is_locked_out_whatever_fails() {
    let (first, seeds) = (number("CODRIVE_FAULTS_FIRST", 0), number("CODRIVE_FAULTS_SEEDS", SEEDS));
    // A line for each seed that has been run, so that a night can be taken up again.
    let log = std::env::var_os("CODRIVE_FAULTS_LOG").map(PathBuf::from);
    let log = log.map(|path| Mutex::new(fs::File::options().create(true).append(true).open(path).unwrap()));
    let found = broken(seeds, |place| {
        let failure = seed(first + place);
        if let Some(log) = &log {
            let word = if failure.is_some() { "FAILED" } else { "held" };
            writeln!(log.lock().unwrap(), "{} {word}", first + place).unwrap();
        }
        failure
    });
    assert!(found.is_empty(), "{} of {seeds} seeds:\n{}", found.len(), found.join("\n"));
}
