//! The fast motion sickness scale, asked while driving. In: the time of the drive, what the participant's hand does. Out: when to
//! ask, the number that stands in the picture, a [`FmsRating`] for each question.
//!
//! One question, 0 (no sickness at all) to 20 (frank sickness), once a minute: Keshavarz and Hecht 2011. Time is that of the
//! simulation, so that a drive that is held asks nothing.

use serde::{Deserialize, Serialize};

/// The upper end of the scale: frank sickness.
pub const HIGHEST: u8 = 20;
/// A question stands for so long, seconds; then it counts as unanswered.
pub const ANSWER_S: f64 = 15.0;
/// Name of the score in `stop_above`.
pub const SCORE: &str = "fms";
/// Kinds of events in a recording: asked; answered, with the value; gone without an answer.
pub const ASKED: &str = "fms_asked";
/// See [`ASKED`].
pub const ANSWERED: &str = "fms";
/// See [`ASKED`].
pub const UNANSWERED: &str = "fms_unanswered";

/// One question and what came of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FmsRating {
    /// When it was asked, seconds since the start of the drive.
    pub time_s: f64,
    /// The answer, 0 to [`HIGHEST`]; `None` where none came.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<u8>,
    /// From the question to the answer, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer_s: Option<f64>,
}

/// What time brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FmsEvent {
    /// The question is asked now.
    Asked,
    /// It has stood long enough.
    Unanswered(FmsRating),
}

/// The question as it stands in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FmsPrompt {
    /// The number that would be answered now.
    pub value: u8,
    /// How long it still stands, seconds.
    pub left_s: f64,
}

/// The scale in one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct FmsScale {
    every_s: f64,
    /// The next question, seconds since the start of the drive.
    due_s: f64,
    /// The last answer: the next question begins there.
    last: u8,
    /// The number that stands.
    value: u8,
    /// When the question that stands was asked, seconds.
    asked_s: Option<f64>,
}

impl FmsScale {
    /// Asks every so many seconds; the first question begins at the last answer before the drive.
    pub fn new(every_s: f64, last: u8) -> Self {
        let last = last.min(HIGHEST);
        Self { every_s, due_s: every_s, last, value: last, asked_s: None }
    }

    /// It is `now_s` in a drive that ends at `end_s`: a question that could not stand to its end is not asked.
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

    /// The hand moves the number; without a question nothing moves.
    pub fn turn(&mut self, by: i32) {
        if self.asked_s.is_some() {
            let value = i32::from(self.value).saturating_add(by).clamp(0, HIGHEST.into());
            self.value = value as u8;
        }
    }

    /// The hand answers with the number that stands.
    pub fn confirm(&mut self, now_s: f64) -> Option<FmsRating> {
        let time_s = self.asked_s.take()?;
        self.last = self.value;
        let answer_s = ((now_s - time_s) * 100.0).round() / 100.0;
        Some(FmsRating { time_s, value: Some(self.value), answer_s: Some(answer_s) })
    }

    /// The question that stands.
    pub fn prompt(&self, now_s: f64) -> Option<FmsPrompt> {
        let asked_s = self.asked_s?;
        Some(FmsPrompt { value: self.value, left_s: (asked_s + ANSWER_S - now_s).max(0.0) })
    }
}

impl FmsRating {
    /// In words, for recordings: `12 of 20 after 3.4 s`.
    pub fn words(&self) -> String {
        match (self.value, self.answer_s) {
            (Some(value), Some(answer_s)) => format!("{value} of {HIGHEST} after {answer_s} s"),
            (Some(value), None) => format!("{value} of {HIGHEST}"),
            (None, _) => format!("no answer in {ANSWER_S} s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_asked_once_a_minute_and_not_where_the_drive_would_end_before_the_answer() {
        let mut scale = FmsScale::new(60.0, 0);
        let mut asked = Vec::new();
        for tick in 1..=30_000_u32 {
            let now_s = f64::from(tick) / 100.0;
            if scale.time(now_s, 300.0) == Some(FmsEvent::Asked) {
                asked.push(now_s);
                scale.confirm(now_s + 1.0);
            }
        }
        // 300 s are the end of a drive of five minutes.
        assert_eq!(asked, [60.0, 120.0, 180.0, 240.0]);
        let mut scale = FmsScale::new(60.0, 0);
        assert_eq!((scale.time(60.0, 74.9), scale.time(61.0, 75.0)), (None, None), "it is not asked late either");
        assert_eq!(FmsScale::new(60.0, 0).time(60.0, 75.0), Some(FmsEvent::Asked));
    }

    #[test]
    fn the_number_begins_at_the_last_answer_stays_on_the_scale_and_goes_after_fifteen_seconds() {
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
        assert_eq!((rating.words(), scale.confirm(23.5)), ("20 of 20 after 3.4 s".into(), None));
        assert_eq!(scale.time(40.0, 600.0), Some(FmsEvent::Asked));
        assert_eq!(scale.prompt(40.0).unwrap().value, 20, "from the last answer on");
        scale.turn(-5);
        assert_eq!(scale.time(54.99, 600.0), None);
        let gone = FmsRating { time_s: 40.0, value: None, answer_s: None };
        assert_eq!(scale.time(55.0, 600.0), Some(FmsEvent::Unanswered(gone)));
        assert_eq!((gone.words(), scale.prompt(55.0)), ("no answer in 15 s".into(), None));
        assert_eq!((scale.time(60.0, 600.0), scale.prompt(60.0).unwrap().value), (Some(FmsEvent::Asked), 20));
    }
}
