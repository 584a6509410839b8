//! FollowerStopper (Stern et al. 2018, eqs. 1-2; docs/references.md: follower-stopper): drive the target speed at a wide gap, the
//! leader's speed at a medium gap, and stop at a small one. In: speed, leader's speed, gap. Out: a speed.
//!
//! The command is advice; how fast a vehicle reaches it depends on the driver. The authors' car reached it at once through a controller
//! of its own. That is the driver `exact` with a response time of half a second: `--driver exact --ego-response 0.5` in `codrive
//! evaluate` and `codrive tune`, `follow = "exact"` and `ego_response_s = 0.5` in a training's configuration.

use super::parameters::{GAIN, Order, Parameter, Parametric, SPEED};
use crate::policy::{Action, Observation, Policy};
use serde::{Deserialize, Serialize};

/// The controller, which has no state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FollowerStopper {
    /// Target speed at a wide gap, m/s.
    pub aim_mps: f64,
    /// Gaps at zero relative speed that separate the regions, m, ascending.
    pub dx0_m: [f64; 3],
    /// Decelerations that curve the borders of the regions, m/s², not ascending, so that the borders never cross.
    pub d_mps2: [f64; 3],
}

const REGIONS: &str =
    "Gaps at equal speeds up to which the command is 0, at most the leader's speed, and at most the aim";
const CURVES: &str = "Deceleration that widens each of these gaps while closing in";

impl Parametric for FollowerStopper {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter { key: "aim_mps", doc: "Target speed if the gap allows it", ..SPEED },
        Parameter { key: "dx0_m.0", doc: REGIONS, unit: "m", limits: [0.0, 100.0], search: [0.5, 15.0], ..GAIN },
        Parameter {
            key: "dx0_m.1",
            doc: REGIONS,
            unit: "m",
            limits: [0.0, 100.0],
            search: [0.6, 20.0],
            order: Order::Above,
            ..GAIN
        },
        Parameter {
            key: "dx0_m.2",
            doc: REGIONS,
            unit: "m",
            limits: [0.0, 100.0],
            search: [0.7, 30.0],
            order: Order::Above,
            ..GAIN
        },
        Parameter { key: "d_mps2.0", doc: CURVES, unit: "m/s2", limits: [0.01, 20.0], search: [0.1, 5.0], ..GAIN },
        Parameter {
            key: "d_mps2.1",
            doc: CURVES,
            unit: "m/s2",
            limits: [0.01, 20.0],
            search: [0.1, 5.0],
            order: Order::NotAbove,
            ..GAIN
        },
        Parameter {
            key: "d_mps2.2",
            doc: CURVES,
            unit: "m/s2",
            limits: [0.01, 20.0],
            search: [0.1, 5.0],
            order: Order::NotAbove,
            ..GAIN
        },
    ];

    fn numbers(&self) -> Vec<f64> {
        [&[self.aim_mps][..], &self.dx0_m, &self.d_mps2].concat()
    }

    fn of(x: &[f64]) -> Self {
        Self { aim_mps: x[0], dx0_m: [x[1], x[2], x[3]], d_mps2: [x[4], x[5], x[6]] }
    }
}

impl FollowerStopper {
    /// Returns the controller with its authors' regions.
    pub fn published(aim_mps: f64) -> Self {
        Self { aim_mps, dx0_m: [4.5, 5.25, 6.0], d_mps2: [1.5, 1.0, 0.5] }
    }

    /// Returns the commanded speed, m/s.
    pub fn command_mps(&self, observation: &Observation) -> f64 {
        let Observation { speed_mps, leader_speed_mps, gap_m, .. } = *observation;
        let closing = (leader_speed_mps - speed_mps).min(0.0);
        let border = |k: usize| self.dx0_m[k] + closing * closing / (2.0 * self.d_mps2[k]);
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
        let policy = FollowerStopper::published(4.3);
        policy.command_mps(&Observation { speed_mps, leader_speed_mps, gap_m, ..Observation::default() })
    }

    #[test]
    fn the_regions_meet_at_their_borders() {
        // At zero relative speed the borders are at 4.5, 5.25 and 6 m.
        assert_eq!(command(3.0, 3.0, 4.5), 0.0);
        assert!((command(3.0, 3.0, 5.25) - 3.0).abs() < 1e-12);
        assert!((command(3.0, 3.0, 4.875) - 1.5).abs() < 1e-12);
        assert!((command(3.0, 3.0, 6.0) - 4.3).abs() < 1e-12);
        assert_eq!(command(3.0, 3.0, 50.0), 4.3);
    }

    #[test]
    fn closing_in_asks_for_more_room() {
        // Closing at 2 m/s the borders are at 5.833, 7.25 and 10 m.
        assert_eq!(command(4.0, 2.0, 5.83), 0.0);
        assert!((command(4.0, 2.0, 7.25) - 2.0).abs() < 1e-12);
        assert!((command(4.0, 2.0, 10.0) - 4.3).abs() < 1e-12);
    }

    #[test]
    fn a_faster_leader_is_followed_no_faster_than_the_aim() {
        assert!((command(4.0, 9.0, 5.25) - 4.3).abs() < 1e-12);
    }
}
