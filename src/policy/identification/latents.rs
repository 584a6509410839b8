//! What an estimator says of a driver: traits, which have names and units, or latents, which have neither. In: nothing. Out: numbers
//! with their uncertainty, and what a policy sees of them.
//!
//! A latent is what a variational encoder (Kingma and Welling 2014) found worth knowing of a driver. Among all drivers it is spread
//! about as a normal distribution of mean 0 and standard deviation 1.

use super::{DriverEstimate, EstimatedTrait};
use crate::policy::Observation;

/// The most latents that an estimator may have: those that a policy can name.
pub const MOST_LATENTS: usize = 4;

/// The name of latent `k`, counted from 0, in files: `latent_1` is the first.
pub fn latent_name(k: usize) -> String {
    format!("latent_{}", k + 1)
}

impl EstimatedTrait {
    /// Latent `k`, counted from 0: it is read out as it is.
    pub fn latent(k: usize) -> Self {
        Self { name: latent_name(k), centre: 0.0, spread: 1.0 }
    }
}

/// What is known of a driver whose traits nobody named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatentEstimate {
    /// How many latents there are; the others are 0.
    pub count: usize,
    /// Their means, without a unit.
    pub mean: [f64; MOST_LATENTS],
    /// The standard deviation of each; 1 where nothing is known.
    pub sd: [f64; MOST_LATENTS],
}

/// What an estimator says of a driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WhoDrives {
    /// His traits.
    Traits(DriverEstimate),
    /// His latents.
    Latents(LatentEstimate),
}

impl WhoDrives {
    /// His traits, where they are told.
    pub fn traits(&self) -> Option<DriverEstimate> {
        match self {
            Self::Traits(estimate) => Some(*estimate),
            Self::Latents(_) => None,
        }
    }

    /// His latents, where they are told.
    pub fn latents(&self) -> Option<LatentEstimate> {
        match self {
            Self::Traits(_) => None,
            Self::Latents(estimate) => Some(*estimate),
        }
    }

    /// The same observation by somebody who knows this of the driver: the means.
    pub fn told(&self, observation: &Observation) -> Observation {
        match self {
            Self::Traits(estimate) => Observation { driver: Some(estimate.mean), ..*observation },
            Self::Latents(estimate) => Observation { latents: estimate.mean, ..*observation },
        }
    }
}
