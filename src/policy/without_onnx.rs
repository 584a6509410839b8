//! Replacement for `onnx` in a program built without the feature `onnx`. In: an ONNX file. Out: an error that names the remedy.

use super::{Action, Observation, Policy, PolicyFileError, PolicyFileFault, RoadKind};
use std::path::{Path, PathBuf};

/// Limits of ONNX files.
pub mod limits {
    /// Limits in words for help texts.
    pub const IN_WORDS: &str = "this program was built without the cargo feature `onnx`, which reads ONNX files";
}

/// An ONNX network; without the feature there are no values of this type.
#[derive(Clone)]
pub enum OnnxPolicy {}

impl OnnxPolicy {
    /// Refuses the file.
    ///
    /// # Errors
    /// Always returns an error.
    pub fn from_file(path: &Path) -> Result<Self, PolicyFileError> {
        Err(PolicyFileError { path: path.display().to_string(), fault: PolicyFileFault::WithoutOnnx.into() })
    }

    /// Returns a newly engaged policy; never called, as there is no value.
    pub fn engaged(&self, _step_s: f64) -> Box<dyn Policy> {
        match *self {}
    }

    /// Returns the reason that the policy cannot advise on this kind of road; never called, as there is no value.
    pub fn lacks(&self, _road: RoadKind) -> Option<String> {
        match *self {}
    }

    /// Returns the files of the policy: only the network itself.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        vec![path.to_owned()]
    }
}

impl Policy for OnnxPolicy {
    fn act(&mut self, _: f64, _: &Observation) -> Action {
        match *self {}
    }
}
