//! Driver identification from the advice and the driver's behaviour. In: an [`Observation`] each step. Out: a [`WhoDrives`] once a
//! second: the driver's traits or latents, each with its uncertainty.
//!
//! The estimator is a gated recurrent unit (Cho 2014, in the form of cuDNN: the reset gate acts on the product). Its linear readout gives
//! a mean and a logarithm of a standard deviation per trait or latent. `train::identification` fits it to drivers with known traits or,
//! without their traits, to what drivers do next.

mod estimator;
mod latents;
mod traits;

pub use estimator::{DriverEstimator, EstimatedTrait, EstimatorFault, GATES, LOG_SD, Recurrent};
pub use latents::{LatentEstimate, MOST_LATENTS, WhoDrives, latent_name};
pub use traits::{DriverTraits, TRAITS};

use super::Observation;

/// Length of one sample: advised minus own speed, own speed, leader's minus own speed, gap; each about -1 to 1.
pub const SAMPLE_NUMBERS: usize = 4;

/// Time between two samples, s: a fifth of the spread of people's reaction times.
pub const SAMPLE_S: f64 = 0.2;

/// Samples per update of the estimator, which runs once a second.
pub const SAMPLES: usize = 5;

/// Inputs of the recurrent unit: the samples, and 1 if an advice is in force, else 0.
pub const INPUTS: usize = SAMPLE_NUMBERS * SAMPLES + 1;

/// Estimate of a driver's traits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverEstimate {
    /// Most likely traits of the driver.
    pub mean: DriverTraits,
    /// Standard deviation of each trait, in the trait's unit.
    pub sd: DriverTraits,
}

/// Returns one scaled sample of a driver; speeds in m/s, the gap in m.
pub fn sample(speed_mps: f32, leader_mps: f32, gap_m: f32, advised_mps: Option<f32>) -> [f32; SAMPLE_NUMBERS] {
    let short_mps = advised_mps.map_or(0.0, |advised| advised - speed_mps);
    [short_mps / 2.0, speed_mps / 5.0 - 1.0, (leader_mps - speed_mps) / 2.0, (gap_m / 20.0 - 1.0).min(4.0)]
}

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
        Self { estimator, steps: 0, inputs: Vec::with_capacity(INPUTS), unit, read, who_drives }
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
        self.estimator.step(&self.inputs, &mut self.unit);
        self.inputs.clear();
        self.estimator.read_into(self.unit.state(), &mut self.read);
        self.who_drives = self.estimator.of_readout(&self.read);
    }

    /// Returns the current estimate.
    pub fn who_drives(&self) -> WhoDrives {
        self.who_drives
    }
}

#[cfg(test)]
mod tests;
