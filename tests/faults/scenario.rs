//! Commands that run under faults, and the files that exist before. In: a workplace. Out: folders in it, the command, and its calls without
//! faults.

use super::{
    checks,
    draw::Census,
    plan::Plan,
    program::{LIVE, Outcome, Workplace, copy},
};
use std::{
    fs,
    path::PathBuf,
    sync::{LazyLock, OnceLock},
};

/// Study of two short trials with their baselines, between two questionnaires.
const STUDY: &str = r#"title = "Short"
participants = 2
seed = 7
[base]
traffic = "native"
vehicles = 6
warm_up_s = 0.0
duration_s = 1.0
[[condition]]
name = "narrow"
[[condition]]
name = "none"
set = { policy = "none" }
[[segment]]
kind = "questions"
name = "ssq-before"
questionnaire = "ssq"
[[segment]]
kind = "trials"
name = "trial"
"#;

/// Number of ticks of a recorded drive.
pub const TICKS: u64 = 400;
/// Number of ticks per batch of rows, at the clock of these tests: rows are handed over at the first step after 0.2 s.
pub const BATCH: u64 = 20;

const RUN: [&str; 11] =
    ["run", "--traffic", "native", "--vehicles", "6", "--duration", "4", "--warm-up", "0", "--out", "@p1"];
const REHEARSE: [&str; 7] = ["study", "rehearse", "@study.toml", "--participants", "2", "--out", "@data"];

/// Interrupted recordings: name, fault, and number of ticks on the disk. They were interrupted during the drive; before the tables had
/// their names; after the manifest said that the recording is complete; and after the journal was deleted but not its folder.
pub const CUTS: [(&str, &str, u64); 4] = [
    ("cut", "write rows.blocks 9 kill-after", 8 * BATCH),
    ("cut-tables", "rename advice.parquet 1 kill", TICKS),
    ("cut-whole", "unlink rows.blocks 1 kill", TICKS),
    ("cut-empty", "unlink rows.blocks 1 kill-after", TICKS),
];

/// Command on files of a workplace.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scenario {
    /// Recorded drive without a window.
    Drive,
    /// Rehearsal of a whole study.
    Study,
    /// Recovery of an interrupted drive.
    Recovery,
    /// Continuation of an interrupted study.
    ResumedStudy,
    /// Replay that proves a recording.
    Replay,
    /// Analysis and report of a study.
    Analysis,
    /// Erasure of a participant.
    Erasure,
    /// Exclusion of a participant.
    Exclusion,
    /// Recorded live drive, with devices that disappear and return.
    Live,
}

impl Scenario {
    pub const ALL: [Self; 9] = [
        Self::Drive,
        Self::Study,
        Self::Recovery,
        Self::ResumedStudy,
        Self::Replay,
        Self::Analysis,
        Self::Erasure,
        Self::Exclusion,
        Self::Live,
    ];

    /// Returns the scenario of a seed, and the number of earlier seeds with that scenario.
    pub fn of(seed: u64) -> (Self, u64) {
        // Drives and studies come most, as their data cannot be made again.
        const TEN: [usize; 10] = [0, 1, 2, 0, 3, 1, 0, 4, 0, 5];
        let [ten, place] = [seed / 10, seed % 10].map(|number| number as usize);
        // A live drive takes seconds of real time: one seed of twenty.
        if place == 6 && ten % 2 == 1 {
            return (Self::Live, ten as u64 / 2);
        }
        // Erasures, exclusions and analyses take turns.
        let this = |ten: usize, place: usize| if place == 9 { 5 + ten % 3 } else { TEN[place] };
        let scenario = this(ten, place);
        let visit = if place == 9 {
            ten / 3
        } else {
            let each = TEN.iter().filter(|of| **of == scenario).count();
            ten * each + TEN[..place].iter().filter(|of| **of == scenario).count()
        };
        (Self::ALL[scenario], visit as u64)
    }

    /// Returns the command; arguments that begin with `@` are files of the workplace.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::Drive => &RUN,
            Self::Live => &[LIVE, "@p1"],
            Self::Study | Self::ResumedStudy => &REHEARSE,
            Self::Recovery => &["recover", "@p1"],
            Self::Replay => &["replay", "@p1"],
            Self::Analysis => &["analyse", "@data"],
            Self::Erasure => &["study", "erase", "@study.toml", "R01", "--reason", "asked for", "--from", "@data"],
            Self::Exclusion => &["study", "exclude", "@study.toml", "R01", "--reason", "slept", "--from", "@data"],
        }
    }

    /// Puts the files that exist before the command into a workplace.
    pub fn prepare(self, work: &Workplace, seed: u64) {
        let fixtures = &*FIXTURES;
        let put = |from: &str, to: &str| copy(&fixtures.work.file(from), &work.file(to));
        fs::write(work.file("study.toml"), STUDY).unwrap();
        // A recording of an earlier run, which must not change.
        put("whole", "p0");
        match self {
            Self::Drive | Self::Study => {}
            Self::Live => work.draw_devices_by(seed),
            Self::Recovery => put(CUTS[(seed / 10) as usize % CUTS.len()].0, "p1"),
            Self::ResumedStudy => put("half", "data"),
            Self::Replay => put("whole", "p1"),
            Self::Analysis | Self::Erasure | Self::Exclusion => put("study", "data"),
        }
    }

    /// Returns the calls of this command without faults.
    pub fn census(self) -> &'static Census {
        static COUNTED: [OnceLock<Census>; Scenario::ALL.len()] = [const { OnceLock::new() }; Scenario::ALL.len()];
        COUNTED[self as usize].get_or_init(|| {
            let work = Workplace::new();
            self.prepare(&work, 0);
            let outcome = work.run(self.arguments());
            assert_eq!(outcome.code, Some(0), "{self:?} without faults: {}", outcome.text);
            Census::of(&outcome.trace)
        })
    }

    /// Runs the command under a plan and checks the result.
    ///
    /// # Errors
    /// The first broken promise, with the output of the program.
    pub fn check(self, plan: &Plan, seed: u64) -> Result<(), Box<Broken>> {
        let work = Workplace::new();
        self.prepare(&work, seed);
        let outcome = work.run_under(plan, self.arguments());
        checks::check(self, &work, plan, &outcome, seed).map_err(|promise| Box::new(Broken { promise, outcome, work }))
    }
}

/// Promise that a plan has broken.
pub struct Broken {
    pub promise: String,
    pub outcome: Outcome,
    pub work: Workplace,
}

/// Files of earlier runs, made once.
pub struct Fixtures {
    work: Workplace,
    /// Fingerprint of every tick of the recorded drive.
    hashes: Vec<u64>,
}

impl Fixtures {
    /// Returns the fingerprint of every tick of the recorded drive.
    pub fn hashes(&self) -> &[u64] {
        &self.hashes
    }

    /// Returns the folder of an earlier run.
    pub fn folder(&self, name: &str) -> PathBuf {
        self.work.file(name)
    }
}

pub static FIXTURES: LazyLock<Fixtures> = LazyLock::new(|| {
    let work = Workplace::new();
    fs::write(work.file("study.toml"), STUDY).unwrap();
    let make = |from: &str, to: &str, plan: &str, arguments: &[&str]| {
        let outcome = work.run_under(&plan.parse().unwrap(), arguments);
        assert_eq!(outcome.is_killed(), !plan.is_empty(), "{to}: {:?} {}", outcome.code, outcome.text);
        fs::rename(work.file(from), work.file(to)).unwrap();
        outcome
    };
    let whole = make("p1", "whole", "", &RUN);
    assert_eq!(whole.count("sync", "rows.blocks") as u64, TICKS.div_ceil(BATCH), "batches of the clock of these tests");
    for (name, plan, _) in CUTS {
        make("p1", name, plan, &RUN);
    }
    make("data", "study", "", &REHEARSE);
    // The cut is in the second trial of the second participant.
    make("data", "half", "write rows.blocks 33 kill-after", &REHEARSE);
    let hashes = checks::hashes(&work.file("whole")).unwrap();
    assert_eq!(hashes.len(), TICKS as usize);
    Fixtures { work, hashes }
});
