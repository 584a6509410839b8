//! Draws a plan from a seed. In: a seed, and the calls of a run without faults. Out: one to five faults at calls that exist.
//!
//! The first fault cycles through manners and then through the vital files, so that a few seeds cover every kind. The others are drawn by
//! kind of call, then by file, then by number. A file that is written once is thus hit as often as one that is written a thousand times.

use super::{
    plan::{Fault, Plan},
    program::Call,
};
use codrive::rng::{self, Stream};
use std::collections::BTreeMap;

/// Most important files of the data, the most important one first. Each has three times the weight of another file.
const VITAL: [&str; 9] = [
    "rows.blocks",
    "manifest.new",
    "session.new",
    "manifest.json",
    "session.json",
    "ego.new",
    "checksums.new",
    "SHA256SUMS.new",
    "heart.blocks",
];
/// Probability that a fault without a set file counts the calls on all files together.
const ANY_FILE: f64 = 0.15;

/// Kind of the first fault of a plan.
#[derive(Clone, Copy)]
enum Manner {
    Refusal,
    PowerCut,
    Kill,
    Any,
}

/// Manners of the first fault, in turn, each with its kinds of call.
const TURNS: [(Manner, &[&str]); 5] = [
    (Manner::Refusal, &["write", "send", "recv"]),
    (Manner::PowerCut, &["write", "sync", "rename", "unlink", "mkdir"]),
    (Manner::Kill, &["write", "sync", "rename", "unlink", "open"]),
    (Manner::Refusal, &["sync", "rename", "unlink", "open", "mkdir", "connect"]),
    (Manner::Any, &["read", "stat", "list", "clock", "recv", "open"]),
];

/// Kinds of call, with their weights for the further faults.
const KINDS: [(&str, usize); 14] = [
    ("write", 5),
    ("sync", 5),
    ("rename", 5),
    ("unlink", 2),
    ("open", 2),
    ("mkdir", 1),
    ("read", 2),
    ("truncate", 1),
    ("stat", 1),
    ("list", 1),
    ("clock", 1),
    ("connect", 1),
    ("send", 2),
    ("recv", 2),
];

/// Number of calls by kind, then by file.
pub struct Census(BTreeMap<String, BTreeMap<String, u32>>);

impl Census {
    pub fn of(trace: &[Call]) -> Self {
        let mut counts: BTreeMap<String, BTreeMap<String, u32>> = BTreeMap::new();
        for call in trace {
            *counts.entry(call.kind.clone()).or_default().entry(file_of(&call.name).to_owned()).or_default() += 1;
        }
        Self(counts)
    }

    /// Returns kind, file and number of the calls of these kinds.
    pub fn calls(&self, kinds: &[&str]) -> Vec<(&str, &str, u32)> {
        let of = |kind: &&str| self.0.get_key_value(*kind);
        let all = kinds
            .iter()
            .filter_map(of)
            .flat_map(|(kind, files)| files.iter().map(move |(name, count)| (kind.as_str(), name.as_str(), *count)));
        all.collect()
    }

    /// Draws a plan of one to five faults; `visit` counts the earlier seeds that drew from these calls.
    pub fn draw(&self, seed: u64, visit: u64) -> Plan {
        let mut random = rng::stream(seed, "faults");
        let mut plan = Plan(vec![self.first(visit, &mut random)]);
        while plan.0.len() < 5 && random.uniform(0.0, 1.0) < 0.4 {
            let kind = self.kind(&KINDS, &mut random);
            plan.0.push(self.fault(kind, None, Manner::Any, &mut random));
        }
        plan
    }

    fn first(&self, visit: u64, random: &mut Stream) -> Fault {
        let (manner, kinds) = TURNS[(visit % TURNS.len() as u64) as usize];
        let round = (visit / TURNS.len() as u64) as usize;
        let has = |kind: &str, name: &str| self.0.get(kind).is_some_and(|files| files.contains_key(name));
        let of = |name: &'static str| -> (&'static str, Vec<&'static str>) {
            (name, kinds.iter().copied().filter(|kind| has(kind, name)).collect())
        };
        let vital: Vec<_> = VITAL.into_iter().map(of).filter(|(_, kinds)| !kinds.is_empty()).collect();
        // Each vital file has its round; after that, half of the faults are drawn among all files.
        let place = if round < vital.len() { round } else { random.index(2 * vital.len()) };
        match vital.get(place) {
            Some((name, kinds)) if !matches!(manner, Manner::Any) => {
                self.fault(kinds[random.index(kinds.len())], Some(name), manner, random)
            }
            _ => {
                let kinds: Vec<_> = kinds.iter().map(|kind| (*kind, 1)).collect();
                self.fault(self.kind(&kinds, random), None, manner, random)
            }
        }
    }

    /// Draws one of these kinds that has calls; if none has, one of all kinds.
    fn kind(&self, kinds: &[(&'static str, usize)], random: &mut Stream) -> &'static str {
        let there = |kinds: &[(&'static str, usize)]| -> Vec<&'static str> {
            let kinds = kinds.iter().filter(|(kind, _)| self.0.contains_key(*kind));
            kinds.flat_map(|(kind, times)| std::iter::repeat_n(*kind, *times)).collect()
        };
        let these = Some(there(kinds)).filter(|kinds| !kinds.is_empty()).unwrap_or_else(|| there(&KINDS));
        these[random.index(these.len())]
    }

    fn fault(&self, kind: &str, name: Option<&str>, manner: Manner, random: &mut Stream) -> Fault {
        let files = &self.0[kind];
        let (name, count) = if let Some(name) = name {
            (name, files[name])
        } else if random.uniform(0.0, 1.0) < ANY_FILE || kind == "clock" {
            ("*", files.values().sum())
        } else {
            let times = |name: &str| if VITAL.contains(&name) { 3 } else { 1 };
            let weighed: Vec<(&str, u32)> = files
                .iter()
                .flat_map(|(name, count)| std::iter::repeat_n((name.as_str(), *count), times(name)))
                .collect();
            weighed[random.index(weighed.len())]
        };
        // The first and the last call of a kind are more likely: there things begin and end.
        let at = match random.index(4) {
            0 => 1,
            1 => count,
            _ => 1 + random.index(count as usize) as u32,
        };
        let (action, number) = action(kind, name, manner, random);
        Fault { kind: kind.into(), name: name.into(), at, action, number }
    }
}

/// Returns the part of a file's name that faults use: for the long names of a data set, the end.
fn file_of(path: &str) -> &str {
    let name = path.rsplit_once('/').map_or(path, |(_, name)| name);
    match name.rfind('_') {
        // An empty name is the workplace itself.
        _ if name.is_empty() => "*",
        Some(at) if name.starts_with("sub-") => &name[at..],
        _ => name,
    }
}

fn action(kind: &str, name: &str, manner: Manner, random: &mut Stream) -> (String, i64) {
    let either = |random: &mut Stream, words: [&str; 2]| words[random.index(2)].to_owned();
    match manner {
        Manner::Kill => return (either(random, ["kill", "kill-after"]), 0),
        Manner::PowerCut => {
            // Before the sync of rows, a part of them may be on the disk. For other files the worst case is that none is.
            let is_amid = name == "rows.blocks" && kind == "sync";
            let seed = random.index(if is_amid { 1 } else { 2 }) as i64;
            let seed = (1 - seed) * (1 + random.index(1 << 20) as i64);
            return (if is_amid { "power".into() } else { either(random, ["power", "power-after"]) }, seed);
        }
        Manner::Refusal | Manner::Any => {}
    }
    let refusals: &[&str] = match kind {
        "write" => &["ENOSPC+", "ENOSPC", "EIO", "EDQUOT+"],
        "sync" => &["EIO", "EIO", "ENOSPC"],
        "rename" | "unlink" | "mkdir" => &["EIO", "EACCES", "ENOSPC", "EROFS+"],
        "open" => &["EIO", "EACCES", "EMFILE", "ENOSPC", "EROFS+"],
        "read" => &["EIO", "EIO+", "ESTALE"],
        "truncate" => &["EIO", "ENOSPC"],
        "stat" | "list" => &["EIO", "EACCES", "ESTALE"],
        "clock" => &[],
        "connect" => &["ECONNREFUSED", "ETIMEDOUT"],
        "send" => &["EPIPE", "ECONNRESET"],
        _ => &["ECONNRESET", "ETIMEDOUT"],
    };
    let harmless: &[&str] = match kind {
        "write" | "read" | "send" | "recv" => &["EINTR", "short", "slow"],
        "sync" | "open" => &["EINTR", "slow"],
        "truncate" | "connect" => &["EINTR"],
        "clock" => &["jump"],
        _ => &["slow"],
    };
    let is_harmless = refusals.is_empty() || (matches!(manner, Manner::Any) && random.uniform(0.0, 1.0) < 0.4);
    let actions = if is_harmless { harmless } else { refusals };
    let action = actions[random.index(actions.len())];
    let number = match action {
        "short" => [1, 7, 100, 4095][random.index(4)],
        "slow" => [20, 100, 250][random.index(3)],
        "jump" => [-1, 1, -3600, 3600, -400_000_000, 400_000_000, 300_000_000_000][random.index(7)],
        _ => 0,
    };
    (action.into(), number)
}

#[test]
fn a_seed_gives_the_same_plan_of_existing_calls() {
    let call = |kind: &str, name: &str| Call { kind: kind.into(), name: name.into(), result: "ok".into() };
    let mut trace: Vec<Call> = (0..50).map(|_| call("read", "p1/ego.parquet")).collect();
    trace.extend([call("write", "p1/manifest.new"), call("clock", "*"), call("rename", "d/sub-R01_task-a_events.tsv")]);
    let census = Census::of(&trace);
    let mut kinds = std::collections::BTreeSet::new();
    for seed in 0..200 {
        let plan = census.draw(seed, seed / 2);
        assert_eq!(plan, census.draw(seed, seed / 2));
        assert!((1..=5).contains(&plan.0.len()));
        for fault in plan.0 {
            let most = if fault.kind == "read" { 50 } else { 1 };
            assert!(
                (1..=most).contains(&fault.at)
                    && ["*", "ego.parquet", "manifest.new", "_events.tsv"].contains(&fault.name.as_str()),
                "{fault}"
            );
            kinds.insert(fault.kind);
        }
    }
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), ["clock", "read", "rename", "write"]);
}
