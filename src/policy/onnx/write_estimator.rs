//! An estimator of the driver as an ONNX file: the samples of a second and the state before in, the state after and what is
//! read from it out, any number of drivers at once. Whoever runs it hands the state back in the next second, and begins with 0.

use super::write::{file, node, rows_of, tensor};
use crate::policy::{
    DriverEstimator,
    identification::{GATES, INPUTS, SAMPLE_S, SAMPLES},
};
use serde::Serialize;
use tract_onnx::pb::GraphProto;

/// Names of the inputs and outputs.
const SECOND: &str = "second";
const STATE: &str = "state";
const NEXT: &str = "next_state";
const READ: &str = "traits";

/// What the numbers mean, in the file's metadata.
#[derive(Serialize)]
struct Description<'a> {
    /// Time between two samples, s.
    sample_s: f64,
    /// Samples in a second.
    samples: usize,
    /// The numbers of one sample, each -1 to 1 or so.
    sample: [&'static str; 4],
    /// What follows the samples.
    last: &'static str,
    /// The readout: first the mean of each trait or latent, then the logarithm of its standard deviation, both in units of its spread.
    traits: &'a [crate::policy::identification::EstimatedTrait],
}

/// The file's bytes.
pub fn write_estimator(estimator: &DriverEstimator) -> Vec<u8> {
    let mut graph = GraphProto { name: "driver".into(), ..GraphProto::default() };
    let units = estimator.units();
    let product = |graph: &mut GraphProto, from: &str, rows: &[Vec<f32>], bias: &[f32], output: &str| {
        let (weights, biases) = (format!("{output}/weights"), format!("{output}/bias"));
        graph.initializer.push(tensor(&weights, &[rows.len() as i64, bias.len() as i64], rows.concat()));
        graph.initializer.push(tensor(&biases, &[bias.len() as i64], bias.to_vec()));
        graph.node.push(node("Gemm", &[from, &weights, &biases], output));
    };
    // A product for each gate: nothing has to be cut in parts then.
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
    graph.input = vec![rows_of(SECOND, INPUTS), rows_of(STATE, units)];
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
