//! Model of a wheel with force feedback, for tests. In: the torques of motor and hand each millisecond. Out: the wheel's angle.
//!
//! A rigid rim with Coulomb friction: it rests while the torques are below its friction. The motor's torque comes late.

use super::force::ForceModel;
use std::{collections::VecDeque, f64::consts::PI};

/// Inertia of a G29's rim with its geared motors, kg m², and its dry friction, N m: orders of magnitude, not measured (docs/references.md: g29).
const G29_KGM2: f64 = 0.05;
const G29_NM: f64 = 0.15;
/// Step of the model, s.
pub const STEP_S: f64 = 1e-3;
/// Counts of a G29's sensor per radian.
pub const COUNTS_PER_RAD: f64 = 65_536.0 / (5.0 * PI);

/// Wheel on a desk.
#[derive(Clone, Debug)]
pub struct SimulatedWheel {
    pub inertia_kgm2: f64,
    pub friction_nm: f64,
    /// Time from a torque that is sent to one that acts, ms.
    pub delay_ms: usize,
    pub angle_rad: f64,
    radps: f64,
    /// Motor torques that are on their way, N m, oldest first.
    sent_nm: VecDeque<f64>,
}

impl SimulatedWheel {
    /// Returns a G29 at rest at this angle, rad, whose torque comes 6 ms late.
    pub fn g29(angle_rad: f64) -> Self {
        let (inertia_kgm2, friction_nm, sent_nm) = (G29_KGM2, G29_NM, VecDeque::new());
        Self { inertia_kgm2, friction_nm, delay_ms: 6, angle_rad, radps: 0.0, sent_nm }
    }

    /// Returns wheels of 0.03 to 0.07 kg m², with a friction of 0.05 to 0.25 N m and torques that come at once to 14 ms late: one period
    /// of the thread and the 8 ms of the wheel's own driver.
    pub fn of_all_kinds() -> Vec<Self> {
        let mut wheels = Vec::new();
        for inertia_kgm2 in [0.03, G29_KGM2, 0.07] {
            for friction_nm in [0.05, G29_NM, 0.25] {
                let of = |delay_ms| Self { inertia_kgm2, friction_nm, delay_ms, ..Self::g29(0.0) };
                wheels.extend([0, 6, 14].map(of));
            }
        }
        wheels
    }

    /// Returns the angle as the sensor reports it, rad.
    pub fn seen_rad(&self) -> f64 {
        (self.angle_rad * COUNTS_PER_RAD).round() / COUNTS_PER_RAD
    }

    /// Returns the torque that a device of 2.1 N m makes of a model's torque, N m.
    pub fn made_nm(model: &ForceModel, torque_nm: f64) -> f64 {
        -f64::from(model.level(torque_nm, true)) / 32_767.0 * 2.1
    }

    /// Moves the wheel by one millisecond, in which the motor is sent a torque and a hand gives one, N m.
    pub fn step(&mut self, motor_nm: f64, hand_nm: f64) {
        self.sent_nm.push_back(motor_nm);
        let made_nm = if self.sent_nm.len() > self.delay_ms { self.sent_nm.pop_front() } else { None };
        let torque_nm = made_nm.unwrap_or(0.0) + hand_nm;
        let slides_to = if self.radps == 0.0 { torque_nm } else { self.radps };
        if self.radps == 0.0 && torque_nm.abs() <= self.friction_nm {
            return;
        }
        let radps = self.radps + (torque_nm - self.friction_nm.copysign(slides_to)) / self.inertia_kgm2 * STEP_S;
        self.radps = if radps * slides_to < 0.0 { 0.0 } else { radps };
        self.angle_rad += self.radps * STEP_S;
    }
}
