//! Replay: a recording driven again. In: a recording. Out: the same world tick by tick, with the proof that it is the same. The
//! proof covers every cell of its tables, every value of manifest and summary that follows from the drive ([`facts`]), and each
//! file ([`evidence`]). A replay can also run in a [`window`] or with changes ([`what_if`]).

pub mod evidence;
pub mod facts;
#[cfg(feature = "desktop")]
mod playback;
#[cfg(feature = "desktop")]
mod renderer;
pub mod snapshot_timeline;
#[cfg(feature = "desktop")]
mod sound_track;
mod verifier;
mod what_if;
#[cfg(feature = "desktop")]
pub mod window;

pub use evidence::Evidence;
pub use facts::FactDifference;
pub use verifier::{ReplayHeader, VerificationProgress, Verifier};
pub use what_if::{ChangeFault, WhatIfComparison, changes, changes_text, what_if};
#[cfg(feature = "desktop")]
pub use {renderer::ReplayRenderer, sound_track::SoundTrack};

use crate::{
    controls::Controls,
    drive_loop::{Drive, RunError},
    record::{self, AlteredFile, CellDifference, Table, TableComparison, TableReader, tables::PUT_BACK},
    scenario::Scenario,
    sim::{EventStage, World},
    time::{Pace, Tick},
};
use facts::DriveFacts;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    time::Duration,
};

/// Result of a replay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReplayReport {
    /// Number of ticks driven again.
    pub ticks: u64,
    /// First tick whose world or rows differ from the recorded ones; `None` if all bits are equal.
    pub first_difference: Option<u64>,
    /// First cell that differs.
    pub difference: Option<CellDifference>,
    /// Number of differing cells.
    pub cells: u64,
    /// Number of differing cells, by table name and column name.
    pub columns: BTreeMap<(&'static str, String), u64>,
    /// Files of the recording that were altered.
    pub changes: Vec<AlteredFile>,
    /// Values of manifest and summary that the drive does not give again; known at the end.
    pub facts: Vec<FactDifference>,
    /// Proof of each file; known at the end, and empty if anything differs.
    pub files: Vec<Evidence>,
    /// Tick from which rows of the ego are missing; the replay ends there.
    pub hole: Option<Tick>,
    /// True if the recording has no tick, so that there is nothing to compare.
    pub is_empty: bool,
}

impl ReplayReport {
    /// Checks whether there was something to compare and no difference was found so far.
    pub fn is_proven(&self) -> bool {
        let is_same = self.first_difference.is_none() && self.hole.is_none();
        is_same && !self.is_empty && self.changes.is_empty() && self.facts.is_empty()
    }
}

/// Recording being driven again.
pub struct Replay {
    drive: Drive,
    recorded: TableComparison,
    facts: DriveFacts,
    folder: PathBuf,
    /// Number of recorded ticks, up to the first hole of a damaged recording.
    ticks: u64,
    /// Ticks at which the ego was put back on its lane, in descending order.
    put_back: Vec<u64>,
    /// Ticks at which the experimenter began events by hand, in descending order, and their numbers in the scenario.
    by_hand: Vec<(u64, usize)>,
    controls: Controls,
    report: ReplayReport,
}

impl Replay {
    /// Opens a recording and puts its world at the start.
    ///
    /// # Errors
    /// The folder holds no finished recording, or its scenario cannot be driven here.
    pub fn open(recording: &Path) -> Result<Self, RunError> {
        Self::of(recording, &recorded_scenario(recording)?)
    }

    /// Opens a recording with this scenario.
    fn of(recording: &Path, scenario: &Scenario) -> Result<Self, RunError> {
        let changes = record::changes(recording)?;
        let drive = Drive::new(scenario, Pace::Paused)?;
        let mut recorded = TableComparison::open(recording, &drive.world)?;
        recorded.start(&drive.world)?;
        let ticks = record::count(recording, Table::Ego)?;
        Ok(Self {
            facts: DriveFacts::open(recording, &drive.world)?,
            folder: recording.into(),
            drive,
            recorded,
            ticks,
            put_back: ticks_of(recording, PUT_BACK)?.into_iter().map(|(tick, _)| tick).collect(),
            by_hand: by_hand(recording, scenario)?,
            controls: Controls::default(),
            report: ReplayReport { changes, is_empty: ticks == 0, ..ReplayReport::default() },
        })
    }

    /// Returns the number of recorded ticks, up to the first hole of a damaged recording.
    pub fn len(&self) -> u64 {
        self.ticks
    }

    /// Checks whether nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.ticks == 0
    }

    /// Returns the world at the present tick.
    pub fn world(&self) -> &World {
        &self.drive.world
    }

    /// Checks whether all recorded ticks have been driven.
    pub fn over(&self) -> bool {
        self.report.ticks >= self.len()
    }

    /// Drives `ticks` further, at most to the end of the recording.
    ///
    /// # Errors
    /// The traffic engine failed, or the recording cannot be read further.
    pub fn advance(&mut self, ticks: u64) -> Result<(), RunError> {
        for _ in 0..ticks {
            if self.over() {
                break;
            }
            let due = Tick(self.report.ticks + 1);
            let Some(controls) = self.recorded.controls(due)? else {
                (self.report.hole, self.ticks) = (Some(due), self.report.ticks);
                break;
            };
            self.controls = controls;
            if self.put_back.pop_if(|tick| *tick == due.0).is_some() {
                // If this is no longer possible, the missing event is the difference.
                let _ = self.drive.world.put_back();
            }
            // The row has the tick at which its step began.
            while let Some((_, event)) = self.by_hand.pop_if(|(tick, _)| *tick + 1 == due.0) {
                self.drive.world.begin_event(event);
            }
            self.facts.before(&self.drive.world, &controls);
            self.drive.clock.single_step(1);
            self.drive.frame(Duration::ZERO, |_| controls, |_, _| ())?;
            self.recorded.tick(&self.drive.world, &controls)?;
            self.facts.tick(&self.drive.world);
            self.report.ticks += 1;
        }
        if self.over() {
            self.end()?;
        }
        if let (None, Some(first)) = (&self.report.difference, self.recorded.first()) {
            self.report.first_difference = Some(first.tick.0);
            self.report.difference = Some(first.clone());
        }
        self.report.cells = self.recorded.cells();
        self.report.columns.clone_from(self.recorded.columns());
        if self.over() && self.report.is_proven() {
            self.report.files = evidence::of(&self.folder, self.drive.world.scenario(), &self.facts)?;
        }
        Ok(())
    }

    /// Compares surplus rows and the facts of the whole drive, after all ticks were driven.
    fn end(&mut self) -> Result<(), RunError> {
        self.recorded.end(Tick(self.ticks), self.facts.is_cut())?;
        self.report.facts = self.facts.end(&self.drive.world);
        Ok(())
    }

    /// Returns the controls of the last tick; the default before the first.
    pub fn controls(&self) -> Controls {
        self.controls
    }

    /// Returns the result so far.
    pub fn report(&self) -> &ReplayReport {
        &self.report
    }
}

/// Returns the ticks and details of a recording's events of this kind, the last one first.
fn ticks_of(recording: &Path, kind: &str) -> Result<Vec<(u64, String)>, RunError> {
    let mut found = Vec::new();
    for part in TableReader::parts(&Table::Events.parquet(recording), &["tick", "event", "detail"])? {
        let part = part?;
        let rows = part.wholes("tick").into_iter().zip(part.words("event")).zip(part.words("detail"));
        found.extend(rows.filter(|((_, event), _)| event == kind).map(|((tick, _), detail)| (tick, detail)));
    }
    found.reverse();
    Ok(found)
}

/// Returns the ticks at which the experimenter began events by hand, and the numbers of these events, the last one first.
fn by_hand(recording: &Path, scenario: &Scenario) -> Result<Vec<(u64, usize)>, RunError> {
    let number = |name: &str| scenario.events.iter().position(|event| event.name == name);
    let rows = ticks_of(recording, EventStage::TriggeredByHand.name())?.into_iter();
    Ok(rows.filter_map(|(tick, name)| Some((tick, number(&name)?))).collect())
}

/// Returns the scenario of a recording that has ended.
fn recorded_scenario(recording: &Path) -> Result<Scenario, RunError> {
    record::open(recording)?;
    Ok(record::inputs::scenario(recording)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive_loop::{offline::OfflineDrive, recording_manifest};
    use crate::{
        scenario::{AdvisedVehicles, DisplaySettings},
        sim::{EventKind, ScriptedState},
        traffic::EngineChoice,
    };

    /// Scenario of six vehicles, three of them advised.
    fn three_advised() -> Scenario {
        Scenario {
            traffic: EngineChoice::Native,
            vehicles: 6,
            policy: "pi".into(),
            advised: AdvisedVehicles::Share(0.5),
            duration_s: 12.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        }
    }

    /// Records a whole drive.
    fn recorded(path: &Path, scenario: &Scenario) -> std::path::PathBuf {
        let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY]).unwrap();
        run.record(path).unwrap();
        run.until(scenario.duration_s).unwrap();
        run.finish_recording().unwrap();
        path.into()
    }

    #[test]
    fn other_advised_vehicles_are_recorded_and_proven() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive");
        recorded(&path, &three_advised());
        // Vehicles 2 and 4, one row each step; position and speed equal those in the table of cars.
        let read = |table: Table| TableReader::parquet(&table.parquet(&path)).unwrap();
        let (advised, cars) = (read(Table::Advised), read(Table::Cars));
        assert_eq!(advised.rows(), 2 * 120);
        assert_eq!(advised.ids("vehicle")[..4], [Some(2), Some(4), Some(2), Some(4)]);
        let state = |table: &TableReader, id: &str| -> Vec<_> {
            let numbers = table.numbers("speed_mps").into_iter().zip(table.numbers("x_m"));
            table.wholes("tick").into_iter().zip(table.ids(id)).zip(numbers).collect()
        };
        let of_cars = state(&cars, "car").into_iter().filter(|((_, car), _)| [Some(2), Some(4)].contains(car));
        assert_eq!(state(&advised, "vehicle"), of_cars.collect::<Vec<_>>());
        assert!(advised.numbers("throttle").iter().flatten().any(|pressed| *pressed > 0.1));
        assert!(advised.numbers("target_mps").iter().all(Option::is_some), "the controller advises from the start");
        assert!(advised.ids("contacts").iter().all(|contacts| *contacts == Some(0)));

        let mut replay = Replay::open(&path).unwrap();
        replay.advance(u64::MAX).unwrap();
        assert!(replay.report().is_proven() && replay.report().ticks == 1200, "{:?}", replay.report());
        // The table is replaced by that of another drive; everything else stays.
        let other = recorded(&folder.path().join("other"), &Scenario { driver: "sloppy".into(), ..three_advised() });
        std::fs::copy(Table::Advised.parquet(&other), Table::Advised.parquet(&path)).unwrap();
        let mut replay = Replay::open(&path).unwrap();
        replay.advance(u64::MAX).unwrap();
        let (report, difference) = (replay.report(), replay.report().difference.clone().unwrap());
        assert!(report.cells > 1000 && difference.table == Table::Advised, "{report:?}");
    }

    #[test]
    fn a_cut_drive_with_several_advised_vehicles_is_recovered_and_proven() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive");
        let mut run = OfflineDrive::new(&three_advised(), [0.0, f64::INFINITY]).unwrap();
        run.record(&path).unwrap();
        run.until(6.0).unwrap();
        drop(run);
        let found = record::recover(&path).unwrap();
        let rows = |table: Table| found.rows.iter().find(|(of, _)| *of == table).map(|(_, rows)| *rows);
        assert_eq!((rows(Table::Ego), rows(Table::Advised), rows(Table::Signals)), (Some(600), Some(120), None));
        let mut replay = Replay::open(&path).unwrap();
        replay.advance(u64::MAX).unwrap();
        assert!(replay.report().is_proven() && replay.report().ticks == 600, "{:?}", replay.report());
    }

    #[test]
    fn a_replay_puts_the_ego_back_on_its_lane_at_the_same_ticks() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive");
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            vehicles: 6,
            duration_s: 12.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let away = Controls { throttle: 0.5, steering_wheel_rad: 3.0, ..Controls::default() };
        let mut wished = 0;
        record_drive(&path, &scenario, &away, |world| {
            if world.snapshot().lane_offset_m.abs() > 4.0 {
                wished += u32::from(world.put_back().is_ok());
            }
        });
        assert!(wished > 1, "left the road and was put back {wished} times");
        let mut replay = Replay::open(&path).unwrap();
        assert_eq!(replay.put_back.len(), wished as usize);
        replay.advance(u64::MAX).unwrap();
        assert!(replay.report().is_proven() && replay.report().ticks == 1200, "{:?}", replay.report());
    }

    /// Records a drive with constant controls; `act` acts on the world before each tick.
    fn record_drive(path: &Path, scenario: &Scenario, controls: &Controls, mut act: impl FnMut(&mut World)) {
        let mut world = World::new(scenario).unwrap();
        let mut summary = crate::sim::SummaryAccumulator::new([0.0, f64::INFINITY]);
        let manifest = recording_manifest::manifest(&world, "test".into(), None);
        let mut recorder = recording_manifest::begin(path, &world, manifest).unwrap();
        while world.ended().is_none() {
            act(&mut world);
            world.tick(controls).unwrap();
            summary.add(world.snapshot(), world.events());
            recorder.tick(&world, controls).unwrap();
        }
        recorder.finish(&summary.to_summary()).unwrap();
    }

    #[test]
    fn a_replay_begins_an_event_that_was_begun_by_hand_at_the_same_step() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive");
        // Its chance is 0, and its speed is never driven: only the experimenter begins it.
        let text = "traffic = \"native\"\nvehicles = 6\nduration_s = 8\ntrees = 0\n[[event]]\nname = \"stop\"\ntrigger = { speed_above_mps = 60 }\n\
             probability = 0\nactions = [{ brake = { vehicle = \"leader\", decel_mps2 = 2 } }]\n";
        let scenario = Scenario::from_toml(text, "trial.toml").unwrap();
        let mut stages = Vec::new();
        record_drive(&path, &scenario, &Controls::default(), |world| {
            stages.extend(world.events().iter().filter_map(|event| match event.kind {
                EventKind::Scripted { stage, .. } => Some((event.tick.0, stage)),
                _ => None,
            }));
            if world.snapshot().tick.0 == 403 {
                world.begin_event(0);
                assert_eq!(world.scripted_events().next(), Some(("stop", ScriptedState::Running)));
            }
        });
        assert_eq!(stages[1..3], [(410, EventStage::TriggeredByHand), (411, EventStage::Onset)], "{stages:?}");
        let mut replay = Replay::open(&path).unwrap();
        assert_eq!(replay.by_hand, [(410, 0)]);
        replay.advance(u64::MAX).unwrap();
        assert!(replay.report().is_proven() && replay.report().ticks == 800, "{:?}", replay.report());
    }
}
