//! Calibration of a steering wheel by prompts. In: raw values of its axes with their times, seconds. Out: the next
//! prompt, bars of all axes, and finally a [`WheelProfile`]. The person responds with wheel and pedals only: turn or
//! press, and hold for a moment.

use super::{
    parts::{self, PART},
    profile::{Pedal, ProfileError, Steering, WheelProfile},
    profiles::{self, UnprofiledDevice},
};
use std::collections::BTreeMap;

/// Time for which a response is held, s.
pub const HOLD_S: f64 = 0.8;
/// Time without touch at the start, s.
pub const REST_S: f64 = 2.0;
/// Share of an axis's range within which the axis counts as still.
const STILL: f64 = 0.01;
/// Share of the range by which an axis must move for a response.
const ANSWER: f64 = 0.25;
/// Share of the travel from rest to floor below which a pedal counts as released.
const UP: f64 = 0.15;
/// Share of the range, around the mean of both ends, in which straight ahead may lie.
const STRAIGHT: f64 = 0.15;
/// Share of the range beside a pedal's rest from which the axis may also be the brake: a combined axis rests near its
/// middle.
const SHARED: f64 = 0.35;
/// First evdev code of the hats.
const FIRST_HAT: u16 = 16;

/// Step of the calibration, with its prompt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CalibrationStep {
    /// Any movement, because the driver has not read the wheel yet.
    Wake,
    /// Hands and feet off the wheel and the pedals.
    Rest,
    /// Wheel held fully to the left.
    Left,
    /// Wheel held fully to the right.
    Right,
    /// Wheel held straight ahead.
    Straight,
    /// Accelerator held at the floor.
    Accelerator,
    /// Accelerator released after the press.
    AcceleratorUp,
    /// Brake held at the floor.
    Brake,
    /// Brake released after the press.
    BrakeUp,
    /// Handbrake held at its end, if a further device of the rig has no task yet; the accelerator says that there is none.
    Handbrake,
    /// Handbrake released after the pull.
    HandbrakeUp,
    Done,
}

impl CalibrationStep {
    /// Returns the prompt as a sentence.
    pub fn question(self) -> &'static str {
        match self {
            Self::Wake => "Turn the wheel a little: its position is not known yet.",
            Self::Rest => "Press each pedal once. Turn the wheel straight. Take hands and feet off.",
            Self::Left => "Turn the wheel fully to the left and hold it there.",
            Self::Right => "Turn the wheel fully to the right and hold it there.",
            Self::Straight => "Bring the wheel back to straight ahead and hold it.",
            Self::Accelerator => "Press the accelerator to the floor and hold it.",
            Self::AcceleratorUp => "Release the accelerator.",
            Self::Brake => "Press the brake as hard as for an emergency stop and hold it.",
            Self::BrakeUp => "Release the brake.",
            Self::Handbrake => {
                "Pull the handbrake and hold it. Without a handbrake, press the accelerator and hold it."
            }
            Self::HandbrakeUp => "Release the handbrake.",
            Self::Done => "Thank you.",
        }
    }
}

/// State of one axis.
#[derive(Clone, Copy, Debug)]
struct ObservedAxis {
    range: [i32; 2],
    raw: i32,
    rest: i32,
    /// Smallest and largest raw value at rest.
    noise: [i32; 2],
    /// Raw value at the start of the present standstill, and the time of that start.
    anchor: i32,
    since_s: f64,
}

impl ObservedAxis {
    fn span(&self) -> f64 {
        (f64::from(self.range[1]) - f64::from(self.range[0])).max(1.0)
    }

    /// Returns the deviation from rest, as a signed share of the range.
    fn way(&self) -> f64 {
        (f64::from(self.raw) - f64::from(self.rest)) / self.span()
    }

    fn still(&self, now_s: f64) -> bool {
        now_s - self.since_s >= HOLD_S
    }
}

/// Calibration in progress, with the results so far.
#[derive(Clone, Debug)]
pub struct Calibration {
    device: UnprofiledDevice,
    axes: BTreeMap<u16, ObservedAxis>,
    step: CalibrationStep,
    began_s: f64,
    now_s: f64,
    steering: Option<u16>,
    ends: [i32; 2],
    centre: i32,
    pedals: Vec<(u16, i32)>,
}

impl Calibration {
    /// Starts the calibration of a device with its present values.
    ///
    /// # Errors
    /// The device has fewer than two axes.
    pub fn new(device: UnprofiledDevice, now_s: f64) -> Result<Self, ProfileError> {
        let axes: BTreeMap<u16, ObservedAxis> = device
            .axes
            .iter()
            .filter(|(code, range)| **code % PART < FIRST_HAT && range[0] < range[1])
            .map(|(code, range)| {
                let raw = device.values.get(code).copied().unwrap_or(range[0]);
                (*code, ObservedAxis { range: *range, raw, rest: raw, noise: [raw; 2], anchor: raw, since_s: now_s })
            })
            .collect();
        if axes.len() < 2 {
            let text = format!("{} has fewer than two axes\n  remedy: plug its pedals in", device.name);
            return Err(ProfileError(text));
        }
        // The driver reads a USB wheel when it first reports, which takes a movement. Until then the driver gives 0 for
        // every axis, and the first turn of the wheel would seem to press pedals that rest at 255.
        let unread = device.values.values().all(|raw| *raw == 0);
        let step = if unread { CalibrationStep::Wake } else { CalibrationStep::Rest };
        let (steering, ends, centre, pedals) = (None, [0; 2], 0, Vec::new());
        Ok(Self { device, axes, step, began_s: now_s, now_s, steering, ends, centre, pedals })
    }

    /// Returns the present step.
    pub fn step(&self) -> CalibrationStep {
        self.step
    }

    /// Applies a movement of an axis.
    pub fn moved(&mut self, code: u16, raw: i32, at_s: f64) {
        self.time(at_s);
        let Some(axis) = self.axes.get_mut(&code) else { return };
        axis.raw = raw;
        if (f64::from(raw) - f64::from(axis.anchor)).abs() > STILL * axis.span() {
            (axis.anchor, axis.since_s) = (raw, at_s);
        }
        if self.step == CalibrationStep::Wake {
            (self.step, self.began_s) = (CalibrationStep::Rest, self.now_s);
        }
        if self.step == CalibrationStep::Rest {
            axis.noise = [axis.noise[0].min(raw), axis.noise[1].max(raw)];
        }
        self.answer();
    }

    /// Advances the time, s; needed while nothing moves.
    pub fn time(&mut self, now_s: f64) {
        self.now_s = self.now_s.max(now_s);
        self.answer();
    }

    fn answer(&mut self) {
        let next = match self.step {
            CalibrationStep::Wake => None,
            CalibrationStep::Rest => self.rested().then_some(CalibrationStep::Left),
            CalibrationStep::Left => self.turned().map(|(code, raw)| {
                (self.steering, self.ends[0]) = (Some(code), raw);
                CalibrationStep::Right
            }),
            CalibrationStep::Right => self.turned_back().map(|raw| {
                self.ends[1] = raw;
                CalibrationStep::Straight
            }),
            CalibrationStep::Straight => self.straight().map(|raw| {
                self.centre = raw;
                CalibrationStep::Accelerator
            }),
            CalibrationStep::Accelerator => self.press(self.turned(), CalibrationStep::AcceleratorUp),
            CalibrationStep::Brake => self.press(self.turned(), CalibrationStep::BrakeUp),
            CalibrationStep::Handbrake if self.accelerator_says_none() => Some(CalibrationStep::Done),
            CalibrationStep::Handbrake => self.press(self.pulled(), CalibrationStep::HandbrakeUp),
            CalibrationStep::AcceleratorUp => {
                let pedals_left = self.axes.len() != 2 || self.may_be_combined();
                self.released().then_some(if pedals_left { CalibrationStep::Brake } else { CalibrationStep::Done })
            }
            CalibrationStep::BrakeUp => {
                let lever = self.axes.keys().any(|code| self.is_spare(*code));
                self.released().then_some(if lever { CalibrationStep::Handbrake } else { CalibrationStep::Done })
            }
            CalibrationStep::HandbrakeUp => self.released().then_some(CalibrationStep::Done),
            CalibrationStep::Done => None,
        };
        if let Some(next) = next {
            self.step = next;
            self.began_s = self.now_s;
        }
    }

    /// Checks whether nothing has moved for [`REST_S`]; a movement restarts the time.
    fn rested(&mut self) -> bool {
        for axis in self.axes.values_mut() {
            if axis.since_s > self.began_s {
                self.began_s = axis.since_s;
                axis.noise = [axis.raw; 2];
            }
        }
        let rested = self.now_s - self.began_s >= REST_S;
        if rested {
            self.axes.values_mut().for_each(|axis| axis.rest = axis.raw);
        }
        rested
    }

    /// Keeps a pedal that was pressed, and returns the step after it.
    fn press(&mut self, pedal: Option<(u16, i32)>, next: CalibrationStep) -> Option<CalibrationStep> {
        self.pedals.push(pedal?);
        Some(next)
    }

    /// Returns the unassigned axis that moved most, if it moved enough and is still. A pedal's axis is unassigned on the
    /// other side of its rest: a combined axis is accelerator on one side and brake on the other.
    fn turned(&self) -> Option<(u16, i32)> {
        self.moved_most(|code, axis| {
            let other_side = |pressed: i32| axis.way() * (f64::from(pressed) - f64::from(axis.rest)) < 0.0;
            Some(code) != self.steering
                && self.pedals.iter().all(|(taken, pressed)| *taken != code || other_side(*pressed))
        })
    }

    /// Returns the axis of a device without a task that moved most, if it moved enough and is still.
    fn pulled(&self) -> Option<(u16, i32)> {
        self.moved_most(|code, _| self.is_spare(code))
    }

    fn moved_most(&self, is_free: impl Fn(u16, &ObservedAxis) -> bool) -> Option<(u16, i32)> {
        let free = self.axes.iter().filter(|(code, axis)| is_free(**code, axis));
        let most = free.max_by(|a, b| a.1.way().abs().total_cmp(&b.1.way().abs()));
        most.filter(|(_, axis)| axis.way().abs() >= ANSWER && axis.still(self.now_s))
            .map(|(code, axis)| (*code, axis.raw))
    }

    /// Checks whether an axis is on a further device of the rig that has no task yet.
    fn is_spare(&self, code: u16) -> bool {
        let part = code / PART;
        let taken = self.pedals.iter().map(|(code, _)| *code).chain(self.steering);
        part > 0 && taken.into_iter().all(|code| code / PART != part)
    }

    fn accelerator_says_none(&self) -> bool {
        self.pedals.first().is_some_and(|(code, pressed)| {
            let axis = &self.axes[code];
            let way = axis.way() * (f64::from(*pressed) - f64::from(axis.rest)).signum();
            way >= ANSWER && axis.still(self.now_s)
        })
    }

    fn turned_back(&self) -> Option<i32> {
        let axis = self.axes[&self.steering?];
        let left = f64::from(self.ends[0]) - f64::from(axis.rest);
        let opposite = axis.way() * left.signum() <= -ANSWER;
        (opposite && axis.still(self.now_s)).then_some(axis.raw)
    }

    fn straight(&self) -> Option<i32> {
        let axis = self.axes[&self.steering?];
        let middle = (f64::from(self.ends[0]) + f64::from(self.ends[1])) / 2.0;
        let near = (f64::from(axis.raw) - middle).abs() < STRAIGHT * axis.span();
        (near && axis.still(self.now_s)).then_some(axis.raw)
    }

    /// Checks whether the axis of the last pedal has room for another pedal on the other side of its rest.
    fn may_be_combined(&self) -> bool {
        self.pedals.last().is_some_and(|(code, pressed)| {
            let axis = self.axes[code];
            let end = if *pressed > axis.rest { axis.range[0] } else { axis.range[1] };
            (f64::from(end) - f64::from(axis.rest)).abs() / axis.span() >= SHARED
        })
    }

    fn released(&self) -> bool {
        let Some((code, pressed)) = self.pedals.last() else { return false };
        let axis = self.axes[code];
        axis.way().abs() < UP * (f64::from(*pressed) - f64::from(axis.rest)).abs() / axis.span()
    }

    /// Returns all axes as bars: code, name, and share of the range from rest, or from the lower end for the steering
    /// axis.
    pub fn bars(&self) -> Vec<(u16, String, f64)> {
        let name = |code: u16| match self.pedals.iter().position(|(taken, _)| *taken == code) {
            _ if self.steering == Some(code) => "steering".into(),
            Some(0) if self.pedals.iter().skip(1).any(|(taken, _)| *taken == code) => "accelerator, brake".into(),
            Some(0) => "accelerator".into(),
            Some(1) => "brake".into(),
            Some(_) => "handbrake".into(),
            None if code < PART => format!("axis {code}"),
            None => format!("axis {} of device {}", code % PART, code / PART + 1),
        };
        let share = |code: u16, axis: &ObservedAxis| {
            let from_low = (f64::from(axis.raw) - f64::from(axis.range[0])) / axis.span();
            if self.steering == Some(code) { from_low } else { axis.way().abs() }
        };
        self.axes.iter().map(|(code, axis)| (*code, name(*code), share(*code, axis))).collect()
    }

    /// Returns the calibrated profile under this name. Buttons, force, range and pedal curves come from the shipped
    /// profile of the same product, if there is one.
    ///
    /// # Errors
    /// The calibration is incomplete.
    pub fn profile(&self, name: &str) -> Result<WheelProfile, ProfileError> {
        let steering = self.steering.filter(|_| self.step == CalibrationStep::Done).ok_or_else(|| {
            ProfileError(format!("the calibration is not complete: {}\n  remedy: begin again", self.step.question()))
        })?;
        let (vendor, product) = self.device.id;
        let like = profiles::shipped().find(|profile| profile.is_for(vendor, product));
        let curve =
            |of: fn(&WheelProfile) -> Option<f64>, otherwise: f64| like.as_ref().and_then(of).unwrap_or(otherwise);
        let curves = [curve(|p| Some(p.accelerator.curve), 1.0), curve(|p| Some(p.brake.as_ref()?.curve), 1.6), 1.0];
        let mut pedals = self.pedals.iter().zip(curves).map(|((code, pressed), curve)| {
            let axis = &self.axes[code];
            let way = (f64::from(*pressed) - f64::from(axis.rest)).abs();
            let noise = (f64::from(axis.noise[1]) - f64::from(axis.noise[0])) / way;
            // The dead zone is twice the noise at rest; full effect begins a little before the held position.
            let dead = (2.0 * noise).clamp(0.02, 0.2);
            let (dead, released) = (round(dead), axis.rest);
            let device = parts::name(&self.device.parts, code / PART);
            Pedal { axis: code % PART, released, pressed: *pressed, dead, end: 0.03, curve, device, part: 0 }
        });
        let accelerator = pedals.next().ok_or_else(|| ProfileError("no pedal was pressed".into()))?;
        let (brake, handbrake) = (pedals.next(), pedals.next());
        drop(pedals);
        let noise = self.axes[&steering].noise;
        let half = (f64::from(self.ends[1]) - f64::from(self.ends[0])).abs() / 2.0;
        let profile = WheelProfile {
            name: name.into(),
            products: vec![parts::id_text(self.device.id)],
            steering: Steering {
                axis: steering,
                left: self.ends[0],
                centre: self.centre,
                right: self.ends[1],
                range_deg: like.as_ref().map_or(900.0, |p| p.steering.range_deg),
                ratio: f64::from(crate::controls::STEERING_RATIO),
                dead: round((f64::from(noise[1] - noise[0]) / half).min(0.05)),
            },
            accelerator,
            brake,
            handbrake,
            buttons: like.as_ref().map(|p| p.buttons.clone()).unwrap_or_default(),
            force: like.map(|p| p.force).unwrap_or_default(),
        };
        // Passed through its TOML text, so that the saved profile is known to be readable.
        WheelProfile::from_toml(&profile.to_toml(), name)
    }
}

fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
#[path = "calibrate_tests.rs"]
mod tests;
