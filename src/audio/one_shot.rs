//! Sounds that begin and end: horn, contact, tone, footstep. In: the state of the horn, the strength of a contact, the start of a
//! tone, the number of steps. Out: samples. Each sound has an envelope of its own without corners.

use super::{filtered_noise::FilteredNoise, smoothing::SmoothedValue};
use std::f32::consts::{PI, TAU};

/// The horn: two notes, a major third apart, with few partials.
pub struct Horn {
    rate_hz: f32,
    phases: [f32; 2],
    level: SmoothedValue,
}

impl Horn {
    const NOTES_HZ: [f32; 2] = [392.0, 494.0];
    const PARTIALS: usize = 7;
    const LEVEL: f32 = 0.14;

    /// Creates a silent horn.
    pub fn new(rate_hz: f32) -> Self {
        Self { rate_hz, phases: [0.0; 2], level: SmoothedValue::new(0.0, 0.012, rate_hz) }
    }

    /// Returns the next sample; `held` is true while the horn is pressed.
    pub fn next(&mut self, held: bool) -> f32 {
        let level = self.level.to(if held { Self::LEVEL } else { 0.0 });
        if level == 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        for (phase, note_hz) in self.phases.iter_mut().zip(Self::NOTES_HZ) {
            *phase = (*phase + note_hz / self.rate_hz).fract();
            let (sin, cos) = (TAU * *phase).sin_cos();
            let (mut before, mut here) = (0.0, sin);
            for k in 1..=Self::PARTIALS {
                sum += here / k as f32;
                (before, here) = (here, 2.0 * cos * here - before);
            }
        }
        level * sum
    }
}

/// A contact: a dull thump that falls in pitch.
pub struct ContactSound {
    rate_hz: f32,
    phase: f32,
    /// Remaining strength of the blow, 1 for a hard one, and its smoothed value.
    blow: f32,
    heard: SmoothedValue,
    fall: f32,
}

impl ContactSound {
    /// Closing speed of a blow at full level, m/s.
    const HARD_MPS: f32 = 5.0;
    const LEVEL: f32 = 0.6;

    /// Creates a silent source.
    pub fn new(rate_hz: f32) -> Self {
        let (phase, blow, heard) = (0.0, 0.0, SmoothedValue::new(0.0, 0.002, rate_hz));
        Self { rate_hz, phase, blow, heard, fall: (-1.0 / (0.07 * rate_hz)).exp() }
    }

    /// Adds a contact at this closing speed, m/s.
    pub fn hit(&mut self, closing_mps: f32) {
        self.blow = (self.blow + (closing_mps.abs() / Self::HARD_MPS).clamp(0.15, 1.0)).min(1.0);
    }

    /// Returns the next sample of the thump.
    pub fn next(&mut self) -> f32 {
        self.blow = if self.blow < 1e-5 { 0.0 } else { self.blow * self.fall };
        let heard = self.heard.to(self.blow);
        if heard == 0.0 {
            return 0.0;
        }
        self.phase = (self.phase + (48.0 + 70.0 * heard) / self.rate_hz).fract();
        let turn = TAU * self.phase;
        // A second, rattling voice that decays sooner.
        Self::LEVEL * heard * (turn.sin() + heard * 0.35 * (4.3 * turn).sin() * (PI * self.phase).sin())
    }
}

/// A gentle tone that is always the same: it says that the advice has changed, but not to which, or that there is a
/// question.
pub struct Tone {
    rate_hz: f32,
    note_hz: f32,
    at: Option<u32>,
}

impl Tone {
    const ADVICE_HZ: f32 = 740.0;
    /// A major sixth below the tone of advice, so that the two are not confused.
    const QUESTION_HZ: f32 = 440.0;
    const LENGTH_S: f32 = 0.35;
    const LEVEL: f32 = 0.075;

    /// Creates the tone of a change of advice, silent.
    pub fn of_advice(rate_hz: f32) -> Self {
        Self { rate_hz, note_hz: Self::ADVICE_HZ, at: None }
    }

    /// Creates the tone of a question, silent.
    pub fn of_question(rate_hz: f32) -> Self {
        Self { note_hz: Self::QUESTION_HZ, ..Self::of_advice(rate_hz) }
    }

    /// Starts the tone; a tone that already sounds continues.
    pub fn begin(&mut self) {
        self.at = self.at.or(Some(0));
    }

    /// Returns the next sample of the tone.
    pub fn next(&mut self) -> f32 {
        let Some(at) = self.at else { return 0.0 };
        let t_s = at as f32 / self.rate_hz;
        self.at = (t_s < Self::LENGTH_S).then_some(at + 1);
        // Fast rise and slow decay, flat at both ends: a sine over the square root of time.
        let swell = (PI * (t_s / Self::LENGTH_S).min(1.0).sqrt()).sin().powi(2);
        let turn = TAU * (self.note_hz * t_s).fract();
        Self::LEVEL * swell * (turn.sin() + 0.18 * (2.0 * turn).sin())
    }
}

/// A heel that touches the ground: a short burst of noise.
pub struct Footstep {
    rate_hz: f32,
    noise: FilteredNoise,
    /// Number of steps that have been heard; `None` before the first one of a person.
    heard: Option<u32>,
    /// Samples since the last step, and its level.
    at: Option<u32>,
    level: f32,
}

impl Footstep {
    const NOTE_HZ: f32 = 700.0;
    const RISE_S: f32 = 0.001;
    const DECAY_S: f32 = 0.025;
    const LENGTH_S: f32 = 0.18;
    /// Amplitude of the noise at 1 m.
    const LEVEL: f32 = 0.0075;

    /// Creates a silent source.
    pub fn new(seed: u64, rate_hz: f32) -> Self {
        Self { rate_hz, noise: FilteredNoise::around(seed, rate_hz), heard: None, at: None, level: 0.0 }
    }

    /// Returns the next sample; `steps` are the number of steps of a person so far and their level, 1 at 1 m. A number that changes begins a step.
    pub fn next(&mut self, steps: Option<(u32, f32)>) -> f32 {
        let heard = std::mem::replace(&mut self.heard, steps.map(|(count, _)| count));
        if let (Some(before), Some((now, level))) = (heard, steps)
            && before != now
        {
            (self.at, self.level) = (Some(0), Self::LEVEL * level);
        }
        let Some(at) = self.at else { return 0.0 };
        let t_s = at as f32 / self.rate_hz;
        self.at = (t_s < Self::LENGTH_S).then_some(at + 1);
        let envelope = (1.0 - (-t_s / Self::RISE_S).exp()) * (-t_s / Self::DECAY_S).exp();
        self.level * envelope * self.noise.next(Self::NOTE_HZ)
    }
}
