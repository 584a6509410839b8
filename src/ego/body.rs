//! The ego's rigid body and the bodies of other cars, in rapier. In: obstacles' poses, forces of tyres and air. Out: pose
//! and velocity of the body, wheel rays, contacts. `f32` in a frame whose origin follows the car in whole metres, so that a
//! millimetre keeps its meaning anywhere in the world.
//!
//! rapier's ray-cast vehicle carries the body on its springs; its wheel friction stays off because it creeps sideways at
//! a standstill (it removes a fifth of the slip in a step and knows no grip at rest): `tyre` takes its place.

use super::{Contact, Obstacle, params::CarParams};
use crate::space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, wrap_angle};
use glam::{DVec2, Quat, Vec3, dvec2, vec3};
use rapier3d::{
    control::{DynamicRayCastVehicleController, WheelTuning},
    prelude::*,
};

/// Standard gravity, m/s2.
pub(super) const GRAVITY: f32 = 9.81;
/// Height of the other cars, and of the ego's roof, metres.
const ROOF_M: f32 = 1.4;
/// Ground clearance of the boxes, metres: the springs' travel never brings the ego's to the road.
const CLEARANCE_M: f32 = 0.25;
/// Half height of the other cars' boxes, metres: as walls they push an overlapping ego sideways, never into the road.
const WALL_M: f32 = 4.0;
/// Cars farther away (centre to centre) take no part in the physics, metres: two lengths and what two cars at 60 m/s
/// close within a tick leave room to spare.
const NEAR_M: f64 = 15.0;
/// A car that moves farther within a tick was set there, metres: it gets no velocity of 100 times that a second.
const JUMP_M: f64 = 1.5;
/// The frame's origin moves when the car is farther from it than this, metres: below 32 m an f32 resolves 2 micrometres.
const REBASE_M: f64 = 32.0;

/// What holds of one wheel in this sub-step, world axes relative to the frame's origin.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WheelContact {
    /// Where it stands, metres.
    pub point: Vec3,
    /// Load, N, at least 0.
    pub load_n: f32,
    /// Spring's length, metres.
    pub length_m: f32,
}

pub(super) struct CarBody {
    world: PhysicsWorld,
    vehicle: DynamicRayCastVehicleController,
    chassis: RigidBodyHandle,
    shell: ColliderHandle,
    cars: Vec<ObstacleBody>,
    /// World position of the frame's origin.
    origin: DVec2,
    mass_kg: f32,
    anti_roll_npm: [f32; 2],
    dt: f32,
}

/// Another car.
struct ObstacleBody {
    body: RigidBodyHandle,
    /// Where it was at the end of the last tick; `None` before the first.
    pose: Option<Pose>,
    speed_mps: f64,
    touched: Option<f64>,
}

impl CarBody {
    pub fn new(p: &CarParams, start: Pose, start_speed_mps: f64, cars: usize, dt: f32) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = dt;
        // Weight is given as an impulse beside the springs' (see `springs`), so that a standing car stands exactly.
        world.gravity = Vector::ZERO;
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Z)).friction(0.6));
        let half = vec3(CAR_LENGTH_M as f32 / 2.0, CAR_WIDTH_M as f32 / 2.0, (ROOF_M - CLEARANCE_M) / 2.0);
        let shell = |half_height_m: f32| {
            ColliderBuilder::cuboid(half.x, half.y, half_height_m)
                .translation(vec3(0.0, 0.0, CLEARANCE_M + half.z))
                .density(0.0)
                .friction(0.3)
                .restitution(0.05)
        };
        let b = &p.body;
        let [roll, pitch, yaw] = b.inertia_kgm2.map(|i| i as f32);
        let cg = vec3(cg_x(p), 0.0, b.cg_height_m as f32);
        let forward = start.forward();
        let origin = start.position.round();
        let (chassis, shell_handle) = world.insert(
            RigidBodyBuilder::dynamic()
                .pose(frame_pose(start, origin))
                .linvel((forward * start_speed_mps).as_vec2().extend(0.0))
                .additional_mass_properties(MassProperties::new(cg, b.mass_kg as f32, vec3(roll, pitch, yaw)))
                .can_sleep(false),
            shell(half.z),
        );
        let cars = (0..cars)
            .map(|i| {
                let body = RigidBodyBuilder::kinematic_position_based().enabled(false).can_sleep(false);
                let (body, _) = world.insert(body, shell(WALL_M).user_data(i as u128 + 1));
                ObstacleBody { body, pose: None, speed_mps: 0.0, touched: None }
            })
            .collect();
        let anti_roll_npm = p.suspension.anti_roll_npm.map(|k| k as f32);
        let vehicle = vehicle(chassis, p);
        Self {
            world,
            vehicle,
            chassis,
            shell: shell_handle,
            cars,
            origin,
            mass_kg: b.mass_kg as f32,
            anti_roll_npm,
            dt,
        }
    }

    pub fn chassis(&self) -> &RigidBody {
        &self.world.bodies[self.chassis]
    }

    /// World position of a point of the frame.
    pub fn world_from_frame(&self, point: Vec3) -> DVec2 {
        self.origin + dvec2(f64::from(point.x), f64::from(point.y))
    }

    /// Before the sub-steps of a tick: keeps the frame near the car, and wakes the cars that are near.
    ///
    /// # Panics
    /// If the number of obstacles is not the one given at the start.
    pub fn begin_tick(&mut self, obstacles: &[Obstacle]) {
        assert_eq!(obstacles.len(), self.cars.len(), "the number of other cars is fixed at the start of a drive");
        self.rebase();
        let here = self.world_from_frame(self.chassis().translation());
        for (car, obstacle) in self.cars.iter_mut().zip(obstacles) {
            car.touched = None;
            if car.pose.is_none() {
                car.speed_mps = obstacle.speed_mps;
            }
            let from = car.pose.filter(|pose| pose.position.distance(obstacle.pose.position) < JUMP_M);
            let from = *car.pose.insert(from.unwrap_or(obstacle.pose));
            let near = obstacle.pose.is_finite() && obstacle.pose.position.distance(here) < NEAR_M;
            // rapier lists every body that is asked for as one to change: only those that are.
            let enabled = self.world.bodies[car.body].is_enabled();
            if near || enabled {
                let body = &mut self.world.bodies[car.body];
                if near {
                    body.set_position(frame_pose(from, self.origin), true);
                }
                if near != enabled {
                    body.set_enabled(near);
                }
            }
        }
    }

    /// Weight and springs of one sub-step. Returns what each wheel stands on.
    pub fn springs(&mut self) -> [WheelContact; 4] {
        let world = &mut self.world;
        let queries = world.broad_phase.as_query_pipeline_mut(
            world.narrow_phase.query_dispatcher(),
            &mut world.bodies,
            &mut world.colliders,
            QueryFilter::only_fixed(),
        );
        self.vehicle.update_vehicle(self.dt, queries);
        // After the springs: before them, their dampers would take the weight's impulse for a movement.
        let weight = vec3(0.0, 0.0, -GRAVITY * self.mass_kg * self.dt);
        self.world.bodies[self.chassis].apply_impulse(weight, true);
        let wheels = self.vehicle.wheels();
        let mut rays: [WheelContact; 4] = std::array::from_fn(|i| {
            let (ray, load_n) = (wheels[i].raycast_info(), wheels[i].wheel_suspension_force);
            let load_n = load_n.min(wheels[i].max_suspension_force);
            WheelContact { point: ray.contact_point_ws, load_n, length_m: ray.suspension_length }
        });
        let body = &mut self.world.bodies[self.chassis];
        for axle in 0..2 {
            let (left, right) = (2 * axle, 2 * axle + 1);
            if rays[left].load_n <= 0.0 || rays[right].load_n <= 0.0 {
                continue;
            }
            let lift_n = (self.anti_roll_npm[axle] * (rays[right].length_m - rays[left].length_m))
                .clamp(-rays[left].load_n, rays[right].load_n);
            for (wheel, force_n) in [(left, lift_n), (right, -lift_n)] {
                rays[wheel].load_n += force_n;
                body.apply_impulse_at_point(Vec3::Z * force_n * self.dt, rays[wheel].point, true);
            }
        }
        rays
    }

    /// A force for this sub-step, N, at a point of the frame.
    pub fn push(&mut self, force: Vec3, point: Vec3) {
        self.world.bodies[self.chassis].apply_impulse_at_point(force * self.dt, point, true);
    }

    /// Moves everything by one sub-step; the other cars to `fraction` of their way in this tick.
    pub fn step(&mut self, obstacles: &[Obstacle], fraction: f64) {
        for (car, obstacle) in self.cars.iter().zip(obstacles) {
            let enabled = self.world.bodies[car.body].is_enabled();
            if let Some(from) = car.pose.filter(|_| enabled) {
                let body = &mut self.world.bodies[car.body];
                let mut next = frame_pose(from.lerp(&obstacle.pose, fraction), self.origin);
                // Past west the quaternion changes sign; rapier would take that for a whole turn within a sub-step.
                if next.rotation.dot(*body.rotation()) < 0.0 {
                    next.rotation = -next.rotation;
                }
                body.set_next_kinematic_position(next);
            }
        }
        let before = *self.chassis().vels();
        self.world.step();
        self.note_contacts(&before, obstacles);
    }

    /// After the sub-steps: the cars touched in this tick, and what they did before it.
    pub fn end_tick(&mut self, ego_speed_mps: f64, obstacles: &[Obstacle], contacts: &mut Vec<Contact>) {
        contacts.clear();
        for (index, (car, obstacle)) in self.cars.iter_mut().zip(obstacles).enumerate() {
            if let Some(closing_mps) = car.touched {
                contacts.push(Contact { car: index, ego_speed_mps, car_speed_mps: car.speed_mps, closing_mps });
            }
            car.pose = Some(obstacle.pose);
            car.speed_mps = obstacle.speed_mps;
        }
    }

    fn note_contacts(&mut self, before: &RigidBodyVelocity<Real>, obstacles: &[Obstacle]) {
        for pair in self.world.narrow_phase.contact_pairs_with(self.shell) {
            let (other, sign) =
                if pair.collider1 == self.shell { (pair.collider2, 1.0) } else { (pair.collider1, -1.0) };
            let Some(index) = (self.world.colliders[other].user_data as usize).checked_sub(1) else { continue };
            let Some((manifold, deepest)) = pair.find_deepest_contact() else { continue };
            // rapier keeps pairs that will touch within the next step; touching is a force or an overlap.
            if self.cars[index].touched.is_some() || (pair.total_impulse_magnitude() <= 0.0 && deepest.dist > 0.0) {
                continue;
            }
            let obstacle = &obstacles[index];
            let car = (obstacle.pose.forward() * self.cars[index].speed_mps).as_vec2().extend(0.0);
            let closing = (before.linvel - car).dot(manifold.data.normal) * sign;
            self.cars[index].touched = Some(f64::from(closing.max(0.0)));
        }
    }

    /// Moves the frame's origin under the car by whole metres, which an f32 does without rounding.
    fn rebase(&mut self) {
        let here = self.chassis().translation();
        let shift = dvec2(f64::from(here.x), f64::from(here.y)).round();
        if shift.abs().max_element() < REBASE_M {
            return;
        }
        self.origin += shift;
        self.world.bodies[self.chassis].set_translation(here - shift.as_vec2().extend(0.0), true);
    }
}

/// Centre of gravity ahead of the middle of the body, metres.
fn cg_x(p: &CarParams) -> f32 {
    (p.body.front_axle_m - p.body.wheelbase_m * (1.0 - p.body.front_share)) as f32
}

/// Springs so long that the body stands level at height 0 in its own weight.
fn vehicle(chassis: RigidBodyHandle, p: &CarParams) -> DynamicRayCastVehicleController {
    let (b, s) = (&p.body, &p.suspension);
    let mut vehicle = DynamicRayCastVehicleController::new(chassis);
    vehicle.index_forward_axis = 0;
    vehicle.index_up_axis = 2;
    let axles = [(b.front_axle_m, b.front_share), (b.front_axle_m - b.wheelbase_m, 1.0 - b.front_share)];
    for ((x, share), ride_hz) in axles.into_iter().zip(s.ride_hz) {
        let omega = std::f64::consts::TAU * ride_hz;
        // rapier multiplies stiffness and damping by the whole mass; a wheel carries share / 2 of it. No spring gives
        // more than the whole weight: a car that was turned over must not be catapulted.
        let tuning = WheelTuning {
            suspension_stiffness: (share / 2.0 * omega * omega) as f32,
            suspension_compression: (share / 2.0 * 2.0 * s.bump_ratio * omega) as f32,
            suspension_damping: (share / 2.0 * 2.0 * s.rebound_ratio * omega) as f32,
            max_suspension_travel: s.travel_m as f32,
            side_friction_stiffness: 0.0,
            friction_slip: 1.0,
            max_suspension_force: b.mass_kg as f32 * GRAVITY,
        };
        let compression_m = f64::from(GRAVITY) / (omega * omega);
        let rest_m = compression_m + s.travel_m;
        let top_m = b.wheel_radius_m + s.travel_m;
        for side in [1.0, -1.0] {
            let hard_point = vec3(x as f32, (side * b.track_m / 2.0) as f32, top_m as f32);
            vehicle.add_wheel(
                hard_point,
                Vector::NEG_Z,
                Vector::NEG_Y,
                rest_m as f32,
                b.wheel_radius_m as f32,
                &tuning,
            );
        }
    }
    vehicle
}

fn frame_pose(pose: Pose, origin: DVec2) -> rapier3d::math::Pose {
    let translation = (pose.position - origin).as_vec2().extend(0.0);
    rapier3d::math::Pose::from_parts(translation, Quat::from_rotation_z(wrap_angle(pose.yaw_rad) as f32))
}
