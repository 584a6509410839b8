//! ONNX networks from any program as policies. In: a `.onnx` file and the meaning of its numbers, a [`NetworkDescription`] in its
//! metadata or in a TOML file beside it (`policy.onnx.toml` beside `policy.onnx`). Out: a [`Policy`](super::Policy), or an error before
//! the drive. Run by tract. A recurrent network has its states as inputs and outputs (`states`). [`write()`] exports a network,
//! [`write_layers()`] one with recurrent layers, and [`write_estimator()`] a driver estimator.

#[cfg(test)]
mod border_tests;
mod description;
mod error;
mod external;
mod inputs;
pub mod limits;
mod load;
mod sizes;
mod state_error;
#[cfg(test)]
mod state_tests;
mod states;
mod structure;
mod wire;
mod write;
mod write_estimator;
mod write_recurrent;

pub use description::{METADATA_KEY, NetworkDescription, OutputMeaning};
pub use error::{AnswerFault, DescriptionFault, NodeFault, OnnxFault, PortFault, RunFault, RuntimeFault, TensorFault};
pub use load::OnnxPolicy;
pub use state_error::StateFault;
pub use write::{describe, write, write_layers};
pub use write_estimator::write_estimator;
pub use write_recurrent::{PolicyLayer, RecurrentFault, RecurrentKind, RecurrentLayer};
