//! Plots along the streets of a town: where a building stands, how large it is, and of which kind. In: a network, its paved surfaces, a
//! seed. Out: [`Plot`]s that overlap neither each other nor a road. Metres.

use super::{
    relief::Relief,
    road_surfaces::RoadSurfaces,
    town::{PAVEMENT_M, Town},
};
use crate::{
    map::network::{EdgeId, LaneId, LanePosition, Network, Side},
    rng::{self, Stream},
};
use glam::{IVec2, Vec2};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Maximum number of buildings in a static scene.
pub const MOST_BUILDINGS: usize = 2000;
/// Distance of the first building from the end of a street, metres: corners stay open to view.
const CORNER_M: f64 = 4.0;
/// Step along a street after a place where nothing fits, metres.
const STEP_M: f64 = 4.0;
/// Distance between samples of a building's outline, metres.
const SAMPLE_M: f32 = 3.0;
/// Side of the squares in which near buildings are looked for, metres; wider than any building.
const SQUARE_M: f32 = 40.0;
/// Length of a fence beyond the corners of a house, and the part of the pavement that it may take in a slight bend, metres.
pub const FENCE_BEYOND_M: f32 = 1.2;
const FENCE_SLACK_M: f32 = 0.2;
/// Length of a drive behind the front, distance of its middle from the wall, and least distance of its middle from anything else, metres.
pub const DRIVE_M: f32 = 5.6;
const DRIVE_ASIDE_M: f32 = 1.9;
const DRIVE_FREE_M: f32 = 1.7;
/// Height of paths and drives over the ground, which is not quite level, metres.
pub const DRIVE_UP_M: f32 = 0.03;
/// Overlap of walls that adjoining houses share, metres.
const SHARED_M: f32 = 0.1;

/// Kind of a building.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlotKind {
    /// Detached house in a garden.
    House,
    /// House of flats in a garden.
    Flats,
    /// Building of a row along the pavement, with shops.
    Shops,
}

/// Place of a building: a rectangle with its front towards the street.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plot {
    pub kind: PlotKind,
    /// Middle of the front.
    pub front: Vec2,
    /// Unit vector from the front to the back.
    pub inwards: Vec2,
    pub width_m: f32,
    pub depth_m: f32,
    /// Distance of the front from the pavement.
    pub garden_m: f32,
    /// True for the side that another building adjoins: left, right.
    pub adjoins: [bool; 2],
    /// True if a fence along the front keeps off the pavement, which it would not in a bend towards the house.
    pub has_fence: bool,
    /// Side of the drive beside the house: -1 for the left, 1 for the right; `None` without one.
    pub drive: Option<f32>,
    /// Number of storeys, at most 7; `None` leaves it to the rules.
    pub storeys: Option<u32>,
    /// Number for the choice of details.
    pub seed: u64,
}

impl Plot {
    /// Returns the unit vector along the front, to the right as seen from the street.
    pub fn along(&self) -> Vec2 {
        -self.inwards.perp()
    }

    /// Returns the point this far to the right of the front's middle and behind the front.
    pub fn point(&self, right_m: f32, behind_m: f32) -> Vec2 {
        self.front + self.along() * right_m + self.inwards * behind_m
    }

    /// Returns the point in the middle of the drive this far behind the front; `None` without a drive.
    pub fn drive_point(&self, behind_m: f32) -> Option<Vec2> {
        self.drive.map(|side| self.point(side * (self.width_m / 2.0 + DRIVE_ASIDE_M), behind_m))
    }

    /// Returns the middle of the building.
    pub fn middle(&self) -> Vec2 {
        self.point(0.0, self.depth_m / 2.0)
    }

    /// Returns the height of the ground around the building where it is highest, metres.
    pub fn ground_m(&self, relief: &Relief) -> f32 {
        let half_m = self.width_m / 2.0;
        let corners =
            [(-half_m, 0.0), (half_m, 0.0), (half_m, self.depth_m), (-half_m, self.depth_m), (0.0, -self.garden_m)];
        let heights = corners.map(|(right_m, behind_m)| relief.height_m(self.point(right_m, behind_m)));
        heights.into_iter().fold(f32::NEG_INFINITY, f32::max)
    }

    /// Returns the distance of a point from the building, metres; 0 inside.
    pub fn distance_m(&self, point: Vec2) -> f32 {
        let off = point - self.middle();
        let beyond = Vec2::new(off.dot(self.along()).abs(), off.dot(self.inwards).abs())
            - Vec2::new(self.width_m, self.depth_m) / 2.0;
        beyond.max(Vec2::ZERO).length()
    }

    /// Checks whether two buildings overlap, except for a shared wall (separating axes).
    fn overlaps(&self, other: &Self) -> bool {
        let reach = |of: &Self, axis: Vec2| {
            (of.along().dot(axis).abs() * of.width_m + of.inwards.dot(axis).abs() * of.depth_m) / 2.0
        };
        let apart = |axis: Vec2| {
            let off_m = (self.middle() - other.middle()).dot(axis).abs();
            off_m > reach(self, axis) + reach(other, axis) - SHARED_M
        };
        ![self.along(), self.inwards, other.along(), other.inwards].into_iter().any(apart)
    }

    /// Checks whether a fence along the front leaves the pavement free, whose outer edge is `free_m` from the road.
    fn keeps_fence_off(&self, roads: &RoadSurfaces, free_m: f32) -> bool {
        let half_m = self.width_m / 2.0 + FENCE_BEYOND_M;
        let off_m = |right_m: f32| roads.border_m(self.point(right_m, -self.garden_m));
        [-1.0, -0.5, 0.5, 1.0].into_iter().all(|share| off_m(share * half_m) > free_m - FENCE_SLACK_M)
    }

    /// Checks whether a drive of full length is free of roads and of other buildings.
    fn has_free_drive(&self, roads: &RoadSurfaces, others: &[Self]) -> bool {
        [-self.garden_m, 0.0, DRIVE_M / 2.0, DRIVE_M].into_iter().all(|behind_m| {
            let Some(point) = self.drive_point(behind_m) else { return false };
            let is_off_road = behind_m <= 0.0 || roads.border_m(point) > DRIVE_FREE_M;
            is_off_road && others.iter().all(|other| other == self || other.distance_m(point) > DRIVE_FREE_M)
        })
    }

    /// Checks whether the building and what stands before it keep `free_m` from all roads.
    fn is_free(&self, roads: &RoadSurfaces, free_m: f32) -> bool {
        let is_free = |right_m: f32, behind_m: f32| roads.border_m(self.point(right_m, behind_m)) >= free_m;
        let (half_m, depth_m) = (self.width_m / 2.0, self.depth_m);
        let cuts = |length_m: f32| (0..=(length_m / SAMPLE_M).ceil() as u32).map(move |k| k as f32 * SAMPLE_M);
        is_free(0.0, depth_m / 2.0)
            && cuts(self.width_m).all(|at| {
                let right_m = (at - half_m).min(half_m);
                [0.0, depth_m].into_iter().all(|behind_m| is_free(right_m, behind_m))
            })
            && cuts(depth_m).all(|at| [-half_m, half_m].into_iter().all(|right_m| is_free(right_m, at.min(depth_m))))
    }
}

/// Plots sorted into squares, each also into the eight around its own: one lookup finds all within 40 m of a point.
#[derive(Debug, Default)]
pub struct PlotSquares(BTreeMap<[i32; 2], Vec<Plot>>);

impl PlotSquares {
    fn square(point: Vec2) -> IVec2 {
        (point / SQUARE_M).floor().as_ivec2()
    }

    /// Adds a plot by its middle.
    pub fn add(&mut self, plot: Plot) {
        let at = Self::square(plot.middle());
        for (x, y) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))) {
            self.0.entry([at.x + x, at.y + y]).or_default().push(plot);
        }
    }

    /// Returns the plots with their middles in the square of a point and the eight around it.
    pub fn near(&self, point: Vec2) -> &[Plot] {
        self.0.get(&Self::square(point).to_array()).map_or(&[], Vec::as_slice)
    }
}

/// Rule that says whether a building may stand along a street.
pub type MayStand<'a> = dyn Fn(EdgeId, &Plot) -> bool + Sync + 'a;

/// Returns the plots along all streets of a town where a building may stand.
pub fn plots(net: &Network, town: &Town, roads: &RoadSurfaces, seed: u64, may_stand: &MayStand) -> Vec<Plot> {
    let streets: Vec<EdgeId> = net.edge_ids().filter(|edge| town.has_street(*edge)).collect();
    // Each street has its own random numbers, so that streets can be built up in parallel.
    let along = streets.par_iter().map(|edge| along_street(net, town, roads, (*edge, may_stand), seed));
    let along: Vec<Vec<Plot>> = along.collect();
    let mut squares = PlotSquares::default();
    let mut plots = Vec::new();
    for plot in along.into_iter().flatten() {
        if !squares.near(plot.middle()).iter().any(|other| plot.overlaps(other)) {
            squares.add(plot);
            plots.push(plot);
        }
    }
    let is_free = |plot: &Plot| plot.has_free_drive(roads, squares.near(plot.middle()));
    let drive = |plot: Plot| Plot { drive: plot.drive.filter(|_| is_free(&plot)), ..plot };
    let plots: Vec<Plot> = plots.into_iter().map(drive).collect();
    // In a large town there are too many: only every `keep`-th building stays.
    let keep = plots.len().div_ceil(MOST_BUILDINGS).max(1);
    plots.into_iter().step_by(keep).collect()
}

/// Returns the plots on both sides of a street.
fn along_street(
    net: &Network,
    town: &Town,
    roads: &RoadSurfaces,
    (edge, may_stand): (EdgeId, &MayStand),
    seed: u64,
) -> Vec<Plot> {
    let mut random = rng::stream(seed, &format!("buildings {}", net.edge(edge).id));
    let mut plots: Vec<Plot> = Vec::new();
    for side in [Side::Right, Side::Left] {
        let outermost = net.edge(edge).lanes().find(|lane| net.neighbour(*lane, side).is_none());
        if let Some(lane) = outermost {
            let one_side = beside_lane(net, town, roads, (lane, side), &mut random, may_stand);
            plots.extend(one_side);
        }
    }
    plots
}

fn beside_lane(
    net: &Network,
    town: &Town,
    roads: &RoadSurfaces,
    (id, side): (LaneId, Side),
    random: &mut Stream,
    may_stand: &MayStand,
) -> Vec<Plot> {
    let lane = net.lane(id);
    let scale = lane.length_m / lane.line.drawn_m().max(0.1);
    let pavement_m = if lane.is_footway() { 0.3 } else { PAVEMENT_M + 0.3 };
    let is_centre = town.is_centre(net, lane.edge);
    let mut plots: Vec<Plot> = Vec::new();
    // True if the next building adjoins the last one.
    let mut adjoins = false;
    let mut at_m = CORNER_M;
    while at_m < lane.line.drawn_m() - CORNER_M {
        let (kind, [width_m, depth_m], garden_m, gap_m) = choice(is_centre, random);
        let seed = random.uniform(0.0, 1e9) as u64;
        let middle_m = at_m + f64::from(width_m) / 2.0;
        if at_m + f64::from(width_m) > lane.line.drawn_m() - CORNER_M {
            break;
        }
        let road = net.pose(LanePosition { lane: id, s_m: middle_m * scale, offset_m: 0.0 });
        let left = Vec2::from_angle(road.yaw_rad as f32).perp();
        let inwards = if side == Side::Left { left } else { -left };
        let aside_m = lane.half_width_m() as f32 + pavement_m + garden_m;
        let front = road.position.truncate().as_vec2() + inwards * aside_m;
        let plot = Plot {
            kind,
            front,
            inwards,
            width_m,
            depth_m,
            garden_m,
            adjoins: [false; 2],
            has_fence: false,
            drive: None,
            storeys: None,
            seed,
        };
        // In a bend towards the buildings, adjoining fronts would overlap.
        let is_apart = plots.last().is_none_or(|before| !plot.overlaps(before));
        if is_apart && plot.is_free(roads, pavement_m) && may_stand(lane.edge, &plot) {
            // Along the lane, the right side of a building to the right comes last.
            let [first, last] = if side == Side::Right { [1, 0] } else { [0, 1] };
            if let (true, Some(before)) = (adjoins, plots.last_mut()) {
                before.adjoins[last] = true;
            }
            let mut adjoining = plot;
            adjoining.adjoins[first] = adjoins;
            adjoining.has_fence = plot.keeps_fence_off(roads, pavement_m);
            let has_drive = kind == PlotKind::House && gap_m > DRIVE_ASIDE_M + DRIVE_FREE_M;
            adjoining.drive = has_drive.then_some([-1.0, 1.0][last]);
            plots.push(adjoining);
            at_m += f64::from(width_m + gap_m);
            adjoins = gap_m < 0.1;
        } else {
            adjoins = false;
            at_m += STEP_M;
        }
    }
    plots
}

/// Draws a building: its kind, its width and depth, the depth of its front garden, and the gap to the next building.
fn choice(is_centre: bool, random: &mut Stream) -> (PlotKind, [f32; 2], f32, f32) {
    let mut draw = |low: f64, high: f64| random.uniform(low, high) as f32;
    // The same number of draws in any case keeps streets alike when a rule changes.
    let [pick, width, depth, garden, gap] = [0; 5].map(|_| draw(0.0, 1.0));
    let mix = |low: f32, high: f32, share: f32| low + (high - low) * share;
    if is_centre && pick < 0.86 {
        let gap_m = if gap < 0.72 { 0.0 } else { mix(3.0, 9.0, (gap - 0.72) / 0.28) };
        return (PlotKind::Shops, [mix(9.5, 17.0, width), mix(10.5, 13.0, depth)], 0.05, gap_m);
    }
    if is_centre || pick < 0.12 {
        return (
            PlotKind::Flats,
            [mix(14.0, 22.0, width), mix(10.0, 12.0, depth)],
            mix(3.0, 5.0, garden),
            mix(6.0, 12.0, gap),
        );
    }
    let size = [mix(8.5, 12.5, width), mix(8.0, 10.0, depth)];
    (PlotKind::House, size, mix(3.2, 6.5, garden), mix(4.0, 10.0, gap))
}
