//! Ratings of sickness while driving (fast motion sickness scale). In: a participant's table of ratings in a data set. Out: a
//! [`SicknessRating`] per question. Ratings of drives that were broken off are included, so that the highest ratings are not
//! lost with drives stopped because of sickness.

use super::tsv::{MISSING, TsvFile};
use crate::analysis::error::AnalysisError;
use std::path::Path;

/// A question with its answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SicknessRating {
    /// Participant's id, such as `sub-P03`.
    pub participant: String,
    /// Segment, place and condition of the drive, and the folder of its recording.
    pub drive: [String; 4],
    /// Time of the question, seconds since the start of the drive.
    pub time_s: f64,
    /// Rating, 0 to 20; `None` without an answer.
    pub value: Option<f64>,
    /// Time from the question to the answer, seconds.
    pub answer_s: Option<f64>,
}

/// Reads the ratings of one participant of a data set; none without a table.
pub(crate) fn ratings(root: &Path, subject: &str) -> Result<Vec<SicknessRating>, AnalysisError> {
    let path = root.join(subject).join("beh").join(format!("{subject}_task-fmsRatings_beh.tsv"));
    let Some(table) = TsvFile::read(&path)? else { return Ok(Vec::new()) };
    let names = ["segment", "place", "condition", "recording", "onset", "value", "response_time"];
    let mut at = [0; 7];
    for (at, name) in at.iter_mut().zip(names) {
        *at = table.column(name)?;
    }
    let rating = |(i, row): (usize, &Vec<String>)| {
        let word = |k: usize| if row[at[k]] == MISSING { String::new() } else { row[at[k]].clone() };
        let number = |k: usize| match word(k) {
            text if text.is_empty() => Ok(None),
            text => text.parse::<f64>().map(Some).map_err(|_| {
                let (path, line) = (path.display(), i + 2);
                AnalysisError::Input(format!("{path}: line {line}: {} is \"{text}\"; allowed: a number", names[k]))
            }),
        };
        Ok(SicknessRating {
            participant: subject.into(),
            drive: [0, 1, 2, 3].map(word),
            time_s: number(4)?.unwrap_or_default(),
            value: number(5)?,
            answer_s: number(6)?,
        })
    };
    table.rows.iter().enumerate().map(rating).collect()
}
