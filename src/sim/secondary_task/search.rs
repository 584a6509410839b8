//! Surrogate reference task: one circle is larger than the others; the cursor is to be moved to its column and confirmed
//! (docs/references.md: secondary-tasks). In: buttons left, right and respond. Out: displays.

use super::step::TaskStep;
use crate::{
    controls::TaskButton,
    metrics::{TaskResponse, TaskStimulus},
    rng,
    scenario::SecondaryTask,
    snapshot::TaskPicture,
};

/// Upper limit of the seeds of displays: a number of double precision holds them exactly.
const MOST_SEED: usize = 1 << 53;

/// Surrogate reference task in progress.
#[derive(Clone, Debug)]
pub(super) struct Search {
    random: rng::Stream,
    columns: u8,
    size_ratio: f64,
    /// Seed of the display and column of its target; `None` before the first display.
    display: Option<(u64, u8)>,
    cursor: u8,
}

impl Search {
    pub fn new(settings: &SecondaryTask, seed: u64) -> Self {
        let SecondaryTask { columns, size_ratio, .. } = *settings;
        let random = rng::stream(seed, "secondary task/surrogate reference");
        Self { random, columns, size_ratio, display: None, cursor: 0 }
    }

    pub fn tick(&mut self, step: &mut TaskStep<'_>) {
        let last = self.columns - 1;
        match step.button {
            _ if self.display.is_none() => {}
            TaskButton::None => return,
            TaskButton::Left => self.cursor = self.cursor.saturating_sub(1),
            TaskButton::Right => self.cursor = (self.cursor + 1).min(last),
            TaskButton::Respond => {
                step.respond(TaskResponse::Column(self.cursor + 1));
                self.display = None;
            }
        }
        if let Some((seed, target_column)) = self.display {
            step.show(self.picture(seed, target_column));
            return;
        }
        let (seed, target_column) = (self.random.index(MOST_SEED) as u64, self.random.index(self.columns.into()) as u8);
        self.display = Some((seed, target_column));
        self.cursor = self.columns / 2;
        let stimulus = TaskStimulus::Display { target_column: target_column + 1 };
        step.present(stimulus, self.picture(seed, target_column));
    }

    fn picture(&self, seed: u64, target_column: u8) -> TaskPicture {
        let Self { columns, size_ratio, cursor, .. } = *self;
        TaskPicture::Search { seed, columns, target_column, cursor, size_ratio }
    }
}
