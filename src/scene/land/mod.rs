//! Land around the road: meadow, flat near the road and rolling further out, hills on the horizon. In: the road's position. Out:
//! one mesh in world axes, with fine cells near the road and coarse ones far away.

pub(super) mod tufts;

use super::{
    Material, Mesh, Vertex,
    colours::{mix, shade},
};
use crate::{
    map::surroundings::LandUse,
    roadside::{land_use_map::BORDER_M, noise, relief::Relief, road_surfaces::RoadSurfaces},
    space::smoothstep,
};
use glam::{IVec2, Vec2, Vec3};
use std::collections::BTreeMap;

/// Linear albedo of the meadow.
pub(in crate::scene) const MEADOW: [f32; 3] = [0.098, 0.128, 0.044];
/// Reach of the land beyond the road network, metres.
const REACH_M: f32 = 1300.0;
/// Reach of the hills beyond the road network, metres.
const RANGES_M: f32 = 9000.0;

/// Returns the colour of the meadow: lush, dry and mown patches; hills are darker, with fields.
pub(in crate::scene) fn colour(relief: &Relief, point: Vec2) -> [f32; 3] {
    let broad = noise::fractal(relief.seed ^ 4, point / 34.0);
    let small = noise::fractal(relief.seed ^ 5, point / 7.0);
    let dry = smoothstep(0.05, 0.75, broad + 0.35 * small);
    let lush = smoothstep(0.05, 0.7, -broad + 0.3 * small);
    let colour = mix(mix(MEADOW, [0.150, 0.142, 0.066], 0.55 * dry), [0.066, 0.104, 0.034], 0.55 * lush);
    let colour = match relief.land_use.at(point) {
        Some(LandUse::Field) => mix(colour, [0.190, 0.150, 0.080], 0.75 + 0.2 * small),
        Some(LandUse::Wood | LandUse::Scrub) => mix(colour, [0.052, 0.062, 0.028], 0.6),
        Some(LandUse::Grass | LandUse::Park) => mix(colour, [0.078, 0.120, 0.040], 0.5),
        _ => colour,
    };
    let far = smoothstep(150.0, 500.0, point.distance(relief.roads.centre()) - relief.roads.radius_m());
    let field = noise::value(relief.seed ^ 6, point / 120.0);
    let hill = mix([0.070, 0.098, 0.036], [0.160, 0.152, 0.074], smoothstep(0.1, 0.5, field));
    // From afar, hills are wooded, with fields between the woods.
    let distant = smoothstep(700.0, 1600.0, point.distance(relief.roads.centre()) - relief.roads.radius_m());
    let clearing = noise::fractal(relief.seed ^ 8, point / 700.0);
    let wooded = mix([0.026, 0.042, 0.018], [0.115, 0.122, 0.052], smoothstep(0.12, 0.26, clearing));
    shade(mix(mix(colour, hill, far), wooded, distant), 1.0 + 0.10 * small)
}

/// Returns the mesh of the ground and the hills on the horizon; its cells are as fine as `own`, the roads of the network, needs, and lie
/// around its centre.
pub(in crate::scene) fn land(relief: &Relief, own: &RoadSurfaces) -> Mesh {
    let mut mesh = ground(relief, own);
    ranges(&mut mesh, relief);
    mesh
}

/// Side of the smallest cell, metres; the sides of cells are this times powers of two.
const CELL_M: f32 = 4.0;
/// Approximate maximum number of the smallest cells beside the roads of a network.
const MOST_CELLS: f32 = 40_000.0;

/// Returns the side of the smallest cell for these roads, metres: larger for long roads, to limit the number of cells.
fn cell_m(roads: &RoadSurfaces) -> f32 {
    // Cells are small up to about 20 m beside a road; the area of the whole network is the upper limit.
    let around = 2.0 * roads.radius_m();
    // Where roads have slopes, cells must be fine enough to follow them.
    let finest_m = if roads.level_m().is_some() { CELL_M } else { CELL_M / 2.0 };
    let fine_m2 = (roads.length_m() * 45.0).min(around * around);
    let mut cell_m = finest_m;
    while fine_m2 / (cell_m * cell_m) > MOST_CELLS {
        cell_m *= 2.0;
    }
    cell_m
}

/// Returns a grid of squares, each split while it is large for its distance from the road. Squares next to smaller ones include
/// the corners on their edges, so that there are no cracks.
fn ground(relief: &Relief, own: &RoadSurfaces) -> Mesh {
    let half = relief.roads.radius_m() + REACH_M;
    let cell_m = cell_m(own);
    let off_m = own.centre().distance(relief.roads.centre());
    let levels = (2.0 * (half + off_m) / cell_m).log2().ceil() as u32;
    let size = 1i32 << levels;
    let origin = own.centre() - Vec2::splat(cell_m * size as f32 / 2.0);
    let place = |at: IVec2| origin + at.as_vec2() * cell_m;
    let mut squares = Vec::new();
    let mut open = vec![(IVec2::ZERO, size)];
    while let Some((low, side)) = open.pop() {
        let side_m = side as f32 * cell_m;
        let distance = relief.roads.middle_m(place(low) + Vec2::splat(side_m / 2.0)) - side_m * 0.7;
        if side > 1 && side_m > (distance - 20.0).max(0.0) * 0.22 + cell_m {
            let h = side / 2;
            open.extend([IVec2::ZERO, IVec2::X * h, IVec2::Y * h, IVec2::splat(h)].map(|d| (low + d, h)));
        } else if place(low).distance(relief.roads.centre()) < half * 1.1 {
            squares.push((low, side));
        }
    }
    let mut mesh = Mesh::default();
    let mut numbers: BTreeMap<[i32; 2], u32> = BTreeMap::new();
    let vertex = |mesh: &mut Mesh, point: Vec2| {
        let position = point.extend(relief.height_m(point));
        let (colour, paved) = (colour(relief, point), relief.paved_and_water_m(point));
        mesh.vertex(Vertex::new(position, Vec3::ZERO, colour, paved, Material::Grass))
    };
    for &(low, side) in &squares {
        for d in [IVec2::ZERO, IVec2::X, IVec2::ONE, IVec2::Y] {
            let at = low + d * side;
            numbers.entry(at.to_array()).or_insert_with(|| vertex(&mut mesh, place(at)));
        }
    }
    for &(low, side) in &squares {
        // Around the square, counter-clockwise, with every corner on its edges.
        let mut rim = Vec::new();
        let turns = [(IVec2::ZERO, IVec2::X), (IVec2::X, IVec2::Y), (IVec2::ONE, -IVec2::X), (IVec2::Y, -IVec2::Y)];
        for (corner, along) in turns {
            let start = low + corner * side;
            rim.extend((0..side).filter_map(|k| numbers.get(&(start + along * k).to_array())).copied());
        }
        if rim.len() == 4 {
            mesh.indices.extend([rim[0], rim[1], rim[2], rim[0], rim[2], rim[3]]);
            continue;
        }
        let middle = vertex(&mut mesh, place(low) + Vec2::splat(side as f32 * cell_m / 2.0));
        for k in 0..rim.len() {
            mesh.indices.extend([middle, rim[k], rim[(k + 1) % rim.len()]]);
        }
    }
    smooth(&mut mesh);
    mesh
}

/// Sets the normal of each vertex to the mean of those of its triangles by their areas: heights beside each vertex would cost four times as much
/// as the mesh itself.
fn smooth(mesh: &mut Mesh) {
    let mut normals = vec![Vec3::ZERO; mesh.vertices.len()];
    for triangle in mesh.indices.as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(|index| Vec3::from(mesh.vertices[index as usize].position));
        triangle.iter().for_each(|index| normals[*index as usize] += (b - a).cross(c - a));
    }
    for (vertex, normal) in mesh.vertices.iter_mut().zip(normals) {
        vertex.normal = normal.normalize_or(Vec3::Z).to_array();
    }
}

/// Adds the hills beyond the squares, up to [`RANGES_M`]: rings of quads about the centre, as fine as the outline of the horizon
/// needs. The first ring lies under the squares' rim.
fn ranges(mesh: &mut Mesh, relief: &Relief) {
    const RINGS: u32 = 13;
    const SIDES: u32 = 216;
    let first = mesh.vertices.len() as u32;
    let start = relief.roads.radius_m() + REACH_M * 0.92;
    let stretch = ((relief.roads.radius_m() + RANGES_M) / start).powf(1.0 / RINGS as f32);
    for ring in 0..=RINGS {
        let radius = start * stretch.powi(ring as i32);
        for side in 0..SIDES {
            let way = Vec2::from_angle(std::f32::consts::TAU * (side as f32 + 0.5 * (ring % 2) as f32) / SIDES as f32);
            let point = relief.roads.centre() + way * radius;
            let sunk = if ring == 0 { 12.0 } else { 0.0 };
            let position = point.extend(relief.height_m(point) - sunk);
            let normal = relief.normal(point, 0.03 * radius);
            let dry = Vec2::splat(-BORDER_M);
            mesh.vertex(Vertex::new(position, normal, colour(relief, point), dry, Material::Grass));
        }
    }
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let [a, b] = [side, (side + 1) % SIDES].map(|side| first + ring * SIDES + side);
            let [c, d] = [a + SIDES, b + SIDES];
            // Odd rings are offset by half a side.
            if ring % 2 == 0 {
                mesh.indices.extend([a, c, b, b, c, d]);
            } else {
                mesh.indices.extend([a, c, d, a, d, b]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::surroundings::{LandArea, Surroundings};
    use crate::roadside::{land_use_map::LandUseMap, verge_shape::BESIDE_ROAD_M};
    use crate::scene::mesh::tests::{check, faces};
    use crate::scene::static_scene::tests::{circuit, ring};
    use glam::Vec3;

    #[test]
    fn the_land_never_covers_the_road() {
        for map in [ring(250.0), ring(1500.0), circuit()] {
            let roads = RoadSurfaces::of(&map.network);
            let mesh = ground(&Relief::new(&roads, &LandUseMap::default(), 5), &roads);
            check(&mesh, "land");
            for (corners, face) in faces(&mesh) {
                assert!(face.z > 0.0, "faces up");
                let [a, b, c] = corners.map(|v| Vec3::from(v.position));
                for weights in [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.34, 0.33, 0.33]] {
                    let p = a * weights[0] + b * weights[1] + c * weights[2];
                    let beside = roads.border_m(p.truncate()) < 2.5;
                    assert!(!beside || (p.z - BESIDE_ROAD_M).abs() < 1e-4, "{p}");
                }
            }
        }
    }

    #[test]
    fn the_ground_has_no_cracks_and_reaches_the_horizon() {
        let map = ring(250.0);
        let roads = RoadSurfaces::of(&map.network);
        let mesh = ground(&Relief::new(&roads, &LandUseMap::default(), 5), &roads);
        assert!((5_000..40_000).contains(&mesh.triangles()), "{}", mesh.triangles());
        // Inside, every edge belongs to two triangles: open edges are on the rim only.
        let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
        for t in mesh.indices.chunks(3) {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        for (edge, _) in edges.iter().filter(|(_, count)| **count != 0) {
            let p = Vec3::from(mesh.vertices[edge[0] as usize].position);
            assert!(p.truncate().distance(roads.centre()) > 900.0, "crack at {p}");
        }
    }

    #[test]
    fn hills_stand_above_the_eye_all_around() {
        let map = ring(250.0);
        let roads = RoadSurfaces::of(&map.network);
        let land_use = LandUseMap::default();
        let relief = Relief::new(&roads, &land_use, 5);
        for degrees in 0..360 {
            let direction = Vec2::from_angle((degrees as f32).to_radians());
            let heights = (30..95).map(|k| relief.height_m(roads.centre() + direction * (k as f32 * 10.0)));
            let highest = heights.fold(0.0, f32::max);
            assert!((8.0..50.0).contains(&highest), "{degrees}: {highest}");
        }
    }

    #[test]
    fn water_is_level_below_the_banks_and_never_below_a_road() {
        // A lake over half of the circuit, its straights 20 m and 140 m from the x axis.
        let net = circuit().network;
        let roads = RoadSurfaces::of(&net);
        let lake = LandArea::rectangle(LandUse::Water, [400.0, -50.0], [200.0, 300.0]);
        let map = LandUseMap::of(&Surroundings { areas: vec![lake], ..Surroundings::default() }, &roads);
        let wet = land(&Relief::new(&roads, &map, 5), &roads);
        let mut levels = Vec::new();
        for (corners, _) in faces(&wet) {
            let corners = corners.map(|corner| Vec3::from(corner.position));
            let [road_m, depth_m] = [0, 1].map(|what| {
                let of = |at: Vec2| if what == 0 { roads.border_m(at) } else { map.depth_m(at, &[LandUse::Water]) };
                corners.map(|corner| of(corner.truncate())).into_iter().fold(f32::INFINITY, f32::min)
            });
            let lowest_m = corners.map(|corner| corner.z).into_iter().fold(f32::INFINITY, f32::min);
            assert!(road_m > 1.4 || lowest_m > -0.5, "the ground beside a road stays: {corners:?}");
            if road_m > 20.0 && depth_m >= BORDER_M {
                levels.extend(corners.map(|corner| corner.z));
            }
        }
        let (low, high) =
            levels.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(*z), high.max(*z)));
        assert!(levels.len() > 100 && high - low < 1e-3, "{} faces, {low} to {high} m", levels.len());
        // The road is at 0 m, and the water 70 cm below the meadow beside it.
        assert!((high - (BESIDE_ROAD_M - 0.7)).abs() < 0.01, "{high} m");
    }
}
