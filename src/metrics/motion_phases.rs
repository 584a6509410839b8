//! Stops and hard brakings of a vehicle. In: its speed, step by step, m/s. Out: the start and duration of each. The evaluation
//! of policies and the analysis of recorded drives share these rules.

/// Deceleration above which a vehicle brakes hard, m/s2.
pub const HARD_MPS2: f32 = 3.0;
/// Speeds below which a vehicle stops, and from which on it moves again, m/s.
pub const STOPPED_MPS: [f32; 2] = [0.1, 1.0];

/// Current state of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionPhase {
    before_mps: f32,
    /// True while braking harder than [`HARD_MPS2`].
    pub is_hard: bool,
    /// True at a standstill, or while creeping after a stop.
    pub is_standing: bool,
}

/// Episodes that began in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Begun {
    /// True if a hard braking began.
    pub hard: bool,
    /// True if a stop began.
    pub stop: bool,
}

impl MotionPhase {
    /// Starts with a vehicle at this speed; a vehicle that stands at first has not stopped.
    pub fn new(speed_mps: f32) -> Self {
        Self { before_mps: speed_mps, is_hard: false, is_standing: speed_mps < STOPPED_MPS[0] }
    }

    /// Returns the speed at the last step, m/s.
    pub fn before_mps(&self) -> f32 {
        self.before_mps
    }

    /// Adds the speed at the next step of `step_s`.
    #[inline]
    pub fn add(&mut self, speed_mps: f32, step_s: f32) -> Begun {
        let is_hard = self.before_mps - speed_mps > HARD_MPS2 * step_s;
        let hard = is_hard && !self.is_hard;
        self.is_hard = is_hard;
        let stop = !self.is_standing && speed_mps < STOPPED_MPS[0];
        self.is_standing = if self.is_standing { speed_mps < STOPPED_MPS[1] } else { stop };
        self.before_mps = speed_mps;
        Begun { hard, stop }
    }
}
