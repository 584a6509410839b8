//! Estimate of the torque of the participant's hands on a wheel. In: the torque that was sent to its motor, and its speed. Out: a torque, N m, positive
//! to the left.
//!
//! Wheels for games have no torque sensor. A disturbance observer computes the wheel's momentum from the motor's torque and a nominal friction; what is
//! missing comes from the hands. At rest the estimate is wrong by the wheel's dry friction at most, as friction and a hand cannot be told apart there. A
//! hand that only touches gives no torque, and is not noticed.

/// Inertia, kg m², and dry friction, N m, of a nominal wheel (docs/references.md: g29).
const INERTIA_KGM2: f64 = 0.05;
const FRICTION_NM: f64 = 0.15;
/// Speed at which the nominal friction is nearly full, rad/s.
const SLIDING_RADPS: f64 = 0.1;
/// Time constant of the estimate, s.
pub(super) const DELAY_S: f64 = 0.1;

/// Observer of one wheel, with the state of its filters.
#[derive(Clone, Debug, Default)]
pub(super) struct HandTorque {
    /// Torque of the motor behind the filter that the wheel's speed has, N m.
    motor_nm: f64,
    /// Momentum that all known torques and the estimate have given the wheel, N m s.
    momentum_nms: f64,
    hand_nm: f64,
}

impl HandTorque {
    /// Adds the time `dt_s` since the previous step, in which the motor was sent `motor_nm`. The speed is smoothed by this share in each step.
    pub fn step(&mut self, dt_s: f64, smoothed: f64, motor_nm: f64, wheel_radps: f64) {
        self.motor_nm += smoothed * (motor_nm - self.motor_nm);
        let friction_nm = FRICTION_NM * (wheel_radps / SLIDING_RADPS).tanh();
        self.momentum_nms += (self.motor_nm - friction_nm + self.hand_nm) * dt_s;
        self.hand_nm = (INERTIA_KGM2 * wheel_radps - self.momentum_nms) / DELAY_S;
    }

    /// Returns the estimate, N m.
    pub fn torque_nm(&self) -> f64 {
        self.hand_nm
    }
}

#[cfg(test)]
#[path = "hand_torque_tests.rs"]
mod tests;
