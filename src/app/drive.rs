//! The body of the loop (DESIGN 3). In: elapsed time, and who drives. Out: a world that many ticks later.

use crate::{
    ego::Controls,
    sim::{Scenario, Tally, World, WorldError},
    time::{Clock, Due, Pace},
    traffic::TrafficError,
};
use std::time::Duration;

/// A frame of a window waits so long for a traffic engine that runs elsewhere: one that hears its keys 20 times a second
/// does not feel hung.
pub(super) const PATIENCE: Duration = Duration::from_millis(50);

/// A failure of the world ends the drive, and its recording says why; that somebody ended the program is none.
pub(super) fn note_failure(tally: &mut Tally, error: &WorldError) {
    if !matches!(error, WorldError::Traffic(TrafficError::Interrupted)) {
        tally.fail(error.to_string());
    }
}

/// A running drive: the world and its clock.
pub struct Drive {
    /// The simulation.
    pub world: World,
    /// How it follows the frames.
    pub clock: Clock,
    /// How long a tick may wait for a traffic engine that runs elsewhere. A window sets it to a moment, so that it hears
    /// its keys meanwhile; ticks that are due then are dropped.
    pub patience: Duration,
}

impl Drive {
    /// Starts a drive.
    ///
    /// # Errors
    /// If its world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace) -> Result<Self, WorldError> {
        Ok(Self { world: World::new(scenario)?, clock: Clock::new(pace), patience: Duration::MAX })
    }

    /// One frame: all ticks that are due. `steer` is asked for the controls of each tick, `watch` sees the world
    /// after it, and those controls.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn frame(
        &mut self,
        elapsed: Duration,
        mut steer: impl FnMut(&World) -> Controls,
        mut watch: impl FnMut(&World, &Controls),
    ) -> Result<Due, WorldError> {
        let mut due = self.clock.advance(elapsed);
        for done in 0..due.ticks {
            if self.world.ended().is_some() {
                break;
            }
            if !self.world.prepare(self.patience)? {
                due.dropped += self.clock.drop_ticks(due.ticks - done);
                due.ticks = done;
                break;
            }
            let controls = steer(&self.world);
            self.world.tick(&controls)?;
            watch(&self.world, &controls);
        }
        Ok(due)
    }
}
