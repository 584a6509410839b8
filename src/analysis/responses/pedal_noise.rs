//! Idle movements of a person's pedals. In: pedals (accelerator less brake) tick by tick. Out: a threshold that these movements
//! seldom exceed, as a share of travel.
//!
//! A movement is the distance of the pedals, in one direction, from their extreme position the other way within the last
//! [`WINDOW_S`]. It is taken at every tick without a pending request, in both directions. The threshold is the 95th percentile of
//! all movements, at least [`LEAST`]. The detector of responses takes its movements over the same window.

use crate::time::TICKS_PER_S;
use std::collections::VecDeque;

/// Length of the window, seconds: enough for a deliberate movement of a foot, even a slow one.
pub const WINDOW_S: f64 = 1.0;
/// Smallest threshold, share of travel: pedals of ten bits and a resting foot move by less.
pub const LEAST: f64 = 0.01;
/// Share of idle movements that stay below the threshold.
pub const SHARE: f64 = 0.95;
/// Minimum time of idle pedals for a percentile, seconds.
pub const ENOUGH_S: f64 = 20.0;
/// Number of bins over two travels (brake floored to accelerator floored).
const BINS: usize = 2000;

/// Pedals of the last [`WINDOW_S`], with their extremes.
#[derive(Clone, Debug, Default)]
pub struct MovementWindow {
    seen: u64,
    values: VecDeque<f64>,
    /// Candidates for the minimum (rising) and for the maximum (falling), with their tick numbers.
    lows: VecDeque<(u64, f64)>,
    highs: VecDeque<(u64, f64)>,
}

impl MovementWindow {
    /// Adds the next tick.
    pub fn add(&mut self, pedals: f64) {
        let size = (WINDOW_S * f64::from(TICKS_PER_S)) as u64;
        while self.lows.back().is_some_and(|last| last.1 >= pedals) {
            self.lows.pop_back();
        }
        while self.highs.back().is_some_and(|last| last.1 <= pedals) {
            self.highs.pop_back();
        }
        self.lows.push_back((self.seen, pedals));
        self.highs.push_back((self.seen, pedals));
        self.values.push_back(pedals);
        self.seen += 1;
        let first = self.seen.saturating_sub(size);
        for ends in [&mut self.lows, &mut self.highs] {
            while ends.front().is_some_and(|end| end.0 < first) {
                ends.pop_front();
            }
        }
        if self.values.len() > size as usize {
            self.values.pop_front();
        }
    }

    /// Returns the movements up and down from the extreme the other way, share of travel; `None` before a whole window.
    pub fn movements(&self) -> Option<[f64; 2]> {
        let is_whole = self.seen >= (WINDOW_S * f64::from(TICKS_PER_S)) as u64;
        is_whole.then(|| [self.rise(), self.fall()])
    }

    /// Returns the distance of the pedals above their lowest position in the window, share of travel.
    pub fn rise(&self) -> f64 {
        let last = self.values.back().copied().unwrap_or_default();
        self.lows.front().map_or(0.0, |low| last - low.1)
    }

    fn fall(&self) -> f64 {
        let last = self.values.back().copied().unwrap_or_default();
        self.highs.front().map_or(0.0, |high| high.1 - last)
    }

    /// Returns the lowest position in the window, share of travel.
    pub fn lowest(&self) -> f64 {
        self.lows.front().map_or(0.0, |low| low.1)
    }

    /// Returns the ticks since the pedals were last at most `share` above their lowest position.
    pub fn ticks_since_within(&self, share: f64) -> u64 {
        let limit = self.lowest() + share;
        self.values.iter().rev().position(|value| *value <= limit).unwrap_or_default() as u64
    }
}

/// Distribution of the sizes of idle pedal movements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PedalNoise {
    /// Number of movements by size, in bins of a thousandth of travel; empty before the first.
    counts: Vec<u64>,
    ticks: u64,
}

impl PedalNoise {
    /// Adds the movements at the next idle tick.
    pub fn add(&mut self, window: &MovementWindow) {
        let Some(movements) = window.movements() else { return };
        self.counts.resize(BINS, 0);
        for movement in movements {
            self.counts[((movement * BINS as f64 / 2.0) as usize).min(BINS - 1)] += 1;
        }
        self.ticks += 1;
    }

    /// Returns the threshold, share of travel; `None` below [`ENOUGH_S`] of idle pedals.
    pub fn threshold(&self) -> Option<f64> {
        if (self.ticks as f64) < ENOUGH_S * f64::from(TICKS_PER_S) {
            return None;
        }
        let below = SHARE * self.counts.iter().sum::<u64>() as f64;
        let mut sum = 0;
        let bin = self.counts.iter().position(|count| {
            sum += count;
            sum as f64 >= below
        })?;
        Some(((bin + 1) as f64 * 2.0 / BINS as f64).max(LEAST))
    }
}

/// Source of a threshold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseSource {
    /// Practice of the same participant.
    Practice,
    /// The drive itself, while no request was pending.
    Drive,
    /// Smallest threshold, since neither had enough idle time.
    #[default]
    Least,
}

impl std::fmt::Display for NoiseSource {
    /// Writes the word in the tables.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Practice => "practice",
            Self::Drive => "drive",
            Self::Least => "least",
        })
    }
}

impl NoiseSource {
    /// Returns the threshold, share of travel, and its source.
    pub fn choose(practice: Option<&PedalNoise>, drive: &PedalNoise) -> (f64, Self) {
        let of_practice = practice.and_then(PedalNoise::threshold).map(|threshold| (threshold, Self::Practice));
        of_practice
            .or_else(|| drive.threshold().map(|threshold| (threshold, Self::Drive)))
            .unwrap_or((LEAST, Self::Least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_is_the_95th_percentile_of_idle_movements() {
        // A sawtooth: up by 0.1 % of travel a tick for 50 ticks, down as fast. Rises within a second are even over 0 to 5 %.
        let mut noise = PedalNoise::default();
        let mut window = MovementWindow::default();
        for tick in 0..3000 {
            let phase = tick % 100;
            window.add(0.3 + 0.001 * f64::from(if phase < 50 { phase } else { 100 - phase }));
            noise.add(&window);
            assert_eq!(noise.threshold().is_some(), tick >= 2098, "20 s after the first window: {tick}");
        }
        let threshold = noise.threshold().unwrap();
        assert!((threshold - 0.0475).abs() < 0.0015, "95 % of 5 %: {threshold}");
        assert_eq!(NoiseSource::choose(None, &noise), (threshold, NoiseSource::Drive));
        assert_eq!(NoiseSource::choose(Some(&noise), &PedalNoise::default()), (threshold, NoiseSource::Practice));
        assert_eq!(NoiseSource::choose(None, &PedalNoise::default()), (LEAST, NoiseSource::Least));
    }

    #[test]
    fn tables_name_the_source_of_a_threshold_in_one_word() {
        let words = [NoiseSource::Practice, NoiseSource::Drive, NoiseSource::Least].map(|source| source.to_string());
        assert_eq!(words, ["practice", "drive", "least"]);
    }

    #[test]
    fn a_window_forgets_what_is_older_than_a_second() {
        let mut window = MovementWindow::default();
        (0..150).for_each(|tick| window.add(if tick < 50 { 0.0 } else { 0.2 }));
        assert_eq!(window.rise(), 0.0, "the rise was a second ago");
        window.add(0.25);
        assert!((window.rise() - 0.05).abs() < 1e-12 && window.ticks_since_within(0.01) == 1);
    }
}
