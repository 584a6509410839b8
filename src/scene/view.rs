//! One picture from one snapshot: where every car stands between two ticks, where the camera is, what colours things
//! have. In: a [`Snapshot`], the clock's fraction, options. Out: a [`View`] whose `dial` the caller fills in.

use super::car::{WHEEL_RADIUS_M, WHEELBASE_M};
use super::{Camera, CarInstance, Lens, Stage, View, ViewKind};
use crate::ego::EgoState;
use crate::sim::{CarView, Snapshot};
use crate::space::wrap_angle;
use crate::traffic::{CarId, EGO};
use crate::units::SpeedUnit;
use glam::{EulerRot, Quat, Vec2, Vec3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// What a person may set about the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewOptions {
    /// Driver's eye in the body's frame (x forward, y left, z up from the ground under the centre), metres.
    pub eye: Vec3,
    /// Width of the screen, metres.
    pub screen_width_m: f32,
    /// Distance from the participant's eye to the screen, metres.
    pub eye_distance_m: f32,
    /// How much of the body's pitch and roll the driver's camera takes part in, 0..1: less is easier on the stomach.
    pub body_motion: f32,
    /// The rear-view mirror.
    pub mirror: MirrorOptions,
    /// Unit of the speedometer.
    pub unit: SpeedUnit,
    /// Full scale of the speedometer in its unit; `None` fits the scenario.
    pub dial_full_scale: Option<f64>,
    /// Direction of the sun: compass degrees, 0 north, clockwise.
    pub sun_azimuth_deg: f32,
    /// Height of the sun above the horizon, degrees.
    pub sun_elevation_deg: f32,
    /// The ego's paint, linear.
    pub ego_paint: [f32; 3],
    /// The others' paint from above, and everywhere if `ordinary_paints` is off.
    pub traffic_paint: [f32; 3],
    /// Seen from the road, the others wear a mix of ordinary paints, never red.
    pub ordinary_paints: bool,
    /// Paint of single cars in every view, before all other rules.
    pub paint_overrides: BTreeMap<CarId, [f32; 3]>,
    /// If set, the bird's-eye view follows the ego and shows this many metres to either side of it.
    pub birdseye_follow_m: Option<f32>,
}

/// The rear-view mirror: a camera that looks back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorOptions {
    /// Place in the body's frame, metres: the top of the windscreen.
    pub position: Vec3,
    /// Horizontal angle of view, degrees.
    pub fov_x_deg: f32,
    /// Tilt downwards, degrees: shows the bonnet of a follower 2 m away.
    pub tilt_deg: f32,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self {
            eye: Vec3::new(0.10, 0.36, 1.18),
            // A 55-inch television, 16:9, at one metre: 63 degrees (FACTS 8).
            screen_width_m: 1.2176,
            eye_distance_m: 1.0,
            body_motion: 0.3,
            mirror: MirrorOptions { position: Vec3::new(0.30, 0.0, 1.26), fov_x_deg: 30.0, tilt_deg: 2.5 },
            unit: SpeedUnit::default(),
            dial_full_scale: None,
            sun_azimuth_deg: 130.0,
            sun_elevation_deg: 42.0,
            ego_paint: [0.62, 0.020, 0.018],
            traffic_paint: [0.030, 0.36, 0.060],
            ordinary_paints: true,
            paint_overrides: BTreeMap::new(),
            birdseye_follow_m: None,
        }
    }
}

impl ViewOptions {
    /// Horizontal angle of view of the driver's picture, radians: the one that the screen fills at the eye's distance, so
    /// that the picture's scale is 1.
    pub fn fov_x_rad(&self) -> f32 {
        2.0 * (self.screen_width_m / 2.0 / self.eye_distance_m).atan()
    }

    /// Unit direction towards the sun.
    pub fn to_sun(&self) -> Vec3 {
        let (sin_a, cos_a) = self.sun_azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = self.sun_elevation_deg.to_radians().sin_cos();
        Vec3::new(sin_a * cos_e, cos_a * cos_e, sin_e)
    }

    /// Paint of a car in a view.
    pub fn paint(&self, id: CarId, kind: ViewKind) -> [f32; 3] {
        if let Some(paint) = self.paint_overrides.get(&id) {
            return *paint;
        }
        match kind {
            _ if id == EGO => self.ego_paint,
            ViewKind::Birdseye => self.traffic_paint,
            _ if self.ordinary_paints => ordinary_paint(id),
            _ => self.traffic_paint,
        }
    }
}

/// Paints as they are common on the road (white, greys and black lead), linear. No reds: red is the ego's.
const PAINTS: [[f32; 3]; 10] = [
    [0.72, 0.72, 0.70],
    [0.38, 0.40, 0.42],
    [0.115, 0.120, 0.130],
    [0.012, 0.012, 0.014],
    [0.025, 0.075, 0.230],
    [0.72, 0.72, 0.70],
    [0.020, 0.085, 0.048],
    [0.205, 0.215, 0.225],
    [0.400, 0.340, 0.245],
    [0.055, 0.135, 0.260],
];

/// The same car always wears the same paint; neighbours differ.
fn ordinary_paint(id: CarId) -> [f32; 3] {
    // 7 and 10 share no factor, so ten cars in a row wear ten entries; the jump by rows varies the order.
    let n = PAINTS.len() as u32;
    PAINTS[((id.0 * 7 + (id.0 / n) * 3) % n) as usize]
}

/// The picture at `fraction` (0..1) of the way from the tick before the snapshot to the snapshot.
pub fn view(snapshot: &Snapshot, fraction: f32, kind: ViewKind, options: &ViewOptions, stage: &Stage) -> View {
    let ego = EgoAt::new(snapshot, fraction);
    let mut cars = vec![ego.instance(options.paint(EGO, kind))];
    cars.extend(snapshot.cars.iter().map(|car| traffic_car(car, fraction, options.paint(car.id, kind), stage)));
    let camera = match kind {
        ViewKind::Driver => driver_camera(&ego, options),
        ViewKind::Mirror => mirror_camera(&ego, options),
        ViewKind::Birdseye => birdseye_camera(&ego, options, stage),
        ViewKind::Chase => chase_camera(&ego, snapshot.ego.yaw_rate as f32),
    };
    let before_s = (1.0 - f64::from(fraction)) * crate::time::TICK_S;
    View {
        kind,
        camera,
        mirror: (kind == ViewKind::Driver).then(|| mirror_camera(&ego, options)),
        cars,
        to_sun: options.to_sun(),
        time_s: (snapshot.tick.seconds() - before_s).max(0.0) as f32,
        dial: None,
    }
}

/// The ego between two ticks.
struct EgoAt {
    position: Vec3,
    rotation: Quat,
    yaw_rad: f32,
    hubs: [Vec3; 4],
    steer_rad: f32,
    spin_rad: f32,
    braking: bool,
}

impl EgoAt {
    fn new(snapshot: &Snapshot, fraction: f32) -> Self {
        let (a, b): (&EgoState, &EgoState) = (&snapshot.ego_before, &snapshot.ego);
        let mix = |a: f32, b: f32| a + (b - a) * fraction;
        // A rolled angle may be kept in one turn: the short way round is the way rolled in a tick.
        let spin = |i: usize| {
            let turn = wrap_angle(f64::from(b.wheels[i].spin_rad) - f64::from(a.wheels[i].spin_rad)) as f32;
            a.wheels[i].spin_rad + turn * fraction
        };
        let rotation = a.rotation.slerp(b.rotation, fraction);
        let forward = rotation * Vec3::X;
        Self {
            position: a.position.lerp(b.position, f64::from(fraction)).as_vec3(),
            rotation,
            yaw_rad: forward.y.atan2(forward.x),
            hubs: std::array::from_fn(|i| a.wheels[i].hub.lerp(b.wheels[i].hub, fraction)),
            steer_rad: mix(
                (a.wheels[0].steer_rad + a.wheels[1].steer_rad) / 2.0,
                (b.wheels[0].steer_rad + b.wheels[1].steer_rad) / 2.0,
            ),
            // A rear wheel: it follows the road whatever the brakes of the front axle do.
            spin_rad: spin(2),
            braking: b.braking,
        }
    }

    fn instance(&self, colour: [f32; 3]) -> CarInstance {
        CarInstance {
            position: self.position,
            rotation: self.rotation,
            colour,
            brake: f32::from(u8::from(self.braking)),
            hubs: self.hubs,
            steer_rad: self.steer_rad,
            spin_rad: self.spin_rad,
            is_ego: true,
        }
    }

    /// The body's rotation with only `share` of its pitch and roll.
    fn steadied(&self, share: f32) -> Quat {
        let (yaw, pitch, roll) = self.rotation.to_euler(EulerRot::ZYX);
        Quat::from_euler(EulerRot::ZYX, yaw, pitch * share, roll * share)
    }
}

fn traffic_car(car: &CarView, fraction: f32, colour: [f32; 3], stage: &Stage) -> CarInstance {
    let pose = car.pose_before.lerp(&car.pose, f64::from(fraction));
    let rest_m = (1.0 - f64::from(fraction)) * car.pose_before.position.distance(car.pose.position);
    let spin = ((car.odometer_m - rest_m) / f64::from(WHEEL_RADIUS_M)).rem_euclid(TAU);
    // Ackermann: the angle that rolls the car round the bend under its centre.
    let bend_per_m = stage.bend_per_m(car.s_m - crate::space::CAR_LENGTH_M / 2.0);
    CarInstance {
        position: pose.position.as_vec2().extend(0.0),
        rotation: Quat::from_rotation_z(pose.yaw_rad as f32),
        colour,
        brake: f32::from(u8::from(car.braking)),
        hubs: stage.hubs,
        steer_rad: (WHEELBASE_M * bend_per_m).atan(),
        spin_rad: spin as f32,
        is_ego: false,
    }
}

fn driver_camera(ego: &EgoAt, options: &ViewOptions) -> Camera {
    let rotation = ego.steadied(options.body_motion);
    Camera {
        eye: ego.position + rotation * options.eye,
        forward: rotation * Vec3::X,
        up: rotation * Vec3::Z,
        lens: Lens::Perspective { fov_x_rad: options.fov_x_rad() },
    }
}

fn mirror_camera(ego: &EgoAt, options: &ViewOptions) -> Camera {
    let rotation = ego.steadied(options.body_motion);
    let (sin, cos) = options.mirror.tilt_deg.to_radians().sin_cos();
    Camera {
        eye: ego.position + rotation * options.mirror.position,
        forward: rotation * Vec3::new(-cos, 0.0, -sin),
        up: rotation * Vec3::new(-sin, 0.0, cos),
        lens: Lens::Perspective { fov_x_rad: options.mirror.fov_x_deg.to_radians() },
    }
}

/// Height of the bird's-eye camera above the ground, metres: above every hill and tree.
const BIRDSEYE_HEIGHT_M: f32 = 400.0;

fn birdseye_camera(ego: &EgoAt, options: &ViewOptions, stage: &Stage) -> Camera {
    let (centre, half_extent_m) = match options.birdseye_follow_m {
        Some(half_extent_m) => (ego.position.truncate(), half_extent_m),
        None => (stage.centre, stage.radius_m * 1.06 + 4.0),
    };
    Camera {
        eye: centre.extend(BIRDSEYE_HEIGHT_M),
        forward: -Vec3::Z,
        up: Vec3::Y,
        lens: Lens::Parallel { half_extent_m },
    }
}

/// The chase camera lags behind a turning car by this time, so that it does not stiffly swing with it, seconds.
const CHASE_LAG_S: f32 = 0.25;

fn chase_camera(ego: &EgoAt, yaw_rate: f32) -> Camera {
    let back = Vec2::from_angle(ego.yaw_rad - (yaw_rate * CHASE_LAG_S).clamp(-0.5, 0.5));
    let at = ego.position.truncate();
    let eye = (at - back * 7.0).extend(2.6);
    let target = (at + back * 4.0).extend(0.9);
    let forward = (target - eye).normalize();
    let right = forward.cross(Vec3::Z).normalize();
    Camera { eye, forward, up: right.cross(forward), lens: Lens::Perspective { fov_x_rad: 63f32.to_radians() } }
}
