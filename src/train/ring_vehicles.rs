//! Places and speeds of all vehicles of a block of rings, for users of single vehicles: the rings themselves know gaps only. In: rings, their
//! lengths, the way of each ego since its episode began. Out: front bumpers along each ring and speeds, the ego first, then backwards.
//! Metres, m/s.

use super::{
    ring::VectorizedRing,
    simd::{SimdLanes, splat},
};
use crate::space::CAR_LENGTH_M;
use serde::{Deserialize, Serialize};

/// Lengths of rings, and the ways of their egos.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RingWays {
    pub circumference_m: SimdLanes,
    /// Way of the ego since the episode began, which starts at 0.
    pub ego_way_m: SimdLanes,
}

impl Default for RingWays {
    fn default() -> Self {
        Self { circumference_m: splat(0.0), ego_way_m: splat(0.0) }
    }
}

/// Vehicle of a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingVehicle {
    /// Front bumper along the ring, from 0 up to its length.
    pub s_m: f64,
    pub speed_mps: f64,
}

/// Rings at the end of their last episodes, kept when the next ones begin.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EndedRings {
    ring: VectorizedRing,
    ways: RingWays,
}

impl EndedRings {
    /// Returns rings without an ended episode, of the size of `ring`.
    pub fn new(ring: VectorizedRing) -> Self {
        Self { ring, ways: RingWays::default() }
    }

    /// Keeps ring `l` as it is at the end of its episode.
    pub fn keep(&mut self, l: usize, ring: &VectorizedRing, ways: &RingWays) {
        self.ring.copy_lane(l, ring, l);
        self.ways.circumference_m[l] = ways.circumference_m[l];
        self.ways.ego_way_m[l] = ways.ego_way_m[l];
    }

    /// Returns the length of ring `l` in its last episode, metres.
    pub fn circumference_m(&self, l: usize) -> f64 {
        self.ways.circumference_m[l].into()
    }

    /// Returns the vehicles of ring `l` at the end of its last episode.
    pub fn vehicles(&self, l: usize) -> impl Iterator<Item = RingVehicle> + '_ {
        vehicles(&self.ring, &self.ways, l)
    }
}

/// Returns the vehicles of ring `l` now.
pub fn vehicles<'a>(ring: &'a VectorizedRing, ways: &RingWays, l: usize) -> impl Iterator<Item = RingVehicle> + 'a {
    let (length_m, way_m) = (f64::from(ways.circumference_m[l]), f64::from(ways.ego_way_m[l]));
    let mut behind_m = 0.0;
    ring.speeds_mps(l).enumerate().map(move |(k, speed_mps)| {
        if k > 0 {
            behind_m += f64::from(ring.gaps_m(k)[l]) + CAR_LENGTH_M;
        }
        RingVehicle { s_m: (way_m - behind_m).rem_euclid(length_m), speed_mps: f64::from(speed_mps) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{idm::IdmParams, train::ring::RingStart};

    #[test]
    fn places_follow_from_the_gaps_behind_the_ego() {
        let mut ring = VectorizedRing::new(3, 0.1);
        // Three vehicles on 30 m, 10 m apart; the ego has gone round once and 4 m.
        (0..16).for_each(|l| ring.set(l, &RingStart::even(3, 30.0, IdmParams::default(), 1)));
        let ways = RingWays { circumference_m: splat(30.0), ego_way_m: splat(34.0) };
        let places: Vec<f64> = vehicles(&ring, &ways, 7).map(|vehicle| vehicle.s_m).collect();
        assert!(
            places.iter().zip([4.0, 24.0, 14.0]).all(|(found, expected)| (found - expected).abs() < 1e-4),
            "{places:?}"
        );
    }

    #[test]
    fn an_ended_ring_stays_when_the_next_one_begins() {
        let mut ring = VectorizedRing::new(3, 0.1);
        (0..16).for_each(|l| ring.set(l, &RingStart::even(3, 30.0, IdmParams::default(), 1)));
        let ways = RingWays { circumference_m: splat(30.0), ego_way_m: splat(4.0) };
        let mut ended = EndedRings::new(ring.clone());
        ended.keep(2, &ring, &ways);
        ring.set(2, &RingStart::even(2, 60.0, IdmParams::default(), 1));
        assert_eq!(ended.vehicles(2).count(), 3);
        assert!((ended.vehicles(2).next().expect("the ego").s_m - 4.0).abs() < 1e-9);
    }
}
