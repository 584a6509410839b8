//! Tests of number plates: the car's own number can be read upright at both ends, and is mirrored only in the mirror.

use crate::{pixels::*, place::*};
use codrive::{
    hud::lettering,
    render::{OFFSCREEN, Quality, Renderer},
    scene::{Camera, Lens, Mesh, StaticScene, ViewKind, car::number_plate},
};
use glam::{Vec2, Vec3};

const SIZE: [u32; 2] = [320, 64];
/// Half the width of the picture at the plate, m.
const HALF_M: f32 = 0.26;
const DISTANCE_M: f32 = 4.0;

/// Checks whether the plate has ink at `at`, metres right of and above its centre as the reader sees it.
fn ink(number: u16, at: Vec2) -> bool {
    number_plate::signs(number).iter().any(|&(across, sign)| {
        let strokes = lettering::set(&sign.to_string()).strokes;
        strokes.iter().flat_map(|stroke| stroke.windows(2)).any(|ends| {
            let [a, b] =
                [ends[0], ends[1]].map(|[x, y]| Vec2::new(across, 0.0) + number_plate::SIGN_M * Vec2::new(x, -y));
            let t = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            at.distance(a.lerp(b, t)) < 0.5 * number_plate::PEN * number_plate::SIGN_M
        })
    })
}

/// Returns the correlation of the picture's darkness with the expected ink. `seen` converts a place of the picture to the reader's frame.
fn agreement(image: &image::RgbaImage, number: u16, seen: impl Fn(Vec2) -> Vec2) -> f32 {
    let (mut n, mut sums) = (0.0, [0.0f32; 5]);
    for (x, y, p) in image.enumerate_pixels() {
        let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new(SIZE[0] as f32, SIZE[1] as f32) - 0.5;
        let at = 2.0 * HALF_M * Vec2::new(place.x, -place.y * SIZE[1] as f32 / SIZE[0] as f32);
        // The part between the blue field and the right edge, without the seals.
        let at = seen(at);
        if at.y.abs() > 0.045 || !(-0.20..0.24).contains(&at.x) || (-0.07..-0.02).contains(&at.x) {
            continue;
        }
        let (a, b) = (1.0 - luminance(rgb(p)), f32::from(u8::from(ink(number, at))));
        n += 1.0;
        [a, b, a * a, b * b, a * b].into_iter().zip(&mut sums).for_each(|(v, sum)| *sum += v);
    }
    let [a, b, aa, bb, ab] = sums.map(|sum| sum / n);
    (ab - a * b) / ((aa - a * a) * (bb - b * b)).sqrt().max(1e-6)
}

#[test]
fn a_plate_shows_the_cars_own_number_upright_at_both_ends() {
    let pose = on_lane(40.0, 0.0);
    let cars = [1, 2].map(|id| car(id, pose));
    let mut drawing = renderer_of();
    for (k, end) in [(0, -1.0f32), (0, 1.0), (1, -1.0), (1, 1.0)] {
        let id = cars[k].id;
        let number = number_plate::number(id.0);
        let mut picture = |kind: ViewKind| {
            let mut view = view(&snapshot(vec![cars[k]]), kind, &Default::default());
            view.cars.retain(|car| !car.is_ego);
            (view.mirror, view.seat) = (None, None);
            let along = pose.forward().as_vec2().extend(0.0) * end;
            let middle = pose.position.as_vec2().extend(if end > 0.0 { 0.442 } else { 0.692 }) + along * 2.47;
            let fov_x_rad = 2.0 * (HALF_M / DISTANCE_M).atan();
            let lens = Lens::Perspective { fov_x_rad };
            view.camera = Camera { eye: middle + along * DISTANCE_M, forward: -along, up: Vec3::Z, lens };
            draw_with(&mut drawing, &view, SIZE)
        };
        let seen = picture(ViewKind::Chase);
        let upright = agreement(&seen, number, |at| at);
        assert!(upright > 0.75, "car {id:?}, end {end}: {upright}");
        let wrong = [
            agreement(&seen, number, |at| -at),
            agreement(&seen, number, |at| at * Vec2::new(1.0, -1.0)),
            agreement(&seen, number_plate::number(id.0 + 1), |at| at),
        ];
        assert!(wrong.iter().all(|wrong| *wrong < upright - 0.2), "car {id:?}, end {end}: {upright}, {wrong:?}");
        let mirrored = agreement(&picture(ViewKind::Mirror), number, |at| at * Vec2::new(-1.0, 1.0));
        assert!(mirrored > 0.75, "car {id:?}, end {end}, in the mirror: {mirrored}");
    }
}

/// Returns the mean light of a plate's signs, their contrast (standard deviation over mean), and the width of a sign in pixels. The plate
/// is seen from straight behind at this distance. The values are means of four pictures with the plate shifted by parts of a pixel.
fn plate_at(drawing: &mut Renderer, distance_m: f32) -> (f32, f32, f32) {
    let all = [0.0, 0.25, 0.5, 0.75].map(|off_px| plate_beside(drawing, distance_m, off_px));
    let mean = |of: fn(&(f32, f32, f32)) -> f32| all.iter().map(of).sum::<f32>() / all.len() as f32;
    (mean(|p| p.0), mean(|p| p.1), all[0].2)
}

fn plate_beside(drawing: &mut Renderer, distance_m: f32, off_px: f32) -> (f32, f32, f32) {
    // The middle of a picture of 320 pixels with a lens of 10 degrees: at 12 m the plate has 79 pixels.
    const SIZE: [u32; 2] = [96, 54];
    let half_width = 5f32.to_radians().tan() * SIZE[0] as f32 / 320.0;
    let pose = on_lane(40.0, 0.0);
    let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Chase, &Default::default());
    view.cars.retain(|car| !car.is_ego);
    let along = pose.forward().as_vec2().extend(0.0);
    let middle = pose.position.as_vec2().extend(0.692) - along * 2.47;
    let lens = Lens::Perspective { fov_x_rad: 2.0 * half_width.atan() };
    let pixel_m = 2.0 * distance_m * half_width / SIZE[0] as f32;
    // To the left and up, so that the plate appears to the right and below.
    let aside = (Vec3::Z.cross(along) + Vec3::Z) * (off_px * pixel_m);
    view.camera = Camera { eye: middle - along * distance_m + aside, forward: along, up: Vec3::Z, lens };
    let image = draw_with(drawing, &view, SIZE);
    // Pixels of the plate from `left_m` on, with weights. Pixels that may reach beyond the plate are left out; those at that border count
    // by their share.
    let share = |at: f32, low: f32, high: f32| ((at + 0.5).min(high) - (at - 0.5).max(low)).clamp(0.0, 1.0);
    let lights = |left_m: f32| -> Vec<(f32, f32)> {
        let [left, right, high] = [left_m, 0.26, 0.052].map(|m| m / pixel_m);
        let weighed = image.enumerate_pixels().map(|(x, y, p)| {
            let off =
                Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - 0.5 * Vec2::new(SIZE[0] as f32, SIZE[1] as f32) - off_px;
            let weight = share(off.x, left + 1.0, right - 1.0) * share(off.y, 1.0 - high, high - 1.0);
            (weight, light(luminance(rgb(p))))
        });
        weighed.filter(|(weight, _)| *weight > 0.0).collect()
    };
    let mean_of = |lights: &[(f32, f32)], of: &dyn Fn(f32) -> f32| {
        let weight: f32 = lights.iter().map(|(weight, _)| weight).sum();
        lights.iter().map(|(weight, v)| weight * of(*v)).sum::<f32>() / weight
    };
    // The part right of the blue field.
    let signs = lights(-0.215);
    let mean = mean_of(&signs, &|v| v);
    let spread = mean_of(&signs, &|v| (v - mean) * (v - mean));
    (mean, spread.sqrt() / mean, 0.67 * number_plate::SIGN_M / pixel_m)
}

#[test]
fn a_plate_blends_with_distance_and_does_not_switch_off() {
    // Nothing is between vehicle and camera: no posts, no grass.
    let bare = StaticScene { posts: Mesh::default(), tuft_places: Vec::new(), ..static_scene(false).clone() };
    for quality in [Quality::MEDIUM, Quality::LOW] {
        let mut drawing = Renderer::new(gpu(), &bare, OFFSCREEN, quality);
        let mut before: Option<(f32, f32, f32, f32)> = None;
        let mut distance_m = 12.0f32;
        // Up to the distance at which a plate is two pixels high.
        while distance_m < 88.0 {
            let (mean, contrast, sign_px) = plate_at(&mut drawing, distance_m);
            println!("{distance_m:6.1} m: mean {mean:.3}, contrast {contrast:.3}, sign {sign_px:.1} px");
            // Signs of three pixels are visible: a contrast of a tenth is ten times the eye's threshold of 1 %.
            assert!(sign_px < 3.0 || contrast > 0.10, "{distance_m} m: contrast {contrast} at {sign_px} pixels");
            if let Some((metres, light, seen, px)) = before {
                // The eye does not see a change of less than a tenth on a patch of a few minutes of arc. The contrast fades and does not
                // switch: one step changes it by at most 0.15, a quarter of the 0.6 of a sharp sign.
                let step = (mean / light - 1.0).abs();
                assert!(step < 0.09, "{metres} to {distance_m} m: mean light changes by {step}");
                assert!((contrast - seen).abs() < 0.15, "{metres} m, {px} px: {seen}, then {contrast}");
            }
            before = Some((distance_m, mean, contrast, sign_px));
            distance_m *= 1.06;
        }
    }
}

fn renderer_of() -> Renderer {
    Renderer::new(gpu(), static_scene(false), OFFSCREEN, Quality { msaa: 4, ..Quality::LOW })
}
