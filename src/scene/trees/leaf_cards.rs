//! Leaf cards: flat pieces that the tree shader cuts into leaves or needles. In: position and size of a card. Out: two triangles
//! per card, lit as a part of its crown. Metres.
//!
//! Texture coordinates hold two numbers and the position on the card. The integer part of `v / 2` is the card's [`CardCut`], the
//! integer part of `u / 2` its variant. The remainders of `u` and `v` are the position on the card, 0 to 1.

use crate::scene::{Material, Mesh, Vertex, colours::shade};
use glam::{Vec2, Vec3};

/// Level of detail of a tree model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum ModelDetail {
    /// All twigs; at most 1500 triangles.
    Near,
    /// Boughs only; at most 400 triangles.
    Mid,
    /// Solid shape for shadows, because the shadow pass cuts nothing out.
    Shade,
}

/// Shape that the shader cuts out of a card (`render/leaves.rs` has the same numbers).
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum CardCut {
    /// Spray of about twenty leaves.
    Spray = 0,
    /// Spray with leaves half as large, for cards twice as large.
    Mass = 1,
    /// Spray of small leaves.
    Fine = 2,
    /// Bough of a conifer: the stem runs along `v`, twigs and needles to either side.
    Bough = 3,
}

/// Flat piece of foliage.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct LeafCard {
    /// Middle of the card, metres.
    pub at: Vec3,
    /// Vector from the middle to the edge where `u` is 1.
    pub across: Vec3,
    /// Vector from the middle to the edge where `v` is 1.
    pub along: Vec3,
    /// Linear albedo in full light.
    pub colour: [f32; 3],
    /// Index of the variant, below [`VARIANTS`](crate::roadside::trees::broad_leaf::VARIANTS).
    pub variant: usize,
    /// Shape cut out by the shader.
    pub cut: CardCut,
}

/// Ellipsoid around a crown, for the light on its leaves.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct TreeCrown {
    /// Middle of the ellipsoid, metres.
    pub middle: Vec3,
    /// Half axes along x, y and z, metres.
    pub half: Vec3,
}

impl TreeCrown {
    /// Returns the relative distance of a point from the middle: 0 in the middle, 1 on the hull.
    pub fn outside(&self, position: Vec3) -> f32 {
        ((position - self.middle) / self.half).length()
    }

    /// Returns a leaf's normal and its share of light, which is larger at the hull and the top than inside. Normals follow the
    /// crown, not the card, so that the tree is lit as one soft body.
    fn light(&self, position: Vec3, own: Vec3) -> (Vec3, f32) {
        let from_middle = (position - self.middle) / self.half;
        let outside = from_middle.length().min(1.1);
        let away = from_middle.normalize_or(Vec3::Z);
        let normal = (own * 0.55 + away + Vec3::Z * 0.25).normalize_or(Vec3::Z);
        (normal, (0.44 + 0.62 * outside * outside) * (0.92 + 0.26 * away.z))
    }
}

impl LeafCard {
    /// Returns the texture coordinates of a position on the card (0..1, 0..1).
    pub fn uv(&self, place: Vec2) -> Vec2 {
        place + 2.0 * Vec2::new(self.variant as f32, self.cut as u8 as f32)
    }

    /// Returns the card scaled by `times` and moved into its crown by the share `inwards` of its growth, so that the outline
    /// stays.
    pub fn grown(&self, times: f32, inwards: f32, crown: &TreeCrown) -> Self {
        let grown = (self.across.length() + self.along.length()) / 2.0 * (times - 1.0);
        let out = (self.at - crown.middle).normalize_or_zero();
        let at = self.at - out * grown * inwards;
        Self { at, across: self.across * times, along: self.along * times, ..*self }
    }

    /// Adds the card to a mesh, lit as a part of `crown`.
    pub fn draw(&self, mesh: &mut Mesh, crown: &TreeCrown) {
        let first = mesh.vertices.len() as u32;
        for place in [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y] {
            let from_middle = self.across * (2.0 * place.x - 1.0) + self.along * (2.0 * place.y - 1.0);
            let position = self.at + from_middle;
            let (normal, light) = crown.light(position, from_middle.normalize_or_zero());
            mesh.vertex(Vertex::new(position, normal, shade(self.colour, light), self.uv(place), Material::Leaves));
        }
        mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
}

/// Merges neighbouring cards, about `every` into one at their mean position and colour, and returns each with the number of cards
/// it replaces. K-means, started from every `every`-th card (Lloyd 1982).
pub(in crate::scene) fn gathered(cards: &[LeafCard], every: usize) -> Vec<(LeafCard, usize)> {
    const ROUNDS: usize = 4;
    let mut seeds: Vec<LeafCard> = cards.iter().step_by(every).copied().collect();
    let mut groups = Vec::new();
    for _ in 0..ROUNDS {
        groups = vec![(Vec3::ZERO, Vec3::ZERO, 0); seeds.len()];
        for card in cards {
            let distance = |seed: &LeafCard| seed.at.distance_squared(card.at);
            let nearest = (0..seeds.len()).min_by(|&a, &b| distance(&seeds[a]).total_cmp(&distance(&seeds[b])));
            let (at, colour, count) = &mut groups[nearest.expect("a seed for every so many cards")];
            *at += card.at;
            *colour += Vec3::from(card.colour);
            *count += 1;
        }
        for (seed, (at, colour, count)) in seeds.iter_mut().zip(&groups).filter(|(_, group)| group.2 > 0) {
            (seed.at, seed.colour) = (*at / *count as f32, (*colour / *count as f32).to_array());
        }
    }
    let counts = groups.into_iter().map(|group| group.2);
    seeds.into_iter().zip(counts).filter(|(_, count)| *count > 0).collect()
}

/// Adds a bent, tapering stem of `sides` faces, open at its ends, which are hidden in the ground and in the leaves.
pub(in crate::scene) fn stem(mesh: &mut Mesh, path: &[Vec3], radii: &[f32], sides: u32, colour: [f32; 3]) {
    let first = mesh.vertices.len() as u32;
    for (i, (&at, &radius)) in path.iter().zip(radii).enumerate() {
        let along = (path[(i + 1).min(path.len() - 1)] - path[i.max(1) - 1]).normalize_or(Vec3::Z);
        let (x, y) = along.any_orthonormal_pair();
        for k in 0..sides {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / sides as f32).sin_cos();
            let out = x * cos + y * sin;
            // Light and dark patches of bark.
            let patch = 0.85 + 0.15 * ((i as u32 * 7 + k * 3) % 5) as f32 / 2.0;
            // The texture runs round and back, so that the bark has no seam.
            let uv = Vec2::new((2.0 * k as f32 / sides as f32 - 1.0).abs(), at.z * 0.45);
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
