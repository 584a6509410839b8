//! Limits of ONNX networks. Out: the largest sizes, and the operator sets. A policy decides within milliseconds, so all limits lie far
//! above one.

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
/// Largest number of numbers in one state of a recurrent network; each advised vehicle keeps 4 bytes for each.
pub const MOST_STATE_NUMBERS: usize = 1 << 16;
/// Largest number of multiplications per evaluation, about 10 ms.
pub const MOST_WORK: f64 = 20e6;

/// Limits in words for help texts.
pub const IN_WORDS: &str = "an ONNX file has at most 16 MiB, 1000 nodes, 4 million numbers in a tensor and 20 million \
                            multiplications per decision, no random operator and no network within the network";

/// Operator sets that the runtime knows.
pub(super) const OPERATOR_SETS: std::ops::RangeInclusive<i64> = 7..=23;
