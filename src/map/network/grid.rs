//! Spatial index of lane segments. In: all lanes of a network except walking areas. Out: for a point, the segments within [`REACH_M`],
//! and possibly some others. A uniform grid whose cells lie in a hash table: a cell costs the same at any coordinates, and a lookup takes
//! one step and no allocation. Cells that share a slot of the table list the segments of both; the caller separates them by distance.

use super::{EdgeKind, LaneId, Network, locate::REACH_M};
use glam::DVec2;

/// Side of a cell, metres; larger if the lanes together are longer than 2,000 km, to keep the table small.
const CELL_M: f64 = 20.0;
/// Largest number of pieces that all lanes together are cut into, see [`CELL_M`].
const MOST_PIECES: f64 = 100_000.0;

/// Consecutive segments of a lane's centre line in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SegmentRun {
    pub lane: LaneId,
    // A lane has at most 20,000 points.
    first: u16,
    last: u16,
}

impl SegmentRun {
    pub fn segments(self) -> std::ops::RangeInclusive<usize> {
        usize::from(self.first)..=usize::from(self.last)
    }
}

/// Hash table from cells to segments.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SegmentGrid {
    cell_m: f64,
    /// Index of the first run of each slot; one more entry at the end. The number of slots is a power of two.
    starts: Vec<u32>,
    runs: Vec<SegmentRun>,
}

impl SegmentGrid {
    pub fn new(net: &Network) -> Self {
        let lanes = || net.lane_ids().filter(|lane| net.edge_of(*lane).kind != EdgeKind::WalkingArea);
        let drawn_m: f64 = lanes().map(|lane| net.lane(lane).line.drawn_m()).sum();
        let cell_m = CELL_M.max(drawn_m / MOST_PIECES);
        // Counted first, then filled: a list of all runs would be three times as large as the table.
        let mut cells = Vec::new();
        let mut each_run = |what: &mut dyn FnMut((i64, i64), SegmentRun)| {
            for lane in lanes() {
                runs_of(net, lane, cell_m, &mut cells, what);
            }
        };
        let mut n = 0usize;
        each_run(&mut |_, _| n += 1);
        let places = (n / 2).next_power_of_two();
        let mut starts = vec![0u32; places + 1];
        each_run(&mut |cell, _| starts[place(cell, places) + 1] += 1);
        for k in 0..places {
            starts[k + 1] += starts[k];
        }
        let mut free = starts.clone();
        let mut runs = vec![SegmentRun { lane: LaneId::from_index(0), first: 0, last: 0 }; n];
        each_run(&mut |cell, run| {
            let at = &mut free[place(cell, places)];
            runs[*at as usize] = run;
            *at += 1;
        });
        Self { cell_m, starts, runs }
    }

    /// Returns the segments that may be within reach of a point; each at least once.
    pub fn near(&self, point: DVec2) -> &[SegmentRun] {
        let places = self.starts.len().saturating_sub(1);
        if places == 0 {
            return &[];
        }
        let k = place(cell(point, self.cell_m), places);
        &self.runs[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// Returns the size of the table, bytes.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.starts.len() * size_of::<u32>() + self.runs.len() * size_of::<SegmentRun>()
    }
}

/// Passes the runs of a lane to `what`, cell by cell.
fn runs_of(
    net: &Network,
    lane: LaneId,
    cell_m: f64,
    cells: &mut Vec<((i64, i64), u16)>,
    what: &mut dyn FnMut((i64, i64), SegmentRun),
) {
    cells.clear();
    for (k, pair) in net.lane(lane).line.points().windows(2).enumerate() {
        cells_near(pair[0].truncate(), pair[1].truncate(), cell_m, k as u16, cells);
    }
    cells.sort_unstable();
    cells.dedup();
    for run in cells.chunk_by(|(cell, k), (next_cell, next)| cell == next_cell && *next == k + 1) {
        let ((cell, first), (_, last)) = (run[0], run[run.len() - 1]);
        what(cell, SegmentRun { lane, first, last });
    }
}

fn cell(point: DVec2, cell_m: f64) -> (i64, i64) {
    ((point.x / cell_m).floor() as i64, (point.y / cell_m).floor() as i64)
}

/// Returns the slot of a cell in a table whose size is a power of two.
fn place((x, y): (i64, i64), places: usize) -> usize {
    // Multiplicative hashing: the bits of the golden ratio spread neighbouring cells over the table.
    let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed >> 32) as usize) & (places - 1)
}

/// Adds the cells within reach of segment `k`, some more than once.
fn cells_near(from: DVec2, to: DVec2, cell_m: f64, k: u16, cells: &mut Vec<((i64, i64), u16)>) {
    let pieces = (from.distance(to) / cell_m).ceil().max(1.0);
    for piece in 0..pieces as usize {
        let (a, b) = (from.lerp(to, piece as f64 / pieces), from.lerp(to, (piece + 1) as f64 / pieces));
        let (low, high) = (cell(a.min(b) - REACH_M, cell_m), cell(a.max(b) + REACH_M, cell_m));
        for x in low.0..=high.0 {
            for y in low.1..=high.1 {
                cells.push(((x, y), k));
            }
        }
    }
}
