//! Finds the beginnings of contacts. In: the vehicles that the ego touches in a tick. Out: an event for each contact that begins. Vehicles
//! are identified by id, as they enter and leave.

use crate::{
    ego::Contact,
    sim::{Event, EventKind},
    time::{TICKS_PER_S, Tick},
    traffic::VehicleId,
};
use std::collections::BTreeMap;

/// Longest pause between two touches of the same vehicle that count as one contact, ticks.
const SAME_CONTACT_TICKS: u64 = TICKS_PER_S as u64 / 2;

/// Tick of the last touch of each vehicle that the ego has touched.
#[derive(Default)]
pub(super) struct ContactTracker {
    last: BTreeMap<VehicleId, Tick>,
}

impl ContactTracker {
    /// Returns the contacts that begin at `now`, given all touches of this tick.
    pub fn begun<'a>(&'a mut self, touches: &'a [Contact], now: Tick) -> impl Iterator<Item = Event> + 'a {
        touches.iter().filter_map(move |contact| {
            let car = VehicleId(contact.car);
            let before = self.last.insert(car, now);
            if before.is_some_and(|last| now.0 - last.0 <= SAME_CONTACT_TICKS) {
                return None;
            }
            let kind = EventKind::Contact {
                car,
                ego_speed_mps: contact.ego_speed_mps,
                car_speed_mps: contact.car_speed_mps,
                closing_mps: contact.closing_mps,
                angle_rad: contact.angle_rad,
            };
            Some(Event { tick: now, kind })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_are_separated_by_vehicle_id_while_others_enter_and_leave() {
        let mut tracker = ContactTracker::default();
        let touch = |car| Contact { car, ego_speed_mps: 3.0, car_speed_mps: 1.0, closing_mps: 2.0, angle_rad: 0.0 };
        let mut begun = |tick, touches: &[Contact]| tracker.begun(touches, Tick(tick)).count();
        assert_eq!(begun(1, &[touch(70), touch(8)]), 2);
        assert_eq!(begun(2, &[touch(8), touch(900)]), 1);
        assert_eq!(begun(51, &[touch(8)]), 0, "within half a second of the last touch");
        assert_eq!(begun(53, &[touch(70)]), 1);
    }
}
