//! Circles of a display of the surrogate reference task (docs/references.md: secondary-tasks). In: the display's seed, its columns and its target.
//! Out: circles in a field one wide and one high.

use crate::rng;

/// Circle of a display, in shares of the field's width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchCircle {
    /// Centre, from the left and from the top.
    pub centre: [f32; 2],
    /// Diameter as a share of the least distance of two cells.
    pub size: f32,
}

/// Rows of cells, and the least number of cells in a row.
pub const SEARCH_ROWS: usize = 6;
const LEAST_ACROSS: usize = 12;
/// Diameter of an ordinary circle, and the largest of any, as shares of a cell.
const ORDINARY: f32 = 0.5;
const LARGEST: f32 = 0.9;

/// Returns the number of cells in a row of a display with these columns: each column has as many.
pub fn cells_across(columns: u8) -> usize {
    let columns = usize::from(columns.max(1));
    LEAST_ACROSS.div_ceil(columns) * columns
}

/// Returns the circles of a display, one for each cell and each off its cell's middle as far as it stays within. The target is in a random cell of
/// its column.
pub fn search_circles(seed: u64, columns: u8, target_column: u8, size_ratio: f64) -> Vec<SearchCircle> {
    let mut random = rng::stream(seed, "surrogate reference/circles");
    let across = cells_across(columns);
    let in_column = across / usize::from(columns.max(1));
    let target = [usize::from(target_column) * in_column + random.index(in_column), random.index(SEARCH_ROWS)];
    let ordinary = ORDINARY.min(LARGEST / size_ratio as f32);
    let cells = (0..across * SEARCH_ROWS).map(|i| [i % across, i / across]);
    cells
        .map(|cell| {
            let size = if cell == target { ordinary * size_ratio as f32 } else { ordinary };
            let mut place = |k: usize, of: usize| {
                let free = (1.0 - size) / 2.0;
                (cell[k] as f32 + 0.5 + random.uniform_f32(-free, free)) / of as f32
            };
            SearchCircle { centre: [place(0, across), place(1, SEARCH_ROWS)], size }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_circle_is_larger_and_in_its_column() {
        for (columns, target_column, ratio) in [(2, 1, 1.1), (5, 0, 1.4), (6, 3, 2.0), (12, 11, 3.0)] {
            for seed in 0..50 {
                let circles = search_circles(seed, columns, target_column, ratio);
                assert_eq!(circles.len(), cells_across(columns) * 6);
                let most = circles.iter().map(|circle| circle.size).fold(0.0, f32::max);
                let targets: Vec<_> = circles.iter().filter(|circle| circle.size == most).collect();
                assert_eq!(targets.len(), 1);
                assert_eq!((targets[0].centre[0] * f32::from(columns)) as u8, target_column);
                let other = circles.iter().find(|circle| circle.size < most).unwrap();
                assert!((most / other.size - ratio as f32).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn no_two_circles_overlap() {
        let circles = search_circles(7, 6, 2, 1.8);
        // In units of cells, 12 across and 6 down.
        let at = |circle: &SearchCircle| [circle.centre[0] * 12.0, circle.centre[1] * 6.0];
        for (i, a) in circles.iter().enumerate() {
            for b in &circles[..i] {
                let [[ax, ay], [bx, by]] = [at(a), at(b)];
                assert!((ax - bx).hypot(ay - by) >= (a.size + b.size) / 2.0 - 1e-4);
            }
        }
    }
}
