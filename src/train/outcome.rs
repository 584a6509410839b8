//! Results of holds on the rings of training. In: nothing. Out: an [`Outcome`] for each advised vehicle, in m/s, with its last observation.

use crate::policy::Observation;

/// Ending of a hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The episode continues after the hold.
    None,
    /// The episode reached its horizon; the traffic itself would continue.
    Horizon,
    /// Two vehicles collided, and the episode is over.
    Crash,
}

/// Result of one hold for one advised vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Mean reward over the steps, m/s, after penalties.
    pub reward: f32,
    /// Mean speed of all vehicles over the steps, m/s.
    pub mean_mps: f32,
    /// Ending of the hold.
    pub ending: Ending,
    /// Next observation of the vehicle; of an episode that has just ended, its final observation.
    pub last_seen: Observation,
    /// Whole state of the ring at `last_seen`.
    pub last_state: WholeState,
}

/// Number of entries of [`WholeState`].
pub const STATE_NUMBERS: usize = 10;

/// Inputs of the value network beyond the policy's inputs, each about -1 to 1.
pub type WholeState = [f32; STATE_NUMBERS];
