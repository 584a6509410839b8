//! What a step did to a car's motion, one rule for both engines: speed, acceleration, brake lamps. SI units.

use super::CarState;

/// Below this speed a car counts as standing, m/s (SUMO's halting speed).
const STANDING_MPS: f64 = 0.1;

/// One step of a car's speed, m/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedStep {
    /// Before the step, with its noise: what the model started from.
    pub before_mps: f64,
    /// What the model, or the driver, made of it.
    pub chosen_mps: f64,
    /// The same with noise: what the next step starts from.
    pub after_mps: f64,
}

impl CarState {
    /// Sets speed, acceleration and lamps after a step of `step_s`.
    pub(super) fn set_motion(&mut self, speed: SpeedStep, step_s: f64) {
        self.speed_mps = speed.after_mps;
        self.accel_mps2 = (speed.after_mps - speed.before_mps) / step_s;
        self.braking = lamps_lit(speed, step_s);
    }
}

/// Deceleration that rolling resistance and drag give without a foot on the brake, m/s2 (SUMO's figure).
fn coasting_mps2(speed_mps: f64) -> f64 {
    (0.05 + 0.005 * speed_mps) * speed_mps
}

/// SUMO's rule: a car lights its lamps if it stands or brakes harder than it would coast. What counts is what the model
/// chose: noise is no foot on the brake.
fn lamps_lit(speed: SpeedStep, step_s: f64) -> bool {
    let free_mps = speed.before_mps - coasting_mps2(speed.before_mps) * step_s;
    speed.chosen_mps <= STANDING_MPS || speed.chosen_mps < free_mps
}
