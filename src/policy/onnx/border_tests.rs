//! ONNX networks of other programs: weights in other files, other number types, several inputs.

use super::{NetworkDescription, OnnxFault, OnnxPolicy, write};
use crate::{
    policy::{Action, CorrectedAdvice, FIELD_INPUTS, Network, NetworkLayer, Observation},
    rng,
};
use half::f16;
use prost::Message;
use std::{fs, path::Path};
use tract_onnx::pb::{
    GraphProto, ModelProto, NodeProto, StringStringEntryProto, TensorProto, TypeProto, ValueInfoProto,
    tensor_proto::DataType, tensor_shape_proto::dimension, type_proto,
};

/// Returns a small network with random weights.
fn network() -> Network {
    let mut stream = rng::stream(7, "border");
    let mut layer = |n: usize, m: usize| NetworkLayer {
        bias: (0..m).map(|_| 0.1 * stream.normal() as f32).collect(),
        weights: (0..n).map(|_| (0..m).map(|_| (stream.normal() / (n as f64).sqrt()) as f32).collect()).collect(),
    };
    let layers = vec![layer(4, 16), layer(16, 1)];
    Network { holds_s: [1.0, 1.0], ..Network::advising_speed(FIELD_INPUTS.to_vec(), layers) }
}

fn model() -> ModelProto {
    ModelProto::decode(write(&network()).as_slice()).unwrap()
}

/// Returns the model with `change` applied to its graph.
fn changed(change: impl FnOnce(&mut GraphProto)) -> ModelProto {
    let mut model = model();
    change(model.graph.as_mut().unwrap());
    model
}

fn loaded(model: &ModelProto, description: Option<&str>) -> Result<OnnxPolicy, OnnxFault> {
    OnnxPolicy::from_bytes(&model.encode_to_vec(), description)
}

fn refusal(model: &ModelProto, description: Option<&str>) -> String {
    loaded(model, description).err().unwrap().to_string()
}

/// Returns the description in the file's metadata, with `lines` before it and without the input's name.
fn described(lines: &str) -> String {
    let text = model().metadata_props[0].value.clone();
    let text: Vec<&str> = text.lines().filter(|line| !line.starts_with("input_name")).collect();
    format!("{lines}\n{}", text.join("\n"))
}

const SEEN: [f32; 4] = [0.3, -0.8, 0.9, -0.1];

fn answer(policy: &OnnxPolicy) -> f32 {
    policy.outputs(&SEEN).unwrap()[0]
}

fn expected() -> f32 {
    answer(&loaded(&model(), None).unwrap())
}

/// Moves the graph's weights into one file, as exporters do; returns the file's bytes.
fn move_weights(graph: &mut GraphProto, location: &str) -> Vec<u8> {
    let mut file = b"whatever stands before".to_vec();
    for tensor in &mut graph.initializer {
        let entry = |key: &str, value: String| StringStringEntryProto { key: key.into(), value };
        let bytes = std::mem::take(&mut tensor.raw_data);
        tensor.data_location = Some(1);
        tensor.external_data = vec![
            entry("location", location.into()),
            entry("offset", file.len().to_string()),
            entry("length", bytes.len().to_string()),
        ];
        file.extend(bytes);
    }
    file
}

/// Writes a network into `folder` with its weights at `location`; returns its path and the bytes of the weights.
fn export(folder: &Path, location: &str, change: impl FnOnce(&mut GraphProto)) -> (std::path::PathBuf, Vec<u8>) {
    let mut weights = Vec::new();
    let model = changed(|graph| {
        weights = move_weights(graph, location);
        change(graph);
    });
    let path = folder.join("policy.onnx");
    fs::write(&path, model.encode_to_vec()).unwrap();
    (path, weights)
}

#[test]
fn weights_beside_the_file_are_read_and_belong_to_it() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("policy");
    fs::create_dir(&folder).unwrap();
    let (path, weights) = export(&folder, "policy.onnx.data", |_| ());
    fs::write(folder.join("policy.onnx.data"), &weights).unwrap();
    assert_eq!(answer(&OnnxPolicy::from_file(&path).unwrap()), expected());
    assert_eq!(OnnxPolicy::files(&path), [path.clone(), folder.join("policy.onnx.data")]);
    // Bytes without a path have no folder.
    let message = OnnxPolicy::from_bytes(&fs::read(&path).unwrap(), None).err().unwrap().to_string();
    assert!(message.contains("lie in another file"), "{message}");
}

#[test]
fn weights_elsewhere_or_of_other_sizes_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("policy");
    fs::create_dir(&folder).unwrap();
    let message = |location: &str, change: &dyn Fn(&mut TensorProto)| {
        let (path, weights) = export(&folder, location, |graph| change(&mut graph.initializer[0]));
        fs::write(folder.join("w"), &weights).unwrap();
        fs::write(dir.path().join("outside"), &weights).unwrap();
        OnnxPolicy::from_file(&path).err().map_or_else(String::new, |error| error.fault.to_string())
    };
    assert_eq!(message("w", &|_| ()), "");
    for location in ["../outside", &dir.path().join("outside").to_string_lossy(), "", "./../outside"] {
        let message = message(location, &|_| ());
        assert!(message.contains("allowed: a file in the folder of the network"), "{location}: {message}");
    }
    let absent = message("gone", &|_| ());
    assert!(
        absent.contains("weights `weights0` lie in `gone`, which cannot be read")
            && absent.contains("remedy: put it into"),
        "{absent}"
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../outside", folder.join("link")).unwrap();
        assert!(message("link", &|_| ()).contains("allowed: a file in the folder"), "a link out of the folder");
        std::os::unix::fs::symlink("w", folder.join("within")).unwrap();
        assert_eq!(message("within", &|_| ()), "");
    }
    let place = |key: &'static str, value: &'static str| {
        move |tensor: &mut TensorProto| {
            tensor
                .external_data
                .iter_mut()
                .filter(|entry| entry.key == key)
                .for_each(|entry| entry.value = value.into());
        }
    };
    assert!(message("w", &place("offset", "1000000")).contains("the file has "), "beyond its end");
    assert!(message("w", &place("offset", "-1")).contains("have the offset `-1`"));
    assert!(message("w", &place("length", "8")).contains("that is 256 bytes, but say 8"));
    assert!(message("w", &|tensor| tensor.dims = vec![1 << 40]).contains("allowed: at most"));
    assert!(message(".", &|_| ()).contains("folder"), "{}", message(".", &|_| ()));
}

/// Returns the model with weights, input and output of another number type.
fn in_kind(kind: DataType, bytes: impl Fn(f32) -> Vec<u8>) -> ModelProto {
    changed(|graph| {
        for tensor in &mut graph.initializer {
            let numbers = tensor.raw_data.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
            tensor.raw_data = numbers.flat_map(&bytes).collect();
            tensor.data_type = kind.into();
        }
        for value in graph.input.iter_mut().chain(&mut graph.output) {
            tensor_type(value).elem_type = kind.into();
        }
    })
}

fn tensor_type(value: &mut ValueInfoProto) -> &mut type_proto::Tensor {
    match value.r#type.as_mut().and_then(|kind| kind.value.as_mut()) {
        Some(type_proto::Value::TensorType(tensor)) => tensor,
        _ => panic!("a tensor"),
    }
}

#[test]
fn numbers_of_64_and_16_bits_are_converted_to_32_bits() {
    let double = loaded(&in_kind(DataType::Double, |x| f64::from(x).to_le_bytes().into()), None).unwrap();
    assert!((answer(&double) - expected()).abs() < 1e-6, "{} {}", answer(&double), expected());
    let half = loaded(&in_kind(DataType::Float16, |x| f16::from_f32(x).to_le_bytes().into()), None).unwrap();
    // A half-precision number has eleven binary digits.
    assert!((answer(&half) - expected()).abs() < 5e-3, "{} {}", answer(&half), expected());
    // A network of doubles that casts its input from single precision, as exporters of 64-bit networks write it.
    let mut casting = in_kind(DataType::Double, |x| f64::from(x).to_le_bytes().into());
    let graph = casting.graph.as_mut().unwrap();
    tensor_type(&mut graph.input[0]).elem_type = DataType::Float.into();
    graph.input[0].name = "seen".into();
    let to = tract_onnx::pb::AttributeProto { name: "to".into(), r#type: 2, i: 11, ..Default::default() };
    graph.node.insert(0, NodeProto { attribute: vec![to], ..node("Cast", &["seen"], "observation") });
    let cast = loaded(&casting, Some(&described(""))).unwrap();
    assert!((answer(&cast) - expected()).abs() < 1e-6);
    let whole = changed(|graph| tensor_type(&mut graph.input[0]).elem_type = DataType::Int64.into());
    let message = refusal(&whole, None);
    assert_eq!(message, "input `observation` is of INT64; allowed: floating-point numbers of 16, 32 or 64 bits");
    for (kind, bytes) in [(DataType::Double, f64::NAN.to_le_bytes().to_vec()), (DataType::Float16, vec![0xff, 0xff])] {
        let model = in_kind(kind, |_| bytes.clone());
        assert_eq!(refusal(&model, None), "weights `weights0` hold a NaN");
    }
}

fn value(name: &str, sizes: &[i64]) -> ValueInfoProto {
    let dim = |size: &i64| tract_onnx::pb::tensor_shape_proto::Dimension {
        value: Some(dimension::Value::DimValue(*size)),
        ..Default::default()
    };
    let shape = tract_onnx::pb::TensorShapeProto { dim: sizes.iter().map(dim).collect() };
    let tensor = type_proto::Tensor { elem_type: DataType::Float.into(), shape: Some(shape) };
    let kind = TypeProto { value: Some(type_proto::Value::TensorType(tensor)), ..TypeProto::default() };
    ValueInfoProto { name: name.into(), r#type: Some(kind), ..ValueInfoProto::default() }
}

fn node(kind: &str, inputs: &[&str], output: &str) -> NodeProto {
    NodeProto {
        input: inputs.iter().map(|name| (*name).to_owned()).collect(),
        output: vec![output.into()],
        op_type: kind.into(),
        ..NodeProto::default()
    }
}

/// Returns the model with three more inputs; the action is multiplied by each input in `used`.
fn with_inputs(used: &[&str]) -> ModelProto {
    changed(|graph| {
        graph.input.extend(["mask", "h", "c"].map(|name| value(name, &[1, 1])));
        let action = std::mem::replace(&mut graph.node.last_mut().unwrap().output[0], "raw".into());
        let mut before = "raw".to_owned();
        for name in used {
            graph.node.push(node("Mul", &[&before, name], &format!("by_{name}")));
            before = format!("by_{name}");
        }
        graph.node.push(node("Identity", &[&before], &action));
    })
}

#[test]
fn a_network_with_several_inputs_runs_with_the_description_it_asks_for() {
    let model = with_inputs(&["mask", "h"]);
    let message = refusal(&model, Some(&described("")));
    assert!(message.starts_with("has 4 inputs (observation, mask, h, c); a policy has one"), "{message}");
    // The remedy in the message, used as given.
    let remedy: String = message.lines().skip(2).map(|line| format!("{line}\n")).collect();
    assert_eq!(remedy, "  input_name = \"observation\"\n  fixed = { mask = 0.0, h = 0.0 }\n");
    assert_eq!(answer(&loaded(&model, Some(&described(&remedy))).unwrap()), 0.0);
    let twice = described("input_name = \"observation\"\nfixed = { mask = 2.0, h = 0.5 }");
    assert_eq!(answer(&loaded(&model, Some(&twice)).unwrap()), expected());
    let half = refusal(&model, Some(&described("input_name = \"observation\"\nfixed = { mask = 2.0 }")));
    assert!(half.contains("depends on (h)") && half.contains("fixed = { h = 0.0 }"), "{half}");
    let message = refusal(&model, Some(&described("fixed = { hh = 0.0 }")));
    assert_eq!(message, "has no input `hh` to fix; it has observation, mask, h, c");
    let message = refusal(&model, Some(&described("fixed = { h = nan }")));
    assert!(message.contains("`h` is fixed to NaN; allowed: a finite number"), "{message}");
}

#[test]
fn inputs_without_influence_on_the_action_are_ignored() {
    assert_eq!(answer(&loaded(&with_inputs(&[]), Some(&described(""))).unwrap()), expected());
}

#[test]
fn each_number_may_have_its_own_input() {
    let model = changed(|graph| {
        let axis = tract_onnx::pb::AttributeProto { name: "axis".into(), r#type: 2, i: 1, ..Default::default() };
        let join = NodeProto { attribute: vec![axis], ..node("Concat", &["v", "lead", "gap", "l"], "observation") };
        graph.input = ["v", "lead", "gap", "l"].map(|name| value(name, &[1, 1])).into();
        graph.node.insert(0, join);
    });
    let joined = answer(&loaded(&model, Some(&described(""))).unwrap());
    assert!((joined - expected()).abs() < 1e-6, "{joined}: the sums are in another order");
}

#[test]
fn a_network_with_a_memory_is_refused() {
    for kind in ["LSTM", "GRU", "RNN"] {
        let model = changed(|graph| graph.node.push(node(kind, &["observation"], "remembered")));
        let message = refusal(&model, None);
        assert!(
            message.contains(kind) && message.contains("has a memory, which would be lost at every decision"),
            "{message}"
        );
    }
}

#[test]
fn a_network_that_corrects_another_advises_as_its_own_file_does() {
    let whole =
        Network { limits: [-2.0, 2.0], corrected: Some(CorrectedAdvice::Network(Box::new(network()))), ..network() };
    let read = OnnxPolicy::from_bytes(&write(&whole), None).unwrap();
    let [mut onnx, mut own] = [read.engaged(0.1), whole.clone().policy(0.1)];
    for speed_mps in [0.0, 3.3, 7.1] {
        let seen = Observation { speed_mps, leader_speed_mps: 4.0, gap_m: 20.0, hold_s: 1.0, ..Observation::default() };
        let [Action::Speed(onnx), Action::Speed(own)] = [&mut onnx, &mut own].map(|policy| policy.act(0.0, &seen))
        else {
            panic!("speed policies")
        };
        assert!((onnx - own).abs() < 1e-5, "{onnx} {own}");
    }
    let inner = Network { corrected: whole.corrected.clone(), ..network() };
    let twice = Network { corrected: Some(CorrectedAdvice::Network(Box::new(inner))), ..whole };
    let message = OnnxPolicy::from_bytes(&write(&twice), None).err().unwrap().to_string();
    assert!(message.contains("corrects another advice itself\n  remedy:"), "{message}");
}

#[test]
fn a_description_names_the_key_that_was_meant() {
    let message = NetworkDescription::from_toml(&described("input_nam = \"x\"")).unwrap_err().to_string();
    assert!(message.contains("its description:1:1: unknown key `input_nam`; did you mean `input_name`?"), "{message}");
}
