//! Observer of the driver, from their own history: how late they respond to advice, how far they are from it now, and which time gap they
//! keep. In: own speed, gap, leader's speed and the advice in force, step by step. Out: [`ObservedDriver`].
//!
//! A driver approaches the speed that they seek with a time constant of [`RELAXATION_S`], so that they seek `v + RELAXATION_S dv/dt`. If
//! they seek the advice of a reaction time ago plus a slow deviation, that difference changes least for their own reaction time; each
//! candidate is held against the others by its sum of squared changes (a bank of models, [Magill 1965]). The time gap is told in the same
//! way from the acceleration, which never exceeds that of the car-following model with the driver's own time gap. The models are those of the
//! three populations (docs/references.md: drivers, people).

use super::Observation;
use crate::{idm::IdmParams, optimal_velocity::OptimalVelocityParams};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Time constant with which a driver approaches the speed that they seek, s.
const RELAXATION_S: f64 = 1.5;
/// Time constant of the smoothing of speeds and advice, s: longer than the distance of two candidates, so that near ones look alike.
const SMOOTH_S: f64 = 0.35;
/// Largest deviation, m/s. A larger difference is a driver who does not follow the advice or is held back.
const LARGEST_MPS: f64 = 2.0;

/// Candidates for the reaction time, from 0 in such steps, s.
const REACTIONS: usize = 13;
const REACTION_STEP_S: f64 = 0.2;
/// Reaction time of people, mean and standard deviation, s.
const REACTION_S: [f64; 2] = [1.0, 0.6];
/// Largest squared change of a deviation in a step that counts, m2/s2: a larger one is no driver's.
const LARGEST_CHANGE: f64 = 0.05;

/// Candidates for the time gap as a multiple of a model's, from the first in such steps.
const FACTORS: usize = 21;
const FIRST_FACTOR: f64 = 0.6;
const FACTOR_STEP: f64 = 0.05;
/// Standard deviation of people's factors, whose mean is 1.
const FACTOR_SD: f64 = 0.2;
/// Models of the ring study's drivers, of people who follow safely, and of people who close the gap.
const MODELS: usize = 3;
/// Time gap, s, and acceleration, m/s2, of people who follow safely (docs/references.md: people).
const SAFE_FOLLOWERS: (f64, f64) = (1.867, 1.167);
/// Delay with which drivers see their leader among the ring study's vehicles, s, and the span over which they judge that it brakes.
const LEADER_REACTION_S: f64 = 0.7;
const JUDGED_S: f64 = 0.2;
/// Largest deceleration assumed for a leader, m/s2.
const HARDEST_MPS2: f64 = 9.0;
/// Time between two looks at the acceleration, s.
const LOOK_S: f64 = 0.4;
/// Error of a model's acceleration, m/s2, and the largest differences that count: of a driver who is slower than the model, as advice makes
/// them, and of one who is faster, which rules the candidate out.
const ACCEL_ERROR_MPS2: f64 = 0.2;
const SLOWER_MPS2: f64 = 0.15;
const FASTER_MPS2: f64 = 0.5;

/// Observed state and traits of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObservedDriver {
    /// Present speed sought minus advised speed, m/s. Behind a slower leader it is lower than the driver's own deviation.
    pub deviation_mps: f64,
    /// Time from a new advice to the first response, s.
    pub reaction_s: f64,
    /// Time gap to the leader as a multiple of the other vehicles' time gap.
    pub time_gap_factor: f64,
}

impl Default for ObservedDriver {
    /// Returns what is assumed of a driver who has not been observed.
    fn default() -> Self {
        Self { deviation_mps: 0.0, reaction_s: REACTION_S[0], time_gap_factor: 1.0 }
    }
}

/// Observer of one driver.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DriverObserver {
    steps: u32,
    /// Traffic at the ends of the last steps, the latest first: own speed, leader's speed, m/s, and gap, m.
    traffic: VecDeque<[f64; 3]>,
    /// Smoothed speed that the driver seeks, m/s.
    sought_mps: Option<f64>,
    /// Smoothed advice of the last steps, m/s, the latest first; empty without advice.
    advised_mps: VecDeque<f64>,
    /// Deviation from the advice that each candidate for the reaction time has seen, m/s, and the sum of its squared changes, m2/s2.
    deviations_mps: [Option<f64>; REACTIONS],
    changes: [f64; REACTIONS],
    change_count: u32,
    /// Sum of squared differences from the acceleration of each model with each factor, m2/s4.
    differences: [[f64; FACTORS]; MODELS],
    observed: ObservedDriver,
}

impl DriverObserver {
    /// Adds one step of `step_s` seconds that ended in this traffic, with the advice that was in force in it.
    pub fn watch(&mut self, traffic: &Observation, advised_mps: Option<f64>, step_s: f64) -> ObservedDriver {
        let now = [traffic.speed_mps, traffic.leader_speed_mps, traffic.gap_m];
        let late = |time_s: f64| (time_s / step_s).round() as usize;
        self.traffic.push_front(now);
        self.traffic.truncate(late(LEADER_REACTION_S) + late(JUDGED_S).max(1) + 2);
        self.steps += 1;
        let before = *self.traffic.get(1).unwrap_or(&now);
        let accel_mps2 = (now[0] - before[0]) / step_s;
        self.watch_response(before[0] + RELAXATION_S * accel_mps2, advised_mps, step_s);
        if (self.steps as usize).is_multiple_of(late(LOOK_S).max(1)) {
            self.watch_following(accel_mps2, step_s);
            self.observed.reaction_s = self.reaction_s();
            self.observed.time_gap_factor = self.time_gap_factor();
        }
        self.observed
    }

    /// Returns the driver as observed up to the last step.
    pub fn observed(&self) -> ObservedDriver {
        self.observed
    }

    fn watch_response(&mut self, sought_mps: f64, advised_mps: Option<f64>, step_s: f64) {
        let fresh = 1.0 - (-step_s / SMOOTH_S).exp();
        let smoothed = |before: Option<f64>, now: f64| before.map_or(now, |before| before + (now - before) * fresh);
        let sought_mps = smoothed(self.sought_mps, sought_mps);
        self.sought_mps = Some(sought_mps);
        let Some(advised_mps) = advised_mps else {
            self.advised_mps.clear();
            self.deviations_mps = [None; REACTIONS];
            self.observed.deviation_mps *= 1.0 - fresh;
            return;
        };
        let late = |reaction_s: f64| (reaction_s / step_s).round() as usize;
        self.advised_mps.push_front(smoothed(self.advised_mps.front().copied(), advised_mps));
        self.advised_mps.truncate(late(REACTION_STEP_S * (REACTIONS - 1) as f64) + 1);
        let deviation_mps = |reaction_s: f64| Some(sought_mps - self.advised_mps.get(late(reaction_s))?);
        let now: [Option<f64>; REACTIONS] = std::array::from_fn(|k| deviation_mps(REACTION_STEP_S * k as f64));
        // A candidate that saw an earlier change than others would be blamed for it.
        if now.iter().chain(&self.deviations_mps).all(Option::is_some) {
            self.change_count += 1;
            for (sum, (now, before)) in
                self.changes.iter_mut().zip(now.iter().flatten().zip(self.deviations_mps.iter().flatten()))
            {
                *sum += (now - before).powi(2).min(LARGEST_CHANGE);
            }
        }
        self.deviations_mps = now;
        let now_mps = deviation_mps(self.observed.reaction_s).unwrap_or(0.0);
        self.observed.deviation_mps = now_mps.clamp(-LARGEST_MPS, LARGEST_MPS);
    }

    /// Returns the mean of the candidates for the reaction time, weighted by their likelihood and by how people are.
    fn reaction_s(&self) -> f64 {
        let least = self.changes.iter().copied().fold(f64::INFINITY, f64::min);
        let variance = (least / f64::from(self.change_count.max(1))).max(1e-6);
        let [mean_s, sd_s] = REACTION_S;
        weighted_mean((0..REACTIONS).map(|k| {
            let reaction_s = REACTION_STEP_S * k as f64;
            let usual = ((reaction_s - mean_s) / sd_s).powi(2);
            (reaction_s, (self.changes[k] - least) / variance + usual)
        }))
    }

    /// Compares the last acceleration with those of the models for the traffic before it.
    fn watch_following(&mut self, accel_mps2: f64, step_s: f64) {
        let Some(&[speed_mps, leader_mps, gap_m]) = self.traffic.get(1) else { return };
        let Some([seen_mps, seen_m]) = self.seen_late(step_s) else { return };
        // A driver who stands keeps no time gap, and one who is far behind is free.
        if speed_mps < 0.5 || gap_m > 100.0 || gap_m <= 0.0 {
            return;
        }
        let (ring_study, optimal) = (IdmParams::default(), OptimalVelocityParams::default());
        let safe = IdmParams { t: SAFE_FOLLOWERS.0, a: SAFE_FOLLOWERS.1, ..ring_study };
        // The power of the free road is the same for all candidates.
        let free_share = ring_study.acceleration(speed_mps, speed_mps, f64::INFINITY) / ring_study.a;
        let by_idm = |idm: IdmParams, factor: f64, leader_mps: f64, gap_m: f64| {
            let held_share = IdmParams { t: idm.t * factor, ..idm }.desired_gap_m(speed_mps, leader_mps) / gap_m;
            idm.a * (free_share - held_share * held_share)
        };
        for (k, factor) in factors().enumerate() {
            let models = [
                by_idm(ring_study, factor, seen_mps, seen_m),
                by_idm(safe, factor, leader_mps, gap_m),
                optimal.acceleration(speed_mps, leader_mps, gap_m / factor, f64::INFINITY),
            ];
            for (sums, model_mps2) in self.differences.iter_mut().zip(models) {
                sums[k] += (accel_mps2 - model_mps2).clamp(-SLOWER_MPS2, FASTER_MPS2).powi(2);
            }
        }
    }

    /// Returns the leader's speed, m/s, and the gap, m, as a driver extrapolates them from what they saw [`LEADER_REACTION_S`] ago.
    fn seen_late(&self, step_s: f64) -> Option<[f64; 2]> {
        let late = |time_s: f64| (time_s / step_s).round() as usize;
        let (delay, judged) = (late(LEADER_REACTION_S), late(JUDGED_S).max(1));
        let [_, then_mps, then_m] = *self.traffic.get(1 + delay)?;
        let [_, earlier_mps, _] = *self.traffic.get(1 + delay + judged)?;
        let delay_s = delay as f64 * step_s;
        let brake_mps2 = ((earlier_mps - then_mps) / (judged as f64 * step_s)).clamp(0.0, HARDEST_MPS2);
        let way_m: f64 = self.traffic.range(1..=delay).map(|[speed_mps, ..]| speed_mps * step_s).sum();
        let gap_m = then_m + then_mps * delay_s - 0.5 * brake_mps2 * delay_s * delay_s - way_m;
        Some([(then_mps - brake_mps2 * delay_s).max(0.0), gap_m.max(0.5)])
    }

    /// Returns the mean of the candidates for the time gap, weighted by their likelihood and by how people are.
    fn time_gap_factor(&self) -> f64 {
        let least = self.differences.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let of_model = |sums: &[f64; FACTORS]| {
            let sums = *sums;
            factors().zip(sums).map(move |(factor, sum)| {
                let usual = ((factor - 1.0) / FACTOR_SD).powi(2);
                (factor, (sum - least) / (ACCEL_ERROR_MPS2 * ACCEL_ERROR_MPS2) + usual)
            })
        };
        weighted_mean(self.differences.iter().flat_map(of_model))
    }
}

fn factors() -> impl Iterator<Item = f64> {
    (0..FACTORS).map(|k| FIRST_FACTOR + FACTOR_STEP * k as f64)
}

/// Returns the mean of values whose weights are `exp(-x / 2)` of the second numbers.
fn weighted_mean(candidates: impl Iterator<Item = (f64, f64)>) -> f64 {
    let [sum, weights] = candidates.fold([0.0, 0.0], |[sum, weights], (value, x)| {
        let weight = (-x / 2.0).exp();
        [sum + weight * value, weights + weight]
    });
    sum / weights
}

#[cfg(test)]
#[path = "driver_observer_tests.rs"]
mod tests;
