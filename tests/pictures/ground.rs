//! Tests of the meadow by its pixels: equal brightness from afar and near by, no repetition, no broken pixel.

use crate::{pixels::*, place::*};
use codrive::{
    rng,
    scene::{Camera, Lens, View, ViewKind, ViewOptions},
};
use glam::{Vec2, Vec3};
use image::RgbaImage;

/// Draws a plan of `2 * half_m` metres around a point of the meadow, from too high for tufts of grass.
fn plan(at: Vec2, half_m: f32, side: u32) -> RgbaImage {
    let mut view = view(&snapshot(Vec::new()), ViewKind::Birdseye, &ViewOptions::default());
    view.camera = Camera {
        eye: at.extend(90.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        lens: Lens::Parallel { half_extent_m: half_m },
    };
    draw(&view, false, [side, side])
}

/// Returns the mean light of the middle square of `2 * half` pixels. Pixels are decoded roughly to light, as only light may be averaged.
fn light(image: &RgbaImage, half: u32) -> f32 {
    let middle = image.width() / 2;
    let mut sum = 0.0;
    for y in middle - half..middle + half {
        for x in middle - half..middle + half {
            let p = rgb(image.get_pixel(x, y)).map(|v| (v / (1.0 - v).max(0.01)).powf(1.0 / 1.08));
            sum += luminance(p);
        }
    }
    sum / (4 * half * half) as f32
}

#[test]
fn the_meadow_is_as_bright_from_afar_as_from_near_by() {
    // The same 12 m by 12 m, in pixels of 5, 25 and 60 cm.
    for at in [Vec2::new(0.0, 0.0), Vec2::new(12.0, -9.0), Vec2::new(62.0, 20.0), Vec2::new(-55.0, -31.0)] {
        let near = light(&plan(at, 6.0, 240), 120);
        for pixel_m in [0.25f32, 0.6] {
            let far = light(&plan(at, pixel_m * 60.0, 120), (6.0 / pixel_m) as u32);
            assert!((far / near - 1.0).abs() < 0.06, "{at}, pixels of {pixel_m} m: {far}, near by {near}");
        }
    }
}

/// Returns the largest correlation of the picture's detail with itself, shifted by 10 to 100 pixels along rows, columns or both, and that
/// shift.
fn repetition(image: &RgbaImage) -> (f32, [u32; 2]) {
    let n = image.width() as usize;
    let raw: Vec<f32> = image.pixels().map(|p| luminance(rgb(p))).collect();
    // Remove structure wider than 15 pixels: patches are not repetitions.
    let mut sums = vec![0.0f32; (n + 1) * (n + 1)];
    for y in 0..n {
        for x in 0..n {
            sums[(y + 1) * (n + 1) + x + 1] =
                raw[y * n + x] + sums[y * (n + 1) + x + 1] + sums[(y + 1) * (n + 1) + x] - sums[y * (n + 1) + x];
        }
    }
    let detail = |x: usize, y: usize| {
        let (l, r, t, b) = (x.saturating_sub(7), (x + 8).min(n), y.saturating_sub(7), (y + 8).min(n));
        let sum = sums[b * (n + 1) + r] - sums[t * (n + 1) + r] - sums[b * (n + 1) + l] + sums[t * (n + 1) + l];
        raw[y * n + x] - sum / ((r - l) * (b - t)) as f32
    };
    let detail: Vec<f32> = (0..n * n).map(|i| detail(i % n, i / n)).collect();
    let mut worst = (0.0, [0, 0]);
    for dy in (0..=100).step_by(1) {
        for dx in (0..=100).step_by(1) {
            if dx.max(dy) < 10 {
                continue;
            }
            let (mut both, mut a2, mut b2) = (0.0, 0.0, 0.0);
            for y in (0..n - dy).step_by(3) {
                for x in (0..n - dx).step_by(2) {
                    let (a, b) = (detail[y * n + x], detail[(y + dy) * n + x + dx]);
                    both += a * b;
                    a2 += a * a;
                    b2 += b * b;
                }
            }
            let alike = both / f32::sqrt(a2 * b2).max(1e-9);
            if alike > worst.0 {
                worst = (alike, [dx as u32, dy as u32]);
            }
        }
    }
    worst
}

#[test]
fn the_meadow_has_no_repetition_in_the_birds_eye_view() {
    // Pixels of 9 cm, as in a picture of the ring 1920 pixels wide, and of 20 cm. Chance alone reaches 0.03.
    for (half_m, at) in [(11.5, Vec2::new(0.0, 0.0)), (25.6, Vec2::new(2.0, -3.0))] {
        let (alike, moved) = repetition(&plan(at, half_m, 256));
        assert!(alike < 0.12, "pixels of {} m: alike by {alike} when moved by {moved:?}", half_m / 128.0);
    }
}

#[test]
fn no_pixel_is_white_or_broken_at_any_camera_pose() {
    let mut random = rng::stream(1, "test");
    let mut draw_number = |low: f64, high: f64| random.uniform(low, high) as f32;
    let mut renderer = renderer(true, codrive::render::Quality::LOW);
    for k in 0..60 {
        // Three hours give the sun three heights.
        let options = ViewOptions::default().at_hour([7.0, 10.0, 16.5][k / 20]);
        let mut view: View = view(&full_ring(), ViewKind::Chase, &options);
        let eye = Vec3::new(draw_number(-70.0, 70.0), draw_number(-70.0, 70.0), draw_number(1.0, 12.0));
        let way = Vec2::from_angle(draw_number(0.0, std::f64::consts::TAU)).extend(draw_number(-0.4, 0.25));
        view.camera = Camera { eye, forward: way.normalize(), up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 1.1 } };
        let image = draw_with(&mut renderer, &view, [128, 72]);
        // The sun's disc is white; NaN is drawn black or white.
        let white = pixels(&image, |p| p.iter().all(|v| *v > 0.985)).len();
        let black = pixels(&image, |p| p.iter().all(|v| *v < 0.002)).len();
        assert!(white <= 12 && black == 0, "pose {k}: {white} white, {black} black pixels from {eye} to {way}");
    }
}

#[test]
fn grass_bends_with_the_wind_that_is_set_and_stands_still_without() {
    // Change of a picture of the verge, without trees, in 0.7 s.
    let moved = |wind_mps: f32| {
        let picture = |time_s: f32| {
            let options = ViewOptions { wind_mps, ..ViewOptions::default() };
            let mut view = view(&snapshot(Vec::new()), ViewKind::Chase, &options);
            view.cars.clear();
            view.time_s = time_s;
            draw(&view, false, [240, 135])
        };
        let (before, after) = (picture(5.0), picture(5.7));
        before.pixels().zip(after.pixels()).map(|(a, b)| u32::from(difference(a, b))).sum::<u32>()
    };
    let [none, breeze, strong] = [0.0, 2.5, 8.0].map(moved);
    assert_eq!(none, 0);
    assert!(breeze > 1000 && strong > breeze + breeze / 4, "{breeze} in a breeze, {strong} in a strong wind");
}
