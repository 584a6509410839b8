//! Measures of one drive. In: its totals, and optionally the totals of the same drive without advice. Out: [`DriveMeasures`].
//! Each measure is over the whole trial unless its row in [`MEASURES`] says otherwise. The two lists that make it up
//! (`every_drive` and `on_networks`) compute the measures; [`crate::metrics::registry`] defines them.

use super::{
    MeasuredValue, every_drive::OF_EVERY_DRIVE, inputs::MeasureInputs, on_networks::OF_NETWORKS, totals::DriveTotals,
};
use crate::{
    analysis::{
        data::RecordedTrial,
        responses::{AdviceResponse, ScriptedResponse},
    },
    metrics::Measure,
};

/// Measures of a drive; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveMeasures {
    /// Values in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// Responses to every change of the advice, requests and shams included.
    pub responses: Vec<AdviceResponse>,
}

/// All measures: first `OF_EVERY_DRIVE`, then `OF_NETWORKS`.
pub const MEASURES: &[Measure] = &joined::<{ OF_EVERY_DRIVE.len() + OF_NETWORKS.len() }>();

const fn joined<const N: usize>() -> [Measure; N] {
    let mut all = [OF_EVERY_DRIVE[0].0; N];
    let mut i = 1;
    while i < N {
        all[i] = if i < OF_EVERY_DRIVE.len() { OF_EVERY_DRIVE[i].0 } else { OF_NETWORKS[i - OF_EVERY_DRIVE.len()].0 };
        i += 1;
    }
    all
}

impl DriveMeasures {
    /// Computes the measures of a drive from its totals, its responses to advice and events, and the totals of the same drive without advice.
    pub fn of(
        trial: &RecordedTrial,
        totals: &DriveTotals,
        responses: Vec<AdviceResponse>,
        events: &[ScriptedResponse],
        baseline: Option<&DriveTotals>,
    ) -> Self {
        let task = trial.task.scores(totals.duration_s);
        let takeovers = totals.takeovers.scores();
        let sight = MeasureInputs { trial, totals, baseline, responses: &responses, events, task, takeovers };
        let roads = trial.setup.roads();
        let value = |(measure, of): &MeasuredValue| of(&sight).filter(|_| measure.is_on(roads));
        Self { values: OF_EVERY_DRIVE.iter().chain(OF_NETWORKS).map(value).collect(), responses }
    }

    /// Returns the value of a measure by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = MEASURES.iter().position(|measure| measure.name == name)?;
        self.values.get(at).copied().flatten()
    }
}

/// Returns the index of a measure in [`MEASURES`] by its name.
pub(crate) fn index(name: &str) -> usize {
    MEASURES.iter().position(|measure| measure.name == name).expect("a measure of the list")
}

#[cfg(test)]
#[path = "drive_measures_tests.rs"]
mod tests;
