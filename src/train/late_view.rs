//! Delayed perception of the leaders. In: gaps and speeds of sixteen rings, step by step. Out: the gaps and leaders' speeds on which each
//! ego acts. They are the values of a reaction time ago, extrapolated to now by [`crate::anticipation`], here in vector instructions.
//! Metres, m/s.

use super::simd::{LANES, SimdLanes, lane, splat};
use crate::anticipation::{HARDEST_MPS2, JUDGED_S};
use serde::{Deserialize, Serialize};

/// Past state of one step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Moment {
    gap_m: SimdLanes,
    leader_mps: SimdLanes,
    /// Distance driven by the ego up to this step, m.
    way_m: SimdLanes,
}

/// Memory of the egos' drivers of their leaders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LateView {
    step_s: f32,
    judged_steps: usize,
    /// Ring buffer of past states, with the latest at `newest`.
    moments: Vec<Moment>,
    newest: usize,
    /// Delay of each driver, steps.
    late: [u32; LANES],
    /// Steps that each driver has seen.
    seen: [u32; LANES],
    way_m: SimdLanes,
}

impl LateView {
    /// Returns drivers without delay, with room for delays of up to `longest_s` in steps of `step_s`.
    pub fn new(longest_s: f64, step_s: f64) -> Self {
        let judged_steps = (JUDGED_S / step_s).round().max(1.0) as usize;
        let room = (longest_s / step_s).round() as usize + judged_steps + 1;
        let moment = Moment { gap_m: splat(0.0), leader_mps: splat(0.0), way_m: splat(0.0) };
        Self {
            step_s: step_s as f32,
            judged_steps,
            moments: vec![moment; room],
            newest: 0,
            late: [0; LANES],
            seen: [0; LANES],
            way_m: splat(0.0),
        }
    }

    /// Sets a driver with a delay of `late_s` and an empty memory in lane `l`.
    pub fn set(&mut self, l: usize, late_s: f64) {
        let most = self.moments.len() - self.judged_steps - 1;
        self.late[l] = ((late_s / f64::from(self.step_s)).round() as u32).min(most as u32);
        self.forget(l);
    }

    /// Copies the delay of a driver from another block's lane, with an empty memory.
    pub fn copy_lane(&mut self, l: usize, from: &Self, from_lane: usize) {
        self.late[l] = from.late[from_lane];
        self.forget(l);
    }

    fn forget(&mut self, l: usize) {
        self.seen[l] = 0;
        self.way_m[l] = 0.0;
    }

    /// Returns true if no driver has a delay.
    pub fn is_prompt(&self) -> bool {
        self.late == [0; LANES]
    }

    /// Advances the egos by one step at these speeds.
    #[inline(always)]
    pub fn drive(&mut self, ego_mps: &SimdLanes) {
        for (way_m, speed_mps) in self.way_m.iter_mut().zip(ego_mps) {
            *way_m += speed_mps * self.step_s;
        }
    }

    /// Stores the present state; returns the gaps and the leaders' speeds that the drivers perceive.
    #[inline(always)]
    pub fn see(&mut self, gap_m: &SimdLanes, leader_mps: &SimdLanes) -> [SimdLanes; 2] {
        let size = self.moments.len();
        self.newest = if self.newest + 1 == size { 0 } else { self.newest + 1 };
        self.moments[self.newest] = Moment { gap_m: *gap_m, leader_mps: *leader_mps, way_m: self.way_m };
        // Gathered lane by lane, since each driver remembers another step.
        let mut then = Moment { gap_m: *gap_m, leader_mps: *leader_mps, way_m: self.way_m };
        let (mut before_mps, mut late_s) = (*leader_mps, splat(0.0));
        for l in 0..LANES {
            let late = self.late[l].min(self.seen[l]) as usize;
            self.seen[l] = self.seen[l].saturating_add(1);
            late_s[l] = late as f32 * self.step_s;
            let moment = self.past(late);
            then.gap_m[l] = moment.gap_m[l];
            then.leader_mps[l] = moment.leader_mps[l];
            then.way_m[l] = moment.way_m[l];
            let judged = late + self.judged_steps;
            // `seen` already counts this step, so it must exceed `judged`.
            before_mps[l] =
                if self.seen[l] as usize > judged { self.past(judged).leader_mps[l] } else { then.leader_mps[l] };
        }
        self.anticipated(&then, &before_mps, &late_s)
    }

    /// Returns the state `back` steps ago.
    #[inline(always)]
    fn past(&self, back: usize) -> &Moment {
        // Avoids a division, which takes longer than everything else here.
        let at = self.newest + self.moments.len() - back;
        &self.moments[if at >= self.moments.len() { at - self.moments.len() } else { at }]
    }

    /// Extrapolates gaps and leaders' speeds by `late_s`; only the braking since `before_mps` is continued.
    #[inline(always)]
    fn anticipated(&self, then: &Moment, before_mps: &SimdLanes, late_s: &SimdLanes) -> [SimdLanes; 2] {
        let span_s = self.judged_steps as f32 * self.step_s;
        let brake_mps2 = lane(|l| ((before_mps[l] - then.leader_mps[l]) / span_s).clamp(0.0, HARDEST_MPS2 as f32));
        // The leader brakes until now or until it has stopped.
        let braked_s = lane(|l| {
            let standstill_wait_s = late_s[l].min(then.leader_mps[l] / brake_mps2[l]);
            if brake_mps2[l] > 0.0 { standstill_wait_s } else { late_s[l] }
        });
        let now_mps = lane(|l| (then.leader_mps[l] - brake_mps2[l] * braked_s[l]).max(0.0));
        let gap_m = lane(|l| {
            let his_way_m = (then.leader_mps[l] + now_mps[l]) / 2.0 * braked_s[l];
            then.gap_m[l] + his_way_m - (self.way_m[l] - then.way_m[l])
        });
        let is_late = |l: usize| late_s[l] > 0.0;
        [
            lane(|l| if is_late(l) { gap_m[l] } else { then.gap_m[l] }),
            lane(|l| if is_late(l) { now_mps[l] } else { then.leader_mps[l] }),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anticipation::{LateSight, brake_mps2};

    #[test]
    fn steady_braking_is_anticipated_exactly_and_seen_at_once_without_delay() {
        let mut view = LateView::new(2.0, 0.1);
        view.set(3, 1.0);
        assert!(!view.is_prompt());
        // The ego drives at 10 m/s; the leader brakes with 2 m/s² from 10 m/s, 20 m ahead at the start.
        let at = |t: f32| (splat(20.0 - t * t), splat(10.0 - 2.0 * t));
        for k in 0..30 {
            let (gap_m, leader_mps) = at(k as f32 * 0.1);
            let [gaps_m, leaders_mps] = view.see(&gap_m, &leader_mps);
            assert_eq!((gaps_m[0], leaders_mps[0]), (gap_m[0], leader_mps[0]));
            if k > 12 {
                assert!((gaps_m[3] - gap_m[3]).abs() < 1e-3, "{k}: {} {}", gaps_m[3], gap_m[3]);
                assert!((leaders_mps[3] - leader_mps[3]).abs() < 1e-4);
            }
            view.drive(&splat(10.0));
        }
    }

    #[test]
    fn vectors_anticipate_as_one_driver_does() {
        let mut view = LateView::new(2.0, 0.1);
        (0..LANES).for_each(|l| view.set(l, 0.1 * l as f64));
        let leader_mps = |k: usize| 3.5 + 2.5 * (0.31 * k as f64).sin() - 0.8 * (0.9 * k as f64).cos();
        let gap_m = |k: usize| 12.0 + 3.0 * (0.2 * k as f64).cos();
        let own_mps = |k: usize| 4.0 + 0.02 * k as f64;
        for k in 0..80 {
            let seen = view.see(&splat(gap_m(k) as f32), &splat(leader_mps(k) as f32));
            view.drive(&splat(own_mps(k) as f32));
            if k < 20 {
                continue;
            }
            for (late, (seen_m, seen_mps)) in seen[0].iter().zip(seen[1]).enumerate().skip(1) {
                let then = k - late;
                let sight = LateSight {
                    gap_m: gap_m(then),
                    leader_mps: leader_mps(then),
                    brake_mps2: brake_mps2(leader_mps(then - 2), leader_mps(then), 0.2),
                    late_s: 0.1 * late as f64,
                    own_way_m: (then..k).map(|k| 0.1 * own_mps(k)).sum(),
                };
                let [gap_m, leader_mps] = sight.anticipated();
                // Single precision over a way of up to 40 m.
                assert!((f64::from(*seen_m) - gap_m).abs() < 1e-3, "{k}, {late}");
                assert!((f64::from(seen_mps) - leader_mps).abs() < 1e-3, "{k}, {late}");
            }
        }
    }

    #[test]
    fn a_leaders_braking_is_noticed_one_reaction_time_later() {
        let mut view = LateView::new(2.0, 0.1);
        view.set(0, 0.7);
        let noticed = (0..40).find(|k| {
            let braked_s = (*k as f32 - 20.0).max(0.0) * 0.1;
            let [_, leaders_mps] = view.see(&splat(20.0), &splat(10.0 - 3.0 * braked_s));
            view.drive(&splat(10.0));
            leaders_mps[0] < 9.99
        });
        // Braking begins after step 20 and is first visible in step 21; it is noticed 7 steps later.
        assert_eq!(noticed, Some(28));
    }

    #[test]
    fn a_new_driver_remembers_nothing_of_the_previous_one() {
        let mut view = LateView::new(2.0, 0.1);
        view.set(0, 1.5);
        (0..50).for_each(|_| {
            view.see(&splat(5.0), &splat(1.0));
        });
        let before = view.clone();
        view.copy_lane(0, &before, 0);
        let [gaps_m, leaders_mps] = view.see(&splat(80.0), &splat(9.0));
        assert_eq!((gaps_m[0], leaders_mps[0]), (80.0, 9.0));
    }
}
