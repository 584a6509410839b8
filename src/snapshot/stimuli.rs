//! Stimuli that events of the scenario give the participant, beside texts. In: nothing. Out: [`EventStimuli`] of a moment, which dial, sound and wheel
//! follow, and [`ShownQuestion`].

use crate::{rng, snapshot::HASH_START, time::Tick};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Stimuli of events at a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EventStimuli {
    /// Sign above the speedometer.
    pub pictogram: Option<Pictogram>,
    /// Series of tones that are under way, each with its first tick.
    pub tones: Vec<(ToneSeries, Tick)>,
    /// Sentence to speak, with its first tick.
    pub sentence: Option<(Arc<str>, Tick)>,
    /// Strength of the vibration at the steering wheel, 0 (none) to 1.
    pub wheel_pulse: f64,
}

/// Question to the participant above the speedometer.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownQuestion {
    /// Text of the question.
    pub question: Arc<str>,
    /// Answers from left to right: two for the buttons left and right, a third between them for the response button.
    pub answers: Vec<Arc<str>>,
}

/// Sign above the speedometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Pictogram {
    /// The word BRAKE on red: brake now.
    Brake,
    /// Two hands at a steering wheel: take the wheel.
    HandsOn,
    /// A person on foot in a triangle.
    Pedestrian,
    /// A car that skids, in a triangle.
    Slippery,
    /// A red octagon with the word STOP.
    Stop,
    /// An exclamation mark in a triangle.
    Warning,
}

/// Series of equal tones, as takeover requests have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ToneSeries {
    /// A tone each two seconds.
    Gentle,
    /// A tone each 0.6 s.
    Urgent,
}

impl ToneSeries {
    /// Returns true if a tone begins this number of ticks after the first one.
    pub fn begins_tone(self, passed_ticks: u64) -> bool {
        passed_ticks.is_multiple_of(self.every_ticks())
    }

    /// Returns the time from one tone to the next, ticks.
    pub(super) fn every_ticks(self) -> u64 {
        match self {
            Self::Gentle => 200,
            Self::Urgent => 60,
        }
    }
}

impl ShownQuestion {
    /// Visits its texts as hashes.
    pub(super) fn visit(&self, put: &mut impl FnMut(&'static str, u32, f64)) {
        for text in self.answers.iter().chain([&self.question]) {
            put("question", 0, rng::fnv_1a(HASH_START, text.as_bytes()) as f64);
        }
    }
}

impl EventStimuli {
    /// Visits all of them as numbers, texts by their hashes.
    pub(super) fn visit(&self, put: &mut impl FnMut(&'static str, u32, f64)) {
        if let Some(pictogram) = self.pictogram {
            put("pictogram", 0, f64::from(pictogram as u8));
        }
        for (series, first) in &self.tones {
            put("tone", 0, f64::from(*series as u8));
            put("first tone", 0, first.seconds());
        }
        if let Some((sentence, first)) = &self.sentence {
            put("sentence", 0, rng::fnv_1a(HASH_START, sentence.as_bytes()) as f64);
            put("time of the sentence", 0, first.seconds());
        }
        put("wheel pulse", 0, self.wheel_pulse);
    }
}
