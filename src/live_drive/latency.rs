//! Latencies of the last seconds. In: for each frame the times from input to tick, from input to the frame's handing over,
//! and from frame to frame. Out: medians and 99th percentiles, in words.

use crate::input::TimeStamp;
use std::{collections::VecDeque, time::Duration};

/// Frames that are looked back on: ten seconds at 60 Hz.
const FRAMES: usize = 600;
/// A frame that stood for more than so many of the screen's periods was seen twice.
const LATE: f64 = 1.5;

/// A sliding window of durations.
#[derive(Clone, Debug, Default)]
pub struct SlidingWindow(VecDeque<f64>);

/// What a window holds, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DurationSpread {
    /// Half are below.
    pub median_s: f64,
    /// All but one of a hundred are below or there.
    pub p99_s: f64,
    /// How many there are.
    pub count: usize,
}

impl SlidingWindow {
    /// Adds one, and lets the oldest go.
    pub fn add(&mut self, seconds: f64) {
        if self.0.len() == FRAMES {
            self.0.pop_front();
        }
        self.0.push_back(seconds);
    }

    /// Median and 99th percentile; `None` while it is empty.
    pub fn spread(&self) -> Option<DurationSpread> {
        let mut sorted: Vec<f64> = self.0.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted.get(((sorted.len().max(1) - 1) as f64 * share).round() as usize).copied();
        Some(DurationSpread { median_s: at(0.5)?, p99_s: at(0.99)?, count: sorted.len() })
    }
}

/// All that is known of delays.
#[derive(Clone, Debug, Default)]
pub struct Latency {
    input_to_tick: SlidingWindow,
    input_to_frame: SlidingWindow,
    frames: SlidingWindow,
    /// The screen's period, seconds, where the system tells its rate.
    period_s: Option<f64>,
    present_mode: String,
}

impl Latency {
    /// The screen's refresh rate in Hz, where it is known, and how pictures are handed to it.
    pub fn screen(&mut self, refresh_hz: Option<f64>, present_mode: &str) {
        self.period_s = refresh_hz.filter(|hz| *hz > 0.0).map(|hz| 1.0 / hz);
        self.present_mode = present_mode.into();
    }

    /// A frame was handed over, `elapsed` after the one before. `input` is what it used, if a device told a time: from
    /// there to the tick and to the handing over, seconds.
    pub fn frame(&mut self, elapsed: Duration, input: Option<[f64; 2]>) {
        if !elapsed.is_zero() {
            self.frames.add(elapsed.as_secs_f64());
        }
        if let Some([to_tick_s, to_frame_s]) = input {
            self.input_to_tick.add(to_tick_s);
            self.input_to_frame.add(to_frame_s);
        }
    }

    /// From the kernel's time of an input to the tick that used it.
    pub fn input_to_tick(&self) -> Option<DurationSpread> {
        self.input_to_tick.spread()
    }

    /// From the kernel's time of an input to the handing over of the frame that shows it.
    pub fn input_to_frame(&self) -> Option<DurationSpread> {
        self.input_to_frame.spread()
    }

    /// Share of frames that stood for more than one and a half of the screen's periods.
    pub fn late(&self) -> Option<f64> {
        let period_s = self.period_s?;
        let late = self.frames.0.iter().filter(|frame_s| **frame_s > LATE * period_s).count();
        (!self.frames.0.is_empty()).then(|| late as f64 / self.frames.0.len() as f64)
    }

    /// Lines for the corner of the picture.
    pub fn words(&self) -> Vec<String> {
        let both =
            |spread: DurationSpread| format!("{:.1} ms, 99 % below {:.1}", 1e3 * spread.median_s, 1e3 * spread.p99_s);
        let mut lines = Vec::new();
        let late = self.late().map_or(String::new(), |late| format!(", {:.1} % late", 100.0 * late));
        let rate = self.period_s.map_or("rate unknown".into(), |s| format!("{:.1} Hz", 1.0 / s));
        if let Some(frames) = self.frames.spread() {
            let a_second = 1.0 / frames.median_s.max(1e-6);
            lines.push(format!(
                "frame {}{late}, {a_second:.0} a second; screen {rate}, {}",
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

/// An input that a tick has used.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedInput {
    /// The kernel's time of it.
    at: TimeStamp,
    /// When the tick used it.
    ticked: TimeStamp,
}

/// Follows each input from the kernel to the frame that shows it.
#[derive(Clone, Debug, Default)]
pub struct InputLatency {
    /// Time of the newest input that no tick has used yet, and the oldest used one that no frame has shown yet.
    unused: Option<TimeStamp>,
    pub(super) used: Option<UsedInput>,
    lately: Latency,
}

impl InputLatency {
    /// The devices were read: the time of their newest input, if they tell one.
    pub(super) fn read(&mut self, newest: Option<TimeStamp>) {
        self.unused = self.unused.max(newest);
    }

    /// A tick began at this time, and has used what was read.
    pub(super) fn used(&mut self, ticked: TimeStamp) {
        let used = self.unused.take().map(|at| UsedInput { at, ticked });
        self.used = self.used.or(used);
    }

    /// A frame was handed over, `elapsed` after the one before. From the input that it shows to the tick, and to now, seconds.
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
    fn median_and_percentile_are_of_the_last_six_hundred() {
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
        // One and a half periods of 20 ms, and the least more.
        let late = |frame_us| {
            let mut one = Latency::default();
            one.screen(Some(50.0), "fifo");
            one.frame(Duration::from_micros(frame_us), None);
            one.late()
        };
        assert_eq!((late(30_000), late(30_001)), (Some(0.0), Some(1.0)));
        let words = latency.words().join("\n");
        assert!(
            words.contains("25.0 % late, 48 a second; screen 50.0 Hz, fifo")
                && words.contains("no timed input yet (keyboards give none)"),
            "{words}"
        );
        latency.frame(Duration::from_millis(20), Some([0.004, 0.013]));
        assert!(latency.words()[1].contains("input to tick 4.0 ms, 99 % below 4.0; to frame 13.0 ms"));
        // A frame without a time before it is none.
        latency.frame(Duration::ZERO, None);
        assert_eq!(latency.late(), Some(0.2));
        // A system that does not tell the screen's rate.
        for unknown in [None, Some(0.0), Some(-1.0)] {
            latency.screen(unknown, "immediate");
            assert_eq!(latency.late(), None);
            assert!(
                latency.words()[0].ends_with("50 a second; screen rate unknown, immediate"),
                "{:?}",
                latency.words()
            );
        }
    }
}
