//! The plan of a sweep. In: a TOML file. Out: its runs, each with all its settings, checked. Each table of the file gives all
//! combinations of the lists below `each`, the alphabetically last name changing fastest; `settings` are common to all of them.

use super::{
    SweepError,
    combinations::{Combination, combinations},
    plan_file::{
        DrivesTable, LEAST_LIMIT_S, MOST_LIMIT_S, MOST_RINGS, PlanFile, RehearsalsTable, RingsTable, TrainingsTable,
    },
};
use crate::{
    driver::{self, Population},
    file::{SETTINGS_BYTES, read_text},
    policy::{self, PolicySource},
    scenario::{self, Scenario},
    settings::{self, Field, Settings, fields_of},
    study::Study,
    toml_text::{self, KeyPart, did_you_mean, did_you_mean_file, unknown_key},
    train::TrainConfig,
};
use serde_json::{Map, Value};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Largest number of runs in a plan; their list takes half a gigabyte.
pub const MOST_RUNS: usize = 1_000_000;
/// Default number of rings of a run on the fast ring: one block.
const RINGS: u32 = 16;
/// Names allowed below `settings` and `each` of rings in addition to the settings of a training.
const OF_RINGS: [&str; 3] = ["policy", "driver", "policy_speed_mps"];
/// Names allowed below `settings` and `each` of rehearsals.
const OF_REHEARSALS: [&str; 3] = ["seed", "participants", "population"];

/// One run of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRun {
    /// Index of the run in the plan, from 0.
    pub number: usize,
    /// Name of the run's table in the plan, or its kind and number.
    pub table: String,
    /// Varied settings of the table with this run's values.
    pub varied: Map<String, Value>,
    /// Time limit of the run, s of wall time; `None`: no limit. It does not affect the result.
    pub limit_s: Option<f64>,
    /// Task of the run.
    pub task: SweepTask,
}

impl std::fmt::Display for SweepRun {
    /// Writes the table and the varied settings.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let varied: Vec<String> = self.varied.iter().map(|(name, value)| format!("{name} {value}")).collect();
        let between = if varied.is_empty() { "" } else { ": " };
        write!(f, "{}{between}{}", self.table, varied.join(", "))
    }
}

/// Task of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum SweepTask {
    /// A policy on rings of the fast engine.
    Rings(Box<RingsTask>),
    /// A whole drive with its scenario.
    Drive(Box<Scenario>),
    /// A training with its configuration.
    Training(Box<TrainConfig>),
    /// A rehearsal of a study, with its analysis.
    Rehearsal(RehearsalTask),
}

impl SweepTask {
    /// Returns the kind as used in the names of tables and files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Rings(_) => "rings",
            Self::Drive(_) => "drives",
            Self::Training(_) => "trainings",
            Self::Rehearsal(_) => "rehearsals",
        }
    }
}

/// A policy on rings of the fast engine.
#[derive(Clone, Debug, PartialEq)]
pub struct RingsTask {
    /// Configuration of the rings, the hold and the driver.
    pub config: TrainConfig,
    /// Name or file of the policy.
    pub policy: String,
    /// Driver that follows: the name of a driver or a population, or a driver's numbers; empty: the configuration's driver.
    pub driver: String,
    /// Target speed of built-in policies, m/s; 0: automatic.
    pub policy_speed_mps: f64,
    /// Number of rings, 1 to 1,000,000.
    pub rings: u32,
}

/// A rehearsal of a study with simulated participants.
#[derive(Clone, Debug, PartialEq)]
pub struct RehearsalTask {
    /// Path of the study's file.
    pub study: PathBuf,
    /// Files that the study's drives read.
    pub reads: Vec<PathBuf>,
    /// Seed of the study's orders, drivers and drives.
    pub seed: u64,
    /// Number of simulated participants.
    pub participants: usize,
    /// Population from which the participants are drawn.
    pub population: Population,
}

/// All runs of a plan file.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepPlan {
    /// Path of the plan file.
    pub path: PathBuf,
    /// Runs in the order of the file.
    pub runs: Vec<SweepRun>,
}

impl SweepPlan {
    /// Reads a plan and checks the settings, policies, maps and drivers of every run. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// [`SweepError::Plan`], naming file, line and remedy.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let text = read_text(path, SETTINGS_BYTES).map_err(|why| {
            SweepError::Plan(format!("{}: cannot be read: {why}{}", path.display(), did_you_mean_file(path)))
        })?;
        Self::from_text(&text, path)
    }

    /// Parses the text of the plan at `path`.
    ///
    /// # Errors
    /// The errors of [`SweepPlan::read`].
    pub fn from_text(text: &str, path: &Path) -> Result<Self, SweepError> {
        let name = path.display().to_string();
        let (file, mut mistakes) = toml_text::read::<PlanFile>(text, &name);
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut reader = PlanReader { folder, runs: Vec::new(), checked: BTreeMap::new() };
        if let Some(file) = &file {
            for fault in reader.faults(file) {
                mistakes.add(&fault.key, fault.part, &fault.message);
            }
        }
        mistakes.finish().map_err(|why| SweepError::Plan(why.to_string()))?;
        if reader.runs.is_empty() {
            let text = "there is nothing to run; allowed: tables [[rings]], [[drives]], [[trainings]], [[rehearsals]]";
            return Err(SweepError::Plan(format!("{}: {text}", path.display())));
        }
        Ok(Self { path: path.into(), runs: reader.runs })
    }
}

/// Fault at a key of the plan or its value.
struct PlanFault {
    key: String,
    part: KeyPart,
    message: String,
}

/// Faults of a table.
type PlanFaults = Vec<PlanFault>;

/// Key and name of a run's table in the plan, and the time limit of its runs.
#[derive(Clone)]
struct RunOrigin {
    key: String,
    table: String,
    limit_s: Option<f64>,
}

/// State while a plan is read.
struct PlanReader<'a> {
    folder: &'a Path,
    runs: Vec<SweepRun>,
    /// Resolved policy of each map, path, policy and driver checked so far; the checks take longer than everything else.
    checked: BTreeMap<[String; 4], String>,
}

impl PlanReader<'_> {
    /// Adds the runs of all tables and returns the faults of each table.
    fn faults(&mut self, file: &PlanFile) -> PlanFaults {
        let mut faults = PlanFaults::new();
        let mut add = |read: Result<(), PlanFaults>| faults.extend(read.err().into_iter().flatten());
        file.rings.iter().enumerate().for_each(|(i, table)| add(self.rings(i, table)));
        file.drives.iter().enumerate().for_each(|(i, table)| add(self.drives(i, table)));
        file.trainings.iter().enumerate().for_each(|(i, table)| add(self.trainings(i, table)));
        file.rehearsals.iter().enumerate().for_each(|(i, table)| add(self.rehearsals(i, table)));
        faults
    }

    /// Returns the fault of the value at a key.
    fn wrong(&self, key: &str, message: &str) -> PlanFaults {
        vec![PlanFault { key: key.into(), part: KeyPart::Value, message: message.into() }]
    }

    fn rings(&mut self, index: usize, table: &RingsTable) -> Result<(), PlanFaults> {
        let at = format!("rings.{index}");
        let origin = self.origin(&at, table.name.as_deref(), table.limit_s)?;
        let base = match &table.config {
            Some(file) => self.settings_file(&format!("{at}.config"), file)?,
            None => TrainConfig::paper_ring(),
        };
        let rings = table.rings.unwrap_or(RINGS);
        if !(1..=MOST_RINGS).contains(&rings) {
            return Err(self.wrong(&format!("{at}.rings"), &format!("rings is {rings}; allowed: 1 to {MOST_RINGS}")));
        }
        for mut combination in self.combinations(&at, &table.settings, &table.each)? {
            let policy = self.word(combination.take("policy"), "none")?;
            let driver = self.word(combination.take("driver"), "")?;
            let speed = combination.take("policy_speed_mps");
            let policy_speed_mps = match &speed {
                None => 0.0,
                Some((value, key)) => value.as_f64().filter(|speed| (0.0..=60.0).contains(speed)).ok_or_else(|| {
                    self.wrong(key, &format!("policy_speed_mps is {value}; allowed: a number from 0 to 60 m/s"))
                })?,
            };
            self.find_files(&mut combination);
            let config: TrainConfig = self.changed(&base, &combination, &OF_RINGS)?;
            let task = RingsTask { config, policy: self.policy(&policy.0), driver: driver.0, policy_speed_mps, rings };
            task.follower().map_err(|why| self.wrong(&driver.1, &why))?;
            let asked = ["rings".into(), String::new(), task.policy.clone(), String::new()];
            if !self.checked.contains_key(&asked) {
                PolicySource::for_rings(&task.policy, &task.config.policy_settings(policy_speed_mps))
                    .map_err(|why| self.wrong(&policy.1, &why.to_string()))?;
                self.checked.insert(asked, task.policy.clone());
            }
            self.add(&origin, combination.varied, SweepTask::Rings(Box::new(task)))?;
        }
        Ok(())
    }

    fn drives(&mut self, index: usize, table: &DrivesTable) -> Result<(), PlanFaults> {
        let at = format!("drives.{index}");
        let origin = self.origin(&at, table.name.as_deref(), table.limit_s)?;
        let base = match &table.scenario {
            Some(file) => Scenario::from_file(&self.folder.join(file))
                .map_err(|why| self.wrong(&format!("{at}.scenario"), &why.message))?,
            None => Scenario::default(),
        };
        for mut combination in self.combinations(&at, &table.settings, &table.each)? {
            self.find_files(&mut combination);
            let mut scenario: Scenario = self.changed(&base, &combination, &[])?;
            let key = |name: &str| {
                let set = combination.settings.iter().find(|setting| setting.0 == name);
                set.map_or_else(|| format!("{at}.scenario"), |setting| setting.2.clone())
            };
            if scenario.duration_s <= 0.0 && scenario.traffic.log_file().is_none() {
                let text = "duration_s is 0; a drive of a sweep needs an end, for example 300";
                return Err(self.wrong(&key("duration_s"), text));
            }
            let asked = [scenario.map.clone(), scenario.path.clone(), scenario.policy.clone(), scenario.driver.clone()];
            scenario.policy = match self.checked.get(&asked) {
                Some(policy) => policy.clone(),
                None => self.checked_policy(&scenario, key)?,
            };
            self.checked.insert(asked, scenario.policy.clone());
            self.add(&origin, combination.varied, SweepTask::Drive(Box::new(scenario)))?;
        }
        Ok(())
    }

    /// Checks a drive's map, policy and driver; returns the resolved policy.
    fn checked_policy(&self, scenario: &Scenario, key: impl Fn(&str) -> String) -> Result<String, PlanFaults> {
        let map = scenario.load_map().map_err(|why| self.wrong(&key("map"), &why.to_string()))?;
        driver::named(&scenario.driver).map_err(|why| self.wrong(&key("driver"), &why.to_string()))?;
        let policy = policy::resolve(&scenario.policy, &map).name;
        let settings = TrainConfig::default().policy_settings(scenario.policy_speed_mps);
        PolicySource::read(&policy, &settings).map_err(|why| self.wrong(&key("policy"), &why.to_string()))?;
        Ok(policy)
    }

    fn trainings(&mut self, index: usize, table: &TrainingsTable) -> Result<(), PlanFaults> {
        let at = format!("trainings.{index}");
        let origin = self.origin(&at, table.name.as_deref(), table.limit_s)?;
        let base = match &table.config {
            Some(file) => self.settings_file(&format!("{at}.config"), file)?,
            None => TrainConfig::default(),
        };
        for mut combination in self.combinations(&at, &table.settings, &table.each)? {
            self.find_files(&mut combination);
            let mut config: TrainConfig = self.changed(&base, &combination, &[])?;
            config.advice.residual_over = self.policy(&config.advice.residual_over);
            let task = SweepTask::Training(Box::new(config));
            self.add(&origin, combination.varied, task)?;
        }
        Ok(())
    }

    fn rehearsals(&mut self, index: usize, table: &RehearsalsTable) -> Result<(), PlanFaults> {
        let at = format!("rehearsals.{index}");
        let origin = self.origin(&at, table.name.as_deref(), table.limit_s)?;
        let path = self.folder.join(&table.study);
        let study = Study::load(&path).map_err(|why| self.wrong(&format!("{at}.study"), &why.to_string()))?;
        let reads: Vec<PathBuf> = study.files().cloned().collect();
        for mut combination in self.combinations(&at, &table.settings, &table.each)? {
            let seed = self.whole(combination.take("seed"), study.file.seed, [0, (1 << 53) - 1])?;
            let participants = self.whole(combination.take("participants"), 12, [1, 1000])? as usize;
            let population = match combination.take("population") {
                None => Population::None,
                found => {
                    let (name, key) = self.word(found, "")?;
                    Population::named(&name).map_err(|why| self.wrong(&key, &why.to_string()))?
                }
            };
            if let Some((name, _, key)) = combination.settings.first() {
                return Err(self.unknown(key, name, &OF_REHEARSALS));
            }
            let task = RehearsalTask { study: path.clone(), reads: reads.clone(), seed, participants, population };
            self.add(&origin, combination.varied, SweepTask::Rehearsal(task))?;
        }
        Ok(())
    }

    /// Returns the common data of all runs of the table at a key such as `drives.0`.
    fn origin(&self, at: &str, name: Option<&str>, limit_s: Option<f64>) -> Result<RunOrigin, PlanFaults> {
        if let Some(limit) = limit_s.filter(|limit| !(LEAST_LIMIT_S..=MOST_LIMIT_S).contains(limit)) {
            let text = format!("limit_s is {limit}; allowed: a number from {LEAST_LIMIT_S} to {MOST_LIMIT_S} s");
            return Err(self.wrong(&format!("{at}.limit_s"), &text));
        }
        let (kind, index) = at.split_once('.').unwrap_or((at, ""));
        let numbered = || format!("{kind} {}", index.parse::<usize>().map_or(0, |index| index + 1));
        Ok(RunOrigin { key: at.into(), table: name.map_or_else(numbered, str::to_owned), limit_s })
    }

    fn add(&mut self, origin: &RunOrigin, varied: Map<String, Value>, task: SweepTask) -> Result<(), PlanFaults> {
        let number = self.runs.len();
        if number == MOST_RUNS {
            let text = format!("more than {MOST_RUNS} runs\n  remedy: split the plan into several plans");
            return Err(self.wrong(&origin.key, &text));
        }
        let RunOrigin { table, limit_s, .. } = origin.clone();
        self.runs.push(SweepRun { number, table, varied, limit_s, task });
        Ok(())
    }

    /// Returns all combinations of a table.
    fn combinations(
        &self,
        at: &str,
        settings: &toml::Table,
        each: &toml::Table,
    ) -> Result<Vec<Combination>, PlanFaults> {
        combinations(at, settings, each, MOST_RUNS).map_err(|(key, fault)| self.wrong(&key, &fault))
    }

    /// Reads a file of settings that the plan names.
    fn settings_file<T: Settings>(&self, key: &str, file: &Path) -> Result<T, PlanFaults> {
        settings::from_file(&self.folder.join(file)).map_err(|why| self.wrong(key, &why.message))
    }

    /// Returns the policy's name, or its path relative to the plan's folder.
    fn policy(&self, name: &str) -> String {
        scenario::path_from(self.folder, "policy", name)
    }

    /// Resolves the paths among the settings of a combination relative to the plan's folder.
    fn find_files(&self, combination: &mut Combination) {
        for (name, value, _) in &mut combination.settings {
            let found = |word: &str| scenario::path_from(self.folder, name, word);
            match value {
                // A training has several populations of drivers.
                Value::String(text) if name == "traffic_drivers" => {
                    *text = text.split(',').map(|word| found(word.trim())).collect::<Vec<_>>().join(",");
                }
                Value::String(text) => *text = found(text),
                _ => {}
            }
        }
    }

    /// Returns a word and its key in the plan; the default and an empty key if it is not set.
    fn word(&self, found: Option<(Value, String)>, default: &str) -> Result<(String, String), PlanFaults> {
        match found {
            None => Ok((default.to_owned(), String::new())),
            Some((Value::String(word), key)) => Ok((word, key)),
            Some((value, key)) => Err(self.wrong(&key, &format!("the value is {value}; allowed: a word"))),
        }
    }

    /// Returns a whole number within limits, or the default if it is not set.
    fn whole(&self, found: Option<(Value, String)>, default: u64, limits: [u64; 2]) -> Result<u64, PlanFaults> {
        let Some((value, key)) = found else { return Ok(default) };
        let [low, high] = limits;
        let fault = || format!("the value is {value}; allowed: a whole number from {low} to {high}");
        value.as_u64().filter(|n| (low..=high).contains(n)).ok_or_else(|| self.wrong(&key, &fault()))
    }

    fn unknown(&self, key: &str, name: &str, known: &[&str]) -> PlanFaults {
        vec![PlanFault { key: key.into(), part: KeyPart::Key, message: unknown_key(name, known) }]
    }

    /// Returns the base settings with the changes of a combination; `beside` are further names for the error message.
    fn changed<T: Settings>(&self, base: &T, combination: &Combination, beside: &[&str]) -> Result<T, PlanFaults> {
        let fields = fields_of::<T>();
        let (mut changes, mut faults): (Vec<(Field, Value)>, PlanFaults) = Default::default();
        for (name, value, key) in &combination.settings {
            let Some(field) = fields.iter().find(|field| field.path == *name) else {
                let known: Vec<&str> =
                    fields.iter().map(|field| field.path.as_str()).chain(beside.iter().copied()).collect();
                faults.extend(self.unknown(key, name, &known));
                continue;
            };
            match field.written(value) {
                Ok(value) => changes.push((field.clone(), value)),
                Err(fault) => faults.extend(self.wrong(key, &fault)),
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        settings::changed(base, &changes).map_err(|why| {
            let set = combination.settings.iter().find(|setting| setting.0 == why.key);
            let key = set.or(combination.settings.last()).map_or("", |setting| setting.2.as_str());
            self.wrong(key, &why.message)
        })
    }
}

impl RingsTask {
    /// Returns the configuration with the task's driver or population.
    ///
    /// # Errors
    /// No driver and no population has that name.
    pub fn follower(&self) -> Result<TrainConfig, String> {
        if self.driver.is_empty() {
            return Ok(self.config.clone());
        }
        if let Ok(population) = Population::named(&self.driver) {
            return Ok(self.config.driven_by_some_of(population));
        }
        let populations = || did_you_mean(&self.driver, &Population::NAMES);
        let named = driver::named(&self.driver).map_err(|why| format!("{why}{}", populations()))?;
        Ok(self.config.driven_by(&named.params))
    }
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
