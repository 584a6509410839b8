//! Training of policies on the fast ring. In: a [`TrainConfig`]. Out: a [`crate::policy::Network`] and its learning curve. SI units.
//!
//! [`ring`] simulates sixteen rings at once, [`inputs`] defines the policies' inputs, [`environment`] makes episodes and [`driver`] lets
//! the advised vehicles follow the advice. [`net`] is the network, [`distribution`] the distribution of its actions, [`trpo`] the update and
//! [`learner`] the training loop, [`checkpoint`] its state on disk. [`evaluate()`] evaluates any policy over the horizon. `tuning` searches the parameters of a controller
//! (feature `tune`), `population_fit` the numbers of a population of drivers; [`silence`] learns when a policy should withhold advice.

pub mod adam;
mod advised_vehicle;
pub mod checkpoint;
pub mod config;
mod config_check;
mod corrected;
pub mod distribution;
mod drawn_ring;
pub mod driver;
pub mod environment;
pub mod evaluation;
pub mod fitted_network;
mod hold_totals;
pub mod identification;
pub mod inputs;
mod joint_evaluation;
mod late_view;
mod latent_traits;
pub mod learner;
pub mod learning_curve;
pub mod lessons;
pub mod matrix;
pub mod net;
pub mod outcome;
mod platoon_trajectories;
#[cfg(feature = "tune")]
pub mod population_fit;
pub mod ring;
mod ring_models;
mod ring_trajectories;
mod ring_vehicles;
pub mod rollout;
pub mod scalar;
mod shipped_rings;
pub mod silence;
pub mod simd;
pub mod trpo;
#[cfg(feature = "tune")]
pub mod tuning;

pub use checkpoint::{CHECKPOINT_BYTES, CheckpointClock};
pub use config::{
    ActionKind, AdviceConfig, DriverConfig, FollowKind, NetworkConfig, OptimiserConfig, RewardConfig, RewardKind,
    RingConfig, RunConfig, Scaling, SilenceConfig, StudentConfig, TrainConfig,
};
pub use drawn_ring::drawn_ring;
pub use evaluation::{IdentifiedDriver, evaluate, evaluate_part, identified, trajectories};
pub use joint_evaluation::evaluate_jointly;
pub use learner::{Learner, LearningCurveRow, network_of};
pub use lessons::EstimatorKind;
pub use platoon_trajectories::platoon_trajectories;
pub use ring_trajectories::ring_trajectories;
pub use ring_vehicles::{EndedRings, RingVehicle};

#[cfg(test)]
mod advised_tests;
#[cfg(test)]
mod driver_tests;
#[cfg(test)]
mod environment_tests;
#[cfg(test)]
mod learner_tests;
#[cfg(test)]
mod observed_driver_tests;
#[cfg(test)]
mod ring_tests;
#[cfg(test)]
mod trpo_tests;
