//! Table of conditions. In: analysed drives. Out: `conditions.csv` (mean, deviation and 95 % bootstrap interval of each measure
//! in each condition), with its columns.

use crate::analysis::{
    columns::{ColumnTexts, TableColumns, cell, columns, line},
    drives::{AnalysedRecording, conditions, values},
    measures::MEASURES,
    statistics::{deviation, median},
};
use crate::metrics::Estimate;

const CONDITIONS: [ColumnTexts; 9] = [
    ("condition", "Condition", "", "condition of the trials"),
    ("measure", "Measure", "", "name of the measure, as the column of the table of trials"),
    ("unit", "Unit", "", "unit of the measure"),
    (
        "n",
        "Participants",
        "",
        "number of participants with a value; several drives of a participant in the condition count once, by their \
         mean",
    ),
    ("mean", "Mean", "", "mean over participants"),
    ("sd", "Standard deviation", "", "standard deviation over participants (N−1)"),
    ("median", "Median", "", "median over participants"),
    (
        "low",
        "Interval, lower end",
        "",
        "lower end of the 95 % confidence interval of the mean (percentile bootstrap over participants)",
    ),
    ("high", "Interval, upper end", "", "upper end of the 95 % confidence interval of the mean"),
];

/// Returns the columns of `conditions.csv`.
pub(crate) fn by_condition_columns() -> TableColumns {
    TableColumns { file: "conditions.csv", row: "a measure in a condition", columns: columns(&CONDITIONS) }
}

/// Returns `conditions.csv`: a row per condition and measure.
pub fn by_condition(drives: &[AnalysedRecording]) -> String {
    let mut text = by_condition_columns().head();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{
        data::{DriveSetup, DriverStretches, FoundRecording},
        drives::{StatisticalPower, participants, per_participant, power},
        measures::DriveMeasures,
        tables::trials,
    };

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
            scripted_responses: Vec::new(),
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
