//! An ONNX file as a policy. In: the path. Out: a policy that has been tested on some hundred random observations and gave a number for
//! each. Networks with any batch size load; one row is evaluated at a time.

use super::{
    AnswerFault, METADATA_KEY, NetworkDescription, OnnxFault, OutputMeaning, RunFault, RuntimeFault, external,
    inputs::{self, Ports},
    limits::{MOST_BYTES, OPERATOR_SETS},
    sizes,
    states::NetworkState,
    structure, wire,
};
use crate::{
    file::{SETTINGS_BYTES, read_bounded, read_text},
    foreign::guarded,
    policy::{
        Action, AssistedPolicy, NetworkInput, NetworkOutput, Observation, Policy, PolicyFileError, PolicyFileFault,
        RoadKind, bounded, features::withholds_advice, needs::lacked,
    },
    rng,
    toml_text::did_you_mean_file,
};
use prost::Message;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};
use tract_onnx::{
    pb::{ModelProto, TensorProto, tensor_proto::DataType},
    prelude::*,
};

/// Number of random observations for which every network must give finite numbers before it drives.
const QUESTIONS: usize = 200;

/// An ONNX network from any program, as a policy.
#[derive(Clone)]
pub struct OnnxPolicy {
    description: NetworkDescription,
    plan: Arc<TypedRunnableModel>,
    /// Shapes of the inputs for one observation: one input for all numbers, or one for each.
    shapes: Vec<Vec<usize>>,
    states: Arc<[NetworkState]>,
    /// Present numbers of the states of one vehicle in one drive.
    held: Vec<Vec<f32>>,
}

/// Raw outputs of one decision, and the states for the next one.
type Decided = (Vec<f32>, Vec<Vec<f32>>);

impl OnnxPolicy {
    /// Reads a file and its description.
    ///
    /// # Errors
    /// The file cannot be read, is no ONNX file, has no description, exceeds `limits`, has unsuitable shapes or operators, or gives an
    /// output that is not finite.
    pub fn from_file(path: &Path) -> Result<Self, PolicyFileError> {
        let fault = |fault: PolicyFileFault| PolicyFileError { path: path.display().to_string(), fault: fault.into() };
        let bytes = read_bounded(path, MOST_BYTES)
            .map_err(|source| fault(PolicyFileFault::Unreadable { source, near: did_you_mean_file(path) }))?;
        let beside = description_of(path);
        let text = match read_text(&beside, SETTINGS_BYTES) {
            Ok(text) => Some(text),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => None,
            Err(source) => return Err(fault(PolicyFileFault::UnreadableDescription { file: beside, source })),
        };
        Self::from_parts(&bytes, text.as_deref(), path.parent()).map_err(|why| fault(why.into()))
    }

    /// Returns a newly engaged policy with steps of `step_s` seconds.
    pub fn engaged(&self, step_s: f64) -> Box<dyn Policy> {
        let policy = Box::new(self.clone().at_first_decision());
        let (corrected, gain) = (self.description.corrected.clone(), self.description.expected_gain.clone());
        let probe = self.description.probe;
        match (&corrected, &probe, &gain) {
            (None, None, None) => policy,
            _ => Box::new(AssistedPolicy::new(policy, None, corrected, probe, gain, step_s)),
        }
    }

    /// Returns the reason that the policy cannot advise on this kind of road, in words that follow "it"; `None` if it can.
    pub fn lacks(&self, road: RoadKind) -> Option<String> {
        let d = &self.description;
        lacked(&d.inputs, d.least_spacing_m, d.corrected.as_ref(), d.expected_gain.as_ref(), road)
    }

    /// Returns the existing files of the policy: the network, its description, and weights beside it.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        let mut files = vec![path.to_owned(), description_of(path)];
        files.retain(|file| file.is_file());
        let bytes = read_bounded(path, MOST_BYTES).ok().filter(|bytes| wire::check(bytes).is_ok());
        let model = bytes.and_then(|bytes| ModelProto::decode(bytes.as_slice()).ok());
        files.extend(model.iter().flat_map(|model| external::files(model, path.parent().unwrap_or(Path::new("")))));
        files
    }

    /// Reads a network from bytes; `description` takes precedence over the metadata.
    ///
    /// # Errors
    /// The errors of [`OnnxPolicy::from_file`], and weights in another file.
    pub fn from_bytes(bytes: &[u8], description: Option<&str>) -> Result<Self, OnnxFault> {
        Self::from_parts(bytes, description, None)
    }

    /// Reads a network from bytes; weights may lie in other files of `folder`.
    fn from_parts(bytes: &[u8], description: Option<&str>, folder: Option<&Path>) -> Result<Self, OnnxFault> {
        wire::check(bytes)?;
        let mut model = ModelProto::decode(bytes).map_err(OnnxFault::Foreign)?;
        if model.graph.is_none() {
            return Err(OnnxFault::Empty);
        }
        let metadata = model.metadata_props.iter().find(|entry| entry.key == METADATA_KEY);
        let text = description.or(metadata.map(|entry| entry.value.as_str())).ok_or(OnnxFault::NotDescribed)?;
        let description = NetworkDescription::from_toml(text)?;
        let versions = || model.opset_import.iter().filter(|set| set.domain.is_empty() || set.domain == "ai.onnx");
        if let Some(set) = versions().find(|set| !OPERATOR_SETS.contains(&set.version)) {
            return Err(OnnxFault::OperatorSet(set.version));
        }
        if let Some(folder) = folder {
            external::inline(&mut model, folder)?;
        }
        let graph = model.graph.as_ref().ok_or(OnnxFault::Empty)?;
        structure::check(&model, graph)?;
        let graph = model.graph.as_mut().ok_or(OnnxFault::Empty)?;
        let Ports { observed: shapes, states } = inputs::prepare(graph, &description)?;
        // The runtime's tanh turns a NaN into a number, so that test observations alone would not find it.
        if let Some(tensor) = graph.initializer.iter().find(|tensor| holds_nan(tensor)) {
            return Err(OnnxFault::NanWeights(tensor.name.clone()));
        }
        let all: Vec<&Vec<usize>> = shapes.iter().chain(states.iter().map(|state| &state.shape)).collect();
        let plan = runnable(&model, &all).map_err(OnnxFault::Run)?;
        Self { description, plan, shapes, states: states.into(), held: Vec::new() }.at_first_decision().questioned()
    }

    /// Returns the policy with its states as at the first decision of a drive.
    fn at_first_decision(self) -> Self {
        Self { held: self.initial(), ..self }
    }

    /// Returns the states at the first decision of a drive.
    fn initial(&self) -> Vec<Vec<f32>> {
        self.states.iter().map(|state| state.initial.clone()).collect()
    }

    /// Returns the raw outputs for scaled inputs at the first decision of a drive.
    ///
    /// # Errors
    /// The runtime failed.
    pub fn outputs(&self, seen: &[f32]) -> Result<Vec<f32>, RuntimeFault> {
        self.decided(seen, &self.initial()).map(|(outputs, _)| outputs)
    }

    /// Returns the raw outputs for scaled inputs and states, and the next states.
    fn decided(&self, seen: &[f32], held: &[Vec<f32>]) -> Result<Decided, RuntimeFault> {
        let numbers = |tensor: &Tensor| -> TractResult<Vec<f32>> {
            let numbers = tensor.cast_to::<f32>()?;
            Ok(numbers.to_plain_array_view::<f32>()?.iter().copied().collect())
        };
        let run = || -> TractResult<Decided> {
            let mut left = seen;
            let mut inputs = TVec::new();
            for shape in &self.shapes {
                let (these, others) = left.split_at(shape.iter().product());
                left = others;
                inputs.push(Tensor::from_shape(shape, these)?.into());
            }
            for (state, held) in self.states.iter().zip(held) {
                inputs.push(Tensor::from_shape(&state.shape, held)?.into());
            }
            let out = self.plan.run(inputs)?;
            let states = out[1..].iter().map(|tensor| numbers(tensor)).collect::<TractResult<_>>()?;
            Ok((numbers(&out[0])?, states))
        };
        // An index computed by the network may be out of bounds, and the runtime panics on it.
        guarded(run).map_err(RuntimeFault::BrokeOff)?.map_err(RuntimeFault::Refused)
    }

    /// Returns the scaled inputs for an observation, with the hold clamped to the range of training.
    pub fn seen(&self, observation: &Observation) -> Vec<f32> {
        let [shortest, longest] = self.description.holds_s;
        let observation = Observation { hold_s: observation.hold_s.clamp(shortest, longest), ..*observation };
        self.description.inputs.iter().map(|input| input.scaled(&observation)).collect()
    }

    /// Converts outputs into an action; not finite if the output is not.
    fn action(&self, outputs: &[f32], hold_s: f64) -> Action {
        let d = &self.description;
        let [low, high] = match d.action {
            NetworkOutput::Acceleration => bounded(d.limits, d.speed_change_mps, hold_s),
            NetworkOutput::Speed => d.limits,
        };
        let first = f64::from(outputs.get(d.element.unwrap_or(0)).copied().unwrap_or(f32::NAN));
        let value = match d.output {
            OutputMeaning::Scaled => low + (high - low) * (first.clamp(-1.0, 1.0) + 1.0) / 2.0,
            OutputMeaning::Si => first.clamp(low, high),
            OutputMeaning::Levels if outputs.iter().any(|x| x.is_nan()) => f64::NAN,
            OutputMeaning::Levels => {
                let best = (0..outputs.len()).fold(0, |best, i| if outputs[i] > outputs[best] { i } else { best });
                low + (high - low) * best as f64 / (outputs.len() - 1) as f64
            }
        };
        match d.action {
            NetworkOutput::Acceleration => Action::Acceleration(value),
            NetworkOutput::Speed => Action::Speed(value),
        }
    }

    /// Checks that the outputs are finite and have the right count for random observations, one after the other as in a drive.
    fn questioned(self) -> Result<Self, OnnxFault> {
        let mut stream = rng::stream(1, "questions");
        let mut held = self.initial();
        for i in 0..QUESTIONS {
            // The first observation is the middle of all ranges; the others lie in the ranges and slightly beyond.
            let draw = |_| if i == 0 { 0.0 } else { stream.uniform(-1.2, 1.2) as f32 };
            let seen: Vec<f32> = (0..self.description.inputs.len()).map(draw).collect();
            let (outputs, next) = self.decided(&seen, &held).map_err(|fault| OnnxFault::Run(fault.into()))?;
            self.counted(outputs.len())?;
            self.states.iter().zip(&next).try_for_each(|(state, next)| check_state(state, next))?;
            held = next;
            if let Some(&answer) = outputs.iter().find(|x| !x.is_finite()) {
                return Err(AnswerFault::NotFinite { seen, answer }.into());
            }
        }
        Ok(self)
    }

    fn counted(&self, n: usize) -> Result<(), AnswerFault> {
        match (self.description.output, self.description.element) {
            (OutputMeaning::Levels, _) if n < 2 => Err(AnswerFault::FewLevels(n)),
            (OutputMeaning::Levels, _) => Ok(()),
            (_, Some(element)) if element >= n => Err(AnswerFault::NoElement { numbers: n, element }),
            (_, None) if n != 1 => Err(AnswerFault::Several(n)),
            _ => Ok(()),
        }
    }
}

/// Checks that the next numbers of a state fit its input.
fn check_state(state: &NetworkState, next: &[f32]) -> Result<(), AnswerFault> {
    let numbers = state.initial.len();
    let fault = |given: String| Err(AnswerFault::State { output: state.output.clone(), given, numbers });
    match next.iter().find(|x| !x.is_finite()) {
        _ if next.len() != numbers => fault(format!("{} numbers", next.len())),
        Some(wrong) => fault(wrong.to_string()),
        None => Ok(()),
    }
}

/// Returns the path of a network's description file.
fn description_of(path: &Path) -> PathBuf {
    path.with_extension("onnx.toml")
}

/// Returns true if the weights are 32-bit floats and one of them is NaN.
fn holds_nan(tensor: &TensorProto) -> bool {
    let raw = tensor.raw_data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    tensor.data_type == i32::from(DataType::Float) && tensor.float_data.iter().copied().chain(raw).any(f32::is_nan)
}

/// Builds the optimised network with fixed shapes.
fn runnable(model: &ModelProto, shapes: &[&Vec<usize>]) -> Result<Arc<TypedRunnableModel>, RunFault> {
    // PyTorch's exports with a dynamic batch declare shapes that contradict the fixed one.
    let reader = tract_onnx::onnx().with_ignore_value_info(true).with_ignore_output_shapes(true);
    let build = || -> Result<Arc<TypedRunnableModel>, RunFault> {
        let mut parsed = reader.model_for_proto_model(model).map_err(RuntimeFault::Refused)?;
        for (i, shape) in shapes.iter().enumerate() {
            parsed.set_input_fact(i, f32::fact(*shape).into()).map_err(RuntimeFault::Refused)?;
        }
        sizes::check(&mut parsed)?;
        let network = parsed.into_optimized().and_then(|network| network.into_runnable());
        Ok(network.map_err(RuntimeFault::Refused)?)
    };
    // The structure has been checked, but not each attribute of each operator.
    guarded(build).map_err(RuntimeFault::BrokeOff)?
}

impl Policy for OnnxPolicy {
    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        let outputs = match self.decided(&self.seen(observation), &self.held) {
            Ok((outputs, next)) => {
                self.held = next;
                outputs
            }
            Err(_) => Vec::new(),
        };
        self.action(&outputs, observation.hold_s)
    }

    fn abstains(&mut self, _time_s: f64, observation: &Observation) -> bool {
        withholds_advice(observation, self.description.least_spacing_m)
    }

    fn needs_driver_traits(&self) -> bool {
        self.description.inputs.iter().any(|input| input.feature.is_of_driver())
    }

    fn inputs(&self) -> &[NetworkInput] {
        &self.description.inputs
    }

    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        Some(self.description.holds_s)
    }

    fn advised_share(&self) -> f64 {
        self.description.advised_share
    }
}
