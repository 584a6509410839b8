//! A steering wheel as the car sees it. In: what the reading thread tells ([`WheelMessage`]). Out: [`Controls`], actions of
//! buttons, time of the newest input. Nothing acts before it is known: a pedal counts as released until it has been seen
//! at rest once, since a driver reports a pedal that it has not read as floored, and a foot may rest on one.

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

/// Way of a pedal below which it counts as seen at rest.
const AT_REST: f64 = 0.15;
/// Share of a pedal's way, and turn of the wheel in radians, that count as a hand or foot: more than a worn sensor's noise.
const TOUCH_WAY: f64 = 0.03;
const TOUCH_RAD: f64 = 0.02;

/// What the reading thread tells.
pub enum WheelMessage {
    /// A wheel is there.
    Connected(Box<FoundWheel>),
    /// An axis moved.
    Axis {
        /// evdev code.
        code: u16,
        /// Raw value.
        raw: i32,
        /// When, by the kernel.
        at: Option<TimeStamp>,
    },
    /// A button went down or came up.
    Button {
        /// evdev code.
        code: u16,
        /// True if it went down.
        down: bool,
        /// When, by the kernel.
        at: Option<TimeStamp>,
    },
    /// The wheel was unplugged.
    Lost,
    /// Something to tell a person, once.
    Trouble(String),
}

/// A wheel that was found.
pub struct FoundWheel {
    /// The device: its name, axes and their values when it was opened.
    pub device: UnprofiledDevice,
    /// Its profile.
    pub profile: WheelProfile,
    /// Rev lamps, if it has any.
    pub lamps: Lamps,
    /// What takes its force, if it has any.
    pub force: Option<Box<dyn ForceDevice>>,
    /// Its turn, kept by the reading thread.
    pub angle: Arc<SharedAngle>,
}

/// What is known of a wheel so far.
#[derive(Clone, Debug)]
pub struct WheelState {
    profile: WheelProfile,
    /// Last raw values; an axis that is not known has none.
    raw: BTreeMap<u16, i32>,
    /// Pedals that were seen at rest, by axis.
    armed: Vec<u16>,
    /// Where each hat stands.
    hats: BTreeMap<u16, i32>,
    /// Values at the last touch.
    touched: BTreeMap<u16, i32>,
    reverse: bool,
    horn: bool,
}

impl WheelState {
    /// A wheel with the values that were read when it was opened. If all of them are 0 the driver has not read any.
    pub fn new(profile: WheelProfile, values: BTreeMap<u16, i32>) -> Self {
        let raw = if values.values().all(|raw| *raw == 0) { BTreeMap::new() } else { values };
        let (touched, hats) = (raw.clone(), BTreeMap::new());
        let mut state = Self { profile, touched, raw, hats, armed: Vec::new(), reverse: false, horn: false };
        state.arm();
        state
    }

    /// Its profile.
    pub fn profile(&self) -> &WheelProfile {
        &self.profile
    }

    /// An axis moved. True if a hand or foot moved it.
    pub fn moved(&mut self, code: u16, raw: i32) -> bool {
        self.raw.insert(code, raw);
        self.arm();
        let before = *self.touched.entry(code).or_insert(raw);
        let touched = if code == self.profile.steering.axis {
            (self.profile.steering.wheel_rad(raw) - self.profile.steering.wheel_rad(before)).abs() > TOUCH_RAD
        } else {
            let way = |pedal: &super::profile::Pedal| (pedal.way(raw) - pedal.way(before)).abs() > TOUCH_WAY;
            self.profile.pedals().any(|(_, pedal)| pedal.axis == code && way(pedal))
        };
        if touched {
            self.touched.insert(code, raw);
        }
        touched
    }

    /// A hat moved: what its way out of the middle asks for. A hat that is told twice at the same place asks once.
    pub fn hat(&mut self, code: u16, raw: i32) -> Option<ButtonAction> {
        let before = self.hats.insert(code, raw);
        ButtonAction::of_hat(code, raw).filter(|_| before != Some(raw))
    }

    /// A button went down: what it does. Drive and reverse are changed here, and the horn begins.
    pub fn pressed(&mut self, code: u16) -> Option<ButtonAction> {
        let action = self.profile.buttons.action(code);
        self.horn |= action == Some(ButtonAction::Horn);
        if action == Some(ButtonAction::Reverse) {
            self.reverse = !self.reverse;
        }
        action
    }

    /// A button came up: the horn ends with its own.
    pub fn released(&mut self, code: u16) {
        self.horn &= self.profile.buttons.action(code) != Some(ButtonAction::Horn);
    }

    /// True while the horn is held.
    pub fn horn(&self) -> bool {
        self.horn
    }

    /// Last raw values of the axes that are known.
    pub fn raw(&self) -> &BTreeMap<u16, i32> {
        &self.raw
    }

    /// The selector, as it is kept when a wheel comes back.
    pub fn set_reverse(&mut self, reverse: bool) {
        self.reverse = reverse;
    }

    /// What the wheel asks of the car.
    pub fn controls(&self) -> Controls {
        let steering = self.raw.get(&self.profile.steering.axis);
        Controls {
            throttle: self.effect(Some(&self.profile.accelerator)),
            brake: self.effect(self.profile.brake.as_ref()),
            steering_wheel_rad: steering.map_or(0.0, |raw| self.profile.steering.car_rad(*raw)),
            selector: if self.reverse { Selector::Reverse } else { Selector::Drive },
            ..Controls::default()
        }
    }

    fn effect(&self, pedal: Option<&super::profile::Pedal>) -> f32 {
        pedal
            .filter(|pedal| self.armed.contains(&pedal.axis))
            .and_then(|pedal| Some(pedal.effect(*self.raw.get(&pedal.axis)?)))
            .unwrap_or(0.0)
    }

    fn arm(&mut self) {
        let Self { profile, raw, armed, .. } = self;
        for (_, pedal) in profile.pedals() {
            let rests = raw.get(&pedal.axis).is_some_and(|raw| pedal.way(*raw) < AT_REST);
            if rests && !armed.contains(&pedal.axis) {
                armed.push(pedal.axis);
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
        // Raw 0 would be both pedals floored and full left.
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
    fn the_raw_values_are_the_last_that_were_told_and_none_of_an_axis_that_was_not_read() {
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
    fn noise_is_no_touch_and_a_hand_is() {
        let mut wheel = g29(&REST);
        assert!(!wheel.moved(0, 32_790) && !wheel.moved(2, 253) && !wheel.moved(17, 1));
        assert!(wheel.moved(0, 33_200));
        assert!(wheel.moved(2, 240));
    }

    #[test]
    fn a_foot_is_more_than_three_hundredths_of_the_way_from_where_it_was_last_told() {
        let mut profile = profiles::named("g29").unwrap();
        (profile.accelerator.released, profile.accelerator.pressed) = (0, 100);
        let mut wheel = WheelState::new(profile, [(0, 32_767), (2, 0), (5, 255)].into());
        let moves = [(3, false), (4, true), (6, false), (50, true), (51, false), (52, false), (48, false), (54, true)];
        for (raw, touched) in moves {
            assert_eq!(wheel.moved(2, raw), touched, "to {raw}");
        }
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
