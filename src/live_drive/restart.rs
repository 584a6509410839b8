//! Restart: a new drive in place of the current one. In: a scenario. Out: the drive, some frames later, or the one before
//! from its start and why the other could not begin.

use super::{
    LiveDrive,
    contacts::ContactCount,
    start::{PendingDrive, ReadyDrive},
};
use crate::{drive_loop::RunError, input::AdviceState, scenario::Scenario, sim::SummaryAccumulator, time::Pace};
use std::time::Duration;

/// The end of a restart.
#[derive(Debug)]
pub struct RestartOutcome {
    /// True if the renderer has to be made anew, for another stage or another quality.
    pub new_stage: bool,
    /// Why the drive that was asked for could not start.
    pub refused: Option<RunError>,
}

/// True if what stands still is the same in both.
fn has_stage_of(one: &Scenario, other: &Scenario) -> bool {
    (&one.map, one.seed, one.display.trees) == (&other.map, other.seed, other.display.trees)
}

impl LiveDrive {
    /// Begins another drive at the same pace, which is not recorded yet; devices, view and, if map and seed are the same, the stage
    /// are kept. It comes from [`LiveDrive::restarted`]; until then this one stands as it is, and is over: SUMO allows one
    /// simulation a process.
    ///
    /// # Errors
    /// The recording of this one cannot be finished; it goes on.
    pub fn restart(&mut self, scenario: &Scenario) -> Result<(), RunError> {
        self.finish_recording()?;
        self.refused = None;
        self.begin(scenario)
    }

    fn begin(&mut self, scenario: &Scenario) -> Result<(), RunError> {
        self.drive.world.stop_traffic();
        self.devices.keyboard.rest();
        // One that is not there yet lets go of the engine first.
        self.starting = None;
        self.starting = Some(PendingDrive::begin(scenario, !has_stage_of(self.drive.world.scenario(), scenario))?);
        Ok(())
    }

    /// What is being begun, between [`LiveDrive::restart`] and its end.
    pub fn starting(&self) -> Option<&Scenario> {
        self.starting.as_ref().map(PendingDrive::scenario)
    }

    /// The end of a restart, once, after `patience` at most; `None` while it goes on, or if there is none. Where the new
    /// drive cannot start the one before begins again from its start, held.
    pub fn restarted(&mut self, patience: Duration) -> Option<RestartOutcome> {
        let done = self.starting.as_mut()?.wait(patience)?;
        let wanted = self.starting.take().map(|starting| starting.scenario().clone())?;
        match done {
            Ok(started) => {
                let new_stage = self.put(started);
                if self.refused.is_some() {
                    self.drive.clock.set_pace(Pace::Paused);
                }
                Some(RestartOutcome { new_stage, refused: self.refused.take() })
            }
            Err(error) => {
                let old = self.drive.world.scenario().clone();
                let again = self.refused.is_none() && old != wanted && self.begin(&old).is_ok();
                let refused = self.refused.take().unwrap_or(error);
                if again {
                    self.refused = Some(refused);
                    return None;
                }
                Some(RestartOutcome { new_stage: false, refused: Some(refused) })
            }
        }
    }

    /// Another drive takes the place of this one. True if the renderer has to be made anew, for another stage or another
    /// quality.
    fn put(&mut self, started: ReadyDrive) -> bool {
        let ReadyDrive { mut drive, stage } = started;
        let old = self.drive.world.scenario().clone();
        let scenario = drive.world.scenario();
        let redraw = stage.is_some() || old.display.quality != scenario.display.quality;
        self.tally = SummaryAccumulator::new([0.0, f64::INFINITY]);
        self.lane_help = scenario.lane_help;
        if old.rev_lamps {
            // Dark, unless the new drive shows its own.
            let _ = self.devices.rig_mut().show_advice_state(AdviceState::None);
        }
        self.contacts = ContactCount::default();
        self.sound.restart(&old, scenario);
        self.picture.restart(&drive.world, stage);
        drive.clock.set_pace(self.drive.clock.pace());
        self.drive = drive;
        redraw
    }

    /// True if this drive was stopped for another, which could not start: nothing more comes of it.
    pub fn is_stopped(&self) -> bool {
        self.starting.is_none() && self.drive.world.is_stopped()
    }
}
