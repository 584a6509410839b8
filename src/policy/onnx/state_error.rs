//! Faults of the states of a recurrent network. In: names, shapes and numbers of a state. Out: the message with what is allowed.

use super::limits::MOST_STATE_NUMBERS;

/// Reasons that a state cannot be kept from one decision to the next.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StateFault {
    /// The network takes a state and does not return it.
    #[error("has the input `{input}` of a state and no output `{output}`, which gives it to the next decision")]
    NotReturned {
        /// Name of the input.
        input: String,
        /// Name of the missing output.
        output: String,
    },
    /// The state is too large.
    #[error("input `{input}` has the shape {sizes:?}; allowed for a state: {} numbers", MOST_STATE_NUMBERS)]
    Large {
        /// Name of the input.
        input: String,
        /// Shape of the input.
        sizes: Vec<i64>,
    },
    /// The description gives the first numbers of a state that the network does not have.
    #[error("has no state `{name}` to begin with; its states are {}", if known.is_empty() { "none".into() } else { known.join(", ") })]
    Unknown {
        /// Name in the description.
        name: String,
        /// Names of the states' inputs.
        known: Vec<String>,
    },
    /// The first numbers of a state do not fit it.
    #[error(
        "its description begins `{input}` with {given} numbers; allowed: {numbers} finite numbers, one for each of the state"
    )]
    Initial {
        /// Name of the state's input.
        input: String,
        /// Number of given numbers.
        given: usize,
        /// Number of the state's numbers.
        numbers: usize,
    },
}
