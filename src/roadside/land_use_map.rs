//! Lookup of what a map states of the ground at a point. In: the surroundings of a network. Out: a kind of land, and where the program's own
//! rules decide. Metres.

use super::{outlines::contains, road_surfaces::RoadSurfaces};
use crate::map::surroundings::{LandUse, Surroundings};
use glam::{IVec2, Vec2, Vec3};
use std::collections::{BTreeMap, BTreeSet};

/// Side of the squares in which areas are looked up, metres.
const SQUARE_M: f32 = 32.0;
/// Maximum number of areas in all squares together: 16 MB.
const MOST_ENTRIES: u64 = 4_000_000;
/// Distance from the roads' circle beyond which areas are left out, metres.
const BEYOND_M: f32 = 300.0;
/// Distance from a border up to which it is measured, metres: more than the smallest cells of the ground, so that borders between their
/// corners stay straight.
pub const BORDER_M: f32 = 8.0;
/// Distance on either side of an outline at which the kinds of land are compared, metres.
const ASIDE_M: f32 = 0.2;

/// Kinds of land around the roads of a network.
#[derive(Debug, Default)]
pub struct LandUseMap {
    /// Areas with their outlines, the smallest first.
    areas: Vec<(LandUse, Vec<Vec3>)>,
    /// Areas that reach into each square, the smallest first.
    squares: BTreeMap<[i32; 2], Vec<u32>>,
    /// Kinds of all areas.
    kinds: BTreeSet<LandUse>,
    /// Corners of the box around all that the map states; `None` if it states nothing.
    stated: Option<(Vec2, Vec2)>,
}

impl LandUseMap {
    /// Sorts the areas near the roads into squares.
    pub fn of(surroundings: &Surroundings, roads: &RoadSurfaces) -> Self {
        let mut areas: Vec<_> = surroundings.areas.iter().collect();
        areas.sort_by(|a, b| a.area_m2().total_cmp(&b.area_m2()));
        let places = areas.iter().map(|area| {
            let outline = area.outline.iter().map(|corner| corner.as_vec2().extend(0.0));
            (area.land_use, outline.collect::<Vec<Vec3>>())
        });
        let areas: Vec<(LandUse, Vec<Vec3>)> = places.collect();
        let reach = Vec2::splat(roads.radius_m() + BEYOND_M);
        let (least, most) = (roads.centre() - reach, roads.centre() + reach);
        let mut squares: BTreeMap<[i32; 2], Vec<u32>> = BTreeMap::new();
        let mut left = MOST_ENTRIES;
        for (number, (_, outline)) in (0u32..).zip(&areas) {
            let (low, high) = around(outline.iter().map(|corner| corner.truncate()));
            let (low, high) = (low.max(least), high.min(most));
            let (from, to) = ((low / SQUARE_M).floor().as_ivec2(), (high / SQUARE_M).floor().as_ivec2());
            // In a file with far too many areas, the largest ones are left out.
            let sides = (to - from + 1).max(IVec2::ZERO).as_u64vec2();
            left = left.saturating_sub(sides.x * sides.y);
            if left == 0 {
                break;
            }
            for (x, y) in (from.y..=to.y).flat_map(|y| (from.x..=to.x).map(move |x| (x, y))) {
                squares.entry([x, y]).or_default().push(number);
            }
        }
        let stated =
            surroundings.points().next().is_some().then(|| around(surroundings.points().map(|point| point.as_vec2())));
        let kinds = areas.iter().map(|(land_use, _)| *land_use).collect();
        Self { areas, squares, kinds, stated }
    }

    /// Returns the kind of land at a point, of several areas that of the smallest; `None` if the map states none there.
    pub fn at(&self, point: Vec2) -> Option<LandUse> {
        let square = (point / SQUARE_M).floor().as_ivec2().to_array();
        let of_square = self.squares.get(&square)?.iter().map(|number| &self.areas[*number as usize]);
        of_square.into_iter().find(|(_, outline)| contains(outline, point)).map(|(land_use, _)| *land_use)
    }

    /// Returns the distance of a point from the border of the land of some kinds, metres, at most [`BORDER_M`]: above 0 inside, below 0
    /// outside.
    pub fn depth_m(&self, point: Vec2, kinds: &[LandUse]) -> f32 {
        if !kinds.iter().any(|kind| self.kinds.contains(kind)) {
            return -BORDER_M;
        }
        let square = |at: Vec2| (at / SQUARE_M).floor().as_ivec2();
        let (from, to) = (square(point - BORDER_M), square(point + BORDER_M));
        let squares = (from.y..=to.y).flat_map(|y| (from.x..=to.x).map(move |x| [x, y]));
        let near: BTreeSet<u32> = squares.filter_map(|at| self.squares.get(&at)).flatten().copied().collect();
        let is_of_kinds = |at: Vec2| self.at(at).is_some_and(|here| kinds.contains(&here));
        let border_m = |number: &u32| {
            let (at, across) = nearest_of(&self.areas[*number as usize].1, point);
            // An outline between two areas of these kinds, or in another area, is no border of theirs.
            let is_border = is_of_kinds(at + across * ASIDE_M) != is_of_kinds(at - across * ASIDE_M);
            is_border.then(|| at.distance(point))
        };
        let border_m = near.iter().filter_map(border_m).fold(BORDER_M, f32::min);
        if is_of_kinds(point) { border_m } else { -border_m }
    }

    /// Checks whether the map states anything of its surroundings.
    pub fn is_stated(&self) -> bool {
        self.stated.is_some()
    }

    /// Checks whether a point lies in the box around all that the map states.
    pub fn covers(&self, point: Vec2) -> bool {
        self.stated.is_some_and(|(low, high)| point.cmpge(low).all() && point.cmple(high).all())
    }
}

/// Returns the point of an outline that is nearest to a point, and the unit vector across the outline there.
fn nearest_of(outline: &[Vec3], point: Vec2) -> (Vec2, Vec2) {
    let sides = outline.iter().zip(outline.iter().cycle().skip(1));
    let nearest = sides.map(|(from, to)| {
        let (from, along) = (from.truncate(), (*to - *from).truncate());
        let share = ((point - from).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
        (from + along * share, along.normalize_or_zero().perp())
    });
    let nearer =
        |a: &(Vec2, Vec2), b: &(Vec2, Vec2)| a.0.distance_squared(point).total_cmp(&b.0.distance_squared(point));
    nearest.min_by(nearer).unwrap_or((Vec2::INFINITY, Vec2::X))
}

fn around(points: impl Iterator<Item = Vec2>) -> (Vec2, Vec2) {
    points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::map::{network::Network, surroundings::LandArea};

    #[test]
    fn the_smallest_area_counts_and_borders_lie_where_the_file_says() {
        let roads = RoadSurfaces::of(&Network::load("ring-250").expect("a shipped map"));
        let areas = vec![
            LandArea::rectangle(LandUse::Park, [10.0, 10.0], [20.0, 20.0]),
            LandArea::rectangle(LandUse::Residential, [-100.0, -100.0], [200.0, 200.0]),
        ];
        let map = LandUseMap::of(&Surroundings { areas, ..Surroundings::default() }, &roads);
        let at = |x: f32, y: f32| map.at(Vec2::new(x, y));
        assert_eq!(at(20.0, 20.0), Some(LandUse::Park));
        assert_eq!(at(40.0, 20.0), Some(LandUse::Residential));
        assert_eq!(at(140.0, 20.0), None);
        let depth_m = |x: f32, kind: LandUse| map.depth_m(Vec2::new(x, 20.0), &[kind]);
        for (x, park_m, homes_m) in [(13.0, 3.0, -3.0), (8.0, -2.0, 2.0), (60.0, -8.0, 8.0), (101.5, -8.0, -1.5)] {
            let found = [depth_m(x, LandUse::Park), depth_m(x, LandUse::Residential)];
            assert!((found[0] - park_m).abs() < 1e-3 && (found[1] - homes_m).abs() < 1e-3, "{x}: {found:?}");
        }
        assert_eq!(depth_m(20.0, LandUse::Water), -BORDER_M);
        assert!(map.covers(Vec2::new(99.0, 0.0)) && !map.covers(Vec2::new(101.0, 0.0)));
        assert!(map.is_stated() && !LandUseMap::default().is_stated());
    }
}
