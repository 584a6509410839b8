//! The ego's rigid body and the bodies of other vehicles and fixed objects, in rapier. In: poses of obstacles, forces of tyres and
//! air. Out: pose and velocity of the body, wheel rays, contacts. Values are `f32` in a frame whose origin follows the
//! ego in whole metres, so that they are precise to a millimetre anywhere in the world.
//!
//! rapier's ray-cast vehicle carries the body on its springs. Its wheel friction is off because it creeps sideways at a
//! standstill (it removes a fifth of the slip in a step and has no static grip); `tyre` takes its place.

use super::{Contact, EgoState, Obstacle, ObstacleId, params::CarParams};
use crate::space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, wrap_angle};
use glam::{DVec2, Quat, Vec3, dvec2, vec3};
use rapier3d::{
    control::{DynamicRayCastVehicleController, WheelTuning},
    prelude::*,
};

/// Standard gravity, m/s².
pub(super) const GRAVITY: f32 = 9.81;
/// Height of the other vehicles, and of the ego's roof, m.
const ROOF_M: f32 = 1.4;
/// Ground clearance of the boxes, m: the springs' travel never brings the ego's box to the road.
const CLEARANCE_M: f32 = 0.25;
/// Half height of the other vehicles' boxes, m: tall boxes push an overlapping ego sideways, never into the road.
const WALL_M: f32 = 4.0;
/// Distance within which a vehicle takes part in the physics, m from centre to centre; half of its length beyond the
/// ego's length is added. The distance covers two lengths and the approach of two vehicles at 60 m/s within a tick.
const NEAR_M: f64 = 15.0;
/// Movement within a tick from which a vehicle counts as repositioned, m: it gets no velocity from such a movement.
const JUMP_M: f64 = 1.5;
/// Distance of the ego from the frame's origin at which the origin moves, m: below 32 m an f32 resolves 2 micrometres.
const REBASE_M: f64 = 32.0;

/// State of one wheel in this sub-step, in world axes relative to the frame's origin.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WheelContact {
    /// Contact point with the ground, m.
    pub point: Vec3,
    /// Load, N, at least 0.
    pub load_n: f32,
    /// Length of the spring, m.
    pub length_m: f32,
}

pub(super) struct CarBody {
    world: PhysicsWorld,
    vehicle: DynamicRayCastVehicleController,
    chassis: RigidBodyHandle,
    shell: ColliderHandle,
    /// Bodies of the other vehicles, including bodies without a vehicle at present.
    cars: Vec<ObstacleBody>,
    /// Index in `cars` of each obstacle of this tick, in the order of the obstacles.
    slots: Vec<usize>,
    /// Gravity, m/s², in axes whose x-y plane is the road's plane.
    gravity: Vec3,
    /// World position of the frame's origin.
    origin: DVec2,
    mass_kg: f32,
    anti_roll_npm: [f32; 2],
    dt: f32,
}

/// Body of another vehicle.
struct ObstacleBody {
    body: RigidBodyHandle,
    collider: ColliderHandle,
    /// Identifier and part of the vehicle that uses this body; `None` for an unused body.
    id: Option<(ObstacleId, u8)>,
    /// Length and width, m.
    size_m: [f64; 2],
    /// Pose at the end of the last tick; `None` before the first.
    pose: Option<Pose>,
    speed_mps: f64,
    touched: Option<f64>,
}

impl CarBody {
    pub fn new(p: &CarParams, start: Pose, start_speed_mps: f64, cars: usize, dt: f32) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = dt;
        // Weight is applied as an impulse together with the springs (see `springs`), so that a standing ego is exactly
        // at rest.
        world.gravity = Vector::ZERO;
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(SharedShape::halfspace(Vector::Z)).friction(0.6));
        let half_z = (ROOF_M - CLEARANCE_M) / 2.0;
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
            shell(half_z),
        );
        let cars = (0..cars).map(|slot| ObstacleBody::new(&mut world, slot)).collect();
        let anti_roll_npm = p.suspension.anti_roll_npm.map(|k| k as f32);
        let vehicle = vehicle(chassis, p);
        Self {
            world,
            vehicle,
            chassis,
            shell: shell_handle,
            cars,
            slots: Vec::new(),
            gravity: vec3(0.0, 0.0, -GRAVITY),
            origin,
            mass_kg: b.mass_kg as f32,
            anti_roll_npm,
            dt,
        }
    }

    pub fn chassis(&self) -> &RigidBody {
        &self.world.bodies[self.chassis]
    }

    /// Returns the world position of a point of the frame.
    pub fn world_from_frame(&self, point: Vec3) -> DVec2 {
        self.origin + dvec2(f64::from(point.x), f64::from(point.y))
    }

    /// Sets the rise of the road per metre to the east and to the north. rapier's plane is the road's plane, and
    /// gravity is inclined in it.
    pub fn set_gradient(&mut self, gradient: DVec2) {
        let cos = 1.0 / (1.0 + gradient.length_squared()).sqrt();
        self.gravity = if gradient == DVec2::ZERO {
            vec3(0.0, 0.0, -GRAVITY)
        } else {
            (-gradient * cos).extend(-cos).as_vec3() * GRAVITY
        };
    }

    /// Prepares a tick: keeps the frame near the ego, and enables the bodies of near vehicles.
    pub fn begin_tick(&mut self, obstacles: &[Obstacle]) {
        self.assign(obstacles);
        self.rebase();
        let here = self.world_from_frame(self.chassis().translation());
        for (slot, obstacle) in self.slots.iter().zip(obstacles) {
            let car = &mut self.cars[*slot];
            car.touched = None;
            if car.pose.is_none() {
                car.speed_mps = obstacle.speed_mps;
            }
            let from = car.pose.filter(|pose| pose.position.distance(obstacle.pose.position) < JUMP_M);
            let from = *car.pose.insert(from.unwrap_or(obstacle.pose));
            let near = obstacle.pose.is_finite()
                && obstacle.pose.position.distance(here) < NEAR_M + (longer_m(obstacle) - CAR_LENGTH_M) / 2.0;
            // rapier lists every mutably accessed body as changed, so only bodies that change are accessed.
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

    /// Assigns a body to each obstacle: the one it had before, or an unused one.
    fn assign(&mut self, obstacles: &[Obstacle]) {
        let stays = |(slot, obstacle): (&usize, &Obstacle)| self.cars[*slot].id == Some(obstacle.key());
        if self.slots.len() == obstacles.len() && self.slots.iter().zip(obstacles).all(stays) {
            return;
        }
        for car in &mut self.cars {
            if car.id.is_some_and(|id| obstacles.iter().all(|obstacle| obstacle.key() != id)) {
                (car.id, car.pose, car.touched) = (None, None, None);
                if self.world.bodies[car.body].is_enabled() {
                    self.world.bodies[car.body].set_enabled(false);
                }
            }
        }
        self.slots.clear();
        for obstacle in obstacles {
            let known = self.cars.iter().position(|car| car.id == Some(obstacle.key()));
            let slot = known.or_else(|| self.cars.iter().position(|car| car.id.is_none())).unwrap_or(self.cars.len());
            if slot == self.cars.len() {
                self.cars.push(ObstacleBody::new(&mut self.world, slot));
            }
            let car = &mut self.cars[slot];
            car.id = Some(obstacle.key());
            let size_m = [obstacle.length_m, obstacle.width_m];
            if car.size_m != size_m {
                car.size_m = size_m;
                let [x, y] = size_m.map(|size_m| size_m as f32 / 2.0);
                self.world.colliders[car.collider].set_shape(SharedShape::cuboid(x, y, WALL_M));
            }
            self.slots.push(slot);
        }
    }

    /// Returns the downhill component of the weight, N; zero on a flat road.
    pub fn downhill_n(&self) -> Vec3 {
        vec3(self.gravity.x, self.gravity.y, 0.0) * self.mass_kg
    }

    /// Applies weight and springs for one sub-step. Returns the contact of each wheel.
    pub fn springs(&mut self) -> [WheelContact; 4] {
        let world = &mut self.world;
        let queries = world.broad_phase.as_query_pipeline_mut(
            world.narrow_phase.query_dispatcher(),
            &mut world.bodies,
            &mut world.colliders,
            QueryFilter::only_fixed(),
        );
        self.vehicle.update_vehicle(self.dt, queries);
        // Applied after the springs: before them, their dampers would take the impulse for a movement.
        let weight = vec3(0.0, 0.0, self.gravity.z) * self.mass_kg * self.dt;
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

    /// Applies a force for this sub-step, N, at a point of the frame.
    pub fn push(&mut self, force: Vec3, point: Vec3) {
        self.world.bodies[self.chassis].apply_impulse_at_point(force * self.dt, point, true);
    }

    /// Moves all bodies by one sub-step; the other vehicles move to `fraction` of their way in this tick.
    pub fn step(&mut self, obstacles: &[Obstacle], fraction: f64) {
        for (slot, obstacle) in self.slots.iter().zip(obstacles) {
            let car = &self.cars[*slot];
            let enabled = self.world.bodies[car.body].is_enabled();
            if let Some(from) = car.pose.filter(|_| enabled) {
                let body = &mut self.world.bodies[car.body];
                let mut next = frame_pose(from.lerp(&obstacle.pose, fraction), self.origin);
                // Beyond a heading of west the quaternion changes sign, which rapier would take for a full turn within
                // a sub-step.
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

    /// Completes a tick: lists the vehicles touched in it, with the speeds from before it.
    pub fn end_tick(&mut self, before: &EgoState, obstacles: &[Obstacle], contacts: &mut Vec<Contact>) {
        contacts.clear();
        let (ego_speed_mps, yaw_rad) = (before.speed_mps, before.pose().yaw_rad);
        for (slot, obstacle) in self.slots.iter().zip(obstacles) {
            let car = &mut self.cars[*slot];
            if let Some(closing_mps) = car.touched {
                let angle_rad = wrap_angle(obstacle.pose.yaw_rad - yaw_rad);
                let car_speed_mps = car.speed_mps;
                contacts.push(Contact { with: obstacle.id, ego_speed_mps, car_speed_mps, closing_mps, angle_rad });
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
            let Some(at) = self.slots.iter().position(|slot| *slot == index) else { continue };
            let Some((manifold, deepest)) = pair.find_deepest_contact() else { continue };
            // rapier keeps pairs that will touch within the next step; a contact needs a force or an overlap.
            if self.cars[index].touched.is_some() || (pair.total_impulse_magnitude() <= 0.0 && deepest.dist > 0.0) {
                continue;
            }
            let obstacle = &obstacles[at];
            let car = (obstacle.pose.forward() * self.cars[index].speed_mps).as_vec2().extend(0.0);
            let closing = (before.linvel - car).dot(manifold.data.normal) * sign;
            self.cars[index].touched = Some(f64::from(closing.max(0.0)));
        }
    }

    /// Moves the frame's origin below the ego by whole metres, which an f32 represents without rounding.
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

impl ObstacleBody {
    /// Creates an unused body of the ego's length and width.
    fn new(world: &mut PhysicsWorld, slot: usize) -> Self {
        let body = RigidBodyBuilder::kinematic_position_based().enabled(false).can_sleep(false);
        let (body, collider) = world.insert(body, shell(WALL_M).user_data(slot as u128 + 1));
        Self {
            body,
            collider,
            id: None,
            size_m: [CAR_LENGTH_M, CAR_WIDTH_M],
            pose: None,
            speed_mps: 0.0,
            touched: None,
        }
    }
}

/// Returns the longer side of an obstacle, m.
fn longer_m(obstacle: &Obstacle) -> f64 {
    obstacle.length_m.max(obstacle.width_m)
}

/// Returns the box of a vehicle with this half height, m.
fn shell(half_height_m: f32) -> ColliderBuilder {
    let [half_x, half_y] = [CAR_LENGTH_M as f32 / 2.0, CAR_WIDTH_M as f32 / 2.0];
    ColliderBuilder::cuboid(half_x, half_y, half_height_m)
        .translation(vec3(0.0, 0.0, CLEARANCE_M + (ROOF_M - CLEARANCE_M) / 2.0))
        .density(0.0)
        .friction(0.3)
        .restitution(0.05)
}

/// Returns the distance of the centre of gravity ahead of the body's middle, m.
fn cg_x(p: &CarParams) -> f32 {
    (p.body.front_axle_m - p.body.wheelbase_m * (1.0 - p.body.front_share)) as f32
}

/// Creates rapier's vehicle with springs so long that the body stands level at height 0 under its own weight.
fn vehicle(chassis: RigidBodyHandle, p: &CarParams) -> DynamicRayCastVehicleController {
    let (b, s) = (&p.body, &p.suspension);
    let mut vehicle = DynamicRayCastVehicleController::new(chassis);
    vehicle.index_forward_axis = 0;
    vehicle.index_up_axis = 2;
    let axles = [(b.front_axle_m, b.front_share), (b.front_axle_m - b.wheelbase_m, 1.0 - b.front_share)];
    for ((x, share), ride_hz) in axles.into_iter().zip(s.ride_hz) {
        let omega = std::f64::consts::TAU * ride_hz;
        // rapier multiplies stiffness and damping by the whole mass; a wheel carries share / 2 of it. A spring force is
        // limited to the whole weight, so that an overturned ego is not catapulted.
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
