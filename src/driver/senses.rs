//! Seeing late, and wandering. In: what there is to see now. Out: what the driver acts upon: the advice as it was a
//! reaction time ago, and the leader as he must be by now, going by how he moved a reaction time ago (the anticipation
//! of Treiber, Kesting, Helbing 2006, "Delays, inaccuracies and anticipation in microscopic traffic models").

use super::{Perception, SeenLeader};
use crate::{
    rng::Stream,
    time::{TICK_S, TICKS_PER_S},
};
use std::collections::VecDeque;

/// Span over which the leader's acceleration is judged, ticks.
const JUDGE_TICKS: usize = 20;

/// One moment, kept until it is acted upon.
#[derive(Clone, Copy, Debug)]
struct Moment {
    target_mps: Option<f64>,
    leader: Option<SeenLeader>,
    /// Own way driven until then, metres.
    way_m: f64,
}

/// A memory as long as the reaction time.
#[derive(Clone, Debug)]
pub(super) struct Senses {
    delay_ticks: usize,
    moments: VecDeque<Moment>,
    way_m: f64,
}

impl Senses {
    pub fn new(reaction_s: f64) -> Self {
        let delay_ticks = (reaction_s * f64::from(TICKS_PER_S)).round() as usize;
        Self { delay_ticks, moments: VecDeque::with_capacity(delay_ticks + JUDGE_TICKS + 2), way_m: 0.0 }
    }

    /// Takes in this tick. Returns the advised speed and the leader that the driver acts upon; at the start of a drive
    /// the first moment counts as known.
    pub fn see(&mut self, now: &Perception) -> (Option<f64>, Option<SeenLeader>) {
        self.way_m += now.speed_mps * TICK_S;
        let target_mps = now.advice.map(|advice| advice.target_mps);
        self.moments.push_back(Moment { target_mps, leader: now.leader, way_m: self.way_m });
        while self.moments.len() > self.delay_ticks + JUDGE_TICKS + 1 {
            self.moments.pop_front();
        }
        let index = self.moments.len().saturating_sub(1 + self.delay_ticks);
        let seen = self.moments[index];
        (seen.target_mps, seen.leader.map(|leader| self.anticipate(index, leader)))
    }

    /// Where the leader of moment `index` is now, if he goes on as he did then; only his braking is extrapolated, not
    /// his accelerating.
    fn anticipate(&self, index: usize, leader: SeenLeader) -> SeenLeader {
        let back = index.saturating_sub(JUDGE_TICKS);
        let accel_mps2 = match self.moments[back].leader {
            Some(earlier) if back < index => {
                ((leader.speed_mps - earlier.speed_mps) / ((index - back) as f64 * TICK_S)).clamp(-9.0, 0.0)
            }
            _ => 0.0,
        };
        let late_s = (self.moments.len() - 1 - index) as f64 * TICK_S;
        let speed_mps = (leader.speed_mps + accel_mps2 * late_s).max(0.0);
        let his_way_m = (leader.speed_mps + speed_mps) / 2.0 * late_s;
        let own_way_m = self.way_m - self.moments[index].way_m;
        SeenLeader { gap_m: leader.gap_m + his_way_m - own_way_m, speed_mps }
    }
}

/// An Ornstein-Uhlenbeck process: a wander with a standard deviation and a time constant.
#[derive(Clone, Debug)]
pub(super) struct Wander {
    value: f64,
    deviation: f64,
    time_s: f64,
    stream: Stream,
}

impl Wander {
    pub fn new(deviation: f64, time_s: f64, mut stream: Stream) -> Self {
        Self { value: deviation * stream.normal(), deviation, time_s, stream }
    }

    /// The value after one more tick (exact for any time constant).
    pub fn next(&mut self) -> f64 {
        let keep = (-TICK_S / self.time_s).exp();
        let kick = self.deviation * (1.0 - keep * keep).sqrt();
        self.value = self.value * keep + kick * self.stream.normal();
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn a_wander_has_its_deviation_and_its_time() {
        let mut wander = Wander::new(0.3, 5.0, rng::stream(1, "wander"));
        let values: Vec<f64> = (0..2_000_000).map(|_| wander.next()).collect();
        let moment = |lag: usize| {
            let pairs = values.iter().zip(&values[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (values.len() - lag) as f64
        };
        // 20,000 s are 4000 time constants: 2 % of statistical error in the variance.
        assert!((moment(0).sqrt() / 0.3 - 1.0).abs() < 0.04, "{}", moment(0).sqrt());
        assert!((moment(500) / moment(0) - (-1.0f64).exp()).abs() < 0.06, "{}", moment(500) / moment(0));
    }

    #[test]
    fn a_steadily_braking_leader_is_anticipated_exactly() {
        let mut senses = Senses::new(1.0);
        let mut seen = None;
        for i in 0..300 {
            let t = f64::from(i) * TICK_S;
            // Own speed 10 m/s; the leader brakes with 2 m/s2 from 10 m/s, 20 m ahead at the start.
            let leader = SeenLeader { gap_m: 20.0 - t * t, speed_mps: 10.0 - 2.0 * t };
            let now = Perception { speed_mps: 10.0, leader: Some(leader), ..Perception::default() };
            seen = senses.see(&now).1.map(|s| (s, leader));
        }
        let (seen, true_now) = seen.unwrap();
        assert!((seen.gap_m - true_now.gap_m).abs() < 1e-6, "{seen:?} {true_now:?}");
        assert!((seen.speed_mps - true_now.speed_mps).abs() < 1e-6);
    }
}
