//! The road as a mesh: strips side by side from verge to verge along the closed route, so that no marking lies on top of
//! asphalt and nothing flickers. In: the route, and the land's colours. Out: triangles in world axes; `uv` is (`s_m`,
//! `offset_m`).

use super::{
    Relief,
    noise::{self, shade},
};
use crate::{
    map::Route,
    scene::{Material, Mesh, Vertex},
};
use glam::{DVec2, Vec2, Vec3};

/// Asphalt beside the lane, line included, metres.
pub const SHOULDER_M: f32 = 0.4;
/// Width of the edge lines, metres; their inner edges are the lane's. The strip that carries a line is wider, so that the
/// shader can draw the line's edges: worn near by, and as a share of the pixel far off, where the line is thinner.
pub const LINE_M: f32 = 0.12;
/// What that strip holds inside the lane and beyond the lane's edge, metres.
const LINE_STRIP_M: [f32; 2] = [0.16, LINE_M + 0.22];
/// How far the verge reaches beyond the asphalt, metres: gravel, then grass that dips under the meadow.
pub const VERGE_M: f32 = 1.7;

/// Dark asphalt, linear albedo.
pub(in crate::scene) const ASPHALT: [f32; 3] = [0.082, 0.082, 0.086];
/// Paint of markings, linear albedo.
pub(in crate::scene) const PAINT: [f32; 3] = [0.70, 0.70, 0.67];

/// One strip between two columns: offset from the lane's edge (negative inside the lane as a fraction of the half width,
/// see `RoadColumn`), height and colour at both.
struct RoadStrip {
    material: Material,
    from: RoadColumn,
    to: RoadColumn,
}

/// A line of corners along the road.
#[derive(Clone, Copy)]
struct RoadColumn {
    /// Offset from the centre line in half lane widths.
    halves: f32,
    /// Plus this many metres outwards.
    beyond_m: f32,
    z_m: f32,
    colour: [f32; 3],
    /// How much noise moves it outwards, metres.
    ragged_m: f32,
}

fn column(halves: f32, beyond_m: f32, colour: [f32; 3]) -> RoadColumn {
    RoadColumn { halves, beyond_m, z_m: 0.0, colour, ragged_m: 0.0 }
}

/// The road's right half from the middle outwards is the mirror image of its left half.
fn left_half() -> Vec<RoadStrip> {
    // Tyres polish and darken two tracks; the middle keeps a film of oil.
    let middle = column(0.0, 0.0, shade(ASPHALT, 0.93));
    let track = column(0.45, 0.0, shade(ASPHALT, 0.88));
    let outside = column(0.72, 0.0, shade(ASPHALT, 1.06));
    let edge = column(1.0, -LINE_STRIP_M[0], shade(ASPHALT, 1.10));
    let line = |beyond_m| column(1.0, beyond_m, PAINT);
    let shoulder = column(1.0, LINE_STRIP_M[1], shade(ASPHALT, 1.10));
    let asphalt_end = column(1.0, SHOULDER_M, shade(ASPHALT, 1.22));
    // The colour of the grass that grows there is the land's own; the shader knows that of gravel.
    let gravel_end = RoadColumn { z_m: -0.02, ragged_m: 0.16, ..column(1.0, SHOULDER_M + 0.42, [0.0; 3]) };
    let under = RoadColumn { z_m: -0.14, ..column(1.0, SHOULDER_M + VERGE_M, [0.0; 3]) };
    let strip = |material, from, to| RoadStrip { material, from, to };
    vec![
        strip(Material::Asphalt, middle, track),
        strip(Material::Asphalt, track, outside),
        strip(Material::Asphalt, outside, edge),
        strip(Material::Marking, line(-LINE_STRIP_M[0]), line(LINE_STRIP_M[1])),
        strip(Material::Asphalt, shoulder, asphalt_end),
        strip(Material::Matt, asphalt_end, gravel_end),
        strip(Material::Grass, gravel_end, under),
    ]
}

/// The whole road, closed: the last row lies on the first.
pub(in crate::scene) fn road(route: &Route, relief: &Relief, seed: u64) -> Mesh {
    let rows = rows(route);
    let mut mesh = Mesh::default();
    for strip in left_half() {
        for side in [1.0f32, -1.0] {
            let first = mesh.vertices.len() as u32;
            // Seen from above, counter-clockwise: the right column of the strip first.
            let columns = if side > 0.0 { [&strip.from, &strip.to] } else { [&strip.to, &strip.from] };
            for &s_m in &rows {
                for column in columns {
                    mesh.vertex(corner(route, relief, s_m, column, side, strip.material, seed));
                }
            }
            for row in 0..rows.len() as u32 - 1 {
                let at = first + 2 * row;
                mesh.indices.extend([at, at + 2, at + 3, at, at + 3, at + 1]);
            }
        }
    }
    mesh
}

fn corner(
    route: &Route,
    relief: &Relief,
    s_m: f64,
    column: &RoadColumn,
    side: f32,
    material: Material,
    seed: u64,
) -> Vertex {
    // The last row has to be the first to the bit, noise included.
    let wrapped = route.wrap(s_m);
    let wobble = noise::value(seed ^ 0x51de, Vec2::new(wrapped as f32 * 0.45, side * 100.0 + column.beyond_m * 31.0));
    let half_m = half_width_m(route, wrapped);
    let offset = side * (column.halves * half_m + column.beyond_m + column.ragged_m * wobble);
    let yaw = route.yaw_at(wrapped);
    let place = route.point_at(wrapped) + DVec2::from_angle(yaw).perp() * f64::from(offset);
    let z_m = column.z_m;
    // The verge leans outwards by its slope.
    let lean = match material {
        Material::Matt => 0.05,
        Material::Grass => 0.09,
        _ => 0.0,
    };
    let outwards = DVec2::from_angle(yaw).perp().as_vec2() * side;
    let normal = (Vec3::Z + (outwards * lean).extend(0.0)).normalize();
    let patch = noise::fractal(seed ^ 0x0a5f, place.as_vec2() / 9.0);
    let amount = if material == Material::Marking { 0.05 } else { 0.10 };
    let mut colour = match material {
        Material::Matt | Material::Grass => relief.colour(place.as_vec2()),
        _ => shade(column.colour, 1.0 + amount * patch),
    };
    if material == Material::Marking {
        // Paint is grey enough to spare a channel, which tells how far into the strip this is, metres.
        colour[2] = column.beyond_m + LINE_STRIP_M[0];
    }
    Vertex::new(place.as_vec2().extend(z_m), normal, colour, Vec2::new(s_m as f32, offset), material)
}

/// Half the lane's width, eased over 16 m where lanes of different widths meet.
pub(in crate::scene) fn half_width_m(route: &Route, s_m: f64) -> f32 {
    let widths = [-8.0, -4.0, 0.0, 4.0, 8.0].map(|d| route.width_m(s_m + d));
    (widths.iter().sum::<f64>() / 10.0) as f32
}

/// Route distances of the rows: every metre in bends, every 4 m on straights, from 0 to the length of the route.
fn rows(route: &Route) -> Vec<f64> {
    const BEND_PER_M: f64 = 1.0 / 600.0;
    let metres = route.length_m().ceil() as usize;
    let step_m = route.length_m() / metres as f64;
    let bends = |k: usize| {
        (-6..=10).step_by(4).any(|d| route.curvature_at((k as f64 + f64::from(d)) * step_m, 4.0).abs() > BEND_PER_M)
    };
    let mut rows: Vec<f64> =
        (0..metres).filter(|&k| k.is_multiple_of(4) || bends(k)).map(|k| k as f64 * step_m).collect();
    rows.push(route.length_m());
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::land::road_distance::RoadDistance;
    use crate::scene::mesh::tests::{check, faces};
    use crate::scene::static_scene::tests::{circuit, ring};

    fn by_material(mesh: &Mesh, material: Material) -> Vec<Vertex> {
        mesh.vertices.iter().filter(|v| v.material == material as u32).copied().collect()
    }

    #[test]
    fn the_road_faces_up_and_closes() {
        for map in [ring(250.0), circuit()] {
            let near = RoadDistance::new(&map.route);
            let mesh = road(&map.route, &Relief::new(&near, 1), 1);
            check(&mesh, "road");
            assert!(faces(&mesh).all(|(_, face)| face.z > 0.0));
            let length = map.route.length_m() as f32;
            let start: Vec<_> = mesh.vertices.iter().filter(|v| v.uv[0] == 0.0).collect();
            let end: Vec<_> = mesh.vertices.iter().filter(|v| v.uv[0] == length).collect();
            assert_eq!((start.len(), end.len()), (28, 28));
            for (a, b) in start.iter().zip(end) {
                assert_eq!((a.position, a.normal, a.uv[1]), (b.position, b.normal, b.uv[1]));
            }
        }
    }

    #[test]
    fn asphalt_covers_the_lane_and_lines_stand_at_its_edges() {
        for map in [ring(250.0), ring(641.0), circuit()] {
            let near = RoadDistance::new(&map.route);
            let mesh = road(&map.route, &Relief::new(&near, 1), 1);
            let mut s_m = 0.0;
            while s_m < map.route.length_m() {
                let half = half_width_m(&map.route, s_m);
                assert!((f64::from(half) * 2.0 - map.route.width_m(s_m)).abs() < 1e-6);
                s_m += 13.0;
            }
            for v in by_material(&mesh, Material::Marking) {
                let half = half_width_m(&map.route, f64::from(v.uv[0]));
                let beyond = v.uv[1].abs() - half;
                assert!(LINE_STRIP_M.map(|m| (beyond.abs() - m).abs() < 1e-5).contains(&true), "{beyond}");
                assert!((beyond + LINE_STRIP_M[0] - v.colour[2]).abs() < 1e-5, "{beyond} {}", v.colour[2]);
                // `uv` tells the truth about the place.
                let found = map.route.project(DVec2::new(v.position[0].into(), v.position[1].into()), None);
                assert!((found.offset_m as f32 - v.uv[1]).abs() < 0.01, "{found:?} {v:?}");
            }
            let area: f32 = faces(&mesh)
                .filter(|(c, _)| c[0].material == Material::Asphalt as u32 || c[0].material == Material::Marking as u32)
                .map(|(_, face)| face.length() / 2.0)
                .sum();
            let width = half_width_m(&map.route, 0.0) * 2.0 + 2.0 * SHOULDER_M;
            let expected = width * map.route.length_m() as f32;
            assert!((area / expected - 1.0).abs() < 0.003, "{area} {expected}");
        }
    }

    #[test]
    fn straights_take_fewer_rows_than_bends() {
        assert_eq!(rows(&ring(250.0).route).len(), 251);
        let circuit = circuit().route;
        assert!(rows(&circuit).len() < (circuit.length_m() * 0.75) as usize);
    }
}
