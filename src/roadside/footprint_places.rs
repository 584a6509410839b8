//! Places of buildings by the footprints of a map. In: footprints, the roads. Out: plots for those that are rectangles, blocks for all others.
//! Metres.

use super::{
    plots::{MOST_BUILDINGS, Plot, PlotKind},
    road_surfaces::RoadSurfaces,
};
use crate::{
    map::surroundings::{self, BuildingUse, Footprint},
    rng,
};
use glam::Vec2;

/// Height of a storey in single precision, metres.
pub const STOREY_M: f32 = surroundings::STOREY_M as f32;
/// Greatest distance of a building from a road, metres: others would hardly be seen.
const NEAR_M: f32 = 250.0;
/// Least distance of a corner from a road, metres: an outline over a road is a fault of the data, or a passage.
const FREE_M: f32 = 0.3;
/// Largest sine of the angle by which two walls count as one, and smallest of one that counts as right.
const STRAIGHT_SIN: f32 = 0.1;
const RIGHT_SIN: f32 = 0.98;
/// Sides of a rectangle that is built as a house, metres.
const HOUSE_M: std::ops::RangeInclusive<f32> = 5.0..=26.0;
/// Depth of the path to a door, metres.
const PATH_M: std::ops::RangeInclusive<f32> = 1.0..=6.0;

/// Building of any outline, with a flat roof.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Corners, counter-clockwise.
    pub outline: Vec<Vec2>,
    pub height_m: f32,
    pub kind: BuildingUse,
    /// Number for the choice of details.
    pub seed: u64,
}

/// Returns the buildings of these footprints, those nearest to the roads if there are too many.
pub fn built(footprints: &[Footprint], roads: &RoadSurfaces, seed: u64) -> (Vec<Plot>, Vec<Block>) {
    let near = footprints.iter().enumerate().filter_map(|(k, footprint)| {
        let outline: Vec<Vec2> = footprint.outline.iter().map(|at| at.as_vec2()).collect();
        let middle = outline.iter().sum::<Vec2>() / outline.len() as f32;
        let off_m = roads.border_m(middle);
        let is_free = off_m > 0.0 && off_m < NEAR_M && outline.iter().all(|corner| roads.border_m(*corner) > FREE_M);
        is_free.then_some((off_m, k, outline))
    });
    let mut near: Vec<(f32, usize, Vec<Vec2>)> = near.collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(MOST_BUILDINGS);
    near.sort_by_key(|(_, k, _)| *k);
    let (mut plots, mut blocks) = (Vec::new(), Vec::new());
    for (_, k, outline) in near {
        let footprint = &footprints[k];
        let seed = rng::stream(seed, &format!("building {k}")).index(1 << 30) as u64;
        let outline = straightened(&outline);
        match plot(footprint, &outline, roads, seed) {
            Some(plot) => plots.push(plot),
            None => blocks.push(Block { height_m: height_m(footprint), outline, kind: footprint.kind, seed }),
        }
    }
    (plots, blocks)
}

/// Returns the height of a building, metres; where none is known, that of its use.
fn height_m(footprint: &Footprint) -> f32 {
    let usual_m = match footprint.kind {
        BuildingUse::Outbuilding => 2.7,
        BuildingUse::House | BuildingUse::Shops => 2.0 * STOREY_M,
        BuildingUse::Flats => 3.0 * STOREY_M,
    };
    footprint.height_m.map_or(usual_m, |height_m| height_m as f32)
}

/// Returns an outline without the corners between walls in one line.
fn straightened(outline: &[Vec2]) -> Vec<Vec2> {
    let n = outline.len();
    let is_corner = |k: &usize| {
        let [before, here, after] = [k + n - 1, *k, k + 1].map(|k| outline[k % n]);
        (here - before).normalize_or_zero().perp_dot((after - here).normalize_or_zero()).abs() > STRAIGHT_SIN
    };
    let kept: Vec<Vec2> = (0..n).filter(is_corner).map(|k| outline[k]).collect();
    if kept.len() < 3 { outline.to_vec() } else { kept }
}

/// Returns the plot of a building whose outline is a rectangle of a house's size, with its front towards the nearest road.
fn plot(footprint: &Footprint, outline: &[Vec2], roads: &RoadSurfaces, seed: u64) -> Option<Plot> {
    let kind = match footprint.kind {
        BuildingUse::House => PlotKind::House,
        BuildingUse::Flats => PlotKind::Flats,
        BuildingUse::Shops => PlotKind::Shops,
        BuildingUse::Outbuilding => return None,
    };
    let [a, b, c, d] = outline.try_into().ok()?;
    let corners: [Vec2; 4] = [a, b, c, d];
    let side = |k: usize| corners[(k + 1) % 4] - corners[k % 4];
    let is_right = |k: usize| side(k).normalize_or_zero().perp_dot(side(k + 1).normalize_or_zero()) > RIGHT_SIN;
    let is_house = (0..4).all(|k| is_right(k) && HOUSE_M.contains(&side(k).length()));
    let storeys = (height_m(footprint) / STOREY_M).round() as u32;
    if !is_house || !(1..=7).contains(&storeys) {
        return None;
    }
    let middle = |k: usize| (corners[k] + corners[(k + 1) % 4]) / 2.0;
    let off_m = |k: usize| roads.border_m(middle(k));
    let front = (0..4).min_by(|a, b| off_m(*a).total_cmp(&off_m(*b)))?;
    Some(Plot {
        kind,
        front: middle(front),
        // Counter-clockwise, the inside is on the left.
        inwards: side(front).normalize().perp(),
        width_m: side(front).length(),
        depth_m: side(front + 1).length(),
        garden_m: (off_m(front) - FREE_M).clamp(*PATH_M.start(), *PATH_M.end()),
        adjoins: [false; 2],
        has_fence: false,
        drive: None,
        storeys: Some(storeys),
        seed,
    })
}
