//! The body of the loop (DESIGN 3). In: elapsed time, and who drives. Out: a world that many ticks later.

use crate::{
    ego::Controls,
    sim::{Scenario, World, WorldError},
    time::{Clock, Due, Pace},
};
use std::time::Duration;

/// A running drive: the world and its clock.
pub struct Drive {
    /// The simulation.
    pub world: World,
    /// How it follows the frames.
    pub clock: Clock,
}

impl Drive {
    /// Starts a drive.
    ///
    /// # Errors
    /// If its world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace) -> Result<Self, WorldError> {
        Ok(Self { world: World::new(scenario)?, clock: Clock::new(pace) })
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
        let due = self.clock.advance(elapsed);
        for _ in 0..due.ticks {
            if self.world.ended().is_some() {
                break;
            }
            let controls = steer(&self.world);
            self.world.tick(&controls)?;
            watch(&self.world, &controls);
        }
        Ok(due)
    }
}
