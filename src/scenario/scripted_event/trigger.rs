//! Triggers of a scenario's events: the conditions at which an event begins. In: the setting `trigger`. Out: a checked [`Trigger`]. Seconds, metres,
//! m/s.

use super::{FARTHEST_M, FASTEST_MPS, LATEST_S, VehicleName, check_ahead, within};
use serde::{Deserialize, Serialize};

/// Condition at which an event begins, evaluated at each step of the traffic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Trigger {
    /// Time since the start of the drive, s.
    TimeS(f64),
    /// Place on the ego's route that its front has reached, m; on a closed route anew in each lap.
    PlaceM(f64),
    /// Speed of the ego above this, m/s.
    SpeedAboveMps(f64),
    /// Speed of the ego below this, m/s.
    SpeedBelowMps(f64),
    /// Distance from the ego's front to a vehicle ahead.
    Distance {
        to: VehicleName,
        /// Distance, m.
        below_m: f64,
    },
    /// Time gap to a vehicle ahead: the distance over the ego's speed.
    TimeGap {
        to: VehicleName,
        /// Time gap, s.
        below_s: f64,
    },
    /// Time to collision with a vehicle ahead: the distance over the closing speed.
    TimeToCollision {
        to: VehicleName,
        /// Time to collision, s.
        below_s: f64,
    },
    /// End of another event, and a delay.
    After {
        /// Name of the other event.
        event: String,
        /// Delay after its end, s.
        #[serde(default)]
        delay_s: f64,
    },
    /// Change of the advice on the speedometer.
    AdviceChanges,
    /// Brake of the ego pressed.
    EgoBrakes,
    /// One or more of these conditions.
    Any(Vec<Trigger>),
    /// All of these conditions at once.
    All(Vec<Trigger>),
}

/// Road of a drive, as far as events depend on it.
#[derive(Clone, Copy, Debug)]
pub struct DrivenRoad {
    /// Length of the ego's route, m.
    pub length_m: f64,
    /// True where vehicles enter and leave.
    pub is_open: bool,
    /// Length of the drive, s; 0 without an end.
    pub duration_s: f64,
}

impl Trigger {
    /// Returns the reason why this trigger cannot come true on a road; `None` if it can.
    pub(super) fn unreachable(&self, road: &DrivenRoad) -> Option<String> {
        match self {
            Self::TimeS(time_s) if road.duration_s > 0.0 && *time_s >= road.duration_s => {
                Some(format!("time_s is {time_s}, and the drive ends at {} s", road.duration_s))
            }
            Self::PlaceM(place_m) if *place_m >= road.length_m => {
                Some(format!("place_m is {place_m}, and the route is {:.1} m long", road.length_m))
            }
            Self::All(list) => list.iter().find_map(|trigger| trigger.unreachable(road)),
            Self::Any(list) => {
                let whys: Option<Vec<String>> = list.iter().map(|trigger| trigger.unreachable(road)).collect();
                whys.map(|whys| whys.join("; "))
            }
            _ => None,
        }
    }

    /// Returns the names of the events after which this trigger can come true.
    pub fn events_before(&self) -> Vec<&str> {
        match self {
            Self::After { event, .. } => vec![event],
            Self::Any(list) | Self::All(list) => list.iter().flat_map(Self::events_before).collect(),
            _ => vec![],
        }
    }

    /// Returns the vehicles that the trigger looks at.
    pub fn vehicles(&self) -> Vec<&VehicleName> {
        match self {
            Self::Distance { to, .. } | Self::TimeGap { to, .. } | Self::TimeToCollision { to, .. } => vec![to],
            Self::Any(list) | Self::All(list) => list.iter().flat_map(Self::vehicles).collect(),
            _ => vec![],
        }
    }

    /// Checks the values of the condition.
    pub(super) fn check(&self) -> Result<(), String> {
        match self {
            Self::TimeS(time_s) => within("time_s", *time_s, [0.0, LATEST_S]),
            Self::PlaceM(place_m) => within("place_m", *place_m, [0.0, FARTHEST_M]),
            Self::SpeedAboveMps(speed_mps) => within("speed_above_mps", *speed_mps, [0.0, FASTEST_MPS]),
            Self::SpeedBelowMps(speed_mps) => within("speed_below_mps", *speed_mps, [0.0, FASTEST_MPS]),
            Self::Distance { to, below_m } => {
                within("below_m", *below_m, [0.1, FARTHEST_M]).and_then(|()| check_ahead(to))
            }
            Self::TimeGap { to, below_s } | Self::TimeToCollision { to, below_s } => {
                within("below_s", *below_s, [0.01, 600.0]).and_then(|()| check_ahead(to))
            }
            Self::After { delay_s, .. } => within("delay_s", *delay_s, [0.0, LATEST_S]),
            Self::AdviceChanges | Self::EgoBrakes => Ok(()),
            Self::Any(list) | Self::All(list) if list.is_empty() => {
                Err("a list of conditions is empty; allowed: one or more".into())
            }
            Self::Any(list) | Self::All(list) => list.iter().try_for_each(Self::check),
        }
    }
}
