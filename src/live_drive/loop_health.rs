//! Health of the drive loop, for the experimenter's lamps. In: the times of every frame. Out: a [`DriveHealth`].

use super::LiveDrive;
use crate::{
    panel::{
        DrivePhase,
        experimenter::{DriveHealth, RecordingHealth, WheelHealth},
    },
    time::Pace,
};
use std::{collections::VecDeque, time::Duration};

/// Length of the window for frame times.
const LATELY: Duration = Duration::from_millis(1500);
/// Age up to which dropped time counts as recent.
const FRESH: Duration = Duration::from_secs(10);

/// Times of the last frames.
#[derive(Debug, Default)]
pub struct LoopHealth {
    /// Times from one frame to the next, newest last, and their sum.
    frames: VecDeque<Duration>,
    sum: Duration,
    /// Time of the drive loop, and the dropped times with their moments.
    now: Duration,
    drops: VecDeque<(Duration, Duration)>,
    dropped: Duration,
    had_wheel: bool,
}

impl LoopHealth {
    /// Adds a frame that was shown `elapsed` after the one before, of which `dropped` was skipped.
    pub fn frame(&mut self, elapsed: Duration, dropped: Duration) {
        self.now += elapsed;
        if !elapsed.is_zero() {
            self.frames.push_back(elapsed);
            self.sum += elapsed;
        }
        while self.frames.len() > 1 && self.sum > LATELY {
            self.sum -= self.frames.pop_front().unwrap_or_default();
        }
        if !dropped.is_zero() {
            self.dropped += dropped;
            self.drops.push_back((self.now, dropped));
        }
        while self.drops.front().is_some_and(|(at, _)| self.now - *at > FRESH) {
            self.drops.pop_front();
        }
    }

    /// Begins the counts of another drive. Frame times are those of the last moments, and a wheel that was lost stays lost.
    pub fn restart(&mut self) {
        self.drops.clear();
        self.dropped = Duration::ZERO;
    }

    /// Returns the mean time from frame to frame, ms.
    pub fn frame_ms(&self) -> f64 {
        ms(self.sum) / self.frames.len().max(1) as f64
    }

    /// Returns the state for the experimenter's lamps.
    pub fn health(&mut self, live: &LiveDrive, engine: &str, error: Option<&str>) -> DriveHealth {
        let longest = self.frames.iter().max().copied().unwrap_or_default();
        let fresh: Duration = self.drops.iter().map(|(_, dropped)| *dropped).sum();
        DriveHealth {
            frame_ms: [self.frame_ms(), ms(longest)],
            dropped_s: [self.dropped.as_secs_f64(), fresh.as_secs_f64()],
            latency_ms: live.latency().input_to_frame().map(|spread| [spread.median_s, spread.p99_s].map(|s| 1e3 * s)),
            will_record: false,
            recording: live.writer_status().map(|writer_status| RecordingHealth {
                waiting: writer_status.waiting(),
                free_gb: writer_status.free_bytes().map(|bytes| bytes as f64 / 1e9),
            }),
            wheel: self.wheel(live),
            contacts: live.contacts().health(),
            engine: engine.to_owned(),
            error: error.map(str::to_owned),
        }
    }

    fn wheel(&mut self, live: &LiveDrive) -> WheelHealth {
        match live.devices.wheel_profile() {
            Some(profile) => {
                self.had_wheel = true;
                WheelHealth::There(profile.name.clone())
            }
            None if self.had_wheel => WheelHealth::Lost,
            None => WheelHealth::None,
        }
    }
}

/// Returns the phase of a drive for the panels.
pub fn phase(live: &LiveDrive) -> DrivePhase {
    match live.drive.clock.pace() {
        _ if live.starting().is_some() => DrivePhase::Starting,
        _ if live.is_stopped() => DrivePhase::Ended,
        _ if live.drive.world.ended().is_some() => DrivePhase::Ended,
        Pace::Paused if live.drive.world.snapshot().tick.0 == 0 => DrivePhase::Ready,
        Pace::Paused => DrivePhase::Paused,
        _ => DrivePhase::Running,
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Duration = Duration::from_millis(20);

    #[test]
    fn frame_times_cover_the_last_1_5_s() {
        let mut loop_health = LoopHealth::default();
        loop_health.frame(Duration::from_millis(900), Duration::ZERO);
        (0..20).for_each(|_| loop_health.frame(FRAME, Duration::ZERO));
        assert!(loop_health.frames.contains(&Duration::from_millis(900)));
        (0..80).for_each(|_| loop_health.frame(FRAME, Duration::ZERO));
        assert_eq!(loop_health.frame_ms(), 20.0);
    }

    #[test]
    fn the_window_holds_1_5_s_of_frames_including_its_end() {
        let mut loop_health = LoopHealth::default();
        (0..75).for_each(|_| loop_health.frame(FRAME, Duration::ZERO));
        assert_eq!((loop_health.frames.len(), loop_health.sum), (75, LATELY));
        loop_health.frame(FRAME, Duration::ZERO);
        assert_eq!((loop_health.frames.len(), loop_health.sum), (75, LATELY));
        // A frame longer than the window is its only frame.
        loop_health.frame(Duration::from_secs(2), Duration::ZERO);
        assert_eq!((loop_health.frames.len(), loop_health.frame_ms()), (1, 2000.0));
    }

    #[test]
    fn dropped_time_counts_from_the_start_of_the_present_drive() {
        let mut loop_health = LoopHealth::default();
        loop_health.frame(FRAME, Duration::from_millis(300));
        loop_health.restart();
        assert!(loop_health.drops.is_empty() && loop_health.dropped.is_zero());
        assert_eq!(loop_health.frame_ms(), 20.0, "the picture goes on");
        loop_health.frame(FRAME, Duration::from_millis(100));
        assert_eq!(loop_health.dropped, Duration::from_millis(100));
    }

    #[test]
    fn dropped_time_is_recent_for_ten_seconds_and_stays_in_the_total() {
        let mut loop_health = LoopHealth::default();
        loop_health.frame(FRAME, Duration::from_millis(300));
        let fresh = |loop_health: &LoopHealth| loop_health.drops.iter().map(|(_, dropped)| *dropped).sum::<Duration>();
        (0..500).for_each(|_| loop_health.frame(FRAME, Duration::ZERO));
        assert_eq!(fresh(&loop_health), Duration::from_millis(300));
        loop_health.frame(FRAME, Duration::ZERO);
        assert_eq!(fresh(&loop_health), Duration::ZERO);
        assert_eq!(loop_health.dropped, Duration::from_millis(300));
    }
}
