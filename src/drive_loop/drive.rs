//! Body of the drive loop (docs/decisions.md: 1). In: elapsed time, and a driver. Out: the world after the ticks that
//! were due.

use crate::{
    controls::Controls,
    scenario::{PlannedDrive, Scenario},
    sim::{SummaryAccumulator, World, WorldError},
    time::{Clock, DueTicks, Pace},
    traffic::TrafficError,
};
use std::time::Duration;

/// Notes a failure of the world in the summary, so that the recording says why the drive ended. An interruption by the
/// user is no failure.
pub fn note_failure(summary: &mut SummaryAccumulator, error: &WorldError) {
    if !matches!(error, WorldError::Traffic(TrafficError::Interrupted)) {
        summary.fail(error.to_string());
    }
}

/// Running drive: a world and its clock.
pub struct Drive {
    /// World of the simulation.
    pub world: World,
    /// Clock that converts the time of frames to ticks.
    pub clock: Clock,
}

impl Drive {
    /// Starts a drive.
    ///
    /// # Errors
    /// The world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace) -> Result<Self, WorldError> {
        Self::of(PlannedDrive::new(scenario)?, pace)
    }

    /// Starts a planned drive.
    ///
    /// # Errors
    /// The world cannot start.
    pub fn of(drive: PlannedDrive, pace: Pace) -> Result<Self, WorldError> {
        Ok(Self { world: World::of(drive)?, clock: Clock::new(pace) })
    }

    /// Starts a planned drive with a person as the driver.
    ///
    /// # Errors
    /// The world cannot start, or the scenario has no participant.
    pub fn by_participant(drive: PlannedDrive, pace: Pace) -> Result<Self, WorldError> {
        if drive.scenario().participant { Self::of(drive, pace) } else { Err(WorldError::NoParticipant) }
    }

    /// Runs the ticks that are due in one frame. `steer` returns the controls of each tick; `watch` is called with the
    /// world after it and with those controls.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn frame(
        &mut self,
        elapsed: Duration,
        mut steer: impl FnMut(&World) -> Controls,
        mut watch: impl FnMut(&World, &Controls),
    ) -> Result<DueTicks, WorldError> {
        let due = self.clock.advance(elapsed);
        for _ in 0..due.ticks {
            if self.world.ended().is_some() {
                break;
            }
            self.world.prepare()?;
            let controls = steer(&self.world);
            self.world.tick(&controls)?;
            watch(&self.world, &controls);
        }
        Ok(due)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::EngineChoice;

    #[test]
    fn a_drive_that_is_over_makes_no_tick() {
        let scenario = Scenario { traffic: EngineChoice::Native, vehicles: 2, duration_s: 0.03, ..Scenario::default() };
        let mut drive = Drive::new(&scenario, Pace::RealTime).unwrap();
        for expected in [3, 0] {
            let (mut steered, mut seen) = (0, 0);
            let steer = |_: &World| {
                steered += 1;
                Controls::default()
            };
            drive.frame(Duration::from_millis(50), steer, |_, _| seen += 1).unwrap();
            assert_eq!([steered, seen], [expected; 2]);
            assert!(drive.world.ended().is_some());
        }
    }

    #[test]
    fn a_failure_of_the_world_is_noted_and_an_interruption_is_not() {
        let failure = |error: TrafficError| {
            let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
            note_failure(&mut summary, &WorldError::Traffic(error));
            summary.to_summary().failure
        };
        assert_eq!(failure(TrafficError::Interrupted), None);
        let message = failure(TrafficError::Setup("no cars".into())).unwrap();
        assert!(message.contains("no cars"), "{message}");
    }
}
