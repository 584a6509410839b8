//! Calibration of a steering wheel by questions. In: raw values of its axes with their times, seconds. Out: what to ask
//! next, bars of all axes, and in the end a [`WheelProfile`]. Every answer is given with wheel and pedals alone: turn or
//! press, hold for a moment.

use super::{
    profile::{Pedal, ProfileError, Steering, WheelProfile},
    profiles::{self, UnprofiledDevice},
};
use std::collections::BTreeMap;

/// How long an answer is held, seconds.
pub const HOLD_S: f64 = 0.8;
/// Hands and feet off at the start, seconds.
pub const REST_S: f64 = 2.0;
/// Share of an axis's range within which it stands still.
const STILL: f64 = 0.01;
/// Share of the range that an axis has to move for an answer.
const ANSWER: f64 = 0.25;
/// Share of the way from rest to floor below which a pedal is up again.
const UP: f64 = 0.15;
/// Share of the range around the middle of both ends in which straight ahead may lie.
const STRAIGHT: f64 = 0.15;
/// Codes from here on are hats.
const FIRST_HAT: u16 = 16;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CalibrationStep {
    /// Something moves: its driver has not read the wheel yet.
    Wake,
    /// Nobody touches anything.
    Rest,
    /// Full left.
    Left,
    /// Full right.
    Right,
    /// Straight ahead.
    Straight,
    /// Accelerator to the floor.
    Accelerator,
    /// And up again.
    AcceleratorUp,
    /// Brake to the floor.
    Brake,
    /// And up again.
    BrakeUp,
    /// All is known.
    Done,
}

impl CalibrationStep {
    /// The question, as a sentence.
    pub fn question(self) -> &'static str {
        match self {
            Self::Wake => "Turn the wheel a little: it has not told yet where it stands.",
            Self::Rest => "Wheel straight, hands and feet off.",
            Self::Left => "Turn the wheel fully to the left and hold it there.",
            Self::Right => "Turn the wheel fully to the right and hold it there.",
            Self::Straight => "Bring the wheel back to straight ahead and hold it.",
            Self::Accelerator => "Press the accelerator to the floor and hold it.",
            Self::AcceleratorUp => "Let the accelerator go.",
            Self::Brake => "Press the brake as hard as for an emergency stop and hold it.",
            Self::BrakeUp => "Let the brake go.",
            Self::Done => "Thank you.",
        }
    }
}

/// One axis under observation.
#[derive(Clone, Copy, Debug)]
struct ObservedAxis {
    range: [i32; 2],
    raw: i32,
    rest: i32,
    /// Smallest and largest value at rest.
    noise: [i32; 2],
    /// Value around which it stands still, and since when.
    anchor: i32,
    since_s: f64,
}

impl ObservedAxis {
    fn span(&self) -> f64 {
        (f64::from(self.range[1]) - f64::from(self.range[0])).max(1.0)
    }

    /// Way from rest, as a share of the range, with its sign.
    fn way(&self) -> f64 {
        (f64::from(self.raw) - f64::from(self.rest)) / self.span()
    }

    fn still(&self, now_s: f64) -> bool {
        now_s - self.since_s >= HOLD_S
    }
}

/// The questions and what was learnt.
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
    /// Begins with a device and its values of this moment.
    ///
    /// # Errors
    /// It has less than two axes.
    pub fn new(device: UnprofiledDevice, now_s: f64) -> Result<Self, ProfileError> {
        let axes: BTreeMap<u16, ObservedAxis> = device
            .axes
            .iter()
            .filter(|(code, range)| **code < FIRST_HAT && range[0] < range[1])
            .map(|(code, range)| {
                let raw = device.values.get(code).copied().unwrap_or(range[0]);
                (*code, ObservedAxis { range: *range, raw, rest: raw, noise: [raw; 2], anchor: raw, since_s: now_s })
            })
            .collect();
        if axes.len() < 2 {
            let text = format!("{} has less than two axes\n  remedy: a wheel with pedals of its own", device.name);
            return Err(ProfileError(text));
        }
        // A USB wheel is read when it reports, which it does when something moves. Until then its driver says 0 of every axis,
        // and pedals that rest at 255 would seem to be pressed by the first turn of the wheel.
        let unread = device.values.values().all(|raw| *raw == 0);
        let step = if unread { CalibrationStep::Wake } else { CalibrationStep::Rest };
        let (steering, ends, centre, pedals) = (None, [0; 2], 0, Vec::new());
        Ok(Self { device, axes, step, began_s: now_s, now_s, steering, ends, centre, pedals })
    }

    /// What is asked now.
    pub fn step(&self) -> CalibrationStep {
        self.step
    }

    /// An axis moved.
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

    /// Time has passed.
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
            CalibrationStep::Accelerator | CalibrationStep::Brake => self.pressed().map(|pedal| {
                self.pedals.push(pedal);
                if self.step == CalibrationStep::Brake {
                    CalibrationStep::BrakeUp
                } else {
                    CalibrationStep::AcceleratorUp
                }
            }),
            CalibrationStep::AcceleratorUp => {
                let pedals_left = self.axes.len() != 2;
                self.released().then_some(if pedals_left { CalibrationStep::Brake } else { CalibrationStep::Done })
            }
            CalibrationStep::BrakeUp => self.released().then_some(CalibrationStep::Done),
            CalibrationStep::Done => None,
        };
        if let Some(next) = next {
            self.step = next;
            self.began_s = self.now_s;
        }
    }

    /// Nothing has moved since the start; what moves begins the rest again.
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

    /// The axis that moved most and stands still now.
    fn turned(&self) -> Option<(u16, i32)> {
        let free = |code: &u16| Some(*code) != self.steering && self.pedals.iter().all(|(taken, _)| taken != code);
        let most =
            self.axes.iter().filter(|(code, _)| free(code)).max_by(|a, b| a.1.way().abs().total_cmp(&b.1.way().abs()));
        most.filter(|(_, axis)| axis.way().abs() >= ANSWER && axis.still(self.now_s))
            .map(|(code, axis)| (*code, axis.raw))
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

    fn pressed(&self) -> Option<(u16, i32)> {
        self.turned()
    }

    fn released(&self) -> bool {
        let Some((code, pressed)) = self.pedals.last() else { return false };
        let axis = self.axes[code];
        axis.way().abs() < UP * (f64::from(*pressed) - f64::from(axis.rest)).abs() / axis.span()
    }

    /// All axes as bars: code, name, and how far it is from its rest, of the steering from its lower end: shares of its range.
    pub fn bars(&self) -> Vec<(u16, String, f64)> {
        let name = |code: u16| match self.pedals.iter().position(|(taken, _)| *taken == code) {
            _ if self.steering == Some(code) => "steering".into(),
            Some(0) => "accelerator".into(),
            Some(_) => "brake".into(),
            None => format!("axis {code}"),
        };
        let share = |code: u16, axis: &ObservedAxis| {
            let from_low = (f64::from(axis.raw) - f64::from(axis.range[0])) / axis.span();
            if self.steering == Some(code) { from_low } else { axis.way().abs() }
        };
        self.axes.iter().map(|(code, axis)| (*code, name(*code), share(*code, axis))).collect()
    }

    /// What was learnt, under this name; buttons and force as for the shipped profile of the same product, if there is one.
    ///
    /// # Errors
    /// Not everything was answered.
    pub fn profile(&self, name: &str) -> Result<WheelProfile, ProfileError> {
        let steering = self.steering.filter(|_| self.step == CalibrationStep::Done).ok_or_else(|| {
            ProfileError(format!("not everything was answered: {}\n  remedy: begin again", self.step.question()))
        })?;
        let (vendor, product) = self.device.id;
        let like = profiles::shipped().find(|profile| profile.is_for(vendor, product));
        let curve =
            |of: fn(&WheelProfile) -> Option<f64>, otherwise: f64| like.as_ref().and_then(of).unwrap_or(otherwise);
        let curves = [curve(|p| Some(p.accelerator.curve), 1.0), curve(|p| Some(p.brake.as_ref()?.curve), 1.6)];
        let mut pedals = self.pedals.iter().zip(curves).map(|((code, pressed), curve)| {
            let axis = &self.axes[code];
            let way = (f64::from(*pressed) - f64::from(axis.rest)).abs();
            let noise = (f64::from(axis.noise[1]) - f64::from(axis.noise[0])) / way;
            // Twice the noise at rest, and the floor a little before where it was held.
            let dead = (2.0 * noise).clamp(0.02, 0.2);
            Pedal { axis: *code, released: axis.rest, pressed: *pressed, dead: round(dead), end: 0.03, curve }
        });
        let accelerator = pedals.next().ok_or_else(|| ProfileError("no pedal was pressed".into()))?;
        let brake = pedals.next();
        drop(pedals);
        let noise = self.axes[&steering].noise;
        let half = (f64::from(self.ends[1]) - f64::from(self.ends[0])).abs() / 2.0;
        let profile = WheelProfile {
            name: name.into(),
            products: vec![format!("{vendor:04x}:{product:04x}")],
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
            buttons: like.as_ref().map(|p| p.buttons.clone()).unwrap_or_default(),
            force: like.map(|p| p.force).unwrap_or_default(),
        };
        // The way through its own file: what is saved can be read.
        WheelProfile::from_toml(&profile.to_toml(), name)
    }
}

fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
#[path = "calibrate_tests.rs"]
mod tests;
