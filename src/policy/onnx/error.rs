//! Faults of an ONNX network, by kind: encoding, description, structure, weights, inputs, runtime errors and outputs.

use super::{
    limits::{
        MOST_BYTES, MOST_DEPTH, MOST_DIMENSIONS, MOST_ELEMENTS, MOST_ELEMENTS_IN_ALL, MOST_FIELDS, MOST_NODES,
        MOST_VARINTS, MOST_WHOLE_NUMBERS, MOST_WORK, OPERATOR_SETS,
    },
    state_error::StateFault,
};
use crate::{file::size_text, toml_text::TomlError};
use std::{io, path::PathBuf};
use tract_onnx::prelude::TractError;

/// Example of a description, for messages.
const EXAMPLE: &str = r#"action = "acceleration"   # or "speed"
limits = [-0.5, 0.5]       # m/s2 or m/s
holds_s = [1.0, 1.0]       # shortest and longest hold, s
output = "scaled"          # -1..1 spans the limits; "si": the action itself; "levels": one number a level
inputs = [                 # `from` is seen as -1 and `to` as 1
  { feature = "speed", from = 0.0, to = 10.0 },
  { feature = "leader_speed", from = 0.0, to = 10.0 },
  { feature = "gap", from = 0.0, to = 300.0 },
  { feature = "circumference", from = 200.0, to = 300.0 },
]
# input_name = "obs"       # for a network with several inputs; every other input is a constant:
# fixed = { mask = 1.0 }"#;

/// Reasons that an ONNX network cannot be used as a policy.
#[derive(Debug, thiserror::Error)]
pub enum OnnxFault {
    /// The bytes are no protobuf, or end too early.
    #[error("is not an ONNX file: it is damaged or cut")]
    Damaged,
    /// The file is a protobuf of another kind.
    #[error("is not an ONNX file: {0}")]
    Foreign(prost::DecodeError),
    /// The file has no graph.
    #[error("is not an ONNX file: it has no network")]
    Empty,
    /// Structures are nested too deeply.
    #[error("nests networks more than {} levels deep; allowed: one flat network", MOST_DEPTH)]
    TooDeep,
    /// The file has too many fields.
    #[error("has too many fields; allowed: at most {}", MOST_FIELDS)]
    ManyFields,
    /// A list of integers is too long.
    #[error("has a list of whole numbers of {} bytes; allowed: {} (weights are stored as raw data)", .0, MOST_VARINTS)]
    LongList(usize),
    /// The meaning of the numbers is not described.
    #[error(
        "does not describe its inputs and outputs; write a file with the same name followed by .toml, such as\n{}",
        EXAMPLE
    )]
    NotDescribed,
    /// The description is invalid.
    #[error(transparent)]
    Description(#[from] DescriptionFault),
    /// The runtime does not know this operator set.
    #[error("uses operator set {}; allowed: {} to {}", .0, OPERATOR_SETS.start(), OPERATOR_SETS.end())]
    OperatorSet(i64),
    /// The model defines its own functions instead of using operators.
    #[error("defines functions; export the network with all functions inlined")]
    Functions,
    /// The graph has no nodes.
    #[error("has no nodes: it computes nothing")]
    NoNodes,
    /// The graph has too many nodes or tensors.
    #[error("has {nodes} nodes and {weights} tensors of weights; allowed: {} of either", MOST_NODES)]
    ManyNodes {
        /// Number of nodes in the graph.
        nodes: usize,
        /// Number of weight tensors.
        weights: usize,
    },
    /// Sparse weights are not supported.
    #[error("has sparse weights; store them as dense tensors")]
    SparseWeights,
    /// A weight tensor cannot be used.
    #[error("weights `{name}` {fault}")]
    Weights {
        /// Name of the tensor.
        name: String,
        /// Fault of the tensor.
        fault: TensorFault,
    },
    /// Two weight tensors have the same name.
    #[error("has two tensors of weights `{0}`")]
    WeightsTwice(String),
    /// A weight tensor contains a NaN.
    #[error("weights `{0}` hold a NaN")]
    NanWeights(String),
    /// No node computes this output.
    #[error("output `{0}` is not computed by any node")]
    IdleOutput(String),
    /// The inputs or outputs do not fit the description.
    #[error(transparent)]
    Ports(#[from] PortFault),
    /// The network cannot be run.
    #[error("cannot be run: {0}")]
    Run(RunFault),
    /// The outputs are not actions.
    #[error(transparent)]
    Answer(#[from] AnswerFault),
}

/// All reasons that a text is not a valid description of a network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("is not a description of a network\n{0}")]
pub struct DescriptionFault(pub TomlError);

/// Reasons that a tensor's data cannot be used; the message follows the tensor's name.
#[derive(Debug, thiserror::Error)]
pub enum TensorFault {
    /// The tensor has too many dimensions.
    #[error("have {} dimensions; allowed: {}", .0, MOST_DIMENSIONS)]
    Dimensions(usize),
    /// A size is negative or the shape is too large.
    #[error("have the shape {:?}; allowed: at most {} numbers", .0, MOST_ELEMENTS)]
    Shape(Vec<i64>),
    /// The tensor has too many 64-bit integers.
    #[error("are {} whole numbers of 64 bits; allowed: {}", .0, MOST_WHOLE_NUMBERS)]
    WholeNumbers(usize),
    /// The amount of data does not match the shape.
    #[error("have the shape {dims:?}, that is {numbers} numbers, but hold {found}")]
    Length {
        /// Shape of the tensor.
        dims: Vec<i64>,
        /// Number of elements by the shape.
        numbers: usize,
        /// Number of elements in the data.
        found: usize,
    },
    /// The elements are not numbers, or have an unsupported size.
    #[error("are of the type {0}; allowed: numbers of 8 to 64 bits")]
    Kind(&'static str),
    /// The data lies in another file, and no folder is known.
    #[error("lie in another file; export the policy as one file")]
    Elsewhere,
    /// The data lies in another file without a name.
    #[error("lie in another file that is not named; export the network again")]
    Unnamed,
    /// The data lies in a file outside the network's folder.
    #[error("lie in `{0}`; allowed: a file in the folder of the network")]
    Outside(String),
    /// The data lies in a file that does not exist.
    #[error("lie in `{location}`, which cannot be read: {source}\n  remedy: put it into the folder of the network, {}", folder.display())]
    Absent {
        /// File name as given in the network.
        location: String,
        /// Folder of the network.
        folder: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The data's file cannot be read up to the required length.
    #[error("lie in `{}`, which cannot be read: {source}", file.display())]
    Unreadable {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The offset or length in another file is not a whole number.
    #[error("have the {key} `{text}`; allowed: a whole number of bytes")]
    Place {
        /// Key of the entry: `offset` or `length`.
        key: &'static str,
        /// Value of the entry.
        text: String,
    },
    /// The length in another file does not match the shape.
    #[error("have the shape {dims:?}, that is {size} bytes, but say {declared}")]
    Bytes {
        /// Shape of the tensor.
        dims: Vec<i64>,
        /// Number of bytes by the shape.
        size: u64,
        /// Length given in the network, bytes.
        declared: u64,
    },
    /// The external weights together exceed the limit.
    #[error(
        "have more than {} together with the weights before; allowed: {} in all",
        size_text(MOST_BYTES),
        size_text(MOST_BYTES)
    )]
    TooLarge,
}

/// Reasons that inputs or outputs do not fit the description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PortFault {
    /// No input or output has this name.
    #[error("has no {what} `{name}`; it has {}", known.join(", "))]
    Unknown {
        /// Kind of port: `input` or `output`.
        what: &'static str,
        /// Name in the description.
        name: String,
        /// Names in the network.
        known: Vec<String>,
    },
    /// There are several inputs or outputs, and none is named in the description.
    #[error(
        "has {} {what}s ({}); name the action's: {what}_name = \"{}\"",
        known.len(), known.join(", "), known.first().map_or("", String::as_str)
    )]
    Ambiguous {
        /// Kind of port: `input` or `output`.
        what: &'static str,
        /// Names in the network.
        known: Vec<String>,
    },
    /// The description fixes an input that does not exist.
    #[error("has no input `{name}` to fix; it has {}", known.join(", "))]
    NothingToFix {
        /// Name in the description.
        name: String,
        /// Names in the network.
        known: Vec<String>,
    },
    /// The fixed input is too large.
    #[error("input `{name}` has the shape {dims:?}; allowed for a fixed input: {} numbers", MOST_WHOLE_NUMBERS)]
    LargeToFix {
        /// Name of the input.
        name: String,
        /// Shape of the input.
        dims: Vec<i64>,
    },
    /// The fixed input does not take numbers.
    #[error("input `{name}` is of {kind}; an input of this kind cannot be fixed")]
    KindToFix {
        /// Name of the input.
        name: String,
        /// Element type of the input.
        kind: &'static str,
    },
    /// The action depends on inputs other than the observation.
    #[error(
        "has other inputs that its action depends on ({}); a policy decides from the observation alone\n  remedy: \
         describe a constant for each, the same at every decision: {}",
        others.join(", "), fixed(others)
    )]
    Others {
        /// Names of the other inputs.
        others: Vec<String>,
    },
    /// The network has several inputs, and none is known to be the observation.
    #[error(
        "has {} inputs ({}); a policy has one, the observation, or one for each of its numbers, besides states \
         (state_in_NAME)\n  remedy: name the observation, and a constant for every other input that the action \
         depends on:\n  input_name = \"{first}\"\n  {}",
        all.len(), all.join(", "), fixed(others)
    )]
    Several {
        /// Names of all inputs.
        all: Vec<String>,
        /// First input that the action depends on.
        first: String,
        /// Other inputs that the action depends on.
        others: Vec<String>,
    },
    /// A state of the network cannot be kept from one decision to the next.
    #[error(transparent)]
    State(#[from] StateFault),
    /// The input is not a tensor but, for example, a list.
    #[error("input `{0}` is not a tensor")]
    NoTensor(String),
    /// The input does not take floating-point numbers.
    #[error("input `{name}` is of {kind}; allowed: floating-point numbers of 16, 32 or 64 bits")]
    Kind {
        /// Name of the input.
        name: String,
        /// Element type of the input.
        kind: &'static str,
    },
    /// An input for a single number takes more than one.
    #[error("input `{0}` takes more than one number")]
    MoreThanOne(String),
    /// The input's size differs from the number of described inputs.
    #[error(
        "input `{name}` has the shape [{}]; the {needed} described inputs need [any, {needed}] or [{needed}]",
        sizes(declared)
    )]
    Shape {
        /// Name of the input.
        name: String,
        /// Sizes of the input; `None` is any size.
        declared: Vec<Option<i64>>,
        /// Number of described inputs.
        needed: usize,
    },
}

/// Returns a line for the description that fixes these inputs to 0.
fn fixed(others: &[String]) -> String {
    let list: Vec<String> = others.iter().map(|name| format!("{name} = 0.0")).collect();
    format!("fixed = {{ {} }}", list.join(", "))
}

fn sizes(declared: &[Option<i64>]) -> String {
    let words: Vec<String> = declared.iter().map(|d| d.map_or("any".into(), |d| d.to_string())).collect();
    words.join(", ")
}

/// Reasons that a network cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum RunFault {
    /// The runtime refuses the network as a whole.
    #[error(transparent)]
    Runtime(#[from] RuntimeFault),
    /// A node is at fault.
    #[error("node {title}: {fault}")]
    Node {
        /// Name of the node, with its operator in brackets.
        title: String,
        /// Fault of the node.
        fault: NodeFault,
    },
}

/// Failure of the runtime.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeFault {
    /// The runtime returned an error.
    #[error("{}", error_text(.0))]
    Refused(TractError),
    /// The runtime panicked with this message.
    #[error("the runtime (tract) failed: {0}")]
    BrokeOff(String),
}

/// Returns the runtime's error with its causes.
fn error_text(error: &TractError) -> String {
    let chain: Vec<String> = error.chain().map(ToString::to_string).collect();
    chain.join(": ")
}

/// Reasons that a node cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum NodeFault {
    /// The runtime refuses the node.
    #[error(transparent)]
    Runtime(#[from] RuntimeFault),
    /// The node draws random numbers.
    #[error(
        "it draws random numbers, so a drive could not be replayed; export the policy for evaluation, with its mean \
         action as output"
    )]
    Random,
    /// The node may draw random numbers.
    #[error("it may drop at random; export the policy for evaluation")]
    Dropout,
    /// The node's attributes contain a graph.
    #[error("it contains another network; export the policy unrolled, as one flat network")]
    Nested,
    /// The node has a memory.
    #[error(
        "it has a memory, which would be lost at every decision\n  remedy: export the network with its memory as inputs \
         state_in_NAME and outputs state_out_NAME"
    )]
    Memory,
    /// The operator is not among the allowed ones.
    #[error("operator {0} is not allowed in a policy")]
    Operator(String),
    /// A tensor among the attributes cannot be used.
    #[error("attribute `{name}` {fault}")]
    Attribute {
        /// Name of the attribute.
        name: String,
        /// Fault of the tensor.
        fault: Box<TensorFault>,
    },
    /// A tensor among the attributes is sparse.
    #[error("attribute `{0}` is sparse; store it as a dense tensor")]
    SparseAttribute(String),
    /// An input of the node comes from no earlier node.
    #[error("its input `{0}` is not computed by an earlier node")]
    NoInput(String),
    /// An output of the node has the name of an existing tensor.
    #[error("its output `{0}` exists already")]
    OutputTwice(String),
    /// All tensors together have too many elements.
    #[error("all tensors up to this node have {} numbers; allowed: {}", .0, MOST_ELEMENTS_IN_ALL)]
    Elements(usize),
    /// One evaluation of the network takes too many multiplications.
    #[error("one decision takes {:.0} multiplications up to this node; allowed: {:.0}", .0, MOST_WORK)]
    Work(f64),
    /// The shape of the result depends on values.
    #[error("the size of its result is unknown before it is run; export the policy with fixed shapes")]
    Unsized,
    /// The result has too many dimensions.
    #[error("its result has {} dimensions; allowed: {}", .0, MOST_DIMENSIONS)]
    Dimensions(usize),
    /// The result's shape is negative or too large.
    #[error("its result has the shape {:?}; allowed: sizes of 0 or more, {} numbers", .0, MOST_ELEMENTS)]
    Shape(Vec<i64>),
    /// The result has too many 64-bit integers.
    #[error("its result has {} whole numbers of 64 bits; allowed: {}", .0, MOST_WHOLE_NUMBERS)]
    WholeNumbers(usize),
}

/// Reasons that the outputs of a network are not actions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AnswerFault {
    /// An output is not finite.
    #[error("gives {answer} for the inputs {seen:?}; allowed: finite numbers")]
    NotFinite {
        /// Inputs of the network.
        seen: Vec<f32>,
        /// Output for these inputs.
        answer: f32,
    },
    /// A state becomes infinite or NaN, or has another size than its input.
    #[error("gives {given} for `{output}`; allowed: {numbers} finite numbers, as many as the state has")]
    State {
        /// Name of the state's output.
        output: String,
        /// Numbers of the output: their count, or the first that is not finite.
        given: String,
        /// Number of the state's numbers.
        numbers: usize,
    },
    /// There are too few outputs for levels.
    #[error("gives {0} number; allowed for levels: at least 2")]
    FewLevels(usize),
    /// The described element does not exist.
    #[error("gives {numbers} numbers; element {element} is not one of them")]
    NoElement {
        /// Number of outputs of the network.
        numbers: usize,
        /// Index of the described element.
        element: usize,
    },
    /// There are several outputs, and the description does not say which is the action.
    #[error("gives {0} numbers; allowed for one action: 1; choose it with `element`, or set `output = \"levels\"`")]
    Several(usize),
}
