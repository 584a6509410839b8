//! The ego: the order of computation in one tick. In: controls, ground, obstacles. Out: [`EgoState`], contacts, and a
//! prediction for the traffic.

use super::{
    Contact, EgoError, EgoState, GroundModel, GroundShape, GroundSurface, Obstacle, WheelPose,
    body::{CarBody, GRAVITY, WheelContact},
    disturbance::Disturbance,
    params::CarParams,
    powertrain::Powertrain,
    tyre::{BristleState, ContactPatch, TreadParams, TyreForce},
};
use crate::{
    controls::{Controls, STEERING_RATIO},
    space::{Pose, wrap_angle},
    time::TICK_S,
};
use glam::{DVec2, DVec3, Quat, Vec3, vec3};

/// Physics steps in a tick. Four of 2.5 ms: a standing tyre oscillates at 25 rad/s, a converter settles within 20 ms.
const SUBSTEPS: u32 = 4;
const SUBSTEP_S: f32 = (TICK_S / SUBSTEPS as f64) as f32;
/// Speed below which the aligning torque fades, m/s: a standing tyre has none (the rig adds its friction).
const ALIGN_MPS: f32 = 1.0;

/// Simulation of the participant's vehicle.
pub struct EgoCar {
    params: CarParams,
    body: CarBody,
    powertrain: Powertrain,
    tread: TreadParams,
    tyres: [BristleState; 4],
    wheels: [WheelPose; 4],
    /// Brake force after the hydraulics' lag, as a share of the force at a floored pedal.
    brake: f32,
    steering_wheel_rad: f32,
    steering_torque_nm: f32,
    disturbance: Disturbance,
    /// Height and slope of the ground under the ego.
    ground: GroundShape,
    state: EgoState,
    contacts: Vec<Contact>,
}

/// Horizontal directions of the body in the frame's axes.
struct BodyAxes {
    forward: Vec3,
    left: Vec3,
}

impl EgoCar {
    /// Creates an ego at rest on its springs at `start`, or moving forwards there with `start_speed_mps`. `obstacles`
    /// is the number of bodies that are prepared for other vehicles; more are created when needed.
    ///
    /// # Errors
    /// A parameter is outside the range that can be simulated.
    pub fn new(params: &CarParams, start: Pose, start_speed_mps: f64, obstacles: usize) -> Result<Self, EgoError> {
        params.check()?;
        let t = &params.tyres;
        let tread = TreadParams {
            relaxation_m: t.relaxation_m as f32,
            per_m: t.tread_per_m as f32,
            damping: t.tread_damping as f32,
            slip_control: t.slip_control as f32,
        };
        let mut ego = Self {
            body: CarBody::new(params, start, start_speed_mps, obstacles, SUBSTEP_S),
            powertrain: Powertrain::new(params, start_speed_mps),
            params: params.clone(),
            tread,
            tyres: [BristleState::default(); 4],
            wheels: [WheelPose::default(); 4],
            brake: 0.0,
            steering_wheel_rad: 0.0,
            steering_torque_nm: 0.0,
            disturbance: Disturbance::default(),
            ground: GroundShape::default(),
            state: EgoState::default(),
            contacts: Vec::new(),
        };
        let hubs = ego.hubs([params.suspension.travel_m as f32; 4]);
        let compressions_m = ego.rest_compressions_m();
        for (i, wheel) in ego.wheels.iter_mut().enumerate() {
            *wheel = WheelPose { hub: hubs[i], compression_m: compressions_m[i / 2], ..WheelPose::default() };
        }
        ego.state = ego.observe();
        Ok(ego)
    }

    pub fn params(&self) -> &CarParams {
        &self.params
    }

    /// Returns the state after the last tick.
    pub fn state(&self) -> &EgoState {
        &self.state
    }

    /// Places the ego on ground that is not flat or not at height 0, before its first tick.
    pub fn stand_on(&mut self, ground: GroundShape) {
        self.ground = ground;
        self.state = self.observe();
    }

    /// Disturbs the car from the next tick on, until it is called again.
    pub fn disturb(&mut self, disturbance: Disturbance) {
        self.disturbance = disturbance;
        if let Some(water_mm) = disturbance.water_mm {
            self.params.tyres.water_mm = water_mm;
        }
    }

    /// Advances by one tick. `obstacles` are the other vehicles at the end of it; they may change from tick to tick.
    /// Returns the contacts, one per vehicle.
    pub fn tick(&mut self, controls: &Controls, ground: &dyn GroundModel, obstacles: &[Obstacle]) -> &[Contact] {
        let mut controls = controls.sane();
        if self.disturbance.is_powerless {
            controls.throttle = 0.0;
        }
        let before = self.state;
        self.body.begin_tick(obstacles);
        self.ground = ground.shape(before.position.truncate());
        self.body.set_gradient(self.ground.gradient);
        for wheel in &mut self.wheels {
            let hub = before.rotation * wheel.hub;
            wheel.surface = ground.surface(before.position.truncate() + hub.truncate().as_dvec2());
        }
        self.steering_wheel_rad = controls.steering_wheel_rad;
        self.steer(controls.steering_wheel_rad / STEERING_RATIO);
        // Once a tick, as the power costs as much as a tyre.
        let brake = controls.brake.powf(self.params.brakes.pedal_exponent as f32);
        for substep in 1..=SUBSTEPS {
            self.substep(&controls, brake);
            self.body.step(obstacles, f64::from(substep) / f64::from(SUBSTEPS));
        }
        self.body.end_tick(&before, obstacles, &mut self.contacts);
        self.state = self.observe();
        let change = (self.state.velocity - before.velocity).as_dvec3() / TICK_S;
        let forward = self.state.pose().forward();
        self.state.accel_mps2 = change.truncate().dot(forward);
        self.state.lateral_accel_mps2 = change.truncate().dot(forward.perp());
        self.state.braking = f64::from(controls.brake) > self.params.brakes.lamp_pedal;
        &self.contacts
    }

    /// Predicts pose and speed `dt_s` ahead, with constant acceleration and yaw rate: an arc. A braking ego stops and
    /// stays.
    pub fn predict(&self, dt_s: f64) -> (Pose, f64) {
        let (v, a) = (self.state.speed_mps, self.state.accel_mps2);
        let stopping = v * a < 0.0 && -v / a < dt_s;
        // In a forward gear a standing ego does not set off backwards, although it rocks by a centimetre after a stop.
        let rocking = v <= 0.0 && a < 0.0 && self.state.gear >= 0;
        let (way_m, speed_mps) = match (stopping, rocking) {
            (true, _) => (-v * v / (2.0 * a), 0.0),
            (_, true) => (0.0, 0.0),
            _ => (v * dt_s + a * dt_s * dt_s / 2.0, v + a * dt_s),
        };
        let pose = self.state.pose();
        // Yaw is proportional to the way, not to time: an ego that stops also stops turning.
        let turn = if v.abs() > 0.1 { self.state.yaw_rate / v * way_m } else { self.state.yaw_rate * dt_s };
        let velocity = self.state.velocity.truncate().as_dvec2();
        // Direction of motion, which differs from the heading by the slip angle.
        let course = if v.abs() > 0.1 { velocity / v } else { pose.forward() };
        let chord_m = if turn.abs() < 1e-6 { way_m } else { way_m * (turn / 2.0).sin() / (turn / 2.0) };
        let along = DVec2::from_angle(turn / 2.0).rotate(course) * chord_m;
        (Pose::new(pose.position + along, wrap_angle(pose.yaw_rad + turn)), speed_mps)
    }

    /// Sets the front wheels' angles by Ackermann: both wheels roll about one point on the rear axle's line.
    fn steer(&mut self, middle_rad: f32) {
        let b = &self.params.body;
        let (length, half_track) = (b.wheelbase_m as f32, b.track_m as f32 / 2.0);
        let tan = middle_rad.tan();
        for (wheel, side) in self.wheels.iter_mut().zip([half_track, -half_track]) {
            wheel.steer_rad = (length * tan).atan2(length - side * tan);
        }
    }

    /// Applies the forces of one sub-step: springs, air, engine, brakes, tyres. `brake` is the share of the full brake force that the pedal
    /// asks for.
    fn substep(&mut self, controls: &Controls, brake: f32) {
        let p = &self.params;
        let lag = if p.brakes.lag_s > 0.0 { (SUBSTEP_S / p.brakes.lag_s as f32).min(1.0) } else { 1.0 };
        self.brake += (brake - self.brake) * lag;
        let rays = self.body.springs();
        let axes = self.axes();
        let chassis = self.body.chassis();
        let (velocity, centre) = (chassis.linvel(), chassis.center_of_mass());
        let ground_speed = chassis.velocity_at_point(chassis.translation()).dot(axes.forward);
        let drag = 0.5 * (p.body.air_density_kgm3 * p.body.drag_area_m2) as f32;
        let side_n = self.disturbance.side_force_n(p.body.air_density_kgm3, f64::from(ground_speed)) as f32;
        let air = velocity * (-drag * velocity.length()) + axes.left * side_n;
        let drive_n = self.powertrain.step(p, controls, f64::from(ground_speed), f64::from(SUBSTEP_S)) as f32;
        // All tyres are computed for the same state. Otherwise the force of one would act as slip of the next, and a
        // standing ego would creep.
        let patches: [_; 4] = std::array::from_fn(|i| self.patch(i, &rays[i], &axes, drive_n));
        let mut grips = [TyreForce::default(); 4];
        // Applied after that too: tyres that see the downhill force would hold a standing ego against it twice, and it
        // would creep uphill.
        self.body.push(air + self.body.downhill_n(), centre);
        for (i, (patch, forward, left)) in patches.iter().enumerate() {
            grips[i] = self.tyres[i].step(&self.tread, patch, SUBSTEP_S);
            let point = rays[i].point + Vec3::Z * self.params.suspension.link_height_m as f32;
            self.body.push(forward * grips[i].x_n + left * grips[i].y_n, point);
            let wheel = &mut self.wheels[i];
            wheel.spin_rad += patch.vx_mps * SUBSTEP_S / self.params.body.wheel_radius_m as f32;
        }
        let hubs = self.hubs(rays.map(|ray| ray.length_m));
        let rest = self.rest_lengths_m();
        for (i, wheel) in self.wheels.iter_mut().enumerate() {
            wheel.hub = hubs[i];
            wheel.compression_m = rest[i / 2] - rays[i].length_m;
        }
        self.steering_torque_nm = self.aligning_torque_nm(&grips, ground_speed);
    }

    /// Returns the inputs of the tyre model for wheel `i`, and the wheel's forward and left directions.
    fn patch(&self, i: usize, ray: &WheelContact, axes: &BodyAxes, drive_n: f32) -> (ContactPatch, Vec3, Vec3) {
        let p = &self.params;
        let front = i < 2;
        let (sin, cos) = self.wheels[i].steer_rad.sin_cos();
        let forward = axes.forward * cos + axes.left * sin;
        let left = axes.left * cos - axes.forward * sin;
        let velocity = self.body.chassis().velocity_at_point(ray.point);
        let vx_mps = velocity.dot(forward);
        let pick = |at_front: f64, at_rear: f64| (if front { at_front } else { at_rear }) as f32;
        let weight_n = p.body.mass_kg as f32 * GRAVITY;
        let (friction, rolling) = match self.wheels[i].surface {
            GroundSurface::Asphalt => (p.tyres.asphalt_friction_at(f64::from(vx_mps)), p.tyres.asphalt_rolling),
            GroundSurface::Grass => {
                let growing = p.tyres.grass_rolling + p.tyres.grass_rolling_per_mps * f64::from(vx_mps.abs());
                (p.tyres.grass_friction, growing.min(p.tyres.grass_rolling_max))
            }
        };
        let patch = ContactPatch {
            load_n: ray.load_n,
            rest_load_n: weight_n * pick(p.body.front_share, 1.0 - p.body.front_share) / 2.0,
            vx_mps,
            vy_mps: velocity.dot(left),
            drive_n: if front { drive_n / 2.0 } else { 0.0 },
            brake_n: self.brake
                * weight_n
                * p.brakes.full_share as f32
                * pick(p.brakes.front_share, 1.0 - p.brakes.front_share)
                / 2.0,
            rolling_n: rolling as f32 * ray.load_n,
            friction: (friction * self.disturbance.friction) as f32,
            cornering: pick(p.tyres.front_cornering, p.tyres.rear_cornering),
        };
        (patch, forward, left)
    }

    /// Returns the self-aligning torque at the steering wheel: side force of the front tyres times trail, over the
    /// steering ratio.
    fn aligning_torque_nm(&self, grips: &[TyreForce; 4], speed_mps: f32) -> f32 {
        let s = &self.params.steering;
        let rolling = (speed_mps / ALIGN_MPS).clamp(-1.0, 1.0);
        let torque_nm: f32 = grips[..2]
            .iter()
            .map(|grip| {
                // The pneumatic trail lies behind the rolling direction and vanishes when the tyre slides.
                let pneumatic_m = s.pneumatic_trail_m as f32 * (1.0 - grip.saturation).powi(3) * rolling;
                -grip.y_n * (pneumatic_m + s.caster_trail_m as f32 * rolling.abs())
            })
            .sum();
        torque_nm / STEERING_RATIO * s.feel_share as f32
    }

    fn axes(&self) -> BodyAxes {
        let ahead = *self.body.chassis().rotation() * Vec3::X;
        let forward = vec3(ahead.x, ahead.y, 0.0).normalize_or(Vec3::X);
        BodyAxes { forward, left: vec3(-forward.y, forward.x, 0.0) }
    }

    fn rest_compressions_m(&self) -> [f32; 2] {
        self.params.suspension.ride_hz.map(|hz| GRAVITY / (std::f32::consts::TAU * hz as f32).powi(2))
    }

    fn rest_lengths_m(&self) -> [f32; 2] {
        self.rest_compressions_m().map(|compression_m| compression_m + self.params.suspension.travel_m as f32)
    }

    /// Returns the hubs in the body's frame for springs of these lengths.
    fn hubs(&self, lengths_m: [f32; 4]) -> [Vec3; 4] {
        let b = &self.params.body;
        let top_m = (b.wheel_radius_m + self.params.suspension.travel_m) as f32;
        std::array::from_fn(|i| {
            let x = if i < 2 { b.front_axle_m } else { b.front_axle_m - b.wheelbase_m };
            let y = if i % 2 == 0 { b.track_m / 2.0 } else { -b.track_m / 2.0 };
            vec3(x as f32, y as f32, top_m - lengths_m[i])
        })
    }

    /// Returns the state without accelerations, which need the previous state.
    fn observe(&self) -> EgoState {
        let chassis = self.body.chassis();
        let place = chassis.translation();
        let velocity = chassis.velocity_at_point(place);
        let on_plane = self.body.world_from_frame(place);
        let GroundShape { height_m, gradient } = self.ground;
        let mut rotation = *chassis.rotation();
        if gradient != DVec2::ZERO {
            rotation = Quat::from_rotation_arc(Vec3::Z, (-gradient).extend(1.0).normalize().as_vec3()) * rotation;
        }
        EgoState {
            position: DVec3::new(on_plane.x, on_plane.y, f64::from(place.z) + height_m),
            rotation,
            velocity,
            speed_mps: f64::from(velocity.dot(self.axes().forward)),
            accel_mps2: 0.0,
            lateral_accel_mps2: 0.0,
            yaw_rate: f64::from(chassis.angvel().z),
            gear: self.powertrain.gear(),
            engine_rpm: self.powertrain.rpm() as f32,
            steering_wheel_rad: self.steering_wheel_rad,
            steering_torque_nm: self.steering_torque_nm,
            braking: false,
            wheels: self.wheels,
        }
    }
}
