//! Drive without a window: a simulated driver at full speed. In: a scenario. Out: a recording, a summary, or a world at
//! a given second for a picture.

use super::{Drive, RunError, drive::note_failure, recording_manifest, summary_text};
use crate::{
    controls::Controls,
    driver::{self, DriverError, DriverParams, SimulatedDriver},
    record::{FLUSH_EVERY, Manifest, Recorder},
    scenario::{PlannedDrive, Scenario},
    sim::{Summary, SummaryAccumulator, World},
    study::ParticipantCode,
    time::{Pace, Tick},
    traffic::EGO,
};
use serde::Serialize;
use std::{
    path::Path,
    time::{Duration, Instant},
};

/// Advised vehicles of a drive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdvisedSummary {
    /// Numbers of the vehicles, the ego's (0) first if it is advised.
    pub vehicles: Vec<u32>,
    /// Number of all vehicles; `None` on a network, where they come and go.
    pub of: Option<u32>,
    /// Number of contacts of advised vehicles other than the ego, whose contacts are in the drive's summary.
    pub contacts_of_others: u32,
}

/// Drive by a simulated driver.
pub struct OfflineDrive {
    drive: Drive,
    driver: SimulatedDriver,
    summary: SummaryAccumulator,
    recorder: Option<Recorder>,
    began: Instant,
    flushed: Instant,
}

impl OfflineDrive {
    /// Prepares a drive; means will be taken over `window_s`.
    ///
    /// # Errors
    /// The world cannot start, or the driver is unknown.
    pub fn new(scenario: &Scenario, window_s: [f64; 2]) -> Result<Self, RunError> {
        Self::by(&driver::named(&scenario.driver)?.params, scenario, window_s)
    }

    /// Prepares a planned drive; means will be taken over `window_s`.
    ///
    /// # Errors
    /// The world cannot start, or the driver is unknown.
    pub fn of(drive: PlannedDrive, window_s: [f64; 2]) -> Result<Self, RunError> {
        let params = driver::named(&drive.scenario().driver)?.params;
        Self::driven(&params, Drive::of(drive, Pace::Paused)?, window_s)
    }

    /// Prepares a drive by a driver with these parameters.
    ///
    /// # Errors
    /// The world cannot start, or the driver cannot be simulated.
    pub fn by(params: &DriverParams, scenario: &Scenario, window_s: [f64; 2]) -> Result<Self, RunError> {
        Self::driven(params, Drive::new(scenario, Pace::Paused)?, window_s)
    }

    fn driven(params: &DriverParams, drive: Drive, window_s: [f64; 2]) -> Result<Self, RunError> {
        Ok(Self {
            driver: driver_of(params, &drive.world)?,
            drive,
            summary: SummaryAccumulator::new(window_s),
            recorder: None,
            began: now(),
            flushed: now(),
        })
    }

    /// Starts recording the drive in `folder`.
    ///
    /// # Errors
    /// The folder holds a recording, or cannot be written.
    pub fn record(&mut self, folder: &Path) -> Result<(), RunError> {
        let driver = format!("simulated: {}", self.drive.world.scenario().driver);
        self.record_of(folder, driver, None)
    }

    /// Starts recording the drive in `folder` for a participant of a study; `driver` describes the driver.
    ///
    /// # Errors
    /// The folder holds a recording, or cannot be written.
    pub fn record_of(
        &mut self,
        folder: &Path,
        driver: String,
        participant: Option<&ParticipantCode>,
    ) -> Result<(), RunError> {
        let participant = participant.map(|code| code.as_str().to_owned());
        let manifest = Manifest { participant, ..recording_manifest::manifest(&self.drive.world, driver, None) };
        self.recorder = Some(recording_manifest::begin(folder, &self.drive.world, manifest)?);
        Ok(())
    }

    /// Records an event from outside the world.
    pub fn note(&mut self, kind: &str, detail: &str) {
        let tick = self.drive.world.snapshot().tick;
        if let Some(recorder) = &mut self.recorder {
            recorder.event(tick, kind, detail);
        }
    }

    /// Records an event from outside the world with a number.
    pub fn note_value(&mut self, kind: &str, detail: &str, value: f64) {
        let tick = self.drive.world.snapshot().tick;
        if let Some(recorder) = &mut self.recorder {
            recorder.event_with_value(tick, kind, detail, value);
        }
    }

    /// Ends the recording, if there is one: tables, summary, manifest.
    ///
    /// # Errors
    /// The recording cannot be written; its data can be recovered.
    pub fn finish_recording(&mut self) -> Result<(), RunError> {
        if let Some(recorder) = self.recorder.take() {
            recorder.finish(&self.summary.to_summary())?;
        }
        Ok(())
    }

    /// Drives one step (0.1 s unless the scenario has another one), or less if the drive ends.
    ///
    /// # Errors
    /// The traffic engine failed, and the recording is finished with that reason; or the recording cannot be written.
    pub fn step(&mut self) -> Result<(), RunError> {
        self.ticks(self.drive.world.scenario().step_ticks())
    }

    /// Drives until `time_s` or the end of the drive.
    ///
    /// # Errors
    /// The traffic engine failed, or the recording cannot be written.
    pub fn until(&mut self, time_s: f64) -> Result<(), RunError> {
        let now = self.drive.world.snapshot().tick;
        self.ticks(Tick::at_seconds(time_s).0.saturating_sub(now.0))
    }

    fn ticks(&mut self, ticks: u64) -> Result<(), RunError> {
        let Self { drive, driver, summary, recorder, flushed, .. } = self;
        let mut recorded = Ok(());
        drive.clock.single_step(ticks);
        let driven = drive.frame(
            Duration::ZERO,
            |world| match world.scenario().participant {
                true => driver.controls(&world.perceived_by(driver)),
                false => Controls::default(),
            },
            |world, asked| {
                summary.add(world.snapshot(), world.events());
                if let (Some(recorder), Ok(())) = (&mut *recorder, &recorded) {
                    recorded = recorder.tick(world, asked);
                }
            },
        );
        if let Err(error) = driven {
            note_failure(summary, &error);
            // The drive is over and its recording complete. An error of the disk at this point is not the reason for
            // the end.
            if let Err(also) = self.finish_recording() {
                log::error!("{also}");
            }
            return Err(error.into());
        }
        recorded?;
        if let (Some(recorder), true) = (recorder, flushed.elapsed() > FLUSH_EVERY) {
            recorder.flush_waiting()?;
            *flushed = now();
        }
        Ok(())
    }

    /// Waits until the wall clock reaches the time of the drive, counted from the creation of this value.
    pub fn keep_time(&self) {
        let due = self.began + Duration::from_secs_f64(self.world().time_s());
        std::thread::sleep(due.saturating_duration_since(now()));
    }

    /// Returns the present world.
    pub fn world(&self) -> &World {
        &self.drive.world
    }

    /// Returns the summary of the drive so far.
    pub fn summary(&self) -> Summary {
        self.summary.to_summary()
    }

    /// Returns the summary of the drive so far as text.
    pub fn summary_text(&self) -> String {
        let world = &self.drive.world;
        let policy = world.policy().to_string();
        let driver = &world.scenario().driver;
        let text = summary_text::summary(world.drive(), &world.traffic_engine(), driver, &policy, &self.summary());
        text + &summary_text::advised(&self.advised())
    }

    /// Returns the advised vehicles, the participant's included.
    pub fn advised(&self) -> AdvisedSummary {
        let world = &self.drive.world;
        let ego = (world.policy().name != "none" && world.scenario().participant).then_some(EGO.0);
        AdvisedSummary {
            vehicles: ego.into_iter().chain(world.ever_advised().iter().map(|id| id.0)).collect(),
            of: world.drive().advisable(),
            contacts_of_others: world.contacts_of_others(),
        }
    }
}

/// Creates a simulated driver with these parameters for the ego of a world before its first tick.
///
/// # Errors
/// The driver cannot be simulated.
pub fn driver_of(params: &DriverParams, world: &World) -> Result<SimulatedDriver, DriverError> {
    let scenario = world.scenario();
    let driver = world.simulated_driver(params, scenario.seed)?;
    Ok(if scenario.standing_start { driver.with_foot_on_brake() } else { driver })
}

#[allow(clippy::disallowed_methods, reason = "when to write is a matter of wall time")]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        record::{Table, TableReader},
        traffic::EngineChoice,
    };

    #[test]
    fn a_drive_whose_traffic_failed_is_kept_and_says_why() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("drive");
        let scenario = Scenario { traffic: EngineChoice::Native, vehicles: 6, warm_up_s: 0.0, ..Scenario::default() };
        let mut run = OfflineDrive::new(&scenario, [0.0, f64::INFINITY]).unwrap();
        run.record(&out).unwrap();
        run.until(1.0).unwrap();
        run.drive.world.stop_traffic();
        let error = run.step().unwrap_err().to_string();
        assert_eq!(error, "this drive was stopped");
        let ended = Manifest::load(&out).unwrap().ended;
        assert_eq!(ended.as_deref(), Some("failed: this drive was stopped"));
        let rows = TableReader::parquet(&Table::Ego.parquet(&out)).unwrap().rows();
        assert_eq!(rows, 100);
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        assert!(summary.contains("\"ended\": \"failed\""), "{summary}");
    }
}
