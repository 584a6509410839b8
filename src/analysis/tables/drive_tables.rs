//! Tables of drives. In: analysed drives. Out: `trials.csv` (a row per drive) and `speed.csv` (a row per second), with their
//! columns.

use super::key::{key, key_columns};
use crate::analysis::{
    columns::{ColumnDefinition, ColumnTexts, TableColumns, cell, columns, line},
    drives::{AnalysedRecording, road_kinds},
    measures::MEASURES,
};
use crate::metrics::registry::measure;

const DRIVE: [ColumnTexts; 2] = [
    measure("duration_s").texts(),
    (
        "ended",
        "End",
        "",
        "end of the drive: duration (planned time over), contact, or the person or cause that stopped the drive",
    ),
];

const SPEED: [ColumnTexts; 3] = [
    ("second", "Second", "s", "second of the drive; speeds are means over it"),
    (
        "mean_speed_mps",
        "Mean speed of all vehicles",
        "m/s",
        "speed of all vehicles, the ego vehicle included: mean over the vehicles and over the second",
    ),
    (
        "baseline_speed_mps",
        "Mean speed of all vehicles without advice",
        "m/s",
        "mean speed of all vehicles in the drive from the same seed without advice; empty if there is none",
    ),
];

/// Returns the columns of `trials.csv`.
pub(crate) fn trials_columns(drives: &[AnalysedRecording]) -> TableColumns {
    let roads = road_kinds(drives);
    let measures = MEASURES.iter().filter(|measure| measure.has_column(roads)).map(|measure| ColumnDefinition {
        name: measure.name.into(),
        title: measure.title.into(),
        unit: measure.unit,
        about: measure.definition(roads),
    });
    let columns = key_columns(drives).into_iter().chain(columns(&DRIVE)).chain(measures).collect();
    TableColumns { file: "trials.csv", row: "a drive", columns }
}

/// Returns `trials.csv`: a row per drive.
pub fn trials(drives: &[AnalysedRecording]) -> String {
    let roads = road_kinds(drives);
    let row = |drive: &AnalysedRecording| {
        let facts = [cell(Some(drive.duration_s)), drive.ended.clone()];
        let measured = MEASURES.iter().zip(&drive.measures.values).filter(|(measure, _)| measure.has_column(roads));
        line(key(drive).into_iter().chain(facts).chain(measured.map(|(_, value)| cell(*value))))
    };
    trials_columns(drives).head() + &drives.iter().map(row).collect::<String>()
}

/// Returns the columns of `speed.csv`.
pub(crate) fn speed_columns(drives: &[AnalysedRecording]) -> TableColumns {
    let columns = key_columns(drives).into_iter().chain(columns(&SPEED)).collect();
    TableColumns { file: "speed.csv", row: "a second of a drive", columns }
}

/// Returns `speed.csv`: a row per second of every drive.
pub fn speed(drives: &[AnalysedRecording]) -> String {
    let mut text = speed_columns(drives).head();
    for drive in drives {
        for (second, speed) in drive.per_second_mps.iter().enumerate() {
            let baseline = drive.baseline_per_second_mps.get(second).copied();
            text += &line(key(drive).into_iter().chain([second.to_string(), cell(Some(*speed)), cell(baseline)]));
        }
    }
    text
}
