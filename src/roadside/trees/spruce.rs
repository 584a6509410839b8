//! Form of spruces: whorls of drooping boughs along a straight stem, long below, short above. In: a seed and the number of boughs. Out:
//! [`Whorl`]s, foot at the origin, metres.

use super::broad_leaf::VARIANTS;
use crate::rng;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

pub const HEIGHT_M: f32 = 12.5;
const RADIUS_M: f32 = 2.6;
/// Height of the lowest whorl, metres.
const FOOT_M: f32 = 0.7;
/// Points along the stem, and its radii there, metres.
pub const STEM: ([Vec3; 3], [f32; 3]) = (
    [Vec3::new(0.0, 0.0, -0.1), Vec3::new(0.0, 0.0, HEIGHT_M * 0.5), Vec3::new(0.0, 0.0, HEIGHT_M - 0.3)],
    [0.20, 0.10, 0.012],
);
/// Whorls and boughs of a spruce seen from near.
pub const NEAR: BoughCounts = BoughCounts { whorls: 20, boughs: 9, wide: 0.36 };
/// Places along a bough at which its edges are drawn, as fractions of its length.
pub const EDGES: [f32; 3] = [0.02, 0.5, 1.0];

/// Number of whorls, boughs in each, and the width of a bough as a fraction of its length.
#[derive(Clone, Copy, Debug)]
pub struct BoughCounts {
    pub whorls: usize,
    pub boughs: usize,
    pub wide: f32,
}

/// Boughs at one height of the stem.
#[derive(Debug)]
pub struct Whorl {
    pub z_m: f32,
    pub radius_m: f32,
    /// Direction of the first bough, radians.
    pub turn_rad: f32,
    pub boughs: Vec<Bough>,
}

/// Bough from the stem outwards.
#[derive(Clone, Copy, Debug)]
pub struct Bough {
    pub foot: Vec3,
    azimuth: f32,
    /// Angle above the horizon, radians.
    pitch: f32,
    pub length: f32,
    wide: f32,
    /// Shade of green, 0 dark to 1 light.
    pub tint: f32,
    /// Index of the picture, below [`VARIANTS`].
    pub variant: usize,
}

impl Bough {
    /// Returns the unit vector away from the stem.
    pub fn out(&self) -> Vec2 {
        Vec2::from_angle(self.azimuth)
    }

    /// Returns the vector to the left edge where the bough is widest.
    pub fn aside(&self) -> Vec3 {
        self.out().perp().extend(0.0) * self.length * self.wide
    }

    /// Returns a point of the edge at a fraction of the length; `aside` is the vector to the edge where the bough is widest.
    pub fn edge(&self, share: f32, aside: Vec3) -> Vec3 {
        // Slope of the bough; its end curves upwards.
        let up = self.length * (share * self.pitch.tan() + 0.16 * share * share);
        let width = (0.55 + 0.45 * share).min(1.0);
        self.foot + (self.out() * self.length * share).extend(up) + aside * width
    }
}

/// Returns the whorls of a spruce from the top down.
pub fn whorls(seed: u64, BoughCounts { whorls, boughs, wide }: BoughCounts) -> Vec<Whorl> {
    let mut random = rng::stream(seed, "spruce");
    let whorl = |whorl: usize| {
        let t = (whorl as f32 + random.uniform_f32(-0.25, 0.25)).max(0.0) / whorls as f32;
        let z_m = FOOT_M + (HEIGHT_M - FOOT_M) * t.powf(0.93);
        let radius_m = RADIUS_M * (1.0 - t).powf(0.82) * random.uniform_f32(0.9, 1.06) + 0.18;
        let turn_rad = random.uniform_f32(0.0, TAU);
        let bough = |k: usize| {
            let azimuth = turn_rad + TAU * (k as f32 + random.uniform_f32(-0.28, 0.28)) / boughs as f32;
            let length = radius_m * random.uniform_f32(0.66, 1.06) * (1.0 + 0.15 * (azimuth + 2.0).sin());
            let foot = Vec3::Z * (z_m + random.uniform_f32(-0.22, 0.22));
            // Low boughs hang, high boughs point up.
            let pitch = -0.42 + 0.95 * t * t + random.uniform_f32(-0.10, 0.10);
            let tint = random.uniform_f32(0.0, 1.0);
            let variant = (random.uniform_f32(0.0, VARIANTS as f32) as usize).min(VARIANTS - 1);
            Bough { foot, azimuth, pitch, length, wide, tint, variant }
        };
        Whorl { z_m, radius_m, turn_rad, boughs: (0..boughs).map(bough).collect() }
    };
    (0..whorls).rev().map(whorl).collect()
}

/// Returns the largest distance of a twig from the stem, metres.
pub fn crown_radius_m(seed: u64) -> f32 {
    let whorls = whorls(seed, NEAR);
    let boughs = whorls.iter().flat_map(|whorl| &whorl.boughs);
    let edges = boughs.flat_map(|bough| {
        let aside = bough.aside();
        EDGES.into_iter().flat_map(move |share| [aside, -aside].map(|aside| bough.edge(share, aside)))
    });
    edges.map(|edge| edge.truncate().length()).fold(0.0, f32::max)
}
