//! Summary of a drive. In: the snapshot of each tick and the events. Out: a [`Summary`], HC22's measure first. The averaging window is
//! always stated (docs/references.md: ring).

use super::{Event, EventKind, Snapshot, event::EndReason};
use crate::{
    metrics::{TakeoverLog, TakeoverScores, TaskLog, TaskScores, TickTotals},
    time::Tick,
};
use serde::Serialize;

/// A contact in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactRecord {
    /// Seconds since the start of the drive.
    pub time_s: f64,
    /// Id of the other vehicle.
    pub car: u32,
    /// Speed of the ego just before, m/s.
    pub ego_speed_mps: f64,
    /// Speed of the other vehicle just before, m/s.
    pub car_speed_mps: f64,
    /// Closing speed, m/s.
    pub closing_mps: f64,
}

/// Largest number of contacts that are listed; a drive of days may have more.
pub const MOST_CONTACTS: usize = 10_000;

/// Summary of a drive. Means and deviations are over all ticks in the window; `None` if the window has none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Start and end of the window, seconds since the start of the drive.
    pub window_s: [f64; 2],
    /// Mean speed of all vehicles, the ego included, m/s: mean over ticks of the mean over the vehicles present.
    pub mean_speed_mps: Option<f64>,
    /// Space-mean speed of all vehicles, m/s: their distance over their time (Edie 1963). `None` if the number of vehicles never
    /// changed, because it then equals the mean speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub space_mean_speed_mps: Option<f64>,
    /// Standard deviation of speed over vehicles and time, m/s (divisor N, not N-1).
    pub speed_sd_over_vehicles_and_time_mps: Option<f64>,
    /// Mean speed of the ego, m/s.
    pub ego_mean_speed_mps: Option<f64>,
    /// Share of the time with advice in which the ego's speed was in the acceptable range, 0..1.
    pub time_in_range: Option<f64>,
    /// Smallest gap of the ego to its leader in the whole drive, metres, while the ego is in the lane ([`Snapshot::leader_in_lane`]).
    pub min_gap_m: Option<f64>,
    /// The first `MOST_CONTACTS` contacts of the drive, in order.
    pub contacts: Vec<ContactRecord>,
    /// Number of all contacts, unlisted ones included.
    pub contact_count: u64,
    /// Number of contacts of the ego with fixed objects beside the road, such as walls.
    #[serde(skip_serializing_if = "is_none_of")]
    pub object_contacts: u32,
    /// Number of times the ego left the road.
    pub left_road: u32,
    /// Number of red lights that the ego ran; on networks with signals.
    #[serde(skip_serializing_if = "is_none_of")]
    pub red_lights: u32,
    /// Number of near misses of the ego; on networks.
    #[serde(skip_serializing_if = "is_none_of")]
    pub near_misses: u32,
    /// Scores of the secondary task; omitted without one. Response times count from the tick of a stimulus.
    #[serde(flatten)]
    pub secondary_task: TaskScores,
    /// Scores of the takeovers; omitted without a takeover request.
    #[serde(flatten)]
    pub takeovers: Option<TakeoverScores>,
    /// Number of advices issued.
    pub advices: u32,
    /// Length of the drive, seconds.
    pub duration_s: f64,
    /// Reason for the end; `None` if the drive was stopped.
    pub ended: Option<EndReason>,
    /// Error message, if the drive failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// Hash of all snapshots of the drive, in hexadecimal; equal for equal bits.
    pub hash: String,
}

/// Returns true if a counter is omitted: counters of networks are 0 on closed routes.
fn is_none_of(count: &u32) -> bool {
    *count == 0
}

impl Summary {
    /// Returns the reason for the end as recordings have it; "stopped" if the drive was stopped.
    pub fn end_text(&self) -> String {
        match (self.ended, &self.failure) {
            (_, Some(why)) => format!("failed: {}", why.split_once("\n  remedy").map_or(why.as_str(), |(why, _)| why)),
            (Some(end), None) => end.name().into(),
            (None, None) => "stopped".into(),
        }
    }
}

/// Accumulates a [`Summary`] over a drive.
#[derive(Clone, Debug)]
pub struct SummaryAccumulator {
    window_s: [f64; 2],
    totals: TickTotals,
    contacts: Vec<ContactRecord>,
    contact_count: u64,
    object_contacts: u32,
    left_road: u32,
    red_lights: u32,
    near_misses: u32,
    task: TaskLog,
    takeovers: TakeoverLog,
    advices: u32,
    duration_s: f64,
    ended: Option<EndReason>,
    failure: Option<String>,
    hash: u64,
}

impl SummaryAccumulator {
    /// Returns an empty accumulator; means are over the time between the two seconds of `window_s`.
    pub fn new(window_s: [f64; 2]) -> Self {
        Self {
            window_s,
            totals: TickTotals::default(),
            contacts: Vec::new(),
            contact_count: 0,
            object_contacts: 0,
            left_road: 0,
            red_lights: 0,
            near_misses: 0,
            task: TaskLog::default(),
            takeovers: TakeoverLog::default(),
            advices: 0,
            duration_s: 0.0,
            ended: None,
            failure: None,
            hash: super::HASH_START,
        }
    }

    /// Adds one tick and its events.
    pub fn add(&mut self, snapshot: &Snapshot, events: &[Event]) {
        self.hash = snapshot.hash(self.hash);
        self.duration_s = snapshot.tick.seconds();
        self.totals.min_gap_m.add(snapshot.leader_in_lane().map(|leader| leader.gap_m));
        events.iter().for_each(|event| self.note(event));
        self.takeovers.watch(snapshot.tick, snapshot.ttc_s(), snapshot.lane_offset_m);
        if self.duration_s < self.window_s[0] || self.duration_s > self.window_s[1] {
            return;
        }
        self.totals.add_speeds(snapshot.mean_speed_mps, snapshot.speeds_mps());
        if !snapshot.is_without_ego {
            let ego_mps = snapshot.ego.speed_mps;
            self.totals.add_ego(ego_mps, snapshot.advice.map(|advice| advice.accepts(ego_mps)));
        }
    }

    /// Marks the drive as failed with this message.
    pub fn fail(&mut self, why: String) {
        self.ended = Some(EndReason::Failed);
        self.failure = Some(why);
    }

    /// Leaves the stimulus of the secondary task with this onset out of its scores.
    pub fn leave_unscored(&mut self, onset: Tick) {
        self.task.leave_unscored(onset);
    }

    fn note(&mut self, event: &Event) {
        match event.kind {
            EventKind::Advice(_) => self.advices += 1,
            EventKind::LeftRoad { .. } => self.left_road += 1,
            EventKind::RedLight { .. } => self.red_lights += 1,
            EventKind::NearMiss { .. } => self.near_misses += 1,
            EventKind::ObjectContact { .. } => self.object_contacts += 1,
            EventKind::AdviceWithheld
            | EventKind::BackOnRoad
            | EventKind::LeftPath { .. }
            | EventKind::BackOnPath { .. }
            | EventKind::StopLine { .. }
            | EventKind::WrongWay { .. }
            | EventKind::RightWay
            | EventKind::Speeding { .. }
            | EventKind::WithinLimit
            | EventKind::Indicator(_)
            | EventKind::MainBeam(_)
            | EventKind::Scripted { .. }
            | EventKind::PutBack { .. } => {}
            EventKind::TaskStimulus(_)
            | EventKind::TaskResponse(_)
            | EventKind::Shutter(_)
            | EventKind::Question { .. } => event.add_to(&mut self.task),
            EventKind::Automation(change) => self.takeovers.add(event.tick, change),
            EventKind::Ended(reason) => self.ended = Some(reason),
            EventKind::Contact { car, ego_speed_mps, car_speed_mps, closing_mps, .. } => {
                self.contact_count += 1;
                if self.contacts.len() == MOST_CONTACTS {
                    return;
                }
                let time_s = event.tick.seconds();
                self.contacts.push(ContactRecord { time_s, car: car.0, ego_speed_mps, car_speed_mps, closing_mps });
            }
        }
    }

    /// Returns the summary of the ticks so far.
    pub fn to_summary(&self) -> Summary {
        Summary {
            window_s: [self.window_s[0], self.window_s[1].min(self.duration_s)],
            mean_speed_mps: self.totals.mean_speed_mps.get(),
            space_mean_speed_mps: self.totals.space_mean_speed_mps(),
            speed_sd_over_vehicles_and_time_mps: self.totals.speed_sd_over_vehicles_and_time_mps(),
            ego_mean_speed_mps: self.totals.ego_mean_speed_mps.get(),
            time_in_range: self.totals.time_in_range.get(),
            min_gap_m: self.totals.min_gap_m.0,
            contacts: self.contacts.clone(),
            contact_count: self.contact_count,
            object_contacts: self.object_contacts,
            left_road: self.left_road,
            red_lights: self.red_lights,
            near_misses: self.near_misses,
            secondary_task: self.task.scores(self.duration_s),
            takeovers: self.takeovers.scores(),
            advices: self.advices,
            duration_s: self.duration_s,
            ended: self.ended,
            failure: self.failure.clone(),
            hash: format!("{:016x}", self.hash),
        }
    }
}

#[cfg(test)]
#[path = "summary_tests.rs"]
mod tests;
