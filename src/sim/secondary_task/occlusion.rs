//! Occlusion: a shutter before the picture opens and closes at fixed times, or opens on a press (docs/references.md: secondary-tasks). In: button
//! presses. Out: movements of the shutter.

use super::step::{TaskStep, ticks};
use crate::{scenario::SecondaryTask, sim::EventKind, snapshot::TaskPicture, time::Tick};

/// Occlusion of a drive, in progress.
#[derive(Clone, Debug)]
pub(super) struct Occlusion {
    open: u64,
    /// Time for which the shutter is closed, ticks; `None` if it opens on a press.
    closed: Option<u64>,
    /// Last movement, and true if the shutter is open since then; `None` at the start.
    since: Option<(Tick, bool)>,
}

impl Occlusion {
    pub fn new(settings: &SecondaryTask) -> Self {
        let closed = (!settings.self_paced).then(|| ticks(settings.closed_s));
        Self { open: ticks(settings.open_s), closed, since: None }
    }

    pub fn tick(&mut self, step: &mut TaskStep<'_>) {
        let is_over = |since: Tick, ticks: u64| step.tick.0 - since.0 >= ticks;
        let moves_to = match (self.since, self.closed) {
            (None, _) => true,
            (Some((since, true)), _) if is_over(since, self.open) => false,
            (Some((since, false)), Some(closed)) if is_over(since, closed) => true,
            (Some((_, false)), None) if step.is_pressed() => true,
            _ => return,
        };
        self.since = Some((step.tick, moves_to));
        step.note(EventKind::Shutter(moves_to));
        let closed = TaskPicture::Closed { opens_on_press: self.closed.is_none() };
        step.show(if moves_to { TaskPicture::None } else { closed });
    }
}
