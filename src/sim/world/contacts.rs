//! Finds the beginnings of contacts. In: the vehicles and fixed objects that the ego touches in a tick. Out: an event for each contact that
//! begins. Vehicles are identified by id, as they enter and leave, and fixed objects by kind: a wall or a rail has several parts.

use crate::{
    ego::{Contact, ObstacleId},
    roadside::fixed_objects::FixedObjectKind,
    sim::{Event, EventKind},
    time::{TICKS_PER_S, Tick},
    traffic::{VehicleId, VehicleKind},
};
use std::collections::BTreeMap;

/// Longest pause between two touches of the same vehicle, or kind of object, that count as one contact, ticks.
const SAME_CONTACT_TICKS: u64 = TICKS_PER_S as u64 / 2;

/// Vehicle or kind of object that the ego touches, as contacts are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Touched {
    Vehicle(VehicleId),
    Object(FixedObjectKind),
}

/// Tick of the last touch of all that the ego has touched.
#[derive(Default)]
pub(super) struct ContactTracker {
    last: BTreeMap<Touched, Tick>,
}

impl ContactTracker {
    /// Returns the contacts that begin at `now`, given all touches of this tick and the kinds of fixed objects and vehicles by number.
    pub fn begun<'a>(
        &'a mut self,
        touches: &'a [Contact],
        now: Tick,
        kind_of: &'a dyn Fn(u32) -> Option<FixedObjectKind>,
        vehicle_kind: &'a dyn Fn(VehicleId) -> VehicleKind,
    ) -> impl Iterator<Item = Event> + 'a {
        touches.iter().filter_map(move |contact| {
            let touched = match contact.with {
                ObstacleId::Vehicle(id) => Touched::Vehicle(VehicleId(id)),
                ObstacleId::FixedObject(number) => Touched::Object(kind_of(number)?),
            };
            let before = self.last.insert(touched, now);
            if before.is_some_and(|last| now.0 - last.0 <= SAME_CONTACT_TICKS) {
                return None;
            }
            let Contact { ego_speed_mps, car_speed_mps, closing_mps, angle_rad, .. } = *contact;
            let kind = match touched {
                Touched::Vehicle(car) => {
                    let kind = vehicle_kind(car);
                    EventKind::Contact { car, kind, ego_speed_mps, car_speed_mps, closing_mps, angle_rad }
                }
                Touched::Object(object) => EventKind::ObjectContact { object, ego_speed_mps, closing_mps },
            };
            Some(Event { tick: now, kind })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(with: ObstacleId) -> Contact {
        Contact { with, ego_speed_mps: 3.0, car_speed_mps: 1.0, closing_mps: 2.0, angle_rad: 0.0 }
    }

    #[test]
    fn contacts_are_separated_by_vehicle_id_while_others_enter_and_leave() {
        let mut tracker = ContactTracker::default();
        let car = |id| touch(ObstacleId::Vehicle(id));
        let mut begun =
            |tick, touches: &[Contact]| tracker.begun(touches, Tick(tick), &|_| None, &|_| VehicleKind::Car).count();
        assert_eq!(begun(1, &[car(70), car(8)]), 2);
        assert_eq!(begun(2, &[car(8), car(900)]), 1);
        assert_eq!(begun(51, &[car(8)]), 0, "within half a second of the last touch");
        assert_eq!(begun(53, &[car(70)]), 1);
    }

    #[test]
    fn a_wall_of_several_parts_is_one_contact_and_a_rail_another() {
        let kinds = [FixedObjectKind::Building, FixedObjectKind::Building, FixedObjectKind::GuardRail];
        let mut tracker = ContactTracker::default();
        let part = |number| touch(ObstacleId::FixedObject(number));
        let mut begun = |tick, touches: &[Contact]| -> Vec<EventKind> {
            let kind_of = |number: u32| kinds.get(number as usize).copied();
            tracker.begun(touches, Tick(tick), &kind_of, &|_| VehicleKind::Car).map(|event| event.kind).collect()
        };
        let of = |object| EventKind::ObjectContact { object, ego_speed_mps: 3.0, closing_mps: 2.0 };
        assert_eq!(begun(1, &[part(0), part(1)]), [of(FixedObjectKind::Building)]);
        assert_eq!(begun(40, &[part(1), part(2)]), [of(FixedObjectKind::GuardRail)]);
    }
}
