//! Rows of a run. In: results. Out: rows with their columns, one list per kind. The registry of measures defines those of measures, this
//! file all others.

use crate::{
    metrics::{EVALUATED, EvaluationResult, Measure, registry},
    record::{
        TableColumn,
        table::ColumnValue::{self, Flag, Number, Whole, Word},
    },
    train::LearningCurveRow,
};

/// Common fields of all rows.
#[derive(Clone, Debug, Default)]
pub struct RowHead {
    /// Fingerprint of the run.
    pub run: String,
    /// Name of the plan's table.
    pub table: String,
    /// Varied settings as JSON.
    pub varied: String,
    /// Seed of all random numbers of the run.
    pub seed: u64,
}

/// A drive, or one ring of a run on rings.
#[derive(Clone, Debug)]
pub struct DriveRow {
    pub head: RowHead,
    /// Index of the ring in the run, from 0; 0 for a drive.
    pub ring: u64,
    /// Name of the map; empty for rings.
    pub map: String,
    /// Traffic engine: `ring`, `native` or `sumo`.
    pub traffic: String,
    /// Name of the advising policy.
    pub policy: String,
    /// Name of the driver who followed the advice.
    pub driver: String,
    /// Hold of each advice, s.
    pub hold_s: f64,
    /// Number of advised vehicles of each ring or drive; on a network of those that entered.
    pub advised_vehicles: u32,
    /// Planned share of advised vehicles, 0 to 1, also in a drive without advice; on a network of those that enter.
    pub advised_share: f64,
    /// Evaluation of the drive.
    pub result: EvaluationResult,
}

/// One update of a training.
#[derive(Clone, Debug)]
pub struct TrainingRow {
    pub head: RowHead,
    /// Learning-curve entry of the update.
    pub update: LearningCurveRow,
    /// Text of the best policy's file in the row of its update; empty in the other rows.
    pub policy: String,
}

/// One number of a rehearsal: a measure of a trial, or a planned contrast.
#[derive(Clone, Debug)]
pub struct RehearsalRow {
    pub head: RowHead,
    /// Kind of the number: `trial` or `contrast`.
    pub kind: &'static str,
    /// Participant of the trial; empty for a contrast.
    pub participant: String,
    /// Place of the trial among the trials; empty for a contrast.
    pub place: String,
    /// Condition of the trial, or the compared condition of the contrast.
    pub condition: String,
    /// Reference condition of the contrast; empty for a trial.
    pub reference: String,
    /// Name of the measure.
    pub measure: String,
    /// Measure or difference, in the unit of the measure.
    pub value: Option<f64>,
    /// p-value of the contrast, and its p-value after Holm's correction over the plan; `None` for a trial.
    pub p: [Option<f64>; 2],
}

fn column<R>(name: &'static str, unit: &'static str, about: &'static str, get: ColumnValue<R>) -> TableColumn<R> {
    TableColumn { name, unit, about, get }
}

/// Returns the column of a measure of the registry.
fn measured<R>(name: &str, get: ColumnValue<R>) -> TableColumn<R> {
    let Measure { name, unit, about, .. } = registry::measure(name);
    column(name, unit, about, get)
}

/// Columns of the common fields.
macro_rules! head {
    ($row:ty) => {
        vec![
            column("run", "", "fingerprint of all inputs of the run", Word(|row: &$row| row.head.run.clone())),
            column("table", "", "table of the plan", Word(|row: &$row| row.head.table.clone())),
            column("varied", "", "varied settings of that table, as JSON", Word(|row: &$row| row.head.varied.clone())),
            column("seed", "", "seed of all random numbers", Whole(|row: &$row| row.head.seed)),
        ]
    };
}

/// Returns the accessors of the measures of evaluations, in their order; a column's accessor captures nothing, hence the numbers.
fn evaluated() -> [ColumnValue<DriveRow>; EVALUATED.len()] {
    macro_rules! at {
        ($($k:literal)*) => { [$(Number(|row: &DriveRow| EVALUATED[$k].1(&row.result))),*] };
    }
    at!(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24)
}

/// Returns the columns of drives and rings.
pub fn drive_columns() -> Vec<TableColumn<DriveRow>> {
    let mut columns = head!(DriveRow);
    columns.extend([
        column("ring", "", "number of the ring in the run, from 0", Whole(|row: &DriveRow| row.ring)),
        column("map", "", "road", Word(|row| row.map.clone())),
        column("traffic", "", "engine of the traffic: ring, native or sumo", Word(|row| row.traffic.clone())),
        column("policy", "", "advising policy", Word(|row| row.policy.clone())),
        column("driver", "", "driver who followed the advice", Word(|row| row.driver.clone())),
        column("hold_s", "s", "time for which one advice was held", Number(|row| Some(row.hold_s))),
        measured("advised_vehicles", Whole(|row| row.advised_vehicles.into())),
        measured("advised_share", Number(|row| Some(row.advised_share))),
    ]);
    columns.extend(EVALUATED.iter().zip(evaluated()).map(|((measure, _), get)| match measure.name {
        "crashed" => measured(measure.name, Flag(|row: &DriveRow| Some(row.result.crashed))),
        name => measured(name, get),
    }));
    columns
}

/// Returns the columns of trainings.
pub fn training_columns() -> Vec<TableColumn<TrainingRow>> {
    let mut columns = head!(TrainingRow);
    columns.extend([
        column("iteration", "", "number of the update, from 1", Whole(|row: &TrainingRow| row.update.iteration.into())),
        column("env_steps", "", "steps of rings so far", Whole(|row| row.update.env_steps)),
        measured("batch_mean_speed_mps", Number(|row| Some(row.update.mean_mps))),
        measured("reward_mps", Number(|row| Some(row.update.reward))),
        measured("crashes", Whole(|row| row.update.crashes.into())),
        measured("kl_nat", Number(|row| Some(row.update.kl))),
        measured("entropy_nat", Number(|row| Some(row.update.entropy))),
        measured("value_error", Number(|row| Some(row.update.value_error))),
        measured("judged_speed_mps", Number(|row| row.update.judged_mps)),
        column(
            "policy",
            "",
            "text of the best policy's file, in the row of its update",
            Word(|row| row.policy.clone()),
        ),
    ]);
    columns
}

/// Returns the columns of rehearsals.
pub fn rehearsal_columns() -> Vec<TableColumn<RehearsalRow>> {
    let mut columns = head!(RehearsalRow);
    columns.extend([
        column(
            "kind",
            "",
            "trial: a measure of a trial; contrast: a planned difference",
            Word(|row: &RehearsalRow| row.kind.into()),
        ),
        column("participant", "", "participant of the trial", Word(|row| row.participant.clone())),
        column("place", "", "place among the trials", Word(|row| row.place.clone())),
        column("condition", "", "condition of the trial, or that of the difference", Word(|row| row.condition.clone())),
        column("reference", "", "condition that the first one is compared with", Word(|row| row.reference.clone())),
        column("measure", "", "name of the measure, with its unit", Word(|row| row.measure.clone())),
        column("value", "", "value of the measure, or the difference", Number(|row| row.value)),
        column("p", "", "probability of such a difference without an effect", Number(|row| row.p[0])),
        column("p_holm", "", "p by Holm's correction over the plan", Number(|row| row.p[1])),
    ]);
    columns
}
