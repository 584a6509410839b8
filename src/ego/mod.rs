//! The participant's vehicle. In: [`Controls`](crate::controls::Controls) once a tick, the ground under the wheels, the
//! other vehicles as kinematic bodies. Out: [`EgoState`] and [`Contact`]s. Only this module uses rapier.
//!
//! One [`EgoCar::tick`] is four sub-steps of 2.5 ms: springs (rapier's ray-cast vehicle), engine and gearbox
//! (`powertrain`), brakes and tyres (`tyre`), then rapier moves and collides the body (`body`).

mod body;
mod car;
mod disturbance;
mod longitudinal;
mod params;
mod powertrain;
mod table;
mod tyre;
mod wet_road;

pub use car::EgoCar;
pub use disturbance::Disturbance;
pub use longitudinal::LongitudinalCar;
pub use params::{
    BodyParams, BrakeParams, CarParams, EgoError, EngineParams, GearboxParams, SteeringParams, SuspensionParams,
    TyreParams,
};
pub use wet_road::water_mm;

use crate::space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, is_one_road};
use glam::{DVec2, DVec3, EulerRot, Quat, Vec3};

/// Ground surface under a wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum GroundSurface {
    /// Asphalt, as on all roads.
    #[default]
    Asphalt,
    /// Meadow, with less grip and more rolling resistance.
    Grass,
}

/// State of a wheel. Arrays of wheels have the order front left, front right, rear left, rear right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelPose {
    /// Hub in the body's frame (x forward, y left, z up from the body's origin), m, suspension included.
    pub hub: Vec3,
    /// Road wheel angle, rad, positive to the left.
    pub steer_rad: f32,
    /// Rolled angle, rad, increasing forwards.
    pub spin_rad: f32,
    /// Suspension compression from the rest length, m.
    pub compression_m: f32,
    /// Ground surface under the wheel.
    pub surface: GroundSurface,
}

/// State of the ego after a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EgoState {
    /// Centre of the ego on the ground (z is the ground's height at rest), world axes, m.
    pub position: DVec3,
    /// Rotation from body axes (x forward, y left, z up) to world axes.
    pub rotation: Quat,
    /// Velocity in world axes, m/s.
    pub velocity: Vec3,
    /// Longitudinal speed, m/s, negative in reverse.
    pub speed_mps: f64,
    /// Longitudinal acceleration, m/s².
    pub accel_mps2: f64,
    /// Lateral acceleration, m/s², positive to the left.
    pub lateral_accel_mps2: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate: f64,
    /// Gear: -1 reverse, 0 neutral, 1 and up forwards.
    pub gear: i8,
    /// Engine speed, 1/min.
    pub engine_rpm: f32,
    /// Angle of the steering wheel, rad; positive to the left.
    pub steering_wheel_rad: f32,
    /// Self-aligning torque at the steering wheel, N m; positive turns it to the left.
    pub steering_torque_nm: f32,
    /// True while the brake lamps are lit.
    pub braking: bool,
    /// Wheels in the order front left, front right, rear left, rear right.
    pub wheels: [WheelPose; 4],
}

impl EgoState {
    /// Returns position and heading of the ego's centre on the ground plane.
    pub fn pose(&self) -> Pose {
        let (yaw, _, _) = self.rotation.to_euler(EulerRot::ZYX);
        Pose::new(self.position.truncate(), f64::from(yaw))
    }
}

/// Identity of what the ego can touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ObstacleId {
    /// Identifier of another vehicle.
    Vehicle(u32),
    /// Number of a fixed object, such as a wall.
    FixedObject(u32),
}

/// Other vehicle, or fixed object, that the ego can touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    pub id: ObstacleId,
    /// Part of an articulated vehicle, from 0 at the front; identifier and part are unique among the obstacles.
    pub part: u8,
    /// Pose of the part's centre at the end of this tick.
    pub pose: Pose,
    /// Speed, m/s; 0 for a fixed object.
    pub speed_mps: f64,
    /// Length of the part, from bumper to bumper of a vehicle of one part, m.
    pub length_m: f64,
    pub width_m: f64,
    /// Height of the road under the vehicle, m.
    pub height_m: f64,
}

impl Obstacle {
    /// Returns what tells this obstacle from all others of a tick.
    fn key(&self) -> (ObstacleId, u8) {
        (self.id, self.part)
    }

    /// Checks whether the vehicle's road is at this height, rather than on a bridge above or below.
    pub fn is_at_height(&self, height_m: f64) -> bool {
        is_one_road(self.height_m, height_m)
    }
}

impl Default for Obstacle {
    /// Returns a vehicle of the ego's size that stands at the origin.
    fn default() -> Self {
        Self {
            id: ObstacleId::Vehicle(0),
            part: 0,
            pose: Pose::default(),
            speed_mps: 0.0,
            length_m: CAR_LENGTH_M,
            width_m: CAR_WIDTH_M,
            height_m: 0.0,
        }
    }
}

/// Contact of the ego with another vehicle or a fixed object in this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Other vehicle, or fixed object.
    pub with: ObstacleId,
    /// Speed of the ego just before, m/s.
    pub ego_speed_mps: f64,
    /// Speed of the other vehicle just before, m/s.
    pub car_speed_mps: f64,
    /// Closing speed along the contact normal just before, m/s, at least 0.
    pub closing_mps: f64,
    /// Heading of the other vehicle relative to the ego's, rad, within ±pi: 0 for the same direction, positive to the
    /// left.
    pub angle_rad: f64,
}

/// Height and slope of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroundShape {
    /// Height in world axes, m.
    pub height_m: f64,
    /// Rise per metre to the east and to the north.
    pub gradient: DVec2,
}

/// Ground for the ego: a surface under each wheel, and one plane under the whole ego. A change of grade acts at once,
/// without an effect on the springs.
pub trait GroundModel {
    /// Returns the surface at a point of the world plane.
    fn surface(&self, point: DVec2) -> GroundSurface;

    /// Checks whether asphalt at a point is a lane for vehicles; by default all is. Not so a pavement, on which poles stand.
    fn is_for_vehicles(&self, _point: DVec2) -> bool {
        true
    }

    /// Returns the plane under an ego whose centre is at a point of the world plane; by default flat ground at height
    /// 0.
    fn shape(&self, _middle: DVec2) -> GroundShape {
        GroundShape::default()
    }
}

/// Ground with one surface everywhere: for test tracks, and for maps without meadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UniformGround(pub GroundSurface);

impl GroundModel for UniformGround {
    fn surface(&self, _point: DVec2) -> GroundSurface {
        self.0
    }
}
