//! Gamepads through gilrs, and wheels on systems without evdev. gilrs' filters are off: they round a wheel's steering
//! to 4.5 degrees and couple it with the clutch (docs/references.md: g29). In: gilrs' events. Out: [`Controls`] of the
//! device that was touched last; the force of a wheel, through SDL2.

use super::{
    buttons::ButtonAction,
    force::ForceInput,
    force_thread::{ForceDevice, ForceLoop, ForceThread, SharedAngle},
    kinds::DeviceKind,
    other::{GilrsWheelState, WheelAxis, known_wheel},
    profile::WheelProfile,
    profiles,
    sdl_force::SdlForce,
};
use crate::controls::{Controls, STEERING_LOCK_RAD, Selector};
use gilrs::{Axis, Button, EventType, GamepadId, Gilrs, GilrsBuilder};
use std::{collections::BTreeMap, sync::Arc};

/// Dead zone of the stick around the middle: worn sticks rest at up to 0.1.
const STICK_DEAD: f32 = 0.12;
/// Share of the steering lock at full stick: a thumb cannot control 450 degrees finely.
const STICK_LOCK: f32 = 0.5;

/// All gamepads and wheels that gilrs reads.
pub struct Pads {
    gilrs: Option<Gilrs>,
    devices: BTreeMap<usize, PadDevice>,
    active: Option<usize>,
    /// Profile that a person named; only its force settings are used here.
    asked: Option<WheelProfile>,
    force: Option<WheelForce>,
    /// Actions of buttons pressed since the last [`Pads::take_pressed`].
    pressed: Vec<ButtonAction>,
    /// Messages for people since the last [`Pads::take_troubles`], each sent once.
    troubles: Vec<String>,
    reported: Vec<String>,
}

/// Force feedback of one wheel.
struct WheelForce {
    /// Key of the wheel's device.
    key: usize,
    thread: ForceThread,
    angle: Arc<SharedAngle>,
}

struct PadDevice {
    name: String,
    kind: PadDeviceKind,
}

enum PadDeviceKind {
    Wheel { axes: &'static [(u32, WheelAxis)], state: GilrsWheelState },
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
    /// Opens gilrs. If that fails there are no gamepads, and the log says so. `asked` is the profile that a person
    /// named for the wheel.
    pub fn open(asked: Option<&WheelProfile>) -> Self {
        let asked = asked.cloned();
        if wheel_is_here(|_, kind| kind == DeviceKind::Wheel) {
            // gilrs opens every joystick, and a wheel must have only one reader.
            return Self { asked, ..Self::none() };
        }
        let gilrs = GilrsBuilder::new().with_default_filters(false).build();
        let gilrs = gilrs.map_err(|e| log::info!("no pads or wheels: {e}")).ok();
        let mut pads = Self { gilrs, asked, ..Self::none() };
        let ids: Vec<GamepadId> = pads.gilrs.iter().flat_map(|g| g.gamepads().map(|(id, _)| id)).collect();
        ids.into_iter().for_each(|id| pads.connect(id));
        pads
    }

    fn none() -> Self {
        let (devices, troubles, reported) = (BTreeMap::new(), Vec::new(), Vec::new());
        Self { gilrs: None, devices, active: None, asked: None, force: None, pressed: Vec::new(), troubles, reported }
    }

    /// Reads all events since the last call. Returns true if a device was touched.
    pub fn poll(&mut self) -> bool {
        let mut touched = false;
        while let Some(event) = self.gilrs.as_mut().and_then(Gilrs::next_event) {
            let key = usize::from(event.id);
            match event.event {
                EventType::Connected => self.connect(event.id),
                EventType::Disconnected => self.disconnect(key),
                other => touched |= PadEvent::of(&other).is_some_and(|moved| self.touch(key, moved)),
            }
        }
        if let Some((force, device)) = self.force.as_ref().and_then(|f| Some((f, self.devices.get(&f.key)?))) {
            force.angle.set(device.controls().steering_wheel_rad.into());
        }
        touched
    }

    /// Puts the selectors of all devices into drive.
    pub fn select_drive(&mut self) {
        for device in self.devices.values_mut() {
            match &mut device.kind {
                PadDeviceKind::Wheel { state, .. } => state.select_drive(),
                PadDeviceKind::Pad(state) => state.reverse = false,
            }
        }
    }

    /// Applies a movement by a hand or foot to a device. Returns false if the device is unknown.
    fn touch(&mut self, key: usize, moved: PadEvent) -> bool {
        let Some(device) = self.devices.get_mut(&key) else { return false };
        self.pressed.extend(moved.action());
        device.take(moved);
        self.active = Some(key);
        true
    }

    fn disconnect(&mut self, key: usize) {
        if let Some(device) = self.devices.remove(&key) {
            log::warn!("{} was unplugged: its pedals count as released", device.name);
        }
        if self.active == Some(key) {
            self.active = None;
        }
        self.force.take_if(|force| force.key == key);
    }

    /// Sets the inputs of the force feedback.
    pub fn set_force_input(&self, force_input: ForceInput) {
        if let Some(force) = &self.force {
            force.thread.set_input(force_input);
        }
    }

    /// Checks whether a force can be felt now.
    pub fn has_force(&self) -> bool {
        self.force.is_some()
    }

    /// Returns the mean torque that was sent since the last call, N m, positive to the left; `None` without force feedback.
    pub fn take_torque_nm(&self) -> Option<f64> {
        Some(self.force.as_ref()?.thread.take_torque_nm())
    }

    /// Returns the estimated torque of the hands, N m, positive to the left; `None` without force feedback.
    pub fn hand_torque_nm(&self) -> Option<f64> {
        self.force.as_ref()?.thread.hand_torque_nm()
    }

    /// Returns the actions of buttons pressed since the last call: d-pad, south button and shoulder buttons.
    pub fn take_pressed(&mut self) -> Vec<ButtonAction> {
        std::mem::take(&mut self.pressed)
    }

    /// Returns the messages for people since the last call.
    pub fn take_troubles(&mut self) -> Vec<String> {
        std::mem::take(&mut self.troubles)
    }

    /// Starts the force feedback of a wheel, if its profile wants force, SDL2 offers it, and no other wheel has it.
    fn strengthen(&mut self, key: usize, id: (u16, u16), name: &str) {
        let shipped = || profiles::shipped().find(|profile| profile.is_for(id.0, id.1));
        let profile = self.asked.clone().or_else(shipped).or_else(|| profiles::named("g29").ok());
        let Some(profile) = profile.filter(|p| p.force.strength > 0.0 && self.force.is_none()) else { return };
        match SdlForce::open(id, name, profile.force.autocentre_after) {
            Ok(device) => self.push(key, Box::new(device), &profile),
            Err(without) => {
                let text = without.to_string();
                if self.reported.contains(&text) {
                    return;
                }
                log::warn!("{text}");
                self.reported.push(text.clone());
                self.troubles.push(text);
            }
        }
    }

    fn push(&mut self, key: usize, device: Box<dyn ForceDevice>, profile: &WheelProfile) {
        let angle = Arc::new(SharedAngle::default());
        let thread = ForceThread::start(ForceLoop::new(device, profile), Arc::clone(&angle));
        let thread = thread.map_err(|e| log::warn!("the thread for the force cannot start: {e}")).ok();
        self.force = thread.map(|thread| WheelForce { key, thread, angle });
    }

    /// Returns the controls of the device touched last; `None` if there is none.
    pub fn controls(&self) -> Option<Controls> {
        Some(self.devices.get(&self.active?)?.controls())
    }

    /// Returns the name of the device touched last.
    pub fn name(&self) -> Option<&str> {
        Some(&self.devices.get(&self.active?)?.name)
    }

    fn connect(&mut self, id: GamepadId) {
        let Some(pad) = self.gilrs.as_ref().map(|g| g.gamepad(id)) else { return };
        let name = pad.name().to_owned();
        let ids = (pad.vendor_id().unwrap_or(0), pad.product_id().unwrap_or(0));
        if wheel_is_here(|id, _| id == ids) {
            // Evdev reads this wheel, and a wheel must have only one reader.
            return;
        }
        let kind = match known_wheel(pad.vendor_id(), pad.product_id(), pad.os_name()) {
            Some(axes) => PadDeviceKind::Wheel { axes, state: GilrsWheelState::default() },
            None => PadDeviceKind::Pad(PadState::default()),
        };
        let is_wheel = matches!(kind, PadDeviceKind::Wheel { .. });
        log::info!("found {name} ({})", if is_wheel { "wheel" } else { "pad" });
        if is_wheel {
            self.strengthen(usize::from(id), ids, &name);
        }
        self.devices.insert(usize::from(id), PadDevice { name, kind });
    }
}

/// Checks whether evdev finds a wheel for whose ids and kind `which` holds.
#[cfg(target_os = "linux")]
fn wheel_is_here(which: impl Fn((u16, u16), DeviceKind) -> bool) -> bool {
    super::linux::wheels().iter().any(|node| which(node.id, node.kind))
}

#[cfg(not(target_os = "linux"))]
fn wheel_is_here(_which: impl Fn((u16, u16), DeviceKind) -> bool) -> bool {
    false
}

/// A movement by a hand or foot: gilrs' events with their codes as numbers, because only gilrs can create the codes.
#[derive(Clone, Copy, Debug)]
enum PadEvent {
    Axis(Axis, f32, u32),
    Button(Button, f32),
    Press(Button, u32),
}

impl PadEvent {
    fn of(event: &EventType) -> Option<Self> {
        Some(match event {
            EventType::AxisChanged(axis, value, code) => Self::Axis(*axis, *value, code.into_u32()),
            EventType::ButtonChanged(button, value, _) => Self::Button(*button, *value),
            EventType::ButtonPressed(button, code) => Self::Press(*button, code.into_u32()),
            _ => return None,
        })
    }
}

impl PadEvent {
    /// Returns the action that the event asks for besides driving.
    fn action(self) -> Option<ButtonAction> {
        match self {
            Self::Press(Button::DPadUp, _) => Some(ButtonAction::Up),
            Self::Press(Button::DPadDown, _) => Some(ButtonAction::Down),
            Self::Press(Button::DPadLeft, _) => Some(ButtonAction::Left),
            Self::Press(Button::DPadRight, _) => Some(ButtonAction::Right),
            Self::Press(Button::South, _) => Some(ButtonAction::Answer),
            Self::Press(Button::LeftTrigger, _) => Some(ButtonAction::IndicateLeft),
            Self::Press(Button::RightTrigger, _) => Some(ButtonAction::IndicateRight),
            // A d-pad that gilrs reports as axes: right and up are positive.
            Self::Axis(Axis::DPadX, value, _) if value > 0.5 => Some(ButtonAction::Right),
            Self::Axis(Axis::DPadX, value, _) if value < -0.5 => Some(ButtonAction::Left),
            Self::Axis(Axis::DPadY, value, _) if value > 0.5 => Some(ButtonAction::Up),
            Self::Axis(Axis::DPadY, value, _) if value < -0.5 => Some(ButtonAction::Down),
            _ => None,
        }
    }
}

/// Left paddle of the G29 (docs/references.md: g29): key 293 of evdev type 1, the type in the upper half.
const LEFT_PADDLE: u32 = (1 << 16) + 293;

impl PadDevice {
    fn take(&mut self, moved: PadEvent) {
        match (&mut self.kind, moved) {
            (PadDeviceKind::Wheel { axes, state }, PadEvent::Axis(_, value, code)) => {
                if let Some((_, axis)) = axes.iter().find(|(raw, _)| *raw == code) {
                    state.moved(*axis, value);
                }
            }
            (PadDeviceKind::Wheel { state, .. }, PadEvent::Press(_, LEFT_PADDLE)) => state.toggle_reverse(),
            (PadDeviceKind::Pad(state), PadEvent::Axis(Axis::LeftStickX, value, _)) => state.stick = value,
            (PadDeviceKind::Pad(state), PadEvent::Button(Button::RightTrigger2, value)) => state.throttle = value,
            (PadDeviceKind::Pad(state), PadEvent::Button(Button::LeftTrigger2, value)) => state.brake = value,
            (PadDeviceKind::Pad(state), PadEvent::Press(Button::West, _)) => state.reverse = !state.reverse,
            _ => {}
        }
    }

    fn controls(&self) -> Controls {
        match &self.kind {
            PadDeviceKind::Wheel { state, .. } => state.controls(),
            PadDeviceKind::Pad(state) => state.controls(),
        }
    }
}

impl PadState {
    fn controls(&self) -> Controls {
        let travel = ((self.stick.abs() - STICK_DEAD) / (1.0 - STICK_DEAD)).max(0.0);
        // Squared, for fine small corrections.
        let steer = travel * travel * self.stick.signum();
        Controls {
            throttle: self.throttle,
            brake: self.brake,
            steering_wheel_rad: -steer * STICK_LOCK * STEERING_LOCK_RAD,
            selector: if self.reverse { Selector::Reverse } else { Selector::Drive },
            ..Controls::default()
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

    /// evdev's event types in the upper half, as gilrs writes its codes.
    const KEY: u32 = 0x0001_0000;
    const ABS: u32 = 0x0003_0000;

    fn plugged(key: usize, name: &str, kind: PadDeviceKind) -> Pads {
        let mut pads = Pads::none();
        pads.devices.insert(key, PadDevice { name: name.into(), kind });
        pads
    }

    #[test]
    fn a_pad_drives_with_stick_triggers_and_its_west_button() {
        let mut pads = plugged(3, "Pad", PadDeviceKind::Pad(PadState::default()));
        assert_eq!((pads.controls(), pads.name()), (None, None), "nobody has touched it");
        assert!(!pads.touch(4, PadEvent::Press(Button::West, KEY)), "one that is not known");
        for moved in [
            PadEvent::Axis(Axis::LeftStickX, 1.0, ABS),
            PadEvent::Axis(Axis::LeftStickY, -1.0, ABS + 1),
            PadEvent::Button(Button::RightTrigger2, 0.75),
            PadEvent::Button(Button::LeftTrigger2, 0.25),
            PadEvent::Button(Button::East, 1.0),
            PadEvent::Press(Button::East, KEY),
            PadEvent::Press(Button::West, KEY),
        ] {
            assert!(pads.touch(3, moved));
        }
        // Stick fully to the right: half of the lock.
        let steering_wheel_rad = -0.5 * STEERING_LOCK_RAD;
        let pedals = Controls { throttle: 0.75, brake: 0.25, ..Controls::default() };
        let asked = Controls { steering_wheel_rad, selector: Selector::Reverse, ..pedals };
        assert_eq!((pads.controls(), pads.name()), (Some(asked), Some("Pad")));
        pads.touch(3, PadEvent::Press(Button::West, KEY));
        assert_eq!(pads.controls().map(|c| c.selector), Some(Selector::Drive));
        // The next drive does not begin in reverse.
        pads.touch(3, PadEvent::Press(Button::West, KEY));
        pads.select_drive();
        assert_eq!(pads.controls().map(|c| c.selector), Some(Selector::Drive));
        pads.disconnect(4);
        assert!(pads.controls().is_some(), "that was another");
        pads.disconnect(3);
        assert_eq!((pads.controls(), pads.name()), (None, None));
    }

    #[test]
    fn a_wheel_read_by_gilrs_drives_by_the_codes_of_its_axes() {
        let axes = known_wheel(Some(0x046d), Some(0xc24f), "G29").unwrap();
        let mut pads = plugged(7, "G29", PadDeviceKind::Wheel { axes, state: GilrsWheelState::default() });
        for (code, value) in [(0, -1.0), (1, -1.0), (2, -1.0), (5, 1.0), (16, 1.0)] {
            assert!(pads.touch(7, PadEvent::Axis(Axis::Unknown, value, ABS + code)));
        }
        let asked = Controls { throttle: 1.0, steering_wheel_rad: STEERING_LOCK_RAD, ..Controls::default() };
        assert_eq!(pads.controls(), Some(asked), "full left and floored, the clutch is nothing");
        // docs/references.md: g29: 293 is the left paddle, 292 the right one.
        pads.touch(7, PadEvent::Press(Button::West, KEY + 292));
        assert_eq!(pads.controls(), Some(asked));
        pads.touch(7, PadEvent::Press(Button::Unknown, KEY + 293));
        assert_eq!(pads.controls(), Some(Controls { selector: Selector::Reverse, ..asked }));
        pads.select_drive();
        assert_eq!(pads.controls(), Some(asked));
    }

    #[test]
    fn a_stick_doses_small_corrections_finely() {
        let share = |stick: f32| {
            PadState { stick, ..PadState::default() }.controls().steering_wheel_rad / (STICK_LOCK * STEERING_LOCK_RAD)
        };
        // Half of the travel beyond the dead zone of 0.12 gives a quarter of the angle.
        assert!((share(0.56) + 0.25).abs() < 1e-6 && (share(-0.56) - 0.25).abs() < 1e-6, "{}", share(0.56));
        assert_eq!((share(0.12), share(-0.12)), (0.0, 0.0));
    }

    /// Levels sent to a wheel; `None` is the end.
    #[derive(Clone, Default)]
    struct Log(Arc<std::sync::Mutex<Vec<Option<i16>>>>);

    impl ForceDevice for Log {
        fn set(&mut self, level: i16) -> std::io::Result<()> {
            self.0.lock().unwrap().push(Some(level));
            Ok(())
        }

        fn end(&mut self) {
            self.0.lock().unwrap().push(None);
        }
    }

    #[test]
    fn a_wheel_read_by_gilrs_has_force_until_it_is_unplugged() {
        let (log, mut pads) = (Log::default(), Pads::none());
        let axes = known_wheel(Some(0x046d), Some(0xc24f), "G29").unwrap();
        let kind = PadDeviceKind::Wheel { axes, state: GilrsWheelState::default() };
        pads.devices.insert(7, PadDevice { name: "G29".into(), kind });
        assert_eq!(pads.take_torque_nm(), None);
        let mut torque_nm = None;
        pads.push(7, Box::new(log.clone()), &profiles::named("g29").unwrap());
        for _ in 0..100 {
            assert!(!pads.poll());
            torque_nm = pads.take_torque_nm();
            pads.set_force_input(ForceInput {
                aligning_nm: 4.0,
                speed_mps: 10.0,
                grass: 0.0,
                contact: 0.0,
                pulse: 0.0,
                held_rad: None,
                running: true,
            });
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        assert!(torque_nm.unwrap() > 1.3);
        let strongest = log.0.lock().unwrap().iter().flatten().min().copied();
        assert!(strongest.is_some_and(|level| level < -20_000), "to the left, against the axis: {strongest:?}");
        pads.disconnect(7);
        assert_eq!(log.0.lock().unwrap().last(), Some(&None));
        assert!(pads.force.is_none() && pads.take_torque_nm().is_none());
    }

    #[test]
    fn the_reason_for_missing_force_is_reported_once() {
        let mut pads = Pads::none();
        // No wheel has this product number.
        for _ in 0..3 {
            pads.strengthen(1, (0x046d, 0xcffe), "Some wheel");
        }
        let troubles = pads.take_troubles();
        assert_eq!(troubles.len(), 1, "{troubles:?}");
        assert!(troubles[0].starts_with("Some wheel gives no force (") && troubles[0].contains("remedy: "));
        assert_eq!(pads.take_troubles(), [""; 0]);
    }

    #[test]
    fn no_force_is_opened_for_a_second_wheel_or_a_profile_without_strength() {
        let g29 = profiles::named("g29").unwrap();
        let mut weak = g29.clone();
        weak.force.strength = 0.0;
        let mut pads = Pads { asked: Some(weak), ..Pads::none() };
        pads.strengthen(1, (0x046d, 0xcffe), "Some wheel");
        assert_eq!(pads.take_troubles(), [""; 0]);
        let mut pads = Pads::none();
        pads.push(7, Box::new(Log::default()), &g29);
        pads.strengthen(1, (0x046d, 0xcffe), "Some wheel");
        assert_eq!(pads.take_troubles(), [""; 0]);
        pads.disconnect(1);
        assert!(pads.take_torque_nm().is_some(), "the force is that of 7");
    }

    #[test]
    fn a_stick_to_the_left_steers_left() {
        let state = PadState { stick: -1.0, ..PadState::default() };
        assert_eq!(state.controls().steering_wheel_rad, STICK_LOCK * STEERING_LOCK_RAD);
    }

    #[test]
    fn half_stick_travel_steers_a_quarter_to_the_same_side() {
        let steered = |stick| PadState { stick, ..PadState::default() }.controls().steering_wheel_rad;
        let half = STICK_DEAD + (1.0 - STICK_DEAD) / 2.0;
        let quarter = STICK_LOCK * STEERING_LOCK_RAD / 4.0;
        assert!((steered(half) + quarter).abs() < 1e-5 && (steered(-half) - quarter).abs() < 1e-5, "{}", steered(half));
    }
}
