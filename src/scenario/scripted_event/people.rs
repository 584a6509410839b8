//! People of a scenario's events: a pedestrian who crosses the ego's route, a cyclist who rides along it. In: an action's table. Out: checked
//! settings; the world moves the person. Metres, m/s.

use super::{FARTHEST_M, within};
use crate::map::network::Side;
use serde::{Deserialize, Serialize};

/// Lowest and highest speed of a person on foot, m/s: from a slow walk to a run.
const ON_FOOT_MPS: [f64; 2] = [0.3, 5.0];
/// Lowest and highest speed of a cyclist, m/s.
const RIDING_MPS: [f64; 2] = [1.5, 12.0];
/// Shortest and longest ride on the road, m.
const RIDE_M: [f64; 2] = [10.0, 10_000.0];

/// Pedestrian who waits beside the road and crosses it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PedestrianCrossing {
    /// Place on the ego's route, m.
    #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
    pub place_m: f64,
    /// Side of the route on which the pedestrian waits.
    pub from: Side,
    /// Walking speed, m/s.
    #[serde(default = "usual_walk_mps")]
    #[schemars(range(min = ON_FOOT_MPS[0], max = ON_FOOT_MPS[1]), extend("unit" = "m/s"))]
    pub speed_mps: f64,
}

/// Cyclist who waits beside the road and rides along its near edge in the ego's direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CyclistRide {
    /// Place on the ego's route at which the ride begins, m.
    #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
    pub place_m: f64,
    /// Length of the ride on the road, m.
    #[serde(default = "usual_ride_m")]
    #[schemars(range(min = RIDE_M[0], max = RIDE_M[1]), extend("unit" = "m"))]
    pub for_m: f64,
    /// Riding speed, m/s.
    #[serde(default = "usual_riding_mps")]
    #[schemars(range(min = RIDING_MPS[0], max = RIDING_MPS[1]), extend("unit" = "m/s"))]
    pub speed_mps: f64,
}

/// Returns the usual walking speed (docs/references.md: walkers).
fn usual_walk_mps() -> f64 {
    1.4
}

/// Returns the usual riding speed (docs/references.md: walkers).
fn usual_riding_mps() -> f64 {
    5.0
}

fn usual_ride_m() -> f64 {
    150.0
}

impl PedestrianCrossing {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        within("place_m", self.place_m, [0.0, FARTHEST_M])?;
        within("speed_mps", self.speed_mps, ON_FOOT_MPS)
    }
}

impl CyclistRide {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        within("place_m", self.place_m, [0.0, FARTHEST_M])?;
        within("for_m", self.for_m, RIDE_M)?;
        within("speed_mps", self.speed_mps, RIDING_MPS)
    }
}
