//! Whole drives for Python: physics, pedals and traffic of either engine, advised hold by hold. In: settings, a seed, actions. Out: what
//! advised vehicles see, their rewards and endings, as numpy arrays. See `codrive._drive` for what stands around it.

#[cfg(feature = "desktop")]
use crate::picture::Shot;
use crate::{
    configuration::{Configuration, json, single, unknown_setting},
    threads,
};
use codrive::{
    data_folders,
    drive_loop::episode::{self, Episode, EpisodeError, HoldOutcome},
    drive_loop::episode_config::{EpisodeConfig, LATE},
    driver::{self, DriverError, Population},
    native_code,
    scenario::Scenario,
    settings::Field,
    toml_text::did_you_mean,
    traffic::{Demand, EGO, EngineChoice, sumo},
};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::{
    exceptions::{PyRuntimeError, PyTypeError, PyValueError},
    prelude::*,
    types::PyDict,
};
use serde_json::{Map, Value};
use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

/// True if this module can draw (the cargo feature `desktop`).
pub const HAS_DESKTOP: bool = cfg!(feature = "desktop");

/// The setting that says who comes to a network, which is no plain value.
const DEMAND: &str = "demand";

/// The setting that Python calls `engine`.
const ENGINE: &str = "traffic";

/// Settings of whole drives, checked. See `codrive.make` for what the arguments mean.
#[pyclass(frozen, module = "codrive._codrive")]
pub struct DriveConfiguration {
    config: EpisodeConfig,
    is_open: bool,
}

#[pymethods]
impl DriveConfiguration {
    /// Settings of `codrive run` and of episodes on a road; `driver` is a name, numbers, a population, or "late".
    #[new]
    fn new(py: Python<'_>, map: &str, driver: Option<&str>, settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        data_folders::require().map_err(refused)?;
        let Value::Object(named) = json(settings.as_any(), "settings")? else {
            return Err(PyTypeError::new_err("settings: a dict"));
        };
        let asked_engine = named.get(ENGINE).and_then(Value::as_str).map(str::to_string);
        let (demand, changes) = changes(named)?;
        let made = || {
            let config = EpisodeConfig::new(map, driver, demand, &changes)
                .map_err(|why| about_engine(&why.key, asked_engine.as_deref()).unwrap_or(why.message))?;
            let is_open = config.is_open().map_err(|why| why.to_string())?;
            Ok::<_, String>(Self { config, is_open })
        };
        threads::interruptible(py, made)?
            .map_err(|why| unknown_driver(driver).unwrap_or_else(|| PyValueError::new_err(why)))
    }

    /// All settings as JSON: those of the drive, and in `learning` those of training that have a meaning here.
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

    /// What each number of an observation is: its name, the value that becomes -1 and the one that becomes 1, SI units.
    fn inputs(&self) -> Vec<(&'static str, f64, f64)> {
        self.config.inputs().iter().map(|input| (input.feature.name(), input.from, input.to)).collect()
    }

    /// Levels of an action; 0 where it is continuous.
    #[getter]
    fn levels(&self) -> u32 {
        self.config.learning.advice.levels
    }

    /// What -1 and 1 mean as an action (or the first and the last level), m/s or m/s2; an acceleration may be bounded further where
    /// `speed_change_mps` is set.
    #[getter]
    fn action_limits(&self) -> (f64, f64) {
        self.config.learning.action_limits().into()
    }

    /// What says of a policy that learns in such drives what its numbers mean, as for one that learns on rings.
    #[getter]
    fn learning(&self) -> Configuration {
        Configuration { config: self.config.learning.clone(), corrected: None }
    }

    /// SUMO moves the traffic in this process, of which there is one at a time.
    #[getter]
    fn needs_sumo(&self) -> bool {
        self.config.scenario.traffic == EngineChoice::Sumo
    }

    /// Vehicles come and go: who will be advised is not known before.
    #[getter]
    fn is_open(&self) -> bool {
        self.is_open
    }

    /// Names of all that can be advised; of an open road those that are known before: the participant's vehicle, or nobody.
    fn possible_agents(&self) -> Vec<String> {
        let scenario = &self.config.scenario;
        let ego = scenario.participant.then_some(EGO);
        let others = scenario.advised.others(if self.is_open { 0 } else { scenario.vehicles });
        ego.into_iter().chain(others.map(codrive::traffic::VehicleId)).map(episode::name).collect()
    }
}

/// Keyword arguments as settings of an episode, and the demand apart from them.
fn changes(named: Map<String, Value>) -> PyResult<(Demand, Vec<(Field, Value)>)> {
    let fields = EpisodeConfig::fields();
    let (mut demand, mut flat) = (Demand::default(), Vec::new());
    for (key, value) in named {
        if key == DEMAND {
            demand = read_demand(value)?;
            continue;
        }
        if let Some(field) = fields.iter().find(|field| field.is_called(&key)) {
            flat.push((field.clone(), single(&key, value)?));
            continue;
        }
        match value {
            Value::Object(inner) if fields.iter().any(|field| field.table() == Some(&key)) => {
                for (name, value) in inner {
                    let path = format!("{key}.{name}");
                    let field = fields.iter().find(|field| field.is_called(&path));
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

/// What a fault of this setting is in the words of Python, where it is one of the engine that was asked for.
fn about_engine(key: &str, engine: Option<&str>) -> Option<String> {
    let engine = engine.filter(|engine| key == ENGINE && *engine == "native")?;
    Some(format!(
        "engine is '{engine}'; allowed on a road network, with a path or with a demand: 'sumo', which alone moves vehicles that come and \
         go\n  remedy: engine='sumo', or a closed route such as \"ring-250\" or \"practice\""
    ))
}

/// Who comes to a network: a file of SUMO's by its path, or `{"files": [...], "flows": [{"from": ..., "to": ..., "per_hour": ...}]}`.
fn read_demand(value: Value) -> PyResult<Demand> {
    if let Value::String(file) = value {
        return Ok(Demand { files: vec![PathBuf::from(file)], flows: Vec::new() });
    }
    serde_json::from_value(value).map_err(|error| PyValueError::new_err(format!("demand: {error}")))
}

/// The error of a driver whom nobody knows, with all that are known here.
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

/// One drive at a time, and what its last hold brought.
#[derive(Default)]
struct Running {
    episode: Option<Episode>,
    last: Option<HoldOutcome>,
}

/// One drive at a time. See `codrive._drive` for what stands around it.
#[pyclass(frozen, module = "codrive._codrive")]
pub struct Drive {
    config: EpisodeConfig,
    running: Mutex<Running>,
    #[cfg(feature = "desktop")]
    pictures: Mutex<Option<codrive::render::DrivePictures>>,
}

#[pymethods]
impl Drive {
    #[new]
    fn new(configuration: &DriveConfiguration) -> Self {
        Self {
            config: configuration.config.clone(),
            running: Mutex::default(),
            #[cfg(feature = "desktop")]
            pictures: Mutex::default(),
        }
    }

    /// Begins the drive of this seed, whatever became of the one before: the world, its warm-up, up to the first hold.
    fn begin(&self, py: Python<'_>, seed: u64) -> PyResult<()> {
        let most = most_seed();
        if seed > most {
            return Err(PyValueError::new_err(format!("seed is {seed}; allowed: a whole number from 0 to {most}")));
        }
        let begun = threads::interruptible(py, || {
            let mut running = self.lock();
            // SUMO runs once a process: the drive before lets go of it first.
            *running = Running::default();
            running.episode = Some(Episode::begin(&self.config, seed)?);
            Ok::<_, codrive::drive_loop::RunError>(())
        })?;
        begun.map_err(|why| PyRuntimeError::new_err(why.to_string()))
    }

    /// Lets go of the drive, and of SUMO. Another may be begun.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        threads::here(py, || *self.lock() = Running::default())
    }

    /// Who can be advised now, "ego" (the participant's vehicle) first; nobody once the drive is over.
    fn agents(&self) -> PyResult<Vec<String>> {
        self.with(|episode| episode.agents().map(episode::name).collect())
    }

    /// What they see, scaled as for training, float32, `(agents, inputs)`.
    fn observations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let rows = self.with(|episode| episode.scaled(episode.observations()))?;
        self.table(py, rows)
    }

    /// One hold under these actions, float32, `(agents,)`: -1 to 1 spans the limits, or numbers of levels.
    fn hold(&self, py: Python<'_>, actions: PyReadonlyArray1<'_, f32>) -> PyResult<()> {
        let actions = actions.as_slice()?;
        let driven = threads::here(py, || {
            let mut running = self.lock();
            // Beside its place while it is driven: what panics is not driven on.
            let mut episode = running.episode.take()?;
            let outcome = episode.hold(actions);
            match outcome {
                Ok(outcome) => {
                    *running = Running { episode: Some(episode), last: Some(outcome) };
                    Some(Ok(()))
                }
                Err(EpisodeError::Run(why)) => Some(Err(EpisodeError::Run(why))),
                Err(refused) => {
                    running.episode = Some(episode);
                    Some(Err(refused))
                }
            }
        })?;
        match driven {
            None => Err(not_begun()),
            Some(Ok(())) => Ok(()),
            Some(Err(why @ (EpisodeError::Run(_) | EpisodeError::Over))) => {
                Err(PyRuntimeError::new_err(why.to_string()))
            }
            Some(Err(why)) => Err(PyValueError::new_err(why.to_string())),
        }
    }

    /// Rewards of the last hold, m/s, float64: a number for each of those that were agents before it, as the next two.
    fn rewards<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let rewards: Vec<f64> = self.last(|last| last.agents.iter().map(|agent| agent.reward).collect())?;
        Ok(PyArray1::from_vec(py, rewards))
    }

    /// True of those that have left the road, and of all after the first contact of an advised vehicle.
    fn terminations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let ended: Vec<bool> = self.last(|last| last.agents.iter().map(|agent| agent.is_terminated).collect())?;
        Ok(PyArray1::from_vec(py, ended))
    }

    /// What they see after it, or saw last, float32, `(agents before it, inputs)`.
    fn final_observations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let seen: Vec<_> = self.last(|last| last.agents.iter().map(|agent| agent.last_seen).collect())?;
        let rows = self.with(|episode| episode.scaled(seen))?;
        self.table(py, rows)
    }

    /// Mean speed of all vehicles over the last hold, m/s.
    fn mean_speed_mps(&self) -> PyResult<f64> {
        self.last(|last| last.mean_speed_mps)
    }

    /// The last hold reached the horizon, or the end of the participant's way: nobody is advised any more.
    fn is_truncated(&self) -> PyResult<bool> {
        self.last(|last| last.is_truncated)
    }

    /// Of all states of all steps so far: equal if every bit of them is, 16 hexadecimal digits.
    fn fingerprint(&self) -> PyResult<String> {
        self.with(|episode| format!("{:016x}", episode.fingerprint()))
    }

    /// Seconds that are driven since the warm-up.
    fn time_s(&self) -> PyResult<f64> {
        self.with(|episode| episode.world().time_s())
    }

    /// The picture of this moment, uint8, `(height, width, 3)`; `view` is driver, mirror, birdseye or chase.
    #[cfg(feature = "desktop")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: u32,
        view: &str,
    ) -> PyResult<Bound<'py, numpy::PyArray3<u8>>> {
        let shot = Shot::new(view, [width, height])?;
        let drawn = threads::here(py, || {
            let mut pictures = self.pictures.lock().unwrap_or_else(PoisonError::into_inner);
            self.lock().episode.as_ref().map(|episode| shot.draw(&mut pictures, episode.world()))
        })?;
        shot.array(py, drawn.ok_or_else(not_begun)?)
    }

    /// The same where this build draws none.
    #[cfg(not(feature = "desktop"))]
    #[expect(unused_variables, reason = "the same call as where pictures are drawn")]
    fn render(&self, width: u32, height: u32, view: &str) -> PyResult<()> {
        Err(PyRuntimeError::new_err(
            "this build of codrive draws no pictures\n  remedy: build it from a checkout with the desktop feature: \
             maturin build --release --features desktop, in the folder python",
        ))
    }
}

impl Drive {
    fn lock(&self) -> std::sync::MutexGuard<'_, Running> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(&self, look: impl FnOnce(&Episode) -> T) -> PyResult<T> {
        self.lock().episode.as_ref().map(look).ok_or_else(not_begun)
    }

    fn last<T>(&self, look: impl FnOnce(&HoldOutcome) -> T) -> PyResult<T> {
        let none = || PyRuntimeError::new_err("no hold has been driven yet");
        self.lock().last.as_ref().map(look).ok_or_else(none)
    }

    fn table<'py>(&self, py: Python<'py>, rows: Vec<f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let inputs = self.config.inputs().len();
        let count = rows.len() / inputs.max(1);
        PyArray1::from_vec(py, rows).reshape([count, inputs])
    }
}

/// The SUMO that drives in this process would have; `None` where there is none.
#[pyfunction]
pub fn sumo_home() -> Option<PathBuf> {
    sumo::home().ok()
}

/// Lets this interpreter try networks that do not come with codrive (`_check_network.py` beside this module), so that one on which SUMO
/// breaks down takes a process of its own along. Without effect where there is no interpreter to start.
pub fn try_networks_apart(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let program: Option<PathBuf> = module.py().import("sys")?.getattr("executable")?.extract()?;
    let file = module.filename().and_then(|file| file.extract::<PathBuf>());
    if let Ok(file) = &file {
        // Libraries and data are looked for beside this module, not beside the interpreter.
        native_code::program_is(file.clone());
    }
    if let (Some(program), Ok(file)) = (program.filter(|program| program.is_file()), file) {
        sumo::check_networks_by(program, vec![file.with_file_name("_check_network.py").into()]);
    }
    Ok(())
}

/// What that program does: drives some cars on a network to see whether SUMO survives it. Raises `RuntimeError` where it does not.
#[pyfunction]
pub fn try_network(py: Python<'_>, file: PathBuf) -> PyResult<()> {
    threads::interruptible(py, || sumo::try_network(&file))?.map_err(|why| PyRuntimeError::new_err(why.to_string()))
}

/// The largest seed of a drive: every reader of a recording keeps it exactly.
fn most_seed() -> u64 {
    let seed = Scenario::fields().into_iter().find(|field| field.path == "seed").map(|field| field.kind);
    match seed {
        Some(codrive::settings::SettingKind::Whole { max, .. }) => max,
        _ => u64::MAX,
    }
}

fn not_begun() -> PyErr {
    PyRuntimeError::new_err("no drive has begun: reset first")
}

fn refused(why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}
