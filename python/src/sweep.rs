//! Sweeps for Python: the runs of a plan, each as bytes. In: a plan's file. Out: names of parts, and parts.

use crate::threads::here;
use codrive::sweep::{
    NoCheckpoint, RunCheckpoint, SweepError, SweepPlan,
    results::SweepFolder,
    supervisor::{self, FailedRun, WorkerFault},
};
use pyo3::{
    exceptions::{PyIndexError, PyRuntimeError, PyValueError},
    prelude::*,
    types::PyBytes,
};
use std::path::PathBuf;

/// Runs of a plan, in its order.
#[pyclass(frozen, module = "codrive_sim._codrive")]
pub struct Plan(SweepPlan);

#[pymethods]
impl Plan {
    /// Reads a plan and checks all its runs. Names of files are relative to the plan.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        here(py, || SweepPlan::read(&path))?.map(Self).map_err(raised)
    }

    /// Returns the number of runs.
    fn __len__(&self) -> usize {
        self.0.runs.len()
    }

    /// Returns the name of each run's part, which depends on the run and not on its place in the plan.
    fn part_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        here(py, || self.0.runs.iter().map(|run| run.part_name()).collect::<Result<_, _>>())?.map_err(raised)
    }

    /// Returns the name of one run's part, from the present files.
    fn part_name(&self, py: Python<'_>, number: usize) -> PyResult<String> {
        let run = self.run(number)?;
        here(py, || run.part_name())?.map_err(raised)
    }

    /// Returns the time limit of each run, s; `None` for no limit.
    fn limits_s(&self) -> Vec<Option<f64>> {
        self.0.runs.iter().map(|run| run.limit_s).collect()
    }

    /// Returns the report of failed runs, given as (number, reason).
    fn failure_report(&self, failed: Vec<(usize, String)>) -> PyResult<String> {
        failed.iter().try_for_each(|(number, _)| self.run(*number).map(drop))?;
        let failed: Vec<_> = failed.into_iter().map(|(number, why)| FailedRun { number, why }).collect();
        Ok(supervisor::failure_report(&self.0, &failed))
    }

    /// Returns the reason of the failure of a run that exceeded its limit, s.
    #[staticmethod]
    fn timed_out(limit_s: f64) -> String {
        WorkerFault::TimedOut(limit_s).to_string()
    }

    /// Returns the reason of the failure of a run whose process ended with this status.
    #[staticmethod]
    fn process_ended(status: String) -> String {
        WorkerFault::Ended(status).to_string()
    }

    /// Returns the message of a sweep that was stopped.
    #[staticmethod]
    fn stopped() -> &'static str {
        supervisor::STOPPED
    }

    /// Executes a run and returns its part, a Parquet file as bytes, which are the same on every machine. `checkpoint` keeps the state of a
    /// training while it runs, and the training continues from it: an object with `load() -> bytes | None`, `save(bytes)` and `report(str)`.
    #[pyo3(signature = (number, checkpoint = None))]
    fn execute<'py>(
        &self,
        py: Python<'py>,
        number: usize,
        checkpoint: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let run = self.run(number)?;
        let checkpoint = checkpoint.map(PythonCheckpoint);
        let part = here(py, || match &checkpoint {
            Some(checkpoint) => run.execute(checkpoint),
            None => run.execute(&NoCheckpoint),
        })?;
        Ok(PyBytes::new(py, &part.map_err(raised)?))
    }

    /// Joins the parts in the folder `root`/parts into one table per kind. Returns (file, runs, rows) of each.
    fn collect(&self, py: Python<'_>, root: PathBuf) -> PyResult<Vec<(PathBuf, usize, u64)>> {
        let collected = here(py, || SweepFolder::open(&root)?.collect(&self.0))?.map_err(raised)?;
        Ok(collected.into_iter().map(|table| (table.path, table.runs, table.rows)).collect())
    }
}

impl Plan {
    fn run(&self, number: usize) -> PyResult<&codrive::sweep::SweepRun> {
        let runs = self.0.runs.len();
        self.0
            .runs
            .get(number)
            .ok_or_else(|| PyIndexError::new_err(format!("run {number}; allowed: 0 to {}", runs - 1)))
    }
}

/// Checkpoint of a run in an object of Python.
struct PythonCheckpoint(Py<PyAny>);

impl RunCheckpoint for PythonCheckpoint {
    fn load(&self) -> Result<Option<Vec<u8>>, SweepError> {
        let loaded = Python::attach(|py| self.0.call_method0(py, "load")?.extract(py));
        loaded.map_err(|why: PyErr| SweepError::Run(why.to_string()))
    }

    fn save(&self, checkpoint: &[u8]) -> Result<(), SweepError> {
        let saved = Python::attach(|py| self.0.call_method1(py, "save", (PyBytes::new(py, checkpoint),)).map(drop));
        saved.map_err(|why| SweepError::Run(why.to_string()))
    }

    fn report(&self, text: &str) {
        Python::attach(|py| {
            if let Err(why) = self.0.call_method1(py, "report", (text,)) {
                why.write_unraisable(py, None);
            }
        });
    }
}

/// Converts an error of a sweep to a Python exception.
fn raised(error: SweepError) -> PyErr {
    match error {
        SweepError::Plan(text) => PyValueError::new_err(text),
        error => PyRuntimeError::new_err(error.to_string()),
    }
}
