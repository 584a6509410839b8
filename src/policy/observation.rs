//! Input of a policy at each step: the traffic around the ego, the advice in force, the driver and the road ahead. In: plain numbers, SI.
//! Out: an [`Observation`].

use super::{DriverTraits, RoadAhead, identification::MOST_LATENTS};

/// Inputs available to a policy; the first four are HC22's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Own speed, m/s.
    pub speed_mps: f64,
    /// Leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// Own front bumper to the leader's rear bumper, m.
    pub gap_m: f64,
    /// Length of the closed route, m.
    pub circumference_m: f64,
    /// Number of vehicles on the closed route, the ego included.
    pub vehicles: u32,
    /// Hold of the action, s; set by [`Advisor`](super::Advisor).
    pub hold_s: f64,
    /// Own mean speed over about the last half minute, m/s ([`MeanSpeed`](super::MeanSpeed)); set by [`Advisor`](super::Advisor).
    pub mean_speed_mps: f64,
    /// Target of the current advice, m/s; set by [`Advisor`](super::Advisor).
    pub advised_mps: Option<f64>,
    /// Traits of the driver, if known or estimated.
    pub driver: Option<DriverTraits>,
    /// Latents of the driver from a variational encoder, dimensionless; 0 if unknown.
    pub latents: [f64; MOST_LATENTS],
    /// Speed that the policy corrects, m/s, if it corrects one.
    pub corrected_mps: Option<f64>,
    /// Road ahead; absent on training rings.
    pub road: RoadAhead,
}
