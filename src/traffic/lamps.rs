//! When a car of the traffic lights its brake lamps: one rule for both engines. In: its speed before a step and the
//! acceleration that its model chose for it (noise left out). Out: lit or dark. SI units.

/// Below this speed a car counts as standing, m/s (SUMO's halting speed).
const STANDING_MPS: f64 = 0.1;

/// Deceleration that rolling resistance and drag give without a foot on the brake, m/s2 (SUMO's figure).
fn coasting_mps2(speed_mps: f64) -> f64 {
    (0.05 + 0.005 * speed_mps) * speed_mps
}

/// True if the lamps are lit: the car brakes harder than it would coast, or stands.
pub(super) fn lit(speed_mps: f64, accel_mps2: f64, step_s: f64) -> bool {
    speed_mps + accel_mps2 * step_s <= STANDING_MPS || accel_mps2 < -coasting_mps2(speed_mps)
}
