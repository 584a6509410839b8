//! Whole drives for Python: physics, pedals and traffic of either engine, advised hold by hold. In: settings, a seed, actions. Out: the
//! observations, rewards and endings of advised vehicles, as numpy arrays. `codrive_sim._drive` wraps this.

#[cfg(feature = "desktop")]
use crate::picture::Shot;
use crate::{
    drive_configuration::DriveConfiguration,
    threads,
    traffic_columns::{self, VEHICLE_COLUMNS},
};
use codrive::{
    drive_loop::{
        episode::{self, Episode, EpisodeError, HoldOutcome},
        episode_config::EpisodeConfig,
    },
    map::network::SignalId,
    native_code,
    scenario::Scenario,
    sim::WorldError,
    toml_text::did_you_mean,
    traffic::{TrafficOrder, VehicleId, sumo},
};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use std::{
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

/// True if this module can draw (the cargo feature `desktop`).
pub const HAS_DESKTOP: bool = cfg!(feature = "desktop");

/// Result of a hold. Of the vehicles that were agents before it: rewards, m/s, float64; true for vehicles that have left the road, and for
/// all after the first contact of an advised vehicle; the last observations, float32, `(agents, inputs)`. Then whether the horizon or the end
/// of the participant's route is reached; the measures in the order of `HOLD_MEASURES`; the time since the drive began, s; the vehicles that
/// can be advised next, and their observations.
type HoldResult<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray2<f32>>,
    bool,
    Bound<'py, PyArray1<f64>>,
    f64,
    Vec<String>,
    Bound<'py, PyArray2<f32>>,
);

/// Array of one axis for numpy.
type Numbers<'py, T> = Bound<'py, PyArray1<T>>;

/// Lane: id, width, m, and centre line, float64, `(points, 2)`.
type LaneLine<'py> = (String, f64, Bound<'py, PyArray2<f64>>);

/// Environment that holds one drive at a time. `codrive_sim._drive` wraps this.
#[pyclass(frozen, module = "codrive_sim._codrive")]
pub struct Drive {
    config: EpisodeConfig,
    /// Number of inputs of an observation.
    inputs: usize,
    episode: Mutex<Option<Episode>>,
    #[cfg(feature = "desktop")]
    pictures: Mutex<Option<codrive::render::DrivePictures>>,
}

#[pymethods]
impl Drive {
    #[new]
    fn new(configuration: &DriveConfiguration) -> Self {
        Self {
            config: configuration.config.clone(),
            inputs: configuration.config.inputs().len(),
            episode: Mutex::default(),
            #[cfg(feature = "desktop")]
            pictures: Mutex::default(),
        }
    }

    /// Begins the drive of this seed, in any state of the one before: the world, its warm-up, up to the first hold.
    fn begin(&self, py: Python<'_>, seed: u64) -> PyResult<()> {
        let most = most_seed();
        if seed > most {
            return Err(PyValueError::new_err(format!("seed is {seed}; allowed: a whole number from 0 to {most}")));
        }
        let begun = threads::interruptible(py, || {
            let mut present = self.lock();
            // A process can hold one SUMO, so the drive before must release it first.
            *present = None;
            *present = Some(Episode::begin(&self.config, seed)?);
            Ok::<_, codrive::drive_loop::RunError>(())
        })?;
        begun.map_err(|why| PyRuntimeError::new_err(why.to_string()))
    }

    /// Ends the drive and releases SUMO. Another drive may begin.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        threads::here(py, || *self.lock() = None)
    }

    /// Returns the vehicles that can be advised now, "ego" (the participant's vehicle) first; none once the drive is over.
    fn agents(&self) -> PyResult<Vec<String>> {
        self.with(|episode| episode.agents().map(episode::name).collect())
    }

    /// Returns the agents' observations, scaled as for training, float32, `(agents, inputs)`.
    fn observations<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let rows = self.with(|episode| episode.scaled(episode.observations()))?;
        self.table(py, rows)
    }

    /// Drives one hold under these actions, float32, `(agents,)`: -1 to 1 spans the limits, or numbers of levels.
    fn hold<'py>(&self, py: Python<'py>, actions: PyReadonlyArray1<'_, f32>) -> PyResult<HoldResult<'py>> {
        let actions = actions.as_slice()?;
        let driven = threads::here(py, || {
            let mut present = self.lock();
            // The episode is taken out while it is driven, so that one that panics is not continued.
            let mut episode = present.take()?;
            let outcome = episode.hold(actions);
            if !matches!(outcome, Err(EpisodeError::Run(_))) {
                *present = Some(episode);
            }
            Some(outcome)
        })?;
        match driven.ok_or_else(not_begun)? {
            Ok(outcome) => self.result(py, &outcome),
            Err(why @ (EpisodeError::Run(_) | EpisodeError::Over)) => Err(PyRuntimeError::new_err(why.to_string())),
            Err(why) => Err(PyValueError::new_err(why.to_string())),
        }
    }

    /// Returns all vehicles now, float64, `(columns, vehicles)`, in the order of `VEHICLE_COLUMNS`.
    fn vehicles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = self.with(|episode| traffic_columns::vehicles(episode.world()))?;
        let vehicles = columns.len() / VEHICLE_COLUMNS.len();
        PyArray1::from_vec(py, columns).reshape([VEHICLE_COLUMNS.len(), vehicles])
    }

    /// Returns for each of `vehicles` the vehicle ahead of it on its way within a distance, m: its number, -1 without one; and the gap, m, NaN
    /// without one. Only on networks with a demand.
    fn leaders<'py>(&self, py: Python<'py>, reach_m: f64) -> PyResult<(Numbers<'py, i64>, Numbers<'py, f64>)> {
        let leaders = self.with(|episode| traffic_columns::leaders(episode.world(), reach_m))?.map_err(refused)?;
        let cars = leaders.iter().map(|leader| leader.map_or(-1, |leader| leader.id.0.into()));
        let gaps = leaders.iter().map(|leader| leader.map_or(f64::NAN, |leader| leader.gap_m));
        Ok((PyArray1::from_iter(py, cars), PyArray1::from_iter(py, gaps)))
    }

    /// Returns the names of vehicles in the demand, and those of their types. Only on networks with a demand.
    fn names(&self, cars: Vec<u32>) -> PyResult<Vec<[String; 2]>> {
        let names = self.with(|episode| {
            cars.iter().map(|car| episode.world().names(VehicleId(*car))).collect::<Result<_, WorldError>>()
        })?;
        names.map_err(refused)
    }

    /// Returns for each lane its id, its width and its centre line, float64, `(points, 2)`, metres.
    fn lanes<'py>(&self, py: Python<'py>) -> PyResult<Vec<LaneLine<'py>>> {
        let lanes = self.with(|episode| traffic_columns::lanes(&episode.world().map().network))?;
        let lane = |(id, width_m, points): (String, f64, Vec<f64>)| {
            let count = points.len() / 2;
            Ok((id, width_m, PyArray1::from_vec(py, points).reshape([count, 2])?))
        };
        lanes.into_iter().map(lane).collect()
    }

    /// Returns the length of the route, m, and true if it is closed.
    fn route(&self) -> PyResult<(f64, bool)> {
        self.with(|episode| {
            let route = &episode.world().map().route;
            (route.length_m(), route.is_closed())
        })
    }

    /// Returns for each signal its id and the letters that it shows.
    fn signals(&self) -> PyResult<Vec<(String, String)>> {
        self.with(|episode| traffic_columns::signals(episode.world()))
    }

    /// Orders a vehicle to change lanes by this many to the left within a time, s, and then only by order.
    fn change_lane(&self, py: Python<'_>, car: u32, to_the_left: i32, duration_s: f64) -> PyResult<()> {
        self.order(py, &TrafficOrder::ChangeLane { id: VehicleId(car), to_the_left, duration_s, keeps_gaps: true })
    }

    /// Orders a vehicle to drive along these edges from the first one, where it is.
    fn set_route(&self, py: Python<'_>, car: u32, edges: Vec<String>) -> PyResult<()> {
        self.order(py, &TrafficOrder::Route { id: VehicleId(car), edges })
    }

    /// Orders a signal to begin a phase of its programme.
    fn set_phase(&self, py: Python<'_>, signal: &str, phase: u32) -> PyResult<()> {
        let signal = self.signal(signal)?;
        self.order(py, &TrafficOrder::Phase { signal, phase })
    }

    /// Orders a signal to show these letters, one for each link, until the next order.
    fn set_letters(&self, py: Python<'_>, signal: &str, letters: String) -> PyResult<()> {
        let signal = self.signal(signal)?;
        self.order(py, &TrafficOrder::State { signal, letters })
    }

    /// Orders a vehicle to change its speed evenly within a time, s; 0 is the next step.
    fn set_speed(&self, py: Python<'_>, car: u32, speed_mps: f64, duration_s: f64) -> PyResult<()> {
        self.order(py, &TrafficOrder::Speed { id: VehicleId(car), speed_mps, duration_s })
    }

    /// Orders the model of a vehicle to drive at this speed at most.
    fn set_max_speed(&self, py: Python<'_>, car: u32, speed_mps: f64) -> PyResult<()> {
        self.order(py, &TrafficOrder::MaxSpeed { id: VehicleId(car), speed_mps })
    }

    /// Orders a vehicle to obey the checks of this speed mode of SUMO.
    fn set_speed_mode(&self, py: Python<'_>, car: u32, mode: u32) -> PyResult<()> {
        self.order(py, &TrafficOrder::SpeedMode { id: VehicleId(car), mode })
    }

    /// Returns the fingerprint of all states so far, 16 hexadecimal digits: equal if every bit of them is equal.
    fn fingerprint(&self) -> PyResult<String> {
        self.with(|episode| format!("{:016x}", episode.fingerprint()))
    }

    /// Returns the driving time since the warm-up, s.
    fn time_s(&self) -> PyResult<f64> {
        self.with(|episode| episode.world().time_s())
    }

    /// Returns the present picture, uint8, `(height, width, 3)`; `view` is driver, mirror, birdseye or chase.
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
            self.lock().as_ref().map(|episode| shot.draw(&mut pictures, episode.world()))
        })?;
        shot.array(py, drawn.ok_or_else(not_begun)?)
    }

    /// Raises the error of a build without pictures.
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
    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Episode>> {
        self.episode.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(&self, look: impl FnOnce(&Episode) -> T) -> PyResult<T> {
        self.lock().as_ref().map(look).ok_or_else(not_begun)
    }

    fn result<'py>(&self, py: Python<'py>, outcome: &HoldOutcome) -> PyResult<HoldResult<'py>> {
        let HoldOutcome { agents, measures, is_truncated } = outcome;
        let (final_rows, time_s, next, rows) = self.with(|episode| {
            let last = episode.scaled(agents.iter().map(|agent| agent.last_seen));
            let next: Vec<String> = episode.agents().map(episode::name).collect();
            (last, episode.world().time_s(), next, episode.scaled(episode.observations()))
        })?;
        Ok((
            PyArray1::from_iter(py, agents.iter().map(|agent| agent.reward)),
            PyArray1::from_iter(py, agents.iter().map(|agent| agent.is_terminated)),
            self.table(py, final_rows)?,
            *is_truncated,
            PyArray1::from_slice(py, measures),
            time_s,
            next,
            self.table(py, rows)?,
        ))
    }

    fn signal(&self, id: &str) -> PyResult<SignalId> {
        let ids: Vec<String> = self
            .with(|episode| episode.world().map().network.signals().iter().map(|signal| signal.id.clone()).collect())?;
        let index = ids.iter().position(|own| own == id).ok_or_else(|| {
            let near = did_you_mean(id, &ids.iter().map(String::as_str).collect::<Vec<_>>());
            PyValueError::new_err(format!("no signal is called {id:?}{near}; env.signals has all of the network"))
        })?;
        Ok(SignalId::from_index(index))
    }

    fn order(&self, py: Python<'_>, order: &TrafficOrder) -> PyResult<()> {
        let given = threads::here(py, || self.lock().as_mut().map(|episode| episode.order(order)))?;
        given.ok_or_else(not_begun)?.map_err(refused)
    }

    fn table<'py>(&self, py: Python<'py>, rows: Vec<f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let count = rows.len() / self.inputs.max(1);
        PyArray1::from_vec(py, rows).reshape([count, self.inputs])
    }
}

/// Returns the home of the SUMO that drives in this process would load; `None` if there is none.
#[pyfunction]
pub fn sumo_home() -> Option<PathBuf> {
    sumo::home().ok()
}

/// Checks networks that do not come with codrive in a separate interpreter (`_check_network.py` beside this module). A network that crashes
/// SUMO then ends only that process. Does nothing if there is no interpreter to start.
pub fn try_networks_apart(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let program: Option<PathBuf> = module.py().import("sys")?.getattr("executable")?.extract()?;
    let file = module.filename().and_then(|file| file.extract::<PathBuf>());
    if let Ok(file) = &file {
        // Libraries and data are found relative to this module, not to the interpreter.
        native_code::program_is(file.clone());
    }
    if let (Some(program), Ok(file)) = (program.filter(|program| program.is_file()), file) {
        sumo::check_networks_by(program, vec![file.with_file_name("_check_network.py").into()]);
    }
    Ok(())
}

/// Drives some vehicles on a network to check that SUMO survives it; `_check_network.py` calls this. Raises `RuntimeError` if SUMO fails.
#[pyfunction]
pub fn try_network(py: Python<'_>, file: PathBuf) -> PyResult<()> {
    threads::interruptible(py, || sumo::try_network(&file))?.map_err(|why| PyRuntimeError::new_err(why.to_string()))
}

/// Returns the largest seed of a drive that every reader of a recording keeps exactly.
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
