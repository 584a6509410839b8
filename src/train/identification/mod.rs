//! Training of the estimator of `policy::identification`. In: advice and behaviour on the rings of a block, and the drivers' traits. Out:
//! a [`DriverEstimator`](crate::policy::DriverEstimator) for the policy's file, of traits or of latents.
//!
//! During training the policy drives with the student's own estimates (Ross 2011), so that the student sees their consequences.

mod estimator_learner;
mod fitting;
mod gru;
mod of_latents;
mod of_traits;
mod seconds;
mod variational;
mod watcher;

pub use estimator_learner::EstimatorLearner;
pub use gru::GruShape;
pub use seconds::{BlockSample, Seconds};
pub use watcher::Watcher;

#[cfg(test)]
mod tests;
