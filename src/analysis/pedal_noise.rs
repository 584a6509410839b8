//! How far a person's pedals move while nothing is asked of them. In: pedals (accelerator less brake) tick by tick. Out: a threshold that
//! such idle movements seldom pass, as a share of travel.
//!
//! A movement is how far the pedals are, in one direction, from where they were furthest the other way within the last
//! [`WINDOW_S`]. It is taken at every tick at which no event is pending, in both directions; the threshold is the 95th
//! percentile of all of these, and [`LEAST`] at the least. The detector of responses takes its movements over the same window.

use crate::time::TICKS_PER_S;
use std::collections::VecDeque;

/// Length of the window, seconds: room for a deliberate movement of a foot, a slow one too.
pub const WINDOW_S: f64 = 1.0;
/// Smallest threshold, share of travel: pedals of ten bits and a resting foot move by less.
pub const LEAST: f64 = 0.01;
/// Share of idle movements that stay below the threshold.
pub const SHARE: f64 = 0.95;
/// Time of idle pedals from which on their percentile is told, seconds.
pub const ENOUGH_S: f64 = 20.0;
/// Bins over two travels (brake floored to accelerator floored).
const BINS: usize = 2000;

/// The pedals of the last [`WINDOW_S`], with the furthest to both sides.
#[derive(Clone, Debug, Default)]
pub struct MovementWindow {
    seen: u64,
    values: VecDeque<f64>,
    /// Falling, rising: what may become the smallest and the largest, with its number.
    lows: VecDeque<(u64, f64)>,
    highs: VecDeque<(u64, f64)>,
}

impl MovementWindow {
    /// The next tick.
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

    /// How far the pedals have moved up and down from the furthest the other way, share of travel; `None` before a whole window.
    pub fn movements(&self) -> Option<[f64; 2]> {
        let is_whole = self.seen >= (WINDOW_S * f64::from(TICKS_PER_S)) as u64;
        is_whole.then(|| [self.rise(), self.fall()])
    }

    /// How far the pedals are above their lowest in the window.
    pub fn rise(&self) -> f64 {
        let last = self.values.back().copied().unwrap_or_default();
        self.lows.front().map_or(0.0, |low| last - low.1)
    }

    fn fall(&self) -> f64 {
        let last = self.values.back().copied().unwrap_or_default();
        self.highs.front().map_or(0.0, |high| high.1 - last)
    }

    /// The lowest value.
    pub fn lowest(&self) -> f64 {
        self.lows.front().map_or(0.0, |low| low.1)
    }

    /// How many ticks ago the pedals were last no more than `share` above their lowest.
    pub fn ticks_since_within(&self, share: f64) -> u64 {
        let limit = self.lowest() + share;
        self.values.iter().rev().position(|value| *value <= limit).unwrap_or_default() as u64
    }
}

/// How often idle pedals have moved how far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PedalNoise {
    /// Movements by their size, in steps of a thousandth of travel; empty before the first.
    counts: Vec<u64>,
    ticks: u64,
}

impl PedalNoise {
    /// The movements at the next idle tick.
    pub fn add(&mut self, window: &MovementWindow) {
        let Some(movements) = window.movements() else { return };
        self.counts.resize(BINS, 0);
        for movement in movements {
            self.counts[((movement * BINS as f64 / 2.0) as usize).min(BINS - 1)] += 1;
        }
        self.ticks += 1;
    }

    /// The threshold, share of travel; `None` of less than [`ENOUGH_S`] of idle pedals.
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

/// Where a threshold is from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NoiseSource {
    /// The practice of the same participant.
    Practice,
    /// The drive itself, while no event was pending.
    Drive,
    /// Neither had enough idle time: the smallest threshold.
    #[default]
    Least,
}

impl NoiseSource {
    /// As the tables say it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Practice => "practice",
            Self::Drive => "drive",
            Self::Least => "least",
        }
    }

    /// The threshold, share of travel, and where it is from.
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
    fn the_threshold_is_what_idle_movements_pass_once_in_twenty() {
        // A saw tooth: up by 0.1 % of travel a tick for 50 ticks, down as fast: rises within a second are even over 0..5 %.
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
        let words = [NoiseSource::Practice, NoiseSource::Drive, NoiseSource::Least].map(NoiseSource::word);
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
