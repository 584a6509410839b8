//! Seconds of driving on the rings of a block: inputs and truths for an estimator in training.

use crate::{
    policy::DriverTraits,
    train::simd::{LANES, SimdLanes},
};

/// State of a block's egos at one instant: speed, leader's speed, gap, advice (negative: none), and the driver's observed reaction time,
/// s, and time gap factor; m/s and m.
pub type BlockSample = [SimdLanes; 6];

/// Consecutive seconds of a block's rings.
#[derive(Clone, Debug, Default)]
pub struct Seconds {
    /// States before the first second, one row per ring.
    pub state: Vec<f32>,
    /// Inputs of each second, one row per ring.
    pub inputs: Vec<Vec<f32>>,
    /// Rings that restart in each second.
    pub begins: Vec<Vec<bool>>,
    /// True traits of the drivers in each second.
    pub truths: Vec<[DriverTraits; LANES]>,
}
