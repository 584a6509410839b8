//! Tree models, foot at the origin, metres: two broad oaks, a birch, a spruce and a bush, each near (300-600 triangles) and
//! far (about a quarter). Crowns are clumps of leaves set irregularly about a hull; their normals point away from the crown
//! as well as from the clump, so that light falls on the crown as a whole; the inside is darker.

use super::noise::{mix, shade};
use super::{Material, Mesh, Vertex};
use crate::rng::{self, Stream};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// How much a model shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Detail {
    /// Some five hundred triangles.
    Near,
    /// Some hundred triangles, same outline and colour.
    Far,
}

/// Number of models.
#[cfg(test)]
pub(super) const KINDS: usize = 5;
/// Index of the bush, which stands at the edges of the woods.
pub(super) const BUSH: usize = 4;
/// Index of the spruce, which keeps to its own kind.
pub(super) const SPRUCE: usize = 3;

/// All models in a fixed order.
pub(super) fn models(seed: u64, detail: Detail) -> Vec<Mesh> {
    vec![
        grow(&OAK, seed, detail),
        grow(&MAPLE, seed, detail),
        grow(&BIRCH, seed, detail),
        spruce(seed, detail),
        grow(&HAZEL, seed, detail),
    ]
}

/// The measures of a broad-leaved tree.
struct Broad {
    name: &'static str,
    height_m: f32,
    width_m: f32,
    /// Where the crown begins, as a fraction of the height.
    crown_from: f32,
    trunk_radius_m: f32,
    clumps: usize,
    /// Tufts on all clumps together.
    sprigs: usize,
    /// Radius of a clump, metres at a scale of the crown's width.
    clump_size: f32,
    bark: [f32; 3],
    leaf: [f32; 3],
}

const OAK: Broad = Broad {
    name: "oak",
    height_m: 10.5,
    width_m: 8.4,
    crown_from: 0.24,
    trunk_radius_m: 0.30,
    clumps: 11,
    sprigs: 88,
    clump_size: 0.22,
    bark: [0.075, 0.058, 0.042],
    leaf: [0.082, 0.155, 0.034],
};
const MAPLE: Broad = Broad {
    name: "maple",
    height_m: 9.0,
    width_m: 6.2,
    crown_from: 0.22,
    trunk_radius_m: 0.21,
    clumps: 10,
    sprigs: 90,
    clump_size: 0.23,
    bark: [0.090, 0.075, 0.060],
    leaf: [0.100, 0.172, 0.038],
};
const BIRCH: Broad = Broad {
    name: "birch",
    height_m: 11.5,
    width_m: 4.4,
    crown_from: 0.26,
    trunk_radius_m: 0.13,
    clumps: 10,
    sprigs: 88,
    clump_size: 0.24,
    bark: [0.52, 0.50, 0.46],
    leaf: [0.118, 0.190, 0.052],
};
const HAZEL: Broad = Broad {
    name: "hazel",
    height_m: 2.6,
    width_m: 3.2,
    crown_from: 0.05,
    trunk_radius_m: 0.05,
    clumps: 6,
    sprigs: 54,
    clump_size: 0.26,
    bark: [0.07, 0.055, 0.04],
    leaf: [0.092, 0.165, 0.040],
};

/// Builds a broad-leaved tree.
fn grow(kind: &Broad, seed: u64, detail: Detail) -> Mesh {
    let mut random = rng::stream(seed, kind.name);
    let mut mesh = Mesh::default();
    let crown_low = kind.height_m * kind.crown_from;
    let middle = Vec3::Z * (crown_low + kind.height_m) / 2.0;
    let half = Vec3::new(kind.width_m, kind.width_m, kind.height_m - crown_low) / 2.0;
    let lean = Vec3::new(random.uniform(-0.35, 0.35) as f32, random.uniform(-0.35, 0.35) as f32, 0.0);
    let path =
        [Vec3::ZERO, Vec3::Z * crown_low * 0.55 + lean * 0.4, Vec3::Z * crown_low * 1.15 + lean, middle + lean * 0.6];
    let r = kind.trunk_radius_m;
    let sides = if detail == Detail::Near { 6 } else { 3 };
    tube(&mut mesh, &path, &[r * 1.35, r, r * 0.85, r * 0.35], sides, kind.bark);
    // The same numbers are drawn at both details, so that far and near trees have one shape.
    let clumps: Vec<(Vec3, f32, f32)> = (0..kind.clumps)
        .map(|k| {
            // Spread evenly over the sphere (golden angle), then pushed about.
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / kind.clumps as f32;
            let turn = k as f32 * 2.399_963 + random.uniform(-0.5, 0.5) as f32;
            let ring = (1.0 - z * z).sqrt();
            let shell = random.uniform(0.48, 0.74) as f32;
            let direction = Vec3::new(ring * turn.cos(), ring * turn.sin(), z * random.uniform(0.85, 1.0) as f32);
            let size = kind.clump_size * kind.width_m * random.uniform(0.75, 1.3) as f32;
            (middle + half * direction * shell, size, random.uniform(0.0, 1.0) as f32)
        })
        .collect();
    let branches = if detail == Detail::Near { 4 } else { 0 };
    for (to, ..) in clumps.iter().rev().take(branches) {
        let from = Vec3::Z * (crown_low * 0.8 + (to.z - crown_low).max(0.0) * 0.35) + lean * 0.8;
        tube(
            &mut mesh,
            &[from, from.lerp(*to, 0.5) + Vec3::Z * 0.15, *to],
            &[r * 0.42, r * 0.28, r * 0.1],
            3,
            kind.bark,
        );
    }
    let crown = Crown { middle, half };
    let clump_at = |&(at, size, tint): &(Vec3, f32, f32)| {
        let half = Vec3::new(size, size, size * 0.85);
        Clump { at, half, sprig: size, colour: tinted(kind.leaf, tint) }
    };
    let (clumps, sprigs): (Vec<Clump>, usize) = match detail {
        Detail::Near => (clumps.iter().map(clump_at).collect(), kind.sprigs),
        Detail::Far => {
            let sprig = kind.clump_size * kind.width_m * 1.35;
            (vec![Clump { at: middle, half: half * 0.92, sprig, colour: tinted(kind.leaf, 0.5) }], kind.sprigs / 3)
        }
    };
    for clump in &clumps {
        leaf_clump(&mut mesh, &mut random, clump, &crown);
    }
    for k in 0..sprigs {
        sprig(&mut mesh, &mut random, &clumps[k % clumps.len()], &crown);
    }
    mesh
}

/// A heap of leaves.
struct Clump {
    at: Vec3,
    half: Vec3,
    /// Size of the tufts on it, metres.
    sprig: f32,
    colour: [f32; 3],
}

fn tinted(leaf: [f32; 3], tint: f32) -> [f32; 3] {
    mix(shade(leaf, 0.80), [leaf[0] * 1.30, leaf[1] * 1.12, leaf[2] * 1.05], tint)
}

/// Where a crown is, for the light on its clumps.
struct Crown {
    middle: Vec3,
    half: Vec3,
}

impl Crown {
    /// A leaf's normal and how much light reaches it: the hull and the top more than the inside.
    fn light(&self, position: Vec3, own: Vec3) -> (Vec3, f32) {
        let from_middle = (position - self.middle) / self.half;
        let outside = from_middle.length().min(1.2);
        let away = from_middle.normalize_or(Vec3::Z);
        let normal = (own * 0.5 + away * 0.65 + Vec3::Z * 0.12).normalize_or(own);
        (normal, (0.62 + 0.36 * outside * outside) * (0.90 + 0.14 * away.z))
    }
}

/// A dented icosahedron.
fn leaf_clump(mesh: &mut Mesh, random: &mut Stream, clump: &Clump, crown: &Crown) {
    let turn = Mat3::from_rotation_z(angle(random)) * Mat3::from_rotation_x(angle(random));
    let first = mesh.vertices.len() as u32;
    for corner in icosahedron() {
        let direction = turn * corner;
        let position = clump.at + direction * clump.half * random.uniform(0.62, 1.05) as f32;
        let (normal, light) = crown.light(position, direction);
        let uv = Vec2::new(direction.y.atan2(direction.x) / TAU + 0.5, 0.5 + 0.5 * direction.z);
        mesh.vertex(Vertex::new(position, normal, shade(clump.colour, light * 0.85), uv, Material::Leaves));
    }
    mesh.indices.extend(ICOSAHEDRON_FACES.iter().flatten().map(|i| first + i));
}

/// A tuft of leaves on a clump: a low pyramid with its tip outwards, dark at its foot. Tufts break up the outline and the
/// face of a clump for three triangles each.
fn sprig(mesh: &mut Mesh, random: &mut Stream, clump: &Clump, crown: &Crown) {
    // Mostly on the side that faces out of the crown.
    let z = random.uniform(-1.0, 1.0) as f32;
    let ball = Vec2::from_angle(angle(random)) * (1.0 - z * z).sqrt();
    let outwards = ((clump.at - crown.middle) / crown.half).normalize_or_zero();
    let direction = (ball.extend(z) + outwards * 0.9).normalize_or(Vec3::Z);
    let foot = clump.at + direction * clump.half * 0.70;
    let width = clump.sprig * random.uniform(0.42, 0.62) as f32;
    let sideways: [f32; 3] = std::array::from_fn(|_| random.uniform(-0.55, 0.45) as f32);
    let tip =
        foot + (direction + Vec3::from(sideways) * 0.9).normalize() * clump.sprig * random.uniform(0.42, 0.78) as f32;
    let (x, y) = direction.any_orthonormal_pair();
    let turn = angle(random);
    let leafy = shade(clump.colour, random.uniform(0.82, 1.22) as f32);
    let first = mesh.vertices.len() as u32;
    for k in 0..3 {
        let (sin, cos) = (turn + TAU * k as f32 / 3.0).sin_cos();
        let corner = foot + (x * cos + y * sin) * width;
        let (normal, light) = crown.light(corner, (direction + (x * cos + y * sin) * 0.6).normalize());
        mesh.vertex(Vertex::new(corner, normal, shade(leafy, light * 0.90), Vec2::new(cos, sin), Material::Leaves));
    }
    let (normal, light) = crown.light(tip, direction);
    mesh.vertex(Vertex::new(tip, normal, shade(leafy, light * 1.15), Vec2::ZERO, Material::Leaves));
    for k in 0..3 {
        mesh.indices.extend([first + k, first + (k + 1) % 3, first + 3]);
    }
}

fn angle(random: &mut Stream) -> f32 {
    random.uniform(0.0, std::f64::consts::TAU) as f32
}

/// Corners of the unit icosahedron.
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

/// A bent, tapering stem, open at its ends (which are in the ground and in the leaves).
fn tube(mesh: &mut Mesh, path: &[Vec3], radii: &[f32], sides: u32, colour: [f32; 3]) {
    let first = mesh.vertices.len() as u32;
    for (i, (&at, &radius)) in path.iter().zip(radii).enumerate() {
        let along = (path[(i + 1).min(path.len() - 1)] - path[i.max(1) - 1]).normalize();
        let (x, y) = along.any_orthonormal_pair();
        for k in 0..sides {
            let (sin, cos) = (TAU * k as f32 / sides as f32).sin_cos();
            let out = x * cos + y * sin;
            // Patches of light and dark as bark has.
            let patch = 0.85 + 0.15 * ((i as u32 * 7 + k * 3) % 5) as f32 / 2.0;
            let uv = Vec2::new(k as f32 / sides as f32, at.z);
            mesh.vertex(Vertex::new(at + out * radius, out, shade(colour, patch), uv, Material::Bark));
        }
    }
    for i in 0..path.len() as u32 - 1 {
        for k in 0..sides {
            let [a, b] = [k, (k + 1) % sides].map(|k| first + i * sides + k);
            mesh.indices.extend([a, b, b + sides, a, b + sides, a + sides]);
        }
    }
}

/// Tiers of drooping boughs with a ragged rim.
fn spruce(seed: u64, detail: Detail) -> Mesh {
    const HEIGHT_M: f32 = 12.5;
    const RADIUS_M: f32 = 2.5;
    let mut random = rng::stream(seed, "spruce");
    let mut mesh = Mesh::default();
    let (tiers, points, sides) = if detail == Detail::Near { (9, 9, 6) } else { (4, 6, 3) };
    tube(&mut mesh, &[Vec3::ZERO, Vec3::Z * HEIGHT_M * 0.6], &[0.19, 0.07], sides, [0.075, 0.052, 0.038]);
    for tier in 0..tiers {
        let t = tier as f32 / tiers as f32;
        // Low tiers wide and hanging, high ones narrow and steep.
        let rim_z = HEIGHT_M * (0.07 + 0.80 * t);
        let tip_z = (rim_z + HEIGHT_M * (1.15 - 0.35 * t) / tiers as f32 * 1.35).min(HEIGHT_M);
        let radius = RADIUS_M * (1.0 - t).powf(0.85) * random.uniform(0.9, 1.1) as f32 + 0.22;
        let turn = angle(&mut random);
        let colour = mix([0.032, 0.070, 0.030], [0.050, 0.100, 0.038], random.uniform(0.0, 1.0) as f32);
        let first = mesh.vertices.len() as u32;
        let rim = 2 * points;
        for k in 0..rim {
            let bough = k % 2 == 0;
            let angle = turn + TAU * k as f32 / rim as f32;
            let reach = radius * if bough { random.uniform(0.88, 1.15) } else { random.uniform(0.60, 0.76) } as f32;
            let out = Vec2::from_angle(angle);
            let z = rim_z + if bough { -0.12 * radius } else { 0.16 * radius } + random.uniform(-0.08, 0.08) as f32;
            let light = if bough { 1.25 } else { 0.62 };
            let normal = out.extend(0.75).normalize();
            let uv = Vec2::new(k as f32 / rim as f32, 0.0);
            mesh.vertex(Vertex::new((out * reach).extend(z), normal, shade(colour, light), uv, Material::Leaves));
        }
        let tip = Vertex::new(Vec3::Z * tip_z, Vec3::Z, shade(colour, 0.85), Vec2::new(0.5, 1.0), Material::Leaves);
        let tip = mesh.vertex(tip);
        let inside = Vec3::Z * (rim_z + 0.35 * (tip_z - rim_z));
        let below =
            mesh.vertex(Vertex::new(inside, -Vec3::Z, shade(colour, 0.3), Vec2::new(0.5, 0.5), Material::Leaves));
        for k in 0..rim {
            let [a, b] = [k, (k + 1) % rim].map(|k| first + k);
            mesh.indices.extend([a, b, tip, b, a, below]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::check;
    use super::*;

    #[test]
    fn trees_are_sound_of_modest_size_and_far_ones_are_small() {
        let (near, far) = (models(1, Detail::Near), models(1, Detail::Far));
        assert_eq!((near.len(), far.len()), (KINDS, KINDS));
        for (kind, (near, far)) in near.iter().zip(&far).enumerate() {
            check(near, "tree");
            check(far, "far tree");
            assert!((200..=600).contains(&near.triangles()), "{kind}: {}", near.triangles());
            assert!(far.triangles() <= 170, "{kind}: {}", far.triangles());
            let (low, high) = near.bounds();
            assert!(low.z > -1.0 && low.z <= 0.01, "{kind}: foot {low}");
            let far_high = far.bounds().1.z;
            assert!((far_high / high.z - 1.0).abs() < 0.15, "{kind}: {} or {far_high} m high", high.z);
        }
    }

    #[test]
    fn crowns_are_irregular() {
        // Seen from above, the outline's radius varies by more than a tenth of itself: no lollipops.
        for (kind, mesh) in models(1, Detail::Near).iter().enumerate() {
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
