//! Motions of road users by a scenario's events: changes of speed and lane with a shape, meetings, ways on foot. In: an action's table. Out: checked
//! settings; the words and the shapes are those of OpenSCENARIO XML. Seconds, metres, m/s.

use super::values::{
    EGO_NAME, FARTHEST_M, FASTEST_MPS, LATEST_S, MOST_LANES, VehicleName, check_subject, is_zero, within,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest change of speed per time, m/s2: that of a collision, for scenes from other programs.
const FASTEST_CHANGE_MPS2: f64 = 100.0;
/// Farthest place beside the path, m.
const BESIDE_M: f64 = 100.0;
/// Largest number of points of a way.
const MOST_POINTS: usize = 1000;

/// Shape of a change from its begin to its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChangeShape {
    /// Straight line from the begin to the end.
    #[default]
    Linear,
    /// Cubic polynomial without a slope at both ends.
    Cubic,
    /// Half of a cosine's period.
    Sinusoidal,
}

impl ChangeShape {
    /// Returns the share of the change that is done after a share of its time.
    pub fn done(self, share: f64) -> f64 {
        let t = share.clamp(0.0, 1.0);
        match self {
            Self::Linear => t,
            Self::Cubic => t * t * (3.0 - 2.0 * t),
            Self::Sinusoidal => (1.0 - (PI * t).cos()) / 2.0,
        }
    }

    /// Returns the steepest slope of the shape: 1 for an even change.
    pub fn steepest(self) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Cubic => 1.5,
            Self::Sinusoidal => PI / 2.0,
        }
    }
}

/// Change of the speed of a road user.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedChange {
    /// Vehicle by its place beside the ego, its number, or its name.
    pub vehicle: VehicleName,
    /// Speed at the end, m/s; without `like`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = FASTEST_MPS), extend("unit" = "m/s"))]
    pub to_mps: Option<f64>,
    /// Vehicle whose speed counts in place of `to_mps`; `ego` is the participant's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub like: Option<VehicleName>,
    /// Factor by which that speed is multiplied.
    #[serde(default = "once", skip_serializing_if = "is_once")]
    pub times: f64,
    /// Speed that is added to it, m/s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -FASTEST_MPS, max = FASTEST_MPS), extend("unit" = "m/s"))]
    pub plus_mps: f64,
    /// True to follow that vehicle's speed until another action changes it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub keeps: bool,
    /// Largest change of speed per time, m/s2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = FASTEST_CHANGE_MPS2), extend("unit" = "m/s2"))]
    pub rate_mps2: Option<f64>,
    /// Duration of the change, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = LATEST_S), extend("unit" = "s"))]
    pub in_s: Option<f64>,
    /// Distance of the change, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = FARTHEST_M), extend("unit" = "m"))]
    pub in_m: Option<f64>,
    /// Shape of the change.
    #[serde(default)]
    pub shape: ChangeShape,
}

/// Change of lanes of a vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LaneChange {
    /// Vehicle by its place beside the ego, its number, or its name.
    pub vehicle: VehicleName,
    /// Number of lanes, positive to the left.
    #[serde(default)]
    pub to_the_left: i32,
    /// Vehicle from whose lane the lanes are counted; without it the vehicle itself. For road users.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<VehicleName>,
    /// Time in which the change has to begin, s; road users begin at once.
    #[serde(default = "usual_change_s")]
    #[schemars(range(min = 0.1, max = 600.0), extend("unit" = "s"))]
    pub within_s: f64,
    /// Duration of a road user's change, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = LATEST_S), extend("unit" = "s"))]
    pub in_s: Option<f64>,
    /// Distance of a road user's change, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = FARTHEST_M), extend("unit" = "m"))]
    pub in_m: Option<f64>,
    /// Shape of a road user's change.
    #[serde(default = "usual_shape")]
    pub shape: ChangeShape,
}

/// Shift of a road user within or beside its lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OffsetChange {
    /// Vehicle by its place beside the ego, its number, or its name.
    pub vehicle: VehicleName,
    /// Offset from the middle of its lane at the end, m, positive to the left of the path.
    #[schemars(range(min = -BESIDE_M, max = BESIDE_M), extend("unit" = "m"))]
    pub to_m: f64,
    /// Duration, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = LATEST_S), extend("unit" = "s"))]
    pub in_s: Option<f64>,
    /// Distance, m; the shift then waits while the road user stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = FARTHEST_M), extend("unit" = "m"))]
    pub in_m: Option<f64>,
    /// Shape of the shift.
    #[serde(default = "usual_shape")]
    pub shape: ChangeShape,
}

/// Change of the speed of a road user, so that it meets another vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Meeting {
    /// Vehicle by its place beside the ego, its number, or its name.
    pub vehicle: VehicleName,
    /// Place of its front on the ego's path at the meeting, m.
    #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
    pub place_m: f64,
    /// Other vehicle; `ego` is the participant's.
    pub with: VehicleName,
    /// Place of the other vehicle's front on the ego's path at the meeting, m.
    #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
    pub with_place_m: f64,
    /// Speed at the meeting, m/s; without it any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = FASTEST_MPS), extend("unit" = "m/s"))]
    pub to_mps: Option<f64>,
}

/// Way of a road user along a line of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Walk {
    /// Vehicle by its place beside the ego, its number, or its name.
    pub vehicle: VehicleName,
    /// Points: place on the ego's path and offset from it to the left, m.
    pub points: Vec<[f64; 2]>,
}

/// Move of a road user to another place at once; its speed stays as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Teleport {
    /// Vehicle by its place beside the ego, its number, or its name.
    pub vehicle: VehicleName,
    /// Place of its front on the ego's path, m.
    #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
    pub place_m: f64,
    /// Number of lanes to the left of the path's lane, negative to the right.
    #[serde(default)]
    pub lanes_left: i32,
    /// Offset from the middle of that lane, m, positive to the left of the path.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -BESIDE_M, max = BESIDE_M), extend("unit" = "m"))]
    pub offset_m: f64,
    /// True for a road user that then heads and drives against the path.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub against: bool,
}

fn once() -> f64 {
    1.0
}

fn is_once(value: &f64) -> bool {
    *value == 1.0
}

fn usual_change_s() -> f64 {
    5.0
}

fn usual_shape() -> ChangeShape {
    ChangeShape::Sinusoidal
}

/// Checks that at most one of these extents is stated, and that it is within its bounds.
fn check_extent(extents: &[(&str, Option<f64>, f64)]) -> Result<(), String> {
    let stated: Vec<&str> = extents.iter().filter(|extent| extent.1.is_some()).map(|extent| extent.0).collect();
    if stated.len() > 1 {
        return Err(format!("{} together; allowed: one of them", stated.join(" and ")));
    }
    extents.iter().try_for_each(|(key, value, most)| value.map_or(Ok(()), |value| within(key, value, [0.01, *most])))
}

impl SpeedChange {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        let extents = [
            ("rate_mps2", self.rate_mps2, FASTEST_CHANGE_MPS2),
            ("in_s", self.in_s, LATEST_S),
            ("in_m", self.in_m, FARTHEST_M),
        ];
        check_extent(&extents)?;
        match (&self.to_mps, &self.like) {
            (Some(to_mps), None) => {
                let changed = [("times", self.times != 1.0), ("plus_mps", self.plus_mps != 0.0), ("keeps", self.keeps)];
                if let Some((key, _)) = changed.iter().find(|(_, is_changed)| *is_changed) {
                    return Err(format!("{key} without like; allowed: with like = \"{}\"", EGO_NAME));
                }
                within("to_mps", *to_mps, [0.0, FASTEST_MPS])
            }
            (None, Some(like)) => {
                within("times", self.times, [0.0, 100.0])?;
                within("plus_mps", self.plus_mps, [-FASTEST_MPS, FASTEST_MPS])?;
                check_subject("like", like)
            }
            _ => Err("allowed: one of to_mps (m/s) and like (another vehicle)".into()),
        }
    }
}

impl LaneChange {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        if (self.to_the_left == 0 && self.of.is_none()) || self.to_the_left.abs() > 10 {
            return Err(format!("to_the_left is {}; allowed: -10 to 10, but for 0", self.to_the_left));
        }
        within("within_s", self.within_s, [0.1, 600.0])?;
        check_extent(&[("in_s", self.in_s, LATEST_S), ("in_m", self.in_m, FARTHEST_M)])?;
        self.of.as_ref().map_or(Ok(()), |of| check_subject("of", of))
    }

    /// Checks whether settings are stated that only road users have.
    pub(crate) fn is_for_road_users(&self) -> bool {
        self.of.is_some() || self.in_s.is_some() || self.in_m.is_some() || self.shape != usual_shape()
    }
}

impl OffsetChange {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        within("to_m", self.to_m, [-BESIDE_M, BESIDE_M])?;
        check_extent(&[("in_s", self.in_s, LATEST_S), ("in_m", self.in_m, FARTHEST_M)])
    }
}

impl Meeting {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        within("place_m", self.place_m, [0.0, FARTHEST_M])?;
        within("with_place_m", self.with_place_m, [0.0, FARTHEST_M])?;
        within("to_mps", self.to_mps.unwrap_or(0.0), [0.0, FASTEST_MPS])?;
        check_subject("with", &self.with)
    }
}

impl Teleport {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        within("place_m", self.place_m, [0.0, FARTHEST_M])?;
        within("lanes_left", f64::from(self.lanes_left), [-f64::from(MOST_LANES), MOST_LANES.into()])?;
        within("offset_m", self.offset_m, [-BESIDE_M, BESIDE_M])
    }
}

impl Walk {
    /// Checks the values of the action.
    pub(super) fn check(&self) -> Result<(), String> {
        if self.points.len() < 2 || self.points.len() > MOST_POINTS {
            return Err(format!("points has {}; allowed: 2 to {MOST_POINTS}", self.points.len()));
        }
        self.points.iter().try_for_each(|[place_m, offset_m]| {
            within("points: place", *place_m, [0.0, FARTHEST_M])?;
            within("points: offset", *offset_m, [-BESIDE_M, BESIDE_M])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_begin_and_end_without_a_jump_and_are_half_done_in_the_middle() {
        for shape in [ChangeShape::Linear, ChangeShape::Cubic, ChangeShape::Sinusoidal] {
            let done = [-1.0, 0.0, 0.5, 1.0, 2.0].map(|share| shape.done(share));
            assert!((done[2] - 0.5).abs() < 1e-12, "{shape:?}: {done:?}");
            assert_eq!([done[0], done[1], done[3], done[4]], [0.0, 0.0, 1.0, 1.0], "{shape:?}");
            let slope = (shape.done(0.500_1) - shape.done(0.499_9)) / 0.000_2;
            assert!((slope - shape.steepest()).abs() < 1e-6, "{shape:?}: {slope}");
        }
    }

    #[test]
    fn a_change_of_speed_needs_one_target_and_at_most_one_extent() {
        let read = |text: &str| toml::from_str::<SpeedChange>(&format!("vehicle = \"a\"\n{text}")).expect("an action");
        for text in ["to_mps = 10", "to_mps = 0\nrate_mps2 = 4", "like = \"ego\"\ntimes = 1.2\nkeeps = true"] {
            assert_eq!(read(text).check(), Ok(()), "{text}");
        }
        for (text, part) in [
            ("", "one of to_mps"),
            ("to_mps = 3\nlike = \"ego\"", "one of to_mps"),
            ("to_mps = 3\ntimes = 2", "times without like"),
            ("to_mps = 3\nin_s = 1\nin_m = 2", "in_s and in_m together"),
            ("to_mps = 71", "to_mps is 71"),
        ] {
            assert!(read(text).check().unwrap_err().contains(part), "{text}: {:?}", read(text).check());
        }
    }
}
