//! A grid of square cells, and what lies in them. In: boxes around entries. Out: the entries near a point, row by row. Lengths are in metres.

use glam::{IVec2, Vec2};
use std::ops::Range;

/// Initial side of a cell, metres. The side is doubled until there are at most [`MOST_CELLS`].
pub(super) const CELL_M: f32 = 16.0;
const MOST_CELLS: usize = 1 << 20;

/// Grid of square cells over a rectangle.
#[derive(Debug)]
pub(super) struct CellGrid {
    low: Vec2,
    pub cell_m: f32,
    columns: i32,
    rows: i32,
}

impl CellGrid {
    /// Returns a grid from the corner `low` to the corner `high`, with at least one cell.
    pub fn over(low: Vec2, high: Vec2) -> Self {
        let mut cell_m = CELL_M;
        let count = |cell_m: f32| ((high - low) / cell_m).ceil().max(Vec2::ONE);
        while count(cell_m).element_product() as usize > MOST_CELLS {
            cell_m *= 2.0;
        }
        let size = count(cell_m).as_ivec2();
        Self { low, cell_m, columns: size.x, rows: size.y }
    }

    /// Returns the number of cells.
    pub fn cells(&self) -> usize {
        (self.columns * self.rows) as usize
    }

    /// Returns a table with each entry in all cells that its box, from low to high, touches.
    pub fn table<T: Copy>(&self, entries: impl Iterator<Item = ((Vec2, Vec2), T)>) -> CellTable<T> {
        let last = IVec2::new(self.columns, self.rows) - 1;
        let cell = |point: Vec2| self.cell_at(point).clamp(IVec2::ZERO, last);
        let mut of_cell = Vec::new();
        for ((low, high), entry) in entries {
            let (from, to) = (cell(low), cell(high));
            for y in from.y..=to.y {
                of_cell.extend((from.x..=to.x).map(|x| ((y * self.columns + x) as u32, entry)));
            }
        }
        CellTable::new(self.cells(), of_cell)
    }

    /// Returns the number of rings of cells around a point's cell within which all entries up to a distance, m, lie.
    pub fn rings(&self, within_m: f32) -> i32 {
        (within_m / self.cell_m).ceil() as i32
    }

    /// Returns the cells in some square rings around the point's cell, which is ring 0, as ranges of neighbours in a row. The point may lie
    /// outside the grid.
    pub fn around(&self, point: Vec2, rings: Range<i32>) -> impl Iterator<Item = Range<usize>> + use<> {
        let (at, columns, outer) = (self.cell_at(point), self.columns, rings.end - 1);
        let rows = (at.y - outer).max(0)..(at.y + outer + 1).min(self.rows);
        rows.flat_map(move |y| {
            let parts = if (y - at.y).abs() >= rings.start {
                [at.x - outer..at.x + outer + 1, 0..0]
            } else {
                [at.x - outer..at.x - rings.start + 1, at.x + rings.start..at.x + outer + 1]
            };
            let inside = |part: Range<i32>| part.start.max(0)..part.end.min(columns);
            let index = move |x: i32| (y * columns + x) as usize;
            parts.map(inside).into_iter().filter(|part| !part.is_empty()).map(move |x| index(x.start)..index(x.end))
        })
    }

    /// Returns column and row of the cell at a point, which may lie outside the grid.
    fn cell_at(&self, point: Vec2) -> IVec2 {
        ((point - self.low) / self.cell_m).floor().as_ivec2()
    }
}

/// Entries of the cells of a grid. Those of neighbours in a row are one slice.
#[derive(Debug)]
pub(super) struct CellTable<T> {
    /// Index of each cell's first entry, plus one more index at the end.
    starts: Vec<u32>,
    entries: Vec<T>,
}

impl<T> CellTable<T> {
    /// Sorts entries by their cells; those of a cell keep their order.
    fn new(cells: usize, mut entries: Vec<(u32, T)>) -> Self {
        entries.sort_by_key(|(cell, _)| *cell);
        let mut starts = vec![0; cells + 1];
        entries.iter().for_each(|(cell, _)| starts[*cell as usize + 1] += 1);
        for cell in 0..cells {
            starts[cell + 1] += starts[cell];
        }
        Self { starts, entries: entries.into_iter().map(|(_, entry)| entry).collect() }
    }

    /// Returns the entries of neighbours in a row.
    pub fn of(&self, cells: Range<usize>) -> &[T] {
        &self.entries[self.starts[cells.start] as usize..self.starts[cells.end] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_around_a_point_have_the_cells_at_their_distance() {
        // Five columns and four rows; the point lies in column 1, row 2.
        let grid = CellGrid::over(Vec2::ZERO, Vec2::new(5.0, 4.0) * CELL_M);
        let cells = |point: Vec2, rings: Range<i32>| grid.around(point, rings).flatten().collect::<Vec<_>>();
        let point = Vec2::new(1.5, 2.5) * CELL_M;
        assert_eq!(cells(point, 0..1), [11]);
        assert_eq!(cells(point, 1..2), [5, 6, 7, 10, 12, 15, 16, 17]);
        assert_eq!(cells(point, 2..4), [0, 1, 2, 3, 4, 8, 9, 13, 14, 18, 19]);
        assert_eq!(cells(point, 0..9), (0..20).collect::<Vec<_>>());
        assert_eq!(cells(Vec2::new(-1.5, -0.5) * CELL_M, 2..3), [0, 5]);
    }

    #[test]
    fn an_entry_is_in_each_cell_that_its_box_touches() {
        let grid = CellGrid::over(Vec2::ZERO, Vec2::new(3.0, 2.0) * CELL_M);
        let boxed = |from: [f32; 2], to: [f32; 2]| (Vec2::from(from) * CELL_M, Vec2::from(to) * CELL_M);
        let entries = [(boxed([0.5, 0.5], [1.5, 1.5]), 'a'), (boxed([1.2, 0.2], [9.0, 0.4]), 'b')];
        let table = grid.table(entries.into_iter());
        let cells: Vec<String> = (0..grid.cells()).map(|cell| table.of(cell..cell + 1).iter().collect()).collect();
        assert_eq!(cells, ["a", "ab", "b", "a", "a", ""]);
        assert_eq!(table.of(1..3), ['a', 'b', 'b']);
    }
}
