//! Recordings and data sets for Python. In: a folder. Out: its drives, the settings and the figure of each, and the measures of all.

use crate::threads;
use codrive::{
    analysis::{self, AnalysisError, FolderContents, FoundRecording, tables},
    record::{self, inputs},
};
use pyo3::{
    exceptions::{PyFileNotFoundError, PyValueError},
    prelude::*,
};
use std::path::{Path, PathBuf};

/// Participant, segment, place, condition and levels of factors of a drive, its folder, and the folder of the same drive without advice.
type FoundDrive = (String, String, String, String, Vec<(String, String)>, PathBuf, Option<PathBuf>);

/// Returns the contents of a folder: its title, true if it is a data set or a participant of one, and its drives.
#[pyfunction]
pub fn find_drives(py: Python<'_>, folder: PathBuf) -> PyResult<(String, bool, Vec<FoundDrive>)> {
    let contents = found(py, &folder)?;
    let drives = contents.found.into_iter().map(|drive| {
        let FoundRecording { participant, segment, place, condition, levels, recording, baseline, .. } = drive;
        (participant, segment, place, condition, levels, recording, baseline)
    });
    Ok((contents.title, contents.root.is_some(), drives.collect()))
}

/// Returns the settings of a recorded drive as JSON.
#[pyfunction]
pub fn recorded_settings(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    let read = || {
        record::open(&folder).map_err(|e| PyValueError::new_err(e.to_string()))?;
        let scenario = inputs::scenario(&folder).map_err(|e| PyValueError::new_err(e.message))?;
        serde_json::to_string(&scenario).map_err(|e| PyValueError::new_err(e.to_string()))
    };
    threads::here(py, read)?
}

/// Returns the positions of all vehicles over time, as SVG; `None` if there is too little to draw.
#[pyfunction]
pub fn space_time(py: Python<'_>, folder: PathBuf) -> PyResult<Option<String>> {
    threads::here(py, || analysis::space_time(&folder))?.map_err(refused)
}

/// Returns the measures of each drive of a folder as CSV with a header: `trials.csv` of `codrive analyse`.
#[pyfunction]
pub fn measures(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    let contents = found(py, &folder)?;
    let drives = threads::on_all_cores(py, || analysis::analyse(&contents.found, &[], &|| ()))?.map_err(refused)?;
    Ok(tables::trials(&drives))
}

fn found(py: Python<'_>, folder: &Path) -> PyResult<FolderContents> {
    if !folder.is_dir() {
        return Err(PyFileNotFoundError::new_err(format!("there is no folder {}", folder.display())));
    }
    threads::here(py, || analysis::find(folder))?.map_err(refused)
}

fn refused(why: AnalysisError) -> PyErr {
    PyValueError::new_err(why.to_string())
}
