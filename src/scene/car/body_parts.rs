//! Parts fixed to a body (mirrors, handles, plates, grille bars, projectors, third brake lamp) and the interior seen through the
//! windows (seats, dashboard, a driver). In: the body's lines. Out: loose triangles in the body's frame, metres. No part reaches
//! beyond the body's 5.00 m.

use super::{
    body_profile::{self, BodyLines},
    materials::{ARCH_RADIUS_M, CHROME, DARK, GLOSS, HIGH_BRAKE, LampLevel, PAINT, TRIM, WHEEL_RADIUS_M, WHEELBASE_M},
    number_plate,
};
use crate::scene::{
    Material, Mesh,
    mesh::{SurfaceFinish, TriangleList},
};
use glam::Vec3;

const PLATE: SurfaceFinish = SurfaceFinish::grey(Material::Plate, number_plate::SURFACE);
const PLATE_FIELD: [f32; 3] = [0.010, 0.045, 0.26];
/// Mean finish of a plate with its signs and its blue field, which covers a twelfth of it.
const PLATE_AFAR: SurfaceFinish = SurfaceFinish::new(
    Material::Matt,
    [
        number_plate::MEAN + (PLATE_FIELD[0] - number_plate::MEAN) / 12.0,
        number_plate::MEAN + (PLATE_FIELD[1] - number_plate::MEAN) / 12.0,
        number_plate::MEAN + (PLATE_FIELD[2] - number_plate::MEAN) / 12.0,
    ],
);
/// Half the thickness of a plate, metres.
const PLATE_M: f32 = 0.0035;
const SEAT: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.045);
const CLOTH: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.055, 0.065, 0.095]);
const SKIN: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.36, 0.21, 0.145]);
const HAIR: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.030, 0.020, 0.014]);

/// Returns the parts outside the body.
pub(in crate::scene) fn outside(lines: &BodyLines, level: LampLevel) -> TriangleList {
    let mut all = TriangleList::default();
    let left = side(lines, level);
    all.append(left.mirrored());
    all.append(left);
    all.append(middle(lines, level));
    all
}

/// Returns the left one of each pair of parts.
fn side(lines: &BodyLines, level: LampLevel) -> TriangleList {
    let mut parts = TriangleList::default();
    // Mirror: the housing in the car's colour, its glass dark; a foot on the door.
    let fine = match level {
        LampLevel::Near => [10, 16],
        LampLevel::Mid => [5, 7],
        LampLevel::Far => [3, 5],
    };
    parts.ellipsoid(Vec3::new(0.745, 0.912, 0.992), Vec3::new(0.070, 0.088, 0.060), fine, |outwards| match outwards {
        o if o.x < -0.62 => GLASS_BACK,
        o if o.z < -0.45 => GLOSS,
        _ => PAINT,
    });
    if level == LampLevel::Far {
        return parts;
    }
    parts.cuboid(Vec3::new(0.76, 0.840, 0.950), Vec3::new(0.026, 0.045, 0.013), GLOSS);
    let fine = if level == LampLevel::Near { [8, 12] } else { [3, 4] };
    for x in [0.13, -0.79] {
        let y = body_profile::at(lines, x).side(0.80).x;
        parts.ellipsoid(Vec3::new(x, y - 0.002, 0.792), Vec3::new(0.100, 0.011, 0.014), fine, |_| PAINT);
    }
    if level != LampLevel::Near {
        return parts;
    }
    for hub in [-WHEELBASE_M / 2.0, WHEELBASE_M / 2.0] {
        parts.append(lip(lines, hub));
    }
    // Two projectors behind the clear cover, each a bowl with a lens.
    for (y, x) in [(0.515, 2.5), (0.600, 2.5), (0.672, 2.5)] {
        let at = body_profile::bend(lines, Vec3::new(x, y, 0.613)) - Vec3::new(0.050, 0.022, 0.0);
        parts.ellipsoid(at, Vec3::new(0.022, 0.029, 0.026), [6, 10], |_| CHROME);
        parts.ellipsoid(at + Vec3::X * 0.010, Vec3::new(0.020, 0.021, 0.019), [6, 10], |_| GLASS_BACK);
    }
    parts
}

/// Glass that is not transparent: mirrors, lenses of lamps.
const GLASS_BACK: SurfaceFinish = SurfaceFinish::new(Material::Lamp, [0.020, 0.024, 0.028]);

/// Draws the edge of a wheel arch: a rim that stands out 4 mm.
fn lip(lines: &BodyLines, hub: f32) -> TriangleList {
    const PLACES: usize = 25;
    let mut lip = TriangleList::default();
    let ring = |i: usize| {
        let turn = -0.33 + (std::f32::consts::PI + 0.66) * i as f32 / (PLACES - 1) as f32;
        let (sin, cos) = turn.sin_cos();
        let point = |radius_m: f32, out_m: f32| {
            let (x, z) = (hub + radius_m * cos, WHEEL_RADIUS_M + radius_m * sin);
            let at = body_profile::at(lines, x);
            let y = at.side(((z - at.sill_z) / (at.belt_z - at.sill_z)).clamp(0.0, 1.0)).x;
            Vec3::new(x, y + out_m, z)
        };
        let r = ARCH_RADIUS_M;
        vec![
            point(r - 0.008, -0.03),
            point(r + 0.030, -0.004),
            point(r + 0.012, 0.0035),
            point(r - 0.004, 0.0035),
            point(r - 0.008, -0.002),
        ]
    };
    lip.bar(PLACES, ring, PAINT);
    lip
}

/// Returns the position of the plates as (x, z): rear, front.
fn plates(lines: &BodyLines, level: LampLevel) -> [(f32, f32); 2] {
    let z = 0.692;
    // Without the recess the boot lid bulges through the plate.
    let x = if level == LampLevel::Near { -2.5 + 0.046 + 0.020 } else { rearmost(lines, z) + PLATE_M - 0.004 };
    [(x, z), (2.4985, 0.442)]
}

/// Returns the signs on the plates; none at the far level, where each would be smaller than a pixel.
pub(in crate::scene) fn lettering(lines: &BodyLines, level: LampLevel) -> Mesh {
    let mut all = Mesh::default();
    for (x, z) in plates(lines, level).into_iter().filter(|_| level != LampLevel::Far) {
        all.append(&number_plate::lettering(Vec3::new(x + (PLATE_M + 0.0008) * x.signum(), 0.0, z), x.signum(), level));
    }
    all
}

/// Returns the parts in the middle of the body.
fn middle(lines: &BodyLines, level: LampLevel) -> TriangleList {
    let mut parts = TriangleList::default();
    let near = level == LampLevel::Near;
    // No part exceeds the bumpers by more than 2 mm: the body would be longer than 5.00 m.
    for (x, z) in plates(lines, level) {
        let plate = if level == LampLevel::Far { PLATE_AFAR } else { PLATE };
        parts.cuboid(Vec3::new(x, 0.0, z), Vec3::new(PLATE_M, 0.26, 0.052), plate);
        if level == LampLevel::Mid {
            let at = Vec3::new(x + 0.0010 * x.signum(), -0.239 * x.signum(), z);
            parts.cuboid(at, Vec3::new(PLATE_M, 0.021, 0.052), SurfaceFinish::new(Material::Matt, PLATE_FIELD));
        }
        if near {
            // A dark holder behind, the blue field at the reader's left, two seals between letters and digits.
            let out = |m: f32| Vec3::X * (m * x.signum());
            parts.cuboid(Vec3::new(x, 0.0, z) - out(0.003), Vec3::new(0.003, 0.268, 0.060), TRIM);
            let mut field = |aside: f32, up: f32, half: [f32; 2], colour: [f32; 3]| {
                let at = Vec3::new(x, aside * x.signum(), z + up) + out(0.0036);
                parts.cuboid(at, Vec3::new(0.0005, half[0], half[1]), SurfaceFinish::new(Material::Matt, colour));
            };
            field(-0.239, 0.0, [0.021, 0.052], PLATE_FIELD);
            for (up, half, colour) in [(0.019, 0.012, [0.06, 0.17, 0.09]), (-0.017, 0.014, [0.30, 0.31, 0.34])] {
                let at = Vec3::new(x, -0.045 * x.signum(), z + up) + out(PLATE_M);
                parts.ellipsoid(at, Vec3::new(0.0008, half, half), [6, 10], |_| {
                    SurfaceFinish::new(Material::Matt, colour)
                });
            }
        }
    }
    let lamp_x = lines.rear_glass[1] + 0.03;
    let lamp_z = body_profile::at(lines, lamp_x).top_z - 0.003;
    // The housing hides the lamp from ahead: no red light may show through the windscreen.
    parts.cuboid(Vec3::new(lamp_x, 0.0, lamp_z), Vec3::new(0.018, 0.151, 0.010), GLOSS);
    parts.cuboid(Vec3::new(lamp_x - 0.019, 0.0, lamp_z), Vec3::new(0.002, 0.15, 0.009), HIGH_BRAKE);
    if !near {
        return parts;
    }
    // Grille: bars across the dark opening, bowed as the nose is; a badge.
    for z in [0.532, 0.558, 0.584, 0.610] {
        let reach = 0.37 - 0.9 * (z - 0.572f32).abs();
        let ring = |i: usize| {
            let y = reach * (1.0 - 2.0 * i as f32 / 12.0);
            let at = body_profile::bend(lines, Vec3::new(2.5, y, z)) - Vec3::X * 0.020;
            [(0.012, 0.0), (0.0, -0.005), (-0.012, 0.0), (0.0, 0.005)].map(|(x, z)| at + Vec3::new(x, 0.0, z)).into()
        };
        parts.bar(13, ring, GLOSS);
    }
    let badge = body_profile::bend(lines, Vec3::new(2.5, 0.0, 0.572)) - Vec3::X * 0.006;
    parts.ellipsoid(badge, Vec3::new(0.010, 0.050, 0.036), [10, 18], |_| CHROME);
    let badge = body_profile::bend(lines, Vec3::new(-2.5, 0.0, 0.858)) + Vec3::X * 0.002;
    parts.ellipsoid(badge, Vec3::new(0.006, 0.036, 0.018), [8, 14], |_| CHROME);
    wipers(lines, &mut parts);
    // An aerial on the roof.
    let x = lines.rear_glass[1] + 0.26;
    let z = body_profile::at(lines, x).top_z - 0.006;
    parts.ellipsoid(Vec3::new(x, 0.0, z), Vec3::new(0.075, 0.016, 0.026), [8, 10], |_| PAINT);
    parts
}

/// Returns the smallest x of the boot lid behind a plate whose middle is at the height `z`.
fn rearmost(lines: &BodyLines, z: f32) -> f32 {
    let points = [-0.26, -0.13, 0.0, 0.13, 0.26].into_iter().flat_map(|y| [-0.052, 0.0, 0.052].map(|up| (y, z + up)));
    points.map(|(y, z)| body_profile::bend(lines, Vec3::new(-2.5, y, z)).x).fold(0.0, f32::min)
}

/// Draws the wipers at rest along the foot of the windscreen.
fn wipers(lines: &BodyLines, parts: &mut TriangleList) {
    for (from, to) in [(0.58, 0.02), (-0.02, -0.52)] {
        let ring = |i: usize| {
            let t = i as f32 / 8.0;
            let x = 1.105 - 0.03 * t;
            let y = from + (to - from) * t;
            let z = body_profile::at(lines, x).top_z - 0.05 * (y / 0.7) * (y / 0.7);
            let at = body_profile::bend(lines, Vec3::new(x, y, z)) + Vec3::Z * 0.010;
            [(-0.008, -0.004), (0.008, -0.006), (0.005, 0.006), (-0.006, 0.008)]
                .map(|(x, z)| at + Vec3::new(x, 0.0, z))
                .into()
        };
        parts.bar(9, ring, GLOSS);
    }
}

/// Returns the interior seen through the windows, with a dark floor below.
pub(in crate::scene) fn cabin(lines: &BodyLines, level: LampLevel) -> TriangleList {
    let mut all = TriangleList::default();
    let fine =
        |rings: usize, sides: usize| if level == LampLevel::Near { [rings, sides] } else { [rings / 2, sides / 2] };
    let (rear, front) = (lines.cabin_rear_m + 0.12, 1.05);
    let floor = Vec3::new((rear + front) / 2.0, 0.0, 0.78);
    all.cuboid(floor, Vec3::new((front - rear) / 2.0, 0.80, 0.02), DARK);
    // Dashboard, parcel shelf, steering wheel. The dashboard is 4 cm below that of the cockpit: this body casts the ego's shadow, and
    // at the same height it would cover the cockpit's dashboard with stripes.
    all.ellipsoid(Vec3::new(0.90, 0.0, 0.80), Vec3::new(0.26, 0.74, 0.085), fine(12, 14), |_| TRIM);
    all.cuboid(Vec3::new(-1.42, 0.0, 0.88), Vec3::new(0.22, 0.62, 0.05), TRIM);
    for y in [-0.36, 0.36] {
        seat(&mut all, Vec3::new(-0.16, y, 0.0), fine(8, 10));
    }
    for y in [-0.40, 0.0, 0.40] {
        seat(&mut all, Vec3::new(-1.05, y, -0.05), fine(6, 8));
    }
    driver(&mut all, fine(8, 12));
    let n = fine(24, 6)[0];
    let rim = |i: usize| {
        let (sin, cos) = (std::f32::consts::TAU * (i % n) as f32 / n as f32).sin_cos();
        let (out, up) = (Vec3::new(-0.40 * sin, cos, 0.92 * sin), Vec3::new(-0.92, 0.0, -0.40));
        let at = Vec3::new(0.52, 0.36, 0.93) + out * 0.175;
        [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(a, b)| at + (out * a + up * b) * 0.014).into()
    };
    all.bar(n + 1, rim, DARK);
    all
}

/// Draws a driver: torso, shoulders, arms, neck, a head with hair.
fn driver(all: &mut TriangleList, fine: [usize; 2]) {
    let y = 0.36;
    let mut ball = |at: [f32; 3], half: [f32; 3], finish: SurfaceFinish| {
        all.ellipsoid(Vec3::from(at), Vec3::from(half), fine, |_| finish);
    };
    ball([-0.03, y, 0.92], [0.120, 0.185, 0.200], CLOTH);
    ball([-0.04, y, 1.055], [0.085, 0.215, 0.062], CLOTH);
    for side in [-1.0, 1.0] {
        ball([0.11, y + 0.205 * side, 0.945], [0.150, 0.045, 0.050], CLOTH);
        ball([0.32, y + 0.185 * side, 0.935], [0.120, 0.034, 0.036], CLOTH);
        ball([0.45, y + 0.165 * side, 0.965], [0.045, 0.030, 0.034], SKIN);
    }
    ball([-0.02, y, 1.125], [0.050, 0.050, 0.075], SKIN);
    ball([0.02, y, 1.245], [0.092, 0.072, 0.112], SKIN);
    ball([-0.012, y, 1.272], [0.098, 0.082, 0.104], HAIR);
    ball([0.105, y, 1.235], [0.018, 0.013, 0.022], SKIN);
}

/// Draws backrest and headrest of a seat; its cushion would be below the windows.
fn seat(all: &mut TriangleList, at: Vec3, fine: [usize; 2]) {
    all.ellipsoid(at + Vec3::new(-0.07, 0.0, 0.90), Vec3::new(0.085, 0.235, 0.235), fine, |_| SEAT);
    all.ellipsoid(at + Vec3::new(-0.13, 0.0, 1.20), Vec3::new(0.048, 0.125, 0.078), fine, |_| SEAT);
}
