//! The student beside a block of rings: it observes each driver second by second and estimates their traits or latents. In: samples of
//! the block and the drivers' true traits. Out: estimates, and the [`Seconds`] for training.

use super::{
    estimator_learner::EstimatorLearner,
    gru::GruShape,
    seconds::{BlockSample, Seconds},
};
use crate::{
    policy::{
        DriverEstimator, DriverTraits, WhoDrives,
        identification::{INPUTS_WITH_OBSERVED, SAMPLE_NUMBERS, SAMPLES, observed_inputs, sample},
    },
    train::simd::LANES,
};
use serde::{Deserialize, Serialize};

/// The student beside one block.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Watcher {
    estimator: DriverEstimator,
    shape: (usize, usize, usize),
    theta: Vec<f32>,
    state: Vec<f32>,
    read: Vec<f32>,
    partial: Vec<BlockSample>,
    begins: [bool; LANES],
}

impl Watcher {
    /// Returns a student with the current parameters of `learner` and no estimate of these drivers.
    pub fn new(learner: &EstimatorLearner) -> Self {
        let GruShape { inputs, units, outputs } = learner.shape();
        let mut watcher = Self {
            estimator: learner.estimator(),
            shape: (inputs, units, outputs),
            theta: learner.theta().to_vec(),
            state: vec![0.0; LANES * units],
            read: Vec::new(),
            partial: Vec::new(),
            begins: [true; LANES],
        };
        watcher.reread();
        watcher
    }

    /// Takes over the learner's new parameters and keeps the states of the drivers.
    pub fn learn(&mut self, learner: &EstimatorLearner) {
        self.estimator = learner.estimator();
        learner.theta().clone_into(&mut self.theta);
        self.reread();
    }

    fn shape(&self) -> GruShape {
        let (inputs, units, outputs) = self.shape;
        GruShape { inputs, units, outputs }
    }

    /// Recomputes the readout of the current states.
    fn reread(&mut self) {
        let units = self.shape.1;
        let of = |l: usize| self.estimator.read(&self.state[l * units..][..units]);
        self.read = (0..LANES).flat_map(of).collect();
    }

    /// Returns the estimate of the driver on ring `l`.
    pub fn who_drives(&self, l: usize) -> WhoDrives {
        let outputs = self.shape.2;
        self.estimator.of_readout(&self.read[l * outputs..][..outputs])
    }

    /// Resets ring `l` for a new driver.
    pub fn begin(&mut self, l: usize) {
        let (_, units, outputs) = self.shape;
        let state = &mut self.state[l * units..][..units];
        state.fill(0.0);
        self.begins[l] = true;
        self.estimator.read_into(state, &mut self.read[l * outputs..][..outputs]);
        // Clears the previous driver's samples of the second in progress.
        for sample in &mut self.partial {
            sample.iter_mut().for_each(|numbers| numbers[l] = 0.0);
        }
    }

    /// Adds samples, one per [`crate::policy::identification::SAMPLE_S`]; completed seconds are appended to `log`.
    pub fn watch(&mut self, samples: &[BlockSample], truths: &[DriverTraits; LANES], log: Option<&mut Seconds>) {
        let mut log = log;
        for sample in samples {
            self.partial.push(*sample);
            if self.partial.len() == SAMPLES {
                let inputs = self.inputs();
                if let Some(log) = log.as_deref_mut() {
                    if log.inputs.is_empty() {
                        log.state.clone_from(&self.state);
                    }
                    log.inputs.push(inputs.clone());
                    log.begins.push(self.begins.to_vec());
                    log.truths.push(*truths);
                }
                let step = self.shape().step(&self.theta, &inputs, &self.state);
                (self.state, self.read) = (step.state, step.read);
                self.begins = [false; LANES];
                self.partial.clear();
            }
        }
    }

    /// Returns the inputs of the second just completed, one row per ring.
    fn inputs(&self) -> Vec<f32> {
        let mut inputs = Vec::with_capacity(LANES * INPUTS_WITH_OBSERVED);
        for l in 0..LANES {
            for [speed, leader, gap, advised, ..] in &self.partial {
                let numbers: [f32; SAMPLE_NUMBERS] =
                    sample(speed[l], leader[l], gap[l], (advised[l] >= 0.0).then_some(advised[l]));
                inputs.extend(numbers);
            }
            if let Some([.., advised, reaction_s, time_gap_factor]) = self.partial.last() {
                inputs.push(f32::from(u8::from(advised[l] >= 0.0)));
                if self.estimator.observes_driver() {
                    inputs.extend(observed_inputs(reaction_s[l], time_gap_factor[l]));
                }
            }
        }
        inputs
    }
}
