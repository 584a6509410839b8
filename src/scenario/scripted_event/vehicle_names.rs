//! Names of vehicles in events. In: the triggers and actions of events, and the road of their drive. Out: the first name that no vehicle of the drive
//! can have, with the nearest one of those that can be there.

use super::{Action, DrivenRoad, EGO_NAME, PLACES, Trigger};
use crate::{
    toml_text::did_you_mean,
    traffic::{DemandNames, EGO},
};
use std::cell::OnceCell;

/// Vehicles that can be in a drive.
pub(super) struct KnownVehicles<'a> {
    road: &'a DrivenRoad<'a>,
    /// Names of the demand, read once an event needs them.
    of_demand: OnceCell<DemandNames>,
}

impl<'a> KnownVehicles<'a> {
    /// Returns the vehicles of the drive on a road.
    pub fn new(road: &'a DrivenRoad<'a>) -> Self {
        Self { road, of_demand: OnceCell::new() }
    }

    /// Checks the vehicles that a trigger looks at.
    ///
    /// # Errors
    /// As [`KnownVehicles::check_action`].
    pub fn check_trigger(&self, trigger: &Trigger) -> Result<(), String> {
        trigger.vehicles().into_iter().try_for_each(|name| self.check(name, true))
    }

    /// Checks the vehicle that acts, and another one that the action names.
    ///
    /// # Errors
    /// No vehicle of the drive can have the name, or a file of the demand cannot be read.
    pub fn check_action(&self, action: &Action) -> Result<(), String> {
        action.vehicle().map_or(Ok(()), |name| self.check(name, false))?;
        action.others().map_or(Ok(()), |name| self.check(name, true))
    }

    fn check(&self, name: &str, can_be_ego: bool) -> Result<(), String> {
        let DrivenRoad { fixed_vehicles, road_users, demand, .. } = *self.road;
        let users = road_users.iter().map(|user| user.name.as_str());
        let names: Vec<&str> = PLACES.into_iter().chain(users).chain(can_be_ego.then_some(EGO_NAME)).collect();
        let numbers = match fixed_vehicles {
            Some(vehicles) => EGO.0 + 1..vehicles,
            None if demand.is_empty() => 0..0,
            None => EGO.0 + 1..u32::MAX,
        };
        if names.contains(&name) || name.parse().is_ok_and(|number| numbers.contains(&number)) {
            return Ok(());
        }
        let (mut allowed, mut near) = (names.join(", "), did_you_mean(name, &names));
        if let Some(vehicles) = fixed_vehicles {
            allowed += &format!(", the number of another vehicle, 1 to {}", vehicles.saturating_sub(1));
        } else if !demand.is_empty() {
            let of_demand = match self.of_demand.get() {
                Some(known) => known,
                None => {
                    let read = DemandNames::of(demand).map_err(|fault| fault.to_string())?;
                    self.of_demand.get_or_init(|| read)
                }
            };
            if of_demand.has(name) {
                return Ok(());
            }
            if let Some(nearest) = of_demand.nearest(name).filter(|_| near.is_empty()) {
                near = format!(" (did you mean {nearest}?)");
            }
            allowed += ", the number of a vehicle, its name in the demand";
        }
        Err(format!("no vehicle of this drive can be \"{name}\"{near}; allowed: {allowed}"))
    }
}
