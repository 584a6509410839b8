//! An estimator in training, of traits or of latents. In: [`Seconds`] of all blocks. Out: the parameters of its recurrent unit, and the
//! [`DriverEstimator`].

use super::{gru::GruShape, of_latents::LatentLearner, of_traits::TraitLearner, seconds::Seconds};
use crate::{
    policy::DriverEstimator,
    train::{EstimatorKind, TrainConfig},
};
use serde::{Deserialize, Serialize};

/// An estimator in training.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum EstimatorLearner {
    /// Learns traits from drivers with known traits.
    Traits(TraitLearner),
    /// Learns latents without any traits.
    Latents(LatentLearner),
}

impl EstimatorLearner {
    /// Returns an untrained estimator.
    pub fn new(config: &TrainConfig) -> Self {
        match config.student.estimator {
            EstimatorKind::Traits => Self::Traits(TraitLearner::new(config)),
            EstimatorKind::Variational => Self::Latents(LatentLearner::new(config)),
        }
    }

    /// Returns the shape of the recurrent unit.
    pub fn shape(&self) -> GruShape {
        match self {
            Self::Traits(learner) => learner.shape(),
            Self::Latents(learner) => learner.shape(),
        }
    }

    /// Returns the parameters of the recurrent unit.
    pub fn theta(&self) -> &[f32] {
        match self {
            Self::Traits(learner) => learner.theta(),
            Self::Latents(learner) => learner.theta(),
        }
    }

    /// Fits to the seconds of all blocks with learning rate `rate`. Returns the mean loss during the last pass, each block before its
    /// step, nat: per trait and second, or per second.
    pub fn fit(&mut self, blocks: &[Seconds], rate: f64) -> f64 {
        match self {
            Self::Traits(learner) => learner.fit(blocks, rate),
            Self::Latents(learner) => learner.fit(blocks, rate),
        }
    }

    /// Returns the current estimator.
    pub fn estimator(&self) -> DriverEstimator {
        match self {
            Self::Traits(learner) => learner.estimator(),
            Self::Latents(learner) => learner.estimator(),
        }
    }
}
