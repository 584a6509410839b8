//! Estimates of a driver: traits, which have names and units, or latents, which have neither. Out: numbers with their uncertainty, and
//! the observation completed with them.
//!
//! A latent is a quantity that a variational encoder (Kingma and Welling 2014) found informative about a driver. Over all drivers it is
//! approximately normal with mean 0 and standard deviation 1.

use super::{DriverEstimate, EstimatedTrait};
use crate::policy::Observation;

/// Largest number of latents, each of which a policy can take as input.
pub const MOST_LATENTS: usize = 4;

/// Returns the name of latent `k` in files; `k` counts from 0 and the first name is `latent_1`.
pub fn latent_name(k: usize) -> String {
    format!("latent_{}", k + 1)
}

impl EstimatedTrait {
    /// Returns the readout scaling of latent `k`, counted from 0: centre 0, spread 1.
    pub fn latent(k: usize) -> Self {
        Self { name: latent_name(k), centre: 0.0, spread: 1.0 }
    }
}

/// Estimate of a driver by latents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatentEstimate {
    /// Number of latents; the entries beyond are 0.
    pub count: usize,
    /// Mean of each latent, dimensionless.
    pub mean: [f64; MOST_LATENTS],
    /// Standard deviation of each latent; 1 if nothing is known.
    pub sd: [f64; MOST_LATENTS],
}

/// Estimate of a driver, by traits or by latents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WhoDrives {
    /// Estimated traits with standard deviations.
    Traits(DriverEstimate),
    /// Estimated latents with standard deviations.
    Latents(LatentEstimate),
}

impl WhoDrives {
    /// Returns the estimated traits, if traits are estimated.
    pub fn traits(&self) -> Option<DriverEstimate> {
        match self {
            Self::Traits(estimate) => Some(*estimate),
            Self::Latents(_) => None,
        }
    }

    /// Returns the estimated latents, if latents are estimated.
    pub fn latents(&self) -> Option<LatentEstimate> {
        match self {
            Self::Traits(_) => None,
            Self::Latents(estimate) => Some(*estimate),
        }
    }

    /// Returns the observation with the means of this estimate filled in.
    pub fn complete_observation(&self, observation: &Observation) -> Observation {
        match self {
            Self::Traits(estimate) => Observation { driver: Some(estimate.mean), ..*observation },
            Self::Latents(estimate) => Observation { latents: estimate.mean, ..*observation },
        }
    }
}
