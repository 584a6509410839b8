//! Changes of the advice that need a response of the driver. In: advices, then the ego's rows, in order. Out: the [`Onset`]s of
//! a drive, sham onsets, and the pedal movements while no request is pending ([`PedalNoise`]).
//!
//! * **change**: target or range differ by at least [`CHANGE_MPS`](crate::analysis::data::advice::CHANGE_MPS) from the last
//!   change, so that small steps add up. Smaller steps cannot be seen on the dial. The first advice of a drive replaces
//!   nothing and is not a change.
//! * **demand**: faster if the speed is below the range, slower if it is above, none within it.
//! * **request**: a change with a demand at its onset (the speed is outside the new range) that differs from the demand of the
//!   old range: the driver was in the old range, or on its other side. A change with the same demand, or with none, is no
//!   request.
//! * **onset**: the first frame that shows the change (its tick); without a screen, the tick of its issue.
//! * **pending**: from a request's onset until the speed enters the range, at most [`PENDING_S`].
//! * **sham**: the onsets of the requests, all shifted by the same time (round the drive's end), with their directions. The shift
//!   comes from a fixed grid and moves most of them to times without a pending request; the others are left out. Responses to
//!   shams are chance detections.

use super::pedal_noise::{MovementWindow, PedalNoise};
use crate::analysis::data::{AdviceChange, EgoSample, RecordedTrial};
use crate::{record::RecordError, time::TICKS_PER_S};

/// Longest time that a request is pending, seconds.
pub const PENDING_S: f64 = 5.0;
/// Largest number of shifts tried for sham onsets, and their smallest spacing, ticks.
const SHIFTS: [u64; 2] = [600, 50];

/// Returns the demand of a range at this speed: 1 faster, -1 slower, 0 none.
fn demand(speed_mps: f64, [low, high]: [f64; 2]) -> i8 {
    i8::from(speed_mps < low) - i8::from(speed_mps > high)
}

/// Kind of an onset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnsetKind {
    /// A change without a new demand, which is not a request.
    #[default]
    Change,
    /// A change with a new demand.
    Request,
    /// A moment without a change, to measure chance detections.
    Sham,
}

impl std::fmt::Display for OnsetKind {
    /// Writes the word in the table.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Change => "change",
            Self::Request => "request",
            Self::Sham => "sham",
        })
    }
}

/// A moment from which the pedals are watched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Onset {
    pub kind: OnsetKind,
    pub tick: u64,
    /// First tick that is not watched: the next change (of a sham also the next sham); `None` if watched to the end of the
    /// drive.
    pub until_tick: Option<u64>,
    /// Demand: 1 faster, -1 slower, 0 none.
    pub direction: i8,
    /// Speed of the ego, m/s.
    pub speed_mps: f64,
    /// Change at the onset; of a sham, the change of its request.
    pub change: AdviceChange,
}

/// The onsets of a drive, and its pedals while no request is pending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveOnsets {
    /// Changes and requests, in order.
    pub onsets: Vec<Onset>,
    /// Shams in the order of their ticks.
    pub shams: Vec<Onset>,
    /// Pedal movements while no request is pending.
    pub noise: PedalNoise,
}

impl DriveOnsets {
    /// Reads the ego's rows of a drive.
    ///
    /// # Errors
    /// The same as for [`RecordedTrial::ego`].
    pub fn of(trial: &RecordedTrial) -> Result<Self, RecordError> {
        let mut finder = OnsetFinder::new(trial.changes.clone());
        for ego in trial.ego()? {
            finder.add(&ego?);
        }
        Ok(finder.finish())
    }
}

/// Finds onsets from all rows of the ego, added in order.
#[derive(Clone, Debug)]
pub struct OnsetFinder {
    ahead: std::vec::IntoIter<AdviceChange>,
    onsets: Vec<Onset>,
    /// First and last tick of each pending request.
    pending: Vec<[u64; 2]>,
    is_pending: bool,
    window: MovementWindow,
    noise: PedalNoise,
    last_tick: u64,
}

impl OnsetFinder {
    /// Starts with these changes, in order.
    pub fn new(changes: Vec<AdviceChange>) -> Self {
        Self {
            ahead: changes.into_iter(),
            onsets: Vec::new(),
            pending: Vec::new(),
            is_pending: false,
            window: MovementWindow::default(),
            noise: PedalNoise::default(),
            last_tick: 0,
        }
    }

    /// Adds the next row of the ego.
    pub fn add(&mut self, ego: &EgoSample) {
        self.last_tick = ego.tick;
        while self.ahead.as_slice().first().is_some_and(|change| change.seen_tick <= ego.tick) {
            let Some(change) = self.ahead.next() else { break };
            self.begin(change, ego.speed_mps);
        }
        if self.is_pending
            && let (Some(pending), Some(onset)) = (self.pending.last_mut(), self.onsets.last())
        {
            let is_met = demand(ego.speed_mps, onset.change.range_mps) != onset.direction;
            let is_late = ego.tick >= pending[0] + (PENDING_S * f64::from(TICKS_PER_S)) as u64;
            pending[1] = ego.tick;
            self.is_pending = !(is_met || is_late);
            self.window = MovementWindow::default();
        }
        if !self.is_pending {
            self.window.add(ego.throttle - ego.brake);
            self.noise.add(&self.window);
        }
    }

    fn begin(&mut self, change: AdviceChange, speed_mps: f64) {
        let now = demand(speed_mps, change.range_mps);
        let is_request = now != 0 && now != demand(speed_mps, change.before_mps);
        if let Some(before) = self.onsets.last_mut() {
            before.until_tick = Some(change.seen_tick);
        }
        let kind = if is_request { OnsetKind::Request } else { OnsetKind::Change };
        let direction = if is_request { now } else { 0 };
        self.onsets.push(Onset { kind, tick: change.seen_tick, until_tick: None, direction, speed_mps, change });
        // A change with the same demand keeps the request pending, now towards the new range.
        if is_request {
            self.pending.push([change.seen_tick, change.seen_tick]);
            self.is_pending = true;
        } else if let (true, Some(last)) = (self.is_pending, self.onsets.last_mut()) {
            last.direction = now;
            self.is_pending = now != 0;
        }
    }

    /// Returns the onsets after all rows were added. A change after the last row was not seen by the driver and has no time
    /// watched.
    pub fn finish(mut self) -> DriveOnsets {
        for change in self.ahead.by_ref() {
            if let Some(before) = self.onsets.last_mut() {
                before.until_tick.get_or_insert(change.seen_tick);
            }
            self.onsets.push(Onset {
                tick: change.seen_tick,
                until_tick: Some(change.seen_tick),
                change,
                ..Onset::default()
            });
        }
        let shams = shams(&self.onsets, &self.pending, self.last_tick);
        DriveOnsets { onsets: self.onsets, shams, noise: self.noise }
    }
}

/// Returns the requests, shifted to times at which most of them meet no pending request.
fn shams(onsets: &[Onset], pending: &[[u64; 2]], last_tick: u64) -> Vec<Onset> {
    let requests: Vec<&Onset> = onsets.iter().filter(|onset| onset.kind == OnsetKind::Request).collect();
    if requests.is_empty() || last_tick < 2 {
        return Vec::new();
    }
    let most = u64::from(TICKS_PER_S) * PENDING_S as u64;
    let shifted = |request: &Onset, shift: u64| (request.tick + shift - 1) % last_tick + 1;
    // Ticks from here to the next change, at most the longest pending time; `None` while a request is pending.
    let free = |tick: u64| {
        let before = pending.partition_point(|span| span[0] <= tick);
        if before > 0 && tick <= pending[before - 1][1] {
            return None;
        }
        let next = onsets.partition_point(|onset| onset.tick <= tick);
        let end = onsets.get(next).map_or(last_tick, |onset| onset.tick);
        Some(end.saturating_sub(tick).min(most)).filter(|ticks| *ticks > 0)
    };
    let [tried, step] = SHIFTS;
    let step = step.max(last_tick / tried);
    // Most shams first, then the most time to watch them, then the smallest shift.
    let score = |shift: u64| {
        let spans: Vec<u64> = requests.iter().filter_map(|request| free(shifted(request, shift))).collect();
        (spans.len(), spans.iter().sum::<u64>(), std::cmp::Reverse(shift))
    };
    let Some(shift) = (1..).map(|k| k * step).take_while(|shift| *shift < last_tick).max_by_key(|shift| score(*shift))
    else {
        return Vec::new();
    };
    let mut found: Vec<Onset> = requests
        .iter()
        .filter(|request| free(shifted(request, shift)).is_some())
        .map(|request| Onset { kind: OnsetKind::Sham, tick: shifted(request, shift), ..**request })
        .collect();
    found.sort_by_key(|sham| sham.tick);
    for i in 0..found.len() {
        let tick = found[i].tick;
        let change = onsets.get(onsets.partition_point(|onset| onset.tick <= tick)).map(|onset| onset.tick);
        let sham = found.get(i + 1).map(|sham| sham.tick);
        found[i].until_tick = [change, sham].into_iter().flatten().min();
    }
    found
}

#[cfg(test)]
#[path = "advice_onsets_tests.rs"]
mod tests;
