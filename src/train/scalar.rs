//! Arithmetic of a network in `f32` for training and in `f64` for tests with finite differences.

use super::simd::{VectorWork, in_wide_vectors};
use std::{
    iter::Sum,
    ops::{Add, AddAssign, Div, Mul, Neg, Sub},
};

/// The arithmetic that training needs.
pub trait SimdFloat:
    Copy
    + Default
    + Send
    + Sync
    + PartialOrd
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Sum
    + 'static
{
    /// Converts to the nearest number of this type.
    fn of(x: f64) -> Self;
    /// Converts this number to `f64`.
    fn f64(self) -> f64;
    /// Returns the exponential function.
    fn exp(self) -> Self;
    /// Replaces every number by its tanh.
    fn tanh_all(xs: &mut [Self]);
}

impl SimdFloat for f32 {
    fn of(x: f64) -> Self {
        x as Self
    }

    fn f64(self) -> f64 {
        f64::from(self)
    }

    fn exp(self) -> Self {
        self.exp()
    }

    fn tanh_all(xs: &mut [Self]) {
        tanh_f32(xs);
    }
}

impl SimdFloat for f64 {
    fn of(x: f64) -> Self {
        x
    }

    fn f64(self) -> f64 {
        self
    }

    fn exp(self) -> Self {
        self.exp()
    }

    fn tanh_all(xs: &mut [Self]) {
        xs.iter_mut().for_each(|x| *x = x.tanh());
    }
}

/// Computes tanh x = 1 - 2/(exp(2x) + 1) in vectors with an error below 2e-7. The library's tanh takes ten times as long.
fn tanh_f32(xs: &mut [f32]) {
    in_wide_vectors(TanhOfAll(xs));
}

/// Numbers to be replaced by their tanh.
struct TanhOfAll<'a>(&'a mut [f32]);

impl VectorWork for TanhOfAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for x in self.0 {
            // Beyond 9, tanh is 1 except for the last bit. A NaN stays a NaN.
            let z = x.clamp(-9.0, 9.0) * (2.0 * std::f32::consts::LOG2_E);
            // 2^z = 2^n 2^f: adding and subtracting 1.5 * 2^23 rounds to the nearest integer.
            let shifted = z + 12_582_912.0;
            let n = shifted - 12_582_912.0;
            let f = (z - n) * std::f32::consts::LN_2;
            let series = 1.0
                + f * (1.0
                    + f * (1.0 / 2.0 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0))))));
            let scale = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
            *x = 1.0 - 2.0 / (series * scale + 1.0);
        }
    }
}
