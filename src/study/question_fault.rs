//! Errors in the questions and scores of a questionnaire, by kind.

use super::StudyError;

/// Reason why a questionnaire cannot be asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuestionFault {
    /// A question without options.
    #[error("\"{name}\" has no {what}")]
    Empty {
        /// Name of the question.
        name: String,
        /// Missing list: choices, columns or rows.
        what: &'static str,
    },
    /// A scale without whole steps, or with too many.
    #[error("\"{name}\" rates from {from} to {to} in steps of {by}; allowed: 1 to 100 whole steps")]
    Scale {
        /// Name of the question.
        name: String,
        /// Lowest rating of the scale.
        from: f64,
        /// Highest rating of the scale.
        to: f64,
        /// Step between ratings, `rateStep`.
        by: f64,
    },
    /// A number without a range.
    #[error("\"{name}\" asks for a number from {min} to {max}; allowed: `min` below `max`")]
    Bounds {
        /// Name of the question.
        name: String,
        /// Lowest number, `min`.
        min: f64,
        /// Highest number, `max`.
        max: f64,
    },
    /// Two questions with the same name.
    #[error("the name \"{0}\" occurs twice")]
    Twice(String),
    /// A condition on an unknown question.
    #[error("visibleIf names \"{name}\", but no earlier question and none on its page has this name{near}")]
    UnknownCondition {
        /// Unknown name in the condition.
        name: String,
        /// Nearest known name, as a question ("did you mean ...?"); empty if none is near.
        near: String,
    },
    /// A comparison that no answer can satisfy as meant, because the answers are of another type.
    #[error("\"{comparison}\" does not fit: an answer to \"{name}\" is {is}; allowed: {allowed}")]
    Unlike {
        /// Text with the name in braces, such as `{age} < 18`.
        comparison: String,
        /// Name of the question.
        name: String,
        /// Type of the question's answers.
        is: String,
        /// Comparisons that this type allows, with the remedy.
        allowed: String,
    },
    /// A score of an unknown question.
    #[error("the score \"{score}\" uses \"{name}\", but no question has this name{near}")]
    UnknownScore {
        /// Name of the score.
        score: String,
        /// Unknown name in the score.
        name: String,
        /// Nearest known name, as a question ("did you mean ...?"); empty if none is near.
        near: String,
    },
    /// Weights in a score without weighting, or missing weights in a weighted score.
    #[error("the score \"{0}\" has `by` without weighting, or weighting without `by`; allowed: both or neither")]
    Weights(String),
    /// A reversed item whose scale cannot be reversed.
    #[error(
        "the score \"{score}\" reverses \"{name}\"; allowed: a rating, or a row of a matrix of numbers, from its `of`"
    )]
    Turned {
        /// Name of the score.
        score: String,
        /// Name of the item in `turned`.
        name: String,
    },
    /// A condition that cannot be parsed.
    #[error("visibleIf has \"{0}\"; allowed: {{name}} = 'word' or {{name}} > 3, with = <> < <= > >= contains")]
    Comparison(String),
}

impl QuestionFault {
    /// Returns the whole message, with the file and the position of a condition at fault in its text.
    pub(super) fn located(&self, text: &str, name: &str) -> StudyError {
        StudyError(format!("{name}{}: {self}", self.place_in(text)))
    }

    /// Returns the position of a condition at fault, as `:line:column`; empty for other faults.
    fn place_in(&self, text: &str) -> String {
        let written = match self {
            Self::Unlike { comparison, .. } => serde_json::Value::from(comparison.as_str()).to_string(),
            Self::UnknownCondition { name, .. } => format!("\"{{{name}}}\""),
            _ => return String::new(),
        };
        let Some(at) = text.find(written.trim_matches('"')) else { return String::new() };
        let before = &text[..at];
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        format!(":{}:{column}", before.matches('\n').count() + 1)
    }
}
