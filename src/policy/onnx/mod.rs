//! ONNX networks from any program as policies. In: a `.onnx` file and the meaning of its numbers, a [`NetworkDescription`] in its
//! metadata or in a TOML file beside it (`policy.onnx.toml` beside `policy.onnx`). Out: a [`Policy`](super::Policy), or an error before
//! the drive. Run by tract. [`write()`] exports a network, and [`write_estimator()`] its driver estimator.

#[cfg(test)]
mod border_tests;
mod description;
mod error;
mod external;
mod inputs;
pub mod limits;
mod load;
mod sizes;
mod structure;
mod wire;
mod write;
mod write_estimator;

pub use description::{METADATA_KEY, NetworkDescription, OutputMeaning};
pub use error::{AnswerFault, DescriptionFault, NodeFault, OnnxFault, PortFault, RunFault, RuntimeFault, TensorFault};
pub use load::OnnxPolicy;
pub use write::{describe, write};
pub use write_estimator::write_estimator;
