//! The participant's car. In: [`Controls`](crate::controls::Controls) once a tick, the ground under the wheels, the other cars as kinematic
//! bodies. Out: [`EgoState`] and [`Contact`]s. Only this room knows rapier.
//!
//! One [`EgoCar::tick`] is four sub-steps of 2.5 ms: springs (rapier's ray-cast vehicle), engine and gearbox
//! (`powertrain`), brakes and tyres (`tyre`), then rapier moves and collides the body (`body`).

mod body;
mod car;
mod params;
mod powertrain;
mod tyre;

pub use car::EgoCar;
pub use params::{
    BodyParams, BrakeParams, CarParams, EgoError, EngineParams, GearboxParams, SteeringParams, SuspensionParams,
    TyreParams,
};

use crate::space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose};
use glam::{DVec2, DVec3, EulerRot, Quat, Vec3};

/// What lies under a wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum GroundSurface {
    /// Dry asphalt.
    #[default]
    Asphalt,
    /// Meadow: slow and slippery.
    Grass,
}

/// One wheel, in the order front left, front right, rear left, rear right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelPose {
    /// Hub in the body's frame (x forward, y left, z up from the body's origin), metres, suspension included.
    pub hub: Vec3,
    /// Road wheel angle, radians, positive to the left.
    pub steer_rad: f32,
    /// Rolled angle, radians, growing forwards.
    pub spin_rad: f32,
    /// Suspension compression from its rest length, metres.
    pub compression_m: f32,
    /// Ground under it.
    pub surface: GroundSurface,
}

/// The ego after a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EgoState {
    /// Centre of the car on the ground (z is the ground's height at rest), world axes, metres.
    pub position: DVec3,
    /// Rotation of the body: body x forward, y left, z up to world.
    pub rotation: Quat,
    /// Velocity, world axes, m/s.
    pub velocity: Vec3,
    /// Speed along the car, m/s, negative in reverse.
    pub speed_mps: f64,
    /// Acceleration along the car, m/s2.
    pub accel_mps2: f64,
    /// Acceleration to the left, m/s2.
    pub lateral_accel_mps2: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate: f64,
    /// Gear: -1 reverse, 0 neutral, 1.. forwards.
    pub gear: i8,
    /// Engine speed, revolutions a minute.
    pub engine_rpm: f32,
    /// Angle of the steering wheel, radians, positive to the left.
    pub steering_wheel_rad: f32,
    /// Self-aligning torque at the steering wheel, N m, positive turns it to the left.
    pub steering_torque_nm: f32,
    /// True while the brake lamps are lit.
    pub braking: bool,
    /// Front left, front right, rear left, rear right.
    pub wheels: [WheelPose; 4],
}

impl EgoState {
    /// Place and heading of the car's centre on the ground plane.
    pub fn pose(&self) -> Pose {
        let (yaw, _, _) = self.rotation.to_euler(EulerRot::ZYX);
        Pose::new(self.position.truncate(), f64::from(yaw))
    }
}

/// Another car as the ego can touch it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Which car; each has another number.
    pub id: u32,
    /// Pose of its centre at the end of this tick.
    pub pose: Pose,
    /// Its speed, m/s.
    pub speed_mps: f64,
    /// Bumper to bumper, metres.
    pub length_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Height of the road that it stands on, metres.
    pub height_m: f64,
}

/// Vehicles whose roads lie further above each other do not touch, metres: 4.5 m are left free below bridges, and on the way on which two touch
/// no road climbs half of that.
const ONE_ROAD_M: f64 = 2.5;

impl Obstacle {
    /// True if it stands on the road of something at this height: on a bridge, it is nobody's obstacle below.
    pub fn is_at_height(&self, height_m: f64) -> bool {
        is_one_road(self.height_m, height_m)
    }
}

/// True if two places are so near in height that who meets there can touch: none of them is on a bridge above the other.
pub fn is_one_road(a_m: f64, b_m: f64) -> bool {
    (a_m - b_m).abs() < ONE_ROAD_M
}

impl Default for Obstacle {
    /// A car like the ego that stands in the origin.
    fn default() -> Self {
        Self {
            id: 0,
            pose: Pose::default(),
            speed_mps: 0.0,
            length_m: CAR_LENGTH_M,
            width_m: CAR_WIDTH_M,
            height_m: 0.0,
        }
    }
}

/// The ego touched another car in this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Number of the other car.
    pub car: u32,
    /// Ego's speed just before, m/s.
    pub ego_speed_mps: f64,
    /// Other car's speed just before, m/s.
    pub car_speed_mps: f64,
    /// Normal speed of approach just before, m/s.
    pub closing_mps: f64,
    /// The other's heading against the ego's, radians within +-pi: 0 alike, positive to the left.
    pub angle_rad: f64,
}

/// How high the ground is, and how it rises.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroundShape {
    /// Height, metres.
    pub height_m: f64,
    /// Rise a metre to the east and to the north.
    pub gradient: DVec2,
}

/// The ground as the car feels it: its surface under each wheel, and one plane under the whole car. A bend of the road's grade is
/// none of the springs': it takes no time.
pub trait GroundModel {
    /// Surface at a point of the world plane.
    fn surface(&self, point: DVec2) -> GroundSurface;

    /// The plane under a car whose middle is at a point of the world plane; flat ground at height 0 unless it says otherwise.
    fn shape(&self, _middle: DVec2) -> GroundShape {
        GroundShape::default()
    }
}

/// The same surface everywhere: test tracks, and maps that have no meadow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UniformGround(pub GroundSurface);

impl GroundModel for UniformGround {
    fn surface(&self, _point: DVec2) -> GroundSurface {
        self.0
    }
}
