//! What stands in the place of `onnx` in a program that is built without the feature `onnx`. In: a file of another's network.
//! Out: a refusal that names the remedy.

use super::{Action, Observation, Policy, PolicyFileError, PolicyFileFault, RoadKind};
use std::path::{Path, PathBuf};

/// Limits of files that are read.
pub mod limits {
    /// Limits in words, for help texts.
    pub const IN_WORDS: &str = "this program was built without ONNX files (the cargo feature `onnx`)";
}

/// A network of any origin: there is none.
#[derive(Clone)]
pub enum OnnxPolicy {}

impl OnnxPolicy {
    /// Refuses the file.
    ///
    /// # Errors
    /// Always.
    pub fn from_file(path: &Path) -> Result<Self, PolicyFileError> {
        Err(PolicyFileError { path: path.display().to_string(), fault: PolicyFileFault::WithoutOnnx.into() })
    }

    /// A policy that is asked each `step_s` seconds, engaged now.
    pub fn engaged(&self, _step_s: f64) -> Box<dyn Policy> {
        match *self {}
    }

    /// Why it cannot advise on this kind of road.
    pub fn lacks(&self, _road: RoadKind) -> Option<String> {
        match *self {}
    }

    /// The files that make it.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        vec![path.to_owned()]
    }
}

impl Policy for OnnxPolicy {
    fn act(&mut self, _: f64, _: &Observation) -> Action {
        match *self {}
    }
}
