//! Limits of triggers: a value below or above a bound, and the distance or the time to a vehicle ahead. In: tables of a trigger. Out: checked limits, and
//! whether a value meets them. Seconds, metres, m/s.

use super::values::{EGO_NAME, FARTHEST_M, VehicleName, check_ahead, check_subject, is_zero, within};
use serde::{Deserialize, Serialize};

/// Distance to a vehicle ahead, on one side of a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistanceAhead {
    /// Vehicle behind; without it the participant's.
    #[serde(default = "ego_name", skip_serializing_if = "is_ego")]
    pub of: VehicleName,
    /// Vehicle by its place beside the ego, its number, or its name.
    pub to: VehicleName,
    /// Upper limit of the distance, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.1, max = FARTHEST_M), extend("unit" = "m"))]
    pub below_m: Option<f64>,
    /// Lower limit of the distance, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.1, max = FARTHEST_M), extend("unit" = "m"))]
    pub above_m: Option<f64>,
    /// Length that is added to the distance from bumper to bumper, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -100.0, max = 100.0), extend("unit" = "m"))]
    pub plus_m: f64,
}

/// Time to a vehicle ahead, on one side of a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeAhead {
    /// Vehicle behind; without it the participant's.
    #[serde(default = "ego_name", skip_serializing_if = "is_ego")]
    pub of: VehicleName,
    /// Vehicle by its place beside the ego, its number, or its name.
    pub to: VehicleName,
    /// Upper limit of the time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
    pub below_s: Option<f64>,
    /// Lower limit of the time, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = 600.0), extend("unit" = "s"))]
    pub above_s: Option<f64>,
    /// Length that is added to the distance from bumper to bumper, m.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -100.0, max = 100.0), extend("unit" = "m"))]
    pub plus_m: f64,
}

pub(super) fn ego_name() -> VehicleName {
    EGO_NAME.into()
}

pub(super) fn is_ego(name: &VehicleName) -> bool {
    name == EGO_NAME
}

/// Limit on one side: a value has to be below the first, or above the second.
pub(super) type Limit = (Option<f64>, Option<f64>);

/// Checks that a limit is stated on one side alone, within these bounds. `unit` ends the names of both sides.
pub(super) fn check_limit((below, above): Limit, unit: &str, bounds: [f64; 2]) -> Result<(), String> {
    match (below, above) {
        (Some(value), None) => within(&format!("below_{unit}"), value, bounds),
        (None, Some(value)) => within(&format!("above_{unit}"), value, bounds),
        _ => Err(format!("allowed: one of below_{unit} and above_{unit}")),
    }
}

/// Returns a limit in words, such as `below 2 s`.
pub(super) fn limit_in_words((below, above): Limit, unit: &str) -> String {
    match (below, above) {
        (Some(value), _) => format!("below {value} {unit}"),
        (None, value) => format!("above {} {unit}", value.unwrap_or(0.0)),
    }
}

impl DistanceAhead {
    /// Checks the values of the limit.
    pub(super) fn check(&self) -> Result<(), String> {
        check_limit((self.below_m, self.above_m), "m", [0.1, FARTHEST_M])?;
        check_pair(&self.of, &self.to, self.plus_m)
    }

    pub(super) fn in_words(&self) -> String {
        let subject = if is_ego(&self.of) { String::new() } else { format!(" from {}", self.of) };
        format!("distance{subject} to {} {}", self.to, limit_in_words((self.below_m, self.above_m), "m"))
    }

    /// Checks a distance from bumper to bumper, m.
    pub fn is_met(&self, gap_m: f64) -> bool {
        is_within((self.below_m, self.above_m), gap_m + self.plus_m)
    }
}

impl TimeAhead {
    pub(super) fn in_words(&self, word: &str) -> String {
        let subject = if is_ego(&self.of) { String::new() } else { format!("of {} ", self.of) };
        format!("{subject}{word} {} {}", self.to, limit_in_words((self.below_s, self.above_s), "s"))
    }

    /// Checks a distance from bumper to bumper, m, that is covered at a speed, m/s. At no speed the time is infinite.
    pub fn is_met(&self, gap_m: f64, speed_mps: f64) -> bool {
        let time_s = if speed_mps > 0.0 { (gap_m + self.plus_m) / speed_mps } else { f64::INFINITY };
        is_within((self.below_s, self.above_s), time_s)
    }

    /// Checks the values of the limit.
    pub(super) fn check(&self) -> Result<(), String> {
        check_limit((self.below_s, self.above_s), "s", [0.01, 600.0])?;
        check_pair(&self.of, &self.to, self.plus_m)
    }
}

/// Checks whether a value is on its side of a limit.
pub(super) fn is_within((below, above): Limit, value: f64) -> bool {
    below.is_none_or(|below| value < below) && above.is_none_or(|above| value > above)
}

/// Checks the names of a vehicle and of one ahead of it, and the length that is added to their distance.
fn check_pair(of: &str, to: &str, plus_m: f64) -> Result<(), String> {
    within("plus_m", plus_m, [-100.0, 100.0])?;
    check_subject("of", of)?;
    if of == to {
        return Err(format!("to is \"{to}\", as of; allowed: another vehicle"));
    }
    if to == EGO_NAME { Ok(()) } else { check_ahead(to) }
}
