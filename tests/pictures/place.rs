//! Shared scene of these tests: `ring-250`, with and without trees, a renderer for each, and vehicles at chosen places.

use codrive::{
    ego::{EgoState, WheelPose},
    map::RoadMap,
    render::{Gpu, OFFSCREEN, Quality, Renderer, render_to_image},
    scene::{self, StaticScene, View, ViewKind, ViewOptions},
    sim::{Snapshot, VehicleSnapshot},
    space::{CAR_LENGTH_M, Pose},
    time::Tick,
    traffic::{EGO, VehicleId},
};
use glam::{Quat, Vec3};
use image::RgbaImage;
use std::sync::{Mutex, OnceLock};

/// Paint that nothing in the world has, linear.
pub const MAGENTA: [f32; 3] = [0.75, 0.0, 0.75];
/// Circumference of the ring, m.
pub const RING_M: f64 = 250.0;

pub fn gpu() -> &'static Gpu {
    Gpu::shared().unwrap_or_else(|e| panic!("{e}"))
}

pub fn map() -> &'static RoadMap {
    static MAP: OnceLock<RoadMap> = OnceLock::new();
    MAP.get_or_init(|| RoadMap::load("ring-250").expect("a map that is shipped"))
}

/// Returns the scene with trees, or the bare land, where nothing hides a vehicle.
pub fn static_scene(trees: bool) -> &'static StaticScene {
    static STAGES: OnceLock<[StaticScene; 2]> = OnceLock::new();
    &STAGES.get_or_init(|| [StaticScene::with_trees(map(), 1, 0), StaticScene::build(map(), 1)])[usize::from(trees)]
}

/// Draws with a renderer that all tests share.
pub fn draw(view: &View, trees: bool, size: [u32; 2]) -> RgbaImage {
    static RENDERERS: [OnceLock<Mutex<Renderer>>; 2] = [OnceLock::new(), OnceLock::new()];
    let renderer = RENDERERS[usize::from(trees)].get_or_init(|| Mutex::new(renderer(trees, Quality::LOW)));
    draw_with(&mut renderer.lock().unwrap_or_else(|e| e.into_inner()), view, size)
}

pub fn renderer(trees: bool, quality: Quality) -> Renderer {
    Renderer::new(gpu(), static_scene(trees), OFFSCREEN, quality)
}

pub fn draw_with(renderer: &mut Renderer, view: &View, size: [u32; 2]) -> RgbaImage {
    render_to_image(gpu(), renderer, view, size).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns a vehicle of the traffic with its centre at `pose`.
pub fn car(id: u32, pose: Pose) -> VehicleSnapshot {
    let s_m = map().route.project(pose.position, None).s_m + CAR_LENGTH_M / 2.0;
    VehicleSnapshot {
        id: VehicleId(id),
        pose,
        pose_before: pose,
        s_m: Some(s_m),
        speed_mps: 4.0,
        odometer_m: s_m,
        ..VehicleSnapshot::default()
    }
}

/// Returns the pose on the lane with the front bumper at `front_s_m`, shifted to the left by `left_m`.
pub fn on_lane(front_s_m: f64, left_m: f64) -> Pose {
    let pose = map().route.pose_of_front(map().route.wrap(front_s_m), CAR_LENGTH_M);
    Pose::new(pose.position + pose.left() * left_m, pose.yaw_rad)
}

/// Returns a snapshot with the ego's front bumper at 0 and the other vehicles.
pub fn snapshot(cars: Vec<VehicleSnapshot>) -> Snapshot {
    let pose = on_lane(0.0, 0.0);
    let wheels = static_scene(false).hubs.map(|hub| WheelPose { hub, ..Default::default() });
    let ego = EgoState {
        position: pose.position.extend(0.0),
        rotation: Quat::from_rotation_z(pose.yaw_rad as f32),
        wheels,
        ..Default::default()
    };
    Snapshot { tick: Tick(500), ego, ego_before: ego, cars, mean_speed_mps: 4.0, ..Snapshot::default() }
}

/// Returns the full ring: 22 vehicles at equal distances, every third of the traffic braking.
pub fn full_ring() -> Snapshot {
    let mut cars: Vec<VehicleSnapshot> = (1..22).map(|i| car(i, on_lane(f64::from(i) * RING_M / 22.0, 0.0))).collect();
    cars.iter_mut().step_by(3).for_each(|car| car.lamps.brake = true);
    snapshot(cars)
}

/// Returns options in which vehicle 1 is magenta.
pub fn marked() -> ViewOptions {
    let mut options = ViewOptions::default();
    options.paint_overrides.insert(VehicleId(1), MAGENTA);
    options
}

/// Returns options in which the ego is magenta and all others green. A lit lamp on blue paint would look magenta at its edge.
pub fn marked_ego() -> ViewOptions {
    let mut options = ViewOptions { ordinary_paints: false, ..Default::default() };
    options.paint_overrides.insert(EGO, MAGENTA);
    options
}

pub fn view(snapshot: &Snapshot, kind: ViewKind, options: &ViewOptions) -> View {
    scene::view(snapshot, 1.0, kind, options, static_scene(true))
}

/// Returns the corners of the box around a vehicle's body, in world axes.
pub fn corners(pose: &Pose) -> impl Iterator<Item = Vec3> {
    let (at, along, left) = (pose.position.as_vec2(), pose.forward().as_vec2(), pose.left().as_vec2());
    (0..8).map(move |i| {
        let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
        (at + along * 2.5 * sign(1) + left * 0.9 * sign(2)).extend(if i & 4 == 0 { 0.1 } else { 1.45 })
    })
}
