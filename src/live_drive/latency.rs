//! Latencies of the last seconds. In: for each frame the times from input to tick, from input to the hand-over of the
//! frame, and from frame to frame. Out: medians and 99th percentiles, as numbers and text.

use crate::input::TimeStamp;
use std::{collections::VecDeque, time::Duration};

/// Length of a window in frames: 10 s at 60 Hz.
const FRAMES: usize = 600;
/// Number of screen periods above which a frame is late: the screen showed the frame before it twice.
const LATE: f64 = 1.5;

/// Sliding window over the durations of the last 600 frames, s.
#[derive(Clone, Debug, Default)]
pub struct SlidingWindow(VecDeque<f64>);

/// Distribution of the durations in a window, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DurationSpread {
    pub median_s: f64,
    /// 99th percentile of the durations.
    pub p99_s: f64,
    /// Number of durations in the window.
    pub count: usize,
}

impl SlidingWindow {
    /// Adds a duration and drops the oldest one from a full window.
    pub fn add(&mut self, seconds: f64) {
        if self.0.len() == FRAMES {
            self.0.pop_front();
        }
        self.0.push_back(seconds);
    }

    /// Returns median and 99th percentile; `None` for an empty window.
    pub fn spread(&self) -> Option<DurationSpread> {
        let mut sorted: Vec<f64> = self.0.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted.get(((sorted.len().max(1) - 1) as f64 * share).round() as usize).copied();
        Some(DurationSpread { median_s: at(0.5)?, p99_s: at(0.99)?, count: sorted.len() })
    }
}

/// Latencies of the last frames.
#[derive(Clone, Debug, Default)]
pub struct Latency {
    input_to_tick: SlidingWindow,
    input_to_frame: SlidingWindow,
    frames: SlidingWindow,
    /// Period of the screen, s, if the system reports its rate.
    period_s: Option<f64>,
    present_mode: String,
}

impl Latency {
    /// Sets the screen's refresh rate, Hz, if it is known, and the name of the present mode.
    pub fn screen(&mut self, refresh_hz: Option<f64>, present_mode: &str) {
        self.period_s = refresh_hz.filter(|hz| *hz > 0.0).map(|hz| 1.0 / hz);
        self.present_mode = present_mode.into();
    }

    /// Adds a frame that was handed over `elapsed` after the one before. `input` is given if the frame used a
    /// time-stamped input: the times from the input to the tick and to the hand-over, s.
    pub fn frame(&mut self, elapsed: Duration, input: Option<[f64; 2]>) {
        if !elapsed.is_zero() {
            self.frames.add(elapsed.as_secs_f64());
        }
        if let Some([to_tick_s, to_frame_s]) = input {
            self.input_to_tick.add(to_tick_s);
            self.input_to_frame.add(to_frame_s);
        }
    }

    /// Returns the time from the kernel's time stamp of an input to the tick that used it.
    pub fn input_to_tick(&self) -> Option<DurationSpread> {
        self.input_to_tick.spread()
    }

    /// Returns the time from the kernel's time stamp of an input to the hand-over of the frame that shows it.
    pub fn input_to_frame(&self) -> Option<DurationSpread> {
        self.input_to_frame.spread()
    }

    /// Returns the share of late frames, longer than 1.5 screen periods; `None` without frames or refresh rate.
    pub fn late(&self) -> Option<f64> {
        let period_s = self.period_s?;
        let late = self.frames.0.iter().filter(|frame_s| **frame_s > LATE * period_s).count();
        (!self.frames.0.is_empty()).then(|| late as f64 / self.frames.0.len() as f64)
    }

    /// Returns the lines for the corner of the picture.
    pub fn lines(&self) -> Vec<String> {
        let both =
            |spread: DurationSpread| format!("{:.1} ms, 99 % below {:.1}", 1e3 * spread.median_s, 1e3 * spread.p99_s);
        let mut lines = Vec::new();
        let late = self.late().map_or(String::new(), |late| format!(", {:.1} % late", 100.0 * late));
        let rate = self.period_s.map_or("rate unknown".into(), |s| format!("{:.1} Hz", 1.0 / s));
        if let Some(frames) = self.frames.spread() {
            let a_second = 1.0 / frames.median_s.max(1e-6);
            lines.push(format!(
                "frame {}{late}, {a_second:.0} per second; screen {rate}, {}",
                both(frames),
                self.present_mode
            ));
        }
        lines.push(match (self.input_to_tick(), self.input_to_frame()) {
            (Some(tick), Some(frame)) => format!("input to tick {}; to frame {}", both(tick), both(frame)),
            _ => "input to frame: no timed input yet (keyboards give none)".into(),
        });
        lines
    }
}

/// Input that a tick has used.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedInput {
    /// Kernel time stamp of the input.
    at: TimeStamp,
    /// Time at which the tick used it.
    ticked: TimeStamp,
}

/// Measures the latency of inputs from the kernel to the frame that shows them.
#[derive(Clone, Debug, Default)]
pub struct InputLatency {
    /// Time stamp of the newest input that no tick has used yet, and the oldest used one that no frame has shown yet.
    unused: Option<TimeStamp>,
    pub(super) used: Option<UsedInput>,
    lately: Latency,
}

impl InputLatency {
    /// Notes the time stamp of the devices' newest input, if there is one.
    pub(super) fn read(&mut self, newest: Option<TimeStamp>) {
        self.unused = self.unused.max(newest);
    }

    /// Notes that a tick began at this time and used the newest input.
    pub(super) fn used(&mut self, ticked: TimeStamp) {
        let used = self.unused.take().map(|at| UsedInput { at, ticked });
        self.used = self.used.or(used);
    }

    /// Notes that a frame was handed over, `elapsed` after the one before. Returns the times from its input to the tick
    /// and to now, s.
    pub(super) fn shown(&mut self, elapsed: Duration) -> [Option<f64>; 2] {
        let used = self.used.take();
        let to_tick_s = used.map(|input| input.at.until(input.ticked).as_secs_f64());
        let to_frame_s = used.map(|input| input.at.until(TimeStamp::now()).as_secs_f64());
        self.lately.frame(elapsed, to_tick_s.zip(to_frame_s).map(|(tick, frame)| [tick, frame]));
        [to_tick_s, to_frame_s]
    }

    pub(super) fn screen(&mut self, refresh_hz: Option<f64>, present_mode: &str) {
        self.lately.screen(refresh_hz, present_mode);
    }

    pub(super) fn recent(&self) -> &Latency {
        &self.lately
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_percentile_are_of_the_last_600_frames() {
        let mut window = SlidingWindow::default();
        assert_eq!(window.spread(), None);
        (0..1000).for_each(|_| window.add(9.0));
        (1..=600).for_each(|i| window.add(f64::from(i)));
        let spread = window.spread().unwrap();
        assert_eq!((spread.median_s, spread.p99_s, spread.count), (301.0, 594.0, 600));
    }

    #[test]
    fn a_frame_that_the_screen_showed_twice_is_late() {
        let mut latency = Latency::default();
        assert_eq!(latency.late(), None);
        latency.screen(Some(50.0), "fifo");
        for frame_ms in [20, 20, 21, 40] {
            latency.frame(Duration::from_millis(frame_ms), None);
        }
        assert_eq!(latency.late(), Some(0.25));
        // Exactly 1.5 periods of 20 ms, and slightly more.
        let late = |frame_us| {
            let mut one = Latency::default();
            one.screen(Some(50.0), "fifo");
            one.frame(Duration::from_micros(frame_us), None);
            one.late()
        };
        assert_eq!((late(30_000), late(30_001)), (Some(0.0), Some(1.0)));
        let words = latency.lines().join("\n");
        assert!(
            words.contains("25.0 % late, 48 per second; screen 50.0 Hz, fifo")
                && words.contains("no timed input yet (keyboards give none)"),
            "{words}"
        );
        latency.frame(Duration::from_millis(20), Some([0.004, 0.013]));
        assert!(latency.lines()[1].contains("input to tick 4.0 ms, 99 % below 4.0; to frame 13.0 ms"));
        // The first frame has no time since a frame before it.
        latency.frame(Duration::ZERO, None);
        assert_eq!(latency.late(), Some(0.2));
        // A system that does not report the screen's rate.
        for unknown in [None, Some(0.0), Some(-1.0)] {
            latency.screen(unknown, "immediate");
            assert_eq!(latency.late(), None);
            assert!(
                latency.lines()[0].ends_with("50 per second; screen rate unknown, immediate"),
                "{:?}",
                latency.lines()
            );
        }
    }
}
