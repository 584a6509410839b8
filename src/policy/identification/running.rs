//! A running estimator for one driver. In: an [`Observation`] each step. Out: a [`WhoDrives`] once a second.

use super::{
    DriverEstimator, INPUTS_WITH_OBSERVED, Recurrent, SAMPLE_NUMBERS, SAMPLE_S, SAMPLES, WhoDrives, observed_inputs,
    sample,
};
use crate::policy::Observation;

/// A running estimator for one driver.
#[derive(Clone, Debug, PartialEq)]
pub struct Identification {
    estimator: DriverEstimator,
    steps: u64,
    inputs: Vec<f32>,
    unit: Recurrent,
    read: Vec<f32>,
    who_drives: WhoDrives,
}

impl Identification {
    /// Returns an estimator that knows only the average of all drivers.
    pub fn new(estimator: DriverEstimator) -> Self {
        let unit = estimator.begin();
        let read = estimator.read(unit.state());
        let who_drives = estimator.of_readout(&read);
        Self { estimator, steps: 0, inputs: Vec::with_capacity(INPUTS_WITH_OBSERVED), unit, read, who_drives }
    }

    /// Observes one step of `step_s` seconds.
    pub fn watch(&mut self, seen: &Observation, step_s: f64) {
        let every = (SAMPLE_S / step_s).round().max(1.0) as u64;
        let is_due = self.steps > 0 && self.steps.is_multiple_of(every);
        self.steps += 1;
        if !is_due {
            return;
        }
        let advised = seen.advised_mps.map(|advised| advised as f32);
        self.inputs.extend(sample(seen.speed_mps as f32, seen.leader_speed_mps as f32, seen.gap_m as f32, advised));
        if self.inputs.len() < SAMPLE_NUMBERS * SAMPLES {
            return;
        }
        self.inputs.push(f32::from(u8::from(advised.is_some())));
        if self.estimator.observes_driver() {
            let [reaction_s, time_gap_factor] = [seen.observed.reaction_s, seen.observed.time_gap_factor];
            self.inputs.extend(observed_inputs(reaction_s as f32, time_gap_factor as f32));
        }
        self.estimator.step(&self.inputs, &mut self.unit);
        self.inputs.clear();
        self.estimator.read_into(self.unit.state(), &mut self.read);
        self.who_drives = self.estimator.of_readout(&self.read);
    }

    /// Returns true if the estimator needs the driver as observed.
    pub fn observes_driver(&self) -> bool {
        self.estimator.observes_driver()
    }

    /// Returns the current estimate.
    pub fn who_drives(&self) -> WhoDrives {
        self.who_drives
    }
}
