//! Force-feedback model. In: the wheel's angle, the state of the ego ([`ForceInput`]), settings of the profile. Out: a
//! torque, N m, positive to the left, and the kernel's level for it.
//!
//! The torque is the ego's self-aligning torque, dry friction (more at a standstill), damping, optional centring,
//! vibration on grass, the jolt of a contact, pulses of events and soft end stops. While an automation steers, its controller (`hold`) is in
//! place of the first four. The torque is capped, and faded in and out. The filters have a time constant of [`SMOOTH_S`].

use super::{hand_torque::HandTorque, hold::WheelHold, profile::ForceSettings};
use std::f64::consts::TAU;

/// Time constant of the filters for the drive loop's inputs, which change once a tick, and for the wheel's speed, s.
pub const SMOOTH_S: f64 = 0.010;
/// Age of the drive loop's last input at which the force begins to fade out, s.
pub const STALE_S: f64 = 0.060;
/// Fade-out time, s: four periods of the thread. The first of them detects the stall, so the force is zero at most 84
/// ms after the last input. With the timers of the wheel's own driver (up to 8 ms, see `tests/wheel/usb.rs`) that is
/// less than 100 ms.
const FADE_OUT_S: f64 = 0.024;
/// Fade-in time, s, so that the force does not surprise the driver.
const FADE_IN_S: f64 = 0.4;
/// Wheel speed at which dry friction is nearly full, rad/s: a steeper rise would buzz with the delay of the device.
const FRICTION_RADPS: f64 = 1.0;
/// Speed from which the tyres add no standstill friction, m/s.
const ROLLING_MPS: f64 = 2.0;
/// Angle over which the torque of a soft end stop rises to the cap, rad.
const END_RAD: f64 = 0.2;

/// Amplitude, N m, and frequency, Hz, of the jolt of the hardest contact.
const CONTACT_NM: f64 = 0.8;
const CONTACT_HZ: f64 = 14.0;
/// Amplitude, N m, and frequency, Hz, of the strongest pulse of an event: six turns of the force thread for each period.
const PULSE_NM: f64 = 1.0;
const PULSE_HZ: f64 = 25.0;

/// State of the ego from which the force is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceInput {
    /// Self-aligning torque at the steering wheel, N m; positive turns it to the left.
    pub aligning_nm: f64,
    pub speed_mps: f64,
    /// Share of the front wheels on grass, 0 to 1.
    pub grass: f64,
    /// Strength of a contact that has just happened, 0 (none) to 1.
    pub contact: f64,
    /// Strength of a pulse of an event, 0 (none) to 1.
    pub pulse: f64,
    /// Angle of the steering wheel at which an automation holds the wheel, rad; `None` while the participant steers.
    pub held_rad: Option<f64>,
    /// True while simulation time runs.
    pub running: bool,
}

/// Force model of one wheel, with the state of its filters.
#[derive(Clone, Debug)]
pub struct ForceModel {
    settings: ForceSettings,
    end_rad: f64,
    aligning_nm: f64,
    grass: f64,
    contact: Vibration,
    pulse: Vibration,
    hold: WheelHold,
    hands: HandTorque,
    /// Torque of the previous step, N m.
    sent_nm: f64,
    wheel_radps: f64,
    wheel_rad: Option<f64>,
    way_m: f64,
    gain: f64,
}

impl ForceModel {
    /// Creates the model of a wheel that turns by `end_rad` to either side.
    pub fn new(settings: &ForceSettings, end_rad: f64) -> Self {
        Self {
            settings: settings.clone(),
            end_rad,
            aligning_nm: 0.0,
            grass: 0.0,
            contact: Vibration::default(),
            pulse: Vibration::default(),
            hold: WheelHold::default(),
            hands: HandTorque::default(),
            sent_nm: 0.0,
            wheel_radps: 0.0,
            wheel_rad: None,
            way_m: 0.0,
            gain: 0.0,
        }
    }

    /// Returns the torque `dt_s` after the previous step, N m, positive to the left. `age_s` is the age of `force_input`, whose angle is
    /// one of this wheel.
    pub fn step(&mut self, dt_s: f64, wheel_rad: f64, force_input: &ForceInput, age_s: f64) -> f64 {
        let s = &self.settings;
        let live = force_input.running && age_s < STALE_S && s.strength > 0.0;
        self.gain = if live { self.gain + dt_s / FADE_IN_S } else { self.gain - dt_s / FADE_OUT_S }.clamp(0.0, 1.0);
        let share = 1.0 - (-dt_s / SMOOTH_S).exp();
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        let speed_mps = finite(force_input.speed_mps).abs();
        self.aligning_nm += share * (finite(force_input.aligning_nm) - self.aligning_nm);
        self.grass += share * (finite(force_input.grass) - self.grass);
        let contact_nm = CONTACT_NM * self.contact.step(finite(force_input.contact), share, dt_s, CONTACT_HZ);
        let pulse_nm = PULSE_NM * self.pulse.step(finite(force_input.pulse), share, dt_s, PULSE_HZ);
        let before = self.wheel_rad.replace(wheel_rad).unwrap_or(wheel_rad);
        self.wheel_radps += share * ((wheel_rad - before) / dt_s - self.wheel_radps);
        self.hands.step(dt_s, share, self.sent_nm, self.wheel_radps);
        self.way_m = (self.way_m + speed_mps * dt_s) % 1000.0;

        let standstill_share = 1.0 - smooth(speed_mps / ROLLING_MPS);
        let dry_nm = s.friction_nm + s.standstill_nm * standstill_share;
        let friction_nm = -dry_nm * (self.wheel_radps / FRICTION_RADPS).tanh();
        let damping_nm = -s.damping_nms * self.wheel_radps;
        let centring_nm = -s.centring_nm * wheel_rad;
        let bumps = 0.6 * (TAU * self.way_m / 0.9).sin() + 0.4 * (TAU * self.way_m / 0.37).sin();
        let grass_nm = s.grass_nm * self.grass * smooth(speed_mps / 3.0) * bumps;
        let free_rad = self.end_rad - END_RAD;
        let over_rad = (wheel_rad.abs() - free_rad).max(0.0);
        let end_nm = -wheel_rad.signum() * s.cap_nm * over_rad / END_RAD;
        let steered_nm = s.strength * self.aligning_nm + friction_nm + damping_nm + centring_nm;
        let held_rad = force_input.held_rad.filter(|rad| rad.is_finite()).map(|rad| rad.clamp(-free_rad, free_rad));
        let (held_nm, held_share) = self.hold.step(dt_s, held_rad, wheel_rad, self.wheel_radps);
        let turning_nm = steered_nm + held_share * (held_nm - steered_nm);
        let sum_nm = turning_nm + grass_nm + contact_nm + pulse_nm + end_nm;
        self.sent_nm = self.gain * finite(sum_nm).clamp(-s.cap_nm, s.cap_nm);
        self.sent_nm
    }

    /// Returns the estimated torque of the hands at the last step, N m, positive to the left.
    pub fn hand_torque_nm(&self) -> f64 {
        self.hands.torque_nm()
    }

    /// Returns the kernel's level for a torque. With direction 0xC000 a positive level turns towards greater axis
    /// values, which is to the right if the left end has the smaller value. A side has 255 steps: devices cannot
    /// resolve finer ones, and each change is a blocking write.
    pub fn level(&self, torque_nm: f64, left_is_low: bool) -> i16 {
        let to_left = (torque_nm / self.settings.full_nm).clamp(-1.0, 1.0);
        let steps = (to_left * 255.0).round() * 128.0;
        (if left_is_low { -steps } else { steps }) as i16
    }
}

/// Vibration of the wheel with its filtered strength.
#[derive(Clone, Copy, Debug, Default)]
struct Vibration {
    strength: f64,
    /// Time since its begin, s; 0 without one.
    since_s: f64,
}

impl Vibration {
    /// Returns the deflection `dt_s` after the previous step, -1 to 1, where the strength goes this share of the way to a new one.
    fn step(&mut self, strength: f64, share: f64, dt_s: f64, frequency_hz: f64) -> f64 {
        self.strength += share * (strength.clamp(0.0, 1.0) - self.strength);
        self.since_s = if self.strength > 1e-3 { self.since_s + dt_s } else { 0.0 };
        self.strength * (TAU * frequency_hz * self.since_s).sin()
    }
}

/// Smoothstep: 0 below 0, 1 above 1, with a continuous slope.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
#[path = "force_tests.rs"]
mod tests;
