//! Number plates can be read: the signs of the car's own number, upright, from either end; mirrored in the mirror alone.

use crate::{pixels::*, place::*};
use codrive::{
    hud::lettering,
    render::{OFFSCREEN, Quality, Renderer},
    scene::{Camera, Lens, ViewKind, plate},
};
use glam::{Vec2, Vec3};

const SIZE: [u32; 2] = [320, 64];
/// Half the width that a picture shows at the plate, metres.
const HALF_M: f32 = 0.26;
const DISTANCE_M: f32 = 4.0;

/// Whether ink is to be where a reader sees it, metres right of and above the plate's middle.
fn ink(number: u16, at: Vec2) -> bool {
    plate::signs(number).iter().any(|&(across, sign)| {
        let strokes = lettering::set(&sign.to_string()).strokes;
        strokes.iter().flat_map(|stroke| stroke.windows(2)).any(|ends| {
            let [a, b] = [ends[0], ends[1]].map(|[x, y]| Vec2::new(across, 0.0) + plate::SIGN_M * Vec2::new(x, -y));
            let t = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            at.distance(a.lerp(b, t)) < 0.5 * plate::PEN * plate::SIGN_M
        })
    })
}

/// Correlation of the picture's darkness with where ink should be, if `seen` turns a place of the picture into the reader's.
fn agreement(image: &image::RgbaImage, number: u16, seen: impl Fn(Vec2) -> Vec2) -> f32 {
    let (mut n, mut sums) = (0.0, [0.0f32; 5]);
    for (x, y, p) in image.enumerate_pixels() {
        let place = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new(SIZE[0] as f32, SIZE[1] as f32) - 0.5;
        let at = 2.0 * HALF_M * Vec2::new(place.x, -place.y * SIZE[1] as f32 / SIZE[0] as f32);
        // Between the blue field and the right edge, without the seals.
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
fn a_plate_reads_the_cars_own_number_the_right_way_up_at_both_ends() {
    let pose = on_lane(40.0, 0.0);
    let cars = [1, 2].map(|id| car(id, pose));
    let mut drawing = renderer_of();
    for (k, end) in [(0, -1.0f32), (0, 1.0), (1, -1.0), (1, 1.0)] {
        let id = cars[k].id;
        let number = plate::number(id.0);
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
            agreement(&seen, plate::number(id.0 + 1), |at| at),
        ];
        assert!(wrong.iter().all(|wrong| *wrong < upright - 0.2), "car {id:?}, end {end}: {upright}, {wrong:?}");
        let mirrored = agreement(&picture(ViewKind::Mirror), number, |at| at * Vec2::new(-1.0, 1.0));
        assert!(mirrored > 0.75, "car {id:?}, end {end}, in the mirror: {mirrored}");
    }
}

fn renderer_of() -> Renderer {
    Renderer::new(gpu(), stage(false), OFFSCREEN, Quality { msaa: 4, ..Quality::LOW })
}
