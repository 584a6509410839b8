//! Trees: their forms and places. In: paved surfaces, buildings, kinds of land, a seed. Out: [`Woods`], metres.
//!
//! `broad_leaf` and `spruce` are the forms, from which the picture is drawn; `forest` places the trees.

pub mod broad_leaf;
pub mod forest;
pub mod spruce;

use self::broad_leaf::{BIRCH, BroadLeafMeasures, HAZEL, MAPLE, OAK, TreeSkeleton};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

/// Number of kinds of trees: oak, maple, birch, spruce, hazel.
pub const KINDS: usize = 5;
/// Index of the bush, which grows at the edges of woods.
pub const BUSH: usize = 4;
/// Index of the spruce, which grows in groups.
pub const SPRUCE: usize = 3;

/// Tree of full size, by what keeps it off roads and stops a car.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeForm {
    /// Largest distance of a leaf from the trunk, metres.
    pub crown_m: f32,
    /// Lowest part of the trunk; `None` for a bush, whose stems give way.
    pub trunk: Option<Trunk>,
}

/// Lowest part of a trunk, round and straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trunk {
    /// Middle of the lower and the upper end, relative to the tree's place.
    ends: [Vec3; 2],
    radii_m: [f32; 2],
}

impl Trunk {
    /// Returns the middle and the radius of the trunk at a height over the tree's place, metres.
    pub fn at(&self, height_m: f32) -> (Vec2, f32) {
        let [low, high] = self.ends;
        let share = (height_m - low.z) / (high.z - low.z);
        (low.lerp(high, share).truncate(), self.radii_m[0] + (self.radii_m[1] - self.radii_m[0]) * share)
    }
}

/// Place of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tree {
    pub at: Vec2,
    pub yaw_rad: f32,
    /// Size relative to full size.
    pub scale: f32,
    /// Factor of its colour.
    pub tint: [f32; 3],
    /// Index of its kind, below [`KINDS`].
    pub kind: usize,
}

/// Trees around the roads of a network.
#[derive(Debug, Default)]
pub struct Woods {
    pub trees: Vec<Tree>,
    /// Form of each kind of tree.
    pub forms: Vec<TreeForm>,
}

/// Returns the form of each kind of tree.
pub fn forms(seed: u64) -> Vec<TreeForm> {
    let broad_leaf = |kind: &'static BroadLeafMeasures| {
        let tree = TreeSkeleton::new(kind, seed);
        let stem = &tree.limbs[0];
        let trunk = Trunk { ends: [stem.path[0], stem.path[1]], radii_m: [stem.radii[0], stem.radii[1]] };
        TreeForm { crown_m: tree.crown_radius_m(), trunk: (kind.stems == 1).then_some(trunk) }
    };
    let form = |kind: usize| match kind {
        0 => broad_leaf(&OAK),
        1 => broad_leaf(&MAPLE),
        2 => broad_leaf(&BIRCH),
        SPRUCE => {
            let ([low, high, _], [foot_m, middle_m, _]) = spruce::STEM;
            let trunk = Trunk { ends: [low, high], radii_m: [foot_m, middle_m] };
            TreeForm { crown_m: spruce::crown_radius_m(seed), trunk: Some(trunk) }
        }
        _ => broad_leaf(&HAZEL),
    };
    (0..KINDS).into_par_iter().map(form).collect()
}
