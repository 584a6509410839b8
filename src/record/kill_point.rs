//! Ends the program as a power cut would, at a named point: for tests of what is left then. In: `CODRIVE_KILL_AT=NAME` or
//! `NAME:COUNT` (the COUNT-th time that the point is passed). Out: SIGKILL. Release builds do not look.
//!
//! These are places in a recording's life, whatever else a program in a window or with devices does at the time. What may fail or end
//! it at any call is tried from outside, by the calls themselves (tests/faults).

use std::sync::atomic::{AtomicU64, Ordering};

/// Every point, in the order of a recording's life. `replace.*` are passed by every small file that is saved.
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

/// Variable of the environment.
const VARIABLE: &str = "CODRIVE_KILL_AT";

/// Arms the point that the environment names; does nothing in a release build.
///
/// # Panics
/// If there is no such point: a test that names one means it.
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
