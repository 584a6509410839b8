//! Scores of questions that events put to the participant while they drive. In: moments of questions and answers, in order. Out: a
//! [`QuestionScore`]. Seconds since the start of the drive.

use super::secondary_task::share;
use crate::time::Tick;
use serde::Serialize;

/// Change of a question to the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuestionChange {
    /// The question appears above the speedometer.
    Asked,
    /// A button chooses an answer in its time.
    Answered {
        /// Number of the answer, from 0 on the left.
        answer: u8,
        /// True for the right answer; `None` if no right answer is stated.
        is_right: Option<bool>,
    },
    /// The time for the answer is over, or another question takes the place.
    Unanswered,
}

impl QuestionChange {
    /// Returns kind, detail and value of the row in the table of events; the detail is `None` for the name of the question's event.
    pub fn words(self) -> (&'static str, Option<&'static str>, Option<f64>) {
        match self {
            Self::Asked => ("question_asked", None, None),
            Self::Unanswered => ("question_unanswered", None, None),
            Self::Answered { answer, is_right } => {
                let detail = match is_right {
                    Some(true) => "right",
                    Some(false) => "wrong",
                    None => "not scored",
                };
                ("question_answered", Some(detail), Some(f64::from(answer) + 1.0))
            }
        }
    }

    /// Returns the change of a row of the table of events; `None` for other rows.
    pub fn of_words(kind: &str, detail: &str, value: Option<f64>) -> Option<Self> {
        match (kind, value) {
            ("question_asked", _) => Some(Self::Asked),
            ("question_unanswered", _) => Some(Self::Unanswered),
            ("question_answered", Some(number)) => {
                let is_right = match detail {
                    "right" => Some(true),
                    "wrong" => Some(false),
                    _ => None,
                };
                Some(Self::Answered { answer: (number - 1.0) as u8, is_right })
            }
            _ => None,
        }
    }
}

/// Score of the questions of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct QuestionScore {
    /// Number of questions that were answered or had their whole time.
    pub questions: u32,
    /// Number of those without an answer.
    pub questions_unanswered: u32,
    /// Share of right answers among the answers to questions with a right one, 0..1; `None` without such answers.
    pub question_correct: Option<f64>,
    /// Mean time from a question to its answer, s; `None` without answers.
    pub question_response_s: Option<f64>,
}

impl QuestionScore {
    /// Returns the score of these changes.
    pub fn of(changes: &[(Tick, QuestionChange)]) -> Self {
        let (mut answered, mut unanswered, mut scored, mut right) = (0, 0, 0, 0);
        let (mut sum_s, mut asked) = (0.0, None);
        for (tick, change) in changes {
            match *change {
                QuestionChange::Asked => asked = Some(tick.seconds()),
                QuestionChange::Unanswered => unanswered += 1,
                QuestionChange::Answered { is_right, .. } => {
                    let Some(asked_s) = asked.take() else { continue };
                    answered += 1;
                    sum_s += tick.seconds() - asked_s;
                    scored += u32::from(is_right.is_some());
                    right += u32::from(is_right == Some(true));
                }
            }
        }
        Self {
            questions: answered + unanswered,
            questions_unanswered: unanswered,
            question_correct: share(right, scored),
            question_response_s: (answered > 0).then(|| sum_s / f64::from(answered)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_answers_and_times_from_question_to_answer() {
        use QuestionChange::{Answered, Asked, Unanswered};
        let answered = |is_right| Answered { answer: 0, is_right };
        // Right after 1.5 s, wrong after 2.5 s, not answered, not scored after 2 s, right after 1 s; the last has no time left.
        let changes = [
            (10.0, Asked),
            (11.5, answered(Some(true))),
            (20.0, Asked),
            (22.5, answered(Some(false))),
            (30.0, Asked),
            (38.0, Unanswered),
            (40.0, Asked),
            (42.0, answered(None)),
            (50.0, Asked),
            (51.0, answered(Some(true))),
            (60.0, Asked),
        ];
        let score = QuestionScore::of(&changes.map(|(at_s, change)| (Tick::at_seconds(at_s), change)));
        assert_eq!((score.questions, score.questions_unanswered), (5, 1));
        assert_eq!(score.question_correct, Some(2.0 / 3.0));
        // (1.5 + 2.5 + 2 + 1) / 4
        assert!((score.question_response_s.unwrap() - 1.75).abs() < 1e-9);
        let none = QuestionScore::of(&[(Tick(1), Asked)]);
        assert_eq!((none.questions, none.question_correct, none.question_response_s), (0, None, None));
    }

    #[test]
    fn changes_are_read_as_they_are_written() {
        let answers = [Some(true), Some(false), None].map(|is_right| QuestionChange::Answered { answer: 2, is_right });
        for change in answers.into_iter().chain([QuestionChange::Asked, QuestionChange::Unanswered]) {
            let (kind, detail, value) = change.words();
            assert_eq!(QuestionChange::of_words(kind, detail.unwrap_or("mode"), value), Some(change));
        }
        assert_eq!(QuestionChange::of_words("task_response", "button", None), None);
    }
}
