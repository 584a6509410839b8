//! Anticipation of a leader that a driver sees late (Treiber, Kesting, Helbing 2006, "Delays, inaccuracies and anticipation in microscopic
//! traffic models"). In: gap and speed of the leader a reaction time ago. Out: those that the driver assumes now. SI units.

/// Span over which drivers judge whether their leader brakes, s.
pub const JUDGED_S: f64 = 0.2;
/// Largest deceleration that drivers assume of a leader, m/s2.
pub const HARDEST_MPS2: f64 = 9.0;

/// Leader as seen a reaction time ago.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateSight {
    /// Gap to the leader then, m.
    pub gap_m: f64,
    /// Speed of the leader then, m/s.
    pub leader_mps: f64,
    /// Deceleration of the leader then, m/s2, from [`brake_mps2`].
    pub brake_mps2: f64,
    /// Time since then, s.
    pub late_s: f64,
    /// Own way since then, m.
    pub own_way_m: f64,
}

/// Returns the deceleration of a leader whose speed changed so in `judged_s`, m/s2; an acceleration is not extrapolated and counts as 0.
pub fn brake_mps2(earlier_mps: f64, later_mps: f64, judged_s: f64) -> f64 {
    ((earlier_mps - later_mps) / judged_s).clamp(0.0, HARDEST_MPS2)
}

impl LateSight {
    /// Returns the gap, m, and the leader's speed, m/s, extrapolated to now. The leader brakes until now, or until it stands.
    pub fn anticipated(&self) -> [f64; 2] {
        let Self { gap_m, leader_mps, brake_mps2, late_s, own_way_m } = *self;
        let braked_s = if brake_mps2 > 0.0 { late_s.min(leader_mps / brake_mps2) } else { late_s };
        let now_mps = (leader_mps - brake_mps2 * braked_s).max(0.0);
        let leader_way_m = (leader_mps + now_mps) / 2.0 * braked_s;
        [gap_m + leader_way_m - own_way_m, now_mps]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_braking_leader_is_anticipated_until_it_stands() {
        // From 4 m/s with 2 m/s2: after 1 s it has driven 3 m and has 2 m/s; it stands after 2 s and 4 m, and stays there.
        let seen = |late_s: f64| LateSight {
            gap_m: 10.0,
            leader_mps: 4.0,
            brake_mps2: brake_mps2(4.4, 4.0, 0.2),
            late_s,
            own_way_m: 1.5,
        };
        for (late_s, expected) in [(0.0, [8.5, 4.0]), (1.0, [11.5, 2.0]), (2.0, [12.5, 0.0]), (3.0, [12.5, 0.0])] {
            let anticipated = seen(late_s).anticipated();
            assert!((anticipated[0] - expected[0]).abs() < 1e-9, "{late_s}: {anticipated:?}");
            assert!((anticipated[1] - expected[1]).abs() < 1e-9, "{late_s}: {anticipated:?}");
        }
    }

    #[test]
    fn a_leader_that_speeds_up_is_taken_to_keep_its_speed() {
        assert_eq!(brake_mps2(3.0, 4.0, 0.2), 0.0);
        let seen = LateSight { gap_m: 10.0, leader_mps: 4.0, brake_mps2: 0.0, late_s: 1.5, own_way_m: 9.0 };
        assert_eq!(seen.anticipated(), [7.0, 4.0]);
        // More than the brakes of a car can do is not assumed.
        assert_eq!(brake_mps2(30.0, 0.0, 0.2), 9.0);
    }
}
