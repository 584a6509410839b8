//! A trained network as an ONNX file with operator set 17. In: a [`Network`]. Out: the file's bytes. The file maps rows of scaled
//! observations to rows of raw outputs, with any number of rows; its metadata holds everything needed to use it.

use super::{METADATA_KEY, NetworkDescription, OutputMeaning, PolicyLayer};
use crate::policy::{Network, NetworkLayer};
use prost::Message;
use std::collections::BTreeMap;
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, OperatorSetIdProto, StringStringEntryProto, TensorProto,
    TensorShapeProto, TypeProto, ValueInfoProto,
    attribute_proto::AttributeType,
    tensor_proto::DataType,
    tensor_shape_proto::{Dimension, dimension},
    type_proto,
};

/// Gemm, Tanh and Constant have been unchanged since operator set 13, and every runtime in use reads 17.
const OPERATOR_SET: i64 = 17;
const IR_VERSION: i64 = 8;

/// Names of the input and the output tensor.
const INPUT: &str = "observation";
const OUTPUT: &str = "action";

/// Returns the ONNX file of a network as bytes.
pub fn write(network: &Network) -> Vec<u8> {
    let layers: Vec<PolicyLayer> = network.layers.iter().cloned().map(PolicyLayer::Dense).collect();
    write_layers(network, &layers)
}

/// Returns the ONNX file of these layers as bytes; `network` says what their numbers mean. Recurrent layers have their states as inputs
/// and outputs of the file, and no tanh follows them.
///
/// # Panics
/// There is no layer, or a recurrent layer is inconsistent ([`RecurrentLayer::check`](super::RecurrentLayer::check)).
pub fn write_layers(network: &Network, layers: &[PolicyLayer]) -> Vec<u8> {
    let mut graph = GraphProto { name: "policy".into(), ..GraphProto::default() };
    let last = layers.len() - 1;
    graph.input.push(rows_of(INPUT, network.inputs.len()));
    graph.output.push(rows_of(OUTPUT, layers[last].outputs()));
    let mut before = INPUT.to_owned();
    for (i, layer) in layers.iter().enumerate() {
        before = match layer {
            PolicyLayer::Dense(layer) => dense(&mut graph, layer, &before, i, i == last),
            PolicyLayer::Recurrent(layer) => layer.append(&mut graph, &before, i),
        };
    }
    if before != OUTPUT {
        graph.node.push(node("Identity", &[&before], OUTPUT));
    }
    file(graph, describe(network))
}

/// Appends the nodes of a dense layer, y = x W + b; returns the name of its output.
fn dense(graph: &mut GraphProto, layer: &NetworkLayer, before: &str, i: usize, is_last: bool) -> String {
    let (weights, bias) = (format!("weights{i}"), format!("bias{i}"));
    let (rows, columns) = (layer.weights.len() as i64, layer.bias.len() as i64);
    graph.initializer.push(tensor(&weights, &[rows, columns], layer.weights.concat()));
    graph.initializer.push(tensor(&bias, &[columns], layer.bias.clone()));
    let sum = if is_last { OUTPUT.to_owned() } else { format!("sum{i}") };
    graph.node.push(node("Gemm", &[before, &weights, &bias], &sum));
    if is_last {
        return sum;
    }
    let bent = format!("hidden{i}");
    graph.node.push(node("Tanh", &[&sum], &bent));
    bent
}

/// Returns the description of a network: the text of `NAME.onnx.toml`, which accompanies files of other programs.
pub fn describe(network: &Network) -> String {
    toml::to_string(&description(network)).unwrap_or_default()
}

/// Returns the ONNX file of a graph with a description in its metadata.
pub(super) fn file(graph: GraphProto, description: String) -> Vec<u8> {
    let model = ModelProto {
        ir_version: IR_VERSION,
        opset_import: vec![OperatorSetIdProto { domain: String::new(), version: OPERATOR_SET }],
        producer_name: "codrive".into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        graph: Some(graph),
        metadata_props: vec![StringStringEntryProto { key: METADATA_KEY.into(), value: description }],
        ..ModelProto::default()
    };
    model.encode_to_vec()
}

fn description(network: &Network) -> NetworkDescription {
    NetworkDescription {
        fixed: BTreeMap::new(),
        initial_state: BTreeMap::new(),
        action: network.action,
        limits: network.limits,
        speed_change_mps: network.speed_change_mps,
        least_spacing_m: network.least_spacing_m,
        holds_s: network.holds_s,
        advised_share: network.advised_share,
        output: if network.levels == 0 { OutputMeaning::Scaled } else { OutputMeaning::Levels },
        element: None,
        input_name: Some(INPUT.into()),
        output_name: Some(OUTPUT.into()),
        inputs: network.inputs.clone(),
        corrected: network.corrected.clone(),
        probe: network.probe,
        expected_gain: network.expected_gain.clone(),
    }
}

pub(super) fn node(kind: &str, inputs: &[&str], output: &str) -> NodeProto {
    let attribute = |name: &str, value: f32| AttributeProto {
        name: name.into(),
        r#type: AttributeType::Float.into(),
        f: value,
        ..AttributeProto::default()
    };
    NodeProto {
        input: inputs.iter().map(|name| (*name).into()).collect(),
        output: vec![output.into()],
        name: format!("{kind}/{output}"),
        op_type: kind.into(),
        attribute: if kind == "Gemm" { vec![attribute("alpha", 1.0), attribute("beta", 1.0)] } else { Vec::new() },
        ..NodeProto::default()
    }
}

pub(super) fn tensor(name: &str, dims: &[i64], numbers: Vec<f32>) -> TensorProto {
    TensorProto {
        name: name.into(),
        dims: dims.to_vec(),
        data_type: DataType::Float.into(),
        raw_data: numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ..TensorProto::default()
    }
}

/// Returns a tensor type with `columns` columns and any number of rows.
pub(super) fn rows_of(name: &str, columns: usize) -> ValueInfoProto {
    let dimension = |value| Dimension { value: Some(value), ..Dimension::default() };
    let shape = TensorShapeProto {
        dim: vec![
            dimension(dimension::Value::DimParam("batch".into())),
            dimension(dimension::Value::DimValue(columns as i64)),
        ],
    };
    let tensor = type_proto::Tensor { elem_type: DataType::Float.into(), shape: Some(shape) };
    let kind = TypeProto { value: Some(type_proto::Value::TensorType(tensor)), ..TypeProto::default() };
    ValueInfoProto { name: name.into(), r#type: Some(kind), ..ValueInfoProto::default() }
}
