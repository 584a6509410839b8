//! Body of a light agent: pedals, engine and brakes along a lane. In: the parameters of a car, its start. Out: its state at a place, and its
//! motion in a step. Metres, m/s.

use super::traffic_start::StartPlace;
use crate::{
    ego::{CarParams, Contact, EgoError, EgoState, LongitudinalCar},
    space::Pose,
    traffic::LaneMotion,
};
use glam::{Quat, Vec3};

/// Body of a light agent.
pub(super) struct LightBody {
    pub car: LongitudinalCar,
    /// Motion in the present step; `None` if the vehicle is not on a road.
    pub motion: Option<LaneMotion>,
    /// First contact with the leader in the present step.
    pub touch: Option<Contact>,
}

impl LightBody {
    pub fn new(params: &CarParams, start: StartPlace) -> Result<Self, EgoError> {
        let car = LongitudinalCar::new(params, start.speed_mps)?;
        Ok(Self { car, motion: None, touch: None })
    }

    /// Returns the state of the vehicle at this place.
    pub fn state(&self, pose: Pose, height_m: f64) -> EgoState {
        let forward = pose.forward();
        let (gear, rpm) = self.car.gear_and_rpm();
        let speed_mps = self.car.speed_mps();
        EgoState {
            position: pose.position.extend(height_m),
            rotation: Quat::from_rotation_z(pose.yaw_rad as f32),
            velocity: Vec3::new(forward.x as f32, forward.y as f32, 0.0) * speed_mps as f32,
            speed_mps,
            accel_mps2: self.car.accel_mps2(),
            gear,
            engine_rpm: rpm as f32,
            braking: self.car.is_braking(),
            ..EgoState::default()
        }
    }
}
