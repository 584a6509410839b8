//! An ONNX file as a policy. In: the path. Out: a policy that has been asked some hundred questions and has answered each
//! with a number. Batches of any size load; one row is run at a time.

use super::{
    AnswerFault, METADATA_KEY, NetworkDescription, OnnxFault, OutputMeaning, RunFault, RuntimeFault, external, inputs,
    limits, sizes, wire,
};
use crate::{
    file::{SETTINGS_BYTES, read_bounded, read_text},
    foreign::guarded,
    policy::{
        Action, AssistedPolicy, NetworkOutput, Observation, Policy, PolicyFileError, PolicyFileFault, RoadKind,
        bounded, observe::withholds_advice, road_ahead::lacked,
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

/// Operator sets that the runtime knows.
pub(super) const OPERATOR_SETS: std::ops::RangeInclusive<i64> = 7..=23;
/// Observations that every network must answer with finite numbers before it drives.
const QUESTIONS: usize = 200;

/// A network of any origin.
#[derive(Clone)]
pub struct OnnxPolicy {
    description: NetworkDescription,
    plan: Arc<TypedRunnableModel>,
    /// Shapes of its inputs for one observation: one with all numbers, or one for each.
    shapes: Vec<Vec<usize>>,
}

impl OnnxPolicy {
    /// Reads a file and its description.
    ///
    /// # Errors
    /// The file cannot be read, is no ONNX, has no description, its shapes or operators do not fit, it is larger than
    /// `limits` allows, or it answers with something that is no number.
    pub fn from_file(path: &Path) -> Result<Self, PolicyFileError> {
        let fault = |fault: PolicyFileFault| PolicyFileError { path: path.display().to_string(), fault: fault.into() };
        let bytes = read_bounded(path, limits::MOST_BYTES)
            .map_err(|source| fault(PolicyFileFault::Unreadable { source, near: did_you_mean_file(path) }))?;
        let beside = description_of(path);
        let text = match read_text(&beside, SETTINGS_BYTES) {
            Ok(text) => Some(text),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => None,
            Err(source) => return Err(fault(PolicyFileFault::UnreadableDescription { file: beside, source })),
        };
        Self::from_parts(&bytes, text.as_deref(), path.parent()).map_err(|why| fault(why.into()))
    }

    /// A policy that is asked each `step_s` seconds, engaged now.
    pub fn engaged(&self, step_s: f64) -> Box<dyn Policy> {
        let policy = Box::new(self.clone());
        let (corrected, gain) = (self.description.corrected.clone(), self.description.expected_gain.clone());
        match (&corrected, &gain) {
            (None, None) => policy,
            _ => Box::new(AssistedPolicy::new(policy, None, corrected, gain, step_s)),
        }
    }

    /// Why it cannot advise on this kind of road, in words that follow "it"; `None` where it can.
    pub fn lacks(&self, road: RoadKind) -> Option<String> {
        let d = &self.description;
        lacked(&d.inputs, d.least_spacing_m, d.corrected.as_ref(), d.expected_gain.as_ref(), road)
    }

    /// The files that make it: the network, its description and its weights, as far as they lie beside it.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        let mut files = vec![path.to_owned(), description_of(path)];
        files.retain(|file| file.is_file());
        let bytes = read_bounded(path, limits::MOST_BYTES).ok().filter(|bytes| wire::check(bytes).is_ok());
        let model = bytes.and_then(|bytes| ModelProto::decode(bytes.as_slice()).ok());
        files.extend(model.iter().flat_map(|model| external::files(model, path.parent().unwrap_or(Path::new("")))));
        files
    }

    /// The same for bytes; `description` wins over the metadata.
    ///
    /// # Errors
    /// As [`OnnxPolicy::from_file`], and weights that lie in another file.
    pub fn from_bytes(bytes: &[u8], description: Option<&str>) -> Result<Self, OnnxFault> {
        Self::from_parts(bytes, description, None)
    }

    /// The same; weights may lie in other files of `folder`.
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
        limits::check(&model, graph)?;
        let graph = model.graph.as_mut().ok_or(OnnxFault::Empty)?;
        let shapes = inputs::prepare(graph, &description)?;
        // The runtime's tanh takes a NaN for a number, so that questions alone would not find it.
        if let Some(tensor) = graph.initializer.iter().find(|tensor| holds_nan(tensor)) {
            return Err(OnnxFault::NanWeights(tensor.name.clone()));
        }
        let plan = runnable(&model, &shapes).map_err(OnnxFault::Run)?;
        Self { description, plan, shapes }.questioned()
    }

    /// The raw output for what the network sees.
    ///
    /// # Errors
    /// The runtime failed.
    pub fn outputs(&self, seen: &[f32]) -> Result<Vec<f32>, RuntimeFault> {
        let run = || -> TractResult<Vec<f32>> {
            let mut left = seen;
            let mut inputs = TVec::new();
            for shape in &self.shapes {
                let (these, others) = left.split_at(shape.iter().product());
                left = others;
                inputs.push(Tensor::from_shape(shape, these)?.into());
            }
            let out = self.plan.run(inputs)?;
            let numbers = out[0].cast_to::<f32>()?;
            Ok(numbers.to_plain_array_view::<f32>()?.iter().copied().collect())
        };
        // An index that the network reckons may lie outside of a table, which the runtime does not expect.
        guarded(run).map_err(RuntimeFault::BrokeOff)?.map_err(RuntimeFault::Refused)
    }

    /// What the network sees of an observation.
    pub fn seen(&self, observation: &Observation) -> Vec<f32> {
        let [shortest, longest] = self.description.holds_s;
        let observation = Observation { hold_s: observation.hold_s.clamp(shortest, longest), ..*observation };
        self.description.inputs.iter().map(|input| input.scaled(&observation)).collect()
    }

    /// The action of an output; not finite where the output is not.
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

    /// Asks questions; a network that cannot answer them does not drive.
    fn questioned(self) -> Result<Self, OnnxFault> {
        let mut stream = rng::stream(1, "questions");
        for i in 0..QUESTIONS {
            // The first is the middle of everything; the others lie in and a little around the range.
            let draw = |_| if i == 0 { 0.0 } else { stream.uniform(-1.2, 1.2) as f32 };
            let seen: Vec<f32> = (0..self.description.inputs.len()).map(draw).collect();
            let outputs = self.outputs(&seen).map_err(|fault| OnnxFault::Run(fault.into()))?;
            self.counted(outputs.len())?;
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

/// Where the description of a network lies.
fn description_of(path: &Path) -> PathBuf {
    path.with_extension("onnx.toml")
}

/// True if the weights are 32-bit numbers and one of them is none.
fn holds_nan(tensor: &TensorProto) -> bool {
    let raw = tensor.raw_data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    tensor.data_type == i32::from(DataType::Float) && tensor.float_data.iter().copied().chain(raw).any(f32::is_nan)
}

/// The network with its shapes fixed, made fast.
fn runnable(model: &ModelProto, shapes: &[Vec<usize>]) -> Result<Arc<TypedRunnableModel>, RunFault> {
    // PyTorch's exports with a dynamic batch declare shapes that contradict the fixed one.
    let reader = tract_onnx::onnx().with_ignore_value_info(true).with_ignore_output_shapes(true);
    let build = || -> Result<Arc<TypedRunnableModel>, RunFault> {
        let mut parsed = reader.model_for_proto_model(model).map_err(RuntimeFault::Refused)?;
        for (i, shape) in shapes.iter().enumerate() {
            parsed.set_input_fact(i, f32::fact(shape).into()).map_err(RuntimeFault::Refused)?;
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
        let outputs = self.outputs(&self.seen(observation)).unwrap_or_default();
        self.action(&outputs, observation.hold_s)
    }

    fn abstains(&mut self, _time_s: f64, observation: &Observation) -> bool {
        withholds_advice(observation, self.description.least_spacing_m)
    }

    fn must_be_told_who_drives(&self) -> bool {
        self.description.inputs.iter().any(|input| input.feature.is_of_driver())
    }

    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        Some(self.description.holds_s)
    }
}
