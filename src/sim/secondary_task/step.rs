//! Step of a secondary task: its input and output in one tick.

use crate::{
    controls::TaskButton,
    metrics::{TaskResponse, TaskStimulus},
    sim::{Event, EventKind},
    snapshot::{TaskDisplay, TaskPicture},
    time::{TICKS_PER_S, Tick},
};

/// Input and output of a task in one tick.
pub(super) struct TaskStep<'a> {
    pub tick: Tick,
    pub button: TaskButton,
    pub display: &'a mut TaskDisplay,
    pub events: &'a mut Vec<Event>,
}

impl TaskStep<'_> {
    /// Shows a new stimulus.
    pub fn present(&mut self, stimulus: TaskStimulus, shown: TaskPicture) {
        *self.display = TaskDisplay { stimulus: self.display.stimulus + 1, shown };
        self.note(EventKind::TaskStimulus(stimulus));
    }

    /// Shows something else without a new stimulus.
    pub fn show(&mut self, shown: TaskPicture) {
        self.display.shown = shown;
    }

    /// Notes a response of the driver.
    pub fn respond(&mut self, response: TaskResponse) {
        self.note(EventKind::TaskResponse(response));
    }

    /// Adds an event of this tick.
    pub fn note(&mut self, kind: EventKind) {
        self.events.push(Event { tick: self.tick, kind });
    }

    /// Returns true if the response button was pressed.
    pub fn is_pressed(&self) -> bool {
        self.button == TaskButton::Respond
    }
}

/// Returns the number of ticks of a time.
pub(super) fn ticks(seconds: f64) -> u64 {
    (seconds * f64::from(TICKS_PER_S)).round() as u64
}
