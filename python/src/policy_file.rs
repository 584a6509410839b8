//! Networks of Python as policy files. In: layers, and the settings of the rings that they were trained on. Out: an ONNX file or one in
//! codrive's own format, or the description of a file that others write.

use crate::configuration::Configuration;
use codrive::{
    policy::{NetworkLayer, onnx},
    private,
    train::network_of,
};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::path::Path;

/// Writes layers of weights, one row per input, and biases; the ending of the name selects the format.
#[pyfunction]
pub fn write_network(
    path: &str,
    configuration: &Configuration,
    layers: Vec<(Vec<Vec<f32>>, Vec<f32>)>,
) -> PyResult<()> {
    let layers = layers.into_iter().map(|(weights, bias)| NetworkLayer { bias, weights }).collect();
    let mut network = network_of(&configuration.config, layers);
    network.corrected = configuration.corrected.clone();
    network.check().map_err(refused)?;
    let path = Path::new(path);
    let bytes = match path.extension().and_then(|ending| ending.to_str()) {
        Some("onnx") => onnx::write(&network),
        Some("toml") => network.to_toml().into_bytes(),
        _ => {
            return Err(refused(format!(
                "{}: the format is unknown; allowed: a name that ends in .onnx or .toml",
                path.display()
            )));
        }
    };
    private::replace(path, &bytes)
        .map_err(|fault| PyErr::from(std::io::Error::new(fault.kind(), format!("{}: {fault}", path.display()))))
}

/// Returns the description of a network that was trained with these settings, as in `NAME.onnx.toml`.
#[pyfunction]
pub fn network_description(configuration: &Configuration) -> String {
    let mut network = network_of(&configuration.config, Vec::new());
    network.corrected = configuration.corrected.clone();
    onnx::describe(&network)
}

fn refused(why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}
