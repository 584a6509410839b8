//! A benchmark as a file. In: TOML of `assets/benchmarks`, or another's. Out: a [`Benchmark`]: roads, drivers and policies, each
//! with each. SI units.

use crate::{
    cli::CliError,
    data_folders,
    driver::{DriverError, NamedDriver, Population, named},
    file,
    policy::{self, Hold, PolicyError, PolicySettings},
    toml_text::{self, KeyPart, did_you_mean},
    train::{DriverConfig, RingConfig, TrainConfig},
};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// What such a file calls itself.
const FORMAT: &str = "codrive benchmark 1";

/// Where the shipped ones lie, below the program's data.
const SHIPPED: &str = "assets/benchmarks";

/// A benchmark.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Benchmark {
    /// Kind of file.
    pub format: String,
    /// What it is called.
    pub title: String,
    /// Rings of each cell.
    pub rings: usize,
    /// Seed of the rings.
    pub seed: u64,
    /// Holds, seconds.
    pub holds_s: Vec<f64>,
    /// Roads.
    #[serde(rename = "road")]
    pub roads: Vec<Road>,
    /// Who follows the advice.
    #[serde(rename = "driver")]
    pub drivers: Vec<JudgedDriver>,
    /// What advises.
    #[serde(rename = "row")]
    pub rows: Vec<JudgedPolicy>,
    /// The folder of the file, which paths in it start from.
    #[serde(skip)]
    pub folder: PathBuf,
}

/// A kind of ring.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Road {
    /// What it is called.
    pub name: String,
    /// Shortest and longest ring, metres.
    pub circumference_m: [f64; 2],
    /// Fewest and most cars.
    pub vehicles: [u32; 2],
    /// Share by which the car-following model differs from ring to ring, either way.
    pub idm_spread: f64,
}

/// A driver, or a population of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedDriver {
    /// What tables call him; `{driver}` in a policy's path.
    pub name: String,
    /// As `--driver` takes it, or the name of a population.
    pub driver: String,
    /// Largest deceleration of the guard of a guarded one, m/s2.
    pub guard_decel_mps2: Option<f64>,
}

/// A row: one policy, or the same one trained from several seeds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgedPolicy {
    /// What tables call it.
    pub name: String,
    /// Names, or paths from the folder of this file; `{driver}` and `{hold}` in one stand for those of the cell.
    pub policies: Vec<String>,
}

impl Benchmark {
    /// The benchmark of this name, or of this file.
    ///
    /// # Errors
    /// There is none, or it is wrong; the message names file, line, value and what is allowed.
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

    /// The same for text.
    fn parse(text: &str, name: &str, folder: PathBuf) -> Result<Self, CliError> {
        let parsed: Self = toml_text::parse(text, name).map_err(|error| CliError::Input(error.to_string()))?;
        let benchmark = Self { folder, ..parsed };
        benchmark
            .check()
            .map_err(|(key, message)| CliError::Input(toml_text::at(text, name, &key, KeyPart::Value, &message)))?;
        Ok(benchmark)
    }

    /// What must hold; the key at fault and what is allowed.
    fn check(&self) -> Result<(), (String, String)> {
        if self.format != FORMAT {
            return Err(("format".into(), format!("format is `{}`; known is `{FORMAT}`", self.format)));
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
        let step_s = RingConfig::default().step_s;
        for (i, hold_s) in self.holds_s.iter().enumerate() {
            Hold::new(*hold_s, step_s).map_err(|fault| (format!("holds_s.{i}"), fault.to_string()))?;
        }
        for (i, driver) in self.drivers.iter().enumerate() {
            driver.who().map_err(|fault| (format!("driver.{i}.driver"), fault.to_string()))?;
        }
        for (i, road) in self.roads.iter().enumerate() {
            let fits = road.circumference_m[0] <= road.circumference_m[1] && road.vehicles[0] <= road.vehicles[1];
            let room_m = road.circumference_m[0] / f64::from(road.vehicles[1].max(1));
            if !fits || road.vehicles[0] < 2 || room_m < 7.5 || !(0.0..0.9).contains(&road.idm_spread) {
                let message = format!(
                    "road `{}` cannot be driven: first the lesser, then the greater number, at least 2 cars, 7.5 m of road \
                     for each, idm_spread from 0 to 0.9",
                    road.name
                );
                return Err((format!("road.{i}.name"), message));
            }
        }
        for (i, row) in self.rows.iter().enumerate() {
            if row.policies.is_empty() {
                return Err((format!("row.{i}.policies"), "policies is empty; name at least one".into()));
            }
            for (k, policy) in row.policies.iter().enumerate() {
                let fault = |error: PolicyError| (format!("row.{i}.policies.{k}"), error.to_string());
                for driver in &self.drivers {
                    for hold_s in &self.holds_s {
                        let name = self.policy(policy, driver, *hold_s);
                        policy::build(&name, &PolicySettings { aim_mps: 4.0, equilibrium_mps: 4.0, step_s })
                            .map_err(fault)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The name or path of a policy in a cell.
    pub fn policy(&self, name: &str, driver: &JudgedDriver, hold_s: f64) -> String {
        if !policy::is_path(name) {
            return name.into();
        }
        let path = name.replace("{driver}", &driver.name).replace("{hold}", &hold_s.to_string());
        self.folder.join(path).display().to_string()
    }

    /// The rings of a road with this driver in each.
    pub fn config(&self, road: &Road, driver: &JudgedDriver, hold_s: f64) -> Result<TrainConfig, CliError> {
        let config = TrainConfig {
            seed: self.seed,
            ring: RingConfig {
                circumference_min_m: road.circumference_m[0],
                circumference_max_m: road.circumference_m[1],
                vehicles_min: road.vehicles[0],
                vehicles_max: road.vehicles[1],
                idm_spread: road.idm_spread,
                bunched_share: 1.0,
                ..RingConfig::default()
            },
            ..TrainConfig::default()
        };
        let config = config.held(hold_s);
        let mut config = match driver.who().map_err(|e| CliError::Input(e.to_string()))? {
            Who::Person(named) => config.driven_by(&named.params),
            Who::Some(population) => config.driven_by_some_of(population),
        };
        if let Some(guard_decel_mps2) = driver.guard_decel_mps2 {
            config.driver = DriverConfig { guard_decel_mps2, ..config.driver };
        }
        Ok(config)
    }
}

/// Who a driver is.
pub enum Who {
    /// The same in each ring.
    Person(Box<NamedDriver>),
    /// Another in each ring.
    Some(Population),
}

impl JudgedDriver {
    /// Who he is.
    ///
    /// # Errors
    /// There is no such driver and no such population.
    pub fn who(&self) -> Result<Who, DriverError> {
        match Population::named(&self.driver) {
            Ok(population) => Ok(Who::Some(population)),
            Err(_) => Ok(Who::Person(Box::new(named(&self.driver)?))),
        }
    }
}

/// Names of the shipped benchmarks, sorted.
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
mod tests {
    use super::*;

    fn shipped_text() -> String {
        std::fs::read_to_string(data_folders::root().join(SHIPPED).join("ring.toml")).unwrap()
    }

    fn refused(from: &str, to: &str) -> String {
        let text = shipped_text();
        assert!(text.contains(from), "{from}");
        match Benchmark::parse(&text.replacen(from, to, 1), "ring.toml", data_folders::root().join(SHIPPED)) {
            Err(CliError::Input(message)) => message,
            _ => panic!("{to} was taken"),
        }
    }

    #[test]
    fn what_is_wrong_in_a_file_is_said_with_its_place() {
        for (from, to, expected) in [
            ("rings = 200", "rings = 1", "ring.toml:5:9: rings is 1; allowed: 2 to 100000"),
            ("rings = 200", "ringz = 200", "did you mean `rings`"),
            ("holds_s = [1.0, 10.0]", "holds_s = [1.0, 0.25]", "ring.toml:7:17"),
            ("driver = \"people\"", "driver = \"peeple\"", "no driver is called \"peeple\""),
            ("policies = [\"pi\"]", "policies = [\"pie\"]", "policy `pie` is unknown (did you mean pi?)"),
            ("vehicles = [18, 26]", "vehicles = [18, 36]", "road `210-290 m, 18-26 cars` cannot be driven"),
        ] {
            let message = refused(from, to);
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn a_path_is_that_of_the_cell() {
        let benchmark = Benchmark::load("ring").map_err(|e| e.to_string()).unwrap();
        let late = &benchmark.drivers[1];
        let path = benchmark.policy("tuned/constant-{driver}-{hold}.toml", late, 10.0);
        let folder = data_folders::root().join(SHIPPED);
        assert_eq!(path, folder.join("tuned/constant-late-10.toml").display().to_string());
        assert_eq!(benchmark.policy("pi", late, 1.0), "pi");
    }

    #[test]
    fn an_unknown_benchmark_is_told_which_there_are() {
        let Err(CliError::Input(message)) = Benchmark::load("rign") else { panic!("there is none") };
        assert!(message.contains("did you mean ring") && message.contains("name one of ring"), "{message}");
    }
}
