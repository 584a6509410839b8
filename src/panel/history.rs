//! Speeds since the start of the drive, for the plot. In: one sample a step. Out: at most [`SpeedHistory::CAPACITY`]
//! samples over the whole drive, evenly spaced: when full, neighbours are averaged and the spacing doubles. Seconds,
//! m/s.

/// Speeds at one time, or their means over the short interval that ends then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedSample {
    /// Time since the start of the drive, seconds.
    pub time_s: f64,
    /// Mean speed of all vehicles, m/s.
    pub mean_mps: f64,
    /// Speed of the ego, m/s.
    pub ego_mps: f64,
    /// Latest advised speed, m/s; `None` without advice.
    pub target_mps: Option<f64>,
}

/// Bounded record of a drive of any length.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedHistory {
    samples: Vec<SpeedSample>,
    /// Number of pushes averaged into one sample.
    stride: u32,
    /// Incomplete sample, with sums instead of means, and the number of its pushes.
    block: Option<(SpeedSample, u32)>,
}

impl Default for SpeedHistory {
    fn default() -> Self {
        Self { samples: Vec::new(), stride: 1, block: None }
    }
}

impl SpeedHistory {
    /// Maximum number of samples: more than the plot has pixels across.
    pub const CAPACITY: usize = 1200;

    /// Adds the speeds at `time_s`. A time before the last one starts a new drive: all samples are cleared.
    pub fn push(&mut self, time_s: f64, mean_mps: f64, ego_mps: f64, target_mps: Option<f64>) {
        let latest = self.block.map(|(sample, _)| sample).or(self.samples.last().copied());
        if latest.is_some_and(|sample| time_s < sample.time_s) {
            self.clear();
        }
        let (sum, count) = self.block.unwrap_or((SpeedSample { time_s, mean_mps: 0.0, ego_mps: 0.0, target_mps }, 0));
        let sum = SpeedSample { time_s, mean_mps: sum.mean_mps + mean_mps, ego_mps: sum.ego_mps + ego_mps, target_mps };
        let count = count + 1;
        if count < self.stride {
            self.block = Some((sum, count));
            return;
        }
        self.block = None;
        let share = 1.0 / f64::from(count);
        self.samples.push(SpeedSample { mean_mps: sum.mean_mps * share, ego_mps: sum.ego_mps * share, ..sum });
        if self.samples.len() == Self::CAPACITY {
            self.thin();
        }
    }

    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Returns the complete samples, oldest first.
    pub fn samples(&self) -> &[SpeedSample] {
        &self.samples
    }

    fn thin(&mut self) {
        self.samples = self
            .samples
            .chunks_exact(2)
            .map(|pair| SpeedSample {
                mean_mps: (pair[0].mean_mps + pair[1].mean_mps) / 2.0,
                ego_mps: (pair[0].ego_mps + pair[1].ego_mps) / 2.0,
                ..pair[1]
            })
            .collect();
        self.stride *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_drive_stays_bounded_evenly_spaced_and_keeps_its_mean() {
        let mut history = SpeedHistory::default();
        // An hour of steps.
        for i in 0..36_000 {
            history.push(f64::from(i) * 0.1, f64::from(i % 7), 5.0, Some(4.0));
            assert!(history.samples().len() < SpeedHistory::CAPACITY);
        }
        let samples = history.samples();
        assert!(samples.len() >= SpeedHistory::CAPACITY / 2, "{}", samples.len());
        let spacing = samples[1].time_s - samples[0].time_s;
        assert!(samples.windows(2).all(|pair| (pair[1].time_s - pair[0].time_s - spacing).abs() < 1e-6));
        assert!(samples.iter().all(|sample| (sample.ego_mps - 5.0).abs() < 1e-9));
        let mean = samples.iter().map(|sample| sample.mean_mps).sum::<f64>() / samples.len() as f64;
        assert!((mean - 3.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn a_new_drive_starts_a_new_record() {
        let mut history = SpeedHistory::default();
        for i in 0..100 {
            history.push(f64::from(i) * 0.1, 4.0, 4.0, None);
        }
        history.push(0.0, 1.0, 1.0, None);
        assert_eq!(history.samples(), [SpeedSample { time_s: 0.0, mean_mps: 1.0, ego_mps: 1.0, target_mps: None }]);
    }
}
