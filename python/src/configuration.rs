//! Settings by their own names, as `codrive train` takes them. In: the name of a ring or a configuration's file, and keyword arguments of
//! Python. Out: a checked [`TrainConfig`], or an error that names the key, the value and the allowed values.

use codrive::{
    data_folders,
    driver::{self, DriverError, Population},
    policy::CorrectedAdvice,
    settings::{self, Field, fields_of},
    toml_text::{did_you_mean, unknown_key},
    train::{FollowKind, TrainConfig},
};
use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    types::{PyBool, PyDict, PyList, PyString, PyTuple},
};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// Name of the drivers of training: with a reaction time, an error and a bias that differ from episode to episode.
const LATE: &str = "late";

/// Checked settings of rings. See `codrive_sim.make` for the arguments.
#[pyclass(frozen, module = "codrive_sim._codrive")]
pub struct Configuration {
    pub config: TrainConfig,
    /// Advice that the policy corrects, if any.
    pub corrected: Option<CorrectedAdvice>,
}

#[pymethods]
impl Configuration {
    #[new]
    fn new(name: &str, driver: Option<&str>, settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        let base = base(name)?;
        let base = driver.map_or(Ok(base.clone()), |driver| driven_by(&base, driver))?;
        let config = settings::changed(&base, &changes(settings)?).map_err(|why| PyValueError::new_err(why.message))?;
        let corrected = config.corrected_advice().map_err(PyValueError::new_err)?;
        Ok(Self { config, corrected })
    }

    /// Returns all settings as JSON; tables are nested.
    fn json(&self) -> String {
        serde_json::to_value(&self.config).unwrap_or_default().to_string()
    }

    /// Returns the inputs of an observation: name, the value that becomes -1, and the value that becomes 1, in SI units.
    fn inputs(&self) -> Vec<(&'static str, f64, f64)> {
        self.config.inputs().iter().map(|input| (input.feature.name(), input.from, input.to)).collect()
    }

    /// Returns the names of the advised vehicles of each ring, by their numbers: "ego" and "vehicle_7".
    fn possible_agents(&self) -> Vec<String> {
        let name = |slot| if slot == 0 { "ego".into() } else { format!("vehicle_{slot}") };
        self.config.ring.advised_slots().map(name).collect()
    }

    /// Returns the number of levels of an action; 0 for continuous actions.
    #[getter]
    fn levels(&self) -> u32 {
        self.config.advice.levels
    }

    /// Returns the actions that -1 and 1 (or the first and the last level) stand for, m/s or m/s². An acceleration may have further limits
    /// if `speed_change_mps` is set.
    #[getter]
    fn action_limits(&self) -> (f64, f64) {
        self.config.action_limits().into()
    }
}

/// Returns the folder that holds `maps/` and `assets/`: the one in `CODRIVE_DATA`, a checkout, or the contents of the wheel, written to the
/// user's cache.
#[pyfunction]
pub fn data_folder() -> PyResult<PathBuf> {
    data_folders::require().map_err(|why| PyValueError::new_err(why.to_string()))?;
    Ok(data_folders::root().to_path_buf())
}

/// Returns the settings that a name stands for: a ring, or a file.
fn base(name: &str) -> PyResult<TrainConfig> {
    if name.ends_with(".toml") {
        return settings::from_file(Path::new(name)).map_err(|why| PyValueError::new_err(why.message));
    }
    TrainConfig::of_ring(name).ok_or_else(|| {
        PyValueError::new_err(format!(
            "there is no ring {name:?}{}; allowed: {}, or the FILE.toml of a training's configuration",
            did_you_mean(name, &TrainConfig::RINGS),
            TrainConfig::RINGS.join(", ")
        ))
    })
}

/// Returns the same rings with this driver: a name as in `codrive evaluate --driver`, or [`LATE`].
fn driven_by(config: &TrainConfig, name: &str) -> PyResult<TrainConfig> {
    if name == LATE {
        let driver = codrive::train::DriverConfig { follow: FollowKind::Driver, ..config.driver.clone() };
        return Ok(TrainConfig { driver, ..config.clone() });
    }
    if let Ok(population) = Population::named(name) {
        return Ok(config.driven_by_some_of(population));
    }
    match driver::named(name) {
        Ok(named) => Ok(config.driven_by(&named.params)),
        Err(DriverError::Unknown { name }) => {
            let known = [&driver::PRESETS[..], &driver::MACHINES, &Population::NAMES, &[LATE]].concat();
            Err(PyValueError::new_err(format!(
                "no driver is called {name:?}{}; allowed: {}, or numbers: \"reaction=1,error=0.5,speed_bias=0,deadband=0\"",
                did_you_mean(&name, &known),
                known.join(", ")
            )))
        }
        Err(fault) => Err(PyValueError::new_err(fault.to_string())),
    }
}

/// Returns the settings named by keyword arguments; tables such as `idm` are dicts.
fn changes(settings: &Bound<'_, PyDict>) -> PyResult<Vec<(Field, Value)>> {
    let fields = fields_of::<TrainConfig>();
    let Value::Object(named) = json(settings.as_any(), "settings")? else { return Ok(Vec::new()) };
    let mut flat = Vec::new();
    flatten(&fields, String::new(), named, &mut flat)?;
    Ok(flat)
}

fn flatten(fields: &[Field], table: String, named: Map<String, Value>, flat: &mut Vec<(Field, Value)>) -> PyResult<()> {
    for (key, value) in named {
        let path = format!("{table}{key}");
        let field = fields.iter().find(|field| field.path == path);
        match (field, value) {
            (Some(field), value) => flat.push((field.clone(), single(&path, value)?)),
            (None, Value::Object(inner)) if fields.iter().any(|field| field.table() == Some(&path)) => {
                flatten(fields, format!("{path}."), inner, flat)?;
            }
            (None, _) => return Err(unknown_setting(&path, fields)),
        }
    }
    Ok(())
}

/// Arguments of the Python functions that are not settings, for suggestions after a misspelling.
const ARGUMENTS: [&str; 12] = [
    "hold",
    "advice",
    "driver",
    "traffic",
    "num_envs",
    "own_process",
    "lane_changes",
    "observation",
    "observation_space",
    "render_mode",
    "view",
    "size",
];

/// Returns the error for a name that is none of these settings.
pub fn unknown_setting(path: &str, fields: &[Field]) -> PyErr {
    let known: Vec<&str> = ARGUMENTS.into_iter().chain(fields.iter().map(|field| field.path.as_str())).collect();
    PyTypeError::new_err(unknown_key(path, &known))
}

/// Returns the value of a setting, which must not be a list.
pub fn single(key: &str, value: Value) -> PyResult<Value> {
    match value {
        Value::Array(_) => Err(PyTypeError::new_err(format!("{key} is {value}; allowed: {ALLOWED}"))),
        value => Ok(value),
    }
}

/// Allowed values of a setting, for messages.
const ALLOWED: &str = "a number, a text, True or False, or a dict of such";

/// Maximum depth of nested tables and lists. A demand needs the most levels, and a Python dict may contain itself.
const DEEPEST: usize = 8;

/// Converts a Python value to JSON: texts, numbers (numpy's, too), truth values, and lists and dicts of these.
pub fn json(value: &Bound<'_, PyAny>, key: &str) -> PyResult<Value> {
    nested_json(value, key, 0)
}

fn nested_json(value: &Bound<'_, PyAny>, key: &str, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(PyTypeError::new_err(format!("{key} is nested too deeply; allowed: {ALLOWED}")));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let entry = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let key: String = key.extract()?;
            let value = nested_json(&value, &key, depth + 1)?;
            Ok((key, value))
        };
        return table.iter().map(entry).collect::<PyResult<Map<String, Value>>>().map(Value::Object);
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let entries = value.try_iter()?.map(|entry| nested_json(&entry?, key, depth + 1));
        return entries.collect::<PyResult<Vec<Value>>>().map(Value::Array);
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_str()?.into());
    }
    if let Ok(switch) = value.cast::<PyBool>() {
        return Ok(switch.is_true().into());
    }
    if let Ok(whole) = value.extract::<u64>() {
        return Ok(whole.into());
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(whole.into());
    }
    match value.extract::<f64>() {
        Ok(number) => Ok(number.into()),
        Err(_) => Err(PyTypeError::new_err(format!(
            "{key} is {}; allowed: {ALLOWED}",
            value.repr().map(|repr| repr.to_string()).unwrap_or_else(|_| "unknown".into())
        ))),
    }
}
