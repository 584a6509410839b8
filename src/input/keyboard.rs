//! Driving with the keyboard. In: the keys that are down, speed, lane. Out: smooth [`Controls`] per tick. A key is only
//! a switch, so the pedals and the wheel move at the speed of a foot and a hand, and the wheel turns less at higher
//! speed.

use crate::{
    controls::{Controls, LaneHint, STEERING_LOCK_RAD, STEERING_RATIO, Selector},
    time::TICK_S,
};

/// Keys that drive the ego.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveKey {
    Throttle,
    Brake,
    Left,
    Right,
    Horn,
}

/// Pedal moved by a key: quickly to a useful share, then slowly on while the key is held, and quickly back after
/// release.
struct KeyPedal {
    /// Share of the travel that is reached quickly.
    soon: f64,
    /// Time to that share, s.
    soon_s: f64,
    /// Rate beyond that share, per second.
    press_per_s: f64,
    /// Largest share of the travel that the key reaches.
    most: f64,
}

/// Accelerator: 0.4 gives 1.0 m/s² at walking pace. Taps hold 4 m/s, and a held key accelerates briskly.
const THROTTLE: KeyPedal = KeyPedal { soon: 0.4, soon_s: 0.3, press_per_s: 0.2, most: 1.0 };
/// Brake: 0.15 gives 1.5 m/s²; 0.6 is a firm stop of about 6 m/s².
const BRAKE: KeyPedal = KeyPedal { soon: 0.15, soon_s: 0.15, press_per_s: 0.7, most: 0.6 };
const PEDAL_UP_S: f64 = 0.2;
/// Lateral acceleration that limits the keys' steering, m/s²: firm, not yet sliding.
const KEY_LATERAL_MPS2: f64 = 4.0;
/// Time from straight to the limit of the keys' steering, and back, s.
const STEER_IN_S: f64 = 0.6;
const STEER_OUT_S: f64 = 0.35;
/// Largest road wheel angle, rad.
const LOCK_RAD: f64 = (STEERING_LOCK_RAD / STEERING_RATIO) as f64;
/// Wheelbase that the limits assume, m.
const WHEELBASE_M: f64 = 2.8;
/// Lane help: road wheel angle per radian of heading error, and per metre of offset.
const HELP_PER_HEADING: f64 = 0.9;
const HELP_PER_METRE: f64 = 0.06;

/// Longest time between two strokes of the brake key that ask for reverse at a standstill, s. A single stroke does not,
/// because a driver in a queue brakes again and again.
const TWICE_S: f64 = 0.4;
/// Speed below which the ego is at a standstill, m/s.
const STANDS_MPS: f64 = 0.1;

/// State of the keys, and of the pedals and the wheel that they move.
#[derive(Clone, Debug, Default)]
pub struct Keyboard {
    down: [bool; 5],
    throttle: f64,
    brake: f64,
    /// Steering by the keys as a share of its limit, -1 right to 1 left.
    steer: f64,
    selector: Selector,
    /// True after reverse was requested with the brake key: the brake key then accelerates, and the accelerator key
    /// brakes.
    swapped: bool,
    /// Keys of accelerator and brake in the previous tick, and the time since the last stroke of the brake key, s.
    before: [bool; 2],
    since_brake_s: f64,
}

impl Keyboard {
    /// Sets a key to pressed or released.
    pub fn set(&mut self, key: DriveKey, down: bool) {
        self.down[key as usize] = down;
    }

    /// Releases all keys, for a window without focus or a paused drive.
    pub fn release_all(&mut self) {
        self.down = [false; 5];
    }

    /// Resets pedals, wheel and selector for the start of a drive; keys that are down stay down.
    pub fn rest(&mut self) {
        *self = Self { down: self.down, ..Self::default() };
    }

    /// Keeps the selector in Drive: before a drive begins, repeated strokes of the brake key only brake.
    pub fn stay_in_drive(&mut self) {
        (self.selector, self.swapped, self.since_brake_s) = (Selector::Drive, false, TWICE_S);
    }

    /// Switches between drive and reverse; the gearbox refuses the change while the ego rolls.
    pub fn toggle_reverse(&mut self) {
        self.selector = if self.selector == Selector::Reverse { Selector::Drive } else { Selector::Reverse };
        self.swapped = false;
    }

    /// Changes the selector at a standstill: two strokes of the brake key give reverse, one of the accelerator key
    /// gives drive again.
    fn shift(&mut self, speed_mps: f64) {
        let now = [self.down[DriveKey::Throttle as usize], self.down[DriveKey::Brake as usize]];
        let struck = [0, 1].map(|i| now[i] && !self.before[i]);
        self.before = now;
        let stands = speed_mps.abs() < STANDS_MPS;
        if struck[1] && stands && self.selector == Selector::Drive && self.since_brake_s < TWICE_S {
            (self.selector, self.swapped) = (Selector::Reverse, true);
        } else if struck[0] && stands && self.swapped {
            (self.selector, self.swapped) = (Selector::Drive, false);
        }
        self.since_brake_s = if struck[1] { 0.0 } else { self.since_brake_s + TICK_S };
    }

    /// Checks whether a key is down that moves a pedal or the wheel.
    pub fn any_down(&self) -> bool {
        self.down[..DriveKey::Horn as usize].contains(&true)
    }

    /// Checks whether this key is down.
    pub fn is_down(&self, key: DriveKey) -> bool {
        self.down[key as usize]
    }

    /// Checks whether the horn key is down.
    pub fn horn(&self) -> bool {
        self.down[DriveKey::Horn as usize]
    }

    /// Moves pedals and wheel by one tick.
    pub fn tick(&mut self, speed_mps: f64, hint: Option<LaneHint>) -> Controls {
        self.shift(speed_mps);
        let down = |key: DriveKey| self.down[key as usize];
        let [go, stop] =
            if self.swapped { [DriveKey::Brake, DriveKey::Throttle] } else { [DriveKey::Throttle, DriveKey::Brake] };
        let braking = down(stop);
        let accelerating = down(go) && !braking;
        let steer_goal = f64::from(down(DriveKey::Left)) - f64::from(down(DriveKey::Right));
        self.throttle = THROTTLE.moved(self.throttle, accelerating);
        self.brake = BRAKE.moved(self.brake, braking);
        let time_s = if steer_goal == 0.0 || steer_goal * self.steer < 0.0 { STEER_OUT_S } else { STEER_IN_S };
        self.steer = approach(self.steer, steer_goal, time_s);
        let helped_rad = hint.map_or(0.0, |hint| lane_help_rad(&hint, self.steer));
        let road_rad = (helped_rad + self.steer * key_limit_rad(speed_mps)).clamp(-LOCK_RAD, LOCK_RAD);
        Controls {
            throttle: self.throttle as f32,
            brake: self.brake as f32,
            steering_wheel_rad: road_rad as f32 * STEERING_RATIO,
            selector: self.selector,
            ..Controls::default()
        }
    }
}

/// Returns the limit of the keys' steering, rad at the road wheels: the lock at walking pace, the angle for 4 m/s² at
/// higher speed.
fn key_limit_rad(speed_mps: f64) -> f64 {
    (KEY_LATERAL_MPS2 * WHEELBASE_M / speed_mps.powi(2).max(1.0)).atan().min(LOCK_RAD)
}

/// Returns the steering of lane help, rad at the road wheels. The driver's own steering (-1 to 1) reduces the pull to
/// the centre line, to zero at full steering, so that lane help does not work against the driver.
fn lane_help_rad(hint: &LaneHint, steer: f64) -> f64 {
    let along = (WHEELBASE_M * hint.curvature).atan() - HELP_PER_HEADING * hint.heading_error_rad;
    along - (1.0 - steer.abs()) * HELP_PER_METRE * hint.offset_m
}

impl KeyPedal {
    /// Returns the pedal position one tick later.
    fn moved(&self, pedal: f64, pressed: bool) -> f64 {
        if !pressed {
            return approach(pedal, 0.0, PEDAL_UP_S);
        }
        let per_s = if pedal < self.soon { self.soon / self.soon_s } else { self.press_per_s };
        (pedal + per_s * TICK_S).min(self.most)
    }
}

/// Moves `value` by one tick towards `goal`, with `stroke_s` seconds for a change of 1.
fn approach(value: f64, goal: f64, stroke_s: f64) -> f64 {
    let step = TICK_S / stroke_s;
    value + (goal - value).clamp(-step, step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(keyboard: &mut Keyboard, seconds: f64, speed_mps: f64) -> Vec<Controls> {
        (0..(seconds / TICK_S) as usize).map(|_| keyboard.tick(speed_mps, None)).collect()
    }

    #[test]
    fn without_a_key_nothing_acts() {
        assert_eq!(Keyboard::default().tick(5.0, None), Controls::default());
    }

    #[test]
    fn a_tap_reaches_the_useful_part_of_a_pedal_and_a_held_key_floors_it() {
        let mut keyboard = Keyboard::default();
        keyboard.set(DriveKey::Throttle, true);
        let pressed = run(&mut keyboard, 4.0, 5.0);
        assert!(pressed.windows(2).all(|w| (0.0..=0.0134).contains(&(w[1].throttle - w[0].throttle))));
        assert!((pressed[30].throttle - 0.4).abs() < 0.02, "{}", pressed[30].throttle);
        assert_eq!(pressed[399].throttle, 1.0);
        keyboard.set(DriveKey::Brake, true);
        let last = run(&mut keyboard, 1.0, 5.0)[99];
        assert_eq!((last.throttle, last.brake), (0.0, 0.6), "the brake wins");
        keyboard.release_all();
        assert_eq!(run(&mut keyboard, 0.25, 5.0)[24], Controls::default(), "up at once");
    }

    #[test]
    fn before_a_drive_repeated_strokes_of_the_brake_key_only_brake() {
        let mut keyboard = Keyboard::default();
        for stroke in 0..12 {
            keyboard.set(DriveKey::Brake, stroke % 2 == 1);
            keyboard.stay_in_drive();
            keyboard.tick(0.0, None);
        }
        // The reverse key has no effect either.
        for toggles in [false, true] {
            if toggles {
                keyboard.toggle_reverse();
            }
            let mut held = Controls::default();
            for _ in 0..100 {
                keyboard.stay_in_drive();
                held = keyboard.tick(0.0, None);
            }
            assert_eq!((held.selector, held.throttle, held.brake), (Selector::Drive, 0.0, 0.6), "{toggles}");
        }
    }

    #[test]
    fn two_brake_strokes_are_reverse_and_the_accelerator_is_drive_again() {
        let strokes = |keyboard: &mut Keyboard, key: DriveKey, times: usize, apart_s: f64, speed_mps: f64| {
            for _ in 0..times {
                keyboard.set(key, true);
                run(keyboard, apart_s / 2.0, speed_mps);
                keyboard.set(key, false);
                run(keyboard, apart_s / 2.0, speed_mps);
            }
            keyboard.set(key, true);
            run(keyboard, 1.0, speed_mps)[99]
        };
        let mut keyboard = Keyboard::default();
        run(&mut keyboard, 1.0, 0.0);
        let once = strokes(&mut keyboard, DriveKey::Brake, 0, 0.2, 0.0);
        assert_eq!((once.selector, once.throttle, once.brake), (Selector::Drive, 0.0, 0.6), "one stroke brakes");
        keyboard.release_all();
        run(&mut keyboard, 1.0, 0.0);
        for (apart_s, speed_mps) in [(1.0, 0.0), (0.2, 2.0)] {
            let late = strokes(&mut keyboard, DriveKey::Brake, 1, apart_s, speed_mps);
            assert_eq!(late.selector, Selector::Drive, "{apart_s} s apart at {speed_mps} m/s");
            keyboard.release_all();
            run(&mut keyboard, 1.0, speed_mps);
        }
        let back = strokes(&mut keyboard, DriveKey::Brake, 1, 0.2, 0.0);
        assert_eq!((back.selector, back.brake), (Selector::Reverse, 0.0));
        assert!(back.throttle > 0.4, "held down it drives backwards: {}", back.throttle);
        keyboard.set(DriveKey::Brake, false);
        let braked = strokes(&mut keyboard, DriveKey::Throttle, 0, 0.2, -2.0);
        assert_eq!((braked.selector, braked.throttle, braked.brake), (Selector::Reverse, 0.0, 0.6), "the other brakes");
        keyboard.set(DriveKey::Throttle, false);
        run(&mut keyboard, 0.5, 0.0);
        let on = strokes(&mut keyboard, DriveKey::Throttle, 0, 0.2, 0.0);
        assert_eq!((on.selector, on.brake), (Selector::Drive, 0.0));
        assert!(on.throttle > 0.4);
    }

    #[test]
    fn steering_is_gentler_the_faster_the_car() {
        let end = |speed| {
            let mut keyboard = Keyboard::default();
            keyboard.set(DriveKey::Left, true);
            run(&mut keyboard, 1.0, speed)[99].steering_wheel_rad
        };
        assert!((end(0.0) - STEERING_LOCK_RAD).abs() < 1e-4);
        assert!(end(5.0) > end(10.0) && end(10.0) > end(30.0) && end(30.0) > 0.0);
        let road_rad = f64::from(end(20.0) / STEERING_RATIO);
        assert!((20.0_f64.powi(2) * road_rad.tan() / WHEELBASE_M - KEY_LATERAL_MPS2).abs() < 1e-3);
    }

    #[test]
    fn a_released_wheel_returns_to_straight() {
        let mut keyboard = Keyboard::default();
        keyboard.set(DriveKey::Right, true);
        assert!(run(&mut keyboard, 1.0, 8.0)[99].steering_wheel_rad < 0.0);
        keyboard.release_all();
        assert_eq!(run(&mut keyboard, 1.0, 8.0)[99].steering_wheel_rad, 0.0);
    }

    #[test]
    fn the_wheel_turns_to_a_side_in_0_6_s_and_back_in_0_35_s() {
        let steered = |keyboard: &mut Keyboard, ticks: i32| {
            let controls = (0..ticks).map(|_| keyboard.tick(0.0, None)).last().unwrap();
            controls.steering_wheel_rad / STEERING_LOCK_RAD
        };
        // A tick is 1/60 of the way out and 1/35 of the way back.
        let near = |value: f32, expected: f32| assert!((value - expected).abs() < 0.02, "{value}, not {expected}");
        let mut keyboard = Keyboard::default();
        keyboard.set(DriveKey::Left, true);
        near(steered(&mut keyboard, 30), 0.5);
        near(steered(&mut keyboard, 31), 1.0);
        keyboard.release_all();
        near(steered(&mut keyboard, 14), 0.6);
        keyboard.set(DriveKey::Right, true);
        near(steered(&mut keyboard, 21), 0.0);
        near(steered(&mut keyboard, 15), -0.25);
        keyboard.release_all();
        near(steered(&mut keyboard, 9), 0.0);
    }

    #[test]
    fn only_pedal_and_steering_keys_drive_and_the_horn_key_sounds_the_horn() {
        use DriveKey as K;
        for key in [K::Throttle, K::Brake, K::Left, K::Right] {
            let mut keyboard = Keyboard::default();
            assert!(!keyboard.any_down());
            keyboard.set(key, true);
            assert!(keyboard.any_down() && !keyboard.horn(), "{key:?}");
            keyboard.set(key, false);
            assert!(!keyboard.any_down(), "{key:?}");
        }
        let mut keyboard = Keyboard::default();
        keyboard.set(K::Horn, true);
        assert!(keyboard.horn() && !keyboard.any_down());
        keyboard.release_all();
        assert!(!keyboard.horn());
    }

    #[test]
    fn reverse_toggles_and_a_drive_begins_in_drive_with_keys_still_down() {
        let mut keyboard = Keyboard::default();
        let selector = |keyboard: &mut Keyboard| keyboard.tick(0.0, None).selector;
        assert_eq!(selector(&mut keyboard), Selector::Drive);
        keyboard.toggle_reverse();
        assert_eq!(selector(&mut keyboard), Selector::Reverse);
        keyboard.toggle_reverse();
        assert_eq!(selector(&mut keyboard), Selector::Drive);
        keyboard.toggle_reverse();
        keyboard.set(DriveKey::Throttle, true);
        run(&mut keyboard, 1.0, 0.0);
        keyboard.rest();
        assert!(keyboard.any_down());
        let first = keyboard.tick(0.0, None);
        // The first tick of the key from a released pedal: 0.4 in 0.3 s.
        assert!((first.throttle - 0.4 / 30.0).abs() < 1e-6 && first.selector == Selector::Drive, "{first:?}");
    }

    #[test]
    fn lane_help_corrects_heading_and_leaves_the_offset_to_a_steering_driver() {
        let helped = |hint: LaneHint, steer: f64| lane_help_rad(&hint, steer);
        let heading = LaneHint { heading_error_rad: 0.1, ..LaneHint::default() };
        assert!((helped(heading, 0.0) + 0.09).abs() < 1e-12 && (helped(heading, 1.0) + 0.09).abs() < 1e-12);
        let beside = LaneHint { offset_m: -0.5, ..LaneHint::default() };
        assert!((helped(beside, 0.0) - 0.03).abs() < 1e-12);
        assert!((helped(beside, -0.5) - 0.015).abs() < 1e-12, "half steered by hand, half the pull");
        assert_eq!(helped(beside, 1.0).abs(), 0.0);
    }

    #[test]
    fn lane_help_follows_the_bend_and_steers_back_to_the_middle() {
        let mut keyboard = Keyboard::default();
        let bend = LaneHint { curvature: 1.0 / 39.8, ..LaneHint::default() };
        let road_rad = f64::from(keyboard.tick(5.0, Some(bend)).steering_wheel_rad / STEERING_RATIO);
        assert!((road_rad - (WHEELBASE_M / 39.8).atan()).abs() < 1e-6);
        let left_of_it = LaneHint { offset_m: 1.0, ..LaneHint::default() };
        assert!(keyboard.tick(5.0, Some(left_of_it)).steering_wheel_rad < 0.0);
    }
}
