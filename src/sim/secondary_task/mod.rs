//! Secondary task of the driver. In: the scenario's settings, and the pressed button once a tick. Out: events, and the [`TaskDisplay`] that the
//! driver sees. A task runs on ticks and draws from random streams of its own, so that a replay with the recorded buttons repeats it.
//!
//! * [`detection_response`]: a red signal every few seconds. * [`n_back`]: digits to be kept in mind. * [`search`]: a larger circle among many.
//! * [`occlusion`]: a shutter before the picture. * [`step`]: input and output of a task in one tick.

mod detection_response;
mod n_back;
mod occlusion;
mod search;
mod step;
#[cfg(test)]
mod tests;

use super::Event;
use crate::{
    controls::TaskButton,
    scenario::{Scenario, SecondaryTaskKind},
    snapshot::TaskDisplay,
    time::Tick,
};
use detection_response::DetectionResponse;
use n_back::NBack;
use occlusion::Occlusion;
use search::Search;
use step::TaskStep;

/// Secondary task in progress.
#[derive(Clone, Debug)]
pub(super) struct TaskRun {
    task: Task,
    display: TaskDisplay,
}

#[derive(Clone, Debug)]
enum Task {
    DetectionResponse(DetectionResponse),
    NBack(NBack),
    Search(Search),
    Occlusion(Occlusion),
}

impl TaskRun {
    /// Returns the task of a drive; `None` if it has none.
    pub fn new(scenario: &Scenario) -> Option<Self> {
        let (settings, seed) = (&scenario.secondary_task, scenario.seed);
        let task = match settings.kind {
            SecondaryTaskKind::None => return None,
            SecondaryTaskKind::DetectionResponse => Task::DetectionResponse(DetectionResponse::new(seed)),
            SecondaryTaskKind::NBack => Task::NBack(NBack::new(settings, seed)),
            SecondaryTaskKind::SurrogateReference => Task::Search(Search::new(settings, seed)),
            SecondaryTaskKind::Occlusion => Task::Occlusion(Occlusion::new(settings)),
        };
        Some(Self { task, display: TaskDisplay::default() })
    }

    /// Advances to a tick with the button that was pressed since the tick before. Returns what the driver sees from now on.
    pub fn tick(&mut self, tick: Tick, button: TaskButton, events: &mut Vec<Event>) -> TaskDisplay {
        let mut step = TaskStep { tick, button, display: &mut self.display, events };
        match &mut self.task {
            Task::DetectionResponse(task) => task.tick(&mut step),
            Task::NBack(task) => task.tick(&mut step),
            Task::Search(task) => task.tick(&mut step),
            Task::Occlusion(task) => task.tick(&mut step),
        }
        self.display
    }
}
