//! What a driver does about each change of the advice. In: advices, then the ego's rows, in order. Out: a [`AdviceResponse`] a change,
//! times in seconds and steps.
//!
//! SAE J2944 (10.1): reaction time runs from the onset of the event to the first observable response of hand or foot. Here:
//! * **onset**: the first frame that shows the new target (its tick); without a screen, the tick of its issue;
//! * **change**: the target differs by at least [`CHANGE_MPS`] from the one that counted last, so that small changes add up
//!   until they count; the first advice of a drive replaces nothing and is no change;
//! * **response**: the pedals, accelerator less brake, move towards the new target by at least [`PEDAL`] of their travel from
//!   where they were furthest the other way since the onset. The moment is that in which this is reached;
//! * no response: nothing until the next change or [`LATEST_S`]; a movement that is complete before [`EARLIEST_S`] was under way
//!   when the change came and is no response to it;
//! * **entering the range**: the first tick from the onset on at which the speed is in the new range, until the next change.
//!   None where it was in it at the onset already.
//!
//! Measured on 75 rehearsed trials with a change from 2.5 to 4.3 m/s: the reaction found is the driver's own plus 0.06 s in the
//! median (the time that a foot takes for 5 % of a pedal), 80 % lie between +0.02 and +0.07 s; four of 75 are much
//! too early, where a pedal was under way. With 2 % of travel it were 14.

use super::trial::{EgoSample, IssuedAdvice};
use crate::time::{TICK_S, Tick};

/// Smallest change of the target that counts, m/s (0.2 mph: a needle's width on the dial).
pub const CHANGE_MPS: f64 = 0.1;
/// Movement of a pedal that counts, share of its travel.
pub const PEDAL: f64 = 0.05;
/// What is sooner is no response, seconds.
pub const EARLIEST_S: f64 = 0.15;
/// What is later is no response, seconds.
pub const LATEST_S: f64 = 5.0;

/// Changes of one drive that are taken at the most: one a second for nearly six days. Each is a row of `advice.csv`.
pub const MOST_CHANGES: usize = 500_000;

/// A change of the advice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdviceChange {
    /// When it was seen.
    pub seen_tick: u64,
    /// The target before, m/s.
    pub from_mps: f64,
    /// The new target, m/s.
    pub to_mps: f64,
    /// Edges of the new acceptable range, m/s.
    pub range_mps: [f64; 2],
}

/// Finds the changes among advices.
#[derive(Clone, Debug, Default)]
pub struct ChangeFinder {
    /// The changes so far.
    pub changes: Vec<AdviceChange>,
    /// Many small steps add up to a change: what stands is what was last counted.
    standing_mps: Option<f64>,
}

/// The advice of a drive changes more often than is analysed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the advice changes more than {} times, the most that is analysed of one drive\n  remedy: drive in parts, or with a \
     longer --hold",
    MOST_CHANGES
)]
pub struct TooManyChanges;

impl ChangeFinder {
    /// The next advice.
    ///
    /// # Errors
    /// More than [`MOST_CHANGES`].
    pub fn add(&mut self, advice: &IssuedAdvice) -> Result<(), TooManyChanges> {
        let from_mps = *self.standing_mps.get_or_insert(advice.target_mps);
        if (advice.target_mps - from_mps).abs() >= CHANGE_MPS {
            if self.changes.len() == MOST_CHANGES {
                return Err(TooManyChanges);
            }
            let (to_mps, range_mps) = (advice.target_mps, advice.range_mps);
            self.changes.push(AdviceChange { seen_tick: advice.seen_tick, from_mps, to_mps, range_mps });
            self.standing_mps = Some(to_mps);
        }
        Ok(())
    }
}

/// One change of the advice and what came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdviceResponse {
    /// When the change was seen, seconds.
    pub onset_s: f64,
    /// The target before, m/s.
    pub from_mps: f64,
    /// The new target, m/s.
    pub to_mps: f64,
    /// Reaction time, seconds.
    pub reaction_s: Option<f64>,
    /// The speed was in the new range at the onset.
    pub was_in_range: bool,
    /// From the onset to entering the range, seconds.
    pub enter_s: Option<f64>,
    /// The same in whole steps of the scenario.
    pub enter_steps: Option<u64>,
}

/// Watches the ego for responses.
#[derive(Clone, Debug)]
pub struct ResponseDetector {
    step_s: f64,
    /// Changes that are to come.
    ahead: std::vec::IntoIter<AdviceChange>,
    watched: Option<PendingResponse>,
    found: Vec<AdviceResponse>,
}

/// A change, and what the driver has done about it so far.
#[derive(Clone, Debug)]
struct PendingResponse {
    change: AdviceChange,
    has_rows: bool,
    /// Where the pedals were furthest the other way.
    furthest: f64,
    moved_s: Option<f64>,
    entered_s: Option<f64>,
    was_in_range: bool,
}

impl ResponseDetector {
    /// To these changes, in order, where a step takes `step_s`.
    pub fn new(step_s: f64, changes: Vec<AdviceChange>) -> Self {
        Self { step_s, ahead: changes.into_iter(), watched: None, found: Vec::new() }
    }

    /// The next row of the ego.
    pub fn add(&mut self, ego: &EgoSample) {
        while self.ahead.as_slice().first().is_some_and(|change| change.seen_tick <= ego.tick) {
            self.next();
        }
        if let Some(watched) = &mut self.watched {
            watched.add(ego);
        }
    }

    /// The next change replaces the one that is watched.
    fn next(&mut self) {
        let watched = self.ahead.next().map(PendingResponse::new);
        let over = std::mem::replace(&mut self.watched, watched);
        self.found.extend(over.map(|watched| watched.response(self.step_s)));
    }

    /// The responses of the drive, in order.
    pub fn finish(mut self) -> Vec<AdviceResponse> {
        while self.watched.is_some() || !self.ahead.as_slice().is_empty() {
            self.next();
        }
        self.found
    }
}

impl PendingResponse {
    fn new(change: AdviceChange) -> Self {
        let (moved_s, entered_s) = (None, None);
        Self { change, has_rows: false, furthest: f64::INFINITY, moved_s, entered_s, was_in_range: false }
    }

    fn add(&mut self, ego: &EgoSample) {
        let change = &self.change;
        let since_s = ego.tick.saturating_sub(change.seen_tick) as f64 * TICK_S;
        let pedals = (change.to_mps - change.from_mps).signum() * (ego.throttle - ego.brake);
        self.furthest = self.furthest.min(pedals);
        if self.moved_s.is_none() && pedals - self.furthest >= PEDAL {
            self.moved_s = Some(since_s);
        }
        let [low, high] = change.range_mps;
        if self.entered_s.is_none() && (low..=high).contains(&ego.speed_mps) {
            self.entered_s = Some(since_s);
            self.was_in_range = !self.has_rows;
        }
        self.has_rows = true;
    }

    fn response(&self, step_s: f64) -> AdviceResponse {
        let AdviceChange { seen_tick, from_mps, to_mps, .. } = self.change;
        let enter_s = self.entered_s.filter(|_| !self.was_in_range);
        AdviceResponse {
            onset_s: Tick(seen_tick).seconds(),
            from_mps,
            to_mps,
            reaction_s: self.moved_s.filter(|s| (EARLIEST_S - 1e-9..=LATEST_S + 1e-9).contains(s)),
            was_in_range: self.was_in_range,
            enter_s,
            enter_steps: enter_s.map(|s| (s / step_s - 1e-9).ceil() as u64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten seconds; pedals and speed as functions of the time. Advices are seen two ticks after their issue.
    fn responses(
        pedals: impl Fn(f64) -> (f64, f64),
        speed: impl Fn(f64) -> f64,
        advice: &[(u64, f64)],
    ) -> Vec<AdviceResponse> {
        let mut finder = ChangeFinder::default();
        for &(tick, target_mps) in advice {
            let range_mps = [target_mps - 0.5, target_mps + 0.5];
            finder.add(&IssuedAdvice { seen_tick: tick + 2, target_mps, range_mps }).unwrap();
        }
        let mut responses = ResponseDetector::new(0.1, finder.changes);
        for tick in 1..=1000 {
            let at_s = Tick(tick).seconds();
            let (throttle, brake) = pedals(at_s);
            responses.add(&EgoSample { tick, throttle, brake, speed_mps: speed(at_s), ..EgoSample::default() });
        }
        responses.finish()
    }

    #[test]
    fn reaction_runs_from_the_frame_that_shows_the_change_to_five_percent_of_a_pedal() {
        // The accelerator moves by 10 % a second from 3.00 s on: 5 % are reached at 3.50 s. Seen at 2.02 s.
        let press = |t: f64| (0.2 + 0.1 * (t - 3.0).max(0.0), 0.0);
        // 3.5 m/s, the lower edge, is reached 2.5 s after 3.00 s.
        let speed = |t: f64| 2.0 + 0.6 * (t - 3.0).max(0.0);
        let found = responses(press, speed, &[(100, 2.0), (150, 2.05), (200, 4.0)]);
        assert_eq!(found.len(), 1, "2.00, the first, and 2.05 are no changes: {found:?}");
        assert_eq!((found[0].onset_s, found[0].from_mps, found[0].to_mps), (2.02, 2.0, 4.0));
        assert!((found[0].reaction_s.unwrap() - 1.48).abs() < 0.011, "{found:?}");
        assert!((found[0].enter_s.unwrap() - 3.48).abs() < 0.011 && !found[0].was_in_range, "{found:?}");
        assert_eq!(found[0].enter_steps, Some(35));
    }

    #[test]
    fn lifting_the_foot_answers_a_lower_target_and_pressing_on_does_not() {
        let lift = |t: f64| (if t < 2.5 { 0.2 + 0.02 * t } else { 0.1 }, 0.0);
        let found = responses(lift, |_| 5.0, &[(100, 5.0), (200, 3.0)]);
        assert!((found[0].reaction_s.unwrap() - 0.48).abs() < 0.011, "{found:?}");
        assert_eq!((found[0].enter_s, found[0].was_in_range), (None, false));
        let brake = |t: f64| (0.0, if t < 2.5 { 0.0 } else { 0.3 });
        assert!((responses(brake, |_| 5.0, &[(100, 5.0), (200, 3.0)])[0].reaction_s.unwrap() - 0.48).abs() < 0.011);
        let on = |t: f64| (0.2 + 0.02 * t, 0.0);
        assert_eq!(responses(on, |_| 5.0, &[(100, 5.0), (200, 3.0)])[0].reaction_s, None);
    }

    #[test]
    fn what_was_under_way_or_comes_too_late_is_no_response() {
        let control_delay = |t: f64| (0.2 + 0.4 * (t - 1.8).clamp(0.0, 1.0), 0.0);
        assert_eq!(responses(control_delay, |_| 2.0, &[(100, 2.0), (200, 4.0)])[0].reaction_s, None);
        let late = |t: f64| (if t < 7.1 { 0.1 } else { 0.5 }, 0.0);
        assert_eq!(responses(late, |_| 2.0, &[(100, 2.0), (200, 4.0)])[0].reaction_s, None);
        // The same movement answers a change that comes later, and not one that has been replaced.
        let found = responses(late, |_| 2.0, &[(100, 2.0), (200, 4.0), (600, 6.0)]);
        assert_eq!(found.iter().map(|r| r.reaction_s.is_some()).collect::<Vec<_>>(), [false, true]);
        assert!((found[1].reaction_s.unwrap() - 1.08).abs() < 0.011);
    }

    #[test]
    fn small_steps_that_add_up_are_a_change_and_a_speed_in_the_range_has_nothing_to_enter() {
        let advice: Vec<(u64, f64)> = (0..8).map(|k| (100 + 100 * k, 2.0 + 0.06 * k as f64)).collect();
        let found = responses(|_| (0.1, 0.0), |_| 2.0, &advice);
        assert_eq!(found.iter().map(|r| (r.onset_s * 100.0).round()).collect::<Vec<_>>(), [302.0, 502.0, 702.0]);
        assert!(found.iter().all(|r| r.was_in_range && r.enter_s.is_none()));
    }

    #[test]
    fn a_change_that_is_replaced_before_it_is_seen_or_comes_at_the_end_is_counted_and_has_no_response() {
        let press = |t: f64| (if t < 2.5 { 0.1 } else { 0.5 }, 0.0);
        // Two are shown by one frame, and one after the last row.
        let found = responses(press, |_| 2.0, &[(100, 2.0), (200, 4.0), (200, 6.0), (999, 8.0)]);
        assert_eq!(found.iter().map(|r| r.reaction_s.is_some()).collect::<Vec<_>>(), [false, true, false]);
        assert_eq!((found[0].to_mps, found[2].to_mps, found[2].onset_s), (4.0, 8.0, 10.01));
    }

    #[test]
    fn more_changes_than_are_analysed_are_refused() {
        let mut finder = ChangeFinder::default();
        let advice = |k: usize| IssuedAdvice { target_mps: (k % 2) as f64, ..IssuedAdvice::default() };
        (0..=MOST_CHANGES).for_each(|k| finder.add(&advice(k)).unwrap());
        assert_eq!(finder.changes.len(), MOST_CHANGES);
        let why = finder.add(&advice(MOST_CHANGES + 1)).unwrap_err().to_string();
        assert!(why.contains("500000") && why.contains("remedy"), "{why}");
    }
}
