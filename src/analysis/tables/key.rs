//! Columns that identify the drive of a row. In: an analysed drive. Out: participant, segment, place, condition and levels of
//! factors, and the definitions of these columns.

use crate::analysis::{
    columns::{ColumnDefinition, ColumnTexts, columns},
    drives::AnalysedRecording,
};

/// Columns of every drive.
pub(super) const KEY: [ColumnTexts; 4] = [
    ("participant", "Participant", "", "code of the participant; empty outside of a study"),
    ("segment", "Segment", "", "segment of the study; empty outside of a study"),
    ("place", "Place", "", "place among the trials of the segment, from 1"),
    ("condition", "Condition", "", "condition of the trial; empty for a drive that is the same for everyone"),
];

/// Returns the names of the factors of the first drive.
pub(super) fn factors(drives: &[AnalysedRecording]) -> Vec<String> {
    drives.first().map(|d| d.found.levels.iter().map(|level| level.0.clone()).collect()).unwrap_or_default()
}

/// Returns the columns that identify the drive of a row.
pub(super) fn key_columns(drives: &[AnalysedRecording]) -> Vec<ColumnDefinition> {
    let factor = |name: String| ColumnDefinition {
        title: format!("Factor {name}"),
        about: format!("level of the factor {name} in the study's plan"),
        name,
        unit: "",
    };
    // A study without factors names its one factor "condition", which is a column already.
    let factors = factors(drives).into_iter().filter(|name| name != "condition").map(factor);
    columns(&KEY).into_iter().chain(factors).collect()
}

pub(super) fn key(drive: &AnalysedRecording) -> Vec<String> {
    let found = &drive.found;
    let mut cells =
        vec![found.participant.clone(), found.segment.clone(), found.place.clone(), found.condition.clone()];
    cells.extend(found.levels.iter().filter(|level| level.0 != "condition").map(|level| level.1.clone()));
    cells
}
