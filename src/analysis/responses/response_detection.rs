//! Responses of a driver to changes of the advice. In: the [`Onset`]s of a drive, then the ego's rows, in order. Out: an
//! [`AdviceResponse`] per onset, times in seconds and steps.
//!
//! SAE J2944 (6.5.2): reaction time runs from the onset of an event to the first observable response of hand or foot. Here:
//! * **reaction**: the start of the first movement of the pedals, accelerator less brake, in the direction of the demand and
//!   larger than the person's own idle movements ([`pedal_noise`](super::pedal_noise)). The start is the last tick at which the
//!   pedals were within half of that threshold of the origin of the movement;
//! * **movement**: from there until the pedals are 5 % of their travel ([`PEDAL`]) beyond that threshold;
//! * **entering the range**: from the onset to the first tick at which the speed is in the new range;
//! * a movement that starts before [`EARLIEST_S`] was under way at the onset: its reaction time is unknown;
//! * all times are watched until the next change of the advice or the end of the drive. A time that has not ended by then is
//!   censored: it is longer than [`AdviceResponse::watched_s`].

use super::{
    advice_onsets::{DriveOnsets, Onset, OnsetKind},
    pedal_noise::{MovementWindow, NoiseSource, PedalNoise},
};
use crate::analysis::data::EgoSample;
use crate::time::{TICK_S, Tick};

/// Movement of the pedals beyond the threshold that ends the movement time, share of travel.
pub const PEDAL: f64 = 0.05;
/// Shortest time from onset to response, seconds: no person responds to a picture faster.
pub const EARLIEST_S: f64 = 0.15;
/// Distance from its origin at which a movement starts, share of the threshold. For simulated people with known reactions
/// (`response_tests`) a tenth takes idle waves for the start: 18 % early, with a spread of 10 %. A half is 4 % late, with a
/// spread of 2 %.
const START: f64 = 0.5;

/// Response to a change of the advice, or to a sham.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdviceResponse {
    /// Kind of the onset.
    pub kind: OnsetKind,
    /// Time of the onset, seconds from the start of the drive.
    pub onset_s: f64,
    /// Target before, m/s.
    pub from_mps: f64,
    /// New target, m/s.
    pub to_mps: f64,
    /// Speed at the onset, m/s.
    pub speed_mps: f64,
    /// Demand: 1 faster, -1 slower, 0 none.
    pub direction: i8,
    /// Reaction time, seconds; `None` if censored or unknown.
    pub reaction_s: Option<f64>,
    /// True for a movement that was under way at the onset, so that the reaction time is unknown.
    pub is_under_way: bool,
    /// Time from the reaction to the end of the movement, seconds.
    pub movement_s: Option<f64>,
    /// Time from the onset to entering the range, seconds.
    pub enter_s: Option<f64>,
    /// Time from the onset to entering the range, in whole steps of the scenario, rounded up.
    pub enter_steps: Option<u64>,
    /// Time watched, seconds; 0 for a change that is not a request.
    pub watched_s: f64,
    /// Threshold of idle pedal movements, share of travel.
    pub threshold: f64,
    /// Source of the threshold.
    pub noise_from: NoiseSource,
}

/// Detects the ego's responses to onsets and to shams.
#[derive(Clone, Debug)]
pub struct ResponseWatch {
    watches: [ResponseDetector; 2],
}

impl ResponseWatch {
    /// Starts for a drive with steps of `step_s`; `practice` has the idle movements of the same participant's practice.
    pub fn new(step_s: f64, onsets: DriveOnsets, practice: Option<&PedalNoise>) -> Self {
        let noise = NoiseSource::choose(practice, &onsets.noise);
        Self { watches: [onsets.onsets, onsets.shams].map(|list| ResponseDetector::new(step_s, list, noise)) }
    }

    /// Adds the next row of the ego.
    pub fn add(&mut self, ego: &EgoSample) {
        self.watches.iter_mut().for_each(|watch| watch.add(ego));
    }

    /// Returns the responses to changes and requests in order, then those to shams.
    pub fn finish(self) -> Vec<AdviceResponse> {
        self.watches.into_iter().flat_map(ResponseDetector::finish).collect()
    }
}

/// Detects responses to successive onsets.
#[derive(Clone, Debug)]
struct ResponseDetector {
    step_s: f64,
    noise: (f64, NoiseSource),
    /// Onsets still to come.
    ahead: std::vec::IntoIter<Onset>,
    watched: Option<PendingResponse>,
    found: Vec<AdviceResponse>,
}

/// An onset with the driver's response so far; times in ticks since the onset.
#[derive(Clone, Debug)]
struct PendingResponse {
    onset: Onset,
    window: MovementWindow,
    /// Start of the movement, and the position of the pedals that ends it.
    moved: Option<(u64, f64)>,
    ended: Option<u64>,
    entered: Option<u64>,
    watched: u64,
}

impl ResponseDetector {
    fn new(step_s: f64, onsets: Vec<Onset>, noise: (f64, NoiseSource)) -> Self {
        Self { step_s, noise, ahead: onsets.into_iter(), watched: None, found: Vec::new() }
    }

    fn add(&mut self, ego: &EgoSample) {
        while self.ahead.as_slice().first().is_some_and(|onset| onset.tick <= ego.tick) {
            self.next();
        }
        let threshold = self.noise.0;
        if let Some(watched) = &mut self.watched {
            watched.add(ego, threshold);
        }
    }

    /// Ends the watch of the current onset and starts to watch the next.
    fn next(&mut self) {
        let watched = self.ahead.next().map(PendingResponse::new);
        let over = std::mem::replace(&mut self.watched, watched);
        self.found.extend(over.map(|watched| watched.response(self.step_s, self.noise)));
    }

    fn finish(mut self) -> Vec<AdviceResponse> {
        while self.watched.is_some() || !self.ahead.as_slice().is_empty() {
            self.next();
        }
        self.found
    }
}

impl PendingResponse {
    fn new(onset: Onset) -> Self {
        Self { onset, window: MovementWindow::default(), moved: None, ended: None, entered: None, watched: 0 }
    }

    fn add(&mut self, ego: &EgoSample, threshold: f64) {
        let onset = &self.onset;
        if onset.direction == 0 || onset.until_tick.is_some_and(|until| ego.tick >= until) {
            return;
        }
        let since = ego.tick.saturating_sub(onset.tick);
        self.watched = since;
        let pedals = f64::from(onset.direction) * (ego.throttle - ego.brake);
        self.window.add(pedals);
        if self.moved.is_none() && self.window.rise() > threshold {
            let start = since.saturating_sub(self.window.ticks_since_within(START * threshold));
            self.moved = Some((start, self.window.lowest() + threshold + PEDAL));
        }
        if self.ended.is_none() && self.moved.is_some_and(|moved| pedals >= moved.1) {
            self.ended = Some(since);
        }
        let [low, high] = onset.change.range_mps;
        if self.entered.is_none() && (low..=high).contains(&ego.speed_mps) {
            self.entered = Some(since);
        }
    }

    fn response(&self, step_s: f64, (threshold, noise_from): (f64, NoiseSource)) -> AdviceResponse {
        let Onset { kind, tick, direction, speed_mps, change, .. } = self.onset;
        let needs_response = kind != OnsetKind::Change;
        let seconds = |ticks: u64| ticks as f64 * TICK_S;
        let start = self.moved.filter(|_| needs_response).map(|moved| moved.0);
        let is_under_way = start.is_some_and(|start| seconds(start) < EARLIEST_S - 1e-9);
        let reaction = start.filter(|_| !is_under_way);
        let enter_s = self.entered.filter(|_| kind == OnsetKind::Request).map(seconds);
        AdviceResponse {
            kind,
            onset_s: Tick(tick).seconds(),
            from_mps: change.from_mps,
            to_mps: change.to_mps,
            speed_mps,
            direction: if needs_response { direction } else { 0 },
            reaction_s: reaction.map(seconds),
            is_under_way,
            movement_s: reaction.and_then(|start| Some(seconds(self.ended?.saturating_sub(start)))),
            enter_s,
            enter_steps: enter_s.map(|s| (s / step_s - 1e-9).ceil() as u64),
            watched_s: if needs_response { seconds(self.watched) } else { 0.0 },
            threshold,
            noise_from,
        }
    }
}

#[cfg(test)]
#[path = "response_detection_tests.rs"]
mod tests;
