//! A driver estimator as an ONNX file. In: the samples of one second and the previous state, for any number of drivers. Out: the readout
//! and the next state. The caller feeds the state back in the next second and starts with zeros.

use super::write::{file, node, rows_of, tensor};
use crate::policy::{
    DriverEstimator,
    identification::{GATES, SAMPLE_S, SAMPLES},
};
use serde::Serialize;
use tract_onnx::pb::GraphProto;

/// Names of the inputs and outputs.
const SECOND: &str = "second";
const STATE: &str = "state";
const NEXT: &str = "next_state";
const READ: &str = "traits";

/// Meaning of the numbers, stored in the file's metadata.
#[derive(Serialize)]
struct Description<'a> {
    /// Time between two samples, s.
    sample_s: f64,
    /// Number of samples per second.
    samples: usize,
    /// Quantities in one sample, each about -1 to 1.
    sample: [&'static str; 4],
    /// Meaning of the last input, after the samples.
    last: &'static str,
    /// Traits or latents in the readout: first the means, then the logarithms of standard deviations, both in units of the spread.
    traits: &'a [crate::policy::identification::EstimatedTrait],
}

/// Returns the ONNX file of an estimator as bytes.
pub fn write_estimator(estimator: &DriverEstimator) -> Vec<u8> {
    let mut graph = GraphProto { name: "driver".into(), ..GraphProto::default() };
    let units = estimator.units();
    let product = |graph: &mut GraphProto, from: &str, rows: &[Vec<f32>], bias: &[f32], output: &str| {
        let (weights, biases) = (format!("{output}/weights"), format!("{output}/bias"));
        graph.initializer.push(tensor(&weights, &[rows.len() as i64, bias.len() as i64], rows.concat()));
        graph.initializer.push(tensor(&biases, &[bias.len() as i64], bias.to_vec()));
        graph.node.push(node("Gemm", &[from, &weights, &biases], output));
    };
    // One product per gate, so that no result has to be split.
    for (gate, name) in ["reset", "update", "candidate"].into_iter().enumerate().take(GATES) {
        let part = |rows: &[Vec<f32>]| rows.iter().map(|row| row[gate * units..][..units].to_vec()).collect::<Vec<_>>();
        let bias = |all: &[f32]| all[gate * units..][..units].to_vec();
        let from = |what: &str| format!("{name} by {what}");
        product(&mut graph, SECOND, &part(&estimator.weights), &bias(&estimator.bias), &from(SECOND));
        product(&mut graph, STATE, &part(&estimator.state_weights), &bias(&estimator.state_bias), &from(STATE));
    }
    for gate in ["reset", "update"] {
        let sum = format!("{gate} sum");
        graph.node.push(node("Add", &[&format!("{gate} by {SECOND}"), &format!("{gate} by {STATE}")], &sum));
        graph.node.push(node("Sigmoid", &[&sum], gate));
    }
    for (kind, inputs, output) in
        [("Mul", ["reset", "candidate by state"], "kept"), ("Add", ["candidate by second", "kept"], "candidate sum")]
    {
        graph.node.push(node(kind, &inputs, output));
    }
    graph.node.push(node("Tanh", &["candidate sum"], "candidate"));
    // (1 - z) n + z h = n + z (h - n).
    for (kind, inputs, output) in [
        ("Sub", [STATE, "candidate"], "difference"),
        ("Mul", ["update", "difference"], "step"),
        ("Add", ["candidate", "step"], NEXT),
    ] {
        graph.node.push(node(kind, &inputs, output));
    }
    product(&mut graph, NEXT, &estimator.readout.weights, &estimator.readout.bias, READ);
    graph.input = vec![rows_of(SECOND, estimator.inputs()), rows_of(STATE, units)];
    graph.output = vec![rows_of(READ, estimator.outputs()), rows_of(NEXT, units)];
    let description = Description {
        sample_s: SAMPLE_S,
        samples: SAMPLES,
        sample: [
            "(advised - own speed) / 2 m/s, 0 without advice",
            "own speed / 5 m/s - 1",
            "(leader's - own speed) / 2 m/s",
            "gap / 20 m - 1, at most 4",
        ],
        last: "1 where an advice stands, else 0",
        traits: &estimator.traits,
    };
    file(graph, toml::to_string(&description).unwrap_or_default())
}
