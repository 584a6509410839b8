//! Which touches of other cars are contacts of their own. In: the cars that the ego touches in a tick. Out: an event for each
//! contact that begins.

use crate::{
    ego::Contact,
    sim::{Event, EventKind, snapshot::VehicleSnapshot},
    time::{TICKS_PER_S, Tick},
};

/// A contact that begins again sooner than this after the last one with the same car is the same contact, ticks.
const SAME_CONTACT_TICKS: u64 = TICKS_PER_S as u64 / 2;

/// When the ego last touched each car.
pub(super) struct ContactTracker {
    last: Vec<Option<Tick>>,
}

impl ContactTracker {
    /// None of so many cars was touched yet.
    pub fn new(cars: usize) -> Self {
        Self { last: vec![None; cars] }
    }

    /// The contacts that begin at `now`, of all touches of this tick.
    pub fn begun<'a>(
        &'a mut self,
        touches: &'a [Contact],
        now: Tick,
        cars: &'a [VehicleSnapshot],
    ) -> impl Iterator<Item = Event> + 'a {
        touches.iter().filter_map(move |contact| {
            let before = self.last[contact.car].replace(now);
            if before.is_some_and(|last| now.0 - last.0 <= SAME_CONTACT_TICKS) {
                return None;
            }
            let kind = EventKind::Contact {
                car: cars[contact.car].id,
                ego_speed_mps: contact.ego_speed_mps,
                car_speed_mps: contact.car_speed_mps,
                closing_mps: contact.closing_mps,
            };
            Some(Event { tick: now, kind })
        })
    }
}
