//! Products of the small matrices of a small network: hundreds of rows by 64 columns. In and out: row-major slices.
//!
//! Blocks of rows by `COLUMNS` results stay in registers during the sum. A library for large matrices spends three quarters of its time
//! on copying blocks here (measured: matrixmultiply 0.3 at 500 x 64 x 64). Operations are neither fused nor reordered by machine, so that
//! the bits are the same on all machines.

use super::scalar::SimdFloat;

/// Columns of a block of results: one register of AVX-512 in `f32`, two of AVX2.
const COLUMNS: usize = 16;
/// Rows of a block, so that half of AVX2's sixteen registers hold sums.
const ROWS: usize = 4;
/// Rows of a block with AVX-512, which has twice as many registers, each twice as wide.
#[cfg(target_arch = "x86_64")]
const ROWS_AVX512: usize = 12;

/// A row-major matrix or its transpose.
#[derive(Clone, Copy, Debug)]
pub struct Matrix<'a, T> {
    data: &'a [T],
    rows: usize,
    columns: usize,
    transposed: bool,
}

impl<'a, T: SimdFloat> Matrix<'a, T> {
    /// Returns a matrix whose rows have `columns` numbers.
    pub fn new(data: &'a [T], columns: usize) -> Self {
        Self { rows: data.len() / columns, data, columns, transposed: false }
    }

    /// Returns the transpose without copying.
    pub fn t(self) -> Self {
        Self { rows: self.columns, columns: self.rows, transposed: !self.transposed, ..self }
    }

    /// Copies the numbers into contiguous rows.
    fn copied(self) -> Vec<T> {
        let (down, right) = self.strides();
        (0..self.rows * self.columns).map(|i| self.data[i / self.columns * down + i % self.columns * right]).collect()
    }

    /// Returns the strides between neighbours in a column and in a row.
    fn strides(&self) -> (usize, usize) {
        if self.transposed { (1, self.rows) } else { (self.columns, 1) }
    }
}

/// Computes `c += a b`.
///
/// # Panics
/// Panics if the sizes do not fit together.
pub fn add_product<T: SimdFloat>(a: Matrix<'_, T>, b: Matrix<'_, T>, c: &mut [T]) {
    assert!(a.columns == b.rows && a.rows * b.columns == c.len(), "{} x {}: {}", a.rows, b.columns, c.len());
    if a.transposed && b.columns < COLUMNS && a.rows >= COLUMNS {
        // For few columns, such as a gradient by the last layer's weights, the transposed product has longer rows.
        let mut turned = vec![T::default(); c.len()];
        add_product(b.t(), a.t(), &mut turned);
        for (i, x) in turned.into_iter().enumerate() {
            c[i % a.rows * b.columns + i / a.rows] += x;
        }
        return;
    }
    let copy;
    let right = if b.transposed {
        copy = b.copied();
        &copy
    } else {
        b.data
    };
    multiply_wide(a, right, b.columns, c);
}

/// Runs [`multiply`] compiled for the widest vectors of this machine. [`super::simd::in_wide_vectors`] does not support AVX-512.
fn multiply_wide<T: SimdFloat>(a: Matrix<'_, T>, b: &[T], columns: usize, c: &mut [T]) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f")]
        fn avx512<T: SimdFloat>(a: Matrix<'_, T>, b: &[T], columns: usize, c: &mut [T]) {
            multiply::<T, ROWS_AVX512>(a, b, columns, c);
        }
        #[target_feature(enable = "avx2")]
        fn avx2<T: SimdFloat>(a: Matrix<'_, T>, b: &[T], columns: usize, c: &mut [T]) {
            multiply::<T, ROWS>(a, b, columns, c);
        }
        if std::arch::is_x86_feature_detected!("avx512f") {
            // SAFETY: AVX-512 has just been detected.
            unsafe { avx512(a, b, columns, c) };
            return;
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 has just been detected.
            unsafe { avx2(a, b, columns, c) };
            return;
        }
    }
    multiply::<T, ROWS>(a, b, columns, c);
}

#[inline(always)]
fn multiply<T: SimdFloat, const R: usize>(a: Matrix<'_, T>, b: &[T], columns: usize, c: &mut [T]) {
    let whole = columns / COLUMNS * COLUMNS;
    let even = a.rows / R * R;
    let rest = even + (a.rows - even) / ROWS * ROWS;
    for j in (0..whole).step_by(COLUMNS) {
        for i in (0..even).step_by(R) {
            block::<T, R>(a, i, b, columns, j, c);
        }
        for i in (even..rest).step_by(ROWS) {
            block::<T, ROWS>(a, i, b, columns, j, c);
        }
        for i in rest..a.rows {
            block::<T, 1>(a, i, b, columns, j, c);
        }
    }
    for j in whole..columns {
        column(a, b, columns, j, c);
    }
}

/// Adds `R` rows from `i` and `COLUMNS` columns from `j`.
#[inline(always)]
fn block<T: SimdFloat, const R: usize>(a: Matrix<'_, T>, i: usize, b: &[T], columns: usize, j: usize, c: &mut [T]) {
    let mut sums = [[T::default(); COLUMNS]; R];
    // Indices instead of iterators or array functions: the compiler may not inline `zip` or `from_fn` here, which takes six to ten times
    // as long (measured without link-time optimisation between crates). Slices are cut to length outside of the loop, because an index
    // check in it takes as long as the sums.
    if a.transposed {
        for k in 0..a.columns {
            let row: &[T; COLUMNS] = b[k * columns + j..].first_chunk().expect("a whole block of columns");
            let xs: &[T; R] = a.data[k * a.rows + i..].first_chunk().expect("a whole block of rows");
            for r in 0..R {
                for l in 0..COLUMNS {
                    sums[r][l] += xs[r] * row[l];
                }
            }
        }
    } else {
        let mut rows: [&[T]; R] = [&[]; R];
        for (r, row) in rows.iter_mut().enumerate() {
            *row = &a.data[(i + r) * a.columns..][..a.columns];
        }
        for k in 0..a.columns {
            let row: &[T; COLUMNS] = b[k * columns + j..].first_chunk().expect("a whole block of columns");
            for r in 0..R {
                let x = rows[r][k];
                for l in 0..COLUMNS {
                    sums[r][l] += x * row[l];
                }
            }
        }
    }
    for r in 0..R {
        let out: &mut [T; COLUMNS] = c[(i + r) * columns + j..].first_chunk_mut().expect("a whole block of columns");
        for l in 0..COLUMNS {
            out[l] += sums[r][l];
        }
    }
}

/// Adds one column; each element is a sum of `COLUMNS` partial sums, so that it is vectorised as well.
#[inline(always)]
fn column<T: SimdFloat>(a: Matrix<'_, T>, b: &[T], columns: usize, j: usize, c: &mut [T]) {
    let right: Vec<T> = (0..a.columns).map(|k| b[k * columns + j]).collect();
    // Indices for the same reason as in `block`.
    if a.transposed {
        for i in 0..a.rows {
            let mut sum = T::default();
            for (k, y) in right.iter().enumerate() {
                sum += a.data[k * a.rows + i] * *y;
            }
            c[i * columns + j] += sum;
        }
        return;
    }
    let whole = a.columns / COLUMNS * COLUMNS;
    for i in 0..a.rows {
        let left = &a.data[i * a.columns..(i + 1) * a.columns];
        let mut sums = [T::default(); COLUMNS];
        let mut tail = T::default();
        for k in whole..a.columns {
            tail += left[k] * right[k];
        }
        for first in (0..whole).step_by(COLUMNS) {
            let x: &[T; COLUMNS] = left[first..].first_chunk().expect("a whole block");
            let y: &[T; COLUMNS] = right[first..].first_chunk().expect("a whole block");
            for k in 0..COLUMNS {
                sums[k] += x[k] * y[k];
            }
        }
        let mut sum = T::default();
        for part in sums {
            sum += part;
        }
        c[i * columns + j] += sum + tail;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn products_of_all_shapes_and_transposes_equal_the_definition() {
        let mut stream = rng::stream(1, "matrix");
        for (m, k, n) in [(1, 1, 1), (9, 5, 16), (7, 64, 33), (64, 21, 1), (4, 50, 64), (6, 3, 20), (17, 17, 5)] {
            let a: Vec<f64> = (0..m * k).map(|_| stream.normal()).collect();
            let b: Vec<f64> = (0..k * n).map(|_| stream.normal()).collect();
            let expected = |i: usize, j: usize| 1.0 + (0..k).map(|x| a[i * k + x] * b[x * n + j]).sum::<f64>();
            let (plain_a, plain_b) = (Matrix::new(&a, k), Matrix::new(&b, n));
            let (turned_a, turned_b) = (plain_a.t().copied(), plain_b.t().copied());
            for a in [plain_a, Matrix::new(&turned_a, m).t()] {
                for b in [plain_b, Matrix::new(&turned_b, k).t()] {
                    let mut c = vec![1.0; m * n];
                    add_product(a, b, &mut c);
                    for (i, c) in c.iter().enumerate() {
                        assert!((c - expected(i / n, i % n)).abs() < 1e-12, "{m} {k} {n}");
                    }
                }
            }
        }
    }
}
