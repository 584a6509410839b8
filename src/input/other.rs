//! Steering wheels through gilrs, on systems without evdev (docs/references.md: g29). In: raw axis codes and values of
//! gilrs (-1 to 1). Out: wheel angle and pedals. Raw codes are used because a wheel has no gamepad mapping and its axis
//! names in gilrs are arbitrary.

use crate::controls::{Controls, STEERING_LOCK_RAD, Selector};

/// Function of an axis of a wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WheelAxis {
    /// Steering: -1 full left to 1 full right.
    Steering,
    /// Accelerator: 1 released to -1 floored.
    Accelerator,
    /// Brake: 1 released to -1 pressed.
    Brake,
    /// Clutch; unused, because the ego is automatic.
    Clutch,
}

/// Returns the axes of a wheel by evdev code (type 3 in the upper half, as gilrs writes it), or `None` if the device is
/// no known wheel. Logitech's native modes (docs/references.md: g29): G27 c29b, G29 c24f, G923 c266. The G920 c262 and
/// the Xbox G923 c26e order their pedals differently (kernel driver hid-logitech-hidpp).
pub fn known_wheel(vendor: Option<u16>, product: Option<u16>, name: &str) -> Option<&'static [(u32, WheelAxis)]> {
    const EV_ABS: u32 = 3 << 16;
    const G29: &[(u32, WheelAxis)] = &[
        (EV_ABS, WheelAxis::Steering),
        (EV_ABS + 1, WheelAxis::Clutch),
        (EV_ABS + 2, WheelAxis::Accelerator),
        (EV_ABS + 5, WheelAxis::Brake),
    ];
    const G920: &[(u32, WheelAxis)] = &[
        (EV_ABS, WheelAxis::Steering),
        (EV_ABS + 1, WheelAxis::Accelerator),
        (EV_ABS + 2, WheelAxis::Brake),
        (EV_ABS + 5, WheelAxis::Clutch),
    ];
    match (vendor, product) {
        (Some(0x046d), Some(0xc262 | 0xc26e)) => Some(G920),
        (Some(0x046d), Some(0xc29b | 0xc24f | 0xc266)) => Some(G29),
        _ if ["wheel", "racing", "driving force"].iter().any(|word| name.to_lowercase().contains(word)) => Some(G29),
        _ => None,
    }
}

/// State of a wheel read by gilrs; an axis without an event is `None` and has no effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GilrsWheelState {
    steering: Option<f32>,
    accelerator: Option<f32>,
    brake: Option<f32>,
    reverse: bool,
}

impl GilrsWheelState {
    /// Applies a movement of an axis to `value`, -1 to 1.
    pub fn moved(&mut self, axis: WheelAxis, value: f32) {
        match axis {
            WheelAxis::Steering => self.steering = Some(value),
            WheelAxis::Accelerator => self.accelerator = Some(value),
            WheelAxis::Brake => self.brake = Some(value),
            WheelAxis::Clutch => {}
        }
    }

    /// Switches between drive and reverse.
    pub fn toggle_reverse(&mut self) {
        self.reverse = !self.reverse;
    }

    /// Puts the selector into drive.
    pub fn select_drive(&mut self) {
        self.reverse = false;
    }

    /// Returns the controls that the wheel asks for.
    pub fn controls(&self) -> Controls {
        Controls {
            throttle: self.accelerator.map_or(0.0, pedal),
            brake: self.brake.map_or(0.0, pedal),
            steering_wheel_rad: -self.steering.unwrap_or(0.0) * STEERING_LOCK_RAD,
            selector: if self.reverse { Selector::Reverse } else { Selector::Drive },
            ..Controls::default()
        }
    }
}

/// Converts a pedal value to 0 released to 1 floored. gilrs maps the raw range 255 to 0 to 1 to -0.992, because it
/// centres 127.
fn pedal(value: f32) -> f32 {
    ((1.0 - value) / 1.99).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_pedal_acts_before_its_first_event() {
        let mut wheel = GilrsWheelState::default();
        assert_eq!(wheel.controls(), Controls::default());
        wheel.moved(WheelAxis::Accelerator, -0.992);
        let controls = wheel.controls();
        assert_eq!((controls.throttle, controls.brake), (1.0, 0.0), "the brake has not been touched");
    }

    #[test]
    fn a_released_pedal_is_zero_and_a_pressed_one_is_one() {
        assert_eq!(pedal(1.0), 0.0);
        assert_eq!(pedal(-0.9922), 1.0);
        assert!((pedal(0.0) - 0.5).abs() < 0.01);
    }

    #[test]
    fn full_left_on_a_g29_is_the_cars_lock_to_the_left() {
        let axes = known_wheel(Some(0x046d), Some(0xc24f), "Logitech G29").unwrap();
        assert_eq!(axes[0], (196_608, WheelAxis::Steering));
        assert_eq!(axes[3], (196_613, WheelAxis::Brake));
        let mut wheel = GilrsWheelState::default();
        wheel.moved(WheelAxis::Steering, -1.0);
        assert_eq!(wheel.controls().steering_wheel_rad, STEERING_LOCK_RAD);
    }

    #[test]
    fn a_g920_has_other_pedal_axes_and_an_unknown_wheel_counts_as_a_g29() {
        // hid-logitech-hidpp reports them as Y, Z and RZ: accelerator, brake, clutch.
        for product in [0xc262, 0xc26e] {
            let axes = known_wheel(Some(0x046d), Some(product), "Logitech G920").unwrap();
            assert_eq!(axes.iter().map(|axis| axis.0 - 0x3_0000).collect::<Vec<_>>(), [0, 1, 2, 5]);
            let all = [WheelAxis::Steering, WheelAxis::Accelerator, WheelAxis::Brake, WheelAxis::Clutch];
            assert_eq!(axes.iter().map(|axis| axis.1).collect::<Vec<_>>(), all);
        }
        let g29 = known_wheel(Some(0x046d), Some(0xc24f), "");
        for (product, name) in [(0xc29b, ""), (0xc266, ""), (1, "A RACING pad"), (2, "Driving Force"), (3, "The Wheel")]
        {
            assert_eq!(known_wheel(Some(0x046d), Some(product), name), g29, "{name}");
        }
    }

    #[test]
    fn the_paddle_changes_between_drive_and_reverse() {
        let mut wheel = GilrsWheelState::default();
        wheel.toggle_reverse();
        assert_eq!(wheel.controls().selector, Selector::Reverse);
        wheel.toggle_reverse();
        assert_eq!(wheel.controls().selector, Selector::Drive);
    }

    #[test]
    fn a_gamepad_is_no_wheel() {
        assert_eq!(known_wheel(Some(0x045e), Some(0x028e), "Xbox 360 Controller"), None);
    }
}
