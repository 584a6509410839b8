//! Which segments of lanes are near a point. In: all lanes of a network but walking areas. Out: for a point, the segments that come
//! within [`REACH_M`] of it, and perhaps some others. A uniform grid whose cells are kept in a table by their hash: a cell costs the
//! same wherever it is, looking one up takes one step and no memory. In cells that share a place in the table, segments of both
//! are listed; they are told apart by their distance.

use super::{EdgeKind, LaneId, Network, locate::REACH_M};
use glam::DVec2;

/// Side of a cell, metres; larger where a network is so long that the table would be.
const CELL_M: f64 = 20.0;
/// The most pieces that long segments are cut into, for all lanes together.
const MOST_PIECES: f64 = 400_000.0;

/// A segment of a lane's centre line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LaneSegment {
    pub lane: LaneId,
    pub segment: u32,
}

/// The table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SegmentGrid {
    cell_m: f64,
    /// Where the segments of each place of the table begin; one more at the end. The number of places is a power of two.
    starts: Vec<u32>,
    segments: Vec<LaneSegment>,
}

impl SegmentGrid {
    pub fn new(net: &Network) -> Self {
        let lanes = || net.lane_ids().filter(|lane| net.edge_of(*lane).kind != EdgeKind::WalkingArea);
        let drawn_m: f64 = lanes().map(|lane| net.lane(lane).line.drawn_m()).sum();
        let cell_m = CELL_M.max(drawn_m / MOST_PIECES);
        let mut listed: Vec<((i64, i64), LaneSegment)> = Vec::new();
        let mut cells = Vec::new();
        for lane in lanes() {
            let points = net.lane(lane).line.points();
            for (k, pair) in points.windows(2).enumerate() {
                cells.clear();
                cells_near(pair[0].truncate(), pair[1].truncate(), cell_m, &mut cells);
                let segment = LaneSegment { lane, segment: k as u32 };
                listed.extend(cells.iter().map(|cell| (*cell, segment)));
            }
        }
        let places = (listed.len() / 4).next_power_of_two();
        let mut starts = vec![0u32; places + 1];
        for (cell, _) in &listed {
            starts[place(*cell, places) + 1] += 1;
        }
        for k in 0..places {
            starts[k + 1] += starts[k];
        }
        let mut free = starts.clone();
        let mut segments = vec![LaneSegment { lane: LaneId::from_index(0), segment: 0 }; listed.len()];
        for (cell, segment) in &listed {
            let at = &mut free[place(*cell, places)];
            segments[*at as usize] = *segment;
            *at += 1;
        }
        Self { cell_m, starts, segments }
    }

    /// The segments that may be within reach of a point; each at least once.
    pub fn near(&self, point: DVec2) -> &[LaneSegment] {
        let places = self.starts.len().saturating_sub(1);
        if places == 0 {
            return &[];
        }
        let k = place(cell(point, self.cell_m), places);
        &self.segments[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// Memory that it holds, bytes.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.starts.len() * size_of::<u32>() + self.segments.len() * size_of::<LaneSegment>()
    }
}

fn cell(point: DVec2, cell_m: f64) -> (i64, i64) {
    ((point.x / cell_m).floor() as i64, (point.y / cell_m).floor() as i64)
}

/// Place of a cell in a table of a power of two.
fn place((x, y): (i64, i64), places: usize) -> usize {
    // Fibonacci hashing: the golden ratio's bits spread neighbours over the table.
    let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed >> 32) as usize) & (places - 1)
}

/// The cells within reach of a segment, each once.
fn cells_near(from: DVec2, to: DVec2, cell_m: f64, cells: &mut Vec<(i64, i64)>) {
    let pieces = (from.distance(to) / cell_m).ceil().max(1.0);
    for k in 0..pieces as usize {
        let (a, b) = (from.lerp(to, k as f64 / pieces), from.lerp(to, (k + 1) as f64 / pieces));
        let (low, high) = (cell(a.min(b) - REACH_M, cell_m), cell(a.max(b) + REACH_M, cell_m));
        for x in low.0..=high.0 {
            for y in low.1..=high.1 {
                cells.push((x, y));
            }
        }
    }
    cells.sort_unstable();
    cells.dedup();
}
