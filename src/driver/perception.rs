//! Delayed perception and tracking error of a simulated driver. In: the present scene. Out: the scene that the driver
//! acts upon. The advice is delayed by the reaction time. The leader is extrapolated from its motion a reaction time
//! ago ([`crate::anticipation`]).

use super::{Perception, SeenLeader};
use crate::{
    anticipation::{JUDGED_S, LateSight, brake_mps2},
    rng::Stream,
    time::{TICK_S, TICKS_PER_S},
};
use std::collections::VecDeque;

/// Span over which the leader's deceleration is estimated, ticks.
const JUDGE_TICKS: usize = (JUDGED_S * TICKS_PER_S as f64) as usize;

/// Memory as long as the reaction time: it returns the value from that many ticks ago, or the oldest one at the start
/// of a drive.
#[derive(Clone, Debug)]
struct DelayLine<T> {
    ticks: usize,
    /// Values, oldest first; more than the delay needs, to estimate changes.
    moments: VecDeque<T>,
}

impl<T: Copy> DelayLine<T> {
    fn new(delay_s: f64) -> Self {
        let ticks = (delay_s * f64::from(TICKS_PER_S)).round() as usize;
        Self { ticks, moments: VecDeque::with_capacity(ticks + JUDGE_TICKS + 2) }
    }

    /// Adds the value of this tick; returns the index of the value to act upon.
    fn push(&mut self, now: T) -> usize {
        self.moments.push_back(now);
        while self.moments.len() > self.ticks + JUDGE_TICKS + 1 {
            self.moments.pop_front();
        }
        self.moments.len().saturating_sub(1 + self.ticks)
    }
}

/// Perception delayed by the reaction times.
#[derive(Clone, Debug)]
pub(super) struct DelayedPerception {
    advice: DelayLine<Option<f64>>,
    /// Leader, and the ego's way until then, m.
    leader: DelayLine<(Option<SeenLeader>, f64)>,
    /// Distance to the stop line, and the ego's way until then, m.
    stop: DelayLine<(Option<f64>, f64)>,
    way_m: f64,
}

impl DelayedPerception {
    pub fn new(advice_s: f64, leader_s: f64) -> Self {
        Self {
            advice: DelayLine::new(advice_s),
            leader: DelayLine::new(leader_s),
            stop: DelayLine::new(leader_s),
            way_m: 0.0,
        }
    }

    /// Adds this tick and the advised speed that the driver has in mind. Returns the advised speed and the leader to
    /// act upon.
    pub fn see(&mut self, now: &Perception, advised_mps: Option<f64>) -> (Option<f64>, Option<SeenLeader>) {
        self.way_m += now.speed_mps * TICK_S;
        let advised = self.advice.push(advised_mps);
        let index = self.leader.push((now.leader, self.way_m));
        let leader = self.leader.moments[index].0.map(|leader| self.anticipate(index, leader));
        (self.advice.moments[advised], leader)
    }

    /// Adds the stop line of this tick, after [`DelayedPerception::see`]. Returns its present distance if it was there
    /// a reaction time ago, and `None` if the ego has passed it.
    pub fn see_stop(&mut self, now: &Perception) -> Option<f64> {
        let index = self.stop.push((now.stop_ahead_m, self.way_m));
        let (seen_m, way_m) = self.stop.moments[index];
        seen_m.map(|seen_m| seen_m - (self.way_m - way_m)).filter(|ahead_m| *ahead_m >= 0.0)
    }

    /// Returns the present state of the leader of index `index`, as the driver anticipates it.
    fn anticipate(&self, index: usize, leader: SeenLeader) -> SeenLeader {
        let moments = &self.leader.moments;
        let back = index.saturating_sub(JUDGE_TICKS);
        let brake_mps2 = match moments[back].0 {
            Some(earlier) if back < index => {
                brake_mps2(earlier.speed_mps, leader.speed_mps, (index - back) as f64 * TICK_S)
            }
            _ => 0.0,
        };
        let [gap_m, speed_mps] = LateSight {
            gap_m: leader.gap_m,
            leader_mps: leader.speed_mps,
            brake_mps2,
            late_s: (moments.len() - 1 - index) as f64 * TICK_S,
            own_way_m: self.way_m - moments[index].1,
        }
        .anticipated();
        SeenLeader { gap_m, speed_mps }
    }
}

/// Ornstein-Uhlenbeck process, smoothed over a fifth of its time constant: an error with a standard deviation and a
/// time constant. Without the smoothing the wanted acceleration would jump, and the foot would move from pedal to
/// pedal.
#[derive(Clone, Debug)]
pub(super) struct OrnsteinUhlenbeck {
    raw: f64,
    smooth: f64,
    per_tick: PerTick,
    stream: Stream,
}

/// Factors of one tick, which follow from deviation and time constant.
#[derive(Clone, Copy, Debug)]
struct PerTick {
    keeps: f64,
    adds: f64,
    approaches: f64,
    deviation: f64,
}

impl PerTick {
    fn new(deviation: f64, time_s: f64) -> Self {
        let keeps = (-TICK_S / time_s).exp();
        Self {
            keeps,
            adds: (1.0 - keeps * keeps).sqrt(),
            approaches: 1.0 - (-TICK_S / (SMOOTH * time_s)).exp(),
            deviation: deviation * (1.0 + SMOOTH).sqrt(),
        }
    }
}

/// Smoothing time as a share of the time constant; the deviation is scaled up to compensate.
const SMOOTH: f64 = 0.2;

impl OrnsteinUhlenbeck {
    pub fn new(deviation: f64, time_s: f64, mut stream: Stream) -> Self {
        let raw = stream.normal();
        Self { raw, smooth: raw / (1.0 + SMOOTH), per_tick: PerTick::new(deviation, time_s), stream }
    }

    /// Changes standard deviation and time constant, s.
    pub fn scale(&mut self, deviation: f64, time_s: f64) {
        self.per_tick = PerTick::new(deviation, time_s);
    }

    /// Advances by one tick and returns the value.
    pub fn next(&mut self) -> f64 {
        let PerTick { keeps, adds, approaches, deviation } = self.per_tick;
        self.raw = self.raw * keeps + adds * self.stream.normal();
        self.smooth += (self.raw - self.smooth) * approaches;
        deviation * self.smooth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn a_tracking_error_has_its_deviation_and_time_constant() {
        let mut wander = OrnsteinUhlenbeck::new(0.3, 5.0, rng::stream(1, "wander"));
        let values: Vec<f64> = (0..2_000_000).map(|_| wander.next()).collect();
        let moment = |lag: usize| {
            let pairs = values.iter().zip(&values[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (values.len() - lag) as f64
        };
        // 20,000 s are 4000 time constants: 2 % statistical error in the variance.
        assert!((moment(0).sqrt() / 0.3 - 1.0).abs() < 0.04, "{}", moment(0).sqrt());
        // Correlation after one time constant of a process smoothed over a fifth of it.
        let expected = ((-1.0f64).exp() - SMOOTH * (-1.0 / SMOOTH).exp()) / (1.0 - SMOOTH);
        assert!((moment(500) / moment(0) - expected).abs() < 0.06, "{} {expected}", moment(500) / moment(0));
    }

    #[test]
    fn a_steadily_braking_leader_is_anticipated_exactly() {
        let mut senses = DelayedPerception::new(1.0, 1.0);
        let mut seen = None;
        for i in 0..300 {
            let t = f64::from(i) * TICK_S;
            // The ego drives at 10 m/s; the leader brakes at 2 m/s² from 10 m/s, 20 m ahead at the start.
            let leader = SeenLeader { gap_m: 20.0 - t * t, speed_mps: 10.0 - 2.0 * t };
            let now = Perception { speed_mps: 10.0, leader: Some(leader), ..Perception::default() };
            seen = senses.see(&now, None).1.map(|s| (s, leader));
        }
        let (seen, true_now) = seen.unwrap();
        assert!((seen.gap_m - true_now.gap_m).abs() < 1e-6, "{seen:?} {true_now:?}");
        assert!((seen.speed_mps - true_now.speed_mps).abs() < 1e-6);
    }
}
