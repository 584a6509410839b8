//! Leaf cards: flat pieces that the tree shader cuts into leaves or needles. In: where a card lies and how large
//! it is. Out: two triangles a card, lit as a part of its crown. Metres.
//!
//! The texture coordinates carry more than a place on the card: the whole part of half of `v` is the card's [`CardCut`],
//! that of half of `u` a number by which two cards of one cut differ; what is left over is the place, 0 to 1.

use crate::scene::{Material, Mesh, Vertex, land::noise::shade};
use glam::{Vec2, Vec3};

/// How much a model shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum ModelDetail {
    /// Every twig: at most 1500 triangles.
    Near,
    /// Boughs: at most 400.
    Mid,
    /// What throws the shadow: solid, because the shadow's pass cuts nothing out.
    Shade,
}

/// What the shader cuts out of a card (`render/leaves.rs` has the same numbers).
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum CardCut {
    /// A spray of some twenty leaves.
    Spray = 0,
    /// The same with leaves half as large, on cards twice as large.
    Mass = 1,
    /// A spray of small leaves.
    Fine = 2,
    /// A conifer's bough: the stem runs along `v`, twigs and needles to either side.
    Bough = 3,
}

/// How many cards of one cut differ.
pub(in crate::scene) const VARIANTS: usize = 8;

/// A flat piece: middle, half sides.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct LeafCard {
    /// Middle.
    pub at: Vec3,
    /// From the middle to the edge where `u` is 1.
    pub across: Vec3,
    /// From the middle to the edge where `v` is 1.
    pub along: Vec3,
    /// Linear albedo in full light.
    pub colour: [f32; 3],
    /// Which of the [`VARIANTS`].
    pub variant: usize,
    /// What is cut out.
    pub cut: CardCut,
}

/// Where a crown is, for the light on its leaves.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct TreeCrown {
    /// Middle.
    pub middle: Vec3,
    /// Half axes.
    pub half: Vec3,
}

impl TreeCrown {
    /// How far out a point is: 0 the middle, 1 the hull.
    pub fn outside(&self, position: Vec3) -> f32 {
        ((position - self.middle) / self.half).length()
    }

    /// A leaf's normal and how much light reaches it: the hull and the top more than the inside. Normals follow the
    /// crown, not the card, so that light falls on the tree as on one soft body.
    fn light(&self, position: Vec3, own: Vec3) -> (Vec3, f32) {
        let from_middle = (position - self.middle) / self.half;
        let outside = from_middle.length().min(1.1);
        let away = from_middle.normalize_or(Vec3::Z);
        let normal = (own * 0.55 + away + Vec3::Z * 0.25).normalize_or(Vec3::Z);
        (normal, (0.44 + 0.62 * outside * outside) * (0.92 + 0.26 * away.z))
    }
}

impl LeafCard {
    /// Texture coordinates of the place (0..1, 0..1).
    pub fn uv(&self, place: Vec2) -> Vec2 {
        place + 2.0 * Vec2::new(self.variant as f32, self.cut as u8 as f32)
    }

    /// The card `times` as large, drawn into its crown by a share of what it has grown, so that the outline stays.
    pub fn grown(&self, times: f32, inwards: f32, crown: &TreeCrown) -> Self {
        let grown = (self.across.length() + self.along.length()) / 2.0 * (times - 1.0);
        let out = (self.at - crown.middle).normalize_or_zero();
        let at = self.at - out * grown * inwards;
        Self { at, across: self.across * times, along: self.along * times, ..*self }
    }

    /// Adds the card to a mesh.
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

/// One card for every so many that are next to each other, in their middle and of their mean colour, and for how many of
/// them it stands (k-means from every so many-th card on; Lloyd 1982).
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

/// A bent, tapering stem of `sides` faces, open at its ends (which are in the ground and in the leaves).
pub(in crate::scene) fn stem(mesh: &mut Mesh, path: &[Vec3], radii: &[f32], sides: u32, colour: [f32; 3]) {
    let first = mesh.vertices.len() as u32;
    for (i, (&at, &radius)) in path.iter().zip(radii).enumerate() {
        let along = (path[(i + 1).min(path.len() - 1)] - path[i.max(1) - 1]).normalize_or(Vec3::Z);
        let (x, y) = along.any_orthonormal_pair();
        for k in 0..sides {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / sides as f32).sin_cos();
            let out = x * cos + y * sin;
            // Patches of light and dark as bark has.
            let patch = 0.85 + 0.15 * ((i as u32 * 7 + k * 3) % 5) as f32 / 2.0;
            // There and back, so that the bark has no seam.
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
