//! What can be wrong with a questionnaire's questions and scores, by kind.

/// Why a questionnaire cannot be asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuestionFault {
    /// A question with nothing to choose from.
    #[error("\"{name}\" has no {what}")]
    Empty {
        /// The question.
        name: String,
        /// What it lacks.
        what: &'static str,
    },
    /// A scale without whole steps, or with too many.
    #[error("\"{name}\" rates from {from} to {to} by {by}; allowed: 1 to 100 whole steps")]
    Scale {
        /// The question.
        name: String,
        /// Lowest rating.
        from: f64,
        /// Highest rating.
        to: f64,
        /// From one rating to the next.
        by: f64,
    },
    /// Two questions of one name.
    #[error("the name \"{0}\" comes twice")]
    Twice(String),
    /// A condition on what is not asked.
    #[error("visibleIf asks for \"{name}\", which no question before or beside it has{near}")]
    UnknownCondition {
        /// The name in the condition.
        name: String,
        /// The nearest that exists, as a question; empty where none is near.
        near: String,
    },
    /// A score of what is not asked.
    #[error("the score \"{score}\" is of \"{name}\", which no question has{near}")]
    UnknownScore {
        /// The score.
        score: String,
        /// The name in it.
        name: String,
        /// The nearest that exists, as a question; empty where none is near.
        near: String,
    },
    /// Weights that nothing asks for, or that are missing.
    #[error("the score \"{0}\" has `by` where it is not weighted, or is weighted without `by`; they go together")]
    Weights(String),
    /// An answer whose scale cannot be turned.
    #[error(
        "the score \"{score}\" turns \"{name}\"; allowed: a rating or a row of a matrix of numbers that is in its `of`"
    )]
    Turned {
        /// The score.
        score: String,
        /// The name in it.
        name: String,
    },
    /// A condition that is none.
    #[error("visibleIf has \"{0}\"; allowed: {{name}} = 'word' or {{name}} > 3, with = <> < <= > >= contains")]
    Comparison(String),
}
