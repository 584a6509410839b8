//! Lettering of number plates. In: the instrument's strokes ([`crate::hud::lettering`]). Out: for each place on a plate every
//! sign that may stand there, as flat triangles in the body's frame, metres. The car's shader draws only the signs of the car's
//! number (`surface.wgsl`), so that one body serves all cars at no cost per pixel.
//!
//! A sign's texture coordinates state when it is shown. `u` is the divisor; `v` is 16 times the number of signs for the place
//! plus the sign's index. The sign is shown if `number / u` modulo that number of signs equals its index.

use super::materials::LampLevel;
use crate::{
    hud::lettering,
    scene::{Material, Mesh, Vertex},
};
use glam::{Vec2, Vec3};

/// Height of the signs, metres.
pub const SIGN_M: f32 = 0.075;
/// Width of the strokes as a share of the height of the signs.
pub const PEN: f32 = 0.15;
/// Upper limit of the numbers on plates (exclusive); the lower limit is a tenth of it.
const NUMBERS: u32 = 10_000;
/// Places on a plate: distance of the sign's middle to the right of the plate's middle, metres; divisor; signs.
const PLACES: [(f32, u16, &str); 6] = [
    (-0.165, 7, "HLMR"),
    (-0.101, 31, "KNTE"),
    (0.012, 1000, "0123456789"),
    (0.074, 100, "0123456789"),
    (0.136, 10, "0123456789"),
    (0.198, 1, "0123456789"),
];
const INK: f32 = 0.010;
/// Grey of a plate's surface, linear.
pub(in crate::scene) const SURFACE: f32 = 0.66;
/// Mean grey of surface and signs, shown where signs are too small to be read (same value in `car.wgsl`).
pub(in crate::scene) const MEAN: f32 = 0.50;
/// Tolerance for omitted points of a stroke, as a share of the height of the signs: near by, and where a sign is three pixels
/// wide.
const COARSE: [f32; 2] = [0.012, 0.035];

/// Returns the number on the plates of the car `id`; unique among any 9000 consecutive ids.
pub fn number(id: u32) -> u16 {
    let free = NUMBERS - NUMBERS / 10;
    // A step that shares no factor with `free` reaches every number once.
    (NUMBERS / 10 + (id % free * 2741 + 3862) % free) as u16
}

/// Returns the signs on the plates of a car with this number, each with the distance of its middle to the right of the plate's
/// middle, metres.
pub fn signs(number: u16) -> [(f32, char); 6] {
    PLACES.map(|(at, divisor, signs)| {
        let own = usize::from(number / divisor) % signs.len();
        (at, signs.as_bytes()[own] as char)
    })
}

/// Returns all signs of a plate whose surface has its middle at `middle`; `outwards` is 1 for the front plate, -1 for the rear
/// plate.
pub(in crate::scene) fn lettering(middle: Vec3, outwards: f32, level: LampLevel) -> Mesh {
    let coarse = COARSE[usize::from(level != LampLevel::Near)];
    let mut mesh = Mesh::default();
    for (across, divisor, signs) in PLACES {
        for (own, sign) in signs.chars().enumerate() {
            let shown = Vec2::new(f32::from(divisor), (16 * signs.len() + own) as f32);
            for stroke in lettering::set(&sign.to_string()).strokes {
                let stroke: Vec<Vec2> =
                    stroke.iter().map(|&[x, y]| Vec2::new(across, 0.0) + SIGN_M * Vec2::new(x, -y)).collect();
                draw(&mut mesh, &stroke, coarse, |p| {
                    // Seen from before the car +y is at the right, seen from behind it -y.
                    let position = middle + Vec3::new(0.0, p.x * outwards, p.y);
                    Vertex::new(position, Vec3::X * outwards, [INK; 3], shown, Material::Plate)
                });
            }
        }
    }
    mesh
}

/// Draws a stroke as a band, square at its ends, split at its corners.
fn draw(mesh: &mut Mesh, stroke: &[Vec2], coarse: f32, place: impl Fn(Vec2) -> Vertex) {
    let points = thinned(stroke, coarse * SIGN_M);
    let half = 0.5 * PEN * SIGN_M;
    let way = |i: usize| (points[i + 1] - points[i]).normalize_or(Vec2::X);
    let closed = points[0].distance(points[points.len() - 1]) < 1e-4;
    let mut start = 0;
    for end in 1..points.len() {
        let last = end + 1 == points.len();
        if !last && way(end - 1).dot(way(end)) > 0.5 {
            continue;
        }
        let first = mesh.vertices.len() as u32;
        for i in start..=end {
            // Square at an end; in between, and round a closed stroke, along the mean of both directions.
            let before = if i > start { Some(way(i - 1)) } else { closed.then(|| way(points.len() - 2)) };
            let after = if i < end { Some(way(i)) } else { closed.then(|| way(0)) };
            let (a, b) = (before.or(after).unwrap_or(Vec2::X), after.or(before).unwrap_or(Vec2::X));
            let over = match (before, after) {
                (None, _) => -0.5 * half * b,
                (_, None) => 0.5 * half * a,
                _ => Vec2::ZERO,
            };
            let aside = (a + b).normalize_or(a).perp() * (half / (0.5 + 0.5 * a.dot(b)).sqrt().max(0.7));
            mesh.vertex(place(points[i] + over - aside));
            mesh.vertex(place(points[i] + over + aside));
        }
        for row in 0..(end - start) as u32 {
            let at = first + 2 * row;
            mesh.indices.extend([at, at + 2, at + 3, at, at + 3, at + 1]);
        }
        start = end;
    }
}

/// Returns the stroke without the points that lie within `off` of a straight line between others (Douglas and Peucker 1973).
pub(in crate::scene) fn thinned(points: &[Vec2], off: f32) -> Vec<Vec2> {
    let (first, last) = (points[0], points[points.len() - 1]);
    let along = (last - first).normalize_or_zero();
    let from_line = |p: Vec2| if along == Vec2::ZERO { p.distance(first) } else { along.perp_dot(p - first).abs() };
    let far =
        (1..points.len().saturating_sub(1)).max_by(|&a, &b| from_line(points[a]).total_cmp(&from_line(points[b])));
    match far.filter(|&i| from_line(points[i]) > off) {
        Some(i) => {
            let mut all = thinned(&points[..=i], off);
            all.pop();
            all.extend(thinned(&points[i..], off));
            all
        }
        None => vec![first, last],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::{check, faces};
    use std::collections::BTreeSet;

    #[test]
    fn no_two_cars_have_the_same_number() {
        let all: BTreeSet<u16> = (0..9000).map(number).collect();
        assert_eq!(all.len(), 9000);
        assert!(all.iter().all(|n| (1000..10_000).contains(n)));
        let text: String = signs(4821).iter().map(|(_, sign)| *sign).collect();
        assert!(text.ends_with("4821") && text.len() == 6, "{text}");
    }

    #[test]
    fn the_mean_of_a_plate_is_the_mean_of_its_surface_and_signs() {
        for level in [LampLevel::Near, LampLevel::Mid] {
            let mesh = lettering(Vec3::ZERO, 1.0, level);
            let shown = |corner: &Vertex, number: u16| {
                let [u, v] = corner.uv.map(|v| v as usize);
                usize::from(number) / u % (v / 16) == v % 16
            };
            let numbers = (0..50).map(number);
            let inked_m2: f32 = numbers
                .flat_map(|number| faces(&mesh).filter(move |(corners, _)| shown(&corners[0], number)))
                .map(|(corners, _)| {
                    let [a, b, c] = corners.map(|corner| Vec3::from(corner.position));
                    0.5 * (b - a).cross(c - a).length()
                })
                .sum();
            // The blue field keeps its colour and does not count.
            let share = inked_m2 / 50.0 / ((0.52 - 0.042) * 0.104);
            let mean = SURFACE + (INK - SURFACE) * share;
            assert!((mean - MEAN).abs() < 0.02, "{level:?}: {mean}");
        }
    }

    #[test]
    fn all_signs_face_outwards_and_stay_on_the_plate() {
        for (outwards, level, most) in
            [(1.0, LampLevel::Near, 2500), (-1.0, LampLevel::Near, 2500), (1.0, LampLevel::Mid, 1400)]
        {
            let mesh = lettering(Vec3::ZERO, outwards, level);
            check(&mesh, "lettering");
            assert!(mesh.triangles() < most, "{level:?}: {}", mesh.triangles());
            for (corners, face) in faces(&mesh) {
                assert!(face.x * outwards >= 0.0, "{corners:?}");
                let [_, y, z] = corners[0].position;
                assert!(y.abs() < 0.25 && z.abs() < 0.045, "{y} {z}");
            }
        }
    }
}
