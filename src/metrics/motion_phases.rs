//! Stops and hard brakings of a vehicle. In: its speed, step by step, m/s. Out: the start and duration of each. The evaluation
//! of policies and the analysis of recorded drives share these rules.

use std::collections::{BTreeMap, btree_map::Entry};

/// Deceleration above which a vehicle brakes hard, m/s2.
pub const HARD_MPS2: f32 = 3.0;
/// Speeds below which a vehicle stops, and from which on it moves again, m/s.
pub const STOPPED_MPS: [f32; 2] = [0.1, 1.0];

/// Current state of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionPhase {
    before_mps: f32,
    /// True while braking harder than [`HARD_MPS2`].
    pub is_hard: bool,
    /// True at a standstill, or while creeping after a stop.
    pub is_standing: bool,
}

/// Episodes that began in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Begun {
    /// True if a hard braking began.
    pub hard: bool,
    /// True if a stop began.
    pub stop: bool,
}

impl MotionPhase {
    /// Starts with a vehicle at this speed; a vehicle that stands at first has not stopped.
    pub fn new(speed_mps: f32) -> Self {
        Self { before_mps: speed_mps, is_hard: false, is_standing: speed_mps < STOPPED_MPS[0] }
    }

    /// Adds the speed at the next step of `step_s`.
    #[inline]
    pub fn add(&mut self, speed_mps: f32, step_s: f32) -> Begun {
        let is_hard = self.before_mps - speed_mps > HARD_MPS2 * step_s;
        let hard = is_hard && !self.is_hard;
        self.is_hard = is_hard;
        let stop = !self.is_standing && speed_mps < STOPPED_MPS[0];
        self.is_standing = if self.is_standing { speed_mps < STOPPED_MPS[1] } else { stop };
        self.before_mps = speed_mps;
        Begun { hard, stop }
    }
}

/// Stops and hard brakings of some vehicles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionTotals {
    /// States by vehicle number.
    cars: BTreeMap<u32, MotionPhase>,
    /// Number of stops that began.
    pub stops: u64,
    /// Time of all vehicles at a stop, seconds.
    pub stopped_s: f64,
    /// Number of hard brakings that began.
    pub hard_brakings: u64,
    /// Time of all vehicles in hard brakings, seconds.
    pub hard_braking_s: f64,
}

impl MotionTotals {
    /// Adds a step of `step_s`: number and speed of each vehicle present.
    pub fn add(&mut self, cars: impl Iterator<Item = (u32, f32)>, step_s: f64) {
        for (id, speed_mps) in cars {
            let car = match self.cars.entry(id) {
                Entry::Vacant(place) => place.insert(MotionPhase::new(speed_mps)),
                Entry::Occupied(place) => {
                    let car = place.into_mut();
                    let begun = car.add(speed_mps, step_s as f32);
                    self.stops += u64::from(begun.stop);
                    self.hard_brakings += u64::from(begun.hard);
                    car
                }
            };
            self.stopped_s += if car.is_standing { step_s } else { 0.0 };
            self.hard_braking_s += if car.is_hard { step_s } else { 0.0 };
        }
    }

    /// Returns the number of vehicles seen so far.
    pub fn cars(&self) -> usize {
        self.cars.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_and_brakings_match_a_hand_count() {
        let mut totals = MotionTotals::default();
        // Vehicle 0: 4 m/s2 for 2.5 s to a standstill of 1 s, then off. Vehicle 7 stands for 1 s from the start, which is not a
        // stop, and goes.
        let braked = (0..=25).map(|k| 10.0 - 0.4 * k as f32);
        let first: Vec<f32> = braked.chain([0.0; 9]).chain([2.0; 10]).collect();
        for (k, speed) in first.iter().enumerate() {
            totals.add([(0, speed.max(0.0)), (7, if k < 10 { 0.0 } else { 3.0 })].into_iter(), 0.1);
        }
        assert_eq!((totals.stops, totals.hard_brakings, totals.cars()), (1, 1, 2));
        // Ten steps of standing each; 25 steps of braking.
        assert!((totals.stopped_s - 2.0).abs() < 1e-9, "{totals:?}");
        assert!((totals.hard_braking_s - 2.5).abs() < 1e-9, "{totals:?}");
    }

    #[test]
    fn a_car_in_the_place_of_another_has_not_braked_from_its_speed() {
        let mut totals = MotionTotals::default();
        // By position in the list, vehicle 8 would stop from 10 m/s, with about 100 m/s2.
        totals.add([(0, 5.0), (7, 10.0)].into_iter(), 0.1);
        totals.add([(0, 5.0), (8, 0.05)].into_iter(), 0.1);
        assert_eq!((totals.stops, totals.hard_brakings, totals.cars()), (0, 0, 3));
        // Vehicle 8 stands when first seen, and creeps at its next row.
        totals.add([(8, 0.5)].into_iter(), 0.1);
        assert!((totals.stopped_s - 0.2).abs() < 1e-9, "{totals:?}");
    }
}
