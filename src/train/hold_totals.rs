//! Sums over the steps of a hold, for the reward. In: sixteen rings after each step. Out: [`RingTotals`] of all vehicles and
//! [`VehicleTotals`] of an advised one, in m/s and m.

use super::{
    ring::VectorizedRing,
    simd::{LANES, SimdLanes, splat},
};

/// Sums over a hold for each ring.
pub struct RingTotals {
    pub mean_mps: SimdLanes,
    /// Standard deviation of speed over the vehicles; 0 where no reward depends on it.
    pub speed_sd_mps: SimdLanes,
}

impl RingTotals {
    /// Returns sums over no steps.
    pub fn new() -> Self {
        Self { mean_mps: splat(0.0), speed_sd_mps: splat(0.0) }
    }

    /// Adds the mean speed after one step.
    #[inline(always)]
    pub fn add(&mut self, ring: &VectorizedRing) {
        for l in 0..LANES {
            self.mean_mps[l] += ring.mean_mps()[l];
        }
    }
}

/// Sums over a hold for one advised vehicle of each ring.
#[derive(Clone, Debug)]
pub struct VehicleTotals {
    pub own_mps: SimdLanes,
    pub least_gap_m: SimdLanes,
    pub short_headway: SimdLanes,
    pub missed_mps: SimdLanes,
}

impl Default for VehicleTotals {
    /// Returns sums over no steps.
    fn default() -> Self {
        Self { own_mps: splat(0.0), least_gap_m: splat(f32::MAX), short_headway: splat(0.0), missed_mps: splat(0.0) }
    }
}

impl VehicleTotals {
    /// Adds one step of the vehicle of slot `k`. Only an advised vehicle can hit its leader or be hit by its follower: the model keeps all
    /// other vehicles apart.
    #[inline(always)]
    pub fn add(&mut self, ring: &VectorizedRing, k: usize, missed_mps: &SimdLanes) {
        let (own_mps, gap_m, gap_behind_m) = (ring.speed_mps_of(k), ring.gaps_m(k), ring.gaps_m(ring.follower_of(k)));
        for l in 0..LANES {
            self.own_mps[l] += own_mps[l];
            self.missed_mps[l] += missed_mps[l];
            self.least_gap_m[l] = self.least_gap_m[l].min(gap_m[l]).min(gap_behind_m[l]);
            // The missing part of a time gap of 1 s, as in Flow's environments.
            self.short_headway[l] += (1.0 - gap_m[l] / own_mps[l].max(0.1)).max(0.0);
        }
    }
}
