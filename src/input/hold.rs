//! Position controller that turns a wheel with that of the automation. In: the automation's angle, and angle and speed of the wheel. Out: a torque,
//! N m, positive to the left, and its share of the force.
//!
//! A spring and a damper pull the wheel to the automation's angle, which changes once a picture and is smoothed. A wheel with dry friction stays up to
//! this friction over [`STIFFNESS_NM`] away. The gains are chosen with the model of a wheel in the tests (docs/references.md: automation).

/// Spring between the automation's angle and the wheel, N m/rad.
pub(super) const STIFFNESS_NM: f64 = 8.0;
/// Damper between both, N m s/rad: a damping ratio of about 0.8 on a wheel of 0.05 kg m².
const DAMPING_NMS: f64 = 1.0;
/// Time constant of each of the two filters of the automation's angle, s.
const FOLLOW_S: f64 = 0.020;
/// Time in which the controller takes over the force, and in which it leaves it, s.
const TAKE_S: f64 = 0.4;
const LEAVE_S: f64 = 0.2;

/// Controller of one wheel, with the state of its filters.
#[derive(Clone, Debug, Default)]
pub(super) struct WheelHold {
    /// Angle of the automation behind each filter, rad.
    angles_rad: [f64; 2],
    share: f64,
}

impl WheelHold {
    /// Returns torque and share `dt_s` after the previous step. `held_rad` is the automation's angle, `None` while the participant steers.
    pub fn step(&mut self, dt_s: f64, held_rad: Option<f64>, wheel_rad: f64, wheel_radps: f64) -> (f64, f64) {
        if self.share <= 0.0 {
            self.angles_rad = [wheel_rad; 2];
        }
        let step = if held_rad.is_some() { dt_s / TAKE_S } else { -dt_s / LEAVE_S };
        self.share = (self.share + step).clamp(0.0, 1.0);
        let smoothed = 1.0 - (-dt_s / FOLLOW_S).exp();
        let [first_rad, second_rad] = &mut self.angles_rad;
        *first_rad += smoothed * (held_rad.unwrap_or(*first_rad) - *first_rad);
        *second_rad += smoothed * (*first_rad - *second_rad);
        let radps = (*first_rad - *second_rad) / FOLLOW_S;
        // The lead makes up for the delay of both filters, so that a wheel that turns evenly is not late.
        let ahead_rad = *second_rad + 2.0 * FOLLOW_S * radps;
        (STIFFNESS_NM * (ahead_rad - wheel_rad) + DAMPING_NMS * (radps - wheel_radps), self.share)
    }
}

#[cfg(test)]
#[path = "hold_tests.rs"]
mod tests;
