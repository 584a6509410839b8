//! Settings by their own names, as `codrive train` takes them. In: the name of a ring or a configuration's file, and keyword
//! arguments of Python. Out: a checked [`TrainConfig`], or an error that names the key, the value and what is allowed.

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

/// Names of rings.
pub const RINGS: [&str; 2] = ["ring-250", "ring-641"];

/// Drivers of training: late, with an error and a habit that differ from episode to episode.
const LATE: &str = "late";

/// Settings of rings, checked. See `codrive.make` for what the arguments mean.
#[pyclass(frozen, module = "codrive._codrive")]
pub struct Configuration {
    pub config: TrainConfig,
    /// What the policy corrects, if anything.
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

    /// All settings, nested where they are tables, as JSON.
    fn json(&self) -> String {
        serde_json::to_value(&self.config).unwrap_or_default().to_string()
    }

    /// What each number of an observation is: its name, the value that becomes -1 and the one that becomes 1, SI units.
    fn inputs(&self) -> Vec<(&'static str, f64, f64)> {
        self.config.inputs().iter().map(|input| (input.feature.name(), input.from, input.to)).collect()
    }

    /// Levels of an action; 0 where it is continuous.
    #[getter]
    fn levels(&self) -> u32 {
        self.config.advice.levels
    }

    /// What -1 and 1 mean as an action (or the first and the last level), m/s or m/s2; an acceleration may be bounded further where
    /// `speed_change_mps` is set.
    #[getter]
    fn action_limits(&self) -> (f64, f64) {
        self.config.action_limits().into()
    }
}

/// The folder that holds `maps/` and `assets/`: that of `CODRIVE_DATA`, a checkout's, or what the wheel brings, written to the user's
/// cache.
#[pyfunction]
pub fn data_folder() -> PyResult<PathBuf> {
    data_folders::require().map_err(|why| PyValueError::new_err(why.to_string()))?;
    Ok(data_folders::root().to_path_buf())
}

/// The settings that a name stands for: those of a ring, or of a file.
fn base(name: &str) -> PyResult<TrainConfig> {
    match name {
        "ring-250" => Ok(TrainConfig::paper_ring()),
        "ring-641" => Ok(TrainConfig::larger_ring()),
        file if file.ends_with(".toml") => {
            settings::from_file(Path::new(file)).map_err(|why| PyValueError::new_err(why.message))
        }
        unknown => Err(PyValueError::new_err(format!(
            "there is no ring {unknown:?}{}; allowed: {}, or the FILE.toml of a training's configuration",
            did_you_mean(unknown, &RINGS),
            RINGS.join(", ")
        ))),
    }
}

/// The same rings with this driver: as `codrive evaluate --driver` names them, or [`LATE`].
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

/// Settings that keyword arguments name; tables such as `idm` are dicts.
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
        let field = fields.iter().find(|field| field.is_called(&path));
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

/// What the functions of Python take beside settings, for who has written one of them wrongly.
const ARGUMENTS: [&str; 8] = ["hold", "advice", "driver", "engine", "num_envs", "render_mode", "view", "size"];

/// The error of a name that none of these settings has.
pub fn unknown_setting(path: &str, fields: &[Field]) -> PyErr {
    let known: Vec<&str> = ARGUMENTS.into_iter().chain(fields.iter().map(|field| field.path.as_str())).collect();
    PyTypeError::new_err(unknown_key(path, &known))
}

/// The value of a setting, which is one and no list of several.
pub fn single(key: &str, value: Value) -> PyResult<Value> {
    match value {
        Value::Array(_) => Err(PyTypeError::new_err(format!("{key} is {value}; allowed: {ALLOWED}"))),
        value => Ok(value),
    }
}

/// What a setting can be.
const ALLOWED: &str = "a number, a text, True or False, or a dict of such";

/// Tables and lists within each other: settings have no more than a demand, and a dict of Python may hold itself.
const DEEPEST: usize = 8;

/// A value of Python as JSON: texts, numbers (numpy's, too), truth values, lists and dicts of such.
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
