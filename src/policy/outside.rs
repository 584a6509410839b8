//! Advice that somebody outside of a drive gives: a learner, a program, a person. In: an [`Action`] before the step that it begins with.
//! Out: that action, once. No policy is asked.

use super::Action;

/// The next advice, said from outside. Nothing new is advised in a step before which nothing was said; what was advised before stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutsideAdvice {
    next: Option<Action>,
}

impl OutsideAdvice {
    /// Says what is advised from the next step on. A second word before that step takes the place of the first.
    pub fn say(&mut self, action: Action) {
        self.next = Some(action);
    }

    /// What was said for the step that begins, if anything.
    pub fn take(&mut self) -> Option<Action> {
        self.next.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_word_is_taken_once_and_the_last_of_two_counts() {
        let mut outside = OutsideAdvice::default();
        assert_eq!(outside.take(), None);
        outside.say(Action::Speed(3.0));
        outside.say(Action::Acceleration(0.5));
        assert_eq!((outside.take(), outside.take()), (Some(Action::Acceleration(0.5)), None));
    }
}
