//! Form of broad-leaved trees: an irregular stem, boughs at the golden angle with the reach of the species' outline, twigs on them, leaves
//! along the twigs. In: a species and a seed. Out: a [`TreeSkeleton`], foot at the origin, metres.

use crate::rng::{self, Stream};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Number of different pictures of leaves.
pub const VARIANTS: usize = 8;

/// Dimensions of a broad-leaved tree.
#[derive(Debug)]
pub struct BroadLeafMeasures {
    pub name: &'static str,
    pub height_m: f32,
    pub width_m: f32,
    /// Height of the crown's lower end, as a fraction of the tree's height.
    pub crown_from: f32,
    pub trunk_radius_m: f32,
    /// Number of stems from the ground.
    pub stems: usize,
    pub boughs: usize,
    /// Height in the crown (0..1) at which it is widest.
    pub widest: f32,
    /// Angle of the boughs above the horizon at their base, radians.
    pub rise_rad: f32,
    /// Drop of the boughs' ends, as a fraction of their length; negative bends them up.
    pub droop: f32,
    pub cards: usize,
    /// Half the side of a leaf card, metres.
    pub card_m: f32,
}

pub const OAK: BroadLeafMeasures = BroadLeafMeasures {
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
};
pub const MAPLE: BroadLeafMeasures = BroadLeafMeasures {
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
};
pub const BIRCH: BroadLeafMeasures = BroadLeafMeasures {
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
};
pub const HAZEL: BroadLeafMeasures = BroadLeafMeasures {
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
};

/// Stem, bough or twig.
#[derive(Debug)]
pub struct Limb {
    /// Points along the limb, metres.
    pub path: [Vec3; 4],
    pub radii: [f32; 4],
    /// Order of branching: 0 stem, 1 bough, 2 twig.
    pub order: usize,
}

/// Leaves that grow together on a flat piece.
#[derive(Clone, Copy, Debug)]
pub struct LeafPatch {
    /// Middle of the piece, metres.
    pub at: Vec3,
    /// Vectors from the middle to two edges at a right angle.
    pub across: Vec3,
    pub along: Vec3,
    /// Shade of green, 0 dark to 1 light.
    pub tint: f32,
    /// Index of the picture, below [`VARIANTS`].
    pub variant: usize,
}

/// Branches and leaves of a tree, from which each level of detail is drawn.
#[derive(Debug)]
pub struct TreeSkeleton {
    pub kind: &'static BroadLeafMeasures,
    /// Stems, then for each bough its twigs and the bough.
    pub limbs: Vec<Limb>,
    pub leaves: Vec<LeafPatch>,
    /// Lumps of leaves as a shadow shows them: middle and radius, metres.
    pub lumps: Vec<(Vec3, f32)>,
}

/// Returns a random direction, uniform over the sphere.
fn any_direction(random: &mut Stream) -> Vec3 {
    let z = random.uniform_f32(-1.0, 1.0);
    (Vec2::from_angle(random.uniform_f32(0.0, TAU)) * (1.0 - z * z).sqrt()).extend(z)
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
    /// Grows a tree of this kind.
    pub fn new(kind: &'static BroadLeafMeasures, seed: u64) -> Self {
        let mut random = rng::stream(seed, kind.name);
        let random = &mut random;
        let mut limbs: Vec<Limb> = (0..kind.stems).map(|k| stem_of(kind, k, random)).collect();
        let turn = random.uniform_f32(0.0, TAU);
        for k in 0..kind.boughs {
            let t = (k as f32 + random.uniform_f32(0.15, 0.85)) / kind.boughs as f32;
            let azimuth = turn + k as f32 * 2.399_963 + random.uniform_f32(-0.3, 0.3);
            let bough = bough_of(kind, &limbs[k % kind.stems], t, azimuth, random);
            for (from, side) in [(0.42, 0.8), (0.62, -0.75), (0.80, 0.6)] {
                limbs.push(twig_of(&bough, from + random.uniform_f32(-0.06, 0.06), side, random));
            }
            limbs.push(bough);
        }
        let leaves = leaves(kind, &limbs, random);
        let ends = limbs.iter().filter(|limb| limb.order == 1);
        let size = kind.width_m * 0.17;
        let lumps = ends.map(|limb| (limb.at(0.72), size * random.uniform_f32(0.8, 1.25))).collect();
        Self { kind, limbs, leaves, lumps }
    }

    /// Returns the largest distance of a leaf from the middle of the foot, metres.
    pub fn crown_radius_m(&self) -> f32 {
        let corners = self.leaves.iter().flat_map(|leaves| {
            let [a, b] = [leaves.across + leaves.along, leaves.across - leaves.along];
            [a, -a, b, -b].map(|off| leaves.at + off)
        });
        corners.map(|corner| corner.truncate().length()).fold(0.0, f32::max)
    }
}

/// Returns the `k`th stem, from the ground to near the top.
fn stem_of(kind: &BroadLeafMeasures, k: usize, random: &mut Stream) -> Limb {
    let spread = if kind.stems == 1 { 0.035 } else { 0.22 };
    let lean =
        Vec2::from_angle(TAU * k as f32 / kind.stems as f32 + random.uniform_f32(-0.4, 0.4)) * spread * kind.height_m;
    let mut wander = || Vec2::new(random.uniform_f32(-1.0, 1.0), random.uniform_f32(-1.0, 1.0)) * 0.02 * kind.height_m;
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
    let reach =
        kind.width_m / 2.0 * kind.outline(t) * random.uniform_f32(0.58, 0.98) * (1.0 + 0.14 * (azimuth + 1.0).sin());

    // Steeper towards the top.
    let rise = kind.rise_rad + (1.25 - kind.rise_rad) * t * t * 0.8 + random.uniform_f32(-0.12, 0.12);
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
    let length = bough.length_m() * (1.05 - from) * random.uniform_f32(0.55, 0.85);
    let towards = (along * 0.7 + aside + Vec3::Z * random.uniform_f32(-0.15, 0.5)).normalize() * length;
    let r = bough.radius_m(from) * 0.6;
    Limb {
        path: [0.0, 0.33, 0.66, 1.0].map(|share| foot + towards * share),
        radii: [r, r * 0.7, r * 0.4, r * 0.15],
        order: 2,
    }
}

/// Returns leaves along the outer part of boughs and twigs and around the tips of the stems.
fn leaves(kind: &BroadLeafMeasures, limbs: &[Limb], random: &mut Stream) -> Vec<LeafPatch> {
    // Longer limbs have more leaves.
    let bears = |limb: &Limb| limb.length_m() * if limb.order == 0 { 0.16 * kind.crown_from + 0.10 } else { 1.0 } + 0.2;
    let weights: Vec<f32> = limbs.iter().map(bears).collect();
    let total: f32 = weights.iter().sum();
    let tints: Vec<f32> = limbs.iter().map(|_| random.uniform_f32(0.0, 1.0)).collect();
    let mut leaves = Vec::with_capacity(kind.cards);
    for _ in 0..kind.cards {
        let mut pick = random.uniform_f32(0.0, total);
        let index = weights.iter().position(|w| {
            pick -= w;
            pick <= 0.0
        });
        let index = index.unwrap_or(limbs.len() - 1);
        let limb = &limbs[index];
        let inner = [0.80, 0.38, 0.20][limb.order];
        let t = inner + (1.02 - inner) * random.uniform_f32(0.0, 1.0).sqrt();
        let size = kind.card_m * random.uniform_f32(0.75, 1.20);
        let outwards = any_direction(random);
        // Leaves surround their twig, with more of them above it.
        let at = limb.at(t) + outwards * size * random.uniform_f32(0.15, 1.15) + Vec3::Z * size * 0.2;
        let face = (any_direction(random) + outwards * 0.55 + Vec3::Z * 0.35).normalize_or(Vec3::Z);
        let (x, y) = face.any_orthonormal_pair();
        let (sin, cos) = random.uniform_f32(0.0, TAU).sin_cos();
        let tint = 0.6 * tints[index] + 0.4 * random.uniform_f32(0.0, 1.0);
        leaves.push(LeafPatch {
            at: at.max(Vec3::new(f32::MIN, f32::MIN, size * 0.4)),
            across: (x * cos + y * sin) * size,
            along: (y * cos - x * sin) * size,
            tint,
            variant: random.index(VARIANTS),
        });
    }
    leaves
}
