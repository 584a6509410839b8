//! Contacts of a drive for its windows. In: the world after each tick, the time of each frame. Out: the number of
//! contacts, the brightness of the flash over the driver's picture, the [`Jolt`] of picture and wheel, messages for the
//! experimenter.

use crate::{
    panel::experimenter::ContactHealth,
    sim::{Event, EventKind, World},
};
use std::time::Duration;

/// Fade time of a flash. A contact during a flash starts no other, so that no picture flashes more than three times a
/// second, which could cause a seizure (WCAG 2.3.1).
const FLASH: Duration = Duration::from_secs(1);

/// Closing speed of a contact whose jolt has full strength, m/s, and the strength of the slightest.
const HARD_MPS: f64 = 5.0;
const LEAST_STRENGTH: f64 = 0.2;
/// Time constant with which a jolt decays, and its end, s.
const JOLT_S: f64 = 0.12;
const JOLT_END_S: f64 = 0.6;

/// Jolt of a contact that has just happened.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jolt {
    /// Strength at present, 0 (none) to 1.
    pub strength: f64,
    /// Time since the contact, s.
    pub since_s: f64,
}

/// Describes a contact; `None` for any other event.
pub fn contact_text(event: &Event) -> Option<String> {
    match event.kind {
        EventKind::Contact { kind, closing_mps, .. } => {
            Some(format!("contact with a {}, closing at {closing_mps:.1} m/s", kind.name()))
        }
        EventKind::ObjectContact { object, closing_mps, .. } => {
            Some(format!("contact with a {}, closing at {closing_mps:.1} m/s", object.name()))
        }
        _ => None,
    }
}

/// Contacts so far, with the flash and the messages.
#[derive(Clone, Debug, Default)]
pub struct ContactCount {
    count: u32,
    /// Closing speed of the last contact, m/s, and the time since.
    last: Option<(f64, Duration)>,
    flash_left: Duration,
    texts: Vec<String>,
}

impl ContactCount {
    /// Adds the contacts of the world's last tick.
    pub fn tick(&mut self, world: &World) {
        for event in world.events() {
            let (EventKind::Contact { closing_mps, .. } | EventKind::ObjectContact { closing_mps, .. }) = event.kind
            else {
                continue;
            };
            self.count += 1;
            self.last = Some((closing_mps, Duration::ZERO));
            // A contact with a person ends the drive, and a text says so; a flash would add a shock.
            if self.flash_left.is_zero() && !event.kind.touches_person() {
                self.flash_left = FLASH;
            }
            self.texts.extend(contact_text(event));
        }
    }

    /// Advances the time by one frame.
    pub fn pass(&mut self, elapsed: Duration) {
        self.flash_left = self.flash_left.saturating_sub(elapsed);
        if let Some((_, ago)) = &mut self.last {
            *ago += elapsed;
        }
    }

    /// Returns the brightness of the flash over the driver's picture, 0 to 1.
    pub fn flash(&self) -> f32 {
        self.flash_left.as_secs_f32() / FLASH.as_secs_f32()
    }

    /// Returns the jolt of the last contact.
    pub fn jolt(&self) -> Jolt {
        let Some((closing_mps, ago)) = self.last else { return Jolt::default() };
        let since_s = ago.as_secs_f64();
        if since_s >= JOLT_END_S {
            return Jolt::default();
        }
        let strength = (closing_mps / HARD_MPS).clamp(LEAST_STRENGTH, 1.0) * (-since_s / JOLT_S).exp();
        Jolt { strength, since_s }
    }

    /// Returns the state for the experimenter's lamp.
    pub fn health(&self) -> ContactHealth {
        ContactHealth { count: self.count, last: self.last.map(|(closing_mps, ago)| [closing_mps, ago.as_secs_f64()]) }
    }

    /// Returns one message for each contact since the last call.
    pub fn take_texts(&mut self) -> Vec<String> {
        std::mem::take(&mut self.texts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        controls::Controls,
        scenario::{DisplaySettings, Scenario},
        traffic::EngineChoice,
    };

    /// Returns a world in which the ego has just hit the vehicle ahead, and the contacts of its ticks.
    fn crashed() -> (World, ContactCount) {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: "none".into(),
            lane_help: false,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let (mut world, mut contacts) = (World::new(&scenario).unwrap(), ContactCount::default());
        let floored = Controls { throttle: 1.0, ..Controls::default() };
        for _ in 0..3000 {
            world.tick(&floored).unwrap();
            contacts.tick(&world);
            if contacts.count > 0 {
                return (world, contacts);
            }
        }
        panic!("30 s of full throttle behind a car that stands, and no contact")
    }

    #[test]
    fn a_contact_flashes_once_is_counted_and_reported() {
        let (world, mut contacts) = crashed();
        let [words] = &contacts.take_texts()[..] else { panic!("one line") };
        let Some(EventKind::Contact { closing_mps, .. }) =
            world.events().iter().map(|event| event.kind).find(|kind| matches!(kind, EventKind::Contact { .. }))
        else {
            panic!("the contact is of this tick")
        };
        assert_eq!(*words, format!("contact with a car, closing at {closing_mps:.1} m/s"));
        assert_eq!((contacts.flash(), contacts.health().count), (1.0, 1));
        let jolt = contacts.jolt();
        assert!(jolt.strength > 0.2 && jolt.since_s == 0.0, "{jolt:?}");
        contacts.pass(Duration::from_millis(500));
        assert!((contacts.flash() - 0.5).abs() < 1e-6 && contacts.health().last == Some([closing_mps, 0.5]));
        assert!((0.001..0.02).contains(&contacts.jolt().strength), "{:?}", contacts.jolt());
        // The same tick again stands for another contact 0.5 s later: counted and reported, without another flash.
        contacts.tick(&world);
        assert!((contacts.flash() - 0.5).abs() < 1e-6 && contacts.health().count == 2);
        contacts.pass(Duration::from_secs(1));
        assert_eq!((contacts.flash(), contacts.take_texts().len()), (0.0, 1));
        assert_eq!(contacts.jolt(), Jolt::default());
    }
}
