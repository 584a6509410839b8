//! Benchmark as a file. In: TOML, shipped in `assets/benchmarks` or the user's. Out: a [`Benchmark`]: every combination of
//! roads, drivers and policies. SI units.

use crate::{
    cli::{
        CliError,
        evaluate::plan::{self, FollowingDriver, FollowingDriverError},
    },
    data_folders, file,
    idm::IdmParams,
    policy::{self, Hold, PolicyError, PolicySettings, PolicySource},
    scenario::AdvisedVehicles,
    settings::Settings,
    toml_text::{self, KeyPart, did_you_mean},
    traffic::{RING_STUDY, is_population_path},
    train::{DriverConfig, RingConfig, TrainConfig},
};
use serde::Deserialize;
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

/// Format name in the file.
const FORMAT: &str = "codrive benchmark 1";

/// Folder of the shipped benchmarks, in the program's data.
const SHIPPED: &str = "assets/benchmarks";

/// Benchmark definition: roads, drivers and policies to compare.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Benchmark {
    /// Format name, `codrive benchmark 1`.
    pub format: String,
    /// Title in tables and results.
    pub title: String,
    /// Number of rings of each cell.
    pub rings: usize,
    /// Seed of the rings.
    pub seed: u64,
    /// Holds of the advice, s.
    pub holds_s: Vec<f64>,
    /// Weight of the standard deviation of speed over the vehicles in the value of a drive, the setting `speed_sd_penalty` of trainings.
    #[serde(default)]
    pub speed_sd_penalty: f64,
    #[serde(rename = "road")]
    pub roads: Vec<Road>,
    /// Drivers who follow the advice.
    #[serde(rename = "driver")]
    pub drivers: Vec<JudgedDriver>,
    /// Policies, one row of the table each.
    #[serde(rename = "row")]
    pub rows: Vec<JudgedPolicy>,
    /// Folder of the file; paths in the file are relative to it.
    #[serde(skip)]
    pub folder: PathBuf,
}

/// Ring lengths, traffic and model spread of a road.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Road {
    /// Name shown in tables.
    pub name: String,
    /// Value of `{road}` in a policy's path; by default the circumference, such as 250 or 210-290.
    pub key: Option<String>,
    /// Shortest and longest ring, metres.
    pub circumference_m: [f64; 2],
    /// Minimum and maximum number of vehicles.
    pub vehicles: [u32; 2],
    /// Advised vehicles, as the setting `advised`; by default one.
    #[serde(default)]
    pub advised: AdvisedVehicles,
    /// Drivers of the traffic, as the setting `traffic_drivers`; a population's file is relative to this one.
    #[serde(default = "ring_study")]
    pub traffic_drivers: String,
    /// Relative spread of the car-following model between rings, either way.
    #[serde(default)]
    pub idm_spread: f64,
    /// Relative spread of each vehicle's model around that of its ring, either way.
    #[serde(default)]
    pub car_spread: f64,
    /// Share of trucks among the other vehicles.
    #[serde(default)]
    pub truck_share: f64,
    /// Desired speed of the car-following model, which is also the speed limit, m/s; by default that of the ring study.
    pub desired_speed_mps: Option<f64>,
    /// Time that traffic runs before advice begins, s; by default 120 s.
    pub warm_up_s: Option<f64>,
}

/// Driver, or population of drivers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedDriver {
    /// Name in tables, and value of `{driver}` in a policy's path.
    pub name: String,
    /// Driver as `--driver` takes it, or the name of a population.
    pub driver: String,
    /// Maximum deceleration of a guarded driver's guard, m/s2.
    pub guard_decel_mps2: Option<f64>,
    /// Time in which an exact driver closes a difference to the advised speed, s; by default one step.
    pub ego_response_s: Option<f64>,
    /// Maximum acceleration of an exact driver towards the advised speed, m/s2.
    pub ego_accel_mps2: Option<f64>,
    /// True if only rows that name this driver use it.
    #[serde(default)]
    pub only_where_named: bool,
}

/// Row of the table: one policy, or one policy trained from several seeds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedPolicy {
    /// Name shown in tables.
    pub name: String,
    /// Names, or paths relative to the file's folder. `{road}`, `{driver}` and `{hold}` are replaced by those of the cell.
    pub policies: Vec<String>,
    /// Keys of the roads to evaluate on; by default all.
    pub roads: Option<Vec<String>>,
    /// Names of the drivers to evaluate with; by default all except those with `only_where_named`.
    pub drivers: Option<Vec<String>>,
    /// Holds to evaluate at, seconds; by default the benchmark's.
    pub holds_s: Option<Vec<f64>>,
    /// True for the best that a search with full knowledge found: each row's share of its value is stated.
    #[serde(default)]
    pub is_limit: bool,
}

/// Condition in which a row is evaluated: road, hold and driver.
#[derive(Clone, Copy, Debug)]
pub struct EvaluationCondition<'a> {
    /// Rings to drive on.
    pub road: &'a Road,
    /// Hold of the advice, s.
    pub hold_s: f64,
    /// Driver who follows the advice.
    pub driver: &'a JudgedDriver,
}

impl EvaluationCondition<'_> {
    /// Checks whether both are the same condition of the same benchmark.
    pub fn is(&self, other: &Self) -> bool {
        self.hold_s == other.hold_s && self.is_beside(other)
    }

    /// Checks whether both are the same condition apart from the hold.
    pub fn is_beside(&self, other: &Self) -> bool {
        std::ptr::eq(self.road, other.road) && std::ptr::eq(self.driver, other.driver)
    }

    /// Returns a path with road, driver and hold filled in.
    pub fn written_in(&self, path: &str) -> String {
        let path = path.replace("{road}", &self.road.key()).replace("{driver}", &self.driver.name);
        path.replace("{hold}", &self.hold_s.to_string())
    }
}

impl Benchmark {
    /// Loads a benchmark by name, or from a TOML file.
    ///
    /// # Errors
    /// There is no such benchmark, or it is wrong; the message names file, line, value and the allowed values.
    pub fn load(name: &str) -> Result<Self, CliError> {
        let path = if Path::new(name).extension().is_some_and(|ending| ending == "toml") {
            PathBuf::from(name)
        } else {
            data_folders::root().join(SHIPPED).join(format!("{name}.toml"))
        };
        let shown = path.display().to_string();
        let text = file::read_text(&path, file::SETTINGS_BYTES).map_err(|error| {
            let known = shipped();
            let near = did_you_mean(name, &known);
            CliError::Input(format!("{shown}: {error}{near}\n  remedy: name one of {}, or a file", known.join(", ")))
        })?;
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        Self::parse(&text, &shown, folder)
    }

    /// Parses a benchmark from text.
    fn parse(text: &str, name: &str, folder: PathBuf) -> Result<Self, CliError> {
        let (parsed, mut mistakes) = toml_text::read::<Self>(text, name);
        let benchmark = parsed.map(|parsed| Self { folder, ..parsed });
        let checked = [Self::check, Self::check_drivers_and_roads, Self::check_rows];
        for (key, message) in benchmark.iter().flat_map(|one| checked.into_iter().filter_map(|check| check(one).err()))
        {
            // Rows name drivers and roads.
            let others: &[&str] = if key.starts_with("row.") { &["driver", "road"] } else { &[] };
            mistakes.add_related(&key, others, KeyPart::Value, &message);
        }
        toml_text::finished((benchmark, mistakes)).map_err(|error| CliError::Input(error.to_string()))
    }

    /// Checks the definition. Returns the key at fault and the allowed values.
    fn check(&self) -> Result<(), (String, String)> {
        if self.format != FORMAT {
            return Err(("format".into(), format!("format is `{}`; allowed: `{FORMAT}`", self.format)));
        }
        if !(2..=100_000).contains(&self.rings) {
            return Err(("rings".into(), format!("rings is {}; allowed: 2 to 100000", self.rings)));
        }
        for (what, is_empty) in [
            ("holds_s", self.holds_s.is_empty()),
            ("road", self.roads.is_empty()),
            ("driver", self.drivers.is_empty()),
            ("row", self.rows.is_empty()),
        ] {
            if is_empty {
                return Err((what.into(), format!("{what} is empty; name at least one")));
            }
        }
        if !(0.0..=10.0).contains(&self.speed_sd_penalty) {
            let text = format!("speed_sd_penalty is {}; allowed: 0 to 10", self.speed_sd_penalty);
            return Err(("speed_sd_penalty".into(), text));
        }
        let limits: Vec<usize> = (0..self.rows.len()).filter(|i| self.rows[*i].is_limit).collect();
        if let [_, second, ..] = limits[..] {
            return Err((format!("row.{second}.is_limit"), "two rows are the limit; allowed: one".into()));
        }
        let step_s = RingConfig::default().step_s;
        for (i, hold_s) in self.holds_s.iter().enumerate() {
            Hold::new(*hold_s, step_s).map_err(|fault| (format!("holds_s.{i}"), fault.to_string()))?;
        }
        Ok(())
    }

    fn check_drivers_and_roads(&self) -> Result<(), (String, String)> {
        for (i, driver) in self.drivers.iter().enumerate() {
            driver.following_driver().map_err(|fault| (format!("driver.{i}.driver"), fault.to_string()))?;
            if self.drivers[..i].iter().any(|other| other.name == driver.name) {
                return Err((format!("driver.{i}.name"), format!("two drivers have the name `{}`", driver.name)));
            }
            for (key, value) in [
                ("guard_decel_mps2", driver.guard_decel_mps2),
                ("ego_response_s", driver.ego_response_s),
                ("ego_accel_mps2", driver.ego_accel_mps2),
            ] {
                if let Some(value) = value.filter(|value| !(0.1..=10.0).contains(value)) {
                    return Err((format!("driver.{i}.{key}"), format!("{key} is {value}; allowed: 0.1 to 10")));
                }
            }
        }
        for (i, road) in self.roads.iter().enumerate() {
            let fits = road.circumference_m[0] <= road.circumference_m[1] && road.vehicles[0] <= road.vehicles[1];
            let room_m = road.circumference_m[0] / f64::from(road.vehicles[1].max(1));
            let least_m = if road.truck_share > 0.0 { 10.0 } else { 7.5 };
            let is_spread = |spread: f64| (0.0..0.9).contains(&spread);
            let spreads = is_spread(road.idm_spread) && is_spread(road.car_spread);
            if !fits || road.vehicles[0] < 2 || room_m < least_m || !spreads || !(0.0..=1.0).contains(&road.truck_share)
            {
                let message = format!(
                    "road `{}` is not valid: each range is [smaller, larger]; at least 2 vehicles, {least_m} m of road \
                     for each, idm_spread and car_spread from 0 to 0.9, truck_share from 0 to 1",
                    road.name
                );
                return Err((format!("road.{i}.name"), message));
            }
            for (key, value, [low, high]) in [
                ("desired_speed_mps", road.desired_speed_mps, [1.0, 60.0]),
                ("warm_up_s", road.warm_up_s, [0.0, 3600.0]),
            ] {
                if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
                    return Err((format!("road.{i}.{key}"), format!("{key} is {value}; allowed: {low} to {high}")));
                }
            }
            let condition = EvaluationCondition { road, hold_s: self.holds_s[0], driver: &self.drivers[0] };
            let config = self.config(&condition).map_err(|error| (format!("road.{i}.name"), error.to_string()))?;
            config.check().map_err(|(key, message)| (format!("road.{i}.{key}"), message))?;
            if self.roads[..i].iter().any(|other| other.key() == road.key()) {
                let message =
                    format!("two roads have the key `{}`\n  remedy: give one of them a key of its own", road.key());
                return Err((format!("road.{i}.name"), message));
            }
        }
        Ok(())
    }

    fn check_rows(&self) -> Result<(), (String, String)> {
        let step_s = RingConfig::default().step_s;
        for (i, row) in self.rows.iter().enumerate() {
            for (what, is_empty) in [
                ("policies", row.policies.is_empty()),
                ("roads", row.roads.as_ref().is_some_and(Vec::is_empty)),
                ("drivers", row.drivers.as_ref().is_some_and(Vec::is_empty)),
                ("holds_s", row.holds_s.as_ref().is_some_and(Vec::is_empty)),
            ] {
                if is_empty {
                    return Err((format!("row.{i}.{what}"), format!("{what} is empty; name at least one")));
                }
            }
            let drivers: Vec<String> = self.drivers.iter().map(|driver| driver.name.clone()).collect();
            let roads: Vec<String> = self.roads.iter().map(Road::key).collect();
            for (what, key, named, known) in [
                ("driver of this file has the name", "drivers", &row.drivers, &drivers),
                ("road of this file has the key", "roads", &row.roads, &roads),
            ] {
                let unknown = named.iter().flatten().enumerate().find(|(_, name)| !known.contains(name));
                if let Some((k, name)) = unknown {
                    let near = did_you_mean(name, known);
                    let message = format!("no {what} `{name}`{near}; allowed: {}", known.join(", "));
                    return Err((format!("row.{i}.{key}.{k}"), message));
                }
            }
            for (k, hold_s) in row.holds_s.iter().flatten().enumerate() {
                Hold::new(*hold_s, step_s).map_err(|fault| (format!("row.{i}.holds_s.{k}"), fault.to_string()))?;
            }
            for (k, policy) in row.policies.iter().enumerate() {
                let fault = |error: PolicyError| (format!("row.{i}.policies.{k}"), error.to_string());
                let conditions = self.conditions();
                let conditions = conditions.iter().filter(|condition| self.judges(row, condition));
                for name in conditions.map(|condition| self.policy(policy, condition)).collect::<BTreeSet<_>>() {
                    PolicySource::for_rings(&name, &PolicySettings { aim_mps: 4.0, equilibrium_mps: 4.0, step_s })
                        .map_err(fault)?;
                }
            }
        }
        Ok(())
    }

    /// Returns the holds of the benchmark, then the additional holds of its rows, s.
    pub fn all_holds_s(&self) -> Vec<f64> {
        let mut holds_s = self.holds_s.clone();
        for hold_s in self.rows.iter().flat_map(|row| row.holds_s.iter().flatten()) {
            if !holds_s.contains(hold_s) {
                holds_s.push(*hold_s);
            }
        }
        holds_s
    }

    /// Returns every condition in which a row is evaluated, in the order of tables.
    pub fn conditions(&self) -> Vec<EvaluationCondition<'_>> {
        let mut conditions = Vec::new();
        for road in &self.roads {
            for hold_s in self.all_holds_s() {
                for driver in &self.drivers {
                    let condition = EvaluationCondition { road, hold_s, driver };
                    if self.rows.iter().any(|row| self.asks_for(row, &condition)) {
                        conditions.push(condition);
                    }
                }
            }
        }
        conditions
    }

    /// Checks whether a row is evaluated there. No advice is evaluated in every condition, as the baseline of the gains.
    pub fn judges(&self, row: &JudgedPolicy, condition: &EvaluationCondition<'_>) -> bool {
        row.is_no_advice() || self.asks_for(row, condition)
    }

    fn asks_for(&self, row: &JudgedPolicy, condition: &EvaluationCondition<'_>) -> bool {
        let has_driver = match &row.drivers {
            Some(drivers) => drivers.contains(&condition.driver.name),
            None => !condition.driver.only_where_named,
        };
        let has_road = row.roads.as_ref().is_none_or(|roads| roads.contains(&condition.road.key()));
        has_driver && has_road && row.holds_s.as_ref().unwrap_or(&self.holds_s).contains(&condition.hold_s)
    }

    /// Returns the name of a policy, or its path in a cell.
    pub fn policy(&self, name: &str, condition: &EvaluationCondition<'_>) -> String {
        if !policy::is_path(name) {
            return name.into();
        }
        self.folder.join(condition.written_in(name)).display().to_string()
    }

    /// Returns the drivers of a road's traffic: a name, or the path of a population's file.
    fn traffic_drivers(&self, road: &Road) -> String {
        if !is_population_path(&road.traffic_drivers) {
            return road.traffic_drivers.clone();
        }
        self.folder.join(&road.traffic_drivers).display().to_string()
    }

    /// Returns the configuration of the rings and driver of a condition.
    pub fn config(&self, condition: &EvaluationCondition<'_>) -> Result<TrainConfig, CliError> {
        let EvaluationCondition { road, hold_s, driver } = *condition;
        let usual = RingConfig::default();
        let idm = IdmParams { v0: road.desired_speed_mps.unwrap_or(usual.idm.v0), ..usual.idm };
        let config = TrainConfig {
            seed: self.seed,
            ring: RingConfig {
                circumference_min_m: road.circumference_m[0],
                circumference_max_m: road.circumference_m[1],
                vehicles_min: road.vehicles[0],
                vehicles_max: road.vehicles[1],
                advised: road.advised,
                traffic_drivers: self.traffic_drivers(road),
                idm_spread: road.idm_spread,
                car_spread: road.car_spread,
                truck_share: road.truck_share,
                bunched_share: 1.0,
                idm,
                warm_up_s: road.warm_up_s.unwrap_or(usual.warm_up_s),
                ..usual
            },
            ..TrainConfig::default()
        };
        let driven_by = driver.following_driver().map_err(|e| CliError::Input(e.to_string()))?;
        let mut config = driven_by.of(&config).held(hold_s);
        let set = config.driver.clone();
        config.driver = DriverConfig {
            guard_decel_mps2: driver.guard_decel_mps2.unwrap_or(set.guard_decel_mps2),
            ego_response_s: driver.ego_response_s.unwrap_or(set.ego_response_s),
            ego_accel_mps2: driver.ego_accel_mps2.unwrap_or(set.ego_accel_mps2),
            ..set
        };
        Ok(config)
    }
}

/// Returns the default of a road's drivers.
fn ring_study() -> String {
    RING_STUDY.into()
}

impl Road {
    /// Returns the value of `{road}` in a path.
    pub fn key(&self) -> String {
        let [low, high] = self.circumference_m;
        let length = if low == high { low.to_string() } else { format!("{low}-{high}") };
        self.key.clone().unwrap_or(length)
    }
}

impl JudgedPolicy {
    /// Checks whether the row advises nothing.
    pub fn is_no_advice(&self) -> bool {
        self.policies == ["none"]
    }
}

impl JudgedDriver {
    /// Returns the driver or population.
    ///
    /// # Errors
    /// There is no such driver or population, or a number of the driver is wrong.
    pub fn following_driver(&self) -> Result<FollowingDriver, FollowingDriverError> {
        plan::driver(&self.driver)
    }
}

/// Returns the names of the shipped benchmarks, sorted.
pub fn shipped() -> Vec<String> {
    let files = std::fs::read_dir(data_folders::root().join(SHIPPED)).into_iter().flatten().flatten();
    let names = files.filter_map(|file| {
        let path = file.path();
        (path.extension()? == "toml").then(|| path.file_stem().map(|name| name.to_string_lossy().into_owned()))?
    });
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[cfg(test)]
#[path = "definition_tests.rs"]
mod tests;
