//! Spruce model. In: its whorls of boughs, and a detail. Out: a mesh, foot at the origin, metres. Each bough is a bent strip of leaf
//! cards with a second strip hanging under it.

use super::leaf_cards::{CardCut, LeafCard, ModelDetail, TreeCrown, stem};
use crate::{
    roadside::trees::spruce::{Bough, BoughCounts, EDGES, HEIGHT_M, NEAR, STEM, Whorl, whorls},
    scene::{
        Material, Mesh, Vertex,
        colours::{mix, shade},
    },
};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Lower limit of a bough's coordinates, metres: no bough is below the ground.
const ON_GROUND: Vec3 = Vec3::new(f32::MIN, f32::MIN, 0.0);
const BARK: [f32; 3] = [0.155, 0.118, 0.092];

/// Boughs of a spruce in the middle distance, and of its shadow, which is a skirt of this many points a whorl.
const MID: BoughCounts = BoughCounts { whorls: 16, boughs: 6, wide: 0.56 };
const SHADE: BoughCounts = BoughCounts { whorls: 5, boughs: 0, wide: 0.0 };
const SKIRT_POINTS: usize = 7;

/// Returns the spruce at a level of detail.
pub(in crate::scene) fn spruce(seed: u64, detail: ModelDetail) -> Mesh {
    let mut mesh = Mesh::default();
    let counts = match detail {
        ModelDetail::Near => NEAR,
        ModelDetail::Mid => MID,
        ModelDetail::Shade => SHADE,
    };
    let sides = if detail == ModelDetail::Near { 7 } else { 3 };
    stem(&mut mesh, &STEM.0, &STEM.1, sides, BARK);
    for Whorl { z_m, radius_m, turn_rad, boughs } in whorls(seed, counts) {
        if detail == ModelDetail::Shade {
            skirt(&mut mesh, z_m - radius_m * 0.25, (z_m + HEIGHT_M * 0.30).min(HEIGHT_M), radius_m * 0.9, turn_rad);
        }
        boughs.iter().for_each(|of| bough(&mut mesh, of, detail));
    }
    if detail != ModelDetail::Shade {
        leader(&mut mesh);
    }
    mesh
}

/// Draws a strip from the stem outwards, bent in the middle at the near level, with a curtain of twigs under it.
fn bough(mesh: &mut Mesh, bough: &Bough, detail: ModelDetail) {
    let (out, aside) = (bough.out(), bough.aside());
    let colour = mix([0.034, 0.058, 0.031], [0.054, 0.082, 0.040], bough.tint);
    let shares: &[f32] = if detail == ModelDetail::Near { &EDGES } else { &[EDGES[0], EDGES[2]] };
    let mut strip = |aside: Vec3, drop: f32, light: f32| {
        let first = mesh.vertices.len() as u32;
        for &share in shares {
            for side in [-1.0, 1.0] {
                let hang = if drop > 0.0 && side < 0.0 { -Vec3::Z * drop * bough.length } else { Vec3::ZERO };
                let position = (bough.edge(share, aside * side) + hang).max(ON_GROUND);
                let normal = (out.extend(0.0) * (0.25 + share) + Vec3::Z * 0.75 + aside * side * 0.15).normalize();
                // Dark at the stem, light at the young tips.
                let light = light * (0.42 + 0.85 * share) * if hang == Vec3::ZERO { 1.0 } else { 0.7 };
                let uv = Vec2::new(0.5 + 0.5 * side, share)
                    + 2.0 * Vec2::new(bough.variant as f32, f32::from(CardCut::Bough as u8));
                mesh.vertex(Vertex::new(position, normal, shade(colour, light), uv, Material::Leaves));
            }
        }
        for row in 0..shares.len() as u32 - 1 {
            let at = first + 2 * row;
            mesh.indices.extend([at, at + 1, at + 3, at, at + 3, at + 2]);
        }
    };
    strip(aside, 0.0, 1.0);
    // The fewer boughs there are, the more hangs under each.
    strip(aside * 0.18, if detail == ModelDetail::Near { 0.30 } else { 0.50 }, 0.85);
}

/// Draws the tip: two crossed upright cards.
fn leader(mesh: &mut Mesh) {
    let crown = TreeCrown { middle: Vec3::Z * (HEIGHT_M - 2.0), half: Vec3::splat(2.0) };
    for across in [Vec3::X, Vec3::Y] {
        let card = LeafCard {
            at: Vec3::Z * (HEIGHT_M - 0.5),
            across: across * 0.26,
            along: Vec3::Z * 0.62,
            colour: [0.046, 0.072, 0.036],
            variant: 1,
            cut: CardCut::Bough,
        };
        card.draw(mesh, &crown);
    }
}

/// Draws a solid cone for the shadow.
fn skirt(mesh: &mut Mesh, low_z: f32, high_z: f32, radius: f32, turn: f32) {
    let first = mesh.vertices.len() as u32;
    let rim = 2 * SKIRT_POINTS as u32;
    for k in 0..rim {
        let reach = radius * if k % 2 == 0 { 1.0 } else { 0.66 };
        let out = Vec2::from_angle(turn + TAU * k as f32 / rim as f32);
        let position = (out * reach).extend(low_z.max(0.3));
        mesh.vertex(Vertex::new(position, out.extend(0.0), [0.05; 3], Vec2::ZERO, Material::Leaves));
    }
    let tip = mesh.vertex(Vertex::new(Vec3::Z * high_z, Vec3::Z, [0.05; 3], Vec2::ZERO, Material::Leaves));
    for k in 0..rim {
        mesh.indices.extend([first + k, first + (k + 1) % rim, tip]);
    }
}
