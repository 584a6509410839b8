//! Restart: a new drive in place of the present one. In: a scenario. Out: the new drive some frames later, or the
//! previous drive from its start and the reason why the new one could not start.

use super::{
    LiveDrive,
    contacts::ContactCount,
    presentation::DigitPresentation,
    start::{PendingDrive, ReadyDrive},
};
use crate::{drive_loop::RunError, input::AdviceState, scenario::Scenario, sim::SummaryAccumulator, time::Pace};
use std::time::Duration;

/// Result of a restart.
#[derive(Debug)]
pub struct RestartOutcome {
    /// True if the renderer must be rebuilt, for another static scene or another quality.
    pub new_static_scene: bool,
    /// Reason why the requested drive could not start.
    pub refused: Option<RunError>,
}

/// Checks whether two scenarios have the same static scene.
fn has_static_scene_of(one: &Scenario, other: &Scenario) -> bool {
    (&one.map, one.seed, one.display.trees) == (&other.map, other.seed, other.display.trees)
}

impl LiveDrive {
    /// Starts another drive at the same pace, not recorded yet. Devices and view are kept, and so is the static scene
    /// if map, seed and trees are the same. [`LiveDrive::restarted`] completes the restart. Until then this drive is
    /// stopped, because SUMO allows one simulation per process.
    ///
    /// # Errors
    /// The recording of this drive cannot be finished, and the drive goes on; or the system cannot start a thread.
    pub fn restart(&mut self, scenario: &Scenario) -> Result<(), RunError> {
        self.finish_recording()?;
        self.refused = None;
        self.begin(scenario)
    }

    fn begin(&mut self, scenario: &Scenario) -> Result<(), RunError> {
        self.drive.world.stop_traffic();
        self.devices.rest();
        // A drive that is still starting must release the engine first.
        self.starting = None;
        self.starting =
            Some(PendingDrive::begin(scenario, !has_static_scene_of(self.drive.world.scenario(), scenario))?);
        Ok(())
    }

    /// Returns the scenario that is starting, between [`LiveDrive::restart`] and its end.
    pub fn starting(&self) -> Option<&Scenario> {
        self.starting.as_ref().map(PendingDrive::scenario)
    }

    /// Returns the result of a restart once, after waiting for `patience` at most; `None` while it goes on, or if there
    /// is none. If the new drive cannot start, the previous one starts again, paused.
    pub fn restarted(&mut self, patience: Duration) -> Option<RestartOutcome> {
        let done = self.starting.as_mut()?.wait(patience)?;
        let wanted = self.starting.take().map(|starting| starting.scenario().clone())?;
        match done {
            Ok(started) => {
                let new_static_scene = self.put(started);
                if self.refused.is_some() {
                    self.drive.clock.set_pace(Pace::Paused);
                }
                Some(RestartOutcome { new_static_scene, refused: self.refused.take() })
            }
            Err(error) => {
                let old = self.drive.world.scenario().clone();
                let again = self.refused.is_none() && old != wanted && self.begin(&old).is_ok();
                let refused = self.refused.take().unwrap_or(error);
                if again {
                    self.refused = Some(refused);
                    return None;
                }
                Some(RestartOutcome { new_static_scene: false, refused: Some(refused) })
            }
        }
    }

    /// Replaces this drive by another. Returns true if the renderer must be rebuilt, for another static scene or
    /// another quality.
    fn put(&mut self, started: ReadyDrive) -> bool {
        let ReadyDrive { mut drive, static_scene } = started;
        let old = self.drive.world.scenario().clone();
        let scenario = drive.world.scenario();
        let redraw = static_scene.is_some() || old.display.quality != scenario.display.quality;
        self.summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
        self.lane_help = scenario.lane_help;
        if old.rev_lamps {
            // Dark, unless the new drive lights them.
            let _ = self.devices.rig_mut().show_advice_state(AdviceState::None);
        }
        self.darken_led();
        self.contacts = ContactCount::default();
        self.sound.restart(&old, scenario);
        self.digits = DigitPresentation::new(scenario.secondary_task.n);
        self.picture.restart(&drive.world, static_scene);
        drive.clock.set_pace(self.drive.clock.pace());
        self.drive = drive;
        redraw
    }

    /// Checks whether this drive was stopped for another that could not start; it does not continue.
    pub fn is_stopped(&self) -> bool {
        self.starting.is_none() && self.drive.world.is_stopped()
    }
}
