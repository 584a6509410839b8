//! Turns of the steering wheel by the participant while the system steers. In: the participant's wheel and the system's, once a tick. Out: true for a
//! turn by hand.
//!
//! The participant's wheel may rest, as one without a motor does, or turn with the system's. A turn by hand both moves the wheel and leads it away from
//! the system's angle. A hand that holds a wheel against its motor does not move it: its torque tells it, where the wheel has force feedback.

use std::collections::VecDeque;

/// Time over which a turn is judged: half a second of ticks. Slower turns are not told from those of the system.
const JUDGED_TICKS: usize = 50;

/// Steering wheels of the last moments.
#[derive(Clone, Debug, Default)]
pub(super) struct WheelTurns {
    /// Angles of the participant's wheel and their differences from the system's, rad, oldest first.
    moments: VecDeque<[f64; 2]>,
}

impl WheelTurns {
    /// Adds the angles of a tick, rad.
    pub fn add(&mut self, given_rad: f32, driven_rad: f32) {
        if self.moments.len() > JUDGED_TICKS {
            self.moments.pop_front();
        }
        let given_rad = f64::from(given_rad);
        self.moments.push_back([given_rad, given_rad - f64::from(driven_rad)]);
    }

    /// Returns true if the participant has turned the wheel by this angle, rad, away from the system's.
    pub fn is_by_hand(&self, least_rad: f64) -> bool {
        let Some(now) = self.moments.back() else { return false };
        let most = |by: &dyn Fn(&[f64; 2]) -> f64| self.moments.iter().map(by).fold(0.0, f64::max);
        let moved_rad = most(&|before| (now[0] - before[0]).abs());
        let away_rad = most(&|before| now[1].abs() - before[1].abs());
        moved_rad >= least_rad && away_rad >= least_rad
    }
}
