//! Pads through gilrs, and wheels on systems without evdev; its filters are off: they round a wheel's steering to 4.5
//! degrees and couple it with the clutch (FACTS 7). In: gilrs' events. Out: [`Controls`] of the device that was touched last.

use super::{
    other::{WheelAxis, WheelState, known_wheel},
    profiles::{self, Kind},
};
use crate::ego::{Controls, STEERING_LOCK_RAD, Selector};
use gilrs::{Axis, Button, EventType, GamepadId, Gilrs, GilrsBuilder};
use std::collections::BTreeMap;

/// Stick travel around the middle that counts as none: worn sticks rest at up to 0.1.
const STICK_DEAD: f32 = 0.12;
/// Share of the steering lock that a stick reaches: a thumb cannot dose 450 degrees.
const STICK_LOCK: f32 = 0.5;

/// All pads and wheels.
pub struct Pads {
    gilrs: Option<Gilrs>,
    devices: BTreeMap<usize, Device>,
    active: Option<usize>,
}

struct Device {
    name: String,
    kind: DeviceKind,
}

enum DeviceKind {
    Wheel { axes: &'static [(u32, WheelAxis)], state: WheelState },
    Pad(PadState),
}

#[derive(Default)]
struct PadState {
    stick: f32,
    throttle: f32,
    brake: f32,
    reverse: bool,
}

impl Pads {
    /// Opens gilrs; where it cannot be opened there are no pads, which is said once.
    pub fn open() -> Self {
        if wheel_is_here() {
            // gilrs opens every joystick there is, and a wheel has one reader.
            return Self { gilrs: None, devices: BTreeMap::new(), active: None };
        }
        let gilrs = GilrsBuilder::new().with_default_filters(false).build();
        let gilrs = gilrs.map_err(|e| log::info!("no pads or wheels: {e}")).ok();
        let mut pads = Self { gilrs, devices: BTreeMap::new(), active: None };
        let ids: Vec<GamepadId> = pads.gilrs.iter().flat_map(|g| g.gamepads().map(|(id, _)| id)).collect();
        ids.into_iter().for_each(|id| pads.connect(id));
        pads
    }

    /// Reads all events since the last call; true if a device was touched.
    pub fn poll(&mut self) -> bool {
        let mut touched = false;
        while let Some(event) = self.gilrs.as_mut().and_then(Gilrs::next_event) {
            let key = usize::from(event.id);
            match event.event {
                EventType::Connected => self.connect(event.id),
                EventType::Disconnected => {
                    if let Some(device) = self.devices.remove(&key) {
                        log::warn!("{} was unplugged: its pedals count as released", device.name);
                    }
                    if self.active == Some(key) {
                        self.active = None;
                    }
                }
                other => {
                    if let Some(device) = self.devices.get_mut(&key).filter(|_| acts(&other)) {
                        device.take(&other);
                        self.active = Some(key);
                        touched = true;
                    }
                }
            }
        }
        touched
    }

    /// What the device touched last asks for; `None` if there is none.
    pub fn controls(&self) -> Option<Controls> {
        Some(self.devices.get(&self.active?)?.controls())
    }

    /// Name of the device touched last.
    pub fn name(&self) -> Option<&str> {
        Some(&self.devices.get(&self.active?)?.name)
    }

    fn connect(&mut self, id: GamepadId) {
        let Some(pad) = self.gilrs.as_ref().map(|g| g.gamepad(id)) else { return };
        let name = pad.name().to_owned();
        let ids = (pad.vendor_id().unwrap_or(0), pad.product_id().unwrap_or(0));
        if cfg!(target_os = "linux") && profiles::kind(ids.0, ids.1, pad.os_name()) != Kind::Other {
            // Evdev has it: never two readers for one wheel.
            return;
        }
        let kind = match known_wheel(pad.vendor_id(), pad.product_id(), pad.os_name()) {
            Some(axes) => DeviceKind::Wheel { axes, state: WheelState::default() },
            None => DeviceKind::Pad(PadState::default()),
        };
        log::info!("found {name} ({})", if matches!(kind, DeviceKind::Pad(_)) { "pad" } else { "wheel" });
        self.devices.insert(usize::from(id), Device { name, kind });
    }
}

#[cfg(target_os = "linux")]
fn wheel_is_here() -> bool {
    super::linux::wheels().iter().any(|node| node.kind == Kind::Wheel)
}

#[cfg(not(target_os = "linux"))]
fn wheel_is_here() -> bool {
    false
}

/// True for events that come from a hand or foot.
fn acts(event: &EventType) -> bool {
    matches!(event, EventType::AxisChanged(..) | EventType::ButtonChanged(..) | EventType::ButtonPressed(..))
}

impl Device {
    fn take(&mut self, event: &EventType) {
        match (&mut self.kind, event) {
            (DeviceKind::Wheel { axes, state }, EventType::AxisChanged(_, value, code)) => {
                if let Some((_, axis)) = axes.iter().find(|(raw, _)| *raw == code.into_u32()) {
                    state.moved(*axis, *value);
                }
            }
            // Code 293 is the G29's left paddle (FACTS 7), type 1 in the upper half.
            (DeviceKind::Wheel { state, .. }, EventType::ButtonPressed(_, code))
                if code.into_u32() == (1 << 16) + 293 =>
            {
                state.toggle_reverse();
            }
            (DeviceKind::Pad(state), EventType::AxisChanged(Axis::LeftStickX, value, _)) => state.stick = *value,
            (DeviceKind::Pad(state), EventType::ButtonChanged(Button::RightTrigger2, value, _)) => {
                state.throttle = *value
            }
            (DeviceKind::Pad(state), EventType::ButtonChanged(Button::LeftTrigger2, value, _)) => state.brake = *value,
            (DeviceKind::Pad(state), EventType::ButtonPressed(Button::West, _)) => state.reverse = !state.reverse,
            _ => {}
        }
    }

    fn controls(&self) -> Controls {
        match &self.kind {
            DeviceKind::Wheel { state, .. } => state.controls(),
            DeviceKind::Pad(state) => state.controls(),
        }
    }
}

impl PadState {
    fn controls(&self) -> Controls {
        let travel = ((self.stick.abs() - STICK_DEAD) / (1.0 - STICK_DEAD)).max(0.0);
        // Squared, so that small corrections are fine.
        let steer = travel * travel * self.stick.signum();
        Controls {
            throttle: self.throttle,
            brake: self.brake,
            steering_wheel_rad: -steer * STICK_LOCK * STEERING_LOCK_RAD,
            selector: if self.reverse { Selector::Reverse } else { Selector::Drive },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pad_at_rest_asks_for_nothing() {
        assert_eq!(PadState::default().controls(), Controls { steering_wheel_rad: 0.0, ..Controls::default() });
        assert_eq!(PadState { stick: 0.1, ..PadState::default() }.controls().steering_wheel_rad, 0.0);
    }

    #[test]
    fn a_stick_to_the_left_steers_left() {
        let state = PadState { stick: -1.0, ..PadState::default() };
        assert_eq!(state.controls().steering_wheel_rad, STICK_LOCK * STEERING_LOCK_RAD);
    }
}
