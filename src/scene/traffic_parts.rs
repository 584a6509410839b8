//! Vehicles of the traffic between two ticks. In: a [`VehicleSnapshot`], the clock's fraction. Out: the instances of its parts, on the road
//! with their wheels, metres from the scene's origin.

use super::{
    CarInstance, StaticScene,
    car::{materials::WHEEL_RADIUS_M, number_plate},
    network::layer::Layer,
    vehicles,
};
use crate::{
    map::network::{EdgeKind, LanePosition},
    sim::{Snapshot, VehicleSnapshot},
    space::{Pose, wrap_angle},
    traffic::{Articulation, VehicleBody, VehicleId, VehicleKind, VehiclePart},
};
use glam::{Quat, Vec3};
use std::f64::consts::TAU;

/// Distance from the ego beyond which a vehicle stands on the middle of its lane, metres. The search for the road under four wheels of each of a
/// town's vehicles took a tenth of a frame.
const FAR_M: f64 = 180.0;

/// Returns the parts of a vehicle between two ticks, the front one first; `ego` is the ego's place in the scene.
pub(super) fn traffic_parts(
    car: &VehicleSnapshot,
    fraction: f32,
    colour: [f32; 3],
    ego: Vec3,
    static_scene: &StaticScene,
) -> impl Iterator<Item = CarInstance> {
    let share = f64::from(fraction);
    let pose = car.pose_before.lerp(&car.pose, share);
    let bent = car.articulation_before.zip(car.articulation).map(|(before, now)| before.lerp(&now, share));
    let parts = car.body.parts(&pose, bent.or(car.articulation));
    parts.enumerate().map(move |(k, part)| traffic_part(car, (k, part), fraction, (colour, ego), static_scene))
}

/// Returns the body and the drawn parts of each vehicle, the ego's first. `cars` are the parts of all of them, in the same order.
pub(super) fn drawn_vehicles<'a>(
    snapshot: &'a Snapshot,
    cars: &'a [CarInstance],
) -> impl Iterator<Item = (VehicleBody, &'a [CarInstance])> {
    let bodies = std::iter::once(VehicleBody::CAR).chain(snapshot.cars.iter().map(|car| car.body));
    let mut rest = cars;
    bodies.map_while(move |body| {
        let (parts, others) = rest.split_at_checked(body.parts(&Pose::default(), None).count())?;
        rest = others;
        Some((body, parts))
    })
}

/// Returns a part of a vehicle, given its index from the front.
fn traffic_part(
    car: &VehicleSnapshot,
    (part, VehiclePart { pose, length_m }): (usize, VehiclePart),
    fraction: f32,
    (colour, ego): ([f32; 3], Vec3),
    static_scene: &StaticScene,
) -> CarInstance {
    let pose = Pose { position: pose.position - static_scene.origin.truncate(), ..pose };
    let height_m = car.height_m - static_scene.origin.z;
    let rest_m = (1.0 - f64::from(fraction)) * car.pose_before.position.distance(car.pose.position);
    let shape = vehicles::shape(&car.body, part, length_m, &static_scene.hubs);
    let radius_m = WHEEL_RADIUS_M * shape.wheel_scale.x;
    let spin = ((car.odometer_m - rest_m) / f64::from(radius_m)).rem_euclid(TAU);
    let posture = vehicles::posture(car.body.kind, car.id.0, car.odometer_m - rest_m, car.speed_mps.abs());
    // Ackermann: the steering angle that rolls the vehicle along the bend under its centre. The wheels behind a joint do not steer.
    let wheelbase_m = shape.hubs[0].x - shape.hubs[2].x;
    let bend_per_m = if part == 0 { bend_per_m(car) } else { 0.0 };
    let lean = Quat::from_rotation_y(-(car.pitch.before_rad + (car.pitch.now_rad - car.pitch.before_rad) * fraction));
    let is_far = pose.position.distance(ego.truncate().as_dvec2()) > FAR_M;
    let on_lane = is_far.then(|| lane_under(car, pose, &shape.hubs, static_scene)).flatten();
    let (road_m, normal) = on_lane.unwrap_or_else(|| road_under(pose, height_m, &shape.hubs, static_scene));
    let rotation = Quat::from_rotation_arc(Vec3::Z, normal) * Quat::from_rotation_z(pose.yaw_rad as f32);
    let foot_m =
        if car.body.kind == VehicleKind::Pedestrian { road_m + kerb_m(pose, height_m, static_scene) } else { road_m };
    CarInstance {
        position: pose.position.as_vec2().extend(foot_m),
        rotation: rotation * lean,
        colour,
        brake: f32::from(u8::from(car.lamps.brake)),
        scale: shape.scale,
        // The wheels stay on the road when the body pitches.
        hubs: shape.hubs.map(|hub| lean.inverse() * hub),
        wheel_scale: shape.wheel_scale,
        steer_rad: (wheelbase_m * bend_per_m).atan(),
        spin_rad: spin as f32,
        style: shape
            .style
            .map_or_else(|| style(car.id), |first| first + posture.map_or(0, |posture| posture.model))
            .min(static_scene.cars.len().saturating_sub(1)),
        plate: posture.map_or_else(|| number_plate::number(car.id.0), |posture| posture.code),
        is_parked: false,
        is_ego: false,
    }
}

/// Returns the height of a walking person's feet over the road, metres: that of the pavement, or 0 beside pavements.
fn kerb_m(pose: Pose, height_m: f64, static_scene: &StaticScene) -> f32 {
    let network = &static_scene.network;
    let on_pavement = network
        .locate(pose.position.extend(height_m), None)
        .is_some_and(|at| network.lane(at.lane).is_footway() && network.edge_of(at.lane).kind != EdgeKind::Crossing);
    if on_pavement { Layer::Pavement.z_m() } else { 0.0 }
}

/// Returns the height of the road under a vehicle's centre, and the unit normal of the plane that its wheels stand on. `height_m` is about
/// that of the road, as SUMO has it under the front bumper.
fn road_under(pose: Pose, height_m: f64, hubs: &[Vec3; 4], static_scene: &StaticScene) -> (f32, Vec3) {
    if let Some(level_m) = static_scene.level_m {
        return (level_m, Vec3::Z);
    }
    let (ahead, left) = (pose.forward(), pose.left());
    let hubs = apart(hubs);
    let [front_left, front_right, rear_left, rear_right] = hubs.map(|hub| {
        let wheel = Pose { position: pose.position + ahead * f64::from(hub.x) + left * f64::from(hub.y), ..pose };
        static_scene.road_at(wheel, height_m).map_or(height_m as f32, |(road_m, _)| road_m)
    });
    let [wheelbase_m, track_m] = [hubs[0].x - hubs[2].x, hubs[0].y - hubs[1].y];
    let grade = (front_left + front_right - rear_left - rear_right) / (2.0 * wheelbase_m);
    // A cycle's wheels have no track.
    let bank = if track_m > 0.1 { (front_left + rear_left - front_right - rear_right) / (2.0 * track_m) } else { 0.0 };
    let middle_x = (hubs[0].x + hubs[2].x) / 2.0;
    let road_m = (front_left + front_right + rear_left + rear_right) / 4.0 - grade * middle_x;
    let uphill = ahead.as_vec2() * grade + left.as_vec2() * bank;
    (road_m, (-uphill).extend(1.0).normalize())
}

/// Returns the same of a vehicle's lane along its middle; `None` where the part is not on the lane of the front bumper alone.
fn lane_under(car: &VehicleSnapshot, pose: Pose, hubs: &[Vec3; 4], static_scene: &StaticScene) -> Option<(f32, Vec3)> {
    let (at, network) = (car.lane?, &static_scene.network);
    let front = car.pose.front(car.body.length_m) - static_scene.origin.truncate();
    let behind_m = (front - pose.position).dot(pose.forward());
    let [front_axle, _, rear_axle, _] = apart(hubs);
    let [front_m, rear_m] = [front_axle, rear_axle].map(|hub| at.s_m - behind_m + f64::from(hub.x));
    let lane_m = 0.0..=network.lane(at.lane).line.length_m();
    let is_within = [front_m, rear_m].iter().all(|s_m| lane_m.contains(s_m));
    let height_m = |s_m: f64| network.pose(LanePosition { s_m, ..at }).position.z as f32;
    is_within.then(|| {
        let grade = (height_m(front_m) - height_m(rear_m)) / (front_axle.x - rear_axle.x);
        let road_m = height_m(front_m) - grade * front_axle.x;
        (road_m, (-pose.forward().as_vec2() * grade).extend(1.0).normalize())
    })
}

/// Returns the points on which a part stands: its hubs, or points ahead of them and behind them where it has one axle.
fn apart(hubs: &[Vec3; 4]) -> [Vec3; 4] {
    const HALF_M: f32 = 1.5;
    let [front_left, front_right, rear_left, rear_right] = *hubs;
    if front_left.x > rear_left.x {
        return *hubs;
    }
    let along = Vec3::X * HALF_M;
    [front_left + along, front_right + along, rear_left - along, rear_right - along]
}

/// Returns the body style of a car, which is constant; three of seven cars are saloons.
pub(super) fn style(id: VehicleId) -> usize {
    [0, 1, 0, 2, 0, 1, 2][id.0 as usize % 7]
}

/// Returns the curvature of a vehicle's path in the last tick, 1/m, positive to the left.
fn bend_per_m(car: &VehicleSnapshot) -> f32 {
    // The wheels straighten as the vehicle stops, because a path of zero length has no direction.
    const STANDING_M: f64 = 0.3 * crate::time::TICK_S;
    // Radius of at least 5 m.
    const MOST_PER_M: f64 = 0.2;
    let way_m = car.pose_before.position.distance(car.pose.position);
    let heading = |pose: &Pose, bent: Option<Articulation>| bent.map_or(pose.yaw_rad, |bent| bent.front_yaw_rad);
    let before_rad = heading(&car.pose_before, car.articulation_before);
    let turn_rad = wrap_angle(heading(&car.pose, car.articulation) - before_rad);
    (turn_rad / way_m.max(STANDING_M)).clamp(-MOST_PER_M, MOST_PER_M) as f32
}
