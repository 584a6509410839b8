//! Driver identification from the advice and the driver's behaviour. In: an [`Observation`](super::Observation) each step. Out: a [`WhoDrives`] once a
//! second: the driver's traits or latents, each with its uncertainty.
//!
//! The estimator is a gated recurrent unit (Cho 2014, in the form of cuDNN: the reset gate acts on the product). Its linear readout gives
//! a mean and a logarithm of a standard deviation per trait or latent. `train::identification` fits it to drivers with known traits or,
//! without their traits, to what drivers do next.

mod estimate;
mod estimator;
mod running;
mod sample;
mod traits;

pub use estimate::{DriverEstimate, LatentEstimate, WhoDrives};
pub use estimator::{DriverEstimator, EstimatedTrait, EstimatorFault, GATES, LOG_SD, Recurrent};
pub use running::Identification;
pub use sample::{INPUTS, INPUTS_WITH_OBSERVED, SAMPLE_NUMBERS, SAMPLE_S, SAMPLES, observed_inputs, sample};
pub use traits::{DriverTraits, MOST_LATENTS, TRAITS, latent_name};

#[cfg(test)]
mod tests;
