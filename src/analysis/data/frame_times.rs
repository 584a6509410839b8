//! Times of the frames that a participant saw. In: the table of frames, from front to back. Out: frame rate, longest frame, time given
//! up, and the latency of inputs. A drive without a window has no frames.

use super::thinned_values::ThinnedValues;
use crate::record::{RecordError, TableParts};

/// Largest number of latencies that are kept: nine hours at 60 Hz. Of a longer drive every second, fourth, ... is kept.
const MOST_LATENCIES: usize = 2_000_000;
/// Latency above which an input is late, s: the largest 99th percentile of a good rig (docs/references.md: display).
pub const LATE_S: f64 = 0.07;

/// Columns of the table of frames that are read.
pub(super) const COLUMNS: [&str; 3] = ["elapsed_s", "latency_s", "dropped_s"];

/// Times of the frames of one drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Latencies from an input to the frame that showed it, s, if the device has time stamps; sorted.
    pub latencies_s: Vec<f64>,
    /// Share of these latencies above [`LATE_S`]; `None` without any.
    pub late_input_share: Option<f64>,
    /// Simulated time given up because frames came too late, s; `None` if no frame was shown.
    pub dropped_s: Option<f64>,
    /// Frames per second of wall time, 1/s; `None` with fewer than two frames.
    pub frames_per_s: Option<f64>,
    /// Longest time from one frame to the next, s; `None` with fewer than two frames.
    pub longest_frame_s: Option<f64>,
}

impl FrameTimes {
    /// Reads the table of frames, which has [`COLUMNS`].
    pub(super) fn read(parts: TableParts) -> Result<Self, RecordError> {
        let mut sums = FrameSums::new();
        for part in parts {
            let part = part?;
            let [elapsed, latency, dropped] = COLUMNS.map(|name| part.numbers(name));
            for ((elapsed_s, latency_s), dropped_s) in elapsed.into_iter().zip(latency).zip(dropped) {
                sums.add([elapsed_s, latency_s, dropped_s]);
            }
        }
        Ok(sums.times())
    }
}

/// Sums over the frames so far.
struct FrameSums {
    latencies: ThinnedValues<f64>,
    latency_count: u64,
    late_count: u64,
    dropped_s: Option<f64>,
    frames: u64,
    wall_s: f64,
    longest_s: f64,
}

impl FrameSums {
    fn new() -> Self {
        Self {
            latencies: ThinnedValues::new(MOST_LATENCIES),
            latency_count: 0,
            late_count: 0,
            dropped_s: None,
            frames: 0,
            wall_s: 0.0,
            longest_s: 0.0,
        }
    }

    /// Adds a frame with its [`COLUMNS`].
    fn add(&mut self, [elapsed_s, latency_s, dropped_s]: [Option<f64>; 3]) {
        if let Some(latency_s) = latency_s {
            self.latencies.push(latency_s);
            self.latency_count += 1;
            self.late_count += u64::from(latency_s > LATE_S);
        }
        if let Some(dropped_s) = dropped_s {
            *self.dropped_s.get_or_insert(0.0) += dropped_s;
        }
        // The first frame has no frame before it.
        let elapsed_s = elapsed_s.filter(|_| self.frames > 0).unwrap_or_default();
        self.wall_s += elapsed_s;
        self.longest_s = self.longest_s.max(elapsed_s);
        self.frames += 1;
    }

    fn times(mut self) -> FrameTimes {
        self.latencies.values.sort_by(f64::total_cmp);
        let has_interval = self.wall_s > 0.0;
        FrameTimes {
            latencies_s: self.latencies.values,
            late_input_share: (self.latency_count > 0).then(|| self.late_count as f64 / self.latency_count as f64),
            dropped_s: self.dropped_s,
            frames_per_s: has_interval.then(|| (self.frames - 1) as f64 / self.wall_s),
            longest_frame_s: has_interval.then_some(self.longest_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_over_wall_time_and_the_first_frame_has_no_length() {
        let mut sums = FrameSums::new();
        let frames = [
            [Some(5.0), None, Some(0.0)],
            [Some(0.02), Some(0.5), Some(0.0)],
            [Some(0.48), Some(0.03), Some(0.25)],
            [Some(0.5), Some(0.07), Some(0.25)],
        ];
        frames.into_iter().for_each(|frame| sums.add(frame));
        let times = sums.times();
        // Three frames in a second; one of three latencies is above 0.07 s.
        assert_eq!((times.frames_per_s, times.longest_frame_s, times.dropped_s), (Some(3.0), Some(0.5), Some(0.5)));
        assert_eq!((times.latencies_s, times.late_input_share), (vec![0.03, 0.07, 0.5], Some(1.0 / 3.0)));
        assert_eq!(FrameSums::new().times(), FrameTimes::default());
    }
}
