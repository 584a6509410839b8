//! Checkpoints of a training. In: a [`Learner`]. Out: its state as text, from which it continues with the same bits on any machine. The clock
//! says when a checkpoint is written and changes nothing in it.

use super::Learner;
use std::time::{Duration, Instant};

/// Wall time between checkpoints.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(60);
/// Maximum size of a checkpoint, bytes: a hundred times that of the shipped configuration.
pub const CHECKPOINT_BYTES: u64 = 64 << 20;

impl Learner {
    /// Returns the state of the training as text.
    ///
    /// # Errors
    /// The state cannot be written as JSON.
    pub fn to_checkpoint(&self) -> Result<String, String> {
        serde_json::to_string(self).map_err(|why| why.to_string())
    }

    /// Returns the training of a checkpoint.
    ///
    /// # Errors
    /// The text is not a checkpoint of this version of the program.
    pub fn from_checkpoint(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|why| format!("not a checkpoint of this version: {why}"))
    }
}

/// Clock of the checkpoints of one training: the first is due at once, each of the others a minute after the one before.
#[derive(Debug, Default)]
pub struct CheckpointClock {
    last: Option<Instant>,
}

impl CheckpointClock {
    /// Returns true if a checkpoint is due, which then counts as written.
    #[allow(
        clippy::disallowed_methods,
        reason = "checkpoints are written by the clock on the wall, and no training knows of it"
    )]
    pub fn is_due(&mut self) -> bool {
        let now = Instant::now();
        let is_due = self.last.is_none_or(|last| now.duration_since(last) >= CHECKPOINT_EVERY);
        if is_due {
            self.last = Some(now);
        }
        is_due
    }
}
