//! Surrogate safety measures: near crashes, hard braking and stops. In: gaps and closing speeds of the ego with its neighbours,
//! sums of all vehicles, step by step. Out: [`Conflicts`]. Measures as in docs/references.md (surrogate safety). SI.

use super::TrafficTotals;
use serde::{Deserialize, Serialize};

/// Time to collision below which an approach is a near miss, s.
const NEAR_MISS_S: f64 = 1.5;

/// Source of the ego's speed in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DrivenBy {
    /// The driver's own car-following, before the first advice or when not following it.
    Model,
    /// Advice that the driver follows.
    Advice,
    /// The distance that drivers keep to their leader, at a lower speed than advised.
    Distance,
    /// The guard against a collision, at a lower speed than advised.
    Guard,
}

/// A pair of vehicles, one behind the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Gap from bumper to bumper, metres.
    pub gap_m: f64,
    /// Speed of the rear vehicle less the speed of the front one, m/s.
    pub closing_mps: f64,
}

impl Approach {
    /// Returns the time to collision at constant speeds, s; `None` if the gap does not close (Hayward 1972).
    pub fn time_to_collision_s(&self) -> Option<f64> {
        (self.closing_mps > 0.0).then(|| self.gap_m.max(0.0) / self.closing_mps)
    }

    /// Returns the deceleration rate to avoid a crash, m/s2: half the square of the closing speed over the gap (Cooper and
    /// Ferguson 1976).
    pub fn drac_mps2(&self) -> f64 {
        let closing = self.closing_mps.max(0.0);
        if closing == 0.0 { 0.0 } else { closing * closing / (2.0 * self.gap_m.max(1e-3)) }
    }
}

/// Surrogate safety measures of a drive.
// Without `serde(default)`, which would read zeros from a result that has none of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conflicts {
    /// Smallest time to collision of the ego with its leader and of the follower with the ego, s; `None` if the gaps never
    /// closed.
    pub min_ttc_to_neighbours_s: Option<f64>,
    /// Largest deceleration rate to avoid a crash of the same pairs, m/s2.
    pub max_drac_to_neighbours_mps2: f64,
    /// Approaches of the same pairs with a time to collision below 1.5 s.
    pub close_approaches: u32,
    /// Brakings of any vehicle beyond 3 m/s2, per vehicle kilometre.
    pub hard_brakings_per_km: f64,
    /// Stops of any vehicle, per vehicle kilometre.
    pub stops_per_km: f64,
    /// Share of the steps with advice in which the advice set the speed, 0 to 1; `None` without advice or if unknown.
    pub advice_share: Option<f64>,
    /// Share of these steps in which the guard against a collision set the speed.
    pub guard_share: Option<f64>,
    /// Share of these steps in which the driver's distance to the leader set the speed.
    pub distance_share: Option<f64>,
}

/// Collects [`Conflicts`] step by step.
#[derive(Clone, Debug, Default)]
pub struct ConflictTotals {
    /// True during a near miss, with the leader and with the follower.
    is_near: [bool; 2],
    min_ttc_to_neighbours_s: Option<f64>,
    max_drac_to_neighbours_mps2: f64,
    close_approaches: u32,
    /// Number of steps driven by advice, distance, guard, model.
    driven: [u64; 4],
}

impl ConflictTotals {
    /// Adds a step: the ego behind its leader, its follower behind the ego, and the source of the ego's speed if there is
    /// advice.
    pub fn approach(&mut self, pairs: [Option<Approach>; 2], driven_by: Option<DrivenBy>) {
        for (pair, is_near) in pairs.into_iter().zip(&mut self.is_near) {
            let Some(pair) = pair else {
                *is_near = false;
                continue;
            };
            let ttc_s = pair.time_to_collision_s();
            if let Some(ttc_s) = ttc_s {
                self.min_ttc_to_neighbours_s =
                    Some(self.min_ttc_to_neighbours_s.map_or(ttc_s, |least| least.min(ttc_s)));
            }
            self.max_drac_to_neighbours_mps2 = self.max_drac_to_neighbours_mps2.max(pair.drac_mps2());
            let now = ttc_s.is_some_and(|ttc_s| ttc_s < NEAR_MISS_S);
            self.close_approaches += u32::from(now && !*is_near);
            *is_near = now;
        }
        if let Some(driven_by) = driven_by {
            let place = match driven_by {
                DrivenBy::Advice => 0,
                DrivenBy::Distance => 1,
                DrivenBy::Guard => 2,
                DrivenBy::Model => 3,
            };
            self.driven[place] += 1;
        }
    }

    /// Returns the measures of the steps so far, with those of all vehicles from their sums.
    pub fn conflicts(&self, traffic: &TrafficTotals) -> Conflicts {
        let steps: u64 = self.driven.iter().sum();
        let share = |place: usize| (steps > 0).then(|| self.driven[place] as f64 / steps as f64);
        Conflicts {
            min_ttc_to_neighbours_s: self.min_ttc_to_neighbours_s,
            max_drac_to_neighbours_mps2: self.max_drac_to_neighbours_mps2,
            close_approaches: self.close_approaches,
            hard_brakings_per_km: traffic.per_km(traffic.hard_brakings),
            stops_per_km: traffic.per_km(traffic.stops),
            advice_share: share(0),
            distance_share: share(1),
            guard_share: share(2),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(gap_m: f64, closing_mps: f64) -> [Option<Approach>; 2] {
        [Some(Approach { gap_m, closing_mps }), None]
    }

    #[test]
    fn approaches_are_measured_as_by_hand() {
        let mut totals = ConflictTotals::default();
        for (gap_m, closing_mps) in [(20.0, 2.0), (4.0, 4.0), (3.6, 4.0), (10.0, -1.0), (2.0, 2.0)] {
            totals.approach(pair(gap_m, closing_mps), Some(DrivenBy::Advice));
        }
        totals.approach([None; 2], Some(DrivenBy::Guard));
        let found = totals.conflicts(&TrafficTotals::new(0.1));
        assert!((found.min_ttc_to_neighbours_s.unwrap() - 0.9).abs() < 1e-12);
        // 4^2 / (2 x 3.6).
        assert!((found.max_drac_to_neighbours_mps2 - 2.222_222).abs() < 1e-5);
        assert_eq!(found.close_approaches, 2, "one approach of two steps, and another");
        assert!((found.advice_share.unwrap() - 5.0 / 6.0).abs() < 1e-12);
        assert!((found.guard_share.unwrap() - 1.0 / 6.0).abs() < 1e-12 && found.distance_share == Some(0.0));
        let never = ConflictTotals::default().conflicts(&TrafficTotals::new(0.1));
        assert_eq!(
            (never.min_ttc_to_neighbours_s, never.max_drac_to_neighbours_mps2, never.advice_share),
            (None, 0.0, None)
        );
    }
}
