//! Replay: a recording driven again. In: a recording. Out: the same world tick by tick, with the proof that it is the same: every cell
//! of its tables, every value of its manifest and summary that follows from the drive ([`facts`]), and what each file was proven by
//! ([`evidence`]); in a [`window`], too, or with something changed ([`what_if`]).

pub mod evidence;
pub mod facts;
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
pub use what_if::{ChangeFault, WhatIfComparison, changes, what_if, words};
#[cfg(feature = "desktop")]
pub use {renderer::ReplayRenderer, sound_track::SoundTrack};

use crate::{
    controls::Controls,
    drive_loop::{Drive, RunError},
    record::{self, AlteredFile, CellDifference, Table, TableComparison, TableReader, tables::PUT_BACK},
    scenario::Scenario,
    sim::World,
    time::{Pace, Tick},
};
use facts::DriveFacts;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    time::Duration,
};

/// What a replay found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReplayReport {
    /// Ticks that were driven again.
    pub ticks: u64,
    /// The first tick whose world or rows differ from the recorded ones; `None` if all bits are equal.
    pub first_difference: Option<u64>,
    /// The cell that differs there.
    pub difference: Option<CellDifference>,
    /// How many cells of the tables differ.
    pub cells: u64,
    /// Cells that differ, by the name of the table and of the column.
    pub columns: BTreeMap<(&'static str, String), u64>,
    /// Files of the recording that are not as they were written.
    pub changes: Vec<AlteredFile>,
    /// Values of the manifest and the summary that are not as the drive gives them; known at the end.
    pub facts: Vec<FactDifference>,
    /// Proof of each file; known at the end, and empty where something differs.
    pub files: Vec<Evidence>,
    /// The tick from which on rows of the ego are missing: the replay ends there.
    pub hole: Option<Tick>,
    /// The recording has no tick: there is nothing to compare.
    pub is_empty: bool,
}

impl ReplayReport {
    /// There was something to compare, and nothing was found that is not as it was recorded.
    pub fn is_proven(&self) -> bool {
        let is_same = self.first_difference.is_none() && self.hole.is_none();
        is_same && !self.is_empty && self.changes.is_empty() && self.facts.is_empty()
    }
}

/// A recording being driven again.
pub struct Replay {
    drive: Drive,
    recorded: TableComparison,
    facts: DriveFacts,
    folder: PathBuf,
    /// Ticks that were recorded, to the first hole of a recording that was damaged.
    ticks: u64,
    /// Ticks with which the car was put back on its lane, the first one last.
    put_back: Vec<u64>,
    controls: Controls,
    verdict: ReplayReport,
}

impl Replay {
    /// Puts the recorded world at its start.
    ///
    /// # Errors
    /// The folder holds no recording that has ended, or its scenario cannot be driven here.
    pub fn open(recording: &Path) -> Result<Self, RunError> {
        Self::of(recording, &recorded_scenario(recording)?)
    }

    /// The same with the scenario of the recording.
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
            put_back: put_back(recording)?,
            controls: Controls::default(),
            verdict: ReplayReport { changes, is_empty: ticks == 0, ..ReplayReport::default() },
        })
    }

    /// How many ticks were recorded, to the first hole of a recording that was damaged.
    pub fn len(&self) -> u64 {
        self.ticks
    }

    /// True if nothing was recorded.
    pub fn is_empty(&self) -> bool {
        self.ticks == 0
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.drive.world
    }

    /// True when all recorded ticks have been driven.
    pub fn over(&self) -> bool {
        self.verdict.ticks >= self.len()
    }

    /// Drives `ticks` on, or to the end of the recording.
    ///
    /// # Errors
    /// The traffic engine failed, or the recording cannot be read on.
    pub fn advance(&mut self, ticks: u64) -> Result<(), RunError> {
        for _ in 0..ticks {
            if self.over() {
                break;
            }
            let due = Tick(self.verdict.ticks + 1);
            let Some(controls) = self.recorded.controls(due)? else {
                (self.verdict.hole, self.ticks) = (Some(due), self.verdict.ticks);
                break;
            };
            self.controls = controls;
            if self.put_back.pop_if(|tick| *tick == due.0).is_some() {
                // Where that is not possible any more, the missing event is the difference.
                let _ = self.drive.world.put_back();
            }
            self.facts.before(&self.drive.world, &controls);
            self.drive.clock.single_step(1);
            self.drive.frame(Duration::ZERO, |_| controls, |_, _| ())?;
            self.recorded.tick(&self.drive.world, &controls)?;
            self.facts.tick(&self.drive.world);
            self.verdict.ticks += 1;
        }
        if self.over() {
            self.end()?;
        }
        if let (None, Some(first)) = (&self.verdict.difference, self.recorded.first()) {
            self.verdict.first_difference = Some(first.tick.0);
            self.verdict.difference = Some(first.clone());
        }
        self.verdict.cells = self.recorded.cells();
        self.verdict.columns.clone_from(self.recorded.columns());
        if self.over() && self.verdict.is_proven() {
            self.verdict.files = evidence::of(&self.folder, self.drive.world.scenario(), &self.facts)?;
        }
        Ok(())
    }

    /// All ticks were driven: what the tables have beyond them, and what else follows from the whole drive.
    fn end(&mut self) -> Result<(), RunError> {
        self.recorded.end(Tick(self.ticks), self.facts.is_cut())?;
        self.verdict.facts = self.facts.end(&self.drive.world);
        Ok(())
    }

    /// The controls of the last tick; at rest before the first.
    pub fn controls(&self) -> Controls {
        self.controls
    }

    /// What was found so far.
    pub fn verdict(&self) -> &ReplayReport {
        &self.verdict
    }
}

/// Ticks with which the car was put back on its lane, the last one first.
fn put_back(recording: &Path) -> Result<Vec<u64>, RunError> {
    let mut found = Vec::new();
    for part in TableReader::parts(&Table::Events.parquet(recording), &["tick", "event"])? {
        let part = part?;
        let events = part.wholes("tick").into_iter().zip(part.words("event"));
        found.extend(events.filter(|(_, event)| event == PUT_BACK).map(|(tick, _)| tick));
    }
    found.reverse();
    Ok(found)
}

/// The scenario of a recording that has ended.
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
        traffic::EngineChoice,
    };

    /// Six cars, three of them advised.
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

    /// A recording of the whole drive.
    fn recorded(path: &Path, scenario: &Scenario) -> std::path::PathBuf {
        let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY]).unwrap();
        run.record(path).unwrap();
        run.until(scenario.duration_s).unwrap();
        run.finish_recording().unwrap();
        path.into()
    }

    #[test]
    fn what_other_advised_vehicles_did_is_recorded_and_proven_and_another_driver_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive");
        recorded(&path, &three_advised());
        // Cars 2 and 4, a row each step: place and speed are those of the table of the cars.
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
        assert!(replay.verdict().is_proven() && replay.verdict().ticks == 1200, "{:?}", replay.verdict());
        // The table of another drive in its place: nothing but that is another.
        let other = recorded(&folder.path().join("other"), &Scenario { driver: "sloppy".into(), ..three_advised() });
        std::fs::copy(Table::Advised.parquet(&other), Table::Advised.parquet(&path)).unwrap();
        let mut replay = Replay::open(&path).unwrap();
        replay.advance(u64::MAX).unwrap();
        let (verdict, difference) = (replay.verdict(), replay.verdict().difference.clone().unwrap());
        assert!(verdict.cells > 1000 && difference.table == Table::Advised, "{verdict:?}");
    }

    #[test]
    fn a_drive_with_several_advised_vehicles_that_was_cut_is_recovered_and_proven() {
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
        assert!(replay.verdict().is_proven() && replay.verdict().ticks == 600, "{:?}", replay.verdict());
    }

    #[test]
    fn a_car_that_was_put_back_on_its_lane_is_put_back_at_the_same_tick_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("drive");
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            vehicles: 6,
            duration_s: 12.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let mut world = World::new(&scenario).unwrap();
        let mut tally = crate::sim::SummaryAccumulator::new([0.0, f64::INFINITY]);
        let mut recorder =
            recording_manifest::begin(&path, &world, recording_manifest::manifest(&world, "test".into(), None))
                .unwrap();
        let away = Controls { throttle: 0.5, steering_wheel_rad: 3.0, ..Controls::default() };
        let mut wished = 0;
        while world.ended().is_none() {
            if world.snapshot().lane_offset_m.abs() > 4.0 {
                wished += u32::from(world.put_back().is_ok());
            }
            world.tick(&away).unwrap();
            tally.add(world.snapshot(), world.events());
            recorder.tick(&world, &away).unwrap();
        }
        recorder.finish(&tally.summary()).unwrap();
        assert!(wished > 1, "left the road and was put back {wished} times");
        let mut replay = Replay::open(&path).unwrap();
        assert_eq!(replay.put_back.len(), wished as usize);
        replay.advance(u64::MAX).unwrap();
        assert!(replay.verdict().is_proven() && replay.verdict().ticks == 1200, "{:?}", replay.verdict());
    }
}
