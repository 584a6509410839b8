//! Inputs of a network: which of them is the observation, and of which number type. In: the graph and its description. Out: the graph
//! reduced to that input, the wanted output and the states, with other inputs made constant or removed, and the input shapes.

use super::{
    NetworkDescription, PortFault,
    limits::MOST_WHOLE_NUMBERS,
    states::{NetworkState, STATE_IN, STATE_OUT, states},
};
use half::f16;
use std::collections::BTreeSet;
use tract_onnx::pb::{
    GraphProto, TensorProto, ValueInfoProto,
    tensor_proto::DataType,
    tensor_shape_proto::dimension,
    type_proto::{self, Tensor},
};

/// Inputs of a prepared graph, in its order.
pub(super) struct Ports {
    /// Shapes of the inputs for one observation: one input for all numbers, or one for each.
    pub observed: Vec<Vec<usize>>,
    /// States, whose inputs and outputs come after those of the observation and the action.
    pub states: Vec<NetworkState>,
}

/// Reduces the graph to the parts that the wanted output and the states need; returns its inputs.
///
/// # Errors
/// Inputs or outputs do not fit the description.
pub(super) fn prepare(graph: &mut GraphProto, description: &NetworkDescription) -> Result<Ports, PortFault> {
    let actions = graph.output.iter().map(|v| v.name.clone()).filter(|name| !name.starts_with(STATE_OUT)).collect();
    let output = chosen("output", actions, description.output_name.as_deref())?;
    // Old files list their weights among the inputs.
    let weights: BTreeSet<String> = graph.initializer.iter().map(|tensor| tensor.name.clone()).collect();
    graph.input.retain(|value| !weights.contains(&value.name));
    fix(graph, description)?;
    let states = states(graph, description)?;
    let kept: Vec<&str> = std::iter::once(output.as_str()).chain(states.iter().map(|s| s.output.as_str())).collect();
    graph.output.retain(|value| kept.contains(&value.name.as_str()));
    graph.output.sort_by_key(|value| kept.iter().position(|name| *name == value.name));
    let needed = prune(graph, &kept);
    let of_states: Vec<ValueInfoProto> = graph.input.extract_if(.., |v| v.name.starts_with(STATE_IN)).collect();
    let observed = observed(graph, description, &needed)?;
    graph.input.retain(|value| observed.contains(&value.name));
    let n = description.inputs.len();
    graph.input.iter().try_for_each(check_kind)?;
    let shapes = match graph.input.as_slice() {
        [one] => vec![shape(one, n)?],
        many => many.iter().map(shape_of_one).collect::<Result<_, _>>()?,
    };
    graph.input.extend(of_states);
    narrow(graph);
    Ok(Ports { observed: shapes, states })
}

/// Converts 64-bit and 16-bit floats to the 32-bit floats that the runtime computes with; it lacks operators for the others.
fn narrow(graph: &mut GraphProto) {
    graph.initializer.iter_mut().for_each(narrow_tensor);
    for attribute in graph.node.iter_mut().flat_map(|node| &mut node.attribute) {
        attribute.t.iter_mut().chain(&mut attribute.tensors).for_each(narrow_tensor);
        // Target type of Cast.
        if attribute.name == "to" && is_other_float(i32::try_from(attribute.i).unwrap_or_default()) {
            attribute.i = i32::from(DataType::Float).into();
        }
    }
    for value in graph.input.iter_mut().chain(&mut graph.output) {
        if let Some(type_proto::Value::TensorType(tensor)) = value.r#type.as_mut().and_then(|kind| kind.value.as_mut())
            && is_other_float(tensor.elem_type)
        {
            tensor.elem_type = DataType::Float.into();
        }
    }
}

fn is_other_float(data_type: i32) -> bool {
    [i32::from(DataType::Double), i32::from(DataType::Float16)].contains(&data_type)
}

fn narrow_tensor(tensor: &mut TensorProto) {
    if !is_other_float(tensor.data_type) {
        return;
    }
    let raw = std::mem::take(&mut tensor.raw_data);
    let numbers: Vec<f32> = if tensor.data_type == i32::from(DataType::Double) {
        let stored = raw.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap_or([0xff; 8])));
        stored.chain(std::mem::take(&mut tensor.double_data)).map(|x| x as f32).collect()
    } else {
        let stored = raw.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]));
        let listed = std::mem::take(&mut tensor.int32_data).into_iter().map(|bits| f16::from_bits(bits as u16));
        stored.chain(listed).map(f16::to_f32).collect()
    };
    tensor.data_type = DataType::Float.into();
    tensor.raw_data = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
}

/// Returns the requested name, or the only one.
fn chosen(what: &'static str, known: Vec<String>, name: Option<&str>) -> Result<String, PortFault> {
    match name {
        Some(name) if known.iter().any(|known| known == name) => Ok(name.into()),
        Some(name) => Err(PortFault::Unknown { what, name: name.into(), known }),
        None if known.len() == 1 => Ok(known[0].clone()),
        None => Err(PortFault::Ambiguous { what, known }),
    }
}

/// Replaces the inputs that the description fixes by constants.
fn fix(graph: &mut GraphProto, description: &NetworkDescription) -> Result<(), PortFault> {
    for (name, value) in &description.fixed {
        let Some(at) = graph.input.iter().position(|input| input.name == *name) else {
            let known = graph.input.iter().map(|input| input.name.clone()).collect();
            return Err(PortFault::NothingToFix { name: name.clone(), known });
        };
        let input = graph.input.remove(at);
        graph.initializer.push(constant(&input, *value)?);
    }
    Ok(())
}

/// Returns a tensor with an input's shape filled with `value`; a free dimension gets size 1.
fn constant(input: &ValueInfoProto, value: f64) -> Result<TensorProto, PortFault> {
    let tensor = tensor(input)?;
    let dims: Vec<i64> = declared(tensor).into_iter().map(|dim| dim.unwrap_or(1)).collect();
    let n = dims.iter().try_fold(1usize, |n, dim| n.checked_mul(usize::try_from(*dim).ok()?));
    let Some(n) = n.filter(|n| *n <= MOST_WHOLE_NUMBERS) else {
        return Err(PortFault::LargeToFix { name: input.name.clone(), dims });
    };
    let bytes = match DataType::try_from(tensor.elem_type).unwrap_or(DataType::Undefined) {
        DataType::Float => (value as f32).to_le_bytes().to_vec(),
        DataType::Double => value.to_le_bytes().to_vec(),
        DataType::Float16 => f16::from_f64(value).to_le_bytes().to_vec(),
        DataType::Int64 => (value as i64).to_le_bytes().to_vec(),
        DataType::Int32 => (value as i32).to_le_bytes().to_vec(),
        DataType::Bool => vec![u8::from(value != 0.0)],
        other => return Err(PortFault::KindToFix { name: input.name.clone(), kind: other.as_str_name() }),
    };
    Ok(TensorProto {
        name: input.name.clone(),
        dims,
        data_type: tensor.elem_type,
        raw_data: bytes.repeat(n),
        ..TensorProto::default()
    })
}

/// Removes the nodes and weights that the outputs do not need; returns the names of the tensors that they need.
fn prune(graph: &mut GraphProto, outputs: &[&str]) -> BTreeSet<String> {
    let mut needed: BTreeSet<String> = outputs.iter().map(|name| (*name).to_owned()).collect();
    // Nodes come after those whose outputs they take (`limits` has checked this).
    for node in graph.node.iter().rev() {
        if node.output.iter().any(|name| needed.contains(name)) {
            needed.extend(node.input.iter().cloned());
        }
    }
    graph.node.retain(|node| node.output.iter().any(|name| needed.contains(name)));
    graph.initializer.retain(|tensor| needed.contains(&tensor.name));
    needed
}

/// Returns the names of the inputs that form the observation: one, or one for each of its numbers.
fn observed(
    graph: &GraphProto,
    description: &NetworkDescription,
    needed: &BTreeSet<String>,
) -> Result<BTreeSet<String>, PortFault> {
    let all: Vec<String> = graph.input.iter().map(|input| input.name.clone()).collect();
    let matter: Vec<&ValueInfoProto> = graph.input.iter().filter(|input| needed.contains(&input.name)).collect();
    let others_than =
        |name: &str| -> Vec<String> { matter.iter().map(|v| v.name.clone()).filter(|other| other != name).collect() };
    if description.input_name.is_some() || all.len() == 1 {
        let name = chosen("input", all, description.input_name.as_deref())?;
        let others = others_than(&name);
        if !others.is_empty() {
            return Err(PortFault::Others { others });
        }
        return Ok(BTreeSet::from([name]));
    }
    if let [one] = matter.as_slice() {
        return Ok(BTreeSet::from([one.name.clone()]));
    }
    let n = description.inputs.len();
    if n > 1 && matter.len() == n && matter.iter().all(|input| shape_of_one(input).is_ok()) {
        return Ok(matter.iter().map(|input| input.name.clone()).collect());
    }
    let first = matter.first().map_or_else(|| all.first().cloned().unwrap_or_default(), |v| v.name.clone());
    let others = others_than(&first);
    Err(PortFault::Several { all, first, others })
}

pub(super) fn tensor(input: &ValueInfoProto) -> Result<&Tensor, PortFault> {
    match input.r#type.as_ref().and_then(|kind| kind.value.as_ref()) {
        Some(type_proto::Value::TensorType(tensor)) => Ok(tensor),
        _ => Err(PortFault::NoTensor(input.name.clone())),
    }
}

/// Returns the sizes of the dimensions; `None` for any size.
pub(super) fn declared(tensor: &Tensor) -> Vec<Option<i64>> {
    let dims = tensor.shape.iter().flat_map(|shape| &shape.dim);
    dims.map(|dim| match &dim.value {
        Some(dimension::Value::DimValue(size)) if *size > 0 => Some(*size),
        _ => None,
    })
    .collect()
}

pub(super) fn check_kind(input: &ValueInfoProto) -> Result<(), PortFault> {
    match DataType::try_from(tensor(input)?.elem_type).unwrap_or(DataType::Undefined) {
        DataType::Float | DataType::Double | DataType::Float16 => Ok(()),
        other => Err(PortFault::Kind { name: input.name.clone(), kind: other.as_str_name() }),
    }
}

/// Returns the shape of an input that takes one number.
fn shape_of_one(input: &ValueInfoProto) -> Result<Vec<usize>, PortFault> {
    let declared = declared(tensor(input)?);
    if declared.len() <= 2 && declared.iter().all(|dim| dim.is_none_or(|d| d == 1)) {
        return Ok(vec![1; declared.len()]);
    }
    Err(PortFault::MoreThanOne(input.name.clone()))
}

/// Returns the shape for one observation of `n` numbers that fits the declared shape.
fn shape(input: &ValueInfoProto, n: usize) -> Result<Vec<usize>, PortFault> {
    let declared = declared(tensor(input)?);
    let fits = |dim: &Option<i64>, size: i64| dim.is_none_or(|d| d == size);
    match declared.as_slice() {
        [] => Ok(vec![1, n]),
        [numbers] if fits(numbers, n as i64) => Ok(vec![n]),
        [rows, numbers] if fits(rows, 1) && fits(numbers, n as i64) => Ok(vec![1, n]),
        _ => Err(PortFault::Shape { name: input.name.clone(), declared, needed: n }),
    }
}
