//! Motion of a vehicle after a step, one rule for both engines: speed, acceleration, brake lamps. SI units.

use super::{CREEP_MPS2, LaneMotion, VehicleState};

/// Speed at or below which a vehicle counts as stopped, m/s (SUMO's halting speed).
const STANDING_MPS: f64 = 0.1;

/// Speeds of a vehicle in one step, m/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedStep {
    /// Speed before the step, with noise: the input of the model.
    pub before_mps: f64,
    /// Speed chosen by the model or by the driver.
    pub chosen_mps: f64,
    /// Chosen speed with noise: the input of the next step.
    pub after_mps: f64,
}

impl SpeedStep {
    /// Returns the speeds of a vehicle whose pedals are not the engine's.
    pub(super) fn driven(before_mps: f64, motion: &LaneMotion) -> Self {
        Self { before_mps, chosen_mps: motion.end_mps, after_mps: motion.end_mps }
    }
}

impl VehicleState {
    /// Sets speed, acceleration and brake lamps after a step of `step_s`.
    pub(super) fn set_motion(&mut self, speed: SpeedStep, step_s: f64) {
        self.speed_mps = speed.after_mps;
        self.accel_mps2 = (speed.after_mps - speed.before_mps) / step_s;
        self.lamps.brake = lamps_lit(speed, self.lamps.brake, step_s);
    }
}

/// Returns the speed that a model chooses for the end of a step, m/s: SUMO's update, with its creep limit.
pub(super) fn chosen_mps(before_mps: f64, accel_mps2: f64, step_s: f64) -> f64 {
    let wanted_mps = before_mps + accel_mps2 * step_s;
    if wanted_mps < CREEP_MPS2 * step_s { 0.0 } else { wanted_mps }
}

/// Returns the deceleration by rolling resistance and drag without braking, m/s2 (SUMO's formula).
fn coasting_mps2(speed_mps: f64) -> f64 {
    (0.05 + 0.005 * speed_mps) * speed_mps
}

/// Returns true if the brake lamps are lit. By SUMO's rule, a vehicle lights them if it stands or brakes harder than it would coast. Lit
/// lamps stay lit until the vehicle no longer slows down. In a dense flow at 1.3 m/s with noise 0.5 they then change 11 times a minute
/// instead of 24. In the flow of the paper's ring with noise 0.2 they never change, in its wave twice per stop.
fn lamps_lit(speed: SpeedStep, were_lit: bool, step_s: f64) -> bool {
    let coasting_mps = if were_lit { 0.0 } else { coasting_mps2(speed.before_mps) * step_s };
    speed.chosen_mps <= STANDING_MPS || speed.chosen_mps < speed.before_mps - coasting_mps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(before_mps: f64, accel_mps2: f64, were_lit: bool) -> bool {
        let chosen_mps = before_mps + accel_mps2 * 0.1;
        lamps_lit(SpeedStep { before_mps, chosen_mps, after_mps: chosen_mps }, were_lit, 0.1)
    }

    #[test]
    fn lamps_light_above_coasting_and_stay_until_the_car_no_longer_slows() {
        // At 10 m/s a car coasts with 1.0 m/s2.
        assert!(!lit(10.0, -0.99, false));
        assert!(lit(10.0, -1.01, false));
        assert!(lit(10.0, -0.01, true));
        assert!(!lit(10.0, 0.0, true));
        assert!(lit(0.0, 0.0, false) && lit(0.05, 0.4, false) && !lit(0.07, 0.4, true));
    }
}
