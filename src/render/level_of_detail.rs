//! Levels of detail of cars and trees, and the ranges of a picture's instances. In: the size of an object in the
//! picture. Out: its level of detail; [`InstanceBatches`], ranges of instances by mesh and level.

use super::view_projection::ViewFrustum;
use glam::Vec3;
use std::ops::Range;

/// Ranges in the instance buffer. The first instance is the world itself, for road and land.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InstanceBatches {
    /// The ego seen from inside, if it is: bonnet and shelf, cabin, steering wheel, wipers at rest, wipers that move.
    pub inside: [Range<u32>; 5],
    /// Housings of the ego's mirrors by mesh.
    pub housings: [Range<u32>; 4],
    /// All car bodies, for the patches of contact shade under them.
    pub cars: Range<u32>,
    /// Car bodies by style and [`CarDetail`].
    pub bodies: Vec<[Range<u32>; CAR_LEVELS]>,
    /// Wheels by level of detail.
    pub wheels: [Range<u32>; 3],
    /// Lamps that are lit.
    pub lamps: Range<u32>,
    /// Lamps that a wet road mirrors.
    pub streaks: Range<u32>,
    /// Puffs of fine drops behind vehicles.
    pub spray: Range<u32>,
    /// Tufts of grass in range.
    pub tufts: Range<u32>,
    /// Patches of shade at the feet of trees.
    pub roots: Range<u32>,
    /// Trees by kind and [`TreeDetail`].
    pub trees: Vec<[Range<u32>; LEVELS]>,
}

impl InstanceBatches {
    /// Returns the `k`th of `n` parts of the trees, `k` from 0.
    pub fn part_of_trees(&self, k: usize, n: usize) -> Vec<[Range<u32>; LEVELS]> {
        let part = |range: Range<u32>| {
            let at = |k: usize| range.start + (range.len() * k / n) as u32;
            at(k)..at(k + 1)
        };
        self.trees.iter().map(|levels| levels.clone().map(part)).collect()
    }
}

/// Level of detail of a car.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CarDetail {
    /// Full detail, with all fittings.
    Near,
    /// Transparent glass, without small fittings.
    Mid,
    /// Outer shape with lamps.
    Far,
    /// Coarse shape with its colours, without wheels.
    Plan,
    /// Coarse shape for shadows.
    Shade,
}

/// Number of levels of a car.
pub(super) const CAR_LEVELS: usize = 5;

/// Level of detail of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeDetail {
    /// Every twig, as leaf cards.
    Near,
    /// A quarter of the triangles.
    Mid,
    /// A picture on two triangles.
    Far,
    /// Solid shape for shadows.
    Shade,
}

/// Number of levels of a tree.
pub(super) const LEVELS: usize = 4;
/// Radius in the picture from which a tree is drawn with every twig, pixels.
const NEAR_PX: f32 = 85.0;
/// Radius from which a car is drawn with all fittings, pixels: from there on the outline without them deviates by more
/// than a pixel (`scene/car/mod.rs`).
const FITTED_PX: f32 = 100.0;
/// Radius from which a tree is drawn with its boughs, and a car with transparent glass, pixels.
const MID_PX: f32 = 36.0;
/// Radius from which a car seen from above is more than its outline, pixels.
const PLAN_PX: f32 = 7.5;
/// Radius from which a car seen from the road is more than a coarse shape, pixels: it is three or four lines high then.
const AFAR_PX: f32 = 6.0;
/// Width of the transition between two levels of a tree, as a share of the radius at which they change.
const BAND: f32 = 0.22;
/// Width of the transition with one sample per pixel: both levels are drawn one over the other, so fewer trees should
/// be in it.
const LAYERED_BAND: f32 = 0.1;

/// Distance from a car's middle within which the eye is at the car itself, m.
const BESIDE_M: f32 = 1.9;

impl CarDetail {
    /// Returns the detail for a car with this bounding sphere, or `None` if it is outside the picture. The ego in a
    /// mirror on its door never has all fittings, which would double the mirror's cost.
    pub fn seen(frustum: &ViewFrustum, centre: Vec3, radius_m: f32) -> Option<Self> {
        let most = if frustum.camera.eye.distance(centre) < BESIDE_M { FITTED_PX } else { f32::MAX };
        let detail = || Self::of(frustum.pixels(centre, radius_m).min(most), frustum.from_above());
        frustum.sees(centre, radius_m).then(detail)
    }

    /// Returns the detail for a car of this radius in the picture, which may be taken from above.
    pub fn of(radius_px: f32, from_above: bool) -> Self {
        match radius_px {
            px if px > FITTED_PX => Self::Near,
            px if px > MID_PX => Self::Mid,
            px if px > if from_above { PLAN_PX } else { AFAR_PX } => Self::Far,
            _ => Self::Plan,
        }
    }
}

impl TreeDetail {
    /// Returns one level, or two around a transition: the finer one with its share of a pixel's samples, the coarser
    /// one with the negative of that share (`kept` in `fade.wgsl`).
    pub fn shares(radius_px: f32, samples: u32) -> DetailShares {
        let band = if samples == 1 { LAYERED_BAND } else { BAND };
        let share = |at: f32| ((radius_px / at - 1.0) / band + 0.5).clamp(0.0, 1.0);
        for (at, finer, coarser) in [(NEAR_PX, Self::Near, Self::Mid), (MID_PX, Self::Mid, Self::Far)] {
            match share(at) {
                1.0 => return [Some((finer, 1.0)), None],
                0.0 => {}
                share => return [Some((finer, share)), Some((coarser, -share))],
            }
        }
        [Some((Self::Far, 1.0)), None]
    }
}

/// Levels at which a tree is drawn, each with its share of a pixel's samples.
pub type DetailShares = [Option<(TreeDetail, f32)>; 2];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_the_trees_are_all_trees_once() {
        let batches = InstanceBatches {
            trees: vec![[3..3, 3..40, 40..45, 45..46], [46..46, 46..146, 146..146, 146..150]],
            ..Default::default()
        };
        let parts: Vec<_> = (0..12).map(|k| batches.part_of_trees(k, 12)).collect();
        for (kind, levels) in batches.trees.iter().enumerate() {
            for (level, range) in levels.iter().enumerate() {
                let together: Vec<u32> = parts.iter().flat_map(|part| part[kind][level].clone()).collect();
                assert_eq!(together, range.clone().collect::<Vec<_>>());
            }
        }
        assert!(parts.iter().all(|part| part[1][1].len() <= 9));
    }

    #[test]
    fn a_car_is_a_coarse_shape_only_at_a_few_pixels() {
        // From above: 40 cars on ring-641 in a picture of 640x360; 22 on ring-250 in that and at 1280x720.
        for (radius_px, above) in [(3.0, CarDetail::Plan), (7.1, CarDetail::Plan), (14.3, CarDetail::Far)] {
            assert_eq!(CarDetail::of(radius_px, true), above);
        }
        // From the road: a wheel of 0.65 m has a pixel and a half where a car's radius of 2.5 m has 6.
        for (radius_px, on_road) in [(3.0, CarDetail::Plan), (5.9, CarDetail::Plan), (6.1, CarDetail::Far)] {
            assert_eq!(CarDetail::of(radius_px, false), on_road);
        }
        for from_above in [true, false] {
            assert_eq!(CarDetail::of(40.0, from_above), CarDetail::Mid);
            assert_eq!(CarDetail::of(95.0, from_above), CarDetail::Mid);
            assert_eq!(CarDetail::of(105.0, from_above), CarDetail::Near);
        }
    }
}
