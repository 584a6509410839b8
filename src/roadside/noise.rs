//! Smooth seeded noise over the plane, for the height of the ground, colours and woods. In: a seed and a point in units of the wavelength. Out:
//! -1..1. Uses integer hashing and polynomials only, so the bits are the same on every machine.

use glam::{IVec2, Vec2};

/// Returns value noise: smooth, -1..1, features about one unit across.
pub fn value(seed: u64, point: Vec2) -> f32 {
    let cell = point.floor();
    let f = point - cell;
    // Quintic fade, so that slopes (and with them normals) are continuous.
    let fade = f * f * f * (f * (f * 6.0 - Vec2::splat(15.0)) + Vec2::splat(10.0));
    let cell = cell.as_ivec2();
    let corner = |dx, dy| lattice(seed, cell + IVec2::new(dx, dy));
    let near = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * fade.x;
    let far = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * fade.x;
    near + (far - near) * fade.y
}

/// Returns the mean of three octaves of [`value`], each half as large and half as strong; -1..1.
pub fn fractal(seed: u64, point: Vec2) -> f32 {
    // Octaves are shifted so that their lattices do not coincide.
    let octave = |k: u64, scale: f32, shift: f32| value(seed ^ (k << 40), point * scale + Vec2::splat(shift));
    (octave(1, 1.0, 0.0) + octave(2, 2.0, 0.37) * 0.5 + octave(3, 4.0, 0.71) * 0.25) / 1.75
}

/// Returns the value of a lattice point, -1..1 (SplitMix64's mixing).
fn lattice(seed: u64, cell: IVec2) -> f32 {
    let packed = (u64::from(cell.x as u32) << 32) | u64::from(cell.y as u32);
    let mut z = (packed ^ seed).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 40) as f32 / (1u32 << 23) as f32 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_stays_within_one_and_has_no_jumps() {
        let mut before = value(9, Vec2::ZERO);
        for i in 1..4000 {
            let point = Vec2::new(i as f32 * 0.01, i as f32 * -0.007);
            let here = value(9, point);
            assert!((-1.0..=1.0).contains(&here) && (-1.0..=1.0).contains(&fractal(9, point)));
            // The steepest slope of the quintic fade is 1.875 per unit over a range of 2, in two axes.
            assert!((here - before).abs() < 2.0 * 1.875 * 0.017 + 1e-4, "jump at {point}");
            before = here;
        }
    }

    #[test]
    fn different_seeds_give_different_noise() {
        let at = |seed| value(seed, Vec2::new(3.3, 1.2));
        assert_eq!(at(1).to_bits(), at(1).to_bits());
        assert_ne!(at(1).to_bits(), at(2).to_bits());
    }
}
