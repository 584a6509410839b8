//! Drives by condition and participant. In: analysed drives. Out: the drives of each condition, a measure of each participant,
//! and paired differences within participants.

use super::analysed::AnalysedRecording;
use crate::analysis::statistics::deviation;
use std::collections::BTreeSet;

/// Groups drives by condition, in the study's order; drives without one are left out.
pub fn conditions(drives: &[AnalysedRecording]) -> Vec<(String, Vec<&AnalysedRecording>)> {
    let mut list: Vec<(String, Vec<&AnalysedRecording>)> = Vec::new();
    for drive in drives.iter().filter(|d| !d.found.condition.is_empty()) {
        match list.iter_mut().find(|(name, _)| *name == drive.found.condition) {
            Some((_, of)) => of.push(drive),
            None => list.push((drive.found.condition.clone(), vec![drive])),
        }
    }
    list.sort_by_key(|(_, of)| of[0].found.rank);
    list
}

/// Returns a measure of each participant who has it: the mean over their drives among these, so that each participant counts
/// once.
pub fn per_participant<'a>(of: &[&'a AnalysedRecording], measure: usize) -> Vec<(&'a str, f64)> {
    let mut sums: Vec<(&str, f64, usize)> = Vec::new();
    for drive in of {
        let Some(value) = drive.measures.values[measure] else { continue };
        let participant = drive.found.participant.as_str();
        match sums.iter_mut().find(|sum| sum.0 == participant) {
            Some(sum) => (sum.1, sum.2) = (sum.1 + value, sum.2 + 1),
            None => sums.push((participant, value, 1)),
        }
    }
    sums.into_iter().map(|(participant, sum, n)| (participant, sum / n as f64)).collect()
}

/// Returns the values of [`per_participant`] without the names.
pub fn values(of: &[&AnalysedRecording], measure: usize) -> Vec<f64> {
    per_participant(of, measure).into_iter().map(|(_, value)| value).collect()
}

/// Returns the number of participants of these drives.
pub fn participants(of: &[&AnalysedRecording]) -> usize {
    of.iter().map(|drive| drive.found.participant.as_str()).collect::<BTreeSet<_>>().len()
}

/// Paired differences of a measure between two conditions within participants, and the differences that would be detected.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticalPower {
    /// Index of the measure in [`MEASURES`](crate::analysis::measures::MEASURES).
    pub measure: usize,
    /// Names of the two conditions.
    pub pair: [String; 2],
    /// Number of participants with both conditions.
    pub n: usize,
    /// Mean of the differences, second condition less first.
    pub mean: f64,
    /// Standard deviation (N-1) of the differences.
    pub sd: f64,
}

impl StatisticalPower {
    /// Returns the difference that `n` participants show with a power of 80 % at a two-sided level of 5 %: 2.80 standard
    /// errors.
    pub fn detectable(&self, n: usize) -> f64 {
        2.80 * self.sd / (n as f64).sqrt()
    }

    /// Returns the number of participants who would show the difference found, as above; `None` for a difference of 0.
    pub fn needed(&self) -> Option<f64> {
        (self.mean != 0.0).then(|| (2.80 * self.sd / self.mean).powi(2).ceil().max(2.0))
    }
}

/// Returns the paired differences of a measure between all pairs of conditions.
pub fn power(drives: &[AnalysedRecording], measure: usize) -> Vec<StatisticalPower> {
    let conditions = conditions(drives);
    let mut list = Vec::new();
    for (i, (first, a)) in conditions.iter().enumerate() {
        for (second, b) in &conditions[i + 1..] {
            let other = per_participant(b, measure);
            let differences: Vec<f64> = per_participant(a, measure)
                .into_iter()
                .filter_map(|(participant, one)| Some(other.iter().find(|(name, _)| *name == participant)?.1 - one))
                .collect();
            if let Some(sd) = deviation(&differences) {
                let n = differences.len();
                let mean = differences.iter().sum::<f64>() / n as f64;
                list.push(StatisticalPower { measure, pair: [first.clone(), second.clone()], n, mean, sd });
            }
        }
    }
    list
}

/// Checks whether the drives have more than one participant.
pub(crate) fn is_of_several_people(drives: &[AnalysedRecording]) -> bool {
    participants(&drives.iter().collect::<Vec<_>>()) > 1
}
