//! Waves of traffic on a ring or in a platoon, step by step. In: speed and position of each vehicle at each step. Out: growth of the
//! waves, their speed and share of variance, and the gain from leader to follower by frequency.
//!
//! Windows of 60 s overlap by half, so that a drive of days takes no more memory than one window and two numbers for each.

mod gain;
mod wave_speed;

pub use gain::{GAIN_HZ, GainSpectrum};
pub use wave_speed::RingWave;

use super::distribution::median;

/// Length of a window for wave speed and gains, s.
const WINDOW_S: f64 = 60.0;
/// Length of a mean of the SD of speed over vehicles, s, for its growth.
const BLOCK_S: f64 = 20.0;

/// Speed and position of a vehicle at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleSample {
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Front bumper along the ring, m; NaN if unknown, and then the window has no wave speed.
    pub position_m: f64,
}

/// Sums of the waves of one drive.
#[derive(Clone, Debug)]
pub struct WaveTotals {
    step_s: f64,
    /// Length of the ring, m; `None` in a platoon, or where it is unknown.
    ring_m: Option<f64>,
    /// Leader of each vehicle by index; `None`: the next vehicle ahead on the ring at the start of a window.
    leaders: Option<Vec<Option<usize>>>,
    /// Steps of the present window, a row per step.
    window: Vec<Vec<VehicleSample>>,
    gains: GainSpectrum,
    waves: Vec<RingWave>,
    /// SD of speed over vehicles: sum and number of steps of the present block, m/s.
    block: (f64, usize),
    /// Mean of the SD over each whole block, m/s.
    block_sds_mps: Vec<f64>,
}

impl WaveTotals {
    /// Starts the sums of a ring, on which each vehicle follows the next one ahead.
    pub fn on_ring(step_s: f64, ring_m: f64) -> Self {
        Self::new(step_s, Some(ring_m), None)
    }

    /// Starts the sums of vehicles with known leaders; without a ring there is no wave speed.
    pub fn with_leaders(step_s: f64, ring_m: Option<f64>, leaders: Vec<Option<usize>>) -> Self {
        Self::new(step_s, ring_m, Some(leaders))
    }

    fn new(step_s: f64, ring_m: Option<f64>, leaders: Option<Vec<Option<usize>>>) -> Self {
        Self {
            step_s,
            ring_m,
            leaders,
            window: Vec::new(),
            gains: GainSpectrum::new(steps_in(WINDOW_S, step_s), step_s),
            waves: Vec::new(),
            block: (0.0, 0),
            block_sds_mps: Vec::new(),
        }
    }

    /// Adds a step. A step with another number of vehicles than the window's begins a new window.
    pub fn add(&mut self, vehicles: impl Iterator<Item = VehicleSample>) {
        let row: Vec<VehicleSample> = vehicles.collect();
        if self.window.first().is_some_and(|first| first.len() != row.len()) {
            self.window.clear();
        }
        self.add_to_block(&row);
        self.window.push(row);
        let steps = steps_in(WINDOW_S, self.step_s);
        if self.window.len() == steps {
            self.finish_window();
            self.window.drain(..steps.div_ceil(2));
        }
    }

    fn add_to_block(&mut self, row: &[VehicleSample]) {
        let n = row.len().max(1) as f64;
        let mean_mps = row.iter().map(|vehicle| vehicle.speed_mps).sum::<f64>() / n;
        let variance = row.iter().map(|vehicle| (vehicle.speed_mps - mean_mps).powi(2)).sum::<f64>() / n;
        self.block = (self.block.0 + variance.sqrt(), self.block.1 + 1);
        if self.block.1 == steps_in(BLOCK_S, self.step_s) {
            let (sum, steps) = std::mem::take(&mut self.block);
            self.block_sds_mps.push(sum / steps as f64);
        }
    }

    fn finish_window(&mut self) {
        let by_position = || leaders_by_position(&self.window[0], self.ring_m);
        let leaders = self.leaders.clone().unwrap_or_else(by_position);
        self.gains.add_window(&self.window, &leaders);
        if let Some(ring_m) = self.ring_m {
            self.waves.extend(RingWave::of(&self.window, self.step_s, ring_m));
        }
    }

    /// Returns the median of speed and share over the windows; `None` below one whole window, without a ring, or without
    /// differences in speed.
    pub fn wave(&self) -> Option<RingWave> {
        let over = |of: fn(&RingWave) -> f64| median(self.waves.iter().map(of).collect());
        Some(RingWave { speed_mps: over(|wave| wave.speed_mps)?, share: over(|wave| wave.share)? })
    }

    /// Returns the waves of all windows, in order of time.
    pub fn windows(&self) -> &[RingWave] {
        &self.waves
    }

    /// Returns the gain from leader to follower at a frequency of [`GAIN_HZ`]; `None` below one whole window, or if no
    /// leader's speed varies.
    pub fn gain(&self, hz: f64) -> Option<f64> {
        self.gains.gain(hz)
    }

    /// Returns the growth of the SD of speed over vehicles, 1/min: slope of its logarithm, by least squares over means of 20 s.
    /// `None` below a minute, or if a mean is 0.
    pub fn growth_per_min(&self) -> Option<f64> {
        let sds_mps = &self.block_sds_mps;
        if sds_mps.len() < 3 || sds_mps.iter().any(|sd| *sd <= 0.0) {
            return None;
        }
        let n = sds_mps.len() as f64;
        let minutes = |i: usize| (i as f64 - (n - 1.0) / 2.0) * BLOCK_S / 60.0;
        let [xy, xx] = sds_mps
            .iter()
            .enumerate()
            .fold([0.0; 2], |[xy, xx], (i, sd)| [xy + minutes(i) * sd.ln(), xx + minutes(i).powi(2)]);
        Some(xy / xx)
    }
}

/// Returns the number of whole steps in a time.
fn steps_in(time_s: f64, step_s: f64) -> usize {
    (time_s / step_s).round().max(1.0) as usize
}

/// Returns the next vehicle ahead of each on the ring.
fn leaders_by_position(row: &[VehicleSample], ring_m: Option<f64>) -> Vec<Option<usize>> {
    let mut leaders = vec![None; row.len()];
    let Some(ring_m) = ring_m else { return leaders };
    let order = wave_speed::order_on_ring(row, ring_m);
    for (k, vehicle) in order.iter().enumerate() {
        leaders[*vehicle] = Some(order[(k + 1) % order.len()]);
    }
    leaders
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
