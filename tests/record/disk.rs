//! What is said to be on the disk is there: the program's calls to the system, as strace sees them. A file takes its name when it
//! is synced, the folder that has the name is synced after, a batch of rows is one write and one sync, and the journal is
//! removed when the manifest that says that it can be is on the disk.

use std::{collections::BTreeMap, fs, path::Path, process::Command};

/// A call, once it has returned.
#[derive(Debug, PartialEq)]
enum Call {
    Write(String),
    Sync(String),
    Rename(String, String),
    Remove(String),
}

/// Runs the program under strace.
fn calls(arguments: &[&str], folder: &Path) -> Vec<Call> {
    let log = folder.join("calls");
    let status = Command::new("strace")
        .args(["--follow-forks", "--decode-fds=path", "--string-limit=0", "--quiet=all", "--seccomp-bpf"])
        .args(["-e", "trace=write,fsync,fdatasync,rename,renameat,renameat2,unlink,unlinkat", "-o"])
        .arg(&log)
        .arg(env!("CARGO_BIN_EXE_codrive"))
        .args(arguments)
        .env("RUST_LOG", "error")
        .stdout(std::process::Stdio::null())
        .status()
        .expect("strace is needed: scripts/setup --test installs it");
    assert!(status.success(), "{arguments:?}");
    parse(&fs::read_to_string(log).unwrap())
}

/// Calls in the order in which they returned; one that another thread interrupts is two lines.
fn parse(log: &str) -> Vec<Call> {
    let mut pending: BTreeMap<&str, String> = BTreeMap::new();
    let mut calls = Vec::new();
    for line in log.lines() {
        let (thread, text) = line.split_once(' ').unwrap();
        let text = text.trim_start();
        let whole = if let Some(begin) = text.strip_suffix(" <unfinished ...>") {
            pending.insert(thread, begin.into());
            continue;
        } else if text.starts_with("<... ") {
            let begin = pending.remove(thread).unwrap();
            begin + text.split_once("resumed>").unwrap().1
        } else {
            text.into()
        };
        calls.extend(call(&whole));
    }
    calls
}

fn call(text: &str) -> Option<Call> {
    let (name, rest) = text.split_once('(')?;
    if rest.contains(") = -1") {
        return None;
    }
    // `write(5</a/b>, ...)`, `rename("/a/b", "/a/c")`, `unlinkat(AT_FDCWD</here>, "/a/b", 0)`: of a call by a folder's descriptor
    // the name is relative to it.
    let descriptor = || Some(rest.split_once('<')?.1.split_once('>')?.0.to_owned());
    let quoted: Vec<&str> = rest.split('"').skip(1).step_by(2).collect();
    let full = |name: &str| {
        let base = descriptor().filter(|_| rest.contains('<') && !name.starts_with('/'));
        base.map_or(name.to_owned(), |base| format!("{base}/{name}"))
    };
    match (name, &quoted[..]) {
        ("write", _) => descriptor().map(Call::Write),
        ("fsync" | "fdatasync", _) => descriptor().map(Call::Sync),
        ("rename" | "renameat" | "renameat2", [from, to]) => Some(Call::Rename(full(from), full(to))),
        ("unlink" | "unlinkat", [path]) => Some(Call::Remove(full(path))),
        _ => None,
    }
}

fn folder_of(path: &str) -> &str {
    path.rsplit_once('/').map_or(".", |(folder, _)| folder)
}

/// Every rename: the file is synced after its last write and before, its folder after. Returns how many there are.
fn check_renames(calls: &[Call]) -> usize {
    let mut renames = 0;
    for (at, renamed) in calls.iter().enumerate() {
        let Call::Rename(from, to) = renamed else { continue };
        renames += 1;
        if from.ends_with(".new") {
            let last = |wanted: &Call| calls[..at].iter().rposition(|call| call == wanted);
            let (write, sync) = (last(&Call::Write(from.clone())), last(&Call::Sync(from.clone())));
            assert!(sync > write && write.is_some(), "{from} took the name {to} before the disk had it");
        }
        // The next thing that the program relies on is another small file, or that the journal can go.
        let next = calls[at + 1..].iter().position(|call| match call {
            Call::Rename(other, name) => !(name.ends_with(".parquet") && to.ends_with(".parquet")) && other != from,
            Call::Remove(path) => path.ends_with("rows.blocks"),
            _ => false,
        });
        let until = next.map_or(calls.len(), |next| at + 1 + next);
        let synced = Call::Sync(folder_of(to).into());
        assert!(calls[at..until].contains(&synced), "{to} has its name, but its folder was not synced");
    }
    renames
}

#[test]
fn a_recording_is_on_the_disk_when_it_is_said_to_be_at_five_syncs_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p1");
    let run = [
        "run",
        "--traffic",
        "native",
        "--duration",
        "4",
        "--warm-up",
        "0",
        "--real-time",
        "--out",
        out.to_str().unwrap(),
    ];
    let calls = calls(&run, folder.path());
    // manifest, scenario, five tables, summary, checksums, manifest.
    assert_eq!(check_renames(&calls), 10);

    let journal = out.join("journal/rows.blocks").to_str().unwrap().to_owned();
    let of_journal: Vec<&Call> =
        calls.iter().filter(|call| matches!(call, Call::Write(path) | Call::Sync(path) if *path == journal)).collect();
    for pair in of_journal.chunks(2) {
        assert_eq!(pair, [&Call::Write(journal.clone()), &Call::Sync(journal.clone())], "a write, then its sync");
    }
    let syncs = of_journal.len() / 2;
    // Every 0.2 s of 4 s, and the rest at the end; half as many where the machine is busy.
    assert!((10..=22).contains(&syncs), "{syncs} syncs of rows in 4 s");

    let gone =
        calls.iter().position(|call| matches!(call, Call::Remove(path) if path.ends_with("rows.blocks"))).unwrap();
    let manifest = out.join("manifest.json").to_str().unwrap().to_owned();
    let complete = calls.iter().rposition(|call| matches!(call, Call::Rename(_, to) if *to == manifest)).unwrap();
    let folder_synced = Call::Sync(out.to_str().unwrap().into());
    assert!(complete < gone && calls[complete..gone].contains(&folder_synced), "the journal goes last");
}

#[test]
fn every_step_of_a_session_is_on_the_disk_before_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("short.toml"), folder.path().join("data"));
    fs::write(&file, super::kills::STUDY).unwrap();
    let study = ["study", file.to_str().unwrap(), "--rehearse", "--participants", "1", "--out", out.to_str().unwrap()];
    let calls = calls(&study, folder.path());
    check_renames(&calls);
    let session = out.join("sourcedata/sub-R01/session.json");
    let saved = calls.iter().filter(|call| matches!(call, Call::Rename(_, to) if Path::new(to) == session)).count();
    // Opened, traits, two items with a beginning and an end each, the end of the session.
    assert_eq!(saved, 2 + 2 * 2 + 1);
    let trial = out.join("sourcedata/sub-R01/trial-1-narrow/journal/rows.blocks");
    let begun = calls.iter().position(|call| matches!(call, Call::Write(path) if Path::new(path) == trial)).unwrap();
    let before =
        calls[..begun].iter().filter(|call| matches!(call, Call::Rename(_, to) if Path::new(to) == session)).count();
    assert_eq!(before, 2 + 2 + 1, "that the trial began is on the disk before its first row");
}
