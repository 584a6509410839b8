//! Body of the drive loop (docs/decisions.md: 1). In: elapsed time, and a driver. Out: the world after the ticks that
//! were due.

use crate::{
    controls::Controls,
    scenario::Scenario,
    sim::{SummaryAccumulator, World, WorldError},
    time::{Clock, DueTicks, Pace},
    traffic::TrafficError,
};
use std::time::Duration;

/// Longest wait of a window's frame for a traffic engine that runs elsewhere: a window that handles its keys 20 times a
/// second does not seem frozen.
pub const PATIENCE: Duration = Duration::from_millis(50);

/// Notes a failure of the world in the summary, so that the recording says why the drive ended. An interruption by the
/// user is no failure.
pub fn note_failure(tally: &mut SummaryAccumulator, error: &WorldError) {
    if !matches!(error, WorldError::Traffic(TrafficError::Interrupted)) {
        tally.fail(error.to_string());
    }
}

/// Running drive: a world and its clock.
pub struct Drive {
    /// World of the simulation.
    pub world: World,
    /// Clock that converts the time of frames to ticks.
    pub clock: Clock,
    /// Longest wait of a tick for a traffic engine that runs elsewhere. A window sets a short one, so that it can
    /// handle its keys; ticks that are due during the wait are dropped.
    pub patience: Duration,
}

impl Drive {
    /// Starts a drive.
    ///
    /// # Errors
    /// Its world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace) -> Result<Self, WorldError> {
        Ok(Self { world: World::new(scenario)?, clock: Clock::new(pace), patience: Duration::MAX })
    }

    /// Starts a drive with a person as the driver.
    ///
    /// # Errors
    /// Its world cannot start, or has no participant.
    pub fn by_participant(scenario: &Scenario, pace: Pace) -> Result<Self, WorldError> {
        if scenario.participant { Self::new(scenario, pace) } else { Err(WorldError::NoParticipant) }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::EngineChoice;
    use crate::traffic::{CarState, Traffic, VehicleReport};

    /// Traffic of standing vehicles, from an engine that responds late: at query number `questions`.
    struct UnresponsiveTraffic {
        cars: Vec<CarState>,
        questions: u32,
    }

    impl Traffic for UnresponsiveTraffic {
        fn step(&mut self, _reports: &[VehicleReport]) -> Result<(), TrafficError> {
            Ok(())
        }

        fn finish_step(&mut self, patience: Duration) -> Result<bool, TrafficError> {
            assert_eq!(patience, PATIENCE);
            self.questions = self.questions.saturating_sub(1);
            Ok(self.questions == 0)
        }

        fn cars(&self) -> &[CarState] {
            &self.cars
        }

        fn describe(&self) -> String {
            "late".into()
        }
    }

    /// Returns a drive of `duration_s` in real time that waits for such an engine from its first tick on.
    fn drive(duration_s: f64, questions: u32) -> Drive {
        let scenario = Scenario { traffic: EngineChoice::Native, vehicles: 2, duration_s, ..Scenario::default() };
        let mut drive = Drive::new(&scenario, Pace::RealTime).unwrap();
        let other = drive.world.snapshot().cars[0];
        let stands = CarState { id: other.id, s_m: other.s_m.expect("on the ring"), ..CarState::default() };
        let cars = vec![CarState::default(), stands];
        drive.world.set_traffic(Box::new(UnresponsiveTraffic { cars, questions }));
        drive.patience = PATIENCE;
        drive
    }

    /// Runs a frame of this many milliseconds. Returns the numbers of ticks and of calls of `steer`, and the dropped
    /// time in ms.
    fn frame(drive: &mut Drive, elapsed_ms: u64) -> (u64, u64, u128) {
        let (mut steered, mut seen) = (0, 0);
        let steer = |_: &World| {
            steered += 1;
            Controls::default()
        };
        let due = drive.frame(Duration::from_millis(elapsed_ms), steer, |_, _| seen += 1).unwrap();
        assert_eq!(seen, steered);
        (due.ticks, steered, due.dropped.as_millis())
    }

    #[test]
    fn ticks_with_late_traffic_are_dropped_and_counted_as_a_stall() {
        let mut drive = drive(60.0, 3);
        // The second frame drops 0.25 s at its end, and the time beyond that at once.
        assert_eq!(frame(&mut drive, 50), (0, 0, 50));
        assert_eq!(frame(&mut drive, 300), (0, 0, 300));
        assert_eq!((drive.clock.stalls(), drive.clock.dropped()), (3, Duration::from_millis(350)));
        // The engine responds now; dropped time is not made up for.
        assert_eq!(frame(&mut drive, 50), (5, 5, 0));
        assert_eq!(drive.world.snapshot().tick.0, 5);
        // There is no wait within a step; at the next step the engine is queried again.
        drive.world.set_traffic(Box::new(UnresponsiveTraffic { cars: Vec::new(), questions: 2 }));
        assert_eq!(frame(&mut drive, 80), (5, 5, 30), "of eight ticks five are of the step that is known");
        assert_eq!(drive.world.snapshot().tick.0, 10);
    }

    #[test]
    fn an_ended_drive_makes_no_tick() {
        let mut drive = drive(0.03, 0);
        assert_eq!(frame(&mut drive, 50).1, 3);
        assert!(drive.world.ended().is_some());
        assert_eq!(frame(&mut drive, 50).1, 0);
    }

    #[test]
    fn a_failure_of_the_world_is_noted_and_an_interruption_is_not() {
        let failure = |error: TrafficError| {
            let mut tally = SummaryAccumulator::new([0.0, f64::INFINITY]);
            note_failure(&mut tally, &WorldError::Traffic(error));
            tally.summary().failure
        };
        assert_eq!(failure(TrafficError::Interrupted), None);
        let told = failure(TrafficError::Setup("no cars".into())).unwrap();
        assert!(told.contains("no cars"), "{told}");
    }
}
