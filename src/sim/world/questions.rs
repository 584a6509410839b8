//! Questions that events of the scenario put to the participant. In: actions that ask; the pressed button and whether the automation drives, each
//! tick. Out: the question that is shown, and events. A press that answers is none for the secondary task.

use crate::{
    controls::TaskButton,
    metrics::QuestionChange,
    scenario::scripted_event::Ask,
    sim::{Event, EventKind},
    snapshot::ShownQuestion,
    time::Tick,
};
use std::sync::Arc;

/// Question of a drive that is shown, and one that is shown from the next tick on.
#[derive(Debug, Default)]
pub(super) struct Questions {
    next: Option<(u16, Ask)>,
    shown: Option<OpenQuestion>,
}

/// Question that waits for its answer.
#[derive(Debug)]
struct OpenQuestion {
    event: u16,
    ask: Ask,
    /// First tick that shows it.
    since: Tick,
    display: Arc<ShownQuestion>,
}

impl Questions {
    /// Shows the question of an event from the next tick on, in place of another one, which then has no answer.
    pub fn ask(&mut self, event: usize, ask: &Ask) {
        self.next = Some((event as u16, ask.clone()));
    }

    /// Advances to a tick with the button that was pressed since the tick before. Returns the button for the secondary task, which has none while a
    /// question is shown.
    pub fn tick(&mut self, tick: Tick, button: TaskButton, is_automated: bool, events: &mut Vec<Event>) -> TaskButton {
        let mut note = |event, change| events.push(Event { tick, kind: EventKind::Question { event, change } });
        if let Some((event, ask)) = self.next.take() {
            if let Some(before) = self.shown.take() {
                note(before.event, QuestionChange::Unanswered);
            }
            note(event, QuestionChange::Asked);
            let answers = ask.answers.iter().map(|answer| answer.as_str().into()).collect();
            let display = Arc::new(ShownQuestion { question: ask.question.as_str().into(), answers });
            self.shown = Some(OpenQuestion { event, ask, since: tick, display });
            // A press of this tick came before the question.
            return button;
        }
        let Some(OpenQuestion { event, ask, since, .. }) = &self.shown else { return button };
        let is_over = tick.0 - since.0 >= Tick::at_seconds(ask.for_s).0;
        let change = match ask.chosen(button) {
            Some(answer) => QuestionChange::Answered { answer, is_right: ask.is_right(answer, is_automated) },
            None if is_over => QuestionChange::Unanswered,
            None => return TaskButton::None,
        };
        note(*event, change);
        self.shown = None;
        TaskButton::None
    }

    /// Returns the question that is shown.
    pub fn shown(&self) -> Option<Arc<ShownQuestion>> {
        self.shown.as_ref().map(|open| Arc::clone(&open.display))
    }
}
