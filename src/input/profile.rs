//! Profile of a steering wheel: axes, buttons, force. In: a TOML text. Out: a checked [`WheelProfile`]: which axis is which,
//! raw ends, dead zones, curves, the wheel's turn, buttons, strength of the force. Axis and button numbers are evdev's; raw
//! values are the device's own.

use super::buttons::Buttons;
use crate::{
    controls::{STEERING_LOCK_RAD, STEERING_RATIO},
    toml_text::{self, KeyPart},
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A mistake in a profile; the message is complete.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct ProfileError(pub String);

/// Everything about one wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelProfile {
    /// What people call it.
    pub name: String,
    /// Devices that it is for, as `vendor:product` in hexadecimal.
    #[serde(default)]
    pub products: Vec<String>,
    /// The wheel.
    pub steering: Steering,
    /// The right pedal.
    pub accelerator: Pedal,
    /// The middle pedal, or the left of two.
    pub brake: Option<Pedal>,
    /// What buttons do.
    #[serde(default)]
    pub buttons: Buttons,
    /// How strongly the wheel answers.
    #[serde(default)]
    pub force: ForceSettings,
}

/// The steering axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Steering {
    /// evdev code of the axis.
    pub axis: u16,
    /// Raw value at the left end.
    pub left: i32,
    /// Raw value straight ahead.
    pub centre: i32,
    /// Raw value at the right end.
    pub right: i32,
    /// The wheel's turn from end to end, degrees.
    #[serde(default = "full_turn")]
    pub range_deg: f64,
    /// Steering wheel angle per road wheel angle.
    #[serde(default = "ratio")]
    pub ratio: f64,
    /// Raw values on either side of the centre that count as straight ahead, as a share of the half range.
    #[serde(default)]
    pub dead: f64,
}

/// A pedal's axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pedal {
    /// evdev code of the axis.
    pub axis: u16,
    /// Raw value with no foot on it.
    pub released: i32,
    /// Raw value at the floor.
    pub pressed: i32,
    /// Share of the way at the top that does nothing.
    #[serde(default = "pedal_dead")]
    pub dead: f64,
    /// Share of the way at the floor that is full already.
    #[serde(default = "pedal_dead")]
    pub end: f64,
    /// Exponent from way to effect: 1 straight, more is gentler at first.
    #[serde(default = "straight")]
    pub curve: f64,
}

/// What carries the force to the wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ForceBackend {
    /// The system's own: evdev on Linux, SDL2 elsewhere.
    #[default]
    System,
    /// SDL2, opened at run time.
    Sdl,
}

/// The force of a wheel, N m at its rim's axle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ForceSettings {
    /// Share of the car's self-aligning torque that the wheel gives back; 0 switches all force off.
    pub strength: f64,
    /// The most that is ever sent, N m.
    pub cap_nm: f64,
    /// Torque of the device at its full level, N m.
    pub full_nm: f64,
    /// Dry friction of the steering, N m.
    pub friction_nm: f64,
    /// The friction that a standing tyre adds, N m.
    pub standstill_nm: f64,
    /// Damping, N m per rad/s.
    pub damping_nms: f64,
    /// Centring of the program's own, N m per rad; a car has none.
    pub centring_nm: f64,
    /// Shaking on grass, N m.
    pub grass_nm: f64,
    /// Share of the device's own centring spring that is left on at the end; the mainline driver begins with 0.
    pub autocentre_after: f64,
    /// What carries it.
    pub backend: ForceBackend,
    /// True for a wheel whose driver turns to the other side: a wheel that pulls away from the middle.
    pub invert: bool,
}

impl Default for ForceSettings {
    fn default() -> Self {
        Self {
            strength: 0.35,
            cap_nm: 1.8,
            full_nm: 2.1,
            friction_nm: 0.08,
            standstill_nm: 0.35,
            damping_nms: 0.06,
            centring_nm: 0.0,
            grass_nm: 0.25,
            autocentre_after: 0.0,
            backend: ForceBackend::System,
            invert: false,
        }
    }
}

fn full_turn() -> f64 {
    900.0
}

fn ratio() -> f64 {
    STEERING_RATIO.into()
}

fn pedal_dead() -> f64 {
    0.02
}

fn straight() -> f64 {
    1.0
}

impl Steering {
    /// Angle of the wheel itself for a raw value, radians, positive to the left; beyond the ends it goes on.
    pub fn wheel_rad(&self, raw: i32) -> f64 {
        let end = if (raw >= self.centre) == (self.right >= self.centre) { self.right } else { self.left };
        let share = share(raw, self.centre, end);
        let live = ((share - self.dead) / (1.0 - self.dead)).max(0.0);
        let side = if end == self.left { 1.0 } else { -1.0 };
        side * live * (self.range_deg / 2.0).to_radians()
    }

    /// What the car's steering wheel does for a raw value, radians: the wheel's own angle, through this profile's ratio
    /// instead of the car's.
    pub fn car_rad(&self, raw: i32) -> f32 {
        let angle = self.wheel_rad(raw) * f64::from(STEERING_RATIO) / self.ratio;
        (angle as f32).clamp(-STEERING_LOCK_RAD, STEERING_LOCK_RAD)
    }
}

impl Pedal {
    /// Way of the pedal for a raw value, 0 released to 1 at the floor.
    pub fn way(&self, raw: i32) -> f64 {
        // Without the sign that a zero has where the axis falls: it would be shown.
        share(raw, self.released, self.pressed).clamp(0.0, 1.0) + 0.0
    }

    /// Its effect, 0 to 1: exactly 0 at rest and exactly 1 at the floor.
    pub fn effect(&self, raw: i32) -> f32 {
        let live = ((self.way(raw) - self.dead) / (1.0 - self.dead - self.end)).clamp(0.0, 1.0);
        live.powf(self.curve) as f32
    }
}

/// Where `raw` stands between two values, 0 at `from` and 1 at `to`.
fn share(raw: i32, from: i32, to: i32) -> f64 {
    (f64::from(raw) - f64::from(from)) / (f64::from(to) - f64::from(from))
}

/// Smallest and largest raw value of each axis of a device.
pub type AxisRanges = BTreeMap<u16, [i32; 2]>;

impl WheelProfile {
    /// Reads a profile; `file` is what messages call it.
    ///
    /// # Errors
    /// The text is no profile, or a value is not allowed: file, line, value and remedy.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ProfileError> {
        let profile: Self = toml_text::parse(text, file).map_err(|e| ProfileError(e.to_string()))?;
        profile.check().map_err(|(key, message)| {
            ProfileError(toml_text::at(text, file, &key, KeyPart::Value, &format!("{key}: {message}")))
        })?;
        Ok(profile)
    }

    /// The profile as a file that [`WheelProfile::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// True if it is for this device.
    pub fn is_for(&self, vendor: u16, product: u16) -> bool {
        self.products.iter().any(|id| id.eq_ignore_ascii_case(&format!("{vendor:04x}:{product:04x}")))
    }

    /// All pedals.
    pub fn pedals(&self) -> impl Iterator<Item = (&'static str, &Pedal)> {
        [("accelerator", Some(&self.accelerator)), ("brake", self.brake.as_ref())]
            .into_iter()
            .filter_map(|(name, pedal)| Some((name, pedal?)))
    }

    /// A guess for a wheel that nobody has described: the first axis steers, the next two that are no hat are
    /// accelerator and brake; each pedal rests where it is nearer to an end now.
    ///
    /// # Errors
    /// The device has less than two axes.
    pub fn generic(name: &str, axes: &AxisRanges, now: &BTreeMap<u16, i32>) -> Result<Self, ProfileError> {
        /// Codes from here on are hats.
        const FIRST_HAT: u16 = 16;
        let mut usable = axes.iter().filter(|(code, range)| **code < FIRST_HAT && range[0] < range[1]);
        let too_few = || {
            ProfileError(format!("{name} has less than two axes\n  remedy: a wheel with pedals of its own, or a pad"))
        };
        let (steering, [left, right]) = usable.next().ok_or_else(too_few)?;
        let mut pedals: Vec<Pedal> = usable
            .map(|(axis, [low, high])| {
                let raw = now.get(axis).copied().unwrap_or(*high);
                let rests_high = i64::from(*high) - i64::from(raw) <= i64::from(raw) - i64::from(*low);
                let (released, pressed) = if rests_high { (*high, *low) } else { (*low, *high) };
                Pedal { axis: *axis, released, pressed, dead: 0.05, end: 0.02, curve: 1.0 }
            })
            .collect();
        if pedals.is_empty() {
            return Err(too_few());
        }
        let accelerator = pedals.remove(0);
        let centre = ((i64::from(*left) + i64::from(*right)) / 2) as i32;
        let (left, right) = (*left, *right);
        Ok(Self {
            name: name.into(),
            products: Vec::new(),
            steering: Steering { axis: *steering, left, centre, right, range_deg: 900.0, ratio: ratio(), dead: 0.0 },
            accelerator,
            brake: (!pedals.is_empty()).then(|| pedals.remove(0)),
            buttons: Buttons::default(),
            force: ForceSettings::default(),
        })
    }

    /// That the device has every axis of the profile.
    ///
    /// # Errors
    /// One is missing: which, and what there is.
    pub fn fits(&self, axes: &AxisRanges) -> Result<(), ProfileError> {
        let mut wanted = vec![("steering", self.steering.axis)];
        wanted.extend(self.pedals().map(|(name, pedal)| (name, pedal.axis)));
        let Some((what, axis)) = wanted.into_iter().find(|(_, axis)| !axes.contains_key(axis)) else { return Ok(()) };
        let there = axes.keys().map(u16::to_string).collect::<Vec<_>>().join(", ");
        Err(ProfileError(format!(
            "profile \"{}\": {what} is axis {axis}, which the device does not have (it has {there})\n  remedy: codrive \
             calibrate learns its axes; a wheel with a switch for another console may stand at the wrong one",
            self.name
        )))
    }

    fn check(&self) -> Result<(), (String, String)> {
        let wrong = |key: &str, text: String| Err((key.to_owned(), text));
        let s = &self.steering;
        if !((s.left < s.centre && s.centre < s.right) || (s.left > s.centre && s.centre > s.right)) {
            let text = format!("{} is not between left ({}) and right ({})", s.centre, s.left, s.right);
            return wrong("steering.centre", format!("{text}\n  remedy: codrive calibrate measures all three"));
        }
        let within = |key: &str, value: f64, low: f64, high: f64| {
            let fine = (low..=high).contains(&value);
            if fine { Ok(()) } else { wrong(key, format!("{value} is not allowed; allowed: {low} to {high}")) }
        };
        within("steering.range_deg", s.range_deg, 90.0, 2520.0)?;
        within("steering.ratio", s.ratio, 5.0, 40.0)?;
        within("steering.dead", s.dead, 0.0, 0.2)?;
        let mut taken = vec![s.axis];
        for (name, pedal) in self.pedals() {
            if pedal.released == pedal.pressed {
                let text = format!("{} is also the released value\n  remedy: codrive calibrate", pedal.pressed);
                return wrong(&format!("{name}.pressed"), text);
            }
            if taken.contains(&pedal.axis) {
                let text = format!("{} has another task already; allowed: an axis of its own", pedal.axis);
                return wrong(&format!("{name}.axis"), text);
            }
            taken.push(pedal.axis);
            within(&format!("{name}.dead"), pedal.dead, 0.0, 0.4)?;
            within(&format!("{name}.end"), pedal.end, 0.0, 0.4)?;
            within(&format!("{name}.curve"), pedal.curve, 0.3, 4.0)?;
        }
        let f = &self.force;
        within("force.strength", f.strength, 0.0, 2.0)?;
        within("force.full_nm", f.full_nm, 0.1, 30.0)?;
        within("force.cap_nm", f.cap_nm, 0.0, f.full_nm)?;
        for (key, value, most) in [
            ("force.friction_nm", f.friction_nm, 1.0),
            ("force.standstill_nm", f.standstill_nm, 2.0),
            ("force.damping_nms", f.damping_nms, 0.5),
            ("force.centring_nm", f.centring_nm, 2.0),
            ("force.grass_nm", f.grass_nm, 1.0),
            ("force.autocentre_after", f.autocentre_after, 1.0),
        ] {
            within(key, value, 0.0, most)?;
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "profile_tests.rs"]
mod tests;
