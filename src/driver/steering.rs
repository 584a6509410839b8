//! Steering of a simulated driver. In: the lane ahead as the car sees it. Out: the angle of the steering wheel. Pure pursuit
//! (Coulter 1992): the rear axle is led on an arc through a point of the lane ahead; arms that lag and cannot turn faster
//! than arms do.

use super::{DriverParams, LaneView};
use crate::{
    controls::{STEERING_LOCK_RAD, STEERING_RATIO},
    ego::CarParams,
    time::TICK_S,
};

/// Nearest point that the eyes aim at, metres: nearer, the car would swing about the line at walking pace.
const NEAREST_M: f64 = 5.0;
/// Farthest point, metres; farther, the arc would cut bends.
const FARTHEST_M: f64 = 30.0;
/// Slow correction of a steady offset, 1/m of curvature per metre and second.
const TRIM: f64 = 0.004;
/// Largest such correction, 1/m.
const TRIM_MAX: f64 = 0.004;
/// Up to this speed the correction is as quick as [`TRIM`] says, m/s. A curvature moves the car sideways by the square of its speed: a
/// faster one is corrected as much slower, or it would swing about the line until it leaves the road.
const TRIM_SPEED_MPS: f64 = 15.0;

#[derive(Clone, Debug)]
pub(super) struct SteeringModel {
    wheelbase_m: f64,
    /// Understeer, rad per m/s2 of lateral acceleration: a driver knows his car.
    understeer: f64,
    /// `None` before the first tick: the hands find the wheel where it has to be.
    wheel_rad: Option<f64>,
    trim: f64,
}

/// Distance of the point aimed at, metres ahead of the rear axle.
pub(super) fn preview_m(params: &DriverParams, speed_mps: f64) -> f64 {
    (speed_mps.abs() * params.preview_s).clamp(NEAREST_M, FARTHEST_M)
}

impl SteeringModel {
    pub fn new(car: &CarParams) -> Self {
        let understeer = (1.0 / car.tyres.front_cornering - 1.0 / car.tyres.rear_cornering) / 9.81;
        Self { wheelbase_m: car.body.wheelbase_m, understeer, wheel_rad: None, trim: 0.0 }
    }

    /// The steering wheel's angle in this tick, radians, positive to the left. `wander_m` shifts the line to drive.
    pub fn turn(&mut self, params: &DriverParams, speed_mps: f64, lane: &LaneView, wander_m: f64) -> f32 {
        let aim = lane.aim;
        let side_m = aim.y + wander_m;
        let pursuit = 2.0 * side_m / (aim.x * aim.x + side_m * side_m).max(1.0);
        if speed_mps > 1.0 {
            let gain = TRIM * (TRIM_SPEED_MPS / speed_mps).min(1.0).powi(2);
            self.trim = (self.trim - gain * (lane.offset_m - wander_m) * TICK_S).clamp(-TRIM_MAX, TRIM_MAX);
        }
        let curvature = pursuit + self.trim;
        let road_wheel_rad = (self.wheelbase_m * curvature).atan() + self.understeer * curvature * speed_mps.powi(2);
        let lock = f64::from(STEERING_LOCK_RAD);
        let wanted_rad = (road_wheel_rad * f64::from(STEERING_RATIO)).clamp(-lock, lock);
        debug_assert!(wanted_rad.is_finite(), "the lane ahead is {lane:?}");
        let lag = if params.arm_s > 0.0 { (TICK_S / params.arm_s).min(1.0) } else { 1.0 };
        // Nobody turns the wheel of a standing car to and fro.
        let rate_rad_s = params.wheel_rad_s * (speed_mps.abs() / 0.5).min(1.0);
        let held_rad = self.wheel_rad.unwrap_or(wanted_rad);
        let step = ((wanted_rad - held_rad) * lag).clamp(-rate_rad_s * TICK_S, rate_rad_s * TICK_S);
        *self.wheel_rad.insert(held_rad + step) as f32
    }
}
