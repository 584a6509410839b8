//! Settings of whole drives for Python. In: the name of a map, a driver, keyword arguments. Out: checked settings, and what they mean for
//! observations, actions and agents.

use crate::{
    configuration::{Configuration, json, single, unknown_setting},
    threads,
};
use codrive::{
    data_folders,
    drive_loop::{
        episode,
        episode_config::{EpisodeConfig, LATE},
    },
    driver::{self, DriverError, Population},
    settings::Field,
    toml_text::did_you_mean,
    traffic::{Demand, EGO, EngineChoice},
};
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    types::PyDict,
};
use serde_json::{Map, Value};
use std::path::PathBuf;

/// Name of the setting for the vehicles that enter a network, which is not a plain value.
const DEMAND: &str = "demand";

/// Name of the setting that chooses the engine of the traffic.
const TRAFFIC: &str = "traffic";

/// Checked settings of whole drives. See `codrive_sim.make` for the arguments.
#[pyclass(frozen, module = "codrive_sim._codrive")]
pub struct DriveConfiguration {
    pub config: EpisodeConfig,
    is_open: bool,
}

#[pymethods]
impl DriveConfiguration {
    /// Reads settings of `codrive run` and of episodes on a road; `driver` is a name, numbers, a population, or "late".
    #[new]
    fn new(py: Python<'_>, map: &str, driver: Option<&str>, settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        data_folders::require().map_err(|why| PyValueError::new_err(why.to_string()))?;
        let Value::Object(named) = json(settings.as_any(), "settings")? else {
            return Err(PyTypeError::new_err("settings: a dict"));
        };
        let asked_engine = named.get(TRAFFIC).and_then(Value::as_str).map(str::to_string);
        let (demand, changes) = changes(named)?;
        let made = || {
            let config = EpisodeConfig::new(map, driver, demand, &changes)
                .map_err(|why| about_engine(&why.key, asked_engine.as_deref()).unwrap_or(why.message))?;
            let is_open = config.drive(0).map_err(|why| why.to_string())?.is_open();
            Ok::<_, String>(Self { config, is_open })
        };
        threads::interruptible(py, made)?
            .map_err(|why| unknown_driver(driver).unwrap_or_else(|| PyValueError::new_err(why)))
    }

    /// Returns all settings of the drive as JSON, and in `learning` the settings of training that apply here.
    fn json(&self) -> String {
        let scenario = serde_json::to_value(&self.config.scenario).unwrap_or_default();
        let learning = serde_json::to_value(&self.config.learning).unwrap_or_default();
        let mut all = serde_json::to_value(Map::new()).unwrap_or_default();
        for field in EpisodeConfig::fields() {
            let value = field.get(&scenario).or_else(|| field.get(&learning));
            value.into_iter().for_each(|value| field.set(&mut all, value.clone()));
        }
        if let Some(demand) = scenario.get(DEMAND) {
            all[DEMAND] = demand.clone();
        }
        all.to_string()
    }

    /// Returns the inputs of an observation: name, the value that becomes -1, and the value that becomes 1, in SI units.
    fn inputs(&self) -> Vec<(&'static str, f64, f64)> {
        self.config.inputs().iter().map(|input| (input.feature.name(), input.from, input.to)).collect()
    }

    /// Returns the number of levels of an action; 0 for continuous actions.
    #[getter]
    fn levels(&self) -> u32 {
        self.config.learning.advice.levels
    }

    /// Returns the actions that -1 and 1 (or the first and the last level) stand for, m/s or m/s². An acceleration may have further limits
    /// if `speed_change_mps` is set.
    #[getter]
    fn action_limits(&self) -> (f64, f64) {
        self.config.learning.action_limits().into()
    }

    /// Returns the settings that define the meaning of a policy's numbers, for a policy that learns in such drives.
    #[getter]
    fn learning(&self) -> Configuration {
        Configuration { config: self.config.learning.clone(), corrected: None }
    }

    /// Returns true if SUMO moves the traffic in this process, which can hold one SUMO at a time.
    #[getter]
    fn needs_sumo(&self) -> bool {
        self.config.scenario.traffic == EngineChoice::Sumo
    }

    /// Returns true if vehicles enter and leave, so that the advised ones are not known before.
    #[getter]
    fn is_open(&self) -> bool {
        self.is_open
    }

    /// Returns true on a network on which no vehicle is ever advised.
    #[getter]
    fn advises_none(&self) -> bool {
        self.is_open && self.config.scenario.advises_no_vehicle()
    }

    /// Returns the names of all vehicles that can be advised. On an open road these are the ones known before: the participant's vehicle,
    /// or none.
    fn possible_agents(&self) -> Vec<String> {
        let scenario = &self.config.scenario;
        let ego = (scenario.participant || !self.is_open).then_some(EGO);
        let others = scenario.advised.others(if self.is_open { 0 } else { scenario.vehicles });
        ego.into_iter().chain(others.map(codrive::traffic::VehicleId)).map(episode::name).collect()
    }
}

/// Splits keyword arguments into the demand and the settings of an episode.
fn changes(named: Map<String, Value>) -> PyResult<(Demand, Vec<(Field, Value)>)> {
    let fields = EpisodeConfig::fields();
    let (mut demand, mut flat) = (Demand::default(), Vec::new());
    for (key, value) in named {
        if key == DEMAND {
            demand = read_demand(value)?;
            continue;
        }
        if let Some(field) = fields.iter().find(|field| field.path == key) {
            flat.push((field.clone(), single(&key, value)?));
            continue;
        }
        match value {
            Value::Object(inner) if fields.iter().any(|field| field.table() == Some(&key)) => {
                for (name, value) in inner {
                    let path = format!("{key}.{name}");
                    let field = fields.iter().find(|field| field.path == path);
                    let field = field.ok_or_else(|| unknown_setting(&path, &fields))?;
                    flat.push((field.clone(), single(&path, value)?));
                }
            }
            _ => {
                let why = EpisodeConfig::why_not(&key).map(|why| PyTypeError::new_err(format!("{key}: {why}")));
                return Err(why.unwrap_or_else(|| unknown_setting(&key, &fields)));
            }
        }
    }
    Ok((demand, flat))
}

/// Returns the message for a fault of this setting in terms of Python, if it is caused by the chosen engine.
fn about_engine(key: &str, engine: Option<&str>) -> Option<String> {
    let engine = engine.filter(|engine| key == TRAFFIC && *engine == "native")?;
    Some(format!(
        "traffic is '{engine}'; allowed on a road network, with a path or with a demand: 'sumo', the only engine with \
         vehicles that enter and leave\n  remedy: traffic='sumo', or a closed route such as \"ring-250\" or \
         \"practice\""
    ))
}

/// Reads the vehicles that enter a network: the path of a SUMO file, or the keys of a scenario's `[demand]`, such as `{"files": [...],
/// "additional_files": [...], "begin_s": 25200.0, "flows": [{"from": ..., "to": ..., "per_hour": ...}]}`.
fn read_demand(value: Value) -> PyResult<Demand> {
    if let Value::String(file) = value {
        return Ok(Demand { files: vec![PathBuf::from(file)], ..Demand::default() });
    }
    serde_json::from_value(value).map_err(|error| PyValueError::new_err(format!("demand: {error}")))
}

/// Returns the error for an unknown driver, with the known ones.
fn unknown_driver(driver: Option<&str>) -> Option<PyErr> {
    let name = driver?;
    if name == LATE || Population::named(name).is_ok() {
        return None;
    }
    let Err(DriverError::Unknown { name }) = driver::named(name) else { return None };
    let known = [&driver::PRESETS[..], &driver::MACHINES, &Population::NAMES, &[LATE]].concat();
    Some(PyValueError::new_err(format!(
        "no driver is called {name:?}{}; allowed: {}, or numbers: \"reaction=1,error=0.5,speed_bias=0,deadband=0\"",
        did_you_mean(&name, &known),
        known.join(", ")
    )))
}
