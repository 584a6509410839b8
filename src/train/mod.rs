//! Training of policies on the fast ring. In: a [`TrainConfig`]. Out: a [`crate::policy::Network`], and its learning
//! curve. SI units.
//!
//! [`ring`] moves sixteen rings at once; [`environment`] makes episodes of them, [`driver`] lets their egos follow the
//! advice; [`net`] is the network, [`distribution`] the randomness of its actions, [`trpo`] the update, [`learner`] the
//! loop around them; [`judge`] drives any policy over the horizon and says how fast all cars went.

pub mod config;
pub mod driver;
pub mod environment;
pub mod lanes;
pub mod ring;

pub use config::{ActionKind, FollowKind, RewardKind, TrainConfig};

#[cfg(test)]
mod ring_tests;
