//! Estimates of a driver: traits, which have names and units, or latents, which have neither. Out: numbers with their uncertainty, and
//! the observation completed with them.
//!
//! A latent is a quantity that a variational encoder (Kingma and Welling 2014) found informative about a driver. Over all drivers it is
//! approximately normal with mean 0 and standard deviation 1.

use super::{DriverTraits, MOST_LATENTS};
use crate::policy::Observation;

/// Estimate of a driver's traits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriverEstimate {
    /// Most likely traits of the driver.
    pub mean: DriverTraits,
    /// Standard deviation of each trait, in the trait's unit.
    pub sd: DriverTraits,
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
