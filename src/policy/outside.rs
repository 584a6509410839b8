//! Advice from outside of a drive: a learner, a program or a person. In: an [`Action`] before the step in which it begins. Out: that
//! action, once. No policy is asked.

use super::Action;

/// The next action from outside. A step without a new action issues no advice, and the previous advice stays in force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutsideAdvice {
    next: Option<Action>,
}

impl OutsideAdvice {
    /// Sets the action for the next step; a second call before that step replaces the first.
    pub fn set_action(&mut self, action: Action) {
        self.next = Some(action);
    }

    /// Returns the action for the step that begins, if any, and clears it.
    pub fn take(&mut self) -> Option<Action> {
        self.next.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_action_is_taken_once_and_a_later_one_replaces_it() {
        let mut outside = OutsideAdvice::default();
        assert_eq!(outside.take(), None);
        outside.set_action(Action::Speed(3.0));
        outside.set_action(Action::Acceleration(0.5));
        assert_eq!((outside.take(), outside.take()), (Some(Action::Acceleration(0.5)), None));
    }
}
