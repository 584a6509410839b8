//! How the loop does, for the experimenter's lamps. In: every frame's times. Out: a [`Health`].

use super::Show;
use crate::panel::experimenter::{Health, RecordingHealth, WheelHealth};
use std::{collections::VecDeque, time::Duration};

/// Time over which frame times are looked at.
const LATELY: Duration = Duration::from_millis(1500);
/// Time over which dropped time counts as fresh.
const FRESH: Duration = Duration::from_secs(10);
/// Latencies that are looked at: half a minute of a hand that moves.
const LATENCIES: usize = 1000;

/// Times of the last frames.
#[derive(Debug, Default)]
pub struct Pulse {
    /// Time from one frame to the next, newest last, and their sum.
    frames: VecDeque<Duration>,
    sum: Duration,
    /// Time of the loop, and when time was dropped.
    now: Duration,
    drops: VecDeque<(Duration, Duration)>,
    dropped: Duration,
    latencies: VecDeque<Duration>,
    had_wheel: bool,
}

impl Pulse {
    /// A frame was shown, `elapsed` after the one before; `dropped` of that was given up, and it shows an input that is
    /// `latency` old.
    pub fn frame(&mut self, elapsed: Duration, dropped: Duration, latency: Option<Duration>) {
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
        self.latencies.extend(latency);
        while self.latencies.len() > LATENCIES {
            self.latencies.pop_front();
        }
    }

    /// Mean time from frame to frame, milliseconds.
    pub fn frame_ms(&self) -> f64 {
        ms(self.sum) / self.frames.len().max(1) as f64
    }

    /// What the lamps show.
    pub fn health(&mut self, show: &Show, engine: &str, error: Option<&str>) -> Health {
        let longest = self.frames.iter().max().copied().unwrap_or_default();
        let fresh: Duration = self.drops.iter().map(|(_, dropped)| *dropped).sum();
        Health {
            frame_ms: [self.frame_ms(), ms(longest)],
            dropped_s: [self.dropped.as_secs_f64(), fresh.as_secs_f64()],
            latency_ms: self.latency_ms(),
            recording: show.gauge().map(|gauge| RecordingHealth {
                waiting: gauge.waiting(),
                free_gb: gauge.free_bytes().map(|bytes| bytes as f64 / 1e9),
            }),
            wheel: self.wheel(show),
            engine: engine.to_owned(),
            error: error.map(str::to_owned),
        }
    }

    fn latency_ms(&self) -> Option<[f64; 2]> {
        let mut sorted: Vec<Duration> = self.latencies.iter().copied().collect();
        sorted.sort_unstable();
        let last = sorted.len().checked_sub(1)?;
        Some([0.5, 0.99].map(|share| ms(sorted[(share * last as f64).round() as usize])))
    }

    fn wheel(&mut self, show: &Show) -> WheelHealth {
        match show.devices.wheel_profile() {
            Some(profile) => {
                self.had_wheel = true;
                WheelHealth::There(profile.name.clone())
            }
            None if self.had_wheel => WheelHealth::Lost,
            None => WheelHealth::None,
        }
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
    fn frame_times_are_those_of_the_last_second_and_a_half() {
        let mut pulse = Pulse::default();
        pulse.frame(Duration::from_millis(900), Duration::ZERO, None);
        (0..20).for_each(|_| pulse.frame(FRAME, Duration::ZERO, None));
        assert!(pulse.frames.contains(&Duration::from_millis(900)));
        (0..80).for_each(|_| pulse.frame(FRAME, Duration::ZERO, None));
        assert_eq!(pulse.frame_ms(), 20.0);
    }

    #[test]
    fn dropped_time_is_fresh_for_ten_seconds_and_never_forgotten() {
        let mut pulse = Pulse::default();
        pulse.frame(FRAME, Duration::from_millis(300), None);
        let fresh = |pulse: &Pulse| pulse.drops.iter().map(|(_, dropped)| *dropped).sum::<Duration>();
        (0..500).for_each(|_| pulse.frame(FRAME, Duration::ZERO, None));
        assert_eq!(fresh(&pulse), Duration::from_millis(300));
        pulse.frame(FRAME, Duration::ZERO, None);
        assert_eq!(fresh(&pulse), Duration::ZERO);
        assert_eq!(pulse.dropped, Duration::from_millis(300));
    }

    #[test]
    fn latency_is_the_median_and_the_99th_percentile() {
        let mut pulse = Pulse::default();
        assert_eq!(pulse.latency_ms(), None);
        (1..=101).for_each(|i| pulse.frame(FRAME, Duration::ZERO, Some(Duration::from_millis(i))));
        assert_eq!(pulse.latency_ms(), Some([51.0, 100.0]));
    }
}
