//! What stands beside the road below the trees: tufts of grass, so that the meadow has depth where the eye is near, and
//! reflector posts at true distances, a cue for speed. In: the road, the ground, a seed. Out: places and meshes, metres.

use super::{
    Relief,
    noise::{self, shade, smoothstep},
    road::{self, SHOULDER_M},
    road_distance::RoadDistance,
};
use crate::{
    map::Route,
    rng,
    scene::{
        Material, Mesh, TreePlace, Vertex,
        mesh::{SurfaceFinish, TriangleSoup},
        trees::leaf_cards::VARIANTS,
    },
};
use glam::{DVec2, Vec2, Vec3};
use std::f32::consts::TAU;

/// Distance of the posts along the road, metres (as on German roads in narrow bends).
pub const POST_EVERY_M: f64 = 25.0;
/// Distance of the posts from the asphalt, metres.
const POST_BESIDE_M: f32 = 0.75;
/// Height of a post, metres.
const POST_HEIGHT_M: f32 = 1.0;
/// Tufts grow up to this far from the asphalt, metres.
const TUFTS_M: f32 = 45.0;
/// They stand close up to this far from it, metres; further out each is larger.
const CLOSE_M: f32 = 9.0;
/// The variant of cards that carry stalks with ears and flowers (`grass.wgsl` has the same number).
const STALKS: usize = VARIANTS - 1;
/// Side of the lattice on which tufts are sown, metres.
const TUFT_EVERY_M: f32 = 0.46;
/// The most squares of the lattice for a network, about.
const MOST_SQUARES: f32 = 400_000.0;
/// The most tufts of a stage.
const MOST_TUFTS: usize = 60_000;

/// A tuft: upright cards about a common foot.
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
            // Dark at the foot, where blades shade each other; lit as the ground is.
            let colour = shade(colour, 0.52 + 0.78 * place.y);
            let normal = (Vec3::Z + (out * 0.5).extend(0.0)).normalize();
            // The card's variant beside its place, as in `foliage`.
            let uv = place + 2.0 * variant as f32 * Vec2::X;
            mesh.vertex(Vertex::new(position, normal, colour, uv, Material::Leaves));
        }
        mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    mesh
}

/// Where tufts grow: densest at the edge of the gravel, in drifts further out.
pub(in crate::scene) fn sow(near: &RoadDistance, relief: &Relief, seed: u64) -> Vec<TreePlace> {
    let mut random = rng::stream(seed, "tufts");
    let mut draw = |high: f32| random.uniform(0.0, f64::from(high)) as f32;
    // Over a whole network the lattice is wider: no more than a few tufts are drawn for each that stays.
    let every_m = match near.surfaces() {
        None => TUFT_EVERY_M,
        Some(surfaces) => {
            let squares = (surfaces.length_m() * TUFTS_M).min(4.0 * near.radius_m() * near.radius_m()) / MOST_SQUARES;
            TUFT_EVERY_M.max(squares.sqrt())
        }
    };
    let reach = ((near.radius_m() + SHOULDER_M + TUFTS_M) / every_m).ceil() as i32;
    // A square of the lattice is looked at closely only if its block of 16 x 16 is near the road.
    const BLOCK: i32 = 16;
    let block_m = BLOCK as f32 * every_m;
    let blocks = reach / BLOCK + 1;
    let mut places = Vec::new();
    for (row, column) in (-blocks..blocks).flat_map(|row| (-blocks..blocks).map(move |column| (row, column))) {
        let low = near.centre() + Vec2::new(column as f32, row as f32) * block_m;
        if near.distance_m(low + Vec2::splat(block_m / 2.0)) > TUFTS_M + near.half_lane_m() + block_m {
            continue;
        }
        for k in 0..BLOCK * BLOCK {
            let (luck, turn, size, tone) = (draw(1.0), draw(TAU), draw(1.0), draw(1.0));
            let cell = Vec2::new((k % BLOCK) as f32 + draw(1.0), (k / BLOCK) as f32 + draw(1.0));
            let point = low + cell * every_m;
            let beyond = near.distance_m(point) - near.half_lane_m() - SHOULDER_M;
            let drift = noise::fractal(seed ^ 0x67a5, point / 5.0);
            let edge = smoothstep(2.6, 0.7, beyond);
            let far = smoothstep(0.6 * CLOSE_M, 1.8 * CLOSE_M, beyond);
            let density = (0.30 + 0.6 * smoothstep(-0.3, 0.4, drift) + 0.4 * edge)
                * (1.0 - 0.80 * far)
                * smoothstep(TUFTS_M, 0.6 * TUFTS_M, beyond);
            if beyond < 0.55 || luck > density {
                continue;
            }
            let sunk = if beyond < 2.5 { 0.05 } else { 0.0 };
            let base = relief.colour(point);
            let tint = [0, 1, 2].map(|i| (0.15 + 0.85 * base[i] / super::MEADOW[i]) * (0.86 + 0.28 * tone));
            places.push(TreePlace {
                position: point.extend(relief.height_m(point) - sunk),
                yaw_rad: turn,
                scale: (0.65 + 0.55 * size + 0.45 * far) * (0.75 + 0.25 * smoothstep(0.6, 2.0, beyond)),
                tint,
                kind: 0,
            });
        }
    }
    // Too many for a long road: every so many stays.
    let keep = places.len().div_ceil(MOST_TUFTS).max(1);
    places.into_iter().step_by(keep).collect()
}

/// All posts, on the right of the lane: the outer side of a ring driven counter-clockwise.
pub(in crate::scene) fn posts(route: &Route) -> Mesh {
    let post = post();
    let mut mesh = Mesh::default();
    let count = (route.length_m() / POST_EVERY_M).round().max(1.0) as usize;
    for k in 0..count {
        let s_m = k as f64 * POST_EVERY_M;
        if s_m > route.length_m() - POST_EVERY_M / 2.0 {
            break;
        }
        let yaw = route.yaw_at(s_m);
        let aside = f64::from(road::half_width_m(route, s_m) + SHOULDER_M + POST_BESIDE_M);
        let foot = (route.point_at(s_m) - DVec2::from_angle(yaw).perp() * aside).as_vec2().extend(-0.08);
        let turn = glam::Quat::from_rotation_z(yaw as f32);
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(post.vertices.iter().map(|v| Vertex {
            position: (foot + turn * Vec3::from(v.position)).into(),
            normal: (turn * Vec3::from(v.normal)).into(),
            ..*v
        }));
        mesh.indices.extend(post.indices.iter().map(|i| first + i));
    }
    mesh
}

/// One post: white, a black band near its top, in it a reflector to either side. Front towards -x.
fn post() -> Mesh {
    let white = SurfaceFinish::grey(Material::Matt, 0.72);
    let black = SurfaceFinish::grey(Material::Matt, 0.015);
    let mut soup = TriangleSoup::default();
    // A triangle with blunt corners, as moulded posts have; its edge points away from the road.
    let outline = [(-0.045, 0.055), (-0.012, -0.055), (0.012, -0.055), (0.045, 0.055), (0.03, 0.065), (-0.03, 0.065)];
    let bands = [(0.0, 0.66, white), (0.66, 0.88, black), (0.88, POST_HEIGHT_M, white)];
    for (low, high, finish) in bands {
        for k in 0..outline.len() {
            let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
            // The band falls towards the road, as its upper and lower edges do.
            let at = |(x, y): (f32, f32), z: f32| Vec3::new(x, y, if z > 0.0 { z - y * 0.5 } else { z });
            soup.quad([at(a, low), at(b, low), at(b, high), at(a, high)], finish);
        }
    }
    let top = |(x, y): (f32, f32)| Vec3::new(x, y, POST_HEIGHT_M - y * 0.5);
    for k in 1..outline.len() - 1 {
        soup.triangle([top(outline[0]), top(outline[k]), top(outline[k + 1])], white);
    }
    for side in [-1.0, 1.0] {
        soup.cuboid(
            Vec3::new(side * 0.034, 0.022, 0.765),
            Vec3::new(0.008, 0.016, 0.075),
            SurfaceFinish::grey(Material::Lamp, 0.8),
        );
    }
    soup.into_mesh(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::check;
    use crate::scene::static_scene::tests::{circuit, ring};

    #[test]
    fn posts_stand_every_25_m_beside_the_road() {
        for map in [ring(250.0), ring(641.0), circuit()] {
            let all = posts(&map.route);
            check(&all, "posts");
            let one = post().vertices.len();
            let feet: Vec<Vec2> = all.vertices.chunks(one).map(|c| Vec3::from(c[0].position).truncate()).collect();
            assert!(feet.len() >= (map.route.length_m() / POST_EVERY_M) as usize);
            for (k, foot) in feet.iter().enumerate() {
                let found = map.route.project(foot.as_dvec2(), None);
                let along = map.route.wrap(found.s_m - k as f64 * POST_EVERY_M + 1.0) - 1.0;
                assert!(along.abs() < 0.1, "post {k} is {along} m off");
                let beyond = -found.offset_m as f32 - road::half_width_m(&map.route, found.s_m) - SHOULDER_M;
                assert!((0.5..1.0).contains(&beyond), "{beyond} m beside the asphalt");
            }
        }
    }

    #[test]
    fn tufts_grow_beside_the_road_only() {
        for map in [ring(250.0), circuit()] {
            let near = RoadDistance::new(&map.route);
            let places = sow(&near, &Relief::new(&near, 3), 3);
            assert!((2000..=MOST_TUFTS).contains(&places.len()), "{}", places.len());
            for place in &places {
                let beyond = near.distance_m(place.position.truncate()) - near.half_lane_m() - SHOULDER_M;
                assert!((0.5..TUFTS_M + 0.1).contains(&beyond), "{beyond} m from the asphalt");
                assert!(place.tint.iter().all(|c| (0.2..3.0).contains(c)), "{:?}", place.tint);
            }
        }
        check(&tuft(1), "tuft");
    }
}
