//! Observer of the driver, from their own history: how late they respond to advice, how far they are from it now, and which time gap they
//! keep. In: own speed, gap, leader's speed and the advice in force, step by step. Out: [`ObservedDriver`].
//!
//! A driver approaches the speed that they seek with a time constant of [`RELAXATION_S`], so that they seek `v + RELAXATION_S dv/dt`. If
//! they seek the advice of a reaction time ago plus a slow deviation, that difference changes least for their own reaction time; each
//! candidate is held against the others by its sum of squared changes (a bank of models, [Magill 1965]). The time gap is told in the same
//! way from the acceleration: that of the car-following model with the driver's own time gap, or less where the advice holds them back. The
//! models are those of the three populations, each with the noise of its people (docs/references.md: drivers, people).

use super::Observation;
use crate::{
    anticipation::{JUDGED_S, LateSight, brake_mps2},
    idm::IdmParams,
    optimal_velocity::OptimalVelocityParams,
};
use serde::{Deserialize, Serialize};
use std::{collections::VecDeque, f64::consts::TAU};

/// Time constant with which a driver approaches the speed that they seek, s.
pub(crate) const RELAXATION_S: f64 = 1.5;
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
pub(crate) const SAFE_FOLLOWERS: (f64, f64) = (1.867, 1.167);
/// Delay with which drivers see their leader among the ring study's vehicles, s.
pub(crate) const LEADER_REACTION_S: f64 = 0.7;
/// Time between two looks at the acceleration, s.
const LOOK_S: f64 = 0.4;
/// Standard deviation of the acceleration around that of each model, m/s2, and around that with which a person approaches the advised speed.
const ERRORS_MPS2: [f64; MODELS] = [0.1, 0.4, 0.2];
const ADVICE_ERROR_MPS2: f64 = 0.5;
/// Density of an acceleration that no candidate explains, s2/m.
const UNEXPLAINED: f64 = 0.01;
/// Least weight of a candidate, so that it can gain again.
const LEAST_WEIGHT: f64 = 1e-9;

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
    /// Probability of each model with each factor.
    weights: Weights,
    /// Length of the last step, s.
    step_s: f64,
}

/// Probabilities of each model with each factor for the time gap; their sum is 1, but for [`LEAST_WEIGHT`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Weights([[f64; FACTORS]; MODELS]);

impl Default for Weights {
    /// Returns the distribution of people; every model is as likely.
    fn default() -> Self {
        let usual = |k: usize| (-0.5 * ((factor(k) - 1.0) / FACTOR_SD).powi(2)).exp();
        let mut weights = Self([std::array::from_fn(usual); MODELS]);
        weights.normalise();
        weights
    }
}

impl Weights {
    fn normalise(&mut self) {
        let sum: f64 = self.0.iter().flatten().sum();
        self.0.iter_mut().flatten().for_each(|weight| *weight = (*weight / sum).max(LEAST_WEIGHT));
    }

    /// Returns the mean of the factors.
    fn mean_factor(&self) -> f64 {
        let each = self.0.iter().flat_map(|weights| weights.iter().enumerate());
        let [sum, weights] =
            each.fold([0.0, 0.0], |[sum, weights], (k, weight)| [sum + weight * factor(k), weights + weight]);
        sum / weights
    }
}

impl DriverObserver {
    /// Adds one step of `step_s` seconds that ended in this traffic, with the advice that was in force in it.
    pub fn watch(&mut self, traffic: &Observation, advised_mps: Option<f64>, step_s: f64) {
        self.step_s = step_s;
        let now = [traffic.speed_mps, traffic.leader_speed_mps, traffic.gap_m];
        self.traffic.push_front(now);
        self.traffic.truncate(self.late(LEADER_REACTION_S) + self.late(JUDGED_S).max(1) + 2);
        self.steps += 1;
        let before = *self.traffic.get(1).unwrap_or(&now);
        let accel_mps2 = (now[0] - before[0]) / step_s;
        self.watch_response(before[0] + RELAXATION_S * accel_mps2, advised_mps);
        if (self.steps as usize).is_multiple_of(self.late(LOOK_S).max(1)) {
            self.watch_following(accel_mps2);
        }
    }

    /// Returns the driver as observed up to the last step. Without advice in force there is no deviation.
    pub fn observed(&self) -> ObservedDriver {
        let reaction_s = self.reaction_s();
        let deviation_mps = self.deviation_mps(reaction_s).unwrap_or(0.0).clamp(-LARGEST_MPS, LARGEST_MPS);
        ObservedDriver { deviation_mps, reaction_s, time_gap_factor: self.weights.mean_factor() }
    }

    /// Returns a time in steps.
    fn late(&self, time_s: f64) -> usize {
        (time_s / self.step_s).round() as usize
    }

    /// Returns the deviation from the advice of a reaction time ago, m/s, if there was advice then.
    fn deviation_mps(&self, reaction_s: f64) -> Option<f64> {
        Some(self.sought_mps? - self.advised_mps.get(self.late(reaction_s))?)
    }

    /// Holds each candidate for the reaction time against the speed that the driver seeks now.
    fn watch_response(&mut self, sought_mps: f64, advised_mps: Option<f64>) {
        let fresh = 1.0 - (-self.step_s / SMOOTH_S).exp();
        let smoothed = |before: Option<f64>, now: f64| before.map_or(now, |before| before + (now - before) * fresh);
        self.sought_mps = Some(smoothed(self.sought_mps, sought_mps));
        let Some(advised_mps) = advised_mps else {
            self.advised_mps.clear();
            self.deviations_mps = [None; REACTIONS];
            return;
        };
        self.advised_mps.push_front(smoothed(self.advised_mps.front().copied(), advised_mps));
        self.advised_mps.truncate(self.late(REACTION_STEP_S * (REACTIONS - 1) as f64) + 1);
        let now: [Option<f64>; REACTIONS] = std::array::from_fn(|k| self.deviation_mps(REACTION_STEP_S * k as f64));
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
    }

    /// Returns the mean of the candidates for the reaction time, weighted by their likelihood and by how people are.
    fn reaction_s(&self) -> f64 {
        let least = self.changes.iter().copied().fold(f64::INFINITY, f64::min);
        let variance = (least / f64::from(self.change_count.max(1))).max(1e-6);
        let [mean_s, sd_s] = REACTION_S;
        let [sum, weights] = (0..REACTIONS).fold([0.0, 0.0], |[sum, weights], k| {
            let reaction_s = REACTION_STEP_S * k as f64;
            let usual = ((reaction_s - mean_s) / sd_s).powi(2);
            let weight = (-0.5 * ((self.changes[k] - least) / variance + usual)).exp();
            [sum + weight * reaction_s, weights + weight]
        });
        sum / weights
    }

    /// Compares the last acceleration with those of the models for the traffic before it.
    fn watch_following(&mut self, accel_mps2: f64) {
        let Some(&[speed_mps, leader_mps, gap_m]) = self.traffic.get(1) else { return };
        let Some([seen_m, seen_mps]) = self.seen_late() else { return };
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
        let late = self.late(REACTION_S[0]);
        let advised_mps2 = self.advised_mps.get(late).map(|advised_mps| (advised_mps - speed_mps) / RELAXATION_S);
        let density =
            |off_mps2: f64, sd_mps2: f64| (-0.5 * (off_mps2 / sd_mps2).powi(2)).exp() / (sd_mps2 * TAU.sqrt());
        let by_advice = advised_mps2.map_or(0.0, |advised| density(accel_mps2 - advised, ADVICE_ERROR_MPS2));
        for k in 0..FACTORS {
            let models_mps2 = [
                by_idm(ring_study, factor(k), seen_mps, seen_m),
                by_idm(safe, factor(k), leader_mps, gap_m),
                optimal.acceleration(speed_mps, leader_mps, gap_m / factor(k), f64::INFINITY),
            ];
            for (model, (model_mps2, error_mps2)) in models_mps2.into_iter().zip(ERRORS_MPS2).enumerate() {
                // Probability that the advice holds the driver back more than the leader does.
                let is_held = advised_mps2.map_or(0.0, |advised| {
                    let more = (model_mps2 - advised) / ADVICE_ERROR_MPS2;
                    0.5 + 0.5 * more / (1.0 + more * more).sqrt()
                });
                let by_model = density(accel_mps2 - model_mps2, error_mps2);
                let likelihood = (1.0 - is_held) * by_model + is_held * by_advice + UNEXPLAINED;
                // Two looks that follow each other have about the same noise, and count as one.
                self.weights.0[model][k] *= likelihood.sqrt();
            }
        }
        self.weights.normalise();
    }

    /// Returns the gap, m, and the leader's speed, m/s, that a driver among the ring study's vehicles had in mind at the last step's begin.
    fn seen_late(&self) -> Option<[f64; 2]> {
        let (delay, judged) = (self.late(LEADER_REACTION_S), self.late(JUDGED_S).max(1));
        let [_, leader_mps, gap_m] = *self.traffic.get(1 + delay)?;
        let [_, earlier_mps, _] = *self.traffic.get(1 + delay + judged)?;
        let sight = LateSight {
            gap_m,
            leader_mps,
            brake_mps2: brake_mps2(earlier_mps, leader_mps, judged as f64 * self.step_s),
            late_s: delay as f64 * self.step_s,
            own_way_m: self.traffic.range(1..=delay).map(|[speed_mps, ..]| speed_mps * self.step_s).sum(),
        };
        let [gap_m, leader_mps] = sight.anticipated();
        Some([gap_m.max(0.5), leader_mps])
    }
}

/// Returns candidate `k` for the time gap as a multiple of a model's.
fn factor(k: usize) -> f64 {
    FIRST_FACTOR + FACTOR_STEP * k as f64
}

#[cfg(test)]
#[path = "driver_observer_tests.rs"]
mod tests;
