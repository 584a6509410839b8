//! Who drives, told from what was advised and what was done. In: an [`Observation`] each step. Out: a [`WhoDrives`] once a second:
//! the driver's traits or his latents, each with its uncertainty.
//!
//! The estimator is a gated recurrent unit (Cho 2014, in the form of cuDNN: the reset gate acts on the product) with a
//! linear readout of a mean and a logarithm of a standard deviation for each trait or latent. `train::identification` fits it: to
//! drivers whose traits are known, or, without being told anything of them, to what they do next.

mod estimator;
mod latents;
mod traits;

pub use estimator::{DriverEstimator, EstimatedTrait, EstimatorFault, GATES, LOG_SD, Recurrent};
pub use latents::{LatentEstimate, MOST_LATENTS, WhoDrives, latent_name};
pub use traits::{DriverTraits, TRAITS};

use super::Observation;

/// Numbers of one sample: advised less own speed, own speed, leader's less own speed, gap; each about -1 to 1.
pub const SAMPLE_NUMBERS: usize = 4;

/// Time between two samples, s: a fifth of the spread of people's reaction times.
pub const SAMPLE_S: f64 = 0.2;

/// Samples that the estimator takes in at once: it thinks once a second.
pub const SAMPLES: usize = 5;

/// Inputs of the recurrent unit: the samples, and whether an advice stands.
pub const INPUTS: usize = SAMPLE_NUMBERS * SAMPLES + 1;

/// What is known of a driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverEstimate {
    /// The likeliest traits.
    pub mean: DriverTraits,
    /// The standard deviation of each, in its own unit.
    pub sd: DriverTraits,
}

/// What is seen of a driver at one instant; speeds in m/s, the gap in metres.
pub fn sample(speed_mps: f32, leader_mps: f32, gap_m: f32, advised_mps: Option<f32>) -> [f32; SAMPLE_NUMBERS] {
    let short_mps = advised_mps.map_or(0.0, |advised| advised - speed_mps);
    [short_mps / 2.0, speed_mps / 5.0 - 1.0, (leader_mps - speed_mps) / 2.0, (gap_m / 20.0 - 1.0).min(4.0)]
}

/// An estimator at work on one driver.
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
    /// Nothing is known yet but what is known of all drivers.
    pub fn new(estimator: DriverEstimator) -> Self {
        let unit = estimator.begin();
        let read = estimator.read(unit.state());
        let who_drives = estimator.of_readout(&read);
        Self { estimator, steps: 0, inputs: Vec::with_capacity(INPUTS), unit, read, who_drives }
    }

    /// One step of `step_s` has passed.
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
        self.estimator.step(&self.inputs, &mut self.unit);
        self.inputs.clear();
        self.estimator.read_into(self.unit.state(), &mut self.read);
        self.who_drives = self.estimator.of_readout(&self.read);
    }

    /// What is known now.
    pub fn who_drives(&self) -> WhoDrives {
        self.who_drives
    }
}

#[cfg(test)]
mod tests;
