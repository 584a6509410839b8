//! n-back task: digits at a constant interval, in blocks of ten (docs/references.md: secondary-tasks). In: button presses. Out: digits.
//!
//! With a button, about a third of the digits that can match do so. With spoken responses each block has each digit once, as in the delayed digit
//! recall task.

use super::step::{TaskStep, ticks};
use crate::{
    metrics::{TaskResponse, TaskStimulus},
    rng,
    scenario::SecondaryTask,
    snapshot::TaskPicture,
    time::Tick,
};

/// Number of digits in a block.
const BLOCK: usize = 10;
/// Time from the start of the drive to the first digit, s.
const START_S: f64 = 5.0;
/// Longest time for which a digit is shown, s.
const SHOWN_S: f64 = 1.0;
/// Probability of a match.
const MATCHES: f64 = 1.0 / 3.0;
/// Digit at which the button is pressed in the 0-back task.
const TARGET: u8 = 0;

/// State of an n-back task in progress.
#[derive(Clone, Debug)]
pub(super) struct NBack {
    random: rng::Stream,
    n: u8,
    spoken_response: bool,
    interval: u64,
    pause: u64,
    next: Tick,
    /// Onset of the digit that is shown.
    since: Option<Tick>,
    /// Digits of the block so far.
    block: Vec<u8>,
    /// Order of the digits of a block with spoken responses.
    order: Vec<usize>,
}

impl NBack {
    pub fn new(settings: &SecondaryTask, seed: u64) -> Self {
        Self {
            random: rng::stream(seed, "secondary task/n-back"),
            n: settings.n,
            spoken_response: settings.spoken_response,
            interval: ticks(settings.digit_interval_s),
            pause: ticks(settings.block_pause_s),
            next: Tick(ticks(START_S)),
            since: None,
            block: Vec::new(),
            order: Vec::new(),
        }
    }

    pub fn tick(&mut self, step: &mut TaskStep<'_>) {
        if step.is_pressed() {
            step.respond(TaskResponse::Button);
        }
        if self.since.is_some_and(|since| step.tick.0 - since.0 >= ticks(SHOWN_S).min(self.interval)) {
            self.since = None;
            step.show(TaskPicture::None);
        }
        if step.tick < self.next {
            return;
        }
        if self.block.len() == BLOCK {
            self.block.clear();
        }
        let (digit, is_match) = self.draw();
        self.block.push(digit);
        self.since = Some(step.tick);
        let pause = if self.block.len() == BLOCK { self.pause } else { 0 };
        self.next = Tick(step.tick.0 + self.interval + pause);
        step.present(TaskStimulus::Digit { digit, is_match }, TaskPicture::Digit { digit, n: self.n, is_match });
    }

    /// Draws the next digit; true if it asks for a press.
    fn draw(&mut self) -> (u8, Option<bool>) {
        if self.spoken_response {
            if self.block.is_empty() {
                self.order = self.random.permutation(BLOCK);
            }
            return (self.order[self.block.len()] as u8, None);
        }
        let before = match self.n {
            0 => Some(TARGET),
            n => self.block.len().checked_sub(n.into()).map(|at| self.block[at]),
        };
        let Some(before) = before else { return (self.random.index(BLOCK) as u8, None) };
        let is_match = self.random.uniform(0.0, 1.0) < MATCHES;
        // One of the nine others, each as often.
        let other = (usize::from(before) + 1 + self.random.index(BLOCK - 1)) % BLOCK;
        (if is_match { before } else { other as u8 }, Some(is_match))
    }
}
