//! Light and passes by numbers: the grey card, shadows that stay on the ground, lamps, nothing made while driving. In:
//! small stages and cameras made for each question. Out: properties of the pixels.

#[path = "pictures/place.rs"]
#[allow(dead_code, reason = "shared with the tests of pictures, which use the rest")]
mod place;

use codrive::{
    render::{OFFSCREEN, Quality, Renderer, sky::Sky},
    scene::{Camera, Lens, Mesh, Stage, Vertex, View, ViewKind, ViewOptions},
};
use glam::{Quat, Vec3};
use image::RgbaImage;
use place::*;

/// Light before the tone curve and after exposure, from a pixel: `develop.wgsl` backwards.
fn light_of(pixel: [f32; 3]) -> Vec3 {
    let linear = pixel.map(|v| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) });
    let mixed = linear.map(|y| {
        // y (x (2.43 x + 0.59) + 0.14) = x (2.51 x + 0.03)
        let (a, b, c) = (2.51 - 2.43 * y, 0.03 - 0.59 * y, -0.14 * y);
        (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a) / 0.72
    });
    // Each colour kept all but two shares of itself and took one share of either other.
    let spill = 0.006;
    let sum: f32 = mixed.iter().sum();
    Vec3::from(mixed.map(|m| (m - spill * sum) / (1.0 - 3.0 * spill)))
}

/// Mean light in a square of pixels around a point of the world.
fn light_at(image: &RgbaImage, view: &View, point: Vec3, half: i32) -> Vec3 {
    let (width, height) = (image.width() as f32, image.height() as f32);
    let at = view.camera.project(point, width / height).expect("in the picture");
    let (cx, cy) = ((at.x * width) as i32, (at.y * height) as i32);
    let mut sum = Vec3::ZERO;
    for y in cy - half..=cy + half {
        for x in cx - half..=cx + half {
            sum += light_of([0, 1, 2].map(|i| f32::from(image.get_pixel(x as u32, y as u32).0[i]) / 255.0));
        }
    }
    sum / ((2 * half + 1) * (2 * half + 1)) as f32
}

/// A level square, facing up, in one matt grey.
fn card(mesh: &mut Mesh, centre: Vec3, half_m: f32, grey: f32) {
    let first = mesh.vertices.len() as u32;
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        mesh.vertices.push(Vertex {
            position: (centre + Vec3::new(x, y, 0.0) * half_m).to_array(),
            normal: [0.0, 0.0, 1.0],
            colour: [grey; 3],
            ..Default::default()
        });
    }
    mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
}

/// Plan of 16 m around a point at 1.2 m above the ground.
fn from_above(view: &mut View, at: Vec3) {
    view.camera = Camera {
        eye: at + Vec3::Z * 3.0,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        lens: Lens::Parallel { half_extent_m: 8.0 },
    };
}

#[test]
fn a_grey_card_is_as_bright_as_the_sky_and_the_sun_make_it() {
    const GREY: f32 = 0.18;
    for (time_h, visibility_m) in [(9.75, 30_000.0), (7.0, 30_000.0), (14.0, 8000.0)] {
        let options = ViewOptions { visibility_m, ..ViewOptions::default() }.at_hour(time_h);
        let to_sun = options.to_sun();
        // A card above the bonnet, and above the camera a roof whose shadow falls on one half of it.
        let mut stage = Stage { car_body: Mesh::default(), ..stage(false).clone() };
        card(&mut stage.car_body, Vec3::Z * 1.2, 6.0, GREY);
        let height = 6.0;
        let pose = on_lane(40.0, 0.0);
        let body_from_world = Quat::from_rotation_z(-pose.yaw_rad as f32);
        card(&mut stage.car_body, Vec3::Z * 1.2 + body_from_world * to_sun * (height / to_sun.z), 1.5, GREY);
        let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Birdseye, &options);
        let middle = pose.position.as_vec2().extend(1.2);
        from_above(&mut view, middle);
        let mut renderer = Renderer::new(gpu(), &stage, OFFSCREEN, Quality::LOW);
        let image = draw_with(&mut renderer, &view, [160, 160]);

        let sky = Sky::new(to_sun, visibility_m);
        // Whole sphere by a fine grid of height and bearing: an integral of its own, not the renderer's harmonics.
        let mut from_sky = Vec3::ZERO;
        let (n, m) = (60, 90);
        for i in 0..n {
            let z = (i as f32 + 0.5) / n as f32;
            for j in 0..m {
                let (sin, cos) = (std::f32::consts::TAU * j as f32 / m as f32).sin_cos();
                let level = (1.0 - z * z).sqrt();
                from_sky += sky.radiance(Vec3::new(level * cos, level * sin, z)) * z * (2.0 / (n * m) as f32);
            }
        }
        let sunny = sky.exposure * GREY * (from_sky + sky.sun * to_sun.z);
        let shady = sky.exposure * GREY * from_sky;
        let away = Vec3::new(-to_sun.y, to_sun.x, 0.0).normalize() * 4.5;
        for (place, wanted, name) in [(middle + away, sunny, "sun"), (middle, shady, "shade")] {
            let seen = light_at(&image, &view, place, 3);
            let error = (seen / wanted - 1.0).dot(Vec3::new(0.2126, 0.7152, 0.0722));
            assert!(error.abs() < 0.05, "{time_h} h, {name}: {seen}, not {wanted}");
        }
    }
}
