//! Networks of Python as policy files. In: layers, and the settings of the rings that they were trained on. Out: an ONNX file or one in
//! codrive's own format, or the description of a file that others write.

use crate::configuration::Configuration;
use codrive::{
    policy::{
        NetworkLayer, OnnxPolicy,
        onnx::{self, PolicyLayer, RecurrentKind, RecurrentLayer},
    },
    private,
    train::network_of,
};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::path::Path;

/// Kind of a layer, its weights, one row per input, its biases, and the same of its state; these are empty in dense layers.
type GivenLayer = (String, Vec<Vec<f32>>, Vec<f32>, Vec<Vec<f32>>, Vec<f32>);

/// Writes layers; the ending of the name selects the format.
#[pyfunction]
pub fn write_network(path: &str, configuration: &Configuration, layers: Vec<GivenLayer>) -> PyResult<()> {
    let layers = layers.into_iter().enumerate().map(layer).collect::<PyResult<Vec<_>>>()?;
    let dense: Option<Vec<NetworkLayer>> = layers.iter().map(dense).collect();
    let mut network = network_of(&configuration.config, dense.clone().unwrap_or_default());
    network.corrected = configuration.corrected.clone();
    let path = Path::new(path);
    let bytes = match (path.extension().and_then(|ending| ending.to_str()), dense) {
        (Some("onnx"), None) => {
            let bytes = onnx::write_layers(&network, &layers);
            // The reader has all checks of a network with states.
            OnnxPolicy::from_bytes(&bytes, None).map_err(|why| refused(format!("{}: {why}", path.display())))?;
            bytes
        }
        (Some("toml"), None) => {
            return Err(refused(format!(
                "{}: codrive's own format has no recurrent layers; allowed for these: a name that ends in .onnx",
                path.display()
            )));
        }
        (Some(ending @ ("onnx" | "toml")), Some(_)) => {
            network.check().map_err(refused)?;
            if ending == "onnx" { onnx::write(&network) } else { network.to_toml().into_bytes() }
        }
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

fn dense(layer: &PolicyLayer) -> Option<NetworkLayer> {
    match layer {
        PolicyLayer::Dense(layer) => Some(layer.clone()),
        PolicyLayer::Recurrent(_) => None,
    }
}

/// Returns a layer, of which the index is known for messages.
fn layer((index, (kind, weights, bias, state_weights, state_bias)): (usize, GivenLayer)) -> PyResult<PolicyLayer> {
    let input = NetworkLayer { bias, weights };
    let kind = match kind.as_str() {
        "dense" => return Ok(PolicyLayer::Dense(input)),
        "lstm" => RecurrentKind::Lstm,
        "gru" => RecurrentKind::Gru,
        other => return Err(refused(format!("layer {index} is of kind {other:?}; allowed: dense, lstm, gru"))),
    };
    let state = NetworkLayer { bias: state_bias, weights: state_weights };
    let layer = RecurrentLayer { kind, input, state };
    layer.check(index).map_err(refused)?;
    Ok(PolicyLayer::Recurrent(layer))
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
