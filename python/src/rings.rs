//! Many rings as one environment. In: one action for each advised vehicle, -1 to 1 or the number of a level. Out: observations, rewards and
//! endings, written into numpy's own memory. A ring that ends begins another episode in the same step. Each advised vehicle of each ring is a
//! row, ring after ring.

use crate::{
    configuration::Configuration,
    threads::{self, Signals},
};
use codrive::{
    policy::{CorrectedAdvice, NetworkInput, Observation},
    train::{RingVehicle, TrainConfig, environment::VecEnv, outcome::Ending, rollout::action, simd::LANES},
};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray1, PyUntypedArrayMethods};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use rayon::prelude::*;

/// Name of the episodes' random stream, the same as in `codrive train`, so that the rings are the same.
const STREAM: &str = "train";

/// Batch of rings, in blocks of 16.
pub struct RingBatch {
    config: TrainConfig,
    inputs: Vec<NetworkInput>,
    corrected: Option<CorrectedAdvice>,
    blocks: Vec<VecEnv>,
    rings: usize,
    /// Advised vehicles of each ring.
    advised: usize,
}

/// Output of a step: a row or a number for each advised vehicle of each ring.
pub struct StepBuffers<'a> {
    /// Next observation of each policy; after the end of an episode, the first one of the new episode. `(rows, inputs)`.
    pub observations: &'a mut [f32],
    /// Last observation of the old episode where one has just ended; other rows keep their values. `(rows, inputs)`.
    pub final_observations: &'a mut [f32],
    /// Rewards of the step, m/s.
    pub rewards: &'a mut [f64],
    /// Mean speed of all vehicles of the ring over the hold, m/s.
    pub mean_speeds_mps: &'a mut [f64],
    /// True if vehicles of the ring collided.
    pub terminations: &'a mut [bool],
    /// True if the ring has reached the horizon.
    pub truncations: &'a mut [bool],
}

impl RingBatch {
    /// Creates rings without an episode; [`RingBatch::reset`] begins them.
    pub fn new(configuration: &Configuration, rings: usize) -> Self {
        let Configuration { config, corrected } = configuration;
        let (config, corrected) = (config.clone(), corrected.clone());
        let advised = config.ring.advised_slots().count();
        Self { inputs: config.inputs(), config, corrected, blocks: Vec::new(), rings, advised }
    }

    /// Returns the number of rows: rings times advised vehicles.
    pub fn rows(&self) -> usize {
        self.rings * self.advised
    }

    /// Returns the number of inputs of an observation.
    pub fn inputs(&self) -> usize {
        self.inputs.len()
    }

    /// Begins the episodes of this seed, from the first one. Must be called within [`threads::here`]. After a signal there are no episodes.
    ///
    /// # Errors
    /// `RuntimeError` if the system gives no threads.
    pub fn reset(&mut self, seed: u64, signals: &Signals) -> PyResult<()> {
        self.config.seed = seed;
        let count = self.rings.div_ceil(LANES);
        let block = |index| {
            let block = VecEnv::new(&self.config, STREAM, index, self.config.hold_of(index, count));
            let mut block = block.with_rings((self.rings - index * LANES).min(LANES));
            if let Some(advice) = &self.corrected {
                block.correct(advice);
            }
            block
        };
        let mut blocks: Vec<Option<VecEnv>> = (0..count).map(|_| None).collect();
        on_each(&mut blocks, signals, |index, made| *made = Some(block(index)))?;
        // Without one of them, the others are no use.
        self.blocks = blocks.into_iter().collect::<Option<Vec<_>>>().unwrap_or_default();
        Ok(())
    }

    /// Begins the next episode of the `wanted` rings. Must be called within [`threads::here`]. After a signal some have not begun.
    ///
    /// # Errors
    /// `RuntimeError` if the system gives no threads.
    pub fn begin(&mut self, wanted: impl Fn(usize) -> bool + Sync, signals: &Signals) -> PyResult<()> {
        let rings = self.rings;
        on_each(&mut self.blocks, signals, |index, block| {
            let wanted = (0..LANES).filter(|l| index * LANES + l < rings && wanted(index * LANES + l));
            wanted.for_each(|l| block.begin_episode(l));
        })
    }

    /// Writes the present observation of each policy.
    pub fn observe(&self, observations: &mut [f32]) {
        let inputs = &self.inputs;
        let rows = observations.par_chunks_mut(LANES * self.advised * inputs.len());
        self.blocks.par_iter().zip(rows).for_each(|(block, rows)| {
            let rows = rows.chunks_exact_mut(inputs.len()).enumerate();
            rows.for_each(|(row, numbers)| scale(inputs, &block.observe(row), numbers));
        });
    }

    /// Returns places along the rings, m, and speeds, m/s, of all vehicles, `(2, rings, most)`, the ego first, then backwards; NaN where a
    /// ring has fewer. `has_ended`: at the end of each ring's last episode, else now.
    pub fn vehicles(&self, has_ended: bool) -> Vec<f64> {
        let most = self.config.ring.vehicles_max as usize;
        let mut columns = vec![f64::NAN; 2 * self.rings * most];
        let (places, speeds) = columns.split_at_mut(self.rings * most);
        for (ring, (places, speeds)) in places.chunks_mut(most).zip(speeds.chunks_mut(most)).enumerate() {
            let (block, l) = (&self.blocks[ring / LANES], ring % LANES);
            let put = |(k, vehicle): (usize, RingVehicle)| (places[k], speeds[k]) = (vehicle.s_m, vehicle.speed_mps);
            match has_ended {
                true => block.ended().vehicles(l).enumerate().for_each(put),
                false => block.vehicles(l).enumerate().for_each(put),
            }
        }
        columns
    }

    /// Drives one hold of all rings on all cores. Must be called within [`threads::here`]. After a signal there are no episodes, as some
    /// rings have driven the hold and others not.
    ///
    /// # Errors
    /// `RuntimeError` if the system gives no threads.
    pub fn step(&mut self, actions: &[f32], out: StepBuffers<'_>, signals: &Signals) -> PyResult<()> {
        let (config, inputs) = (&self.config, &self.inputs);
        let blocks = self.blocks.len().div_ceil(threads::cores()?);
        let rows = blocks * LANES * self.advised;
        let numbers = rows * inputs.len();
        let parts = self.blocks.chunks_mut(blocks).zip(actions.chunks(rows));
        let seen = out.observations.chunks_mut(numbers).zip(out.final_observations.chunks_mut(numbers));
        let earned = out.rewards.chunks_mut(rows).zip(out.mean_speeds_mps.chunks_mut(rows));
        let ended = out.terminations.chunks_mut(rows).zip(out.truncations.chunks_mut(rows));
        let parts = parts.zip(seen).zip(earned.zip(ended)).map(|(((blocks, actions), seen), (earned, ended))| {
            let [observations, final_observations] = seen.into();
            let ([rewards, mean_speeds_mps], [terminations, truncations]) = (earned.into(), ended.into());
            let out =
                StepBuffers { observations, final_observations, rewards, mean_speeds_mps, terminations, truncations };
            (blocks, actions, out)
        });
        let work = |(blocks, actions, out): (&mut [VecEnv], _, _)| step(config, inputs, blocks, actions, out, signals);
        threads::side_by_side(parts.collect(), work)?;
        if signals.have_come() {
            self.blocks.clear();
        }
        Ok(())
    }
}

/// Works on each item by its index, on all cores, until a signal comes.
fn on_each<T: Send>(items: &mut [T], signals: &Signals, work: impl Fn(usize, &mut T) + Sync) -> PyResult<()> {
    let most = items.len().div_ceil(threads::cores()?).max(1);
    let parts = items.chunks_mut(most).enumerate().collect();
    threads::side_by_side(parts, |(part, items): (usize, &mut [T])| {
        let first = part * most;
        (first..).zip(items).take_while(|_| !signals.have_come()).for_each(|(index, item)| work(index, item));
    })
}

/// Drives one hold of some blocks, until a signal comes.
fn step(
    config: &TrainConfig,
    inputs: &[NetworkInput],
    blocks: &mut [VecEnv],
    actions: &[f32],
    out: StepBuffers<'_>,
    signals: &Signals,
) {
    let (count, mut first) = (inputs.len(), 0);
    let Some(rows) = blocks.first().map(VecEnv::rows) else { return };
    let mut drawn = Vec::with_capacity(rows);
    for (block, actions) in blocks.iter_mut().zip(actions.chunks(rows)) {
        if signals.have_come() {
            return;
        }
        let hold = block.hold_length();
        drawn.clear();
        // Rings beyond the last one get the middle action; their results are not used.
        drawn.extend((0..rows).map(|row| action(config, actions.get(row).copied().unwrap_or(0.0), hold)));
        block.hold_each(&drawn, |block, row, outcome| {
            if row >= actions.len() {
                return;
            }
            let number = first + row;
            let place = number * count..(number + 1) * count;
            let Some(outcome) = outcome else {
                // The ring has begun another episode.
                return scale(inputs, &block.observe(row), &mut out.observations[place]);
            };
            scale(inputs, &outcome.last_seen, &mut out.observations[place.clone()]);
            if outcome.ending != Ending::None {
                out.final_observations[place.clone()].copy_from_slice(&out.observations[place]);
            }
            out.rewards[number] = f64::from(outcome.reward);
            out.mean_speeds_mps[number] = f64::from(outcome.mean_mps);
            out.terminations[number] = outcome.ending == Ending::Crash;
            out.truncations[number] = outcome.ending == Ending::Horizon;
        });
        first += rows;
    }
}

fn scale(inputs: &[NetworkInput], seen: &Observation, row: &mut [f32]) {
    row.iter_mut().zip(inputs).for_each(|(number, input)| *number = input.scaled(seen));
}

/// Writes one scaled row for each observation.
pub fn scale_rows(inputs: &[NetworkInput], seen: &[Observation], rows: &mut [f32]) {
    rows.chunks_exact_mut(inputs.len()).zip(seen).for_each(|(row, seen)| scale(inputs, seen, row));
}

/// Rings whose steps are written into numpy arrays that are made once. `codrive_sim._ring` wraps this.
#[pyclass(module = "codrive_sim._codrive")]
pub struct Rings {
    batch: RingBatch,
    levels: u32,
    observations: Py<PyArray2<f32>>,
    final_observations: Py<PyArray2<f32>>,
    rewards: Py<PyArray1<f64>>,
    mean_speeds_mps: Py<PyArray1<f64>>,
    terminations: Py<PyArray1<bool>>,
    truncations: Py<PyArray1<bool>>,
}

#[pymethods]
impl Rings {
    #[new]
    fn new(py: Python<'_>, configuration: &Configuration, num_envs: usize) -> PyResult<Self> {
        if !(1..=65_536).contains(&num_envs) {
            return Err(PyValueError::new_err(format!("num_envs is {num_envs}; allowed: 1 to 65536")));
        }
        let batch = RingBatch::new(configuration, num_envs);
        let rows = batch.rows();
        let table = || PyArray2::zeros(py, [rows, batch.inputs()], false).unbind();
        Ok(Self {
            observations: table(),
            final_observations: table(),
            rewards: PyArray1::zeros(py, rows, false).unbind(),
            mean_speeds_mps: PyArray1::zeros(py, rows, false).unbind(),
            terminations: PyArray1::zeros(py, rows, false).unbind(),
            truncations: PyArray1::zeros(py, rows, false).unbind(),
            levels: configuration.config.advice.levels,
            batch,
        })
    }

    /// Returns the observations, float32, `(rows, inputs)`. Each step writes into this same array.
    #[getter]
    fn observations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.observations.bind(py).clone()
    }

    /// Returns the last observations of episodes that have just ended, float32, `(rows, inputs)`.
    #[getter]
    fn final_observations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.final_observations.bind(py).clone()
    }

    /// Returns the rewards of the last step, m/s, float64, `(rows,)`.
    #[getter]
    fn rewards<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.rewards.bind(py).clone()
    }

    /// Returns the mean speed of all vehicles of the ring over the last step, m/s, float64, `(rows,)`.
    #[getter]
    fn mean_speeds_mps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.mean_speeds_mps.bind(py).clone()
    }

    /// Returns true for rows of rings with a collision, bool, `(rows,)`.
    #[getter]
    fn terminations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.terminations.bind(py).clone()
    }

    /// Returns true for rows of rings that have reached the horizon, bool, `(rows,)`.
    #[getter]
    fn truncations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.truncations.bind(py).clone()
    }

    /// Begins the episodes of this seed from the first one.
    fn reset(&mut self, py: Python<'_>, seed: u64) -> PyResult<()> {
        let (batch, signals) = (&mut self.batch, Signals::new());
        threads::here(py, || batch.reset(seed, &signals))??;
        signals.raised()?;
        self.look(py)
    }

    /// Begins the next episode of the rings with a row that `mask` marks, bool, `(rows,)`.
    fn begin(&mut self, py: Python<'_>, mask: PyReadonlyArray1<'_, bool>) -> PyResult<()> {
        self.check_begun()?;
        let wanted = mask.as_slice()?.to_vec();
        self.check_length(wanted.len(), "mask")?;
        let (batch, signals) = (&mut self.batch, Signals::new());
        let advised = batch.advised;
        let is_wanted = |ring: usize| wanted[ring * advised..(ring + 1) * advised].contains(&true);
        threads::here(py, || batch.begin(is_wanted, &signals))??;
        signals.raised()?;
        self.look(py)
    }

    /// Returns places along the rings, m, and speeds, m/s, of all vehicles, float64, `(2, num_envs, most)`, the ego first, then backwards;
    /// NaN where a ring has fewer. `has_ended`: at the end of each ring's last episode, else now.
    fn vehicles<'py>(&self, py: Python<'py>, has_ended: bool) -> PyResult<Bound<'py, PyArray3<f64>>> {
        self.check_begun()?;
        let most = self.batch.config.ring.vehicles_max as usize;
        PyArray1::from_vec(py, self.batch.vehicles(has_ended)).reshape([2, self.batch.rings, most])
    }

    /// Returns the lengths of the rings, m, float64, `(num_envs,)`; `has_ended`: of their last episodes, else now.
    fn circumferences_m<'py>(&self, py: Python<'py>, has_ended: bool) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.check_begun()?;
        let length_m = |ring: usize| {
            let (block, l) = (&self.batch.blocks[ring / LANES], ring % LANES);
            if has_ended { block.ended().circumference_m(l) } else { block.circumference_m(l) }
        };
        Ok(PyArray1::from_iter(py, (0..self.batch.rings).map(length_m)))
    }

    /// Returns the times since the episodes began, s, float64, `(num_envs,)`.
    fn times_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.check_begun()?;
        let time_s = |ring: usize| self.batch.blocks[ring / LANES].time_s(ring % LANES);
        Ok(PyArray1::from_iter(py, (0..self.batch.rings).map(time_s)))
    }

    /// Returns the state of all rings as text, from which `set_state` goes on with the same bits.
    fn state(&self, py: Python<'_>) -> PyResult<String> {
        self.check_begun()?;
        let blocks = &self.batch.blocks;
        threads::here(py, || serde_json::to_string(blocks))?.map_err(|why| PyRuntimeError::new_err(why.to_string()))
    }

    /// Sets the state of all rings, which has the same settings and number of rings.
    fn set_state(&mut self, py: Python<'_>, state: &str) -> PyResult<()> {
        let read = threads::here(py, || serde_json::from_str::<Vec<VecEnv>>(state))?;
        let blocks = read.map_err(|why| PyValueError::new_err(format!("this is no state of rings: {why}")))?;
        let wanted = self.batch.rings.div_ceil(LANES);
        if blocks.len() != wanted {
            let text = format!("the state has {} blocks of {LANES} rings; allowed: {wanted}", blocks.len());
            return Err(PyValueError::new_err(text));
        }
        self.batch.blocks = blocks;
        self.look(py)
    }

    /// Drives one hold of all rings under these actions, float32, `(rows,)`. Returns true if an episode ended.
    fn step(&mut self, py: Python<'_>, actions: PyReadonlyArray1<'_, f32>) -> PyResult<bool> {
        self.check_begun()?;
        let actions = actions.as_slice()?;
        self.check_length(actions.len(), "actions")?;
        self.check_actions(actions)?;
        let out = StepBuffers {
            observations: slice(self.observations.bind(py))?,
            final_observations: slice(self.final_observations.bind(py))?,
            rewards: slice(self.rewards.bind(py))?,
            mean_speeds_mps: slice(self.mean_speeds_mps.bind(py))?,
            terminations: slice(self.terminations.bind(py))?,
            truncations: slice(self.truncations.bind(py))?,
        };
        let rows = self.batch.rows();
        let numbers = rows * self.batch.inputs();
        let lengths = [out.observations.len(), out.final_observations.len(), out.rewards.len() * self.batch.inputs()];
        let marks = [out.mean_speeds_mps.len(), out.terminations.len(), out.truncations.len()];
        if lengths != [numbers; 3] || marks != [rows; 3] {
            return Err(PyValueError::new_err(
                "an array of the environment has been resized; make the environment again",
            ));
        }
        let (batch, signals) = (&mut self.batch, Signals::new());
        let work = || {
            let StepBuffers { observations, final_observations, rewards, mean_speeds_mps, terminations, truncations } =
                out;
            let out = StepBuffers {
                observations,
                final_observations,
                rewards,
                mean_speeds_mps,
                terminations: &mut *terminations,
                truncations: &mut *truncations,
            };
            batch.step(actions, out, &signals)?;
            Ok::<_, PyErr>(terminations.iter().zip(&*truncations).any(|(crash, horizon)| *crash || *horizon))
        };
        let has_ended = threads::here(py, work)??;
        signals.raised()?;
        Ok(has_ended)
    }
}

impl Rings {
    fn look(&mut self, py: Python<'_>) -> PyResult<()> {
        let observations = slice(self.observations.bind(py))?;
        let batch = &self.batch;
        threads::on_all_cores(py, || batch.observe(observations))
    }

    fn check_begun(&self) -> PyResult<()> {
        if self.batch.blocks.is_empty() {
            Err(PyRuntimeError::new_err("no episode has begun: reset first"))
        } else {
            Ok(())
        }
    }

    fn check_length(&self, length: usize, what: &str) -> PyResult<()> {
        let rows = self.batch.rows();
        if length == rows {
            return Ok(());
        }
        Err(PyValueError::new_err(format!("{what} has {length} entries; allowed: {rows}, one for each environment")))
    }

    /// Checks that actions are finite numbers, or numbers of levels.
    fn check_actions(&self, actions: &[f32]) -> PyResult<()> {
        let levels = self.levels;
        let is_action = |action: &f32| match levels {
            0 => action.is_finite(),
            levels => action.fract() == 0.0 && (0.0..levels as f32).contains(action),
        };
        let Some(at) = actions.iter().position(|action| !is_action(action)) else { return Ok(()) };
        let allowed = if levels == 0 {
            "a finite number; -1 to 1 spans the limits".into()
        } else {
            format!("0 to {}", levels - 1)
        };
        Err(PyValueError::new_err(format!("the action of environment {at} is {}; allowed: {allowed}", actions[at])))
    }
}

/// Returns the memory of an array that this module made and keeps.
#[expect(
    clippy::mut_from_ref,
    reason = "numpy's arrays are shared with Python; what one is to hold is written while `Rings` is borrowed"
)]
fn slice<'a, T: numpy::Element, D: numpy::ndarray::Dimension>(
    array: &'a Bound<'_, numpy::PyArray<T, D>>,
) -> PyResult<&'a mut [T]> {
    if !array.is_contiguous() {
        return Err(PyValueError::new_err("an array of the environment has been reshaped; make the environment again"));
    }
    // SAFETY: the memory is numpy's and lives as long as `array`. Rust writes it only through `Rings`, which is borrowed mutably. Python
    // may read or write it meanwhile from another thread and get numbers of either step. Any bits are a valid `T`; for bool, numpy writes
    // only 0 and 1.
    unsafe { array.as_slice_mut() }.map_err(|e| PyValueError::new_err(e.to_string()))
}
