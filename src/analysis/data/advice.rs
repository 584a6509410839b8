//! Advices of a recording, and their changes. In: the tables of advices and frames. Out: each advice with the tick at which the
//! driver could see it ([`IssuedAdvice`]), and the changes among them ([`AdviceChange`]). SI units.
//!
//! A change differs in target or range by at least [`CHANGE_MPS`] from the last change, so that small steps add up.

use crate::record::{RecordError, TableParts, TableReader};
use std::vec::IntoIter;

/// Smallest change of target or range that counts, m/s (0.2 mph: a needle's width on the dial).
pub const CHANGE_MPS: f64 = 0.1;

/// Largest number of changes of one drive: one a second for nearly six days. Each is a row of `advice.csv`.
pub const MOST_CHANGES: usize = 500_000;

/// An advice as the driver could see it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IssuedAdvice {
    /// Tick of the first frame that showed the advice, or of its issue without a screen.
    pub seen_tick: u64,
    /// Advised speed, m/s.
    pub target_mps: f64,
    /// Lower and upper edge of the acceptable range, m/s.
    pub range_mps: [f64; 2],
}

/// A change of the advice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdviceChange {
    /// Tick at which the change was seen.
    pub seen_tick: u64,
    /// Target before, m/s.
    pub from_mps: f64,
    /// New target, m/s.
    pub to_mps: f64,
    /// Lower and upper edge of the range before, m/s.
    pub before_mps: [f64; 2],
    /// Lower and upper edge of the new range, m/s.
    pub range_mps: [f64; 2],
}

/// Finds the changes among advices.
#[derive(Clone, Debug, Default)]
pub struct ChangeFinder {
    pub changes: Vec<AdviceChange>,
    /// Advice at the last change, against which the next is compared: small steps add up.
    standing: Option<IssuedAdvice>,
}

/// The advice of a drive changes more often than is analysed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the advice changes more than {} times; codrive analyses no more changes per drive\n  remedy: drive in parts, or \
     with a longer --hold",
    MOST_CHANGES
)]
pub struct TooManyChanges;

impl ChangeFinder {
    /// Adds the next advice.
    ///
    /// # Errors
    /// There are more than [`MOST_CHANGES`] changes.
    pub fn add(&mut self, advice: &IssuedAdvice) -> Result<(), TooManyChanges> {
        let before = *self.standing.get_or_insert(*advice);
        let moved = |a: f64, b: f64| (a - b).abs() >= CHANGE_MPS;
        let [low, high] = advice.range_mps;
        if moved(advice.target_mps, before.target_mps)
            || moved(low, before.range_mps[0])
            || moved(high, before.range_mps[1])
        {
            if self.changes.len() == MOST_CHANGES {
                return Err(TooManyChanges);
            }
            self.changes.push(AdviceChange {
                seen_tick: advice.seen_tick,
                from_mps: before.target_mps,
                to_mps: advice.target_mps,
                before_mps: before.range_mps,
                range_mps: advice.range_mps,
            });
            self.standing = Some(*advice);
        }
        Ok(())
    }
}

/// Reader of the frames alongside the advices that they showed first; both are in order of time.
pub(super) struct ShownFrames {
    parts: TableParts,
    frames: IntoIter<(u64, u64)>,
    /// Number and tick of the frame that was read last.
    last: Option<(u64, u64)>,
    seen_tick: u64,
}

impl ShownFrames {
    /// Starts with the parts of the table of frames, read by their numbers and ticks.
    pub fn new(parts: TableParts) -> Self {
        Self { parts, frames: Vec::new().into_iter(), last: None, seen_tick: 0 }
    }

    /// Reads the next frame; returns false after the last one.
    fn read_next(&mut self) -> Result<bool, RecordError> {
        loop {
            if let Some(next) = self.frames.next() {
                self.last = Some(next);
                return Ok(true);
            }
            let Some(part) = self.parts.next().transpose()? else { return Ok(false) };
            self.frames = part.wholes("frame").into_iter().zip(part.wholes("tick")).collect::<Vec<_>>().into_iter();
        }
    }

    /// Returns the tick of a frame; `None` if it has no row.
    fn tick_of(&mut self, frame: u64) -> Result<Option<u64>, RecordError> {
        while self.last.is_none_or(|last| last.0 < frame) {
            if !self.read_next()? {
                return Ok(None);
            }
        }
        Ok(self.last.filter(|last| last.0 == frame).map(|last| last.1))
    }

    /// Returns the tick of the first frame from a tick on; the tick itself without such a frame. Calls come with ascending ticks.
    pub fn shown_tick(&mut self, tick: u64) -> Result<u64, RecordError> {
        while self.last.is_none_or(|last| last.1 < tick) {
            if !self.read_next()? {
                return Ok(tick);
            }
        }
        Ok(self.last.map_or(tick, |last| last.1))
    }

    /// Returns the advices of a part of their table.
    pub fn advice(&mut self, part: &TableReader) -> Result<Vec<IssuedAdvice>, RecordError> {
        let (ticks, shown) = (part.wholes("tick"), part.ids("shown_frame"));
        let [targets, lows, highs] = ["target_mps", "range_low_mps", "range_high_mps"].map(|name| part.numbers(name));
        let mut advice = Vec::with_capacity(ticks.len());
        for (i, tick) in ticks.into_iter().enumerate() {
            let frame_tick = match shown.get(i).copied().flatten() {
                Some(frame) => self.tick_of(frame.into())?,
                None => None,
            };
            // A later advice is never seen before an earlier one.
            self.seen_tick = self.seen_tick.max(frame_tick.unwrap_or(tick));
            if let (Some(target_mps), Some(low), Some(high)) = (targets[i], lows[i], highs[i]) {
                advice.push(IssuedAdvice { seen_tick: self.seen_tick, target_mps, range_mps: [low, high] });
            }
        }
        Ok(advice)
    }
}
