//! Attention to the advice and compliance with it. In: the driver's parameters, the time since the first advice, and
//! how much slower than the leader the advice was. Out: true or false. There is no state: random numbers come from a
//! seed and the number of a time interval, so that a whole drive and sixteen rings at once agree.

use super::DriverParams;
use crate::time::{TICK_S, TICKS_PER_S};
use serde::{Deserialize, Serialize};

/// Length of the interval for which a decision to follow the advice holds, s.
pub const STRETCH_S: f64 = 20.0;

/// Time constant of the mean by which the advice is slower than the leader, s.
pub const HELD_BACK_S: f64 = 30.0;

/// Willingness and attention of one driver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compliance {
    share: f64,
    fade_s: f64,
    patience_mps: f64,
    inattention_per_min: f64,
    inattention_s: f64,
    seed: u64,
}

/// Decision that a random number is drawn for.
#[derive(Clone, Copy)]
enum RandomDraw {
    Follow = 1,
    Look = 2,
}

impl Compliance {
    /// Creates the compliance of this driver. The same seed gives the same decisions.
    pub fn of(params: &DriverParams, seed: u64) -> Self {
        Self {
            share: params.compliance,
            fade_s: params.compliance_fade_s,
            patience_mps: params.patience_mps,
            inattention_per_min: params.inattention_per_min,
            inattention_s: params.inattention_s,
            seed,
        }
    }

    /// Returns the compliance of a driver that always looks and always follows.
    pub fn full() -> Self {
        Self::of(&DriverParams::default(), 0)
    }

    /// Checks whether the driver looks and follows at all times.
    pub fn is_full(&self) -> bool {
        self.share >= 1.0
            && self.fade_s == 0.0
            && self.patience_mps == 0.0
            && self.inattention_per_min * self.inattention_s == 0.0
    }

    /// Checks whether the driver follows the advice `time_s` after the first one; otherwise they drive as without
    /// advice. `held_back_mps` is the mean of the leader's speed less the advice over the last [`HELD_BACK_S`].
    pub fn follows(&self, time_s: f64, held_back_mps: f64) -> bool {
        let stretch = (time_s / STRETCH_S) as u64;
        self.chance(RandomDraw::Follow, stretch) < self.willingness(time_s, held_back_mps)
    }

    /// Returns the probability of following the advice at that time.
    pub fn willingness(&self, time_s: f64, held_back_mps: f64) -> f64 {
        let stretch = (time_s / STRETCH_S) as u64;
        let mut share = self.share;
        if self.fade_s > 0.0 {
            share *= (-(stretch as f64) * STRETCH_S / self.fade_s).exp();
        }
        if self.patience_mps > 0.0 {
            share *= (-held_back_mps.max(0.0) / self.patience_mps).exp();
        }
        share
    }

    /// Checks whether the driver reads the dial `time_s` after the first advice; otherwise they use the last advice
    /// that they read.
    pub fn looks(&self, time_s: f64) -> bool {
        if self.inattention_per_min == 0.0 || self.inattention_s == 0.0 {
            return true;
        }
        let spell = (time_s / self.inattention_s) as u64;
        self.chance(RandomDraw::Look, spell) >= self.inattention_per_min * self.inattention_s / 60.0
    }

    /// Returns a random number in `[0, 1)` for one interval (SplitMix64).
    fn chance(&self, draw: RandomDraw, stretch: u64) -> f64 {
        let mut z = self.seed ^ (stretch << 2 | draw as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Advice as one driver takes it over a drive, tick by tick.
#[derive(Clone, Debug)]
pub(super) struct AdviceTaken {
    compliance: Compliance,
    ticks: u64,
    held_back_mps: f64,
    follows: bool,
    looks: bool,
    seen_mps: Option<f64>,
}

impl AdviceTaken {
    pub fn new(compliance: Compliance) -> Self {
        Self { compliance, ticks: 0, held_back_mps: 0.0, follows: true, looks: true, seen_mps: None }
    }

    /// Advances by a tick under this advice behind a leader of this speed, m/s. Returns the advice that the driver acts
    /// upon; `None` without advice.
    pub fn see(&mut self, advised_mps: Option<f64>, leader_mps: Option<f64>) -> Option<f64> {
        let advised_mps = advised_mps?;
        if self.compliance.is_full() {
            return Some(advised_mps);
        }
        // Once a second, as on the ring.
        if self.ticks.is_multiple_of(u64::from(TICKS_PER_S)) {
            let time_s = self.ticks as f64 * TICK_S;
            self.follows = self.compliance.follows(time_s, self.held_back_mps);
            self.looks = self.compliance.looks(time_s);
        }
        if self.looks || self.seen_mps.is_none() {
            self.seen_mps = Some(advised_mps);
        }
        let behind_mps = leader_mps.map_or(0.0, |leader| leader - advised_mps);
        self.held_back_mps += (behind_mps - self.held_back_mps) * TICK_S / HELD_BACK_S;
        self.ticks += 1;
        self.seen_mps
    }

    /// Checks whether the driver follows the advice at present.
    pub fn follows(&self) -> bool {
        self.follows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(count: usize, of: impl Fn(u64) -> bool) -> f64 {
        (0..count as u64).filter(|seed| of(*seed)).count() as f64 / count as f64
    }

    #[test]
    fn a_fully_compliant_driver_always_looks_and_follows() {
        let full = Compliance::full();
        assert!(full.is_full());
        assert!((0..1000).all(|s| full.follows(f64::from(s), 5.0) && full.looks(f64::from(s))));
    }

    #[test]
    fn compliance_fades_with_time_and_with_advice_below_the_leaders_speed() {
        let params =
            DriverParams { compliance: 0.8, compliance_fade_s: 200.0, patience_mps: 2.0, ..DriverParams::default() };
        // 20,000 drivers: 0.7 % statistical error at 95 %.
        let at = |time_s: f64, held_back_mps: f64| {
            share(20_000, |seed| Compliance::of(&params, seed).follows(time_s, held_back_mps))
        };
        for (time_s, held_back_mps, expected) in [
            (0.0, 0.0, 0.8),
            (200.0, 0.0, 0.8 * (-1.0_f64).exp()),
            (0.0, 2.0, 0.8 * (-1.0_f64).exp()),
            (0.0, -3.0, 0.8),
        ] {
            let found = at(time_s, held_back_mps);
            assert!((found - expected).abs() < 0.015, "{time_s} s, {held_back_mps} m/s: {found}, not {expected}");
        }
        let one = Compliance::of(&params, 7);
        let first = one.follows(40.0, 0.0);
        assert!((400..600).all(|t| one.follows(f64::from(t) / 10.0, 0.0) == first), "a decision stands for 20 s");
    }

    #[test]
    fn spells_of_inattention_have_their_length_and_share() {
        let params = DriverParams { inattention_per_min: 3.0, inattention_s: 4.0, ..DriverParams::default() };
        let found = share(20_000, |seed| !Compliance::of(&params, seed).looks(12.0));
        assert!((found - 0.2).abs() < 0.01, "{found}: 3 spells of 4 s a minute are a fifth of the time");
        let one = Compliance::of(&params, 11);
        assert!((0..100).all(|spell| {
            let from_s = f64::from(spell) * 4.0;
            (0..40).all(|k| one.looks(from_s + f64::from(k) / 10.0) == one.looks(from_s))
        }));
    }
}
