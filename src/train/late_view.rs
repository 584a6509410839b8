//! The leaders as late drivers see them. In: gaps and speeds of sixteen rings, step by step. Out: gaps and leaders' speeds by
//! which each ego acts: what was a reaction time ago, carried on to now as a driver anticipates it (Treiber, Kesting, Helbing
//! 2006), as [`crate::driver`] does in whole drives. Metres, m/s.

use super::simd::{LANES, SimdLanes, lane, splat};
use serde::{Deserialize, Serialize};

/// Span over which a leader's braking is judged, s.
const JUDGED_S: f32 = 0.2;
/// Hardest braking that is believed, m/s2.
const HARDEST_MPS2: f32 = 9.0;

/// One step, as it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Moment {
    gap_m: SimdLanes,
    leader_mps: SimdLanes,
    /// Way of the ego until then.
    way_m: SimdLanes,
}

/// What the egos' drivers remember of the leaders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LateView {
    step_s: f32,
    judged_steps: usize,
    /// A ring buffer; the newest stands at `newest`.
    moments: Vec<Moment>,
    newest: usize,
    /// Steps by which each driver is late.
    late: [u32; LANES],
    /// Steps that each driver has seen.
    seen: [u32; LANES],
    way_m: SimdLanes,
}

impl LateView {
    /// Drivers who are late by at most `longest_s`, in steps of `step_s`; none is yet.
    pub fn new(longest_s: f64, step_s: f64) -> Self {
        let judged_steps = (f64::from(JUDGED_S) / step_s).round().max(1.0) as usize;
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

    /// A driver in lane `l` who is late by `late_s` and has seen nothing yet.
    pub fn set(&mut self, l: usize, late_s: f64) {
        let most = self.moments.len() - self.judged_steps - 1;
        self.late[l] = ((late_s / f64::from(self.step_s)).round() as u32).min(most as u32);
        self.forget(l);
    }

    /// Takes over the driver of another block's lane, who has seen nothing yet.
    pub fn copy_lane(&mut self, l: usize, from: &Self, from_lane: usize) {
        self.late[l] = from.late[from_lane];
        self.forget(l);
    }

    fn forget(&mut self, l: usize) {
        self.seen[l] = 0;
        self.way_m[l] = 0.0;
    }

    /// True if nobody is late.
    pub fn is_prompt(&self) -> bool {
        self.late == [0; LANES]
    }

    /// The egos drive a step at these speeds.
    #[inline(always)]
    pub fn drive(&mut self, ego_mps: &SimdLanes) {
        for (way_m, speed_mps) in self.way_m.iter_mut().zip(ego_mps) {
            *way_m += speed_mps * self.step_s;
        }
    }

    /// Takes in the present; returns gaps and leaders' speeds as the drivers have them in mind.
    #[inline(always)]
    pub fn see(&mut self, gap_m: &SimdLanes, leader_mps: &SimdLanes) -> [SimdLanes; 2] {
        let size = self.moments.len();
        self.newest = if self.newest + 1 == size { 0 } else { self.newest + 1 };
        self.moments[self.newest] = Moment { gap_m: *gap_m, leader_mps: *leader_mps, way_m: self.way_m };
        // Gathered lane by lane: each driver remembers another moment.
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
            // What was seen before is one more than `late` once this step is counted.
            before_mps[l] =
                if self.seen[l] as usize > judged { self.past(judged).leader_mps[l] } else { then.leader_mps[l] };
        }
        self.anticipated(&then, &before_mps, &late_s)
    }

    /// What was `back` steps ago.
    #[inline(always)]
    fn past(&self, back: usize) -> &Moment {
        // Without a division, which takes longer than all the rest.
        let at = self.newest + self.moments.len() - back;
        &self.moments[if at >= self.moments.len() { at - self.moments.len() } else { at }]
    }

    /// Where the leaders are now if they go on as they did then, `late_s` ago; only their braking since the moment before is carried on.
    #[inline(always)]
    fn anticipated(&self, then: &Moment, before_mps: &SimdLanes, late_s: &SimdLanes) -> [SimdLanes; 2] {
        let span_s = self.judged_steps as f32 * self.step_s;
        let brake_mps2 = lane(|l| ((before_mps[l] - then.leader_mps[l]) / span_s).clamp(0.0, HARDEST_MPS2));
        // He brakes until now, or until he stands.
        let braked_s = lane(|l| {
            let until_he_stands_s = late_s[l].min(then.leader_mps[l] / brake_mps2[l]);
            if brake_mps2[l] > 0.0 { until_he_stands_s } else { late_s[l] }
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

    #[test]
    fn a_steadily_braking_leader_is_anticipated_exactly_and_a_prompt_driver_sees_what_is() {
        let mut view = LateView::new(2.0, 0.1);
        view.set(3, 1.0);
        assert!(!view.is_prompt());
        // The ego drives 10 m/s; the leader brakes with 2 m/s2 from 10 m/s, 20 m ahead at the start.
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
    fn a_leader_who_begins_to_brake_is_noticed_a_reaction_time_later() {
        let mut view = LateView::new(2.0, 0.1);
        view.set(0, 0.7);
        let noticed = (0..40).find(|k| {
            let braked_s = (*k as f32 - 20.0).max(0.0) * 0.1;
            let [_, leaders_mps] = view.see(&splat(20.0), &splat(10.0 - 3.0 * braked_s));
            view.drive(&splat(10.0));
            leaders_mps[0] < 9.99
        });
        // Braking begins after step 20 and is first to be seen in step 21: 7 steps later.
        assert_eq!(noticed, Some(28));
    }

    #[test]
    fn whoever_has_just_sat_down_knows_nothing_of_before() {
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
