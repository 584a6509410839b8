//! Completion of a session, as the data set reports it. In: the log of a session. Out: a [`Completion`].

use super::session_log::{EndCause, ItemOutcome, SessionLog};

/// Extent to which a session was completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Completion {
    /// The session is not over.
    Open,
    /// Every item of the plan was done to its end.
    Complete,
    /// The plan was completed, with at least one item skipped.
    Partial,
    /// The session was stopped for good before the end of the plan.
    Withdrawn,
    /// The session was stopped for good before the end of the plan, because program, computer or a device failed.
    EndedTechnically,
    /// The participant did not agree to take part.
    Declined,
    /// Answers that exclude the participant from the study ended the session.
    NotEligible,
    /// The experimenter excluded the data, however far the session got.
    Excluded,
}

impl std::fmt::Display for Completion {
    /// Writes the word in `participants.tsv`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Open => "open",
            Self::Complete => "complete",
            Self::Partial => "partial",
            Self::Withdrawn => "withdrawn",
            Self::EndedTechnically => "ended_technically",
            Self::Declined => "declined",
            Self::NotEligible => "not_eligible",
            Self::Excluded => "excluded",
        })
    }
}

impl Completion {
    /// All values, in order.
    pub const ALL: [Self; 8] = [
        Self::Open,
        Self::Complete,
        Self::Partial,
        Self::Withdrawn,
        Self::EndedTechnically,
        Self::Declined,
        Self::NotEligible,
        Self::Excluded,
    ];

    /// Returns the completion of a session.
    pub fn of(log: &SessionLog) -> Self {
        let Some(end) = &log.end else { return Self::Open };
        let skipped = |item: &str| log.last(item).is_some_and(|last| last.outcome == ItemOutcome::Skipped);
        if end.excluded.is_some() {
            Self::Excluded
        } else if !end.complete {
            match end.cause {
                Some(EndCause::Declined) => Self::Declined,
                Some(EndCause::NotEligible) => Self::NotEligible,
                Some(EndCause::Technical) => Self::EndedTechnically,
                Some(EndCause::ScoreLimit) | None => Self::Withdrawn,
            }
        } else if log.item_runs.iter().any(|item_run| skipped(&item_run.item)) {
            Self::Partial
        } else {
            Self::Complete
        }
    }

    /// Returns the meaning of the word, for the sidecar.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Open => "the session is not over",
            Self::Complete => "every item of the plan was completed",
            Self::Partial => "the session was completed, and at least one item was skipped",
            Self::Withdrawn => "the session was stopped for good before its end, by the experimenter or by a rule",
            Self::EndedTechnically => {
                "the session was stopped for good before its end, because program, computer or a device failed"
            }
            Self::Declined => "the participant did not agree to take part",
            Self::NotEligible => "the answers to a screening ended the session",
            Self::Excluded => "the experimenter excluded the data; codrive analyse does not use them",
        }
    }
}
