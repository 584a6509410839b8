//! All paved surfaces of a network, and queries for points of the land: distance from the nearest lane, and height of the ground between
//! roads of different heights. In: lines with their widths, outlines of areas. Out: metres. Distances are exact up to 90 m from the
//! roads. Further away they are estimated from sample points, with an error of about the samples' spacing.

use super::{
    cell_grid::{CELL_M, CellGrid, CellTable},
    junction_areas,
    outlines::contains,
};
use crate::{
    map::network::{EdgeKind, Network},
    space::smoothstep,
};
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;

/// Maximum distance from a road at which distances are exact, metres.
const NEAR_M: f32 = 90.0;
/// Maximum length of a segment, metres. Each segment within reach contributes the height of its nearest point to the ground's height.
const PIECE_M: f32 = 8.0;
/// Maximum number of sample points of the roads, for points of the land far from all of them.
const MOST_COARSE: usize = 1000;
/// Maximum distance from its edge at which a segment shapes the ground, metres.
const SHAPED_M: f32 = 90.0;
/// Half-width of the cutting around a road below another, from the lower road's edge, metres. The ground there is as low as that road and
/// rises by 45 degrees beyond. The cutting is wider than a cell of the land, so that no land covers the lower road.
const CUTTING_M: f32 = 5.7;
/// Distance in cells from which the members of a cell count as one in the ground's height.
const TOGETHER_RINGS: i32 = 3;
/// Sum of the weights of near segments above which those of the sample points, 1e-7 in all at most, are left out.
const ENOUGH_WEIGHT: f32 = 1e-4;
/// Range of depths below the mean ground over which a road's cutting sets in, metres. Slopes of the same road cause smaller depths.
const BELOW_M: [f32; 2] = [1.0, 2.0];

/// Height over the ground from which a road is on a bridge, metres. Lower ground is out of a verge's reach.
const BRIDGE_M: f32 = 1.5;

/// Nominal half-width of a lane, for distances from a lane's middle, m.
pub const HALF_LANE_M: f32 = 1.6;

/// Straight segment of a lane's centre line, or of an area's outline (half-width 0).
#[derive(Clone, Copy, Debug)]
struct SurfaceSegment {
    from: Vec3,
    along: Vec3,
    half_width_m: f32,
    /// Horizontal `along`, divided by its squared length, 1/m.
    share_per_m: Vec2,
}

impl SurfaceSegment {
    fn new(from: Vec3, to: Vec3, half_width_m: f32) -> Self {
        let along = to - from;
        let flat = along.truncate();
        Self { from, along, half_width_m, share_per_m: flat / flat.length_squared().max(1e-9) }
    }

    fn to(&self) -> Vec3 {
        self.from + self.along
    }

    fn middle(&self) -> Vec3 {
        self.from + self.along / 2.0
    }

    /// Returns the squared horizontal distance of a point from the segment's line, m², and the height of the line's nearest point.
    fn beside(&self, point: Vec2) -> (f32, f32) {
        let off = point - self.from.truncate();
        let share = off.dot(self.share_per_m).clamp(0.0, 1.0);
        ((off - self.along.truncate() * share).length_squared(), self.from.z + self.along.z * share)
    }
}

/// Mean of the segments in a cell of the grid.
#[derive(Clone, Copy, Debug, Default)]
struct CellMean {
    middle: Vec3,
    half_width_m: f32,
    /// Number of its members that are segments.
    count: f32,
}

impl CellMean {
    fn of(segments: &[SurfaceSegment]) -> Self {
        let mut sum = Self::default();
        for segment in segments {
            sum.middle += segment.middle();
            sum.half_width_m += segment.half_width_m;
            sum.count += 1.0;
        }
        let count = sum.count.max(1.0);
        Self { middle: sum.middle / count, half_width_m: sum.half_width_m / count, count: sum.count }
    }
}

/// Collector of paved surfaces, from which [`RoadSurfaces`] is built.
#[derive(Debug, Default)]
pub struct SurfaceCollector {
    pieces: Vec<SurfaceSegment>,
    areas: Vec<Vec<Vec3>>,
}

impl SurfaceCollector {
    /// Adds a strip along a line, `half_width_m` wide on either side.
    pub fn line(&mut self, points: &[Vec3], half_width_m: f32) {
        for pair in points.windows(2) {
            let n = (pair[0].truncate().distance(pair[1].truncate()) / PIECE_M).ceil().max(1.0);
            let at = |k: f32| pair[0].lerp(pair[1], k / n);
            let cut = (0..n as usize).map(|k| (at(k as f32), at(k as f32 + 1.0)));
            self.pieces.extend(cut.map(|(from, to)| SurfaceSegment::new(from, to, half_width_m)));
        }
    }

    /// Adds an area by its outline, in either orientation.
    pub fn area(&mut self, outline: &[Vec3]) {
        if outline.len() < 3 {
            return;
        }
        let closed: Vec<Vec3> = outline.iter().chain(outline.first()).copied().collect();
        self.line(&closed, 0.0);
        self.areas.push(outline.to_vec());
    }
}

/// Paved surfaces of a network, sorted into the cells of a grid.
#[derive(Debug)]
pub struct RoadSurfaces {
    pieces: Vec<SurfaceSegment>,
    areas: Vec<Vec<Vec3>>,
    /// Centre of the bounding box of all segments.
    centre: Vec2,
    /// Radius around the centre that encloses all segments, m.
    radius_m: f32,
    grid: CellGrid,
    /// Segments in each cell. A segment may be in several.
    segments: CellTable<SurfaceSegment>,
    /// Indices of the areas in each cell.
    areas_in: CellTable<u32>,
    /// Segments of each cell as one.
    means: Vec<CellMean>,
    /// Sample points of roads, at most one in each square of a lattice.
    coarse: Vec<Vec3>,
    /// Common height of all roads, metres; `None` if heights differ by 1 cm or more.
    level_m: Option<f32>,
}

impl RoadSurfaces {
    /// Returns all paved surfaces of a network.
    pub fn of(net: &Network) -> Self {
        let mut collector = SurfaceCollector::default();
        for id in net.lane_ids() {
            let lane = net.lane(id);
            match net.edge_of(id).kind {
                EdgeKind::WalkingArea => collector.area(&points(lane.shape())),
                EdgeKind::Crossing => {}
                _ => collector.line(&points(lane.line.points()), lane.half_width_m() as f32),
            }
        }
        for area in junction_areas::areas(net) {
            collector.area(&area.outline);
        }
        for gore in net.gores() {
            collector.area(&points(&gore.outline));
        }
        Self::new(collector)
    }

    /// Sorts the collected surfaces into cells.
    pub fn new(SurfaceCollector { pieces, areas }: SurfaceCollector) -> Self {
        let points = || pieces.iter().flat_map(|piece| [piece.from, piece.to()]);
        let low = points().reduce(Vec3::min).unwrap_or_default();
        let high = points().reduce(Vec3::max).unwrap_or_default();
        let level_m = (high.z - low.z < 0.01).then_some(low.z);
        let widest_m = pieces.iter().map(|piece| piece.half_width_m).fold(0.0, f32::max);
        let (low, high) = (low.truncate() - widest_m, high.truncate() + widest_m);
        let grid = CellGrid::over(low, high);
        let segments = grid.table(pieces.iter().map(|piece| {
            let (a, b) = (piece.from.truncate(), piece.to().truncate());
            ((a.min(b) - piece.half_width_m, a.max(b) + piece.half_width_m), *piece)
        }));
        let areas_in = grid.table((0..).zip(&areas).map(|(n, area)| {
            let corners = || area.iter().map(|p| p.truncate());
            ((corners().fold(Vec2::INFINITY, Vec2::min), corners().fold(Vec2::NEG_INFINITY, Vec2::max)), n)
        }));
        let means = (0..grid.cells()).map(|cell| CellMean::of(segments.of(cell..cell + 1))).collect();
        let coarse = coarse(&pieces);
        let (centre, radius_m) = circle(&pieces);
        Self { pieces, areas, centre, radius_m, grid, segments, areas_in, means, coarse, level_m }
    }

    /// Returns the centre of the bounding box of all roads, m.
    pub fn centre(&self) -> Vec2 {
        self.centre
    }

    /// Returns the radius around the centre that encloses all surfaces, m.
    pub fn radius_m(&self) -> f32 {
        self.radius_m
    }

    /// Returns the common height of all roads, metres; `None` if heights differ by 1 cm or more.
    pub fn level_m(&self) -> Option<f32> {
        self.level_m
    }

    /// Returns the height of the highest road, metres; at least 0.
    pub fn highest_m(&self) -> f32 {
        self.pieces.iter().map(|piece| piece.from.z.max(piece.to().z)).fold(0.0, f32::max)
    }

    /// Returns the total length of all lines and outlines, metres.
    pub fn length_m(&self) -> f32 {
        self.pieces.iter().map(|piece| piece.along.length()).sum()
    }

    /// Returns the distance from the nearest paved surface, metres; 0 inside.
    pub fn border_m(&self, point: Vec2) -> f32 {
        let mut best_m = f32::INFINITY;
        // Beyond the circle around all surfaces, none is within NEAR_M: most of the land.
        let may_be_near = point.distance(self.centre) <= self.radius_m + NEAR_M;
        let rings = if may_be_near { self.grid.rings(NEAR_M) } else { -1 };
        // An area is in all cells that its box touches.
        let mut areas = self.grid.around(point, 0..1).flat_map(|cell| self.areas_in.of(cell));
        if areas.any(|area| contains(&self.areas[*area as usize], point)) {
            return 0.0;
        }
        for ring in 0..=rings {
            // No segment of this ring can be nearer than the best one so far.
            if best_m <= (ring - 1).max(0) as f32 * self.grid.cell_m {
                break;
            }
            for piece in self.grid.around(point, ring..ring + 1).flat_map(|cells| self.segments.of(cells)) {
                // A root for the nearest ones only.
                let (squared_m2, beyond_m) = (piece.beside(point).0, best_m + piece.half_width_m);
                if squared_m2 < beyond_m * beyond_m {
                    best_m = squared_m2.sqrt() - piece.half_width_m;
                    if best_m <= 0.0 {
                        return 0.0;
                    }
                }
            }
        }
        if best_m <= NEAR_M {
            return best_m;
        }
        let far = self.coarse.iter().map(|p| p.truncate().distance_squared(point)).fold(f32::INFINITY, f32::min);
        far.sqrt().max(NEAR_M)
    }

    /// Checks whether a paved surface may be within a distance, m; false only if there is none.
    pub fn may_be_within(&self, point: Vec2, distance_m: f32) -> bool {
        let mut cells = self.grid.around(point, 0..self.grid.rings(distance_m) + 1);
        cells.any(|cells| !self.segments.of(cells.clone()).is_empty() || !self.areas_in.of(cells).is_empty())
    }

    /// Returns the distance from the middle of the nearest lane, m, if each lane were [`HALF_LANE_M`] wide on either side.
    pub fn middle_m(&self, point: Vec2) -> f32 {
        self.border_m(point) + HALF_LANE_M
    }

    /// Returns the height of the ground, metres: a weighted mean of the heights of the surrounding roads, dominated by the nearest. Around
    /// a road that lies below another, the ground does not cover the lower one.
    pub fn height_m(&self, point: Vec2) -> f32 {
        if let Some(level_m) = self.level_m {
            return level_m;
        }
        // Sum of weighted heights, and sum of weights.
        let (mut sums, mut lowest_m) = (Vec2::ZERO, f32::INFINITY);
        let weighted = |weight: f32, z_m: f32| weight * Vec2::new(z_m, 1.0);
        // Shepard's inverse distance weights, falling to 0 at `SHAPED_M`.
        let shepard = |off_m: f32| {
            let near = off_m.clamp(0.0, SHAPED_M) + 0.3;
            ((SHAPED_M + 0.3 - near) / (SHAPED_M * near)).powi(4)
        };
        for cells in self.grid.around(point, 0..TOGETHER_RINGS) {
            for piece in self.segments.of(cells) {
                let (squared_m2, z_m) = piece.beside(point);
                let off_m = squared_m2.sqrt() - piece.half_width_m;
                sums += weighted(shepard(off_m), z_m);
                lowest_m = lowest_m.min(z_m + (off_m - CUTTING_M).max(0.0));
            }
        }
        for cells in self.grid.around(point, TOGETHER_RINGS..self.grid.rings(SHAPED_M) + 1) {
            for CellMean { middle, half_width_m, count } in self.means[cells].iter().filter(|mean| mean.count > 0.0) {
                sums += weighted(count * shepard(middle.truncate().distance(point) - half_width_m), middle.z);
            }
        }
        if sums.y < ENOUGH_WEIGHT {
            // The sample points have small weights: they dominate from about 50 m from the nearest road.
            let share = 3e-5 / self.coarse.len() as f32;
            for far in &self.coarse {
                sums += weighted(share / (1.0 + far.truncate().distance_squared(point)), far.z);
            }
        }
        let mean_m = if sums.y > 0.0 { sums.x / sums.y } else { 0.0 };
        let above_m = (mean_m - lowest_m).max(0.0);
        mean_m - above_m * smoothstep(BELOW_M[0], BELOW_M[1], above_m)
    }

    /// Checks whether a road at this point is on a bridge, high over the ground below it.
    pub fn is_on_bridge(&self, at: Vec3) -> bool {
        self.level_m.is_none() && self.height_m(at.truncate()) < at.z - BRIDGE_M
    }
}

/// Returns the centre of the bounding box of all segments, and the radius around it that encloses them, m.
fn circle(pieces: &[SurfaceSegment]) -> (Vec2, f32) {
    let points = || pieces.iter().flat_map(|piece| [piece.from, piece.to()]).map(Vec3::truncate);
    let low = points().reduce(Vec2::min).unwrap_or_default();
    let centre = (low + points().reduce(Vec2::max).unwrap_or_default()) / 2.0;
    let reach = |piece: &SurfaceSegment| {
        let ends = [piece.from, piece.to()].map(|end| end.truncate().distance(centre));
        ends[0].max(ends[1]) + piece.half_width_m
    };
    (centre, pieces.iter().map(reach).fold(0.0, f32::max))
}

/// Samples at most one point in each square of a lattice, fine enough to give at most [`MOST_COARSE`] points.
fn coarse(pieces: &[SurfaceSegment]) -> Vec<Vec3> {
    let mut side_m = 2.0 * CELL_M;
    loop {
        let mut squares: BTreeMap<[i32; 2], Vec3> = BTreeMap::new();
        for piece in pieces {
            let middle = piece.middle();
            squares.entry((middle.truncate() / side_m).floor().as_ivec2().to_array()).or_insert(middle);
        }
        if squares.len() <= MOST_COARSE {
            return squares.into_values().collect();
        }
        side_m *= 1.5;
    }
}

/// Returns points in single precision.
pub fn points(shape: &[DVec3]) -> Vec<Vec3> {
    shape.iter().map(|point| point.as_vec3()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_on_a_lane_is_paved_whatever_outline_passes_near_it() {
        let mut collector = SurfaceCollector::default();
        collector.line(&[Vec3::ZERO, Vec3::X * 6.0], 2.0);
        // An area beside the middle of the lane, which reaches beyond its edge.
        collector.area(&[Vec3::new(0.0, 0.5, 0.0), Vec3::new(6.0, 0.5, 0.0), Vec3::new(3.0, 4.0, 0.0)]);
        let surfaces = RoadSurfaces::new(collector);
        let border_m = |y: f32| surfaces.border_m(Vec2::new(3.0, y));
        assert_eq!([-1.9, 0.0, 0.3, 1.0, 3.9].map(border_m), [0.0; 5]);
        assert!((border_m(-3.0) - 1.0).abs() < 1e-6 && (border_m(4.5) - 0.5).abs() < 1e-6, "{}", border_m(4.5));
    }
}
