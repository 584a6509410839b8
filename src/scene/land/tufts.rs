//! Tufts of grass beside the road, which give the meadow depth near the eye. In: the roads, the ground, a seed. Out: places and a
//! mesh, metres.

use crate::{
    rng,
    roadside::{
        buildings::Buildings,
        noise,
        relief::Relief,
        road_surfaces::{HALF_LANE_M, RoadSurfaces},
        trees::broad_leaf::VARIANTS,
    },
    scene::{Material, Mesh, TreePlace, Vertex, colours::shade, network::layer::SHOULDER_M},
    space::smoothstep,
};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_SQRT_2, TAU};

/// Largest distance of tufts from the asphalt, metres.
const TUFTS_M: f32 = 45.0;
/// Distance from the asphalt up to which tufts are dense, metres; further out each is larger.
const CLOSE_M: f32 = 9.0;
/// Variant of cards with stalks, ears and flowers (`grass.wgsl` has the same number).
const STALKS: usize = VARIANTS - 1;
/// Side of the lattice on which tufts are placed, metres.
const TUFT_EVERY_M: f32 = 0.46;
/// Approximate maximum number of lattice squares for a network.
const MOST_SQUARES: f32 = 400_000.0;
/// Maximum number of tufts in a static scene.
const MOST_TUFTS: usize = 60_000;

/// Returns a tuft: upright cards around a common foot.
pub(in crate::scene) fn tuft(seed: u64) -> Mesh {
    let mut random = rng::stream(seed, "tuft");
    let mut draw = |low: f32, high: f32| random.uniform(f64::from(low), f64::from(high)) as f32;
    let mut mesh = Mesh::default();
    for k in 0..9 {
        let stalks = k >= 7;
        let out = Vec2::from_angle(TAU * k as f32 * 0.618 + draw(-0.5, 0.5)) * draw(0.05, 0.42);
        let across = Vec2::from_angle(draw(0.0, TAU)) * draw(0.22, 0.36);
        let height = if stalks { draw(0.40, 0.58) } else { draw(0.16, 0.34) * (1.15 - out.length()) };
        let lean = Vec2::from_angle(draw(0.0, TAU)) * height * if stalks { 0.12 } else { 0.30 };
        let along = lean.extend(height / 2.0);
        let colour = shade(super::MEADOW, draw(0.88, 1.18));
        let variant = if stalks { STALKS } else { draw(0.0, STALKS as f32) as usize % STALKS };
        let first = mesh.vertices.len() as u32;
        for place in [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y] {
            let middle = out.extend(height / 2.0);
            let position = middle + (across * (2.0 * place.x - 1.0)).extend(0.0) + along * (2.0 * place.y - 1.0);
            // Dark at the foot, where blades shade each other; lit like the ground.
            let colour = shade(colour, 0.52 + 0.78 * place.y);
            let normal = (Vec3::Z + (out * 0.5).extend(0.0)).normalize();
            // The card's variant is encoded with the position, as in `leaf_cards`.
            let uv = place + 2.0 * variant as f32 * Vec2::X;
            mesh.vertex(Vertex::new(position, normal, colour, uv, Material::Leaves));
        }
        mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    mesh
}

/// Places tufts: densest at the edge of the gravel, in drifts further out.
pub(in crate::scene) fn sow(roads: &RoadSurfaces, buildings: &Buildings, relief: &Relief, seed: u64) -> Vec<TreePlace> {
    let mut random = rng::stream(seed, "tufts");
    let mut draw = |high: f32| random.uniform(0.0, f64::from(high)) as f32;
    // For a whole network the lattice is coarser, so that only a few tufts are drawn for each one kept.
    let squares = (roads.length_m() * TUFTS_M).min(4.0 * roads.radius_m() * roads.radius_m()) / MOST_SQUARES;
    let every_m = TUFT_EVERY_M.max(squares.sqrt());
    let reach = ((roads.radius_m() + SHOULDER_M + TUFTS_M) / every_m).ceil() as i32;
    // The squares of a block of 16 x 16 are checked only if the block is near the road, each of its parts with a look of its own.
    const BLOCK: i32 = 16;
    const PART: i32 = BLOCK / 4;
    let block_m = BLOCK as f32 * every_m;
    let blocks = reach / BLOCK + 1;
    let mut tufts = Vec::new();
    for (row, column) in (-blocks..blocks).flat_map(|row| (-blocks..blocks).map(move |column| (row, column))) {
        let low = roads.centre() + Vec2::new(column as f32, row as f32) * block_m;
        if roads.middle_m(low + Vec2::splat(block_m / 2.0)) > TUFTS_M + HALF_LANE_M + block_m {
            continue;
        }
        // Distances in a part of the block differ from that of the part's middle by half its diagonal at most.
        let part_m = PART as f32 * every_m;
        let middles = [0, 1, 2, 3].map(|y| [0, 1, 2, 3].map(|x| low + (Vec2::new(x as f32, y as f32) + 0.5) * part_m));
        let nearest = middles
            .map(|row| row.map(|middle| roads.middle_m(middle) - part_m * FRAC_1_SQRT_2 - HALF_LANE_M - SHOULDER_M));
        for k in 0..BLOCK * BLOCK {
            let (luck, yaw_rad, size, tone) = (draw(1.0), draw(TAU), draw(1.0), draw(1.0));
            let cell = Vec2::new((k % BLOCK) as f32 + draw(1.0), (k / BLOCK) as f32 + draw(1.0));
            let nearest_m = nearest[(k / BLOCK / PART) as usize][(k % BLOCK / PART) as usize];
            if luck > density(nearest_m, f32::INFINITY) {
                continue;
            }
            let at = low + cell * every_m;
            let drift = noise::fractal(seed ^ 0x67a5, at / 5.0);
            if luck > density(nearest_m, drift) {
                continue;
            }
            let beyond_m = roads.middle_m(at) - HALF_LANE_M - SHOULDER_M;
            if beyond_m < 0.55 || luck > density(beyond_m, drift) || buildings.is_built_on(at) || relief.is_bare(at) {
                continue;
            }
            tufts.push(Tuft { at, beyond_m, yaw_rad, size, tone });
        }
    }
    // On a long road there are too many: only every `keep`-th tuft stays.
    let keep = tufts.len().div_ceil(MOST_TUFTS).max(1);
    tufts.into_iter().step_by(keep).map(|tuft| tuft.place(relief)).collect()
}

/// Returns the share of the lattice's squares that have a tuft: by the distance from the gravel, metres, and by the drift of grass there.
fn density(beyond_m: f32, drift: f32) -> f32 {
    let edge = smoothstep(2.6, 0.7, beyond_m);
    (0.30 + 0.6 * smoothstep(-0.3, 0.4, drift) + 0.4 * edge)
        * (1.0 - 0.80 * far(beyond_m))
        * smoothstep(TUFTS_M, 0.6 * TUFTS_M, beyond_m)
}

/// Returns how far from the gravel a tuft is, from 0 to 1: far ones are fewer and larger.
fn far(beyond_m: f32) -> f32 {
    smoothstep(0.6 * CLOSE_M, 1.8 * CLOSE_M, beyond_m)
}

/// Tuft beside the road.
struct Tuft {
    at: Vec2,
    /// Distance from the gravel, metres.
    beyond_m: f32,
    yaw_rad: f32,
    /// Size and tone, each from 0 to 1.
    size: f32,
    tone: f32,
}

impl Tuft {
    fn place(&self, relief: &Relief) -> TreePlace {
        let Self { at, beyond_m, yaw_rad, size, tone } = *self;
        let sunk_m = if beyond_m < 2.5 { 0.05 } else { 0.0 };
        let base = super::colour(relief, at);
        TreePlace {
            position: at.extend(relief.height_m(at) - sunk_m),
            yaw_rad,
            scale: (0.65 + 0.55 * size + 0.45 * far(beyond_m)) * (0.75 + 0.25 * smoothstep(0.6, 2.0, beyond_m)),
            tint: [0, 1, 2].map(|i| (0.15 + 0.85 * base[i] / super::MEADOW[i]) * (0.86 + 0.28 * tone)),
            kind: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::static_scene::tests::{circuit, ring};
    use crate::{roadside::land_use_map::LandUseMap, scene::mesh::tests::check};

    #[test]
    fn tufts_grow_beside_the_road_only() {
        for map in [ring(250.0), circuit()] {
            let roads = RoadSurfaces::of(&map.network);
            let places = sow(&roads, &Buildings::default(), &Relief::new(&roads, &LandUseMap::default(), 3), 3);
            assert!((2000..=MOST_TUFTS).contains(&places.len()), "{}", places.len());
            for place in &places {
                let beyond = roads.middle_m(place.position.truncate()) - HALF_LANE_M - SHOULDER_M;
                assert!((0.5..TUFTS_M + 0.1).contains(&beyond), "{beyond} m from the asphalt");
                assert!(place.tint.iter().all(|c| (0.2..3.0).contains(c)), "{:?}", place.tint);
            }
        }
        check(&tuft(1), "tuft");
    }
}
