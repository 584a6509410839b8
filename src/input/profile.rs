//! Profile of a steering wheel: axes, buttons, force. In: a TOML text. Out: a checked [`WheelProfile`]: axis codes, raw
//! end values, dead zones, pedal curves, steering range, buttons, strength of the force. Axis and button codes are
//! evdev's; raw values are the device's own.

use super::{
    buttons::{ButtonAction, Buttons},
    parts::{self, ALLOWED_DEVICE, PART, Part},
};
use crate::{
    controls::{STEERING_LOCK_RAD, STEERING_RATIO},
    toml_text::{self, KeyPart},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Pedal travel, 0 to 1, below which the pedal counts as released; above the rest of it, as floored.
const AT_REST: f64 = 0.15;
/// First evdev code of the hats.
const FIRST_HAT: u16 = 16;

/// Rule for USB ids, for messages.
const ALLOWED_ID: &str = "allowed: VENDOR:PRODUCT in four hexadecimal digits each, such as 046d:c24f";

/// Error in a profile; the message is complete, with the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct ProfileError(pub String);

/// All settings of one wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WheelProfile {
    /// Name shown to people.
    pub name: String,
    /// Devices that the profile is for, as `vendor:product` in hexadecimal.
    #[serde(default)]
    #[schemars(inner(regex(pattern = r"^[0-9a-fA-F]{4}:[0-9a-fA-F]{4}$")))]
    pub products: Vec<String>,
    /// Steering axis of the wheel.
    pub steering: Steering,
    /// Right pedal, also of two.
    pub accelerator: Pedal,
    /// Middle pedal, or the left one of two.
    pub brake: Option<Pedal>,
    /// Lever that brakes as the brake pedal does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub handbrake: Option<Pedal>,
    /// Actions of the buttons.
    #[serde(default)]
    pub buttons: Buttons,
    /// Strength of the force feedback.
    #[serde(default)]
    pub force: ForceSettings,
}

/// Steering axis, from raw values to angles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Rotation from end to end, degrees.
    #[serde(default = "full_turn")]
    #[schemars(range(min = 90.0, max = 2520.0), extend("unit" = "deg"))]
    pub range_deg: f64,
    /// Steering wheel angle per road wheel angle.
    #[serde(default = "ratio")]
    #[schemars(range(min = 5.0, max = 40.0))]
    pub ratio: f64,
    /// Dead zone on either side of the centre, as a share of the half range.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub dead: f64,
}

/// Axis of a pedal, from raw values to the pedal's effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pedal {
    /// Device of the pedal (see `parts`), if it is not the wheel itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// Number of that device in the rig, 0 for the wheel itself; set when the rig is opened.
    #[serde(skip)]
    pub part: u16,
    /// evdev code of the axis.
    pub axis: u16,
    /// Raw value of the released pedal.
    pub released: i32,
    /// Raw value of the pedal at the floor.
    pub pressed: i32,
    /// Share of the travel, from the released end, that has no effect.
    #[serde(default = "pedal_dead")]
    #[schemars(range(min = 0.0, max = 0.4))]
    pub dead: f64,
    /// Share of the travel, up to the floor, that has full effect.
    #[serde(default = "pedal_dead")]
    #[schemars(range(min = 0.0, max = 0.4))]
    pub end: f64,
    /// Exponent from travel to effect: 1 is linear, a larger one is gentler at first.
    #[serde(default = "straight")]
    #[schemars(range(min = 0.3, max = 4.0))]
    pub curve: f64,
}

/// Interface through which the force is sent to the wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ForceBackend {
    /// Interface of the system: evdev on Linux, SDL2 elsewhere.
    #[default]
    System,
    /// SDL2, opened at run time.
    Sdl,
}

/// Force feedback of a wheel. Torques are about the axis of the wheel's rim, N m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ForceSettings {
    /// Share of the ego's self-aligning torque that the wheel reproduces; 0 switches all force off.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub strength: f64,
    /// Largest torque that is sent, N m.
    #[schemars(range(min = 0.0, max = 30.0), extend("unit" = "N m"))]
    pub cap_nm: f64,
    /// Torque of the device at its full level, N m.
    #[schemars(range(min = 0.1, max = 30.0), extend("unit" = "N m"))]
    pub full_nm: f64,
    /// Dry friction of the steering, N m.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "N m"))]
    pub friction_nm: f64,
    /// Friction added at a standstill by the tyres, N m.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "N m"))]
    pub standstill_nm: f64,
    /// Damping, N m per rad/s.
    #[schemars(range(min = 0.0, max = 0.5), extend("unit" = "N m s/rad"))]
    pub damping_nms: f64,
    /// Additional centring spring, N m per rad; a real car has none.
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "N m/rad"))]
    pub centring_nm: f64,
    /// Amplitude of the vibration on grass, N m.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "N m"))]
    pub grass_nm: f64,
    /// Strength of the device's own centring spring after the drive, 0 to 1; the mainline driver starts with 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub autocentre_after: f64,
    /// Interface for the force.
    pub backend: ForceBackend,
    /// Reverses the direction of the force, for a wheel that pulls away from the middle.
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
    /// Returns the angle of the wheel for a raw value, radians, positive to the left; values beyond the ends are
    /// extrapolated.
    pub fn wheel_rad(&self, raw: i32) -> f64 {
        let end = if (raw >= self.centre) == (self.right >= self.centre) { self.right } else { self.left };
        let share = share(raw, self.centre, end);
        let live = ((share - self.dead) / (1.0 - self.dead)).max(0.0);
        let side = if end == self.left { 1.0 } else { -1.0 };
        side * live * (self.range_deg / 2.0).to_radians()
    }

    /// Returns the angle of the ego's steering wheel for a raw value, radians: the wheel's angle, scaled by the ego's
    /// steering ratio over the profile's, and limited to the ego's lock.
    pub fn car_rad(&self, raw: i32) -> f32 {
        let angle = self.wheel_rad(raw) * f64::from(STEERING_RATIO) / self.ratio;
        (angle as f32).clamp(-STEERING_LOCK_RAD, STEERING_LOCK_RAD)
    }
}

impl Pedal {
    /// Returns the code of the axis in the rig: evdev's, plus [`PART`] for each further device.
    pub fn code(&self) -> u16 {
        self.axis + PART * self.part
    }

    /// Returns the travel of the pedal for a raw value, 0 released to 1 at the floor.
    pub fn way(&self, raw: i32) -> f64 {
        // Adding 0 removes the sign of a negative zero, which an axis with falling values yields and which would be
        // displayed.
        share(raw, self.released, self.pressed).clamp(0.0, 1.0) + 0.0
    }

    /// Checks whether the pedal is at its released end.
    pub fn is_released(&self, raw: i32) -> bool {
        self.way(raw) < AT_REST
    }

    /// Checks whether the pedal is at its pressed end.
    pub fn is_floored(&self, raw: i32) -> bool {
        self.way(raw) > 1.0 - AT_REST
    }

    /// Returns the effect of the pedal for a raw value, 0 to 1: exactly 0 when released and exactly 1 at the floor.
    pub fn effect(&self, raw: i32) -> f32 {
        let live = ((self.way(raw) - self.dead) / (1.0 - self.dead - self.end)).clamp(0.0, 1.0);
        live.powf(self.curve) as f32
    }
}

/// Returns the position of `raw` between two values, 0 at `from` and 1 at `to`; not clamped.
fn share(raw: i32, from: i32, to: i32) -> f64 {
    (f64::from(raw) - f64::from(from)) / (f64::from(to) - f64::from(from))
}

/// Smallest and largest raw value of each axis of a device, by evdev code.
pub type AxisRanges = BTreeMap<u16, [i32; 2]>;

impl WheelProfile {
    /// Reads and checks a profile; `file` is the name for messages.
    ///
    /// # Errors
    /// The text is no profile, or a value is not allowed. The message gives file, line, value and remedy of each mistake.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, ProfileError> {
        let (profile, mut mistakes) = toml_text::read::<Self>(text, file);
        if let Some(profile) = &profile {
            profile.check(|key, others, message| {
                mistakes.add_related(key, others, KeyPart::Value, &format!("{key}: {message}"));
            });
        }
        toml_text::finished((profile, mistakes)).map_err(|e| ProfileError(e.to_string()))
    }

    /// Returns the profile as TOML that [`WheelProfile::from_toml`] reads back.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Checks whether the profile lists this device.
    pub fn is_for(&self, vendor: u16, product: u16) -> bool {
        self.products.iter().any(|id| id.eq_ignore_ascii_case(&format!("{vendor:04x}:{product:04x}")))
    }

    /// Returns the pedals for the feet with their names; a missing brake is left out.
    pub fn foot_pedals(&self) -> impl Iterator<Item = (&'static str, &Pedal)> {
        [("accelerator", Some(&self.accelerator)), ("brake", self.brake.as_ref())]
            .into_iter()
            .filter_map(|(name, pedal)| Some((name, pedal?)))
    }

    /// Returns the pedals for the feet, then the handbrake, with their names; those that are missing are left out.
    pub fn pedals(&self) -> impl Iterator<Item = (&'static str, &Pedal)> {
        self.foot_pedals().chain(self.handbrake.as_ref().map(|lever| ("handbrake", lever)))
    }

    /// Checks whether accelerator and brake are the two sides of one axis.
    fn pedals_share_an_axis(&self) -> bool {
        let Some(brake) = &self.brake else { return false };
        let (up, down) = if self.accelerator.pressed > brake.pressed {
            (&self.accelerator, brake)
        } else {
            (brake, &self.accelerator)
        };
        let apart = down.pressed < down.released && down.released <= up.released && up.released < up.pressed;
        let is_free = brake.device.is_some() || brake.axis != self.steering.axis;
        (&brake.device, brake.axis) == (&self.accelerator.device, self.accelerator.axis) && is_free && apart
    }

    /// Checks whether the driver reports the pedals the other way round: every pedal is at its pressed end, and no
    /// further axis of the same range, such as a clutch, is at the released end. Returns false while a value is unknown.
    pub fn pedals_upside_down(&self, axes: &AxisRanges, values: &BTreeMap<u16, i32>) -> bool {
        let own: Vec<u16> = self.foot_pedals().map(|(_, pedal)| pedal.code()).chain([self.steering.axis]).collect();
        let is_read = own.iter().all(|axis| values.contains_key(axis)) && values.values().any(|raw| *raw != 0);
        let floored =
            self.foot_pedals().all(|(_, pedal)| values.get(&pedal.code()).is_some_and(|raw| pedal.is_floored(*raw)));
        let alike = |code: &u16| axes.get(code).is_some_and(|range| Some(range) == axes.get(&self.accelerator.code()));
        let beside = |code: &u16| code / PART == self.accelerator.part && code % PART < FIRST_HAT;
        let further_rests = values
            .iter()
            .filter(|(code, _)| beside(code) && !own.contains(code) && alike(code))
            .any(|(_, raw)| self.accelerator.is_released(*raw));
        is_read && floored && !further_rests
    }

    /// Returns the message for a wheel whose driver reports the pedals the other way round.
    pub fn upside_down_message(&self, device: &str) -> String {
        format!(
            "{device}: without a foot on them, all pedals are where the profile \"{}\" calls them pressed; the wheel's \
             driver turns them round, so they have no effect\n  remedy: if a foot was on them, release them and plug the \
             wheel in again; else measure them with codrive calibrate, or Wheel in the panel (F2)",
            self.name
        )
    }

    /// Guesses a profile for an unknown wheel. The first axis steers; the next two axes that are no hats are
    /// accelerator and brake. Each pedal is released at the end of its range that is nearer to its present value.
    ///
    /// # Errors
    /// The device has fewer than two axes.
    pub fn generic(name: &str, axes: &AxisRanges, now: &BTreeMap<u16, i32>) -> Result<Self, ProfileError> {
        let mut usable = axes.iter().filter(|(code, range)| **code < FIRST_HAT && range[0] < range[1]);
        let too_few = || {
            ProfileError(format!(
                "{name} has fewer than two axes\n  remedy: plug its pedals in; for pedals with a USB cable of their own, codrive \
                 calibrate makes a profile of both"
            ))
        };
        let (steering, [left, right]) = usable.next().ok_or_else(too_few)?;
        let mut pedals: Vec<Pedal> = usable
            .map(|(axis, [low, high])| {
                let raw = now.get(axis).copied().unwrap_or(*high);
                let rests_high = i64::from(*high) - i64::from(raw) <= i64::from(raw) - i64::from(*low);
                let (released, pressed) = if rests_high { (*high, *low) } else { (*low, *high) };
                Pedal { axis: *axis, released, pressed, dead: 0.05, end: 0.02, curve: 1.0, device: None, part: 0 }
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
            handbrake: None,
            buttons: Buttons::default(),
            force: ForceSettings::default(),
        })
    }

    /// Finds the devices of pedals and buttons among the further devices of a rig.
    ///
    /// # Errors
    /// One is not plugged in, or two are alike; the message names it.
    pub fn find_parts(&mut self, parts: &[Part]) -> Result<(), ProfileError> {
        let Self { name: profile, accelerator, brake, handbrake, buttons, .. } = self;
        let find = |what: &str, device: &Option<String>| {
            let Some(device) = device else { return Ok(0) };
            parts::number(parts, device).map_err(|fault| {
                ProfileError(format!("profile \"{profile}\": the device of the {what}, {device}, {fault}"))
            })
        };
        for (name, pedal) in
            [("accelerator", Some(accelerator)), ("brake", brake.as_mut()), ("handbrake", handbrake.as_mut())]
        {
            let Some(pedal) = pedal else { continue };
            pedal.part = find(name, &pedal.device)?;
        }
        for action in ButtonAction::every() {
            for button in buttons.of(action) {
                button.part = find(&format!("button \"{action}\""), &button.device)?;
            }
        }
        Ok(())
    }

    /// Checks whether the devices of the profile are among the further devices of a rig.
    pub fn has_its_parts(&self, parts: &[Part]) -> bool {
        self.clone().find_parts(parts).is_ok()
    }

    /// Checks whether the profile uses an axis or a button of this device of the rig; 0 is the wheel itself.
    pub fn uses_part(&self, part: u16) -> bool {
        let button = |(_, button): (ButtonAction, &super::buttons::RigButton)| button.part == part;
        part == 0 || self.pedals().any(|(_, pedal)| pedal.part == part) || self.buttons.all().any(button)
    }

    /// Checks that the device has every axis of the profile.
    ///
    /// # Errors
    /// An axis is missing; the message names it and lists the device's axes.
    pub fn fits(&self, axes: &AxisRanges) -> Result<(), ProfileError> {
        let mut wanted = vec![("steering", self.steering.axis)];
        wanted.extend(self.pedals().map(|(name, pedal)| (name, pedal.code())));
        let Some((what, axis)) = wanted.into_iter().find(|(_, axis)| !axes.contains_key(axis)) else { return Ok(()) };
        let there = axes.keys().map(u16::to_string).collect::<Vec<_>>().join(", ");
        Err(ProfileError(format!(
            "profile \"{}\": {what} is axis {axis}, which the device does not have (it has {there})\n  remedy: codrive \
             calibrate learns its axes; on a wheel with a switch for consoles, check the switch",
            self.name
        )))
    }

    /// Passes each value that is not allowed to `add`: its key, the keys because of which it is not, and a message.
    fn check(&self, mut add: impl FnMut(&str, &[&str], String)) {
        if let Some(id) = self.products.iter().find(|id| !parts::is_id(id)) {
            add("products", &[], format!("\"{id}\" is no USB id; {ALLOWED_ID}"));
        }
        let s = &self.steering;
        if !((s.left < s.centre && s.centre < s.right) || (s.left > s.centre && s.centre > s.right)) {
            let text = format!("{} is not between left ({}) and right ({})", s.centre, s.left, s.right);
            let others = ["steering.left", "steering.right"];
            add("steering.centre", &others, format!("{text}\n  remedy: codrive calibrate measures all three"));
        }
        let mut taken = vec![(None, s.axis)];
        for (name, pedal) in self.pedals() {
            if let Some(id) = pedal.device.as_ref().filter(|id| !parts::is_device(id)) {
                add(&format!("{name}.device"), &[], format!("\"{id}\" is no USB id; {ALLOWED_DEVICE}"));
            }
            if pedal.released == pedal.pressed {
                let text = format!("{} is also the released value\n  remedy: codrive calibrate", pedal.pressed);
                add(&format!("{name}.pressed"), &[&format!("{name}.released")], text);
            }
            let may_share = name != "handbrake" && self.pedals_share_an_axis();
            if taken.contains(&(pedal.device.as_ref(), pedal.axis)) && !may_share {
                let text = format!(
                    "axis {} already has another task; allowed: an unused axis, or for a combined axis the accelerator's, \
                     pressed to the other side",
                    pedal.axis
                );
                add(&format!("{name}.axis"), &["steering", "accelerator"], text);
            }
            taken.push((pedal.device.as_ref(), pedal.axis));
        }
        let device = |button: &super::buttons::RigButton| button.device.clone().filter(|id| !parts::is_device(id));
        if let Some(id) = self.buttons.all().find_map(|(_, button)| device(button)) {
            add("buttons", &[], format!("\"{id}\" is no USB id; {ALLOWED_DEVICE}"));
        }
        for (key, value, low, high) in self.limited_values() {
            if !(low..=high).contains(&value) {
                let others: &[&str] = if key == "force.cap_nm" { &["force.full_nm"] } else { &[] };
                add(&key, others, format!("{value} is not allowed; allowed: {low} to {high}"));
            }
        }
    }

    /// Returns the values with limits: key, value, lowest and highest allowed value.
    fn limited_values(&self) -> Vec<(String, f64, f64, f64)> {
        let (s, f) = (&self.steering, &self.force);
        let of_pedals = self.pedals().flat_map(|(name, pedal)| {
            let values =
                [("dead", pedal.dead, 0.0, 0.4), ("end", pedal.end, 0.0, 0.4), ("curve", pedal.curve, 0.3, 4.0)];
            values.map(|(key, value, low, high)| (format!("{name}.{key}"), value, low, high))
        });
        let others = [
            ("steering.range_deg", s.range_deg, 90.0, 2520.0),
            ("steering.ratio", s.ratio, 5.0, 40.0),
            ("steering.dead", s.dead, 0.0, 0.2),
            ("force.strength", f.strength, 0.0, 2.0),
            ("force.full_nm", f.full_nm, 0.1, 30.0),
            ("force.cap_nm", f.cap_nm, 0.0, f.full_nm),
            ("force.friction_nm", f.friction_nm, 0.0, 1.0),
            ("force.standstill_nm", f.standstill_nm, 0.0, 2.0),
            ("force.damping_nms", f.damping_nms, 0.0, 0.5),
            ("force.centring_nm", f.centring_nm, 0.0, 2.0),
            ("force.grass_nm", f.grass_nm, 0.0, 1.0),
            ("force.autocentre_after", f.autocentre_after, 0.0, 1.0),
        ];
        others.into_iter().map(|(key, value, low, high)| (key.into(), value, low, high)).chain(of_pedals).collect()
    }
}

#[cfg(test)]
#[path = "profile_tests.rs"]
mod tests;
