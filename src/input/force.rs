//! The force-feedback model. In: the wheel's angle, what the car feels ([`ForceInput`]), settings of the profile. Out: a
//! torque, N m, positive to the left, and the level that the kernel takes for it.
//!
//! The model: the car's self-aligning torque, dry friction (more while the tyres stand), damping, centring by setting,
//! shaking on grass, soft ends; capped, and faded in and out. Its filters delay by [`SMOOTH_S`] at most.

use super::profile::ForceSettings;
use std::f64::consts::TAU;

/// Time constant of what comes from the loop in steps of a tick, and of the wheel's speed, seconds.
pub const SMOOTH_S: f64 = 0.010;
/// The force begins to fade when the loop has not spoken for so long, seconds.
pub const STALE_S: f64 = 0.060;
/// And is gone so much later, seconds: four periods of the thread. With the one in which that is seen at most 84 ms after the
/// last word, and with the timers of the wheel's own driver (up to 8 ms, see `tests/wheel/usb.rs`) less than 100.
const FADE_OUT_S: f64 = 0.024;
/// Fades in, seconds: no hand is surprised.
const FADE_IN_S: f64 = 0.4;
/// Wheel speed at which dry friction is nearly full, rad/s: a steeper rise would buzz with the delay of the device.
const FRICTION_RADPS: f64 = 1.0;
/// Speed from which the tyres roll freely under the steering, m/s.
const ROLLING_MPS: f64 = 2.0;
/// Turn over which a soft end grows to the cap, radians.
const END_RAD: f64 = 0.2;

/// What the car tells the hands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceInput {
    /// Self-aligning torque at the steering wheel, N m, positive turns it to the left.
    pub aligning_nm: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Share of the front wheels on grass.
    pub grass: f64,
    /// True while time runs.
    pub running: bool,
}

/// The force of one wheel.
#[derive(Clone, Debug)]
pub struct ForceModel {
    settings: ForceSettings,
    end_rad: f64,
    aligning_nm: f64,
    grass: f64,
    wheel_radps: f64,
    wheel_rad: Option<f64>,
    way_m: f64,
    gain: f64,
}

impl ForceModel {
    /// A wheel that turns by `end_rad` to either side.
    pub fn new(settings: &ForceSettings, end_rad: f64) -> Self {
        Self {
            settings: settings.clone(),
            end_rad,
            aligning_nm: 0.0,
            grass: 0.0,
            wheel_radps: 0.0,
            wheel_rad: None,
            way_m: 0.0,
            gain: 0.0,
        }
    }

    /// The torque `dt_s` after the last, N m, positive to the left. `age_s` is how long ago the loop spoke.
    pub fn step(&mut self, dt_s: f64, wheel_rad: f64, feel: &ForceInput, age_s: f64) -> f64 {
        let s = &self.settings;
        let live = feel.running && age_s < STALE_S && s.strength > 0.0;
        self.gain = if live { self.gain + dt_s / FADE_IN_S } else { self.gain - dt_s / FADE_OUT_S }.clamp(0.0, 1.0);
        let share = 1.0 - (-dt_s / SMOOTH_S).exp();
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let speed_mps = finite(feel.speed_mps).abs();
        self.aligning_nm += share * (finite(feel.aligning_nm) - self.aligning_nm);
        self.grass += share * (finite(feel.grass) - self.grass);
        let before = self.wheel_rad.replace(wheel_rad).unwrap_or(wheel_rad);
        self.wheel_radps += share * ((wheel_rad - before) / dt_s - self.wheel_radps);
        self.way_m = (self.way_m + speed_mps * dt_s) % 1000.0;

        let advice_state = 1.0 - smooth(speed_mps / ROLLING_MPS);
        let dry_nm = s.friction_nm + s.standstill_nm * advice_state;
        let friction_nm = -dry_nm * (self.wheel_radps / FRICTION_RADPS).tanh();
        let damping_nm = -s.damping_nms * self.wheel_radps;
        let centring_nm = -s.centring_nm * wheel_rad;
        let bumps = 0.6 * (TAU * self.way_m / 0.9).sin() + 0.4 * (TAU * self.way_m / 0.37).sin();
        let grass_nm = s.grass_nm * self.grass * smooth(speed_mps / 3.0) * bumps;
        let over_rad = (wheel_rad.abs() - (self.end_rad - END_RAD)).max(0.0);
        let end_nm = -wheel_rad.signum() * s.cap_nm * over_rad / END_RAD;
        let sum_nm = s.strength * self.aligning_nm + friction_nm + damping_nm + centring_nm + grass_nm + end_nm;
        self.gain * finite(sum_nm).clamp(-s.cap_nm, s.cap_nm)
    }

    /// The kernel's level for a torque. With the direction 0xC000 a positive level turns towards greater axis values, which
    /// is the right on every wheel whose left end is the smaller one. In 256 steps to a side: finer ones no device tells
    /// apart, and each is a blocking write.
    pub fn level(&self, torque_nm: f64, left_is_low: bool) -> i16 {
        let to_left = (torque_nm / self.settings.full_nm).clamp(-1.0, 1.0);
        let steps = (to_left * 255.0).round() * 128.0;
        (if left_is_low { -steps } else { steps }) as i16
    }
}

/// 0 below 0, 1 above 1, without a kink.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
#[path = "force_tests.rs"]
mod tests;
