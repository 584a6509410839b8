//! Spruce model: whorls of drooping boughs along a straight stem, long below, short above. In: a seed and a detail. Out: a mesh,
//! foot at the origin, metres. Each bough is a bent strip of leaf cards with a second strip hanging under it.

use super::leaf_cards::{CardCut, LeafCard, ModelDetail, TreeCrown, VARIANTS, stem};
use crate::{
    rng,
    scene::{
        Material, Mesh, Vertex,
        land::noise::{mix, shade},
    },
};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

const HEIGHT_M: f32 = 12.5;
const RADIUS_M: f32 = 2.6;
/// Height of the lowest whorl, metres.
const FOOT_M: f32 = 0.7;
/// Lower limit of a bough's coordinates, metres: no bough is below the ground.
const ON_GROUND: Vec3 = Vec3::new(f32::MIN, f32::MIN, 0.0);
const BARK: [f32; 3] = [0.155, 0.118, 0.092];

/// Returns the number of whorls, boughs per whorl, and the width of a bough as a fraction of its length.
fn counts(detail: ModelDetail) -> (usize, usize, f32) {
    match detail {
        ModelDetail::Near => (20, 9, 0.36),
        ModelDetail::Mid => (16, 6, 0.56),
        ModelDetail::Shade => (5, 7, 0.0),
    }
}

/// Returns the spruce at a level of detail.
pub(in crate::scene) fn spruce(seed: u64, detail: ModelDetail) -> Mesh {
    let mut random = rng::stream(seed, "spruce");
    let mut draw = |low: f32, high: f32| random.uniform(f64::from(low), f64::from(high)) as f32;
    let mut mesh = Mesh::default();
    let (whorls, boughs, wide) = counts(detail);
    let sides = if detail == ModelDetail::Near { 7 } else { 3 };
    let path = [Vec3::Z * -0.1, Vec3::Z * HEIGHT_M * 0.5, Vec3::Z * (HEIGHT_M - 0.3)];
    stem(&mut mesh, &path, &[0.20, 0.10, 0.012], sides, BARK);
    for whorl in (0..whorls).rev() {
        let t = (whorl as f32 + draw(-0.25, 0.25)).max(0.0) / whorls as f32;
        let z = FOOT_M + (HEIGHT_M - FOOT_M) * t.powf(0.93);
        let radius = RADIUS_M * (1.0 - t).powf(0.82) * draw(0.9, 1.06) + 0.18;
        let turn = draw(0.0, TAU);
        if detail == ModelDetail::Shade {
            skirt(&mut mesh, z - radius * 0.25, (z + HEIGHT_M * 0.30).min(HEIGHT_M), radius * 0.9, turn, boughs);
            continue;
        }
        for k in 0..boughs {
            let azimuth = turn + TAU * (k as f32 + draw(-0.28, 0.28)) / boughs as f32;
            let length = radius * draw(0.66, 1.06) * (1.0 + 0.15 * (azimuth + 2.0).sin());
            let foot = Vec3::Z * (z + draw(-0.22, 0.22));
            // Low boughs hang, high boughs point up.
            let pitch = -0.42 + 0.95 * t * t + draw(-0.10, 0.10);
            let tint = draw(0.0, 1.0);
            let colour = mix([0.034, 0.058, 0.031], [0.054, 0.082, 0.040], tint);
            let variant = (draw(0.0, VARIANTS as f32) as usize).min(VARIANTS - 1);
            bough(&mut mesh, &Bough { foot, azimuth, pitch, length, wide, colour, variant }, detail);
        }
    }
    if detail != ModelDetail::Shade {
        leader(&mut mesh);
    }
    mesh
}

struct Bough {
    foot: Vec3,
    azimuth: f32,
    /// Angle above the horizon, radians.
    pitch: f32,
    length: f32,
    wide: f32,
    colour: [f32; 3],
    variant: usize,
}

/// Draws a strip from the stem outwards, bent in the middle at the near level, with a curtain of twigs under it.
fn bough(mesh: &mut Mesh, bough: &Bough, detail: ModelDetail) {
    let out = Vec2::from_angle(bough.azimuth);
    let point = |share: f32| {
        // Slope of the bough; its end curves upwards.
        let up = bough.length * (share * bough.pitch.tan() + 0.16 * share * share);
        bough.foot + (out * bough.length * share).extend(up)
    };
    let aside = out.perp().extend(0.0) * bough.length * bough.wide;
    let shares: &[f32] = if detail == ModelDetail::Near { &[0.02, 0.5, 1.0] } else { &[0.02, 1.0] };
    let mut strip = |aside: Vec3, drop: f32, light: f32| {
        let first = mesh.vertices.len() as u32;
        for &share in shares {
            let width = (0.55 + 0.45 * share).min(1.0);
            for side in [-1.0, 1.0] {
                let hang = if drop > 0.0 && side < 0.0 { -Vec3::Z * drop * bough.length } else { Vec3::ZERO };
                let position = (point(share) + aside * side * width + hang).max(ON_GROUND);
                let normal = (out.extend(0.0) * (0.25 + share) + Vec3::Z * 0.75 + aside * side * 0.15).normalize();
                // Dark at the stem, light at the young tips.
                let light = light * (0.42 + 0.85 * share) * if hang == Vec3::ZERO { 1.0 } else { 0.7 };
                let uv = Vec2::new(0.5 + 0.5 * side, share)
                    + 2.0 * Vec2::new(bough.variant as f32, f32::from(CardCut::Bough as u8));
                mesh.vertex(Vertex::new(position, normal, shade(bough.colour, light), uv, Material::Leaves));
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
fn skirt(mesh: &mut Mesh, low_z: f32, high_z: f32, radius: f32, turn: f32, points: usize) {
    let first = mesh.vertices.len() as u32;
    let rim = 2 * points as u32;
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
