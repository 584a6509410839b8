//! Tree models, foot at the origin, metres: an oak, a maple, a birch, a spruce and a hazel bush. Each is generated once and drawn
//! at three [`ModelDetail`]s from the same boughs, so that near and far trees have the same shape. Broad-leaved trees: an
//! irregular stem, boughs at the golden angle with the reach of the species' outline, twigs on them, leaf cards along the twigs.

pub(super) mod forest;
pub(super) mod leaf_cards;
pub(super) mod spruce;

use self::leaf_cards::{CardCut, LeafCard, ModelDetail, TreeCrown, VARIANTS, gathered, stem};
use super::{
    Material, Mesh, Vertex,
    land::noise::{mix, shade},
};
use crate::rng::{self, Stream};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

#[cfg(test)]
pub(in crate::scene) const KINDS: usize = 5;
/// Index of the bush, which grows at the edges of woods.
pub(in crate::scene) const BUSH: usize = 4;
/// Index of the spruce, which grows in groups.
pub(in crate::scene) const SPRUCE: usize = 3;

/// Returns all models, in the order oak, maple, birch, spruce, hazel.
pub(in crate::scene) fn models(seed: u64, detail: ModelDetail) -> Vec<Mesh> {
    let broad = |kind| TreeSkeleton::new(kind, seed).draw(detail);
    vec![broad(&OAK), broad(&MAPLE), broad(&BIRCH), spruce::spruce(seed, detail), broad(&HAZEL)]
}

/// Dimensions of a broad-leaved tree.
struct BroadLeafMeasures {
    name: &'static str,
    height_m: f32,
    width_m: f32,
    /// Height of the crown's lower end, as a fraction of the tree's height.
    crown_from: f32,
    trunk_radius_m: f32,
    /// Number of stems from the ground.
    stems: usize,
    boughs: usize,
    /// Height in the crown (0..1) at which it is widest.
    widest: f32,
    /// Angle of the boughs above the horizon at their base, radians.
    rise_rad: f32,
    /// Drop of the boughs' ends, as a fraction of their length; negative bends them up.
    droop: f32,
    cards: usize,
    /// Half the side of a leaf card, metres.
    card_m: f32,
    /// Shape cut out of the cards at the near level.
    cut: CardCut,
    bark: [f32; 3],
    leaf: [f32; 3],
}

const OAK: BroadLeafMeasures = BroadLeafMeasures {
    name: "oak",
    height_m: 10.8,
    width_m: 8.8,
    crown_from: 0.22,
    trunk_radius_m: 0.32,
    stems: 1,
    boughs: 13,
    widest: 0.42,
    rise_rad: 0.42,
    droop: -0.10,
    cards: 560,
    card_m: 0.60,
    cut: CardCut::Spray,
    bark: [0.175, 0.145, 0.114],
    leaf: [0.084, 0.124, 0.037],
};
const MAPLE: BroadLeafMeasures = BroadLeafMeasures {
    name: "maple",
    height_m: 9.4,
    width_m: 6.4,
    crown_from: 0.18,
    trunk_radius_m: 0.21,
    stems: 1,
    boughs: 14,
    widest: 0.33,
    rise_rad: 0.75,
    droop: 0.05,
    cards: 520,
    card_m: 0.50,
    cut: CardCut::Spray,
    bark: [0.200, 0.172, 0.142],
    leaf: [0.100, 0.142, 0.044],
};
const BIRCH: BroadLeafMeasures = BroadLeafMeasures {
    name: "birch",
    height_m: 12.0,
    width_m: 4.8,
    crown_from: 0.24,
    trunk_radius_m: 0.13,
    stems: 1,
    boughs: 17,
    widest: 0.30,
    rise_rad: 0.95,
    droop: 0.42,
    cards: 480,
    card_m: 0.44,
    cut: CardCut::Fine,
    bark: [0.52, 0.50, 0.46],
    leaf: [0.118, 0.156, 0.060],
};
const HAZEL: BroadLeafMeasures = BroadLeafMeasures {
    name: "hazel",
    height_m: 2.7,
    width_m: 3.2,
    crown_from: 0.0,
    trunk_radius_m: 0.045,
    stems: 5,
    boughs: 14,
    widest: 0.45,
    rise_rad: 0.85,
    droop: 0.15,
    cards: 330,
    card_m: 0.27,
    cut: CardCut::Fine,
    bark: [0.14, 0.115, 0.088],
    leaf: [0.092, 0.132, 0.044],
};

/// Stem, bough or twig.
struct Limb {
    path: [Vec3; 4],
    radii: [f32; 4],
    /// Order of branching: 0 stem, 1 bough, 2 twig.
    order: usize,
}

/// Branches and leaf cards of a tree, from which each level of detail is drawn.
struct TreeSkeleton {
    kind: &'static BroadLeafMeasures,
    limbs: Vec<Limb>,
    cards: Vec<LeafCard>,
    crown: TreeCrown,
    lumps: Vec<(Vec3, f32)>,
}

fn draw(random: &mut Stream, low: f32, high: f32) -> f32 {
    random.uniform(f64::from(low), f64::from(high)) as f32
}

/// Returns a random direction, uniform over the sphere.
fn any_direction(random: &mut Stream) -> Vec3 {
    let z = draw(random, -1.0, 1.0);
    (Vec2::from_angle(draw(random, 0.0, TAU)) * (1.0 - z * z).sqrt()).extend(z)
}

impl BroadLeafMeasures {
    /// Returns the reach of the crown at the height `t` in it (0 bottom, 1 top), as a fraction of half its width.
    fn outline(&self, t: f32) -> f32 {
        let d = if t < self.widest {
            (self.widest - t) / (self.widest + 0.12)
        } else {
            (t - self.widest) / (1.0 - self.widest)
        };
        (1.0 - d * d).max(0.0).sqrt().max(0.16)
    }
}

impl Limb {
    /// Returns a point at the fraction `t` of the limb's length.
    fn at(&self, t: f32) -> Vec3 {
        let place = t.clamp(0.0, 0.9999) * 3.0;
        let i = place as usize;
        self.path[i].lerp(self.path[i + 1], place - i as f32)
    }

    fn radius_m(&self, t: f32) -> f32 {
        let place = t.clamp(0.0, 0.9999) * 3.0;
        let i = place as usize;
        self.radii[i] + (self.radii[i + 1] - self.radii[i]) * (place - i as f32)
    }

    fn length_m(&self) -> f32 {
        self.path.windows(2).map(|p| p[0].distance(p[1])).sum()
    }
}

impl TreeSkeleton {
    fn new(kind: &'static BroadLeafMeasures, seed: u64) -> Self {
        let mut random = rng::stream(seed, kind.name);
        let random = &mut random;
        let crown_low = kind.height_m * kind.crown_from;
        let crown = TreeCrown {
            middle: Vec3::Z * (crown_low + (kind.height_m - crown_low) * (0.35 + 0.3 * kind.widest)),
            half: Vec3::new(kind.width_m, kind.width_m, kind.height_m - crown_low) / 2.0,
        };
        let mut limbs: Vec<Limb> = (0..kind.stems).map(|k| stem_of(kind, k, random)).collect();
        let turn = draw(random, 0.0, TAU);
        for k in 0..kind.boughs {
            let t = (k as f32 + draw(random, 0.15, 0.85)) / kind.boughs as f32;
            let azimuth = turn + k as f32 * 2.399_963 + draw(random, -0.3, 0.3);
            let bough = bough_of(kind, &limbs[k % kind.stems], t, azimuth, random);
            for (from, side) in [(0.42, 0.8), (0.62, -0.75), (0.80, 0.6)] {
                limbs.push(twig_of(&bough, from + draw(random, -0.06, 0.06), side, random));
            }
            limbs.push(bough);
        }
        let cards = leaves(kind, &limbs, random);
        let ends = limbs.iter().filter(|limb| limb.order == 1);
        let size = kind.width_m * 0.17;
        let lumps = ends.map(|limb| (limb.at(0.72), size * draw(random, 0.8, 1.25))).collect();
        Self { kind, limbs, cards, crown, lumps }
    }

    fn draw(&self, detail: ModelDetail) -> Mesh {
        let mut mesh = Mesh::default();
        // Sides of a limb by its order; 0 omits the limb.
        let sides: [u32; 3] = match detail {
            ModelDetail::Near => [8, 3, 0],
            ModelDetail::Mid => [5, 0, 0],
            ModelDetail::Shade => [3, 0, 0],
        };
        for limb in self.limbs.iter().filter(|limb| sides[limb.order] > 0) {
            // For the shadow, one of several stems is enough.
            if matches!(detail, ModelDetail::Near | ModelDetail::Mid) || mesh.vertices.is_empty() {
                stem(&mut mesh, &limb.path, &limb.radii, sides[limb.order], self.kind.bark);
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
                let mut random = rng::stream(0, self.kind.name);
                self.lumps.iter().for_each(|&(at, size)| lump(&mut mesh, &mut random, at, size));
                return mesh;
            }
        };
        // The hull first, so that the leaves behind it are not shaded (early depth test).
        cards.sort_by(|a, b| self.crown.outside(b.at).total_cmp(&self.crown.outside(a.at)));
        cards.iter().for_each(|card| card.draw(&mut mesh, &self.crown));
        mesh
    }
}

/// Returns the `k`th stem, from the ground to near the top.
fn stem_of(kind: &BroadLeafMeasures, k: usize, random: &mut Stream) -> Limb {
    let spread = if kind.stems == 1 { 0.035 } else { 0.22 };
    let lean = Vec2::from_angle(TAU * k as f32 / kind.stems as f32 + draw(random, -0.4, 0.4)) * spread * kind.height_m;
    let mut wander = || Vec2::new(draw(random, -1.0, 1.0), draw(random, -1.0, 1.0)) * 0.02 * kind.height_m;
    let top = kind.height_m * 0.90;
    let path = [
        (lean * 0.08).extend(-0.1),
        (lean * 0.35 + wander()).extend(top * 0.33),
        (lean * 0.75 + wander()).extend(top * 0.66),
        (lean + wander() * 2.0).extend(top),
    ];
    let r = kind.trunk_radius_m;
    Limb { path, radii: [r * 1.35, r * 0.82, r * 0.45, r * 0.10], order: 0 }
}

/// Returns a bough that ends at the height `t` of the crown.
fn bough_of(kind: &BroadLeafMeasures, stem: &Limb, t: f32, azimuth: f32, random: &mut Stream) -> Limb {
    let crown_m = kind.height_m * (1.0 - kind.crown_from);
    // The bough leaves the stem below the height of its end.
    let from = (kind.crown_from * 0.9 + (1.0 - kind.crown_from) * t * 0.86).clamp(0.03, 0.97);
    let foot = stem.at(from);
    // Longer towards one side, as trees grow towards the light.
    let reach = kind.width_m / 2.0 * kind.outline(t) * draw(random, 0.58, 0.98) * (1.0 + 0.14 * (azimuth + 1.0).sin());

    // Steeper towards the top.
    let rise = kind.rise_rad + (1.25 - kind.rise_rad) * t * t * 0.8 + draw(random, -0.12, 0.12);
    let out = Vec2::from_angle(azimuth);
    let length = reach.max(crown_m * 0.07);
    let point = |share: f32| {
        let up = length * (share * rise.tan().min(1.5) * 0.75 - kind.droop * share * share * 1.6);
        let sway = out.perp() * length * 0.10 * (share * 5.0 + azimuth * 3.0).sin();
        (foot + (out * length * share + sway).extend(up)).max(Vec3::new(f32::MIN, f32::MIN, 0.12))
    };
    let r = (stem.radius_m(from) * 0.55).min(0.03 + length * 0.02);
    Limb { path: [foot, point(0.35), point(0.7), point(1.0)], radii: [r, r * 0.75, r * 0.5, r * 0.2], order: 1 }
}

/// Returns a twig to one side of a bough, from the fraction `from` of the bough's length.
fn twig_of(bough: &Limb, from: f32, side: f32, random: &mut Stream) -> Limb {
    let foot = bough.at(from);
    let along = (bough.at(from + 0.1) - bough.at(from - 0.1)).normalize_or(Vec3::X);
    let aside = along.cross(Vec3::Z).normalize_or(Vec3::Y) * side;
    let length = bough.length_m() * (1.05 - from) * draw(random, 0.55, 0.85);
    let towards = (along * 0.7 + aside + Vec3::Z * draw(random, -0.15, 0.5)).normalize() * length;
    let r = bough.radius_m(from) * 0.6;
    Limb {
        path: [0.0, 0.33, 0.66, 1.0].map(|share| foot + towards * share),
        radii: [r, r * 0.7, r * 0.4, r * 0.15],
        order: 2,
    }
}

/// Returns leaf cards along the outer part of boughs and twigs and around the tips of the stems.
fn leaves(kind: &BroadLeafMeasures, limbs: &[Limb], random: &mut Stream) -> Vec<LeafCard> {
    // Longer limbs have more leaves.
    let bears = |limb: &Limb| limb.length_m() * if limb.order == 0 { 0.16 * kind.crown_from + 0.10 } else { 1.0 } + 0.2;
    let weights: Vec<f32> = limbs.iter().map(bears).collect();
    let total: f32 = weights.iter().sum();
    let tints: Vec<f32> = limbs.iter().map(|_| draw(random, 0.0, 1.0)).collect();
    let mut cards = Vec::with_capacity(kind.cards);
    for _ in 0..kind.cards {
        let mut pick = draw(random, 0.0, total);
        let index = weights.iter().position(|w| {
            pick -= w;
            pick <= 0.0
        });
        let index = index.unwrap_or(limbs.len() - 1);
        let limb = &limbs[index];
        let inner = [0.80, 0.38, 0.20][limb.order];
        let t = inner + (1.02 - inner) * draw(random, 0.0, 1.0).sqrt();
        let size = kind.card_m * draw(random, 0.75, 1.20);
        let outwards = any_direction(random);
        // Leaves surround their twig, with more of them above it.
        let at = limb.at(t) + outwards * size * draw(random, 0.15, 1.15) + Vec3::Z * size * 0.2;
        let face = (any_direction(random) + outwards * 0.55 + Vec3::Z * 0.35).normalize_or(Vec3::Z);
        let (x, y) = face.any_orthonormal_pair();
        let (sin, cos) = draw(random, 0.0, TAU).sin_cos();
        let tint = 0.6 * tints[index] + 0.4 * draw(random, 0.0, 1.0);
        cards.push(LeafCard {
            at: at.max(Vec3::new(f32::MIN, f32::MIN, size * 0.4)),
            across: (x * cos + y * sin) * size,
            along: (y * cos - x * sin) * size,
            colour: tinted(kind.leaf, tint),
            variant: random.index(VARIANTS),
            cut: kind.cut,
        });
    }
    cards
}

fn tinted(leaf: [f32; 3], tint: f32) -> [f32; 3] {
    mix(shade(leaf, 0.80), [leaf[0] * 1.20, leaf[1] * 1.12, leaf[2] * 1.04], tint)
}

/// Adds a solid lump of leaves for the shadow: a dented ball.
pub(in crate::scene) fn lump(mesh: &mut Mesh, random: &mut Stream, at: Vec3, size_m: f32) {
    let turn = Mat3::from_rotation_z(draw(random, 0.0, TAU)) * Mat3::from_rotation_x(draw(random, 0.0, TAU));
    let first = mesh.vertices.len() as u32;
    for corner in icosahedron() {
        let direction = turn * corner;
        let position = at + direction * size_m * draw(random, 0.6, 1.1);
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
    use crate::scene::mesh::tests::check;

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
