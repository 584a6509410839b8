//! Question that an event puts to the participant while they drive. In: the action `ask`. Out: a checked [`Ask`], and the answer that a button chooses.

use super::{
    action::check_text,
    values::{LATEST_S, within},
};
use crate::controls::TaskButton;
use serde::{Deserialize, Serialize};

/// Longest question and longest answer, letters: they are read at a glance.
const QUESTION_LETTERS: usize = 60;
const ANSWER_LETTERS: usize = 20;

/// Question with two or three answers, which the buttons of the secondary task choose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ask {
    /// Question to the participant, such as "Who steers now?".
    pub question: String,
    /// Answers from left to right.
    pub answers: Vec<String>,
    /// Right answer; `None` if none is scored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<String>,
    /// Right answer while the automation drives, if it is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right_automated: Option<String>,
    /// Time for the answer, s.
    #[schemars(range(min = 0.1, max = LATEST_S), extend("unit" = "s"))]
    pub for_s: f64,
}

impl Ask {
    /// Checks lengths, number of answers, and that right ones are among them.
    pub(super) fn check(&self) -> Result<(), String> {
        check_text("question", &self.question, QUESTION_LETTERS)?;
        if !(2..=3).contains(&self.answers.len()) {
            return Err(format!("{} answers; allowed: 2 or 3", self.answers.len()));
        }
        self.answers.iter().try_for_each(|answer| check_text("answer", answer, ANSWER_LETTERS))?;
        for (key, right) in [("right", &self.right), ("right_automated", &self.right_automated)] {
            if let Some(right) = right.as_ref().filter(|right| !self.answers.contains(right)) {
                return Err(format!("{key} is \"{right}\"; allowed: \"{}\"", self.answers.join("\", \"")));
            }
        }
        if self.right.is_none() && self.right_automated.is_some() {
            return Err("right_automated needs right, the right answer at all other times".into());
        }
        within("for_s", self.for_s, [0.1, LATEST_S])
    }

    /// Returns the number of the answer that a button chooses, from 0 on the left; `None` if it chooses none.
    pub fn chosen(&self, button: TaskButton) -> Option<u8> {
        match (button, self.answers.len()) {
            (TaskButton::Left, _) => Some(0),
            (TaskButton::Respond, 3) => Some(1),
            (TaskButton::Right, answers) => Some(answers as u8 - 1),
            _ => None,
        }
    }

    /// Checks whether this answer is right while the automation drives or does not; `None` if no right answer is stated.
    pub fn is_right(&self, answer: u8, is_automated: bool) -> Option<bool> {
        let automated = self.right_automated.as_ref().filter(|_| is_automated);
        let right = automated.or(self.right.as_ref())?;
        Some(self.answers.get(usize::from(answer)) == Some(right))
    }
}
