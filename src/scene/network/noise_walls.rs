//! Noise walls as a mesh: steel posts, a concrete plinth, wooden boards with a coping. In: their posts. Out: one mesh, metres. Sizes are the
//! project's own (`docs/references.md: roads`).

use crate::{
    roadside::{guard_rails::RailPost, noise_walls::NoiseWall},
    scene::{Material, Mesh, Vertex, colours::shade},
};
use glam::{Vec2, Vec3};

/// Height of the plinth, of a board, and number of boards.
const PLINTH_M: f32 = 0.6;
const BOARD_M: f32 = 0.29;
const BOARDS: usize = 10;
/// Height of the wall and of its posts, which stand out above it.
const WALL_M: f32 = PLINTH_M + BOARDS as f32 * BOARD_M;
const POST_M: f32 = WALL_M + 0.08;
/// Half the thickness of plinth, boards and coping, and half the width of a post.
const PLINTH_HALF_M: f32 = 0.10;
const BOARD_HALF_M: f32 = 0.06;
const COPING_HALF_M: f32 = 0.09;
const POST_HALF_M: f32 = 0.13;
/// Part of a board's height at its lower edge that lies in the shade of the joint.
const JOINT_M: f32 = 0.035;
/// Depth of plinth and posts in the ground.
const UNDER_M: f32 = 0.6;
/// Linear albedo of concrete, weathered larch, its joints, the coping and steel.
const CONCRETE: [f32; 3] = [0.30, 0.295, 0.28];
const LARCH: [f32; 3] = [0.36, 0.30, 0.22];
const JOINT: [f32; 3] = [0.10, 0.085, 0.065];
const COPING: [f32; 3] = [0.16, 0.17, 0.17];
const STEEL: [f32; 3] = [0.115, 0.15, 0.125];

/// Returns the mesh of noise walls.
pub(in crate::scene) fn mesh(walls: &[NoiseWall]) -> Mesh {
    let mut mesh = Mesh::default();
    for wall in walls {
        wall.posts.windows(2).enumerate().for_each(|(k, pair)| add_span(&mut mesh, [pair[0], pair[1]], k));
        wall.posts.iter().for_each(|post| add_post(&mut mesh, post));
    }
    mesh
}

/// Layer of a wall's section: its heights, half its thickness and its colour.
type Layer = ([f32; 2], f32, [f32; 3]);

/// Adds the part of a wall between two posts.
fn add_span(mesh: &mut Mesh, ends: [RailPost; 2], number: usize) {
    let mut layers: Vec<Layer> = vec![([-UNDER_M, PLINTH_M], PLINTH_HALF_M, shade(CONCRETE, tone(number, 0)))];
    for board in 0..BOARDS {
        let low_m = PLINTH_M + board as f32 * BOARD_M;
        layers.push(([low_m, low_m + JOINT_M], BOARD_HALF_M, JOINT));
        layers.push(([low_m + JOINT_M, low_m + BOARD_M], BOARD_HALF_M, shade(LARCH, tone(number, board + 1))));
    }
    layers.push(([WALL_M, WALL_M + 0.06], COPING_HALF_M, COPING));
    for (heights, half_m, colour) in &layers {
        for facing in [1.0, -1.0] {
            let at = |end: usize, height: f32| {
                let RailPost { foot, to_road, .. } = ends[end];
                foot + to_road * facing * *half_m + Vec3::Z * height
            };
            let corners = [at(0, heights[0]), at(1, heights[0]), at(1, heights[1]), at(0, heights[1])];
            quad(mesh, corners, ends[0].to_road * facing, *colour);
        }
    }
    // The upper faces of plinth and coping.
    for ([_, top_m], half_m, colour) in [layers[0], layers[layers.len() - 1]] {
        let at = |end: usize, side: f32| ends[end].foot + ends[end].to_road * side * half_m + Vec3::Z * top_m;
        quad(mesh, [at(0, 1.0), at(1, 1.0), at(1, -1.0), at(0, -1.0)], Vec3::Z, colour);
    }
}

/// Returns the brightness of a board: boards weather differently.
fn tone(span: usize, board: usize) -> f32 {
    let mixed = (span as u32).wrapping_mul(0x9e37_79b9) ^ (board as u32).wrapping_mul(0x85eb_ca6b);
    0.84 + 0.32 * (mixed.wrapping_mul(0xc2b2_ae35) >> 8) as f32 / 16_777_216.0
}

/// Adds a steel post: its four sides and its top.
fn add_post(mesh: &mut Mesh, post: &RailPost) {
    let corner = |along: f32, out: f32, height: f32| {
        post.foot + post.along * along * POST_HALF_M + post.to_road * out * POST_HALF_M + Vec3::Z * height
    };
    let round = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    for (k, from) in round.iter().enumerate() {
        let to = round[(k + 1) % 4];
        let normal = post.along * (from[0] + to[0]) / 2.0 + post.to_road * (from[1] + to[1]) / 2.0;
        let [low, high] = [-UNDER_M, POST_M];
        let corners = [
            corner(from[0], from[1], low),
            corner(to[0], to[1], low),
            corner(to[0], to[1], high),
            corner(from[0], from[1], high),
        ];
        quad(mesh, corners, normal, STEEL);
    }
    quad(mesh, round.map(|[along, out]| corner(along, out, POST_M)), Vec3::Z, STEEL);
}

/// Adds a flat face that is seen from the side of its normal.
fn quad(mesh: &mut Mesh, corners: [Vec3; 4], normal: Vec3, colour: [f32; 3]) {
    let turns_left = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(normal) > 0.0;
    let [a, b, c, d] = corners
        .map(|at| mesh.vertex(Vertex::new(at, normal.normalize_or(Vec3::Z), colour, Vec2::ZERO, Material::Matt)));
    mesh.indices.extend(if turns_left { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::{check, faces};

    #[test]
    fn a_wall_is_closed_on_both_sides_and_faces_outwards() {
        let post = |k: usize| RailPost { foot: Vec3::new(4.0 * k as f32, 0.0, 1.0), along: Vec3::X, to_road: Vec3::Y };
        let mesh = mesh(&[NoiseWall { posts: (0..=2).map(post).collect() }]);
        check(&mesh, "noise wall");
        for (corners, face) in faces(&mesh) {
            assert!(face.dot(Vec3::from(corners[0].normal)) > 0.0, "{corners:?}");
        }
        let highest = mesh.vertices.iter().map(|vertex| vertex.position[2]).fold(f32::MIN, f32::max);
        // 0.6 m of plinth, ten boards of 29 cm, posts 8 cm above them, on a road at 1 m.
        assert!((highest - 4.58).abs() < 1e-4, "{highest}");
        // Two faces for each of 22 layers, two upper ones, and five of each post.
        assert_eq!(mesh.triangles(), 2 * (2 * (2 * 22 + 2) + 3 * 5));
    }
}
