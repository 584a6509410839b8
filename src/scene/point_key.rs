//! Point in space as the key of an ordered map. In: a cell of a lattice, or the exact bits of a point. Out: one number. Keys are
//! ordered like their three coordinates, x first: meshes are built in this order.
//!
//! The key is one number because comparing an array of three is a function call, and building the cars compares millions of
//! times.

use glam::{IVec3, Vec3};

/// Three 32-bit numbers packed into one, the first in the highest bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PointKey(u128);

impl PointKey {
    /// Creates the key of a lattice cell; negative coordinates come first.
    #[inline]
    pub fn cell(at: IVec3) -> Self {
        // With the sign bit flipped, unsigned order equals signed order.
        let ordered = |v: i32| v.cast_unsigned() ^ (1 << 31);
        Self::packed(ordered(at.x), ordered(at.y), ordered(at.z))
    }

    /// Creates the key of a point from its exact bits, ordered by the bits.
    #[inline]
    pub fn exact(at: Vec3) -> Self {
        Self::packed(at.x.to_bits(), at.y.to_bits(), at.z.to_bits())
    }

    #[inline]
    fn packed(x: u32, y: u32, z: u32) -> Self {
        Self(u128::from(x) << 64 | u128::from(y) << 32 | u128::from(z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_ordered_like_the_coordinates() {
        let numbers = [i32::MIN, -2, -1, 0, 1, i32::MAX];
        let cells: Vec<[i32; 3]> =
            numbers.iter().flat_map(|&x| numbers.map(|y| numbers.map(|z| [x, y, z]))).flatten().collect();
        for a in &cells {
            for b in &cells {
                let [p, q] = [a, b].map(|c| PointKey::cell(IVec3::from_array(*c)));
                assert_eq!(p.cmp(&q), a.cmp(b), "{a:?} {b:?}");
            }
        }
        let points = [-1.5, -0.0, 0.0, 1e-40, 2.0].map(Vec3::splat);
        for a in points {
            for b in points {
                let bits = |p: Vec3| p.to_array().map(f32::to_bits);
                assert_eq!(PointKey::exact(a).cmp(&PointKey::exact(b)), bits(a).cmp(&bits(b)), "{a} {b}");
            }
        }
    }
}
