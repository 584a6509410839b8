//! Tree models, foot at the origin, metres: an oak, a maple, a birch, a spruce and a hazel bush. In: their forms. Out: meshes at three
//! [`ModelDetail`]s, all from the same boughs, so that near and far trees have the same shape.

pub(super) mod forest;
pub(super) mod leaf_cards;
pub(super) mod spruce;

use self::leaf_cards::{CardCut, LeafCard, ModelDetail, TreeCrown, gathered, stem};
use super::{
    Material, Mesh, Vertex,
    colours::{mix, shade},
};
use crate::{
    rng::{self, Stream},
    roadside::trees::broad_leaf::{self, LeafPatch, TreeSkeleton},
};
use glam::{Mat3, Vec2, Vec3};
use std::{
    f32::consts::TAU,
    sync::{Mutex, PoisonError},
};

/// Returns all models, in the order of [`kinds`](crate::roadside::trees). Those of the last seed are kept
/// for the next scene with it.
pub(in crate::scene) fn models(seed: u64, detail: ModelDetail) -> Vec<Mesh> {
    static LAST: [Mutex<Option<SeededModels>>; 3] = [const { Mutex::new(None) }; 3];
    let last = || LAST[detail as usize].lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(kept) = last().as_ref().filter(|kept| kept.seed == seed) {
        return kept.models.clone();
    }
    let models = built(seed, detail);
    *last() = Some(SeededModels { seed, models: models.clone() });
    models
}

/// Models of one detail, grown from a seed.
struct SeededModels {
    seed: u64,
    models: Vec<Mesh>,
}

/// Builds all models anew.
pub(in crate::scene) fn built(seed: u64, detail: ModelDetail) -> Vec<Mesh> {
    let broad = |kind, look| BroadLeafTree::new(TreeSkeleton::new(kind, seed), look).draw(detail);
    vec![
        broad(&broad_leaf::OAK, &OAK),
        broad(&broad_leaf::MAPLE, &MAPLE),
        broad(&broad_leaf::BIRCH, &BIRCH),
        spruce::spruce(seed, detail),
        broad(&broad_leaf::HAZEL, &HAZEL),
    ]
}

/// Look of a broad-leaved tree.
struct BroadLeafLook {
    /// Shape cut out of the cards at the near level.
    cut: CardCut,
    bark: [f32; 3],
    leaf: [f32; 3],
}

const OAK: BroadLeafLook =
    BroadLeafLook { cut: CardCut::Spray, bark: [0.175, 0.145, 0.114], leaf: [0.084, 0.124, 0.037] };
const MAPLE: BroadLeafLook =
    BroadLeafLook { cut: CardCut::Spray, bark: [0.200, 0.172, 0.142], leaf: [0.100, 0.142, 0.044] };
const BIRCH: BroadLeafLook =
    BroadLeafLook { cut: CardCut::Fine, bark: [0.52, 0.50, 0.46], leaf: [0.118, 0.156, 0.060] };
const HAZEL: BroadLeafLook =
    BroadLeafLook { cut: CardCut::Fine, bark: [0.14, 0.115, 0.088], leaf: [0.092, 0.132, 0.044] };

/// Broad-leaved tree that is ready to be drawn.
struct BroadLeafTree {
    skeleton: TreeSkeleton,
    bark: [f32; 3],
    cards: Vec<LeafCard>,
    crown: TreeCrown,
}

impl BroadLeafTree {
    fn new(skeleton: TreeSkeleton, look: &BroadLeafLook) -> Self {
        let kind = skeleton.kind;
        let crown_low = kind.height_m * kind.crown_from;
        let crown = TreeCrown {
            middle: Vec3::Z * (crown_low + (kind.height_m - crown_low) * (0.35 + 0.3 * kind.widest)),
            half: Vec3::new(kind.width_m, kind.width_m, kind.height_m - crown_low) / 2.0,
        };
        let card = |&LeafPatch { at, across, along, tint, variant }: &LeafPatch| LeafCard {
            at,
            across,
            along,
            colour: tinted(look.leaf, tint),
            variant,
            cut: look.cut,
        };
        Self { cards: skeleton.leaves.iter().map(card).collect(), bark: look.bark, crown, skeleton }
    }

    fn draw(&self, detail: ModelDetail) -> Mesh {
        let mut mesh = Mesh::default();
        // Sides of a limb by its order; 0 omits the limb.
        let sides: [u32; 3] = match detail {
            ModelDetail::Near => [8, 3, 0],
            ModelDetail::Mid => [5, 0, 0],
            ModelDetail::Shade => [3, 0, 0],
        };
        for limb in self.skeleton.limbs.iter().filter(|limb| sides[limb.order] > 0) {
            // For the shadow, one of several stems is enough.
            if matches!(detail, ModelDetail::Near | ModelDetail::Mid) || mesh.vertices.is_empty() {
                stem(&mut mesh, &limb.path, &limb.radii, sides[limb.order], self.bark);
            }
        }
        let mut cards = match detail {
            ModelDetail::Near => self.cards.clone(),
            ModelDetail::Mid => {
                // A card that replaces four is closer to the middle of the crown than the outermost of the four.
                let merged = |(card, count): (LeafCard, usize)| {
                    let times = 1.85 * (count as f32 / 4.0).sqrt().clamp(0.6, 1.4);
                    LeafCard { cut: CardCut::Mass, ..card.grown(times, 0.2, &self.crown) }
                };
                gathered(&self.cards, 4).into_iter().map(merged).collect()
            }
            ModelDetail::Shade => {
                let mut random = rng::stream(0, self.skeleton.kind.name);
                self.skeleton.lumps.iter().for_each(|&(at, size)| lump(&mut mesh, &mut random, at, size));
                return mesh;
            }
        };
        // The hull first, so that the leaves behind it are not shaded (early depth test).
        cards.sort_by(|a, b| self.crown.outside(b.at).total_cmp(&self.crown.outside(a.at)));
        cards.iter().for_each(|card| card.draw(&mut mesh, &self.crown));
        mesh
    }
}

fn tinted(leaf: [f32; 3], tint: f32) -> [f32; 3] {
    mix(shade(leaf, 0.80), [leaf[0] * 1.20, leaf[1] * 1.12, leaf[2] * 1.04], tint)
}

/// Adds a solid lump of leaves for the shadow: a dented ball.
pub(in crate::scene) fn lump(mesh: &mut Mesh, random: &mut Stream, at: Vec3, size_m: f32) {
    let turn =
        Mat3::from_rotation_z(random.uniform_f32(0.0, TAU)) * Mat3::from_rotation_x(random.uniform_f32(0.0, TAU));
    let first = mesh.vertices.len() as u32;
    for corner in icosahedron() {
        let direction = turn * corner;
        let position = at + direction * size_m * random.uniform_f32(0.6, 1.1);
        mesh.vertex(Vertex::new(position, direction, [0.1; 3], Vec2::ZERO, Material::Leaves));
    }
    mesh.indices.extend(ICOSAHEDRON_FACES.iter().flatten().map(|i| first + i));
}

/// Returns the corners of the unit icosahedron.
fn icosahedron() -> [Vec3; 12] {
    // 1 and the golden ratio, on the unit sphere.
    const A: f32 = 0.525_731_1;
    const B: f32 = 0.850_650_8;
    [
        [-A, B, 0.0],
        [A, B, 0.0],
        [-A, -B, 0.0],
        [A, -B, 0.0],
        [0.0, -A, B],
        [0.0, A, B],
        [0.0, -A, -B],
        [0.0, A, -B],
        [B, 0.0, -A],
        [B, 0.0, A],
        [-B, 0.0, -A],
        [-B, 0.0, A],
    ]
    .map(Vec3::from)
}

/// Faces of [`icosahedron`], counter-clockwise from outside.
#[rustfmt::skip]
const ICOSAHEDRON_FACES: [[u32; 3]; 20] = [
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
    [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        roadside::trees::{KINDS, broad_leaf::VARIANTS},
        scene::mesh::tests::check,
    };

    #[test]
    fn trees_are_valid_meshes_within_their_triangle_limits() {
        let near = models(1, ModelDetail::Near);
        assert_eq!(near.len(), KINDS);
        let levels = [(ModelDetail::Near, 500, 1500), (ModelDetail::Mid, 100, 400), (ModelDetail::Shade, 60, 450)];
        for (detail, least, most) in levels {
            for (kind, (mesh, near)) in models(1, detail).iter().zip(&near).enumerate() {
                check(mesh, "tree");
                assert!((least..=most).contains(&mesh.triangles()), "{kind} {detail:?}: {}", mesh.triangles());
                let ((low, high), near_high) = (mesh.bounds(), near.bounds().1.z);
                assert!(low.z > -1.0 && low.z <= 0.01, "{kind} {detail:?}: foot {low}");
                let share = high.z / near_high;
                assert!((0.75..1.12).contains(&share), "{kind} {detail:?}: {} or {near_high} m high", high.z);
            }
        }
    }

    #[test]
    fn texture_coordinates_of_a_card_hold_cut_variant_and_position() {
        for mesh in models(1, ModelDetail::Near).iter().chain(&models(1, ModelDetail::Mid)) {
            for v in mesh.vertices.iter().filter(|v| v.material == Material::Leaves as u32) {
                let [variant, cut] = v.uv.map(|c| (c / 2.0).floor());
                assert!((0.0..VARIANTS as f32).contains(&variant) && (0.0..=4.0).contains(&cut), "{v:?}");
                for (place, whole) in v.uv.iter().zip([variant, cut]) {
                    assert!((0.0..=1.0).contains(&(place - 2.0 * whole)), "{v:?}");
                }
            }
        }
    }

    #[test]
    fn crowns_are_irregular() {
        // Seen from above, the outline's radius varies by more than a tenth.
        for (kind, mesh) in models(1, ModelDetail::Near).iter().enumerate() {
            let mut reach = [0f32; 24];
            for v in mesh.vertices.iter().filter(|v| v.material == Material::Leaves as u32) {
                let p = Vec3::from(v.position).truncate();
                let sector = ((p.y.atan2(p.x) / TAU + 0.5) * 24.0) as usize % 24;
                reach[sector] = reach[sector].max(p.length());
            }
            let mean = reach.iter().sum::<f32>() / 24.0;
            let sd = (reach.iter().map(|r| (r - mean).powi(2)).sum::<f32>() / 24.0).sqrt();
            assert!(sd / mean > 0.1, "{kind}: {sd} of {mean}");
        }
    }
}
