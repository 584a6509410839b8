//! Sums over the steps of a hold, for the reward. In: sixteen rings after each step. Out: [`Totals`], in m/s and m.

use super::{
    ring::VectorizedRing,
    simd::{SimdLanes, splat},
};

/// Sums over a hold for each lane.
pub struct Totals {
    pub mean_mps: SimdLanes,
    pub ego_mps: SimdLanes,
    pub least_gap_m: SimdLanes,
    pub short_headway: SimdLanes,
    pub missed_mps: SimdLanes,
    /// Standard deviation of speed over the vehicles; 0 where no reward depends on it.
    pub speed_sd_mps: SimdLanes,
}

impl Default for Totals {
    fn default() -> Self {
        Self {
            mean_mps: splat(0.0),
            ego_mps: splat(0.0),
            least_gap_m: splat(f32::MAX),
            short_headway: splat(0.0),
            missed_mps: splat(0.0),
            speed_sd_mps: splat(0.0),
        }
    }
}

impl Totals {
    /// Adds one step. Only the ego can hit its leader and be hit by its follower: the model keeps all other vehicles apart.
    #[inline(always)]
    pub fn add(&mut self, ring: &VectorizedRing, missed_mps: &SimdLanes) {
        for (l, missed) in missed_mps.iter().enumerate() {
            let (gap_m, ego_mps) = (ring.gap_m()[l], ring.ego_mps()[l]);
            self.mean_mps[l] += ring.mean_mps()[l];
            self.ego_mps[l] += ego_mps;
            self.missed_mps[l] += missed;
            self.least_gap_m[l] = self.least_gap_m[l].min(gap_m).min(ring.gap_behind_m()[l]);
            // The missing part of a time gap of 1 s, as in Flow's environments.
            self.short_headway[l] += (1.0 - gap_m / ego_mps.max(0.1)).max(0.0);
        }
    }
}
