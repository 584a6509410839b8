//! FollowerStopper (Stern et al. 2018, eqs. 1-2; docs/references.md: follower-stopper): drive the aim where the gap is
//! wide, follow the leader's speed where it is not, stop where it is closed. In: speed, leader's speed, gap. Out: a
//! speed.

use super::{Action, Observation, Policy};

/// Gaps at zero relative speed that divide the regions, metres.
const DX0_M: [f64; 3] = [4.5, 5.25, 6.0];
/// Decelerations that curve the regions' borders, m/s2.
const D_MPS2: [f64; 3] = [1.5, 1.0, 0.5];

/// The controller; it keeps no state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowerStopper {
    /// Speed wanted where the gap allows, m/s.
    pub aim_mps: f64,
}

impl FollowerStopper {
    /// The commanded speed, m/s.
    pub fn command_mps(&self, observation: &Observation) -> f64 {
        let Observation { speed_mps, leader_speed_mps, gap_m, .. } = *observation;
        let closing = (leader_speed_mps - speed_mps).min(0.0);
        let border = |k: usize| DX0_M[k] + closing * closing / (2.0 * D_MPS2[k]);
        let (dx1, dx2, dx3) = (border(0), border(1), border(2));
        let follow = leader_speed_mps.max(0.0).min(self.aim_mps);
        if gap_m <= dx1 {
            0.0
        } else if gap_m <= dx2 {
            follow * (gap_m - dx1) / (dx2 - dx1)
        } else if gap_m <= dx3 {
            follow + (self.aim_mps - follow) * (gap_m - dx2) / (dx3 - dx2)
        } else {
            self.aim_mps
        }
    }
}

impl Policy for FollowerStopper {
    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        Action::Speed(self.command_mps(observation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(speed_mps: f64, leader_speed_mps: f64, gap_m: f64) -> f64 {
        let policy = FollowerStopper { aim_mps: 4.3 };
        policy.command_mps(&Observation { speed_mps, leader_speed_mps, gap_m, ..Observation::default() })
    }

    #[test]
    fn the_regions_meet_at_their_borders() {
        // No relative speed: borders at 4.5, 5.25 and 6 m.
        assert_eq!(command(3.0, 3.0, 4.5), 0.0);
        assert!((command(3.0, 3.0, 5.25) - 3.0).abs() < 1e-12);
        assert!((command(3.0, 3.0, 4.875) - 1.5).abs() < 1e-12);
        assert!((command(3.0, 3.0, 6.0) - 4.3).abs() < 1e-12);
        assert_eq!(command(3.0, 3.0, 50.0), 4.3);
    }

    #[test]
    fn closing_in_asks_for_more_room() {
        // 2 m/s closing: borders at 5.833, 7.25 and 10 m.
        assert_eq!(command(4.0, 2.0, 5.83), 0.0);
        assert!((command(4.0, 2.0, 7.25) - 2.0).abs() < 1e-12);
        assert!((command(4.0, 2.0, 10.0) - 4.3).abs() < 1e-12);
    }

    #[test]
    fn a_faster_leader_is_followed_no_faster_than_the_aim() {
        assert!((command(4.0, 9.0, 5.25) - 4.3).abs() < 1e-12);
    }
}
