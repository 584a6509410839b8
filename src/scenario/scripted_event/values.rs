//! Names and bounds of values in events. In: a value of a trigger or an action. Out: a message for one that is not allowed. Seconds, metres, m/s.

/// Latest time and longest duration, s, and farthest place, m.
pub(super) const LATEST_S: f64 = 604_800.0;
pub(in crate::scenario) const FARTHEST_M: f64 = 1_000_000.0;
/// Highest speed, m/s.
pub(in crate::scenario) const FASTEST_MPS: f64 = 70.0;

/// Largest number of lanes to one side.
pub(in crate::scenario) const MOST_LANES: i32 = 20;

/// Name of a vehicle of the traffic: its place beside the ego when the event begins, such as `leader`, a number, or its name in the demand.
pub type VehicleName = String;

/// Name of the participant's vehicle.
pub const EGO_NAME: &str = "ego";
/// Vehicle ahead of the ego.
pub const LEADER: &str = "leader";
/// Vehicle behind the ego.
pub const FOLLOWER: &str = "follower";
/// Next vehicle ahead on the lane to the ego's left.
pub const LEFT_LEADER: &str = "left_leader";
/// Next vehicle ahead on the lane to the ego's right.
pub const RIGHT_LEADER: &str = "right_leader";
/// Names of vehicles by their places beside the ego.
pub const PLACES: [&str; 4] = [LEADER, FOLLOWER, LEFT_LEADER, RIGHT_LEADER];

/// Checks that a value lies within its bounds.
pub(in crate::scenario) fn within(what: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), String> {
    match (low..=high).contains(&value) {
        true => Ok(()),
        false => Err(format!("{what} is {value}; allowed: {low} to {high}")),
    }
}

/// Checks the name of a vehicle of the traffic or of a road user.
pub(super) fn check_vehicle(what: &str, name: &str) -> Result<(), String> {
    match name.trim().is_empty() || name.parse() == Ok(crate::traffic::EGO.0) {
        true => Err(format!(
            "{what} is \"{name}\"; allowed: {}, the number of another vehicle, or its name in the demand",
            PLACES.join(", ")
        )),
        false => Ok(()),
    }
}

/// Checks the name of a vehicle, which may be the participant's.
pub(super) fn check_subject(what: &str, name: &str) -> Result<(), String> {
    if name == EGO_NAME { Ok(()) } else { check_vehicle(what, name) }
}

/// Checks the name of a vehicle that can be ahead.
pub(super) fn check_ahead(to: &str) -> Result<(), String> {
    match to {
        FOLLOWER => Err(format!("to is \"{FOLLOWER}\"; allowed: a vehicle that can be ahead, such as {LEADER}")),
        _ => check_vehicle("to", to),
    }
}

/// Returns true for a value that a file need not state.
pub(super) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
