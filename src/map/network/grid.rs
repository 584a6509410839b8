//! Which segments of lanes are near a point. In: all lanes of a network but walking areas. Out: for a point, the segments that come
//! within [`REACH_M`] of it, and perhaps some others. A uniform grid whose cells are kept in a table by their hash: a cell costs the
//! same wherever it is, looking one up takes one step and no memory. In cells that share a place in the table, segments of both
//! are listed; they are told apart by their distance.

use super::{EdgeKind, LaneId, Network, locate::REACH_M};
use glam::DVec2;

/// Side of a cell, metres; larger where lanes are longer than 2,000 km together, so that the table stays small.
const CELL_M: f64 = 20.0;
/// The most pieces that long segments are cut into, for all lanes together: see [`CELL_M`].
const MOST_PIECES: f64 = 100_000.0;

/// Segments of a lane's centre line that follow each other in one cell.
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

/// The table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SegmentGrid {
    cell_m: f64,
    /// Where the runs of each place of the table begin; one more at the end. The number of places is a power of two.
    starts: Vec<u32>,
    runs: Vec<SegmentRun>,
}

impl SegmentGrid {
    pub fn new(net: &Network) -> Self {
        let lanes = || net.lane_ids().filter(|lane| net.edge_of(*lane).kind != EdgeKind::WalkingArea);
        let drawn_m: f64 = lanes().map(|lane| net.lane(lane).line.drawn_m()).sum();
        let cell_m = CELL_M.max(drawn_m / MOST_PIECES);
        // Counted first and filled then: a list of all would be three times as large as the table.
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

    /// The segments that may be within reach of a point; each at least once.
    pub fn near(&self, point: DVec2) -> &[SegmentRun] {
        let places = self.starts.len().saturating_sub(1);
        if places == 0 {
            return &[];
        }
        let k = place(cell(point, self.cell_m), places);
        &self.runs[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// Memory that it holds, bytes.
    #[cfg(test)]
    pub fn bytes(&self) -> usize {
        self.starts.len() * size_of::<u32>() + self.runs.len() * size_of::<SegmentRun>()
    }
}

/// The runs of a lane, cell by cell.
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

/// Place of a cell in a table of a power of two.
fn place((x, y): (i64, i64), places: usize) -> usize {
    // Fibonacci hashing: the golden ratio's bits spread neighbours over the table.
    let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed >> 32) as usize) & (places - 1)
}

/// The cells within reach of segment `k`, some more than once.
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
