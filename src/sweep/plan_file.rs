//! Contents of the file of a sweep's plan. In: TOML. Out: its tables, with settings as they are written, which `plan` checks.

use crate::{scenario::Scenario, train::TrainConfig};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;
use std::{collections::BTreeMap, path::PathBuf};

/// Shortest and longest time limit of a run, s; the longest is a hundred days.
pub(super) const LEAST_LIMIT_S: f64 = 0.1;
pub(super) const MOST_LIMIT_S: f64 = 8_640_000.0;
/// Largest number of rings of a run.
pub(super) const MOST_RINGS: u32 = 1_000_000;

/// Contents of a plan file. Each table gives all combinations of the lists below `each`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// Runs on rings of the fast engine.
    #[serde(default)]
    pub(super) rings: Vec<RingsTable>,
    /// Drives of whole scenarios.
    #[serde(default)]
    pub(super) drives: Vec<DrivesTable>,
    /// Trainings of policies by TRPO.
    #[serde(default)]
    pub(super) trainings: Vec<TrainingsTable>,
    /// Rehearsals of studies with simulated participants.
    #[serde(default)]
    pub(super) rehearsals: Vec<RehearsalsTable>,
}

/// Values of a setting that varies, for the schema.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "only its schema is used")]
enum VariedSetting {
    /// Values one by one.
    List(#[schemars(length(min = 1))] Vec<Value>),
    /// Whole numbers from one to another.
    Range(#[schemars(regex(pattern = r"^\s*[0-9]+\s*-\s*[0-9]+\s*$"))] String),
    /// Settings of a table.
    Table(BTreeMap<String, VariedSetting>),
}

/// A `[[rings]]` table of the plan: a policy on rings of the fast engine.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RingsTable {
    /// Name of the table in results.
    pub name: Option<String>,
    /// Path of a file with the settings of a training; settings that it leaves out have their default.
    pub config: Option<PathBuf>,
    /// Number of rings of each run.
    #[schemars(range(min = 1, max = MOST_RINGS))]
    pub rings: Option<u32>,
    /// Time limit of a run, s of wall time.
    #[schemars(range(min = LEAST_LIMIT_S, max = MOST_LIMIT_S), extend("unit" = "s"))]
    pub limit_s: Option<f64>,
    /// Settings that all runs of the table have, by their keys.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, Value>")]
    pub settings: toml::Table,
    /// Settings that vary, each with the list of its values, or a range of whole numbers such as "1-20".
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, VariedSetting>")]
    pub each: toml::Table,
}

/// A `[[drives]]` table of the plan.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct DrivesTable {
    /// Name of the table in results.
    pub name: Option<String>,
    /// Path of a scenario file; without it, the default scenario.
    pub scenario: Option<PathBuf>,
    /// Time limit of a run, s of wall time.
    #[schemars(range(min = LEAST_LIMIT_S, max = MOST_LIMIT_S), extend("unit" = "s"))]
    pub limit_s: Option<f64>,
    /// Settings that all runs of the table have, by their keys.
    #[serde(default)]
    #[schemars(with = "Scenario")]
    pub settings: toml::Table,
    /// Settings that vary, each with the list of its values, or a range of whole numbers such as "1-20".
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, VariedSetting>")]
    pub each: toml::Table,
}

/// A `[[trainings]]` table of the plan.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TrainingsTable {
    /// Name of the table in results.
    pub name: Option<String>,
    /// Path of a file with the settings of a training; settings that it leaves out have their default.
    pub config: Option<PathBuf>,
    /// Time limit of a run, s of wall time.
    #[schemars(range(min = LEAST_LIMIT_S, max = MOST_LIMIT_S), extend("unit" = "s"))]
    pub limit_s: Option<f64>,
    /// Settings that all runs of the table have, by their keys.
    #[serde(default)]
    #[schemars(with = "TrainConfig")]
    pub settings: toml::Table,
    /// Settings that vary, each with the list of its values, or a range of whole numbers such as "1-20".
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, VariedSetting>")]
    pub each: toml::Table,
}

/// A `[[rehearsals]]` table of the plan.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RehearsalsTable {
    /// Name of the table in results.
    pub name: Option<String>,
    /// Path of the study file.
    pub study: PathBuf,
    /// Time limit of a run, s of wall time.
    #[schemars(range(min = LEAST_LIMIT_S, max = MOST_LIMIT_S), extend("unit" = "s"))]
    pub limit_s: Option<f64>,
    /// Settings that all runs of the table have, by their keys.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, Value>")]
    pub settings: toml::Table,
    /// Settings that vary, each with the list of its values, or a range of whole numbers such as "1-20".
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, VariedSetting>")]
    pub each: toml::Table,
}
