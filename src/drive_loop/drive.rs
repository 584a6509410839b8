//! The body of the drive loop (docs/decisions.md: 1). In: elapsed time, and who drives. Out: a world that many ticks later.

use crate::{
    controls::Controls,
    scenario::Scenario,
    sim::{SummaryAccumulator, World, WorldError},
    time::{Clock, DueTicks, Pace},
    traffic::TrafficError,
};
use std::time::Duration;

/// A frame of a window waits so long for a traffic engine that runs elsewhere: one that hears its keys 20 times a second
/// does not feel hung.
pub const PATIENCE: Duration = Duration::from_millis(50);

/// A failure of the world ends the drive, and its recording says why; that somebody ended the program is none.
pub fn note_failure(tally: &mut SummaryAccumulator, error: &WorldError) {
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

    /// Starts a drive for somebody at the wheel.
    ///
    /// # Errors
    /// If its world cannot start, or has no participant.
    pub fn by_participant(scenario: &Scenario, pace: Pace) -> Result<Self, WorldError> {
        if scenario.participant { Self::new(scenario, pace) } else { Err(WorldError::NoParticipant) }
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

    /// Cars that stand, of an engine that does not answer in time for so many questions.
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

    /// A drive of `duration_s` in real time that waits for such an engine from its first tick on.
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

    /// A frame of so many milliseconds: ticks that were made and steered, and milliseconds that were dropped.
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
    fn ticks_whose_traffic_is_late_are_dropped_with_their_time_and_counted_as_a_stall() {
        let mut drive = drive(60.0, 3);
        // The second frame drops a quarter of a second at its end and what is beyond at once.
        assert_eq!(frame(&mut drive, 50), (0, 0, 50));
        assert_eq!(frame(&mut drive, 300), (0, 0, 300));
        assert_eq!((drive.clock.stalls(), drive.clock.dropped()), (3, Duration::from_millis(350)));
        // Now it answers: nothing is made up for.
        assert_eq!(frame(&mut drive, 50), (5, 5, 0));
        assert_eq!(drive.world.snapshot().tick.0, 5);
        // Within a step nobody waits; at the next one the engine is asked again.
        drive.world.set_traffic(Box::new(UnresponsiveTraffic { cars: Vec::new(), questions: 2 }));
        assert_eq!(frame(&mut drive, 80), (5, 5, 30), "of eight ticks five are of the step that is known");
        assert_eq!(drive.world.snapshot().tick.0, 10);
    }

    #[test]
    fn a_drive_that_is_over_makes_no_tick() {
        let mut drive = drive(0.03, 0);
        assert_eq!(frame(&mut drive, 50).1, 3);
        assert!(drive.world.ended().is_some());
        assert_eq!(frame(&mut drive, 50).1, 0);
    }

    #[test]
    fn a_failure_of_the_world_is_why_a_drive_ended_and_an_end_by_hand_is_none() {
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
