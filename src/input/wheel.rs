//! State of a steering wheel. In: messages of the reading thread ([`WheelMessage`]). Out: [`Controls`], button actions,
//! the time of the newest input. A pedal counts as released until it has been seen at rest once: a driver reports an
//! unread pedal as floored, and a foot may rest on a pedal.

use super::{
    buttons::ButtonAction,
    clock::TimeStamp,
    force_thread::{ForceDevice, SharedAngle},
    lamps::Lamps,
    profile::WheelProfile,
    profiles::UnprofiledDevice,
};
use crate::controls::{Controls, Selector};
use std::{collections::BTreeMap, sync::Arc};

/// Smallest change of pedal travel (share) and of wheel angle (rad) that counts as a hand or foot; a worn sensor's
/// noise is smaller.
const TOUCH_WAY: f64 = 0.03;
const TOUCH_RAD: f64 = 0.02;

/// Message of the reading thread.
pub enum WheelMessage {
    /// A wheel was opened.
    Connected(Box<FoundWheel>),
    Axis {
        /// Axis code of evdev.
        code: u16,
        /// Raw value of the device.
        raw: i32,
        /// Kernel time stamp; `None` if it is implausible.
        at: Option<TimeStamp>,
    },
    /// A button was pressed or released.
    Button {
        /// Button code of evdev.
        code: u16,
        /// True for a press, false for a release.
        down: bool,
        /// Kernel time stamp; `None` if it is implausible.
        at: Option<TimeStamp>,
    },
    /// The wheel was unplugged.
    Lost,
    /// A message for people, sent once.
    Trouble(String),
}

impl WheelMessage {
    /// Returns the code of the axis that moved.
    pub fn axis(&self) -> Option<u16> {
        if let Self::Axis { code, .. } = self { Some(*code) } else { None }
    }
}

/// A wheel that was found and opened.
pub struct FoundWheel {
    /// Name and axes of the device, and the axes' values when it was opened.
    pub device: UnprofiledDevice,
    pub profile: WheelProfile,
    /// Rev lamps; empty if the wheel has none.
    pub lamps: Lamps,
    /// Receiver of the force levels, if the wheel takes force.
    pub force: Option<Box<dyn ForceDevice>>,
    /// Angle of the wheel, written by the reading thread.
    pub angle: Arc<SharedAngle>,
}

/// State of a wheel, from the messages so far.
#[derive(Clone, Debug)]
pub struct WheelState {
    profile: WheelProfile,
    /// Last raw values by axis; an axis that has not been read is absent.
    raw: BTreeMap<u16, i32>,
    /// Axes of the pedals that have been seen at rest.
    armed: Vec<u16>,
    /// Last value of each hat.
    hats: BTreeMap<u16, i32>,
    /// Raw values at the last touch.
    touched: BTreeMap<u16, i32>,
    reverse: bool,
    horn: bool,
    /// True while the handbrake's button is held.
    handbrake: bool,
    /// True if the pedals have no effect, because the driver reports them the other way round.
    pedals_refused: bool,
}

impl WheelState {
    /// Makes the state from the values read when the wheel was opened. If all of them are 0, the driver has not read
    /// the wheel yet.
    pub fn new(profile: WheelProfile, values: BTreeMap<u16, i32>) -> Self {
        let raw = if values.values().all(|raw| *raw == 0) { BTreeMap::new() } else { values };
        let (touched, hats) = (raw.clone(), BTreeMap::new());
        let (reverse, horn, handbrake, pedals_refused) = (false, false, false, false);
        let armed = Vec::new();
        let mut state = Self { profile, touched, raw, hats, armed, reverse, horn, handbrake, pedals_refused };
        state.arm();
        state
    }

    pub fn profile(&self) -> &WheelProfile {
        &self.profile
    }

    /// Applies a movement of an axis. Returns true if a hand or foot caused it.
    pub fn moved(&mut self, code: u16, raw: i32) -> bool {
        self.raw.insert(code, raw);
        self.arm();
        let before = *self.touched.entry(code).or_insert(raw);
        let touched = if code == self.profile.steering.axis {
            (self.profile.steering.wheel_rad(raw) - self.profile.steering.wheel_rad(before)).abs() > TOUCH_RAD
        } else {
            let way = |pedal: &super::profile::Pedal| (pedal.way(raw) - pedal.way(before)).abs() > TOUCH_WAY;
            self.profile.pedals().any(|(_, pedal)| pedal.code() == code && way(pedal))
        };
        if touched {
            self.touched.insert(code, raw);
        }
        touched
    }

    /// Applies a movement of a hat and returns its action. A repeated value has no action.
    pub fn hat(&mut self, code: u16, raw: i32) -> Option<ButtonAction> {
        let before = self.hats.insert(code, raw);
        ButtonAction::of_hat(code, raw).filter(|_| before != Some(raw))
    }

    /// Applies a button press and returns its action. Switches between drive and reverse, and starts horn and handbrake.
    pub fn pressed(&mut self, code: u16) -> Option<ButtonAction> {
        let action = self.profile.buttons.action(code);
        self.horn |= action == Some(ButtonAction::Horn);
        self.handbrake |= action == Some(ButtonAction::Handbrake);
        if action == Some(ButtonAction::Reverse) {
            self.reverse = !self.reverse;
        }
        action
    }

    /// Applies a button release: horn and handbrake last as long as their button is held.
    pub fn released(&mut self, code: u16) {
        let action = self.profile.buttons.action(code);
        self.horn &= action != Some(ButtonAction::Horn);
        self.handbrake &= action != Some(ButtonAction::Handbrake);
    }

    /// Checks whether the horn is held.
    pub fn horn(&self) -> bool {
        self.horn
    }

    /// Returns the last raw values of the axes that have been read.
    pub fn raw(&self) -> &BTreeMap<u16, i32> {
        &self.raw
    }

    /// Takes the effect from the pedals until the wheel is opened again.
    pub fn refuse_pedals(&mut self) {
        self.pedals_refused = true;
    }

    /// Sets the selector, to keep it when a wheel is plugged in again.
    pub fn set_reverse(&mut self, reverse: bool) {
        self.reverse = reverse;
    }

    /// Returns the controls that the wheel asks for. The handbrake acts as the brake pedal: recordings have one brake.
    pub fn controls(&self) -> Controls {
        let lever = if self.handbrake { 1.0 } else { self.effect(self.profile.handbrake.as_ref()) };
        let steering = self.raw.get(&self.profile.steering.axis);
        Controls {
            throttle: self.effect(Some(&self.profile.accelerator)),
            brake: self.effect(self.profile.brake.as_ref()).max(lever),
            steering_wheel_rad: steering.map_or(0.0, |raw| self.profile.steering.car_rad(*raw)),
            selector: if self.reverse { Selector::Reverse } else { Selector::Drive },
            ..Controls::default()
        }
    }

    fn effect(&self, pedal: Option<&super::profile::Pedal>) -> f32 {
        pedal
            .filter(|pedal| !self.pedals_refused && self.armed.contains(&pedal.code()))
            .and_then(|pedal| Some(pedal.effect(*self.raw.get(&pedal.code())?)))
            .unwrap_or(0.0)
    }

    /// Arms the pedals that are seen at rest. The two pedals of a combined axis rest together, in its middle.
    fn arm(&mut self) {
        let Self { profile, raw, armed, .. } = self;
        let rests = |axis: u16| {
            let mut its = profile.pedals().filter(|(_, pedal)| pedal.code() == axis);
            raw.get(&axis).is_some_and(|raw| its.all(|(_, pedal)| pedal.is_released(*raw)))
        };
        for (_, pedal) in profile.pedals() {
            if !armed.contains(&pedal.code()) && rests(pedal.code()) {
                armed.push(pedal.code());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::profiles, *};
    use crate::controls::STEERING_LOCK_RAD;

    fn g29(values: &[(u16, i32)]) -> WheelState {
        WheelState::new(profiles::named("g29").unwrap(), values.iter().copied().collect())
    }

    const REST: [(u16, i32); 4] = [(0, 32_767), (1, 255), (2, 255), (5, 255)];

    #[test]
    fn a_wheel_at_rest_asks_for_nothing_without_any_event() {
        assert_eq!(g29(&REST).controls(), Controls::default());
    }

    #[test]
    fn a_wheel_that_the_driver_has_not_read_asks_for_nothing() {
        // Raw 0 would mean both pedals floored and full left.
        assert_eq!(g29(&[(0, 0), (1, 0), (2, 0), (5, 0)]).controls(), Controls::default());
        assert_eq!(g29(&[]).controls(), Controls::default());
    }

    #[test]
    fn a_pedal_acts_only_after_it_was_seen_at_rest() {
        let mut wheel = g29(&[(0, 32_767), (2, 0), (5, 255)]);
        assert_eq!(wheel.controls().throttle, 0.0, "a foot stood on it at the start");
        wheel.moved(2, 10);
        assert_eq!(wheel.controls().throttle, 0.0);
        wheel.moved(2, 250);
        wheel.moved(2, 0);
        assert_eq!(wheel.controls().throttle, 1.0);
        wheel.moved(5, 0);
        assert_eq!(wheel.controls().brake, 1.0);
    }

    #[test]
    fn a_combined_axis_is_accelerator_and_brake_after_it_rested_in_the_middle() {
        let mut profile = profiles::named("g29").unwrap();
        let pedal = |pressed| super::super::profile::Pedal { released: 128, pressed, ..profile.accelerator.clone() };
        (profile.accelerator, profile.brake) = (pedal(0), Some(pedal(255)));
        let profile = WheelProfile::from_toml(&profile.to_toml(), "combined").unwrap();
        let asked = |wheel: &WheelState| (wheel.controls().throttle, wheel.controls().brake);
        let mut wheel = WheelState::new(profile, [(0, 32_767), (2, 0)].into());
        assert_eq!(asked(&wheel), (0.0, 0.0), "a foot was on it at the start");
        wheel.moved(2, 255);
        assert_eq!(asked(&wheel), (0.0, 0.0), "it went through the middle unseen");
        wheel.moved(2, 128);
        assert_eq!(asked(&wheel), (0.0, 0.0));
        for (raw, expected) in [(0, (1.0, 0.0)), (255, (0.0, 1.0)), (128, (0.0, 0.0))] {
            wheel.moved(2, raw);
            assert_eq!(asked(&wheel), expected, "at {raw}");
        }
    }

    #[test]
    fn refused_pedals_have_no_effect_and_the_wheel_still_steers() {
        let mut wheel = g29(&REST);
        wheel.refuse_pedals();
        for (code, raw) in [(2, 0), (5, 0), (0, 0)] {
            wheel.moved(code, raw);
        }
        let controls = wheel.controls();
        assert_eq!((controls.throttle, controls.brake, controls.steering_wheel_rad), (0.0, 0.0, STEERING_LOCK_RAD));
    }

    #[test]
    fn raw_values_are_the_last_reported_and_unread_axes_have_none() {
        let mut wheel = g29(&REST);
        wheel.moved(5, 30);
        wheel.moved(16, -1);
        assert_eq!(*wheel.raw(), [(0, 32_767), (1, 255), (2, 255), (5, 30), (16, -1)].into());
        assert!(g29(&[(0, 0), (2, 0)]).raw().is_empty());
    }

    #[test]
    fn full_left_is_the_cars_lock_to_the_left() {
        let mut wheel = g29(&REST);
        wheel.moved(0, 0);
        assert_eq!(wheel.controls().steering_wheel_rad, STEERING_LOCK_RAD);
    }

    #[test]
    fn sensor_noise_is_no_touch_and_a_hand_is_one() {
        let mut wheel = g29(&REST);
        assert!(!wheel.moved(0, 32_790) && !wheel.moved(2, 253) && !wheel.moved(17, 1));
        assert!(wheel.moved(0, 33_200));
        assert!(wheel.moved(2, 240));
    }

    #[test]
    fn a_touch_is_more_than_0_03_of_the_travel_since_the_last_touch() {
        let mut profile = profiles::named("g29").unwrap();
        (profile.accelerator.released, profile.accelerator.pressed) = (0, 100);
        let mut wheel = WheelState::new(profile, [(0, 32_767), (2, 0), (5, 255)].into());
        let moves = [(3, false), (4, true), (6, false), (50, true), (51, false), (52, false), (48, false), (54, true)];
        for (raw, touched) in moves {
            assert_eq!(wheel.moved(2, raw), touched, "to {raw}");
        }
    }

    /// G29 with a handbrake on its clutch's axis, and one on button 300.
    fn with_handbrake(values: &[(u16, i32)]) -> WheelState {
        let mut profile = profiles::named("g29").unwrap();
        profile.handbrake = Some(super::super::profile::Pedal { axis: 1, ..profile.accelerator.clone() });
        profile.buttons.handbrake = vec![300.into()];
        WheelState::new(profile, values.iter().copied().collect())
    }

    #[test]
    fn the_handbrake_brakes_as_far_as_the_pedal_or_further() {
        let mut wheel = with_handbrake(&REST);
        for (code, raw) in [(1, 100), (5, 200)] {
            wheel.moved(code, raw);
        }
        let lever = wheel.profile().handbrake.as_ref().unwrap().effect(100);
        let pedal = wheel.profile().brake.as_ref().unwrap().effect(200);
        assert!(0.0 < pedal && pedal < lever && lever < 1.0, "{pedal} {lever}");
        assert_eq!(wheel.controls().brake, lever);
        wheel.moved(5, 0);
        assert_eq!(wheel.controls().brake, 1.0);
        wheel.moved(1, 255);
        wheel.moved(5, 255);
        assert_eq!(wheel.controls().brake, 0.0);
    }

    #[test]
    fn a_handbrake_that_was_pulled_at_the_start_acts_after_its_release() {
        let mut wheel = with_handbrake(&[(0, 32_767), (1, 0), (2, 255), (5, 255)]);
        assert_eq!(wheel.controls().brake, 0.0);
        wheel.moved(1, 255);
        wheel.moved(1, 0);
        assert_eq!(wheel.controls().brake, 1.0);
    }

    #[test]
    fn a_handbrake_button_brakes_while_it_is_held() {
        let mut wheel = with_handbrake(&REST);
        assert_eq!((wheel.pressed(300), wheel.controls().brake), (Some(ButtonAction::Handbrake), 1.0));
        wheel.released(289);
        assert_eq!(wheel.controls().brake, 1.0, "that was another button");
        wheel.released(300);
        assert_eq!(wheel.controls().brake, 0.0);
    }

    #[test]
    fn buttons_do_what_the_profile_says() {
        let mut wheel = g29(&REST);
        assert_eq!(wheel.pressed(293), Some(ButtonAction::Reverse));
        assert_eq!(wheel.controls().selector, Selector::Reverse);
        assert_eq!(wheel.pressed(297), Some(ButtonAction::Start));
        assert_eq!(wheel.pressed(999), None);
        assert_eq!((wheel.pressed(289), wheel.horn()), (Some(ButtonAction::Horn), true));
        wheel.released(297);
        assert!(wheel.horn());
        wheel.released(289);
        assert!(!wheel.horn());
    }
}
