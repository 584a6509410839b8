//! Check of an ONNX network's structure: size and operators. In: a file's structure, before the runtime sees it. Out: nothing, or the
//! fault with node and value.

use super::{
    NodeFault, OnnxFault, RunFault, TensorFault,
    limits::{MOST_DIMENSIONS, MOST_ELEMENTS, MOST_NODES, MOST_WHOLE_NUMBERS},
    states::has_states,
};
use std::collections::BTreeSet;
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, TensorProto,
    tensor_proto::{DataLocation, DataType},
};

/// Operators whose result and cost follow from the shapes of their inputs, in alphabetical order.
const OPERATORS: &str = "\
    Abs Acos Acosh Add And ArgMax ArgMin Asin Asinh Atan Atanh BatchNormalization BiasGelu BitShift BitwiseAnd \
    BitwiseNot BitwiseOr BitwiseXor Cast CastLike Ceil Celu Clip Concat Constant ConstantOfShape Conv Cos Cosh \
    CumSum DequantizeLinear Div Dropout DynamicQuantizeLinear Elu Equal Erf Exp Expand FastGelu Flatten Floor \
    Gather GatherElements GatherND Gelu Gemm GlobalAveragePool GlobalMaxPool Greater GreaterOrEqual \
    GroupNormalization HardSigmoid HardSwish Hardmax Identity InstanceNormalization IsInf IsNaN \
    LayerNormalization LeakyRelu Less LessOrEqual Log LogSoftmax LpNormalization MatMul MatMulInteger Max Mean \
    MeanVarianceNormalization Min Mish Mod Mul Neg Not Or PRelu Pad ParametricSoftplus Pow QuantizeLinear QuickGelu \
    RMSNormalization Reciprocal ReduceL1 ReduceL2 ReduceLogSum ReduceLogSumExp ReduceMax ReduceMean ReduceMin \
    ReduceProd ReduceSum ReduceSumSquare Relu Reshape Round Rsqrt ScaledTanh ScatterElements ScatterND Selu Shape \
    Shrink Sigmoid Sign SimplifiedLayerNormalization Sin Sinh Size Slice Softmax Softplus Softsign Split Sqrt \
    Squeeze Sub Sum Swish Tan Tanh ThresholdedRelu Tile TopK Transpose Trilu Unsqueeze Where Xor";
/// Operators that draw random numbers, which would make a drive irreproducible.
const RANDOM: [&str; 6] =
    ["Bernoulli", "Multinomial", "RandomNormal", "RandomNormalLike", "RandomUniform", "RandomUniformLike"];

/// Operators with a memory; it lasts from one decision to the next only as a state of the network.
const WITH_MEMORY: [&str; 3] = ["GRU", "LSTM", "RNN"];

/// Checks the structure of a file.
///
/// # Errors
/// The structure is inconsistent, exceeds a limit or has an operator that is not allowed.
pub fn check(model: &ModelProto, graph: &GraphProto) -> Result<(), OnnxFault> {
    // Checked first, so that the message names the most important fault even if there are others.
    random(graph)?;
    if !model.functions.is_empty() {
        return Err(OnnxFault::Functions);
    }
    let (nodes, weights) = (graph.node.len(), graph.initializer.len());
    if nodes == 0 {
        return Err(OnnxFault::NoNodes);
    }
    if nodes.max(weights) > MOST_NODES {
        return Err(OnnxFault::ManyNodes { nodes, weights });
    }
    if !graph.sparse_initializer.is_empty() {
        return Err(OnnxFault::SparseWeights);
    }
    let mut known: BTreeSet<&str> = BTreeSet::new();
    for tensor in &graph.initializer {
        sized(tensor).map_err(|fault| OnnxFault::Weights { name: tensor.name.clone(), fault })?;
        if !known.insert(&tensor.name) {
            return Err(OnnxFault::WeightsTwice(tensor.name.clone()));
        }
    }
    // Old files list their weights among the inputs.
    known.extend(graph.input.iter().map(|value| value.name.as_str()));
    let has_states = has_states(graph);
    for node in &graph.node {
        let fault = |fault: NodeFault| node_fault(node, fault);
        flat(node, has_states).map_err(fault)?;
        if let Some(name) = node.input.iter().find(|name| !name.is_empty() && !known.contains(name.as_str())) {
            return Err(fault(NodeFault::NoInput(name.clone())));
        }
        for name in node.output.iter().filter(|name| !name.is_empty()) {
            if !known.insert(name) {
                return Err(fault(NodeFault::OutputTwice(name.clone())));
            }
        }
    }
    match graph.output.iter().find(|value| !known.contains(value.name.as_str())) {
        Some(value) => Err(OnnxFault::IdleOutput(value.name.clone())),
        None => Ok(()),
    }
}

fn node_fault(node: &NodeProto, fault: NodeFault) -> OnnxFault {
    let name = if node.name.is_empty() { node.output.first() } else { Some(&node.name) };
    let title = format!("`{}` ({})", name.map_or("", String::as_str), node.op_type);
    OnnxFault::Run(RunFault::Node { title, fault })
}

/// Refuses operators that draw random numbers, nested graphs included.
fn random(graph: &GraphProto) -> Result<(), OnnxFault> {
    for node in &graph.node {
        if RANDOM.contains(&node.op_type.as_str()) {
            return Err(node_fault(node, NodeFault::Random));
        }
        for attribute in &node.attribute {
            attribute.g.iter().chain(&attribute.graphs).try_for_each(random)?;
        }
    }
    Ok(())
}

/// Index of the first memory among the inputs of an operator with a memory.
const INITIAL_H: usize = 5;

/// Checks that the limits can be computed for a node: no nested graph, a memory only from a state, an allowed operator and sound
/// attributes.
fn flat(node: &NodeProto, has_states: bool) -> Result<(), NodeFault> {
    let holds_graph = |attribute: &AttributeProto| attribute.g.is_some() || !attribute.graphs.is_empty();
    if node.attribute.iter().any(holds_graph) || ["If", "Loop", "Scan"].contains(&node.op_type.as_str()) {
        return Err(NodeFault::Nested);
    }
    let has_memory = WITH_MEMORY.contains(&node.op_type.as_str());
    let is_given = has_states && node.input.get(INITIAL_H).is_some_and(|name| !name.is_empty());
    if has_memory && !is_given {
        return Err(NodeFault::Memory);
    }
    if !has_memory && !OPERATORS.split_whitespace().any(|name| name == node.op_type) {
        return Err(NodeFault::Operator(node.op_type.clone()));
    }
    if node.op_type == "Dropout" && node.input.len() > 2 {
        return Err(NodeFault::Dropout);
    }
    for attribute in &node.attribute {
        attribute
            .t
            .iter()
            .chain(&attribute.tensors)
            .try_for_each(sized)
            .map_err(|fault| NodeFault::Attribute { name: attribute.name.clone(), fault: fault.into() })?;
        if attribute.sparse_tensor.is_some() || !attribute.sparse_tensors.is_empty() {
            return Err(NodeFault::SparseAttribute(attribute.name.clone()));
        }
    }
    Ok(())
}

/// Checks that a tensor has as many elements as its shape says and not too many.
fn sized(tensor: &TensorProto) -> Result<(), TensorFault> {
    if tensor.dims.len() > MOST_DIMENSIONS {
        return Err(TensorFault::Dimensions(tensor.dims.len()));
    }
    let n = tensor.dims.iter().try_fold(1usize, |n, &dim| n.checked_mul(usize::try_from(dim).ok()?));
    let Some(n) = n.filter(|n| *n <= MOST_ELEMENTS) else {
        return Err(TensorFault::Shape(tensor.dims.clone()));
    };
    if is_external(tensor) {
        return Err(TensorFault::Elsewhere);
    }
    let kind = DataType::try_from(tensor.data_type).unwrap_or(DataType::Undefined);
    let bytes = element_bytes(tensor.data_type)?;
    let listed = match kind {
        DataType::Float => tensor.float_data.len(),
        DataType::Double => tensor.double_data.len(),
        DataType::Int64 | DataType::Uint64 => tensor.int64_data.len(),
        _ => tensor.int32_data.len(),
    };
    if matches!(kind, DataType::Int64 | DataType::Uint64) && n > MOST_WHOLE_NUMBERS {
        return Err(TensorFault::WholeNumbers(n));
    }
    let found = if tensor.raw_data.is_empty() { listed } else { tensor.raw_data.len() / bytes };
    let whole = tensor.raw_data.len().is_multiple_of(bytes);
    if found != n || !whole {
        return Err(TensorFault::Length { dims: tensor.dims.clone(), numbers: n, found });
    }
    Ok(())
}

/// Returns true if the tensor's numbers lie in another file.
pub(super) fn is_external(tensor: &TensorProto) -> bool {
    tensor.data_location == Some(DataLocation::External.into()) || !tensor.external_data.is_empty()
}

/// Returns the size of one element of such a tensor, bytes.
///
/// # Errors
/// The elements are not numbers, or have an unsupported size.
pub(super) fn element_bytes(data_type: i32) -> Result<usize, TensorFault> {
    let kind = DataType::try_from(data_type).unwrap_or(DataType::Undefined);
    Ok(match kind {
        DataType::Double | DataType::Int64 | DataType::Uint64 => 8,
        DataType::Float | DataType::Int32 | DataType::Uint32 => 4,
        DataType::Int16 | DataType::Uint16 | DataType::Float16 => 2,
        DataType::Int8 | DataType::Uint8 | DataType::Bool => 1,
        _ => return Err(TensorFault::Kind(kind.as_str_name())),
    })
}
