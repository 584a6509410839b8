//! What the measures of a drive are taken of. In: its sums, its responses, the drive without advice. Out: counts, rates, medians and
//! deviations of them, or `None` of too little.

use super::{RecordedTrial, events::OnsetKind, reactions::ResponseTime, response::AdviceResponse, totals::DriveTotals};
use crate::metrics::FlowTotals;

/// What measures are taken of.
pub(super) struct MeasureInputs<'a> {
    /// The recording.
    pub trial: &'a RecordedTrial,
    /// Its sums.
    pub totals: &'a DriveTotals,
    /// Those of the same drive without advice.
    pub baseline: Option<&'a DriveTotals>,
    /// Responses to changes, events and shams.
    pub responses: &'a [AdviceResponse],
}

impl MeasureInputs<'_> {
    /// Median of a time of the events, censored times taken into account.
    pub fn median_s(&self, time: ResponseTime) -> Option<f64> {
        Some(time.fit(self.responses)?.median_s)
    }

    /// Onsets of a kind.
    pub fn count(&self, kind: OnsetKind) -> f64 {
        self.responses.iter().filter(|response| response.kind == kind).count() as f64
    }

    /// So many in this drive, an hour.
    pub fn per_hour(&self, count: f64) -> Option<f64> {
        (self.totals.duration_s > 0.0).then(|| count * 3600.0 / self.totals.duration_s)
    }

    /// Of all cars, for each of them.
    pub fn per_car(&self, sum: f64) -> Option<f64> {
        let cars = self.totals.all_motion.cars();
        (cars > 0).then(|| sum / cars as f64)
    }
}

/// Speeds of all cars by the code that judges policies: spread, calm, fuel.
pub(super) fn all_cars(totals: &DriveTotals) -> Option<&FlowTotals> {
    enough(&totals.all_cars)
}

/// Of a single step nothing can be told.
pub(super) fn enough(flow: &FlowTotals) -> Option<&FlowTotals> {
    (flow.steps() >= 2).then_some(flow)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Middle value; of an even number the mean of the two in the middle.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    middle(&values)
}

/// The same of values in order.
pub(super) fn middle(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    (n > 0).then(|| (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0)
}

/// Standard deviation, N-1.
pub(super) fn deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values)?;
    let square: f64 = values.iter().map(|x| (x - middle).powi(2)).sum();
    (values.len() > 1).then(|| (square / (values.len() - 1) as f64).sqrt())
}
