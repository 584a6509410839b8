//! Detection response task with a signal on the screen (docs/references.md: secondary-tasks). In: button presses. Out: signals.

use super::step::{TaskStep, ticks};
use crate::{
    metrics::{FIRST_HIT_S, TaskResponse, TaskStimulus},
    rng,
    snapshot::TaskPicture,
    time::Tick,
};

/// Shortest and longest time from one onset to the next, s.
const ONSETS_S: [f64; 2] = [3.0, 5.0];
/// Longest time for which a signal is on, s.
const SIGNAL_S: f64 = 1.0;

/// Detection response task in progress.
#[derive(Clone, Debug)]
pub(super) struct DetectionResponse {
    random: rng::Stream,
    next: Tick,
    /// Onset of the signal that is on.
    since: Option<Tick>,
}

impl DetectionResponse {
    pub fn new(seed: u64) -> Self {
        let mut random = rng::stream(seed, "secondary task/detection response");
        let next = Tick(interval(&mut random));
        Self { random, next, since: None }
    }

    pub fn tick(&mut self, step: &mut TaskStep<'_>) {
        let lit = self.since.map(|since| step.tick.0 - since.0);
        if step.is_pressed() {
            step.respond(TaskResponse::Button);
        }
        // A press that is too early to be caused by the signal leaves it on.
        let is_answered = step.is_pressed() && lit >= Some(ticks(FIRST_HIT_S));
        if self.since.is_some() && (is_answered || lit >= Some(ticks(SIGNAL_S))) {
            self.since = None;
            step.show(TaskPicture::None);
        }
        if step.tick >= self.next {
            self.since = Some(step.tick);
            self.next = Tick(step.tick.0 + interval(&mut self.random));
            step.present(TaskStimulus::Signal, TaskPicture::Signal);
        }
    }
}

/// Draws the time to the next onset, ticks.
fn interval(random: &mut rng::Stream) -> u64 {
    ticks(random.uniform(ONSETS_S[0], ONSETS_S[1]))
}
