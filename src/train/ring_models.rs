//! Car-following models of the fast ring, one for each lane of a block. In: drivers of traffic; then speeds, gaps and the leaders' speeds.
//! Out: accelerations. Metres, m/s, m/s².

use super::simd::{SimdLanes, splat, tanh};
use crate::{
    idm::IdmParams,
    optimal_velocity::{self, OptimalVelocityParams},
    traffic::{self, CarFollowing, TrafficDriver},
};
use serde::{Deserialize, Serialize};

/// Bounds of the native engine in single precision.
const HARDEST_MPS2: f32 = traffic::HARDEST_MPS2 as f32;
const HIGHEST_RATE: f32 = optimal_velocity::HIGHEST_RATE as f32;

/// Driver of each ring, in the form that the inner loop needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Model {
    inverse_v0: SimdLanes,
    pub(super) delta: SimdLanes,
    pub(super) time_gap_s: SimdLanes,
    accel: SimdLanes,
    /// 1 / (2 sqrt(a b)), s²/m.
    approach: SimdLanes,
    s0_m: SimdLanes,
    /// Standard deviation of the change of speed that the noise adds per step, m/s, and the share of it that a step keeps.
    pub(super) noise_mps: SimdLanes,
    pub(super) noise_keeps: SimdLanes,
    /// Drivers with the optimal velocity model; of the others, and where no lane has one, these numbers have no effect.
    pub(super) optimal: OptimalVelocity,
}

/// Kinds of models in a block, each of which has a loop of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Kinds {
    /// True if all exponents are 4: two multiplications replace the power.
    pub(super) are_fourth_powers: bool,
    /// True if a driver has the optimal velocity model.
    pub(super) has_optimal: bool,
}

/// Optimal velocity model of each ring, in the form that the inner loop needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct OptimalVelocity {
    /// 1 in a lane with this model, 0 in one with the IDM.
    pub(super) is_model: SimdLanes,
    alpha: SimdLanes,
    beta: SimdLanes,
    /// v_max / (1 + tanh(ds)), m/s.
    rise_mps: SimdLanes,
    inverse_d0: SimdLanes,
    ds: SimdLanes,
    tanh_ds: SimdLanes,
}

impl Model {
    /// Returns placeholder values for lanes without a ring.
    pub(super) fn new() -> Self {
        let one = splat(1.0);
        Self {
            inverse_v0: one,
            delta: splat(4.0),
            time_gap_s: one,
            accel: one,
            approach: one,
            s0_m: one,
            noise_mps: splat(0.0),
            noise_keeps: splat(0.0),
            optimal: OptimalVelocity {
                is_model: splat(0.0),
                alpha: one,
                beta: one,
                rise_mps: one,
                inverse_d0: one,
                ds: one,
                tanh_ds: one,
            },
        }
    }

    /// Sets the driver of lane `l` for steps of `step_s`.
    pub(super) fn set(&mut self, l: usize, driver: &TrafficDriver, step_s: f64) {
        let (keeps, adds_mps) = driver.noise.in_steps_of(step_s);
        (self.noise_keeps[l], self.noise_mps[l]) = (keeps as f32, adds_mps as f32);
        self.optimal.is_model[l] = 0.0;
        let IdmParams { v0, t, a, b, delta, s0, .. } = match driver.model {
            CarFollowing::Idm(idm) => idm,
            CarFollowing::OptimalVelocity(model) => {
                self.optimal.set(l, &model);
                // A driver who keeps another distance sees the gap in units of their time gap; exponent 4 is the fast one.
                IdmParams { t: 1.0, ..IdmParams::default() }
            }
        };
        self.inverse_v0[l] = (1.0 / v0) as f32;
        self.delta[l] = delta as f32;
        self.time_gap_s[l] = t as f32;
        self.accel[l] = a as f32;
        self.approach[l] = (0.5 / (a * b).sqrt()) as f32;
        self.s0_m[l] = s0 as f32;
    }

    /// Copies lane `from_lane` of another model into lane `l`.
    pub(super) fn copy_lane(&mut self, l: usize, from: &Self, from_lane: usize) {
        for (to, from) in [
            (&mut self.inverse_v0, &from.inverse_v0),
            (&mut self.delta, &from.delta),
            (&mut self.time_gap_s, &from.time_gap_s),
            (&mut self.accel, &from.accel),
            (&mut self.approach, &from.approach),
            (&mut self.s0_m, &from.s0_m),
            (&mut self.noise_mps, &from.noise_mps),
            (&mut self.noise_keeps, &from.noise_keeps),
            (&mut self.optimal.is_model, &from.optimal.is_model),
            (&mut self.optimal.alpha, &from.optimal.alpha),
            (&mut self.optimal.beta, &from.optimal.beta),
            (&mut self.optimal.rise_mps, &from.optimal.rise_mps),
            (&mut self.optimal.inverse_d0, &from.optimal.inverse_d0),
            (&mut self.optimal.ds, &from.optimal.ds),
            (&mut self.optimal.tanh_ds, &from.optimal.tanh_ds),
        ] {
            to[l] = from[from_lane];
        }
    }
}

impl OptimalVelocity {
    /// Sets the model of lane `l`.
    fn set(&mut self, l: usize, model: &OptimalVelocityParams) {
        let OptimalVelocityParams { alpha, beta, v_max, d0, ds } = *model;
        self.is_model[l] = 1.0;
        self.alpha[l] = alpha as f32;
        self.beta[l] = beta as f32;
        self.rise_mps[l] = (v_max / (1.0 + ds.tanh())) as f32;
        self.inverse_d0[l] = (1.0 / d0) as f32;
        self.ds[l] = ds as f32;
        self.tanh_ds[l] = ds.tanh() as f32;
    }

    /// Returns the acceleration in lane `l`, m/s² ([`OptimalVelocityParams::acceleration`]).
    #[inline(always)]
    fn accel(&self, l: usize, speed: f32, leader: f32, gap: f32) -> f32 {
        let gap = gap.max(0.0);
        let wanted = self.rise_mps[l] * (tanh(gap * self.inverse_d0[l] - self.ds[l]) + self.tanh_ds[l]);
        let rate = (self.beta[l] / (gap * gap)).min(HIGHEST_RATE);
        self.alpha[l] * (wanted - speed) + rate * (leader - speed)
    }
}

/// Returns the acceleration in lane `l` for speed, leader's speed, gap and time gap, m/s² (see [`crate::idm`]). Without `OPTIMAL` no lane has
/// the optimal velocity model.
#[inline(always)]
pub(super) fn accel<const FOURTH: bool, const OPTIMAL: bool>(m: &Model, l: usize, seen: [f32; 4]) -> f32 {
    let [speed, leader, gap, time_gap_s] = seen;
    let approach = speed * (speed - leader) * m.approach[l];
    let desired = m.s0_m[l] + (speed * time_gap_s + approach).max(0.0);
    let interaction = desired / gap.max(1e-3);
    let share = speed * m.inverse_v0[l];
    let free = if FOURTH { (share * share) * (share * share) } else { share.powf(m.delta[l]) };
    let mut accel = m.accel[l] * (1.0 - free - interaction * interaction);
    if OPTIMAL {
        let optimal = m.optimal.accel(l, speed, leader, gap / time_gap_s);
        accel = if m.optimal.is_model[l] > 0.0 { optimal } else { accel };
    }
    accel.clamp(-HARDEST_MPS2, HARDEST_MPS2)
}
