//! Actions of a scenario's events: what happens on the road, in the car and on its displays. In: one entry of `actions`. Out: a checked [`Action`].
//! Seconds, metres, m/s.

use super::{FASTEST_MPS, LATEST_S, VehicleName, check_vehicle, within};
use serde::{Deserialize, Serialize};

/// Longest text for the participant, letters: it is read at a glance, beside the speedometer.
const TEXT_LETTERS: usize = 60;
/// Strongest acceleration and braking, m/s2: the bound of all vehicles of the traffic.
const HARDEST_MPS2: f64 = crate::traffic::HARDEST_MPS2;

/// Action of an event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Action {
    /// A vehicle brakes evenly.
    Brake {
        vehicle: VehicleName,
        /// Deceleration, m/s2.
        decel_mps2: f64,
        /// Speed at the end of braking, m/s.
        #[serde(default)]
        to_mps: f64,
        /// Time for which it keeps that speed, s.
        #[serde(default)]
        keep_s: f64,
    },
    /// A vehicle accelerates evenly, as far as the vehicle ahead of it allows.
    Accelerate {
        vehicle: VehicleName,
        /// Acceleration, m/s2.
        accel_mps2: f64,
        /// Speed at the end, m/s.
        to_mps: f64,
        /// Time for which it keeps that speed, s.
        #[serde(default)]
        keep_s: f64,
    },
    /// A vehicle changes lanes as soon as there is room.
    ChangeLane {
        vehicle: VehicleName,
        /// Number of lanes, positive to the left.
        to_the_left: i32,
        /// Time in which the change has to begin, s.
        #[serde(default = "usual_change_s")]
        within_s: f64,
    },
    /// A text appears above the participant's speedometer.
    Message {
        text: String,
        /// Duration, s.
        for_s: f64,
    },
    /// The advice of the participant's speedometer disappears.
    HideAdvice {
        /// Duration, s.
        for_s: f64,
    },
}

fn usual_change_s() -> f64 {
    5.0
}

impl Action {
    /// Returns the vehicle that acts; `None` for an action on the participant.
    pub fn vehicle(&self) -> Option<&VehicleName> {
        match self {
            Self::Brake { vehicle, .. } | Self::Accelerate { vehicle, .. } | Self::ChangeLane { vehicle, .. } => {
                Some(vehicle)
            }
            Self::Message { .. } | Self::HideAdvice { .. } => None,
        }
    }

    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        match self {
            Self::Brake { decel_mps2: rate_mps2, to_mps, keep_s, .. }
            | Self::Accelerate { accel_mps2: rate_mps2, to_mps, keep_s, .. } => {
                let rate = if matches!(self, Self::Brake { .. }) { "decel_mps2" } else { "accel_mps2" };
                within(rate, *rate_mps2, [0.1, HARDEST_MPS2])?;
                within("to_mps", *to_mps, [0.0, FASTEST_MPS])?;
                within("keep_s", *keep_s, [0.0, LATEST_S])?;
            }
            Self::ChangeLane { to_the_left, within_s, .. } => {
                if *to_the_left == 0 || to_the_left.abs() > 10 {
                    return Err(format!("to_the_left is {to_the_left}; allowed: -10 to 10, but for 0"));
                }
                within("within_s", *within_s, [0.1, 600.0])?;
            }
            Self::Message { text, for_s } => {
                let letters = text.chars().count();
                if text.trim().is_empty() || letters > TEXT_LETTERS {
                    return Err(format!("text has {letters} letters; allowed: 1 to {TEXT_LETTERS}"));
                }
                within("for_s", *for_s, [0.1, LATEST_S])?;
            }
            Self::HideAdvice { for_s } => within("for_s", *for_s, [0.1, LATEST_S])?,
        }
        self.vehicle().map_or(Ok(()), |name| check_vehicle("vehicle", name))
    }
}
