//! The saloon that every car is: 5.00 m long, 1.80 m wide, 1.45 m high. Out: the body without wheels (x forward, y left,
//! z up, origin on the ground under the centre) and where the wheels sit. The body is lofted: at each of some fifty
//! stations along x a half cross-section of fourteen points, whose heights and widths follow `shape`.

use super::mesh::{Finish, Soup};
use super::shape::{self, ARCH_RADIUS_M, CABIN_FRONT_M, CABIN_REAR_M};
use super::{Material, Mesh};
use glam::{Vec2, Vec3};

/// Distance between the axles, metres.
pub const WHEELBASE_M: f32 = 2.8;
/// Distance between the middles of the tyres of one axle, metres.
pub const TRACK_M: f32 = 1.55;
/// Radius of a wheel, and height of its hub, metres.
pub const WHEEL_RADIUS_M: f32 = 0.33;

/// Points of a half section, from the middle of the floor round the left side to the middle of the top.
const POINTS: usize = 14;
/// Indices into a half section.
const FLOOR_EDGE: usize = 1;
const SILL: usize = 2;
const BELT: usize = 7;
const GLASS_LOW: usize = 8;
const GLASS_HIGH: usize = 9;
const ROOF_EDGE: usize = 10;

const PAINT: Finish = Finish::grey(Material::Paint, 1.0);
const DARK: Finish = Finish::grey(Material::Matt, 0.012);
const TRIM: Finish = Finish::grey(Material::Matt, 0.025);
const GLASS: Finish = Finish::new(Material::Glass, [0.020, 0.024, 0.028]);
const CHROME: Finish = Finish::grey(Material::Metal, 0.55);
const LAMP: Finish = Finish::grey(Material::Lamp, 0.85);
const BRAKE: Finish = Finish::new(Material::BrakeLamp, [0.32, 0.012, 0.012]);
const PLATE: Finish = Finish::grey(Material::Matt, 0.75);

/// Hubs in the body's frame at rest: front left, front right, rear left, rear right.
pub fn hubs() -> [Vec3; 4] {
    let hub = |x: f32, y: f32| Vec3::new(x * WHEELBASE_M, y * TRACK_M, 2.0 * WHEEL_RADIUS_M) / 2.0;
    [hub(1.0, 1.0), hub(1.0, -1.0), hub(-1.0, 1.0), hub(-1.0, -1.0)]
}

/// The body without wheels; about three thousand triangles.
pub fn body() -> Mesh {
    let mut soup = Soup::default();
    let stations = stations();
    let sections: Vec<[Vec3; POINTS]> = stations.iter().map(|&x| section(x)).collect();
    let mut left = Soup::default();
    for pair in sections.windows(2) {
        for j in 0..POINTS - 1 {
            let finish = side_finish(pair[0][j].x, pair[1][j].x, j);
            left.quad([pair[0][j], pair[0][j + 1], pair[1][j + 1], pair[1][j]], finish);
        }
    }
    cap(&mut left, &sections[0], false);
    cap(&mut left, &sections[sections.len() - 1], true);
    left.append(side_parts());
    soup.append(left.mirrored());
    soup.append(left);
    soup.append(middle_parts());
    soup.into_mesh(48f32.to_radians())
}

/// Where the cross-sections are, from the rear to the front.
fn stations() -> Vec<f32> {
    let mut xs = vec![-2.5, -2.49, -2.47, -2.43, -2.37, -2.28, -2.14, -2.0, CABIN_REAR_M - 0.05, CABIN_REAR_M];
    xs.extend([-0.93, -0.82, -0.62, -0.40, -0.15, 0.12, 0.24, 0.45, 0.75]);
    xs.extend([CABIN_FRONT_M, CABIN_FRONT_M + 0.07, 1.9, 2.03, 2.15, 2.25, 2.33, 2.39, 2.435, 2.465, 2.485, 2.5]);
    // Around each wheel arch: its lip rises on a circle and falls by an upright edge on either side.
    for hub in [-WHEELBASE_M / 2.0, WHEELBASE_M / 2.0] {
        for dx in [0.0, 0.13, 0.24, 0.32, 0.36, ARCH_RADIUS_M, ARCH_RADIUS_M + 0.004] {
            xs.extend([hub - dx, hub + dx]);
        }
    }
    for seam in SEAMS {
        xs.extend([seam - SEAM_M / 2.0, seam + SEAM_M / 2.0]);
    }
    xs.extend(PILLAR);
    xs.sort_by(f32::total_cmp);
    xs.dedup_by(|a, b| *a - *b < 1e-3);
    xs
}

/// Door edges.
const SEAMS: [f32; 3] = [-0.96, -0.01, 0.96];
/// Width of the gap between panels, metres.
const SEAM_M: f32 = 0.012;
/// The pillar between the side windows.
const PILLAR: [f32; 2] = [-0.06, 0.04];
/// Ends of the side windows.
const SIDE_GLASS: [f32; 2] = [-1.28, 0.80];
/// Rear window and windscreen, along x.
const REAR_GLASS: [f32; 2] = [CABIN_REAR_M + 0.03, -0.93];
const WINDSCREEN: [f32; 2] = [0.24, CABIN_FRONT_M];

/// The left half of the cross-section at `x`.
fn section(x: f32) -> [Vec3; POINTS] {
    let at = shape::at(x);
    let mut half = [Vec2::ZERO; POINTS];
    half[0] = Vec2::new(0.0, at.floor_z);
    half[FLOOR_EDGE] = Vec2::new(at.half_width - 0.14, at.floor_z);
    // The side: how far in from the widest, and how far up from sill to belt. Over a wheel the lower lines bunch at the
    // lip of the arch and the upper ones keep their height, so that the panel above it stays smooth.
    let rise = at.belt_z - at.sill_z;
    for (k, (inset, up)) in [(0.030, 0.03), (0.012, 0.20), (0.0, 0.44), (0.003, 0.64), (0.022, 0.91)].iter().enumerate()
    {
        let lip_z = at.floor_z + 0.012 * (k as f32 + 1.0);
        half[SILL + k] = Vec2::new(at.half_width - inset, (at.sill_z + rise * up).max(lip_z));
    }
    half[BELT] = Vec2::new(at.belt_y, at.belt_z);
    // From the belt over the glass (or the bonnet's shoulder) to the edge of the roof, and over it to the middle.
    half[ROOF_EDGE] = Vec2::new(at.roof_y, at.roof_z);
    half[GLASS_LOW] = at.shoulder(0.03 / (at.roof_z - at.belt_z).max(0.12));
    half[GLASS_HIGH] = at.shoulder(1.0 - 0.05 / (at.roof_z - at.belt_z).max(0.12));
    for (k, inwards) in [0.74, 0.40, 0.0].into_iter().enumerate() {
        let crown = 1.0 - inwards * inwards;
        half[ROOF_EDGE + 1 + k] = Vec2::new(at.roof_y * inwards, at.roof_z + (at.top_z - at.roof_z) * crown);
    }
    half.map(|p| Vec3::new(x, p.x, p.y))
}

/// What the skin is made of between two stations and between points `j` and `j + 1`.
fn side_finish(x0: f32, x1: f32, j: usize) -> Finish {
    let within = |[low, high]: [f32; 2]| x0 > low - 1e-3 && x1 < high + 1e-3;
    let seam = SEAMS.iter().any(|s| within([s - SEAM_M / 2.0, s + SEAM_M / 2.0]));
    match j {
        0 | FLOOR_EDGE => DARK,
        SILL if !(-2.2..=2.2).contains(&x0) => TRIM,
        SILL..=6 if seam => DARK,
        5 | 6 if within([2.15, 2.47]) => LAMP,
        5 if within([-2.5, -2.28]) => BRAKE,
        GLASS_LOW if within(PILLAR) => TRIM,
        GLASS_LOW if within(SIDE_GLASS) => GLASS,
        GLASS_HIGH if within(SIDE_GLASS) => TRIM,
        ROOF_EDGE.. if within(REAR_GLASS) || within(WINDSCREEN) => GLASS,
        GLASS_LOW.. if within([CABIN_FRONT_M, CABIN_FRONT_M + 0.07]) => TRIM,
        _ => PAINT,
    }
}

/// Closes the left half of an end: the rear (normal towards -x) or the front.
fn cap(soup: &mut Soup, outline: &[Vec3; POINTS], front: bool) {
    // Columns stand under the points of the upper outline, so that the cap meets it corner by corner.
    let columns: Vec<f32> = outline[BELT..].iter().map(|p| p.y / outline[BELT].y).collect();
    let place = |row: usize, column: usize| {
        let p = outline[row];
        Vec3::new(p.x, p.y * columns[column], p.z)
    };
    let mut face = |[a, b, c, d]: [Vec3; 4], finish: Finish| {
        soup.quad(if front { [d, c, b, a] } else { [a, b, c, d] }, finish);
    };
    for column in 0..columns.len() - 1 {
        // The floor has no corners between its middle and its edge, so the lowest row is a fan from there.
        let edge = outline[FLOOR_EDGE];
        face([edge, edge, place(SILL, column + 1), place(SILL, column)], TRIM);
        for row in SILL..BELT {
            let finish = if front { front_finish(row, column) } else { rear_finish(row, column) };
            face(
                [place(row, column), place(row, column + 1), place(row + 1, column + 1), place(row + 1, column)],
                finish,
            );
        }
        let (outer, inner) = (outline[BELT + column], outline[BELT + column + 1]);
        face([place(BELT, column), place(BELT, column + 1), inner, outer], PAINT);
    }
    let middle = place(SILL, columns.len() - 1);
    face([outline[FLOOR_EDGE], outline[0], middle, middle], TRIM);
}

fn rear_finish(row: usize, column: usize) -> Finish {
    match (row, column) {
        (SILL, _) => TRIM,
        (5, 0..=3) => BRAKE,
        _ => PAINT,
    }
}

fn front_finish(row: usize, column: usize) -> Finish {
    match (row, column) {
        (SILL, _) | (4, 3..) => TRIM,
        _ => PAINT,
    }
}

/// Parts that stand on both sides, left ones: door mirror, handles.
fn side_parts() -> Soup {
    let mut parts = Soup::default();
    // Mirror: the housing in the car's colour, its back dark as glass; a foot on the door.
    parts.ellipsoid(Vec3::new(0.74, 0.905, 0.985), Vec3::new(0.075, 0.085, 0.062), [6, 8], |outwards| {
        if outwards.x < -0.6 { GLASS } else { PAINT }
    });
    parts.cuboid(Vec3::new(0.76, 0.835, 0.945), Vec3::new(0.03, 0.035, 0.014), TRIM);
    for x in [0.12, -0.82] {
        parts.cuboid(Vec3::new(x, 0.893, 0.80), Vec3::new(0.085, 0.009, 0.011), PAINT);
    }
    parts
}

/// Parts in the middle: number plates, third brake lamp, grille bars, trim over the rear plate.
fn middle_parts() -> Soup {
    let mut parts = Soup::default();
    // Thin boxes that stand 1 mm out of the end planes would exceed 5.00 m, so they end at it.
    let plate = |parts: &mut Soup, x: f32, z: f32| {
        parts.cuboid(Vec3::new(x, 0.0, z), Vec3::new(0.004, 0.26, 0.056), PLATE);
    };
    plate(&mut parts, -2.4995, 0.70);
    plate(&mut parts, 2.4995, 0.42);
    parts.cuboid(Vec3::new(-2.4985, 0.0, 0.80), Vec3::new(0.005, 0.42, 0.010), CHROME);
    let lamp_x = -0.985;
    parts.cuboid(Vec3::new(lamp_x, 0.0, shape::at(lamp_x).top_z - 0.003), Vec3::new(0.018, 0.15, 0.009), BRAKE);
    // Nobody sees through the wheel arches to the other side.
    for hub in [-WHEELBASE_M / 2.0, WHEELBASE_M / 2.0] {
        parts.cuboid(Vec3::new(hub, 0.0, 0.45), Vec3::new(ARCH_RADIUS_M - 0.01, 0.55, 0.25), DARK);
    }
    // The bumper's upper edge.
    parts.cuboid(Vec3::new(-2.4985, 0.0, 0.575), Vec3::new(0.003, 0.62, 0.004), DARK);
    parts
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::{check, faces, open_edges, volume_m3, worst_agreement};
    use super::*;
    use crate::space::{CAR_LENGTH_M, CAR_WIDTH_M};

    #[test]
    fn the_body_is_as_long_and_wide_as_the_models_believe() {
        let body = body();
        check(&body, "body");
        let (low, high) = body.bounds();
        assert!(
            (f64::from(high.x - low.x) - CAR_LENGTH_M).abs() < 0.01 && (high.x + low.x).abs() < 0.005,
            "{low} {high}"
        );
        assert!((1.44..1.46).contains(&high.z), "{high}");
        assert!(high.y <= 1.0 && (high.y + low.y).abs() < 1e-5, "mirrors: {low} {high}");
        // Without the mirrors, which stand at 0.92 m and higher.
        let widest = body.vertices.iter().filter(|v| v.position[2] < 0.9).map(|v| v.position[1]).fold(0.0, f32::max);
        assert!((f64::from(widest) * 2.0 - CAR_WIDTH_M).abs() < 0.01, "{widest}");
    }

    #[test]
    fn the_body_is_closed_and_faces_outwards() {
        let body = body();
        assert_eq!(open_edges(&body), 0);
        // 5.0 x 1.8 x 1.45 m filled by a bit more than half.
        assert!((5.5..8.0).contains(&volume_m3(&body)), "{}", volume_m3(&body));
        assert!(worst_agreement(&body) > 0.6, "{}", worst_agreement(&body));
        assert!((2000..4000).contains(&body.triangles()), "{}", body.triangles());
    }

    #[test]
    fn wheels_touch_the_ground_and_fit_their_arches() {
        for hub in hubs() {
            assert_eq!(hub.z, WHEEL_RADIUS_M);
            for v in &body().vertices {
                let p = Vec3::from(v.position);
                let away = Vec2::new(p.x - hub.x, p.z - hub.z).length();
                let beside = (p.y - hub.y).abs() < 0.11;
                assert!(!beside || away > WHEEL_RADIUS_M + 0.02, "{p} in the wheel at {hub}");
            }
        }
    }

    #[test]
    fn lamps_are_where_lamps_are() {
        let middle = |material: Material| -> Vec<Vec3> {
            let of = |v: &super::super::Vertex| v.material == material as u32;
            faces(&body())
                .filter(|(corners, _)| of(&corners[0]))
                .map(|(corners, _)| corners.iter().map(|v| Vec3::from(v.position)).sum::<Vec3>() / 3.0)
                .collect()
        };
        let brake = middle(Material::BrakeLamp);
        assert!(brake.iter().any(|p| p.y > 0.4) && brake.iter().any(|p| p.y < -0.4), "left and right");
        assert!(brake.iter().any(|p| p.z > 1.3 && p.y.abs() < 0.1), "the third, high");
        assert!(brake.iter().filter(|p| p.z < 1.0).all(|p| p.x < -2.2));
        let head = middle(Material::Lamp);
        assert!(!head.is_empty() && head.iter().all(|p| p.x > 2.1 && p.y.abs() > 0.3));
    }
}
