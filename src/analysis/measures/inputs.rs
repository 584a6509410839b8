//! Inputs of the measures of a drive. In: its sums, its responses, the drive without advice. Out: counts and rates, or `None`
//! where there is too little.

use super::totals::DriveTotals;
use crate::analysis::{
    data::RecordedTrial,
    responses::{AdviceResponse, OnsetKind, ResponseTime, ScriptedResponse},
};
use crate::metrics::{RunningMean, TakeoverScores, TaskScores, TrafficTotals};

/// Data that the measures are computed from.
pub struct MeasureInputs<'a> {
    pub trial: &'a RecordedTrial,
    /// Sums of the drive.
    pub totals: &'a DriveTotals,
    /// Sums of the same drive without advice.
    pub baseline: Option<&'a DriveTotals>,
    /// Responses to changes, requests and shams.
    pub responses: &'a [AdviceResponse],
    /// Responses to the events of the scenario that were seen.
    pub events: &'a [ScriptedResponse],
    /// Scores of the secondary task.
    pub task: TaskScores,
    /// Scores of the takeovers; `None` without a request.
    pub takeovers: Option<TakeoverScores>,
}

impl MeasureInputs<'_> {
    /// Returns the median of a time of the requests, s, with censored times taken into account.
    pub fn median_s(&self, time: ResponseTime) -> Option<f64> {
        Some(time.fit(self.responses)?.median_s)
    }

    /// Returns the number of onsets of a kind.
    pub fn count(&self, kind: OnsetKind) -> f64 {
        self.responses.iter().filter(|response| response.kind == kind).count() as f64
    }

    /// Returns the mean of a value over the events that have it.
    pub fn mean_of_events(&self, value: impl Fn(&ScriptedResponse) -> Option<f64>) -> Option<f64> {
        let mut mean = RunningMean::default();
        self.events.iter().filter_map(value).for_each(|value| mean.add(value));
        mean.get()
    }

    /// Returns a count of this drive as a rate per hour.
    pub fn per_hour(&self, count: f64) -> Option<f64> {
        (self.totals.duration_s > 0.0).then(|| count * 3600.0 / self.totals.duration_s)
    }

    /// Returns a sum over all vehicles, divided by their number.
    pub fn per_car(&self, sum: f64) -> Option<f64> {
        let cars = self.totals.traffic.vehicles();
        (cars > 0).then(|| sum / cars as f64)
    }
}

/// Returns the sums of all vehicles, as the evaluation of policies uses them; `None` below two steps.
pub(super) fn all_cars(totals: &DriveTotals) -> Option<&TrafficTotals> {
    enough(&totals.traffic)
}

/// Returns the totals if there are at least two steps; a single step determines nothing.
pub(super) fn enough(traffic: &TrafficTotals) -> Option<&TrafficTotals> {
    (traffic.steps() >= 2).then_some(traffic)
}
