//! Limits of ONNX networks: size and operators. In: a file's structure, before the runtime sees it. Out: nothing, or the fault with node
//! and value. A policy decides within milliseconds, so all limits lie far above one.

use super::{NodeFault, OnnxFault, RunFault, TensorFault, external::is_external};
use std::collections::BTreeSet;
use tract_onnx::pb::{AttributeProto, GraphProto, ModelProto, NodeProto, TensorProto, tensor_proto::DataType};

/// Largest file, bytes: 4 million weights.
pub const MOST_BYTES: u64 = 16 << 20;
/// Largest number of protobuf fields in a file; 20 per node at [`MOST_NODES`] nodes take less than half.
pub const MOST_FIELDS: usize = 50_000;
/// Deepest nesting of structures in a file; a flat network has 7 levels.
pub const MOST_DEPTH: usize = 16;
/// Largest list of integers, bytes.
pub const MOST_VARINTS: usize = 1 << 18;
/// Largest number of nodes. The runtime's time grows with its square and is 1 s at this number.
pub const MOST_NODES: usize = 1_000;
/// Largest number of elements in one tensor.
pub const MOST_ELEMENTS: usize = 4 << 20;
/// Largest number of elements in all tensors of a network.
pub const MOST_ELEMENTS_IN_ALL: usize = 8 << 20;
/// Largest number of dimensions of a tensor.
pub const MOST_DIMENSIONS: usize = 8;
/// Largest number of elements in a tensor of 64-bit integers, which networks use to compute shapes.
pub const MOST_WHOLE_NUMBERS: usize = 4096;
/// Largest number of multiplications per evaluation, about 10 ms.
pub const MOST_WORK: f64 = 20e6;

/// Limits in words for help texts.
pub const IN_WORDS: &str = "an ONNX file has at most 16 MiB, 1000 nodes, 4 million numbers in a tensor and 20 million \
                            multiplications for an answer, no random operator and no network within the network";

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

/// Operators with a memory; a policy has none between decisions.
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
    for node in &graph.node {
        let fault = |fault: NodeFault| node_fault(node, fault);
        flat(node).map_err(fault)?;
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

/// Checks that the limits can be computed for a node: no nested graph, no memory, an allowed operator and sound attributes.
fn flat(node: &NodeProto) -> Result<(), NodeFault> {
    let holds_graph = |attribute: &AttributeProto| attribute.g.is_some() || !attribute.graphs.is_empty();
    if node.attribute.iter().any(holds_graph) || ["If", "Loop", "Scan"].contains(&node.op_type.as_str()) {
        return Err(NodeFault::Nested);
    }
    if WITH_MEMORY.contains(&node.op_type.as_str()) {
        return Err(NodeFault::Memory);
    }
    if !OPERATORS.split_whitespace().any(|name| name == node.op_type) {
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
