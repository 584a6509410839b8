//! Road users that a scenario places beside or on the ego's path, for its events. In: the lists `[[road_user]]` of a scenario file. Out: checked
//! [`RoadUser`]s; the world moves them. Seconds, metres, m/s.
//!
//! A road user has no driver model: it keeps its speed and its lane until an event changes them, as an entity of OpenSCENARIO does.

use super::scripted_event::{DrivenRoad, EGO_NAME, FARTHEST_M, FASTEST_MPS, MOST_LANES, PLACES, within};
use crate::{
    settings::SettingFault,
    traffic::{VehicleBody, VehicleKind},
};
use serde::{Deserialize, Serialize};

/// Key of the list of road users in a scenario.
pub const KEY: &str = "road_user";
/// Largest number of road users of a scenario.
const MOST: usize = 200;
/// Longest name, letters.
const NAME_LETTERS: usize = 40;
/// Share of the length from the front back to the rear axle of a car.
const REAR_AXLE_SHARE: f64 = 0.78;

/// A road user that is placed at the drive's start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoadUser {
    /// Name, unique in the scenario; events name the road user by it.
    pub name: String,
    /// Kind, which selects the model in the picture.
    #[serde(default)]
    pub kind: VehicleKind,
    /// Front on the ego's path, m.
    #[schemars(range(min = 0.0, max = FARTHEST_M), extend("unit" = "m"))]
    pub place_m: f64,
    /// Number of lanes to the left of the path's lane, seen along the path; negative to the right.
    #[serde(default, skip_serializing_if = "is_default")]
    pub lanes_left: i32,
    /// Offset from the middle of that lane, m, positive to the left of the path.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(range(min = -50.0, max = 50.0), extend("unit" = "m"))]
    pub offset_m: f64,
    /// True for one that heads and moves against the path.
    #[serde(default, skip_serializing_if = "is_default")]
    pub against: bool,
    /// Speed at the start, m/s.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(range(min = 0.0, max = FASTEST_MPS), extend("unit" = "m/s"))]
    pub speed_mps: f64,
    /// Length, m; without it that of its kind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Width, m; without it that of its kind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// Height, m; without it that of its kind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// Distance from the front back to the point that follows the lane, m; without it 78 % of the length, as in a car.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rear_axle_m: Option<f64>,
    /// Largest acceleration of its changes of speed, m/s2; those that need more take longer. Without it there is no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_accel_mps2: Option<f64>,
    /// Largest deceleration of its changes of speed, m/s2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_decel_mps2: Option<f64>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl RoadUser {
    /// Returns the body: the sizes that are stated, and otherwise those of SUMO's class of this kind.
    pub fn body(&self) -> VehicleBody {
        let usual = VehicleBody::of_kind(self.kind);
        VehicleBody {
            length_m: self.length_m.unwrap_or(usual.length_m),
            width_m: self.width_m.unwrap_or(usual.width_m),
            height_m: self.height_m.unwrap_or(usual.height_m),
            ..usual
        }
    }

    /// Returns the largest acceleration and deceleration of its changes of speed, m/s2.
    pub fn most_mps2(&self) -> [f64; 2] {
        [self.most_accel_mps2, self.most_decel_mps2].map(|most| most.unwrap_or(f64::INFINITY))
    }

    /// Returns the distance from the front back to the point that follows the lane, m.
    pub fn rear_axle_m(&self) -> f64 {
        let share = if self.kind == VehicleKind::Pedestrian { 0.5 } else { REAR_AXLE_SHARE };
        self.rear_axle_m.unwrap_or_else(|| self.body().length_m * share)
    }

    /// Checks that the road of a drive has room for the road users.
    ///
    /// # Errors
    /// The first fault: the part of the list, such as `.0.place_m`, and a message with value and remedy.
    pub fn check_on(users: &[Self], road: &DrivenRoad) -> Result<(), (String, String)> {
        let Some(user) = users.first() else { return Ok(()) };
        if !road.is_open() {
            let why = "allowed: on a network, as a closed route is full of its own vehicles";
            let message = format!("road_user \"{}\": {why}\n  remedy: a path or a [demand]", user.name);
            return Err((".0.name".into(), message));
        }
        let length_m = road.map.route.length_m();
        let mut beyond = users.iter().enumerate().filter(|(_, user)| user.place_m > length_m);
        beyond.next().map_or(Ok(()), |(k, Self { name, place_m, .. })| {
            let message = format!("road_user \"{name}\": place_m is {place_m}, and the route is {length_m:.1} m long");
            Err((format!(".{k}.place_m"), message))
        })
    }

    /// Returns the faults of the road users of a scenario: their number, and the names and values of each.
    pub fn faults(users: &[Self]) -> Vec<SettingFault> {
        if users.len() > MOST {
            let message = format!("{} road users; allowed: at most {MOST}", users.len());
            return vec![SettingFault::new(format!("{KEY}.{MOST}"), &[], message)];
        }
        users.iter().enumerate().flat_map(|(k, user)| user.own_faults(k, &users[..k])).collect()
    }

    /// Returns the faults of the road user with a number in its scenario, which comes after others.
    fn own_faults(&self, number: usize, before: &[Self]) -> Vec<SettingFault> {
        let mut faults = Vec::new();
        let mut add = |part: &str, message: String| {
            let message = format!("\"{}\": {message}", self.name);
            faults.push(SettingFault::new(format!("{KEY}.{number}.{part}"), &[], message));
        };
        let letters = self.name.chars().count();
        if self.name.trim().is_empty() || letters > NAME_LETTERS {
            add("name", format!("the name has {letters} letters; allowed: 1 to {NAME_LETTERS}"));
        } else if self.name.parse::<u32>().is_ok() || PLACES.contains(&self.name.as_str()) || self.name == EGO_NAME {
            add("name", format!("allowed: a name other than a number, {EGO_NAME}, {}", PLACES.join(", ")));
        } else if before.iter().any(|other| other.name == self.name) {
            add("name", "another road user has this name; allowed: one for each".into());
        }
        let bounds = [
            ("length_m", self.length_m, 25.0),
            ("width_m", self.width_m, 5.0),
            ("height_m", self.height_m, 5.0),
            ("most_accel_mps2", self.most_accel_mps2, 100.0),
            ("most_decel_mps2", self.most_decel_mps2, 100.0),
        ];
        let bounds = bounds.map(|(part, value, most)| (part, value.unwrap_or(1.0), [0.1, most]));
        let values = [
            ("place_m", self.place_m, [0.0, FARTHEST_M]),
            ("lanes_left", f64::from(self.lanes_left), [-f64::from(MOST_LANES), MOST_LANES.into()]),
            ("offset_m", self.offset_m, [-50.0, 50.0]),
            ("speed_mps", self.speed_mps, [0.0, FASTEST_MPS]),
            // An impossible length is a fault of its own.
            ("rear_axle_m", self.rear_axle_m.unwrap_or(0.0), [0.0, self.body().length_m.max(0.0)]),
        ];
        for (part, value, bounds) in bounds.into_iter().chain(values) {
            if let Err(message) = within(part, value, bounds) {
                add(part, message);
            }
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<RoadUser> {
        #[derive(Deserialize)]
        struct List {
            road_user: Vec<RoadUser>,
        }
        toml::from_str::<List>(text).expect("a list of road users").road_user
    }

    #[test]
    fn a_road_user_has_the_sizes_of_its_kind_unless_others_are_stated() {
        let users = read(
            "[[road_user]]\nname = \"coach\"\nkind = \"bus\"\nplace_m = 40\n\
             [[road_user]]\nname = \"long\"\nplace_m = 60\nlength_m = 5.04\nrear_axle_m = 3.92\n",
        );
        assert_eq!(RoadUser::faults(&users), []);
        // SUMO's class bus is 12 m long.
        assert_eq!((users[0].body().length_m, users[0].rear_axle_m()), (12.0, 9.36));
        assert_eq!((users[1].body().length_m, users[1].rear_axle_m()), (5.04, 3.92));
        assert_eq!(users[1].body().width_m, VehicleBody::CAR.width_m);
    }

    #[test]
    fn names_that_mean_another_vehicle_are_refused() {
        for name in ["leader", "7", "ego", " "] {
            let users = read(&format!("[[road_user]]\nname = \"{name}\"\nplace_m = 40\n"));
            let faults = RoadUser::faults(&users);
            let [fault] = faults.as_slice() else { panic!("{name}: {faults:?}") };
            assert!(fault.key == "road_user.0.name" && fault.message.contains("allowed"), "{fault:?}");
        }
        let two = read(&"[[road_user]]\nname = \"a\"\nplace_m = 40\n".repeat(2));
        assert_eq!(RoadUser::faults(&two)[0].key, "road_user.1.name");
    }
}
