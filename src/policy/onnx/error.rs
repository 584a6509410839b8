//! What can be wrong with a network in ONNX, by kind: its encoding, its description, its structure, its weights and inputs,
//! what the runtime says of it, what it answers.

use super::{
    EXAMPLE,
    limits::{
        MOST_BYTES, MOST_DEPTH, MOST_DIMENSIONS, MOST_ELEMENTS, MOST_ELEMENTS_IN_ALL, MOST_FIELDS, MOST_NODES,
        MOST_VARINTS, MOST_WHOLE_NUMBERS, MOST_WORK,
    },
    load::OPERATOR_SETS,
};
use crate::{
    file::size_text,
    policy::{CorrectionFault, ExpectedGainFault, SettingFault},
    toml_text::TomlError,
};
use std::{io, path::PathBuf};
use tract_onnx::prelude::TractError;

/// Why a network in ONNX cannot be a policy.
#[derive(Debug, thiserror::Error)]
pub enum OnnxFault {
    /// Its bytes are no protobuf, or end too early.
    #[error("is no ONNX file: it is damaged or cut")]
    Damaged,
    /// A protobuf, but of something else.
    #[error("is no ONNX file: {0}")]
    Foreign(prost::DecodeError),
    /// ONNX without a graph.
    #[error("is no ONNX file: it holds no network")]
    Empty,
    /// Structures within structures.
    #[error("holds networks within networks over {} deep; that is no policy", MOST_DEPTH)]
    TooDeep,
    /// More fields than are read.
    #[error("has more than {} fields; a policy is smaller", MOST_FIELDS)]
    ManyFields,
    /// A list of whole numbers that is too long.
    #[error("has a list of whole numbers of {} bytes; allowed: {} (weights are stored as raw data)", .0, MOST_VARINTS)]
    LongList(usize),
    /// Nothing says what its numbers mean.
    #[error(
        "does not say what its numbers mean; write a file of the same name with .toml behind it, such as\n{}",
        EXAMPLE
    )]
    NotDescribed,
    /// Its description cannot be one.
    #[error(transparent)]
    Description(#[from] DescriptionFault),
    /// A version of the operators that the runtime does not know.
    #[error("uses operator set {}; known are {} to {}", .0, OPERATOR_SETS.start(), OPERATOR_SETS.end())]
    OperatorSet(i64),
    /// Functions instead of operators.
    #[error("has functions of its own; export it with all of them inlined")]
    Functions,
    /// A graph without nodes.
    #[error("has no nodes: it computes nothing")]
    NoNodes,
    /// More nodes or tensors than are read.
    #[error("has {nodes} nodes and {weights} tensors of weights; allowed: {} of either", MOST_NODES)]
    ManyNodes {
        /// Its nodes.
        nodes: usize,
        /// Its tensors of weights.
        weights: usize,
    },
    /// Weights in a form that is not read.
    #[error("has sparse weights; store them as ordinary ones")]
    SparseWeights,
    /// A tensor of weights that cannot be used.
    #[error("weights `{name}` {fault}")]
    Weights {
        /// The tensor's name.
        name: String,
        /// What is wrong with it.
        fault: TensorFault,
    },
    /// A name that two tensors have.
    #[error("has two tensors of weights `{0}`")]
    WeightsTwice(String),
    /// Weights that are no numbers.
    #[error("weights `{0}` hold a NaN")]
    NanWeights(String),
    /// An output that nothing gives.
    #[error("output `{0}` comes from no node")]
    IdleOutput(String),
    /// Its inputs or outputs do not fit its description.
    #[error(transparent)]
    Ports(#[from] PortFault),
    /// It cannot be run.
    #[error("cannot be run: {0}")]
    Run(RunFault),
    /// Its answers are no actions.
    #[error(transparent)]
    Answer(#[from] AnswerFault),
}

/// Why a text describes no network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DescriptionFault {
    /// Not TOML, or with other keys.
    #[error("is no description of a network: {0}")]
    Toml(TomlError),
    /// A number that cannot be.
    #[error(transparent)]
    Setting(#[from] SettingFault),
    /// It cannot correct what it says that it corrects.
    #[error(transparent)]
    Correction(#[from] CorrectionFault),
    /// What it expects to gain cannot be told.
    #[error(transparent)]
    ExpectedGain(#[from] ExpectedGainFault),
    /// Holds that cannot be.
    #[error("holds_s are {shortest} to {longest}; they must be above 0, the first not above the second")]
    Holds {
        /// Shortest hold, s.
        shortest: f64,
        /// Longest hold, s.
        longest: f64,
    },
    /// An input that is fixed to no number.
    #[error("input `{name}` is fixed to {value}; allowed: a finite number")]
    Fixed {
        /// The input's name.
        name: String,
        /// What it is to be.
        value: f64,
    },
    /// The network would see nothing.
    #[error("inputs are empty; a network sees at least one number")]
    NoInputs,
}

/// Why a tensor's data cannot be used; it is said behind the tensor's name.
#[derive(Debug, thiserror::Error)]
pub enum TensorFault {
    /// Too many dimensions.
    #[error("have {} dimensions; allowed: {}", .0, MOST_DIMENSIONS)]
    Dimensions(usize),
    /// A shape that is negative or too large.
    #[error("have the shape {:?}; allowed: at most {} numbers", .0, MOST_ELEMENTS)]
    Shape(Vec<i64>),
    /// Too many whole numbers of 64 bits.
    #[error("are {} whole numbers of 64 bits; allowed: {}", .0, MOST_WHOLE_NUMBERS)]
    WholeNumbers(usize),
    /// Other data than the shape says.
    #[error("have the shape {dims:?}, that is {numbers} numbers, but hold {found}")]
    Length {
        /// Its shape.
        dims: Vec<i64>,
        /// Numbers that it says.
        numbers: usize,
        /// Numbers that there are.
        found: usize,
    },
    /// No numbers, or of a size that is not read.
    #[error("are of the type {0}; allowed: numbers of 8 to 64 bits")]
    Kind(&'static str),
    /// In another file where none is read.
    #[error("lie in another file; export the policy as one file")]
    Elsewhere,
    /// In another file without a name.
    #[error("lie in another file that is not named; export the network again")]
    Unnamed,
    /// In a file of another folder.
    #[error("lie in `{0}`; allowed: a file in the folder of the network")]
    Outside(String),
    /// In a file that is not there.
    #[error("lie in `{location}`, which cannot be read: {source}\n  remedy: put it into the folder of the network, {}", folder.display())]
    Absent {
        /// The file as it is named.
        location: String,
        /// The network's folder.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// In a file that cannot be read so far.
    #[error("lie in `{}`, which cannot be read: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A place in another file that is no number.
    #[error("have the {key} `{text}`; allowed: a whole number of bytes")]
    Place {
        /// `offset` or `length`.
        key: &'static str,
        /// What it is.
        text: String,
    },
    /// A length in another file that does not fit the shape.
    #[error("have the shape {dims:?}, that is {size} bytes, but say {said}")]
    Bytes {
        /// Its shape.
        dims: Vec<i64>,
        /// Bytes of that shape.
        size: u64,
        /// Bytes that it says.
        said: u64,
    },
    /// Together with those before more than is read.
    #[error(
        "would make more than {} with those before; allowed: {} in all",
        size_text(MOST_BYTES),
        size_text(MOST_BYTES)
    )]
    TooLarge,
}

/// Why inputs or outputs do not fit what is said of them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PortFault {
    /// No input or output of the name.
    #[error("has no {what} `{name}`; it has {}", known.join(", "))]
    Unknown {
        /// `input` or `output`.
        what: &'static str,
        /// The name that was asked for.
        name: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// Several, and nothing says which.
    #[error(
        "has {} {what}s ({}); name the action's: {what}_name = \"{}\"",
        known.len(), known.join(", "), known.first().map_or("", String::as_str)
    )]
    Ambiguous {
        /// `input` or `output`.
        what: &'static str,
        /// The names that there are.
        known: Vec<String>,
    },
    /// A constant for an input that there is not.
    #[error("has no input `{name}` to be fixed; it has {}", known.join(", "))]
    NothingToFix {
        /// The name that is fixed.
        name: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// A constant that would be too large.
    #[error("input `{name}` has the shape {dims:?}; to be fixed it may have {} numbers", MOST_WHOLE_NUMBERS)]
    LargeToFix {
        /// The input's name.
        name: String,
        /// Its shape.
        dims: Vec<i64>,
    },
    /// A constant that is no number.
    #[error("input `{name}` is of {kind}; that cannot be fixed")]
    KindToFix {
        /// The input's name.
        name: String,
        /// What it takes.
        kind: &'static str,
    },
    /// Other inputs than the observation that matter.
    #[error(
        "has other inputs that its action depends on ({}); a policy decides from the observation alone\n  remedy: \
         describe a constant for each, the same at every decision: {}",
        others.join(", "), fixed(others)
    )]
    Others {
        /// Their names.
        others: Vec<String>,
    },
    /// Several inputs, of which none is known to be the observation.
    #[error(
        "has {} inputs ({}); a policy has one, the observation, or one for each of its numbers\n  remedy: describe which it \
         is, and a constant for each other that the action depends on:\n  input_name = \"{first}\"\n  {}",
        all.len(), all.join(", "), fixed(others)
    )]
    Several {
        /// Names of all inputs.
        all: Vec<String>,
        /// The first that matters.
        first: String,
        /// The others that matter.
        others: Vec<String>,
    },
    /// An input of another kind, such as a list.
    #[error("input `{0}` is no tensor")]
    NoTensor(String),
    /// An input that takes no numbers with a point.
    #[error("input `{name}` is of {kind}; allowed: floating-point numbers of 16, 32 or 64 bits")]
    Kind {
        /// The input's name.
        name: String,
        /// What it takes.
        kind: &'static str,
    },
    /// An input for a single number that takes more.
    #[error("input `{0}` takes more than one number")]
    MoreThanOne(String),
    /// An input for another count of numbers than are described.
    #[error(
        "input `{name}` has the shape [{}]; the {needed} inputs that are described need [any, {needed}] or [{needed}]",
        sizes(declared)
    )]
    Shape {
        /// The input's name.
        name: String,
        /// Its sizes; `None` is any.
        declared: Vec<Option<i64>>,
        /// How many numbers are described.
        needed: usize,
    },
}

/// A line of a description that makes constants of inputs.
fn fixed(others: &[String]) -> String {
    let list: Vec<String> = others.iter().map(|name| format!("{name} = 0.0")).collect();
    format!("fixed = {{ {} }}", list.join(", "))
}

fn sizes(declared: &[Option<i64>]) -> String {
    let words: Vec<String> = declared.iter().map(|d| d.map_or("any".into(), |d| d.to_string())).collect();
    words.join(", ")
}

/// Why a network cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum RunFault {
    /// The runtime does not take it as a whole.
    #[error(transparent)]
    Runtime(#[from] RuntimeFault),
    /// One of its nodes is at fault.
    #[error("node {title}: {fault}")]
    Node {
        /// The node's name, and its operator in brackets.
        title: String,
        /// What is wrong with it.
        fault: NodeFault,
    },
}

/// What the runtime made of a network.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeFault {
    /// It said what it does not accept.
    #[error("{}", words(.0))]
    Refused(TractError),
    /// It panicked, with these words.
    #[error("the runtime (tract) cannot deal with it and broke off: {0}")]
    BrokeOff(String),
}

/// The runtime's message without its history.
fn words(error: &TractError) -> String {
    let chain: Vec<String> = error.chain().map(ToString::to_string).collect();
    chain.join(": ")
}

/// Why a node cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum NodeFault {
    /// The runtime does not take it.
    #[error(transparent)]
    Runtime(#[from] RuntimeFault),
    /// It draws numbers.
    #[error(
        "it draws random numbers, so that a drive could not be driven again the same; export the policy for evaluation, \
         with its mean action as output"
    )]
    Random,
    /// It may draw numbers.
    #[error("it may drop at random; export the policy for evaluation")]
    Dropout,
    /// Its attributes hold a graph.
    #[error("it holds a network of its own; a policy is one flat network: export it unrolled")]
    Nested,
    /// It remembers what it saw.
    #[error(
        "it has a memory, which would begin anew at every decision; a policy decides from what it sees now \
         (its own mean speed of half a minute can be among that: mean_speed)\n  remedy: export one without memory"
    )]
    Memory,
    /// Its operator is not among those that are run.
    #[error("operator {0} is none that a policy may use")]
    Operator(String),
    /// A tensor among its attributes cannot be used.
    #[error("attribute `{name}` {fault}")]
    Attribute {
        /// The attribute's name.
        name: String,
        /// What is wrong with it.
        fault: Box<TensorFault>,
    },
    /// A tensor among its attributes is in a form that is not read.
    #[error("attribute `{0}` is sparse; store it as an ordinary tensor")]
    SparseAttribute(String),
    /// It takes what nothing gives.
    #[error("its input `{0}` comes from nowhere before it")]
    NoInput(String),
    /// It gives what another gives.
    #[error("its output `{0}` is there already")]
    OutputTwice(String),
    /// All tensors together are too large.
    #[error("with it all tensors together have {} numbers; allowed: {}", .0, MOST_ELEMENTS_IN_ALL)]
    Elements(usize),
    /// An answer takes too long.
    #[error("with it one answer takes {:.0} multiplications; allowed: {:.0}", .0, MOST_WORK)]
    Work(f64),
    /// The shape of its result depends on numbers.
    #[error("the size of its result cannot be told before it is run; export the policy with fixed shapes")]
    Unsized,
    /// Its result has too many dimensions.
    #[error("its result has {} dimensions; allowed: {}", .0, MOST_DIMENSIONS)]
    Dimensions(usize),
    /// Its result has a shape that is negative or too large.
    #[error("its result has the shape {:?}; allowed: sizes of 0 or more, {} numbers", .0, MOST_ELEMENTS)]
    Shape(Vec<i64>),
    /// Its result has too many whole numbers of 64 bits.
    #[error("its result has {} whole numbers of 64 bits; allowed: {}", .0, MOST_WHOLE_NUMBERS)]
    WholeNumbers(usize),
}

/// Why the answers of a network are no actions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AnswerFault {
    /// An answer is no finite number.
    #[error("answers {seen:?} with {answer}; a policy must give finite numbers")]
    NotFinite {
        /// What it was asked.
        seen: Vec<f32>,
        /// What it answered.
        answer: f32,
    },
    /// Too few numbers for levels.
    #[error("gives {0} number; levels need at least 2")]
    FewLevels(usize),
    /// The number that is to be the action is none of them.
    #[error("gives {numbers} numbers; element {element} is none of them")]
    NoElement {
        /// How many it gives.
        numbers: usize,
        /// Which is described.
        element: usize,
    },
    /// More than one number, and nothing says which is the action.
    #[error("gives {0} numbers; one action needs 1: say which with `element`, or `output = \"levels\"`")]
    Several(usize),
}
