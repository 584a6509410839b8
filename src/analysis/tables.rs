//! Results as CSV. In: analysed drives. Out: text: `trials.csv` (a row per drive), `advice.csv` (a row per change of the advice
//! or sham), `speed.csv` (a row per second), `conditions.csv` (mean, deviation and 95 % bootstrap interval), `drivers.csv` (a
//! row per participant), `scores.csv` (a row per score of a participant). [`glossary`](super::glossary) defines the columns.

use super::{
    AnalysedRecording, MEASURES, RoadKinds,
    drivers::ParticipantDriver,
    glossary::names,
    measures::{deviation, median},
    people::{ParticipantScore, StudyParticipants},
};
use crate::metrics::Estimate;
use std::collections::BTreeSet;

/// Formats a finite number; empty for anything else.
pub(super) fn cell(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string())
}

pub(super) fn line(cells: impl IntoIterator<Item = String>) -> String {
    // RFC 4180: a quote within a cell is doubled.
    let quote = |c: String| format!("\"{}\"", c.replace('"', "\"\""));
    let quoted = cells.into_iter().map(|c| if c.contains([',', '"', '\n', '\r']) { quote(c) } else { c });
    quoted.collect::<Vec<_>>().join(",") + "\n"
}

/// Returns the names of the factors of the first drive.
pub(super) fn factors(drives: &[AnalysedRecording]) -> Vec<String> {
    drives.first().map(|d| d.found.levels.iter().map(|level| level.0.clone()).collect()).unwrap_or_default()
}

pub(super) fn key(drive: &AnalysedRecording) -> Vec<String> {
    let found = &drive.found;
    let mut cells =
        vec![found.participant.clone(), found.segment.clone(), found.place.clone(), found.condition.clone()];
    cells.extend(found.levels.iter().filter(|level| level.0 != "condition").map(|level| level.1.clone()));
    cells
}

/// Returns `trials.csv`: a row per drive.
pub fn trials(drives: &[AnalysedRecording]) -> String {
    let roads = RoadKinds::of(drives);
    let row = |drive: &AnalysedRecording| {
        let facts = [cell(Some(drive.duration_s)), drive.ended.clone()];
        let measured = MEASURES.iter().zip(&drive.measures.values).filter(|(measure, _)| measure.has_column(roads));
        line(key(drive).into_iter().chain(facts).chain(measured.map(|(_, value)| cell(*value))))
    };
    line(names(drives, "trials.csv")) + &drives.iter().map(row).collect::<String>()
}

/// Returns `scores.csv`: a row per score of a participant, and per trial for a questionnaire after every trial.
pub fn scores(drives: &[AnalysedRecording], people: &StudyParticipants) -> String {
    let row = |score: &ParticipantScore| {
        let ParticipantScore { participant, questionnaire, trial: [place, condition], name, value } = score;
        line([participant, questionnaire, place, condition, name, value].map(Clone::clone))
    };
    line(names(drives, "scores.csv")) + &people.each.iter().map(row).collect::<String>()
}

/// Returns `advice.csv`: a row per change of the advice or sham.
pub fn advice(drives: &[AnalysedRecording]) -> String {
    let mut text = line(names(drives, "advice.csv"));
    for drive in drives {
        for r in drive.responses() {
            let own = [
                r.kind.to_string(),
                cell(Some(r.onset_s)),
                cell(Some(r.from_mps)),
                cell(Some(r.to_mps)),
                cell(Some(r.speed_mps)),
                ["slower", "", "faster"][(r.direction + 1) as usize].into(),
                cell(r.reaction_s),
                r.is_under_way.to_string(),
                cell(r.movement_s),
                cell(r.enter_s),
                cell(r.enter_steps.map(|n| n as f64)),
                cell(Some(r.watched_s)),
                cell(Some(r.threshold)),
                r.noise_from.to_string(),
            ];
            text += &line(key(drive).into_iter().chain(own));
        }
    }
    text
}

/// Returns `speed.csv`: a row per second of every drive.
pub fn speed(drives: &[AnalysedRecording]) -> String {
    let mut text = line(names(drives, "speed.csv"));
    for drive in drives {
        for (second, speed) in drive.per_second_mps.iter().enumerate() {
            let baseline = drive.baseline_per_second_mps.get(second).copied();
            text += &line(key(drive).into_iter().chain([second.to_string(), cell(Some(*speed)), cell(baseline)]));
        }
    }
    text
}

/// Returns `drivers.csv`: a row per participant.
pub fn drivers(drives: &[AnalysedRecording], drivers: &[ParticipantDriver]) -> String {
    let row = |driver: &ParticipantDriver| {
        let cells = driver.found.numbers().into_iter().flat_map(|number| {
            let own = number.map(|n| [n.value, n.interval[0], n.interval[1], n.rests_on_s]);
            (0..4).map(move |k| cell(own.map(|own| own[k])))
        });
        line([driver.participant.clone()].into_iter().chain(cells))
    };
    line(names(drives, "drivers.csv")) + &drivers.iter().map(row).collect::<String>()
}

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

/// Returns `conditions.csv`: a row per condition and measure.
pub fn by_condition(drives: &[AnalysedRecording]) -> String {
    let mut text = line(names(drives, "conditions.csv"));
    for (condition, of) in conditions(drives) {
        for (k, measure) in MEASURES.iter().enumerate() {
            let values = values(&of, k);
            let Some(estimate) = Estimate::of(&values) else { continue };
            text += &line([
                condition.clone(),
                measure.name.into(),
                measure.unit.into(),
                values.len().to_string(),
                cell(Some(estimate.mean)),
                cell(deviation(&values)),
                cell(median(values)),
                cell(Some(estimate.low)),
                cell(Some(estimate.high)),
            ]);
        }
    }
    text
}

/// Paired differences of a measure between two conditions within participants, and the differences that would be detected.
#[derive(Clone, Debug, PartialEq)]
pub struct StatisticalPower {
    /// Index of the measure in [`MEASURES`].
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{DriveMeasures, DriveSetup, FoundRecording, driver_moments::DriverStretches};

    /// Returns a trial with a mean speed, which is the first measure.
    fn drive(participant: &str, condition: &str, rank: usize, mean_speed_mps: f64) -> AnalysedRecording {
        let mut values = vec![None; MEASURES.len()];
        values[0] = Some(mean_speed_mps);
        AnalysedRecording {
            found: FoundRecording {
                participant: participant.into(),
                segment: "trial".into(),
                condition: condition.into(),
                rank,
                levels: vec![("range".into(), format!("a \"{condition}\", so"))],
                ..FoundRecording::default()
            },
            measures: DriveMeasures { values, responses: Vec::new() },
            per_second_mps: vec![mean_speed_mps],
            baseline_per_second_mps: Vec::new(),
            duration_s: 1.0,
            ended: "duration".into(),
            setup: DriveSetup::default(),
            stretches: DriverStretches::default(),
            network: None,
        }
    }

    #[test]
    fn differences_are_paired_within_participants() {
        // Differences of 1, 2 and 3 m/s: mean 2, SD 1. The fourth participant has only one trial.
        let mut drives = vec![drive("sub-4", "wide", 0, 9.0)];
        for (i, (wide, narrow)) in [(3.0, 4.0), (2.0, 4.0), (5.0, 8.0)].into_iter().enumerate() {
            drives.push(drive(&format!("sub-{i}"), "narrow", 1, narrow));
            drives.push(drive(&format!("sub-{i}"), "wide", 0, wide));
        }
        let names: Vec<(String, usize)> = conditions(&drives).into_iter().map(|(name, of)| (name, of.len())).collect();
        assert_eq!(names, [("wide".into(), 4), ("narrow".into(), 3)], "in the study's order");
        let found = power(&drives, 0);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].n, found[0].mean, found[0].sd), (3, 2.0, 1.0));
        assert!((found[0].detectable(4) - 1.4).abs() < 1e-12);
        assert_eq!(found[0].needed(), Some(2.0), "(2.80 / 2)^2 = 1.96");
        let small = StatisticalPower { mean: 1.0, sd: 2.0, ..found[0].clone() };
        assert_eq!(small.needed(), Some(32.0), "(2.80 x 2)^2 = 31.4");
        let text = by_condition(&drives);
        assert!(text.contains("wide,mean_speed_mps,m/s,4,4.75,"), "{text}");
        assert!(text.contains("narrow,mean_speed_mps,m/s,3,5.333333333333333,2.309401076758503,4,"), "{text}");
    }

    #[test]
    fn a_participant_with_two_drives_in_a_condition_counts_once() {
        let drives = [drive("sub-1", "wide", 0, 2.0), drive("sub-2", "wide", 0, 6.0), drive("sub-1", "wide", 0, 4.0)];
        let of: Vec<&AnalysedRecording> = drives.iter().collect();
        assert_eq!(per_participant(&of, 0), [("sub-1", 3.0), ("sub-2", 6.0)]);
        assert_eq!((values(&of, 0), participants(&of)), (vec![3.0, 6.0], 2));
        assert!(by_condition(&drives).contains("wide,mean_speed_mps,m/s,2,4.5,"));
    }

    #[test]
    fn cells_with_commas_and_quotes_stay_one_cell() {
        let text = trials(&[drive("sub-1", "wide", 0, 4.5)]);
        let mut lines = text.lines();
        assert!(
            lines
                .next()
                .unwrap()
                .starts_with("participant,segment,place,condition,range,duration_s,ended,mean_speed_mps,")
        );
        assert!(
            lines.next().unwrap().starts_with("sub-1,trial,,wide,\"a \"\"wide\"\", so\",1,duration,4.5,,"),
            "{text}"
        );
    }
}
