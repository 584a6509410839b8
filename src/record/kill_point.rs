//! Kill points for tests: end the program at a named point as a power cut would. In: `CODRIVE_KILL_AT=NAME` or `NAME:COUNT`
//! (the COUNT-th time that the point is passed). Out: SIGKILL. Release builds ignore the variable.
//!
//! The points are stages of a recording. Failures and ends at arbitrary system calls are tested from outside (tests/faults).

use std::sync::atomic::{AtomicU64, Ordering};

/// Names of all points, in the order of a recording. Every small file that is saved passes `replace.*`.
pub const POINTS: &[&str] = &[
    "begin.folder",
    "begin.manifest",
    "begin.scenario",
    "begin.journal",
    "replace.written",
    "replace.renamed",
    "tick",
    "flush.begin",
    "flush.written",
    "flush.synced",
    "finish.begin",
    "finish.tables_written",
    "finish.table_renamed",
    "finish.tables",
    "finish.summary",
    "finish.checksums",
    "finish.complete",
    "finish.journal_gone",
    "session.begin",
];

/// Name of the environment variable.
const VARIABLE: &str = "CODRIVE_KILL_AT";

/// Arms the point named by the environment; does nothing in a release build.
///
/// # Panics
/// There is no such point, so that a test with a wrong name fails.
pub fn arm() {
    if !cfg!(debug_assertions) {
        return;
    }
    let Ok(text) = std::env::var(VARIABLE) else { return };
    let (name, count) = text.split_once(':').unwrap_or((&text, "1"));
    let count: u64 = count.parse().expect("CODRIVE_KILL_AT=NAME:COUNT");
    assert!(POINTS.contains(&name), "{VARIABLE}: there is no point {name}; there are {POINTS:?}");
    let passed = AtomicU64::new(0);
    let armed = fail::cfg_callback(name, move || {
        if passed.fetch_add(1, Ordering::SeqCst) + 1 == count {
            kill();
        }
    });
    armed.expect("a callback can be set");
}

#[cfg(target_os = "linux")]
fn kill() {
    let _ = nix::sys::signal::raise(nix::sys::signal::Signal::SIGKILL);
}

#[cfg(not(target_os = "linux"))]
fn kill() {
    std::process::abort();
}
