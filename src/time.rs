//! Clock of the simulation. In: elapsed wall time (from the windows). Out: the number of whole ticks due, and the position of
//! the picture between two ticks. Integers throughout, so that a minute of frames is exactly a minute of ticks.

use std::time::Duration;

/// Ticks in a second of simulation.
pub const TICKS_PER_S: u32 = 100;
/// Length of a tick, seconds.
pub const TICK_S: f64 = 1.0 / TICKS_PER_S as f64;
/// Length of a tick, nanoseconds.
const TICK_NS: u64 = 1_000_000_000 / TICKS_PER_S as u64;
/// Maximum number of ticks that one frame may catch up; the rest of a longer stall is dropped and counted.
pub const MAX_TICKS_PER_FRAME: u64 = 25;

/// Returns true if a duration in seconds is a whole number of ticks, with a tolerance of a nanosecond.
pub fn is_whole_ticks(seconds: f64) -> bool {
    ((seconds / TICK_S).round() * TICK_S - seconds).abs() < 1e-9
}

/// Time of the simulation, in ticks since the start of the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct Tick(pub u64);

impl Tick {
    /// Returns the seconds since the start of the drive.
    pub fn seconds(self) -> f64 {
        self.0 as f64 * TICK_S
    }

    /// Returns the first tick at or after `seconds`, with a tolerance of 1e-9 ticks.
    pub fn at_seconds(seconds: f64) -> Self {
        Self((seconds * f64::from(TICKS_PER_S) - 1e-9).ceil().max(0.0) as u64)
    }
}

/// Relation of simulation time to frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Speed of the wall clock.
    RealTime,
    /// Frames of exactly `1/hz` seconds, whatever the wall clock says (tests, videos).
    FixedRate {
        /// Frames per second of simulation.
        hz: u32,
    },
    /// Full speed of the machine: [`MAX_TICKS_PER_FRAME`] for each frame.
    FullSpeed,
    /// No ticks due; [`Clock::single_step`] still makes a tick due.
    Paused,
}

/// Ticks that one frame has to simulate, and dropped time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DueTicks {
    /// Whole ticks to run now.
    pub ticks: u64,
    /// Time dropped because the frame came too late; zero in a drive without stalls.
    pub dropped: Duration,
}

/// Converter of frames into ticks.
#[derive(Clone, Debug)]
pub struct Clock {
    pace: Pace,
    /// Time not yet turned into ticks, at real time, ns.
    rest_ns: u64,
    /// Time not yet turned into ticks, at a fixed rate, in units of 1/(hz * TICKS_PER_S) s, so that no frame rate is rounded.
    rest_rate: u64,
    extra_ticks: u64,
    dropped: Duration,
    stalls: u64,
}

impl Clock {
    /// Makes a clock at the start of a drive.
    pub fn new(pace: Pace) -> Self {
        Self { pace, rest_ns: 0, rest_rate: 0, extra_ticks: 0, dropped: Duration::ZERO, stalls: 0 }
    }

    /// Returns the present pace.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Changes the pace from the next frame on. The remainder of a tick is kept.
    pub fn set_pace(&mut self, pace: Pace) {
        self.pace = pace;
    }

    /// Makes `ticks` more ticks due at the next frame, at any pace: one step forward while paused.
    pub fn single_step(&mut self, ticks: u64) {
        self.extra_ticks += ticks;
    }

    /// Advances by one frame, `elapsed` after the last. Only [`Pace::RealTime`] uses `elapsed`.
    pub fn advance(&mut self, elapsed: Duration) -> DueTicks {
        let mut due = DueTicks { ticks: std::mem::take(&mut self.extra_ticks), dropped: Duration::ZERO };
        match self.pace {
            Pace::Paused => {}
            Pace::FullSpeed => due.ticks += MAX_TICKS_PER_FRAME,
            Pace::FixedRate { hz } => {
                let hz = u64::from(hz.max(1));
                self.rest_rate += u64::from(TICKS_PER_S);
                due.ticks += self.rest_rate / hz;
                self.rest_rate %= hz;
            }
            Pace::RealTime => {
                let total = self.rest_ns.saturating_add(u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX));
                let ticks = total / TICK_NS;
                self.rest_ns = total % TICK_NS;
                let late = ticks.saturating_sub(MAX_TICKS_PER_FRAME);
                due.ticks += ticks - late;
                if late > 0 {
                    due.dropped = Duration::from_nanos(late.saturating_mul(TICK_NS));
                    self.dropped += due.dropped;
                    self.stalls += 1;
                }
            }
        }
        due
    }

    /// Returns the position of the present frame between the last tick and the next, 0..1; the picture is drawn there.
    pub fn fraction(&self) -> f32 {
        match self.pace {
            Pace::FixedRate { hz } => self.rest_rate as f32 / hz.max(1) as f32,
            _ => self.rest_ns as f32 / TICK_NS as f32,
        }
    }

    /// Returns the total time dropped so far.
    pub fn dropped(&self) -> Duration {
        self.dropped
    }

    /// Returns the number of stalls: frames that dropped time.
    pub fn stalls(&self) -> u64 {
        self.stalls
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_thousand_frames_at_60_hz_are_exactly_100_000_ticks() {
        let mut clock = Clock::new(Pace::FixedRate { hz: 60 });
        let ticks: u64 = (0..60_000).map(|_| clock.advance(Duration::ZERO).ticks).sum();
        assert_eq!(ticks, 100_000);
        assert_eq!(clock.fraction(), 0.0);
    }

    #[test]
    fn real_time_loses_nothing_to_rounding() {
        // 60 Hz in whole nanoseconds: 16,666,667 ns, 40 ns too much in 120 frames, never a tick.
        let mut clock = Clock::new(Pace::RealTime);
        let frame = Duration::from_nanos(16_666_667);
        let ticks: u64 = (0..60_000).map(|_| clock.advance(frame).ticks).sum();
        assert_eq!(ticks, 60_000 * 16_666_667 / TICK_NS);
        assert_eq!(clock.dropped(), Duration::ZERO);
    }

    #[test]
    fn a_stall_drops_time_and_counts_it() {
        let mut clock = Clock::new(Pace::RealTime);
        let due = clock.advance(Duration::from_millis(1_005));
        assert_eq!(due.ticks, MAX_TICKS_PER_FRAME);
        assert_eq!(due.dropped, Duration::from_millis(1_000 - 10 * MAX_TICKS_PER_FRAME));
        assert_eq!(clock.dropped(), due.dropped);
        assert_eq!(clock.stalls(), 1);
        assert_eq!(clock.fraction(), 0.5, "what is less than a tick is kept");
    }

    #[test]
    fn a_paused_clock_moves_by_single_steps_only() {
        let mut clock = Clock::new(Pace::Paused);
        assert_eq!(clock.advance(Duration::from_secs(5)).ticks, 0);
        clock.single_step(1);
        assert_eq!(clock.advance(Duration::from_secs(5)).ticks, 1);
        assert_eq!(clock.advance(Duration::from_secs(5)), DueTicks::default());
        assert_eq!(clock.dropped(), Duration::ZERO);
    }

    #[test]
    fn a_time_in_seconds_becomes_the_first_tick_not_before_it() {
        assert_eq!(Tick::at_seconds(0.0), Tick(0));
        assert_eq!(Tick::at_seconds(0.1), Tick(10));
        assert_eq!(Tick::at_seconds(0.101), Tick(11));
        assert_eq!(Tick(12_345).seconds(), 123.45);
    }
}
