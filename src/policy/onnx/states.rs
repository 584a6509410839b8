//! States of a recurrent network: inputs `state_in_NAME` that take what the outputs `state_out_NAME` gave at the decision before. In: the
//! graph and its description. Out: the states with their shapes and what they hold at the first decision.

use super::{
    NetworkDescription, PortFault, StateFault,
    inputs::{check_kind, declared, tensor},
    limits::MOST_STATE_NUMBERS,
};
use tract_onnx::pb::GraphProto;

/// Beginnings of the names of a state's input and output.
pub(super) const STATE_IN: &str = "state_in_";
pub(super) const STATE_OUT: &str = "state_out_";

/// State of a network, which belongs to one vehicle in one drive.
#[derive(Clone, Debug)]
pub(super) struct NetworkState {
    /// Names of its input and its output.
    pub input: String,
    pub output: String,
    pub shape: Vec<usize>,
    /// Numbers at the first decision of a drive.
    pub initial: Vec<f32>,
}

/// Returns true if the graph has an input for a state.
pub(super) fn has_states(graph: &GraphProto) -> bool {
    graph.input.iter().any(|input| input.name.starts_with(STATE_IN))
}

/// Returns the states in the order of their inputs.
///
/// # Errors
/// A state has no output, is no tensor of floating-point numbers or is too large; or the description gives numbers that do not fit.
pub(super) fn states(graph: &GraphProto, description: &NetworkDescription) -> Result<Vec<NetworkState>, PortFault> {
    let mut states = Vec::new();
    for input in graph.input.iter().filter(|input| input.name.starts_with(STATE_IN)) {
        let output = input.name.replacen(STATE_IN, STATE_OUT, 1);
        if !graph.output.iter().any(|value| value.name == output) {
            return Err(StateFault::NotReturned { input: input.name.clone(), output }.into());
        }
        check_kind(input)?;
        let sizes: Vec<i64> = declared(tensor(input)?).into_iter().map(|size| size.unwrap_or(1)).collect();
        let shape: Vec<usize> = sizes.iter().map(|size| *size as usize).collect();
        let numbers = shape.iter().try_fold(1usize, |n, size| n.checked_mul(*size));
        let Some(numbers) = numbers.filter(|n| *n <= MOST_STATE_NUMBERS) else {
            return Err(StateFault::Large { input: input.name.clone(), sizes }.into());
        };
        let initial = initial(&input.name, numbers, description)?;
        states.push(NetworkState { input: input.name.clone(), output, shape, initial });
    }
    match description.initial_state.keys().find(|name| !states.iter().any(|state| state.input == **name)) {
        Some(name) => {
            let known = states.into_iter().map(|state| state.input).collect();
            Err(StateFault::Unknown { name: name.clone(), known }.into())
        }
        None => Ok(states),
    }
}

/// Returns the numbers that a state holds at the first decision: zeros unless the description says otherwise.
fn initial(input: &str, numbers: usize, description: &NetworkDescription) -> Result<Vec<f32>, StateFault> {
    match description.initial_state.get(input) {
        None => Ok(vec![0.0; numbers]),
        Some(given) if given.len() == numbers && given.iter().all(|x| x.is_finite()) => Ok(given.clone()),
        Some(given) => Err(StateFault::Initial { input: input.into(), given: given.len(), numbers }),
    }
}
