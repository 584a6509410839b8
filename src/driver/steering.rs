//! Steering of a simulated driver. In: the lane ahead as the car sees it. Out: the angle of the steering wheel. Pure pursuit
//! (Coulter 1992): the rear axle is led on an arc through a point of the lane ahead; arms that lag and cannot turn faster
//! than arms do.

use super::{DriverParams, LaneView};
use crate::{
    controls::{STEERING_LOCK_RAD, STEERING_RATIO},
    ego::CarParams,
    time::TICK_S,
};
use glam::{DVec2, dvec2};

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

/// The wheel is turned in time for where it has to be so much later, s: into street corners, which take more than arms can do in the first of
/// them. In wider bends it is always in time.
pub const TURN_IN_S: [f64; 3] = [0.4, 0.7, 1.0];

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

/// Curvature of the arc from the rear axle, along the car, to a point in its axes, 1/m.
pub(super) fn arc_per_m(aim: DVec2) -> f64 {
    2.0 * aim.y / aim.length_squared().max(1.0)
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
        // Nobody turns the wheel of a standing car to and fro.
        let rate_rad_s = params.wheel_rad_s * (speed_mps.abs() / 0.5).min(1.0);
        let held_rad = self.wheel_rad.unwrap_or(wanted_rad);
        let step = ((wanted_rad - held_rad) * lag).clamp(-rate_rad_s * TICK_S, rate_rad_s * TICK_S);
        *self.wheel_rad.insert(held_rad + step) as f32
    }

    /// The wheel's angle for an arc, radians.
    fn wheel_rad_for(&self, curvature: f64, speed_mps: f64) -> f64 {
        let road_wheel_rad = (self.wheelbase_m * curvature).atan() + self.understeer * curvature * speed_mps.powi(2);
        let lock = f64::from(STEERING_LOCK_RAD);
        (road_wheel_rad * f64::from(STEERING_RATIO)).clamp(-lock, lock)
    }
}
