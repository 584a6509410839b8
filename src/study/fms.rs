//! The fast motion sickness scale, asked while driving. In: time of the drive and the participant's input. Out: the moments to ask, the
//! number to show, a [`FmsRating`] for each question.
//!
//! One question, rated 0 (no sickness at all) to 20 (frank sickness), once a minute (Keshavarz and Hecht 2011). Time is simulation time,
//! so a paused drive asks nothing.

use serde::{Deserialize, Serialize};

/// Upper end of the scale: frank sickness.
pub const HIGHEST: u8 = 20;
/// Time that a question stays on screen, s; then it counts as unanswered.
pub const ANSWER_S: f64 = 15.0;
/// Name of the score in `stop_above`.
pub const SCORE: &str = "fms";
/// Kind of the event in a recording when the question is asked.
pub const ASKED: &str = "fms_asked";
/// Kind of the event in a recording when the question is answered, with the value.
pub const ANSWERED: &str = "fms";
/// Kind of the event in a recording when the question disappears without an answer.
pub const UNANSWERED: &str = "fms_unanswered";

/// One question and its answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FmsRating {
    /// Time of the question since the start of the drive, s.
    pub time_s: f64,
    /// Answer, 0 to [`HIGHEST`]; `None` if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<u8>,
    /// Time from the question to the answer, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer_s: Option<f64>,
}

/// Event that the passing of time causes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FmsEvent {
    /// The question is asked now.
    Asked,
    /// The question has timed out.
    Unanswered(FmsRating),
}

/// Question as shown to the participant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FmsPrompt {
    /// Value that a confirmation would give now.
    pub value: u8,
    /// Time until the question disappears, s.
    pub left_s: f64,
}

/// State of the scale in one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct FmsScale {
    every_s: f64,
    /// Time of the next question since the start of the drive, s.
    due_s: f64,
    /// Last answer, the initial value of the next question.
    last: u8,
    /// Value that is shown now.
    value: u8,
    /// Time when the current question was asked, s; `None` while there is none.
    asked_s: Option<f64>,
}

impl FmsScale {
    /// Creates a scale with a question every `every_s` seconds. `last` is the last answer before the drive, the initial value of the
    /// first question.
    pub fn new(every_s: f64, last: u8) -> Self {
        let last = last.min(HIGHEST);
        Self { every_s, due_s: every_s, last, value: last, asked_s: None }
    }

    /// Advances to `now_s` in a drive that ends at `end_s`. A question whose time to answer would pass the end is not asked.
    pub fn time(&mut self, now_s: f64, end_s: f64) -> Option<FmsEvent> {
        if let Some(asked_s) = self.asked_s {
            if now_s < asked_s + ANSWER_S {
                return None;
            }
            self.asked_s = None;
            return Some(FmsEvent::Unanswered(FmsRating { time_s: asked_s, value: None, answer_s: None }));
        }
        if now_s < self.due_s {
            return None;
        }
        while self.due_s <= now_s {
            self.due_s += self.every_s;
        }
        if now_s + ANSWER_S > end_s {
            return None;
        }
        (self.asked_s, self.value) = (Some(now_s), self.last);
        Some(FmsEvent::Asked)
    }

    /// Changes the value by `by`, within the scale; ignored without a question.
    pub fn turn(&mut self, by: i32) {
        if self.asked_s.is_some() {
            let value = i32::from(self.value).saturating_add(by).clamp(0, HIGHEST.into());
            self.value = value as u8;
        }
    }

    /// Answers the current question with the value shown.
    pub fn confirm(&mut self, now_s: f64) -> Option<FmsRating> {
        let time_s = self.asked_s.take()?;
        self.last = self.value;
        let answer_s = ((now_s - time_s) * 100.0).round() / 100.0;
        Some(FmsRating { time_s, value: Some(self.value), answer_s: Some(answer_s) })
    }

    /// Returns the current question.
    pub fn prompt(&self, now_s: f64) -> Option<FmsPrompt> {
        let asked_s = self.asked_s?;
        Some(FmsPrompt { value: self.value, left_s: (asked_s + ANSWER_S - now_s).max(0.0) })
    }
}

impl std::fmt::Display for FmsRating {
    /// Describes the rating for recordings: `12 of 20 after 3.4 s`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.value, self.answer_s) {
            (Some(value), Some(answer_s)) => write!(f, "{value} of {HIGHEST} after {answer_s} s"),
            (Some(value), None) => write!(f, "{value} of {HIGHEST}"),
            (None, _) => write!(f, "no answer in {ANSWER_S} s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_comes_each_minute_unless_the_drive_ends_first() {
        let mut scale = FmsScale::new(60.0, 0);
        let mut asked = Vec::new();
        for tick in 1..=30_000_u32 {
            let now_s = f64::from(tick) / 100.0;
            if scale.time(now_s, 300.0) == Some(FmsEvent::Asked) {
                asked.push(now_s);
                scale.confirm(now_s + 1.0);
            }
        }
        // A drive of five minutes ends at 300 s.
        assert_eq!(asked, [60.0, 120.0, 180.0, 240.0]);
        let mut scale = FmsScale::new(60.0, 0);
        assert_eq!((scale.time(60.0, 74.9), scale.time(61.0, 75.0)), (None, None), "it is not asked late either");
        assert_eq!(FmsScale::new(60.0, 0).time(60.0, 75.0), Some(FmsEvent::Asked));
    }

    #[test]
    fn the_rating_starts_at_the_last_answer_and_expires_after_15_s() {
        let mut scale = FmsScale::new(20.0, 3);
        scale.turn(5);
        assert_eq!((scale.prompt(1.0), scale.confirm(1.0)), (None, None), "nothing is asked");
        assert_eq!(scale.time(20.0, 600.0), Some(FmsEvent::Asked));
        scale.turn(1);
        assert_eq!(scale.prompt(25.0), Some(FmsPrompt { value: 4, left_s: 10.0 }));
        scale.turn(-9);
        assert_eq!(scale.prompt(25.0).unwrap().value, 0);
        scale.turn(i32::MAX);
        let rating = scale.confirm(23.4).unwrap();
        assert_eq!(rating, FmsRating { time_s: 20.0, value: Some(20), answer_s: Some(3.4) });
        assert_eq!((rating.to_string(), scale.confirm(23.5)), ("20 of 20 after 3.4 s".into(), None));
        assert_eq!(scale.time(40.0, 600.0), Some(FmsEvent::Asked));
        assert_eq!(scale.prompt(40.0).unwrap().value, 20, "from the last answer on");
        scale.turn(-5);
        assert_eq!(scale.time(54.99, 600.0), None);
        let gone = FmsRating { time_s: 40.0, value: None, answer_s: None };
        assert_eq!(scale.time(55.0, 600.0), Some(FmsEvent::Unanswered(gone)));
        assert_eq!((gone.to_string(), scale.prompt(55.0)), ("no answer in 15 s".into(), None));
        assert_eq!((scale.time(60.0, 600.0), scale.prompt(60.0).unwrap().value), (Some(FmsEvent::Asked), 20));
    }
}
