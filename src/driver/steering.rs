//! Steering of a simulated driver. In: the lane ahead as seen from the ego. Out: the angle of the steering wheel. Pure
//! pursuit (Coulter 1992): the rear axle follows an arc through a point of the lane ahead. The arms have a lag and a
//! limited rate.

use super::{DriverParams, LaneView};
use crate::{
    controls::{STEERING_LOCK_RAD, STEERING_RATIO},
    ego::CarParams,
    time::TICK_S,
};
use glam::{DVec2, dvec2};

/// Smallest distance of the target point, m: with a smaller one the ego would oscillate about the line at walking pace.
const NEAREST_M: f64 = 5.0;
/// Largest distance of the target point, m: with a larger one the arc would cut bends.
const FARTHEST_M: f64 = 30.0;
/// Gain of the slow correction of a steady offset, 1/m of curvature per metre and second.
const TRIM: f64 = 0.004;
/// Largest correction of a steady offset, 1/m.
const TRIM_MAX: f64 = 0.004;
/// Speed up to which the gain of the correction is [`TRIM`], m/s. The sideways motion due to a curvature grows with the
/// square of the speed, so the gain falls with that square above it. Otherwise the ego would oscillate about the line
/// until it left the road.
const TRIM_SPEED_MPS: f64 = 15.0;

/// Look-ahead times for street corners, s: the wheel turns early enough to have a corner's angle by then. A corner can
/// need more than the arms can turn within the first of them. In wider bends the wheel is always in time.
pub const TURN_IN_S: [f64; 3] = [0.4, 0.7, 1.0];

#[derive(Clone, Debug)]
pub(super) struct SteeringModel {
    wheelbase_m: f64,
    /// Understeer, rad per m/s² of lateral acceleration, for which the driver compensates.
    understeer: f64,
    /// Angle of the wheel; `None` before the first tick, in which the wheel already has the wanted angle.
    wheel_rad: Option<f64>,
    trim: f64,
}

/// Returns the distance of the target point ahead of the rear axle, m.
pub(super) fn preview_m(params: &DriverParams, speed_mps: f64) -> f64 {
    (speed_mps.abs() * params.preview_s).clamp(NEAREST_M, FARTHEST_M)
}

/// Returns the curvature of the arc from the rear axle to a point in the ego's axes, 1/m. The arc is tangent to the
/// ego's axis.
pub(super) fn arc_per_m(aim: DVec2) -> f64 {
    2.0 * aim.y / aim.length_squared().max(1.0)
}

impl SteeringModel {
    pub fn new(car: &CarParams) -> Self {
        let understeer = (1.0 / car.tyres.front_cornering - 1.0 / car.tyres.rear_cornering) / 9.81;
        Self { wheelbase_m: car.body.wheelbase_m, understeer, wheel_rad: None, trim: 0.0 }
    }

    /// Takes the steering wheel at this angle, rad, and returns it.
    pub fn hold(&mut self, wheel_rad: f32) -> f32 {
        self.wheel_rad = Some(wheel_rad.into());
        wheel_rad
    }

    /// Returns the steering wheel's angle in this tick, rad, positive to the left. `wander_m` shifts the line to drive.
    pub fn turn(&mut self, params: &DriverParams, speed_mps: f64, lane: &LaneView, wander_m: f64) -> f32 {
        let aim = lane.aim;
        let side_m = aim.y + wander_m;
        let pursuit = arc_per_m(dvec2(aim.x, side_m));
        if speed_mps > 1.0 {
            let gain = TRIM * (TRIM_SPEED_MPS / speed_mps).min(1.0).powi(2);
            self.trim = (self.trim - gain * (lane.offset_m - wander_m) * TICK_S).clamp(-TRIM_MAX, TRIM_MAX);
        }
        let curvature = pursuit + self.trim;
        let at_once_rad = self.wheel_rad_for(curvature, speed_mps);
        let wanted_rad =
            lane.next_corners_per_m.iter().zip(TURN_IN_S).fold(at_once_rad, |most_rad: f64, (corner, after_s)| {
                let then_rad = self.wheel_rad_for(*corner, speed_mps);
                let by_now_rad = (then_rad.abs() - params.wheel_rad_s * after_s).max(0.0).copysign(then_rad);
                if by_now_rad.abs() > most_rad.abs() { by_now_rad } else { most_rad }
            });
        debug_assert!(wanted_rad.is_finite(), "the lane ahead is {lane:?}");
        let lag = if params.arm_s > 0.0 { (TICK_S / params.arm_s).min(1.0) } else { 1.0 };
        // Drivers do not turn the wheel back and forth at a standstill.
        let rate_rad_s = params.wheel_rad_s * (speed_mps.abs() / 0.5).min(1.0);
        let held_rad = self.wheel_rad.unwrap_or(wanted_rad);
        let step = ((wanted_rad - held_rad) * lag).clamp(-rate_rad_s * TICK_S, rate_rad_s * TICK_S);
        *self.wheel_rad.insert(held_rad + step) as f32
    }

    /// Returns the steering wheel's angle for an arc, rad.
    fn wheel_rad_for(&self, curvature: f64, speed_mps: f64) -> f64 {
        let road_wheel_rad = (self.wheelbase_m * curvature).atan() + self.understeer * curvature * speed_mps.powi(2);
        let lock = f64::from(STEERING_LOCK_RAD);
        (road_wheel_rad * f64::from(STEERING_RATIO)).clamp(-lock, lock)
    }
}
