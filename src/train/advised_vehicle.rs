//! One advised vehicle on each ring of a block: its driver, and what is known of both. In: the rings at each step, advice. Out: the vehicle's
//! speeds, observations, and sums of a hold. Slot 0 is the ego's; every advised vehicle has a slot of its own, the same on all rings.

use super::{
    config::TrainConfig,
    corrected::CorrectedLanes,
    driver::AdviceFollower,
    hold_totals::VehicleTotals,
    ring::VectorizedRing,
    simd::{LANES, SimdLanes, splat},
};
use crate::{
    policy::{CorrectedAdvice, DriverObserver, Observation, ObservedDriver, WholeRing},
    rng::Stream,
};
use serde::{Deserialize, Serialize};

/// An advised vehicle of each ring.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AdvisedVehicle {
    pub slot: usize,
    pub follower: AdviceFollower,
    /// Drivers of the rings in stock.
    stock: AdviceFollower,
    /// Moving mean of the own speed as the policy may see it, m/s.
    mean_mps: SimdLanes,
    /// Advice that the policy corrects; `None` if the policy corrects no other advice.
    corrected: Option<CorrectedLanes>,
    /// Observers of the drivers, if the policy sees what they observe.
    observers: Option<Vec<DriverObserver>>,
    /// Sums of the hold in progress.
    #[serde(skip, default)]
    pub totals: VehicleTotals,
}

impl AdvisedVehicle {
    /// Returns the vehicle of a slot before any episode.
    pub fn new(slot: usize, config: &TrainConfig) -> Self {
        let follower = AdviceFollower::new(config);
        Self {
            slot,
            stock: follower.clone(),
            follower,
            mean_mps: splat(0.0),
            corrected: None,
            observers: None,
            totals: VehicleTotals::default(),
        }
    }

    /// Draws the driver of ring `l` in stock.
    pub fn draw(&mut self, l: usize, config: &TrainConfig, stream: &mut Stream) {
        self.stock.draw(l, config, stream);
    }

    /// Begins an episode on ring `l` with driver `used` of the stock.
    pub fn begin(&mut self, l: usize, used: usize, ring: &VectorizedRing) {
        self.follower.copy_lane(l, &self.stock, used);
        self.mean_mps[l] = ring.speed_mps_of(self.slot)[l];
    }

    /// Returns the own part of the observation of ring `l`; the facts of the ring itself are left out.
    #[inline(always)]
    pub fn traffic(&self, ring: &VectorizedRing, l: usize) -> Observation {
        Observation {
            speed_mps: f64::from(ring.speed_mps_of(self.slot)[l]),
            leader_speed_mps: f64::from(ring.leader_mps_of(self.slot)[l]),
            gap_m: f64::from(ring.gaps_m(self.slot)[l]),
            mean_speed_mps: f64::from(self.mean_mps[l]),
            advised_mps: self.follower.advised_mps(l),
            observed: self.observed(l),
            ..Observation::default()
        }
    }

    /// Returns the state of the whole of ring `l`, seen from the vehicle.
    pub fn whole_ring(&self, ring: &VectorizedRing, l: usize) -> WholeRing {
        let speeds = ring.speeds_mps(l).map(f64::from);
        let from_here = speeds.clone().skip(self.slot).chain(speeds.take(self.slot));
        WholeRing::of(from_here, self.follower.deviation_mps(l))
    }

    /// Returns the corrected advice of ring `l`, m/s, if there is one.
    pub fn corrected_mps(&self, l: usize) -> Option<f64> {
        self.corrected.as_ref().map(|lanes| lanes.advised_mps(l))
    }

    /// Sets the advice that actions correct from now on.
    pub fn correct(&mut self, advice: &CorrectedAdvice, step_s: f64) {
        self.corrected = Some(CorrectedLanes::new(advice, step_s));
    }

    /// Returns true if there is a corrected advice.
    pub fn is_corrected(&self) -> bool {
        self.corrected.is_some()
    }

    /// Returns true if a corrected advice needs every step.
    pub fn watches_advice(&self) -> bool {
        self.corrected.as_ref().is_some_and(CorrectedLanes::watches)
    }

    /// Passes the current observation of ring `l` to the corrected advice.
    pub fn tell_corrected(&mut self, l: usize, seen: &Observation, tell: fn(&mut CorrectedLanes, usize, &Observation)) {
        self.corrected.iter_mut().for_each(|lanes| tell(lanes, l, seen));
    }

    /// Starts observers of the drivers, without an observation.
    pub fn observe_drivers(&mut self) {
        self.observers = Some(vec![DriverObserver::default(); LANES]);
    }

    /// Returns true if the drivers are observed.
    pub fn is_observed(&self) -> bool {
        self.observers.is_some()
    }

    /// Starts the observer of ring `l`, if there is one, for a new driver.
    pub fn begin_observing(&mut self, l: usize, seen: &Observation, step_s: f64) {
        if let Some(lanes) = &mut self.observers {
            lanes[l] = DriverObserver::default();
            lanes[l].watch(seen, None, step_s);
        }
    }

    /// Passes the step just driven on ring `l` to the observer of the driver, if there is one.
    pub fn watch_driver(&mut self, l: usize, seen: &Observation, step_s: f64) {
        let advised_mps = self.follower.advised_mps(l);
        self.observers.iter_mut().for_each(|lanes| lanes[l].watch(seen, advised_mps, step_s));
    }

    /// Returns the driver of ring `l` as observed.
    pub fn observed(&self, l: usize) -> ObservedDriver {
        self.observers.as_ref().map_or(ObservedDriver::default(), |lanes| lanes[l].observed())
    }

    /// Adds a step after which the vehicle drives at `own_mps` to the sums of the hold and to the moving mean, in which it has the weight
    /// `fresh`.
    #[inline(always)]
    pub fn add(&mut self, ring: &VectorizedRing, own_mps: &SimdLanes, range_mps: f32, fresh: f32) {
        self.totals.add(ring, self.slot, &self.follower.missed_mps(own_mps, range_mps));
        for (mean, now) in self.mean_mps.iter_mut().zip(own_mps) {
            *mean += (now - *mean) * fresh;
        }
    }
}
