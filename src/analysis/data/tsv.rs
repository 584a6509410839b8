//! Tab-separated tables of a BIDS data set. In: a file. Out: its rows, and its columns by name.

use crate::analysis::error::AnalysisError;
use crate::{
    file::{SETTINGS_BYTES, read_text},
    toml_text::did_you_mean,
};
use std::{
    io::ErrorKind,
    path::{Path, PathBuf},
};

/// Mark of a missing value in BIDS.
pub(super) const MISSING: &str = "n/a";

/// A tab-separated table of a BIDS data set.
pub(super) struct TsvFile {
    path: PathBuf,
    pub names: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl TsvFile {
    /// Reads a table; `None` if there is no such file.
    pub fn read(path: &Path) -> Result<Option<Self>, AnalysisError> {
        let Some(text) = read_if_there(path)? else { return Ok(None) };
        let mut lines = text.lines().map(|line| line.split('\t').map(str::to_owned).collect::<Vec<_>>());
        let names = lines.next().unwrap_or_default();
        let rows: Vec<Vec<String>> = lines.collect();
        if let Some(i) = rows.iter().position(|row| row.len() != names.len()) {
            return Err(AnalysisError::Input(format!(
                "{}: line {} has {} cells instead of {}",
                path.display(),
                i + 2,
                rows[i].len(),
                names.len()
            )));
        }
        Ok(Some(Self { path: path.into(), names, rows }))
    }

    pub fn column(&self, name: &str) -> Result<usize, AnalysisError> {
        let fault = || {
            AnalysisError::Input({
                let near = did_you_mean(name, &self.names);
                format!("{}: there is no column \"{name}\"{near}", self.path.display())
            })
        };
        self.names.iter().position(|n| n == name).ok_or_else(fault)
    }

    /// Returns the names of the conditions in the order of the table's sidecar; none if it does not list them.
    pub fn conditions(&self) -> Result<Vec<String>, AnalysisError> {
        let sidecar = self.sidecar()?;
        let levels = sidecar["condition"]["Levels"].as_object();
        Ok(levels.map(|levels| levels.keys().cloned().collect()).unwrap_or_default())
    }

    /// Returns the description of the questionnaire in the table's sidecar; empty if there is none.
    pub fn questionnaire(&self) -> Result<String, AnalysisError> {
        let sidecar = self.sidecar()?;
        Ok(sidecar["MeasurementToolMetadata"]["Description"].as_str().unwrap_or_default().to_owned())
    }

    /// Returns the table's sidecar; null if there is none.
    fn sidecar(&self) -> Result<serde_json::Value, AnalysisError> {
        let sidecar = self.path.with_extension("json");
        let Some(text) = read_if_there(&sidecar)? else { return Ok(serde_json::Value::Null) };
        serde_json::from_str(&text)
            .map_err(|why| AnalysisError::Input(format!("{}: is not JSON: {why}", sidecar.display())))
    }
}

/// Returns the text of a file; `None` if there is no such file.
fn read_if_there(path: &Path) -> Result<Option<String>, AnalysisError> {
    match read_text(path, SETTINGS_BYTES) {
        Ok(text) => Ok(Some(text)),
        Err(why) if why.kind() == ErrorKind::NotFound => Ok(None),
        Err(why) => Err(AnalysisError::Input(format!("{}: cannot be read: {why}", path.display()))),
    }
}
