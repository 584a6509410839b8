//! Tests of many camera poses, hours and weathers: light is a number, and no picture is burnt out.

use crate::place::gpu;
use codrive::{
    map::{self, RoadMap},
    render::{OFFSCREEN, Quality, Renderer, render_to_light},
    rng,
    scene::{self, Camera, Lens, StaticScene, ViewKind, ViewOptions},
    sim::Snapshot,
};
use glam::{DVec2, Vec3};

const POSES: usize = 500;
const SIZE: [u32; 2] = [48, 27];

/// Returns a snapshot with a vehicle every 12 m, on any map.
fn snapshot(map: &RoadMap) -> Snapshot {
    let mut snapshot = crate::place::snapshot(Vec::new());
    let route = &map.route;
    let n = (route.length_m() / 12.0) as u32;
    snapshot.cars = (1..n)
        .map(|id| {
            let front_s_m = route.wrap(12.0 * f64::from(id));
            let pose = route.pose_of_front(front_s_m, codrive::space::CAR_LENGTH_M);
            codrive::sim::VehicleSnapshot { pose, pose_before: pose, ..crate::place::car(id, pose) }
        })
        .collect();
    snapshot
}

#[test]
fn no_pixel_is_nan_or_white_in_500_random_poses_on_every_map() {
    let maps = map::list();
    assert!(maps.len() >= 3, "the maps of maps/");
    // One thread per map: while one waits for its picture, another prepares its own.
    std::thread::scope(|scope| {
        for info in &maps {
            scope.spawn(|| update_derived_state(&info.name));
        }
    });
}

fn update_derived_state(name: &str) {
    let map = RoadMap::load(name).expect("a map that is shipped");
    let static_scene = StaticScene::build(&map, 1);
    let mut renderer = Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality { shadow_size: 256, ..Quality::LOW });
    let snapshot = snapshot(&map);
    let mut random = rng::stream(1, "poses");
    let mut draw = |low: f64, high: f64| random.uniform(low, high);
    let mut options = ViewOptions::default();
    for pose in 0..POSES {
        // The hour changes only every 25 poses, as each hour needs a new sky. It rains in every fifth of them.
        if pose % 25 == 0 {
            let rain_mmph = if pose % 125 == 50 { draw(0.1, 50.0) as f32 } else { 0.0 };
            options = ViewOptions { visibility_m: draw(1e3, 1e5) as f32, rain_mmph, ..ViewOptions::default() }
                .at_hour(draw(0.0, 24.0) as f32);
        }
        let mut view = scene::view(&snapshot, 1.0, ViewKind::Chase, &options, &static_scene);
        // Near the road, from 0.2 m above the ground to above the trees; looking level, down or up; with wide or narrow lenses.
        let beside = DVec2::new(draw(-15.0, 15.0), draw(-15.0, 15.0));
        let place = map.route.point_at(draw(0.0, map.route.length_m())) + beside;
        let eye = place.as_vec2().extend((0.2 * 300f64.powf(draw(0.0, 1.0))) as f32);
        let (yaw, up) = (draw(0.0, std::f64::consts::TAU) as f32, draw(-0.99, 0.6) as f32);
        let level = (1.0 - up * up).sqrt();
        let forward = Vec3::new(level * yaw.cos(), level * yaw.sin(), up);
        view.camera =
            Camera { eye, forward, up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: draw(0.3, 1.8) as f32 } };
        let light = render_to_light(gpu(), &mut renderer, &view, SIZE).unwrap_or_else(|e| panic!("{e}"));
        let seen = || format!("{} pose {pose}: eye {eye}, forward {forward}", map.name);
        let wrong = light.iter().position(|pixel| pixel.iter().any(|v| !(v.is_finite() && *v >= 0.0)));
        assert_eq!(wrong.map(|k| (k, light[k])), None, "{}, pixel and its light", seen());
        assert!(light.iter().any(|p| p[0] > 0.0), "{}: black", seen());
        // The sun and its glints may be white, but not a large part of the picture.
        let white = light.iter().filter(|p| p[0].min(p[1]).min(p[2]) > 4.0).count();
        assert!(white <= light.len() / 20, "{}: {white} white pixels", seen());
    }
}
