//! What is written of a run. In: results. Out: rows with their columns, one list a kind: the only place that names a column.

use crate::{
    metrics::EvaluationResult,
    record::{
        TableColumn,
        table::ColumnValue::{self, Flag, Number, Whole, Word},
    },
    train::LearningCurveRow,
};

/// What every row begins with.
#[derive(Clone, Debug, Default)]
pub struct RowHead {
    /// Fingerprint of the run.
    pub run: String,
    /// Table of the plan.
    pub table: String,
    /// What is varied in it, as JSON.
    pub varied: String,
    /// Seed.
    pub seed: u64,
}

/// A drive, or one ring of a run on rings.
#[derive(Clone, Debug)]
pub struct DriveRow {
    /// The run.
    pub head: RowHead,
    /// Which of its rings; 0 of a drive.
    pub ring: u64,
    /// Where it was driven.
    pub map: String,
    /// What moved the cars.
    pub engine: String,
    /// Policy.
    pub policy: String,
    /// Who followed.
    pub driver: String,
    /// Hold, seconds.
    pub hold_s: f64,
    /// What came of it.
    pub result: EvaluationResult,
}

/// An update of a training.
#[derive(Clone, Debug)]
pub struct TrainingRow {
    /// The run.
    pub head: RowHead,
    /// The update.
    pub update: LearningCurveRow,
    /// The best policy (its file's text) in the row of the update that it is of; else empty.
    pub policy: String,
}

/// A number of a rehearsal: a measure of a trial, or a planned difference.
#[derive(Clone, Debug)]
pub struct RehearsalRow {
    /// The run.
    pub head: RowHead,
    /// `trial` or `contrast`.
    pub kind: &'static str,
    /// Participant of the trial.
    pub participant: String,
    /// Place of the trial.
    pub place: String,
    /// Condition of the trial, or that of the difference.
    pub condition: String,
    /// What it is compared with.
    pub reference: String,
    /// Name of the measure.
    pub measure: String,
    /// The measure, or the difference, in its unit.
    pub value: Option<f64>,
    /// Probability of such a difference without an effect, and by Holm's correction.
    pub p: [Option<f64>; 2],
}

fn column<R>(name: &'static str, unit: &'static str, about: &'static str, get: ColumnValue<R>) -> TableColumn<R> {
    TableColumn { name, unit, about, get }
}

/// Columns of what every row begins with.
macro_rules! head {
    ($row:ty) => {
        vec![
            column("run", "", "fingerprint of all that the run is made of", Word(|row: &$row| row.head.run.clone())),
            column("table", "", "table of the plan", Word(|row: &$row| row.head.table.clone())),
            column("varied", "", "what is varied in that table, as JSON", Word(|row: &$row| row.head.varied.clone())),
            column("seed", "", "seed of everything random", Whole(|row: &$row| row.head.seed)),
        ]
    };
}

/// Columns of drives and of rings.
pub fn drive_columns() -> Vec<TableColumn<DriveRow>> {
    let mut columns = head!(DriveRow);
    columns.extend([
        column("ring", "", "which ring of the run, from 0", Whole(|row: &DriveRow| row.ring)),
        column("map", "", "road", Word(|row| row.map.clone())),
        column("engine", "", "what moved the cars: ring, native or sumo", Word(|row| row.engine.clone())),
        column("policy", "", "advising policy", Word(|row| row.policy.clone())),
        column("driver", "", "who followed the advice", Word(|row| row.driver.clone())),
        column("hold_s", "s", "how long one advice stood", Number(|row| Some(row.hold_s))),
        column(
            "mean_speed_mps",
            "m/s",
            "mean speed of all cars over the horizon",
            Number(|row| Some(row.result.mean_mps)),
        ),
        column(
            "settled_speed_mps",
            "m/s",
            "the same over its last quarter",
            Number(|row| Some(row.result.settled_mps)),
        ),
        column(
            "sd_over_cars_mps",
            "m/s",
            "deviation of speed over the cars",
            Number(|row| Some(row.result.sd_over_cars_mps)),
        ),
        column(
            "sd_in_time_mps",
            "m/s",
            "deviation of a car's speed in time",
            Number(|row| Some(row.result.sd_in_time_mps)),
        ),
        column("last_disturbance_s", "s", "when the wave was last seen", Number(|row| row.result.last_disturbance_s)),
        column("least_gap_m", "m", "smallest gap before or behind the ego", Number(|row| Some(row.result.least_gap_m))),
        column("crashed", "", "cars collided", Flag(|row| Some(row.result.crashed))),
        column("crash_s", "s", "when they did", Number(|row| row.result.crash_s)),
        column("fuel_l_100km", "l/100 km", "fuel of all cars", Number(|row| row.result.fuel_l_100km)),
        column(
            "throughput_per_h",
            "1/h",
            "cars past a place in an hour",
            Number(|row| Some(row.result.throughput_per_h)),
        ),
        column("in_range", "", "share of the time in the advised range", Number(|row| row.result.in_range)),
    ]);
    columns
}

/// Columns of trainings.
pub fn training_columns() -> Vec<TableColumn<TrainingRow>> {
    let mut columns = head!(TrainingRow);
    columns.extend([
        column("iteration", "", "number of the update, from 1", Whole(|row: &TrainingRow| row.update.iteration.into())),
        column("env_steps", "", "steps of rings so far", Whole(|row| row.update.env_steps)),
        column(
            "mean_speed_mps",
            "m/s",
            "mean speed of the batch, with the policy's noise",
            Number(|row| Some(row.update.mean_mps)),
        ),
        column("reward_mps", "m/s", "mean reward", Number(|row| Some(row.update.reward))),
        column("crashes", "", "episodes that ended in a crash", Whole(|row| row.update.crashes.into())),
        column("kl_nat", "nat", "KL divergence of the step", Number(|row| Some(row.update.kl))),
        column("entropy_nat", "nat", "entropy of the policy before it", Number(|row| Some(row.update.entropy))),
        column("value_error", "", "mean square error of the value", Number(|row| Some(row.update.value_error))),
        column(
            "judged_speed_mps",
            "m/s",
            "mean speed without noise over whole horizons, where judged",
            Number(|row| row.update.judged_mps),
        ),
        column(
            "policy",
            "",
            "text of the best policy's file, in the row of its update",
            Word(|row| row.policy.clone()),
        ),
    ]);
    columns
}

/// Columns of rehearsals.
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
        column("reference", "", "condition that it is compared with", Word(|row| row.reference.clone())),
        column("measure", "", "name of the measure, with its unit", Word(|row| row.measure.clone())),
        column("value", "", "the measure, or the difference", Number(|row| row.value)),
        column("p", "", "probability of such a difference without an effect", Number(|row| row.p[0])),
        column("p_holm", "", "the same by Holm's correction over the plan", Number(|row| row.p[1])),
    ]);
    columns
}
