//! Sizes of a network's tensors. In: the network as parsed by the runtime, with the shape of its input. Out: nothing, with all shapes
//! known, or the node that is too large. The runtime evaluates constants as soon as it knows them. Here each node's result shape is
//! inferred and checked first, and only then are its values inferred.

use super::{
    NodeFault, RunFault, RuntimeFault,
    limits::{MOST_DIMENSIONS, MOST_ELEMENTS, MOST_ELEMENTS_IN_ALL, MOST_WHOLE_NUMBERS, MOST_WORK},
};
use crate::foreign::guarded;
use tract_onnx::{
    prelude::*,
    tract_hir::infer::{Factoid, InferenceFact, InferenceModel},
};

/// Passes over the nodes; facts that a later node adds about an earlier one are used in the next pass.
const PASSES: usize = 3;

/// Infers the shape of every tensor, in the order of the file.
///
/// # Errors
/// A tensor or the whole network is too large, or a size is negative or cannot be inferred.
pub fn check(model: &mut InferenceModel) -> Result<(), RunFault> {
    let mut left = None;
    for _ in 0..PASSES {
        left = None;
        let (mut elements, mut work) = (0, 0.0);
        for id in 0..model.nodes().len() {
            let title = format!("`{}` ({})", model.node(id).name, model.node(id).op.name());
            let fault = |fault: NodeFault| RunFault::Node { title: title.clone(), fault };
            let shaped = guarded(|| infer_facts(model, id)).map_err(|panic| RuntimeFault::BrokeOff(panic).into());
            if !shaped.and_then(|is_inferred| is_inferred).map_err(fault)? {
                left = Some(title);
                continue;
            }
            for outlet in 0..model.node(id).outputs.len() {
                elements +=
                    shape_of(&model.node(id).outputs[outlet].fact).map_err(fault)?.iter().flatten().product::<usize>();
            }
            work += work_of(model, id);
            if elements > MOST_ELEMENTS_IN_ALL {
                return Err(fault(NodeFault::Elements(elements)));
            }
            if work > MOST_WORK {
                return Err(fault(NodeFault::Work(work)));
            }
        }
        if left.is_none() {
            return Ok(());
        }
    }
    left.map_or(Ok(()), |title| Err(RunFault::Node { title, fault: NodeFault::Unsized }))
}

/// Tensors around a node: its inputs, its outputs and those that it observes.
struct NodeTensors {
    takes: Vec<OutletId>,
    gives: Vec<OutletId>,
    looks_at: Vec<OutletId>,
}

impl NodeTensors {
    fn new(model: &InferenceModel, id: usize) -> TractResult<Self> {
        let node = model.node(id);
        let gives = (0..node.outputs.len()).map(|slot| OutletId::new(id, slot)).collect();
        Ok(Self { takes: node.inputs.to_vec(), gives, looks_at: node.op.observe_outlets(model, node)? })
    }
}

fn facts(model: &InferenceModel, outlets: &[OutletId]) -> TractResult<Vec<InferenceFact>> {
    outlets.iter().map(|outlet| model.outlet_fact(*outlet).cloned()).collect()
}

/// Infers the facts of the tensors around a node, result shapes first. Returns false if a result shape is not known yet.
fn infer_facts(model: &mut InferenceModel, id: usize) -> Result<bool, NodeFault> {
    let error = RuntimeFault::Refused;
    let tensors = NodeTensors::new(model, id).map_err(error)?;
    let takes = facts(model, &tensors.takes).map_err(error)?;
    let gives = facts(model, &tensors.gives).map_err(error)?;
    let looks_at = facts(model, &tensors.looks_at).map_err(error)?;
    let op = &mut model.node_mut(id).op;
    let shapes =
        op.infer_facts(takes.iter().collect(), gives.iter().collect(), looks_at.iter().collect()).map_err(error)?.1;
    for fact in &shapes {
        if shape_of(fact)?.is_none() {
            return Ok(false);
        }
    }
    let (takes, gives, _) =
        op.infer(takes.iter().collect(), gives.iter().collect(), looks_at.iter().collect()).map_err(error)?;
    for (outlet, fact) in tensors.takes.iter().zip(&takes).chain(tensors.gives.iter().zip(&gives)) {
        let known = model.outlet_fact(*outlet).and_then(|known| known.unify(fact)).map_err(error)?;
        model.set_outlet_fact(*outlet, known).map_err(error)?;
    }
    Ok(true)
}

/// Returns the shape of a tensor, if it is known.
fn shape_of(fact: &InferenceFact) -> Result<Option<Vec<usize>>, NodeFault> {
    let Some(dims) = fact.shape.concretize() else { return Ok(None) };
    let Some(sizes) = dims.iter().map(TDim::as_i64).collect::<Option<Vec<i64>>>() else { return Ok(None) };
    if sizes.len() > MOST_DIMENSIONS {
        return Err(NodeFault::Dimensions(sizes.len()));
    }
    let n = sizes.iter().try_fold(1usize, |n, &size| n.checked_mul(usize::try_from(size).ok()?));
    // If one size is 0, the others could still be of any size.
    let Some(n) = n.filter(|n| *n <= MOST_ELEMENTS && sizes.iter().all(|size| *size <= MOST_ELEMENTS as i64)) else {
        return Err(NodeFault::Shape(sizes));
    };
    let kind = fact.datum_type.concretize();
    if n > MOST_WHOLE_NUMBERS && kind.is_some_and(|kind| kind.is_tdim() || kind == i64::datum_type()) {
        return Err(NodeFault::WholeNumbers(n));
    }
    Ok(Some(sizes.into_iter().map(|size| size as usize).collect()))
}

/// Estimates the number of multiplications of a node, without a large underestimate.
fn work_of(model: &InferenceModel, id: usize) -> f64 {
    let Ok((inputs, outputs)) = model.node_facts(id) else { return 0.0 };
    let known = |facts: &[&InferenceFact]| -> Vec<Vec<usize>> {
        facts.iter().map(|fact| shape_of(fact).ok().flatten().unwrap_or_default()).collect()
    };
    let (inputs, outputs) = (known(&inputs), known(&outputs));
    let numbers = |shape: &Vec<usize>| shape.iter().product::<usize>() as f64;
    let touched: f64 = inputs.iter().chain(&outputs).map(numbers).sum();
    let name = model.node(id).op.name().into_owned();
    touched
        + match (inputs.as_slice(), outputs.as_slice()) {
            // [m, k] times [k, n] takes m k n multiplications, the square root of the product of the three sizes.
            ([a, b, ..], [c, ..]) if ["Gemm", "MatMul"].iter().any(|known| name.contains(known)) => {
                (numbers(a) * numbers(b) * numbers(c)).sqrt()
            }
            // Each element of the result uses the weights of its channel.
            ([_, weights, ..], [c, ..]) if name.contains("Conv") => {
                numbers(c) * numbers(weights) / weights.first().copied().unwrap_or(1).max(1) as f64
            }
            // Each row at each time step uses all weights.
            ([rows, weights @ ..], _) if ["LSTM", "GRU", "RNN"].iter().any(|known| name.contains(known)) => {
                let moments: usize = rows.iter().take(2).product();
                moments as f64 * weights.iter().map(numbers).sum::<f64>()
            }
            _ => 0.0,
        }
}
