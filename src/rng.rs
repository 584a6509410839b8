//! Seeded, named random streams. In: a scenario's seed and the name of the user of the stream. Out: a generator independent of
//! all other names, so that adding a tree never changes a vehicle. PCG is used because `rand`'s own `StdRng` may change.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// Returns the random stream of `name`: the same seed and name give the same numbers on every machine.
pub fn stream(seed: u64, name: &str) -> Stream {
    // Hash of the name, so that streams of equal seed are unrelated.
    let hash = fnv_1a(FNV_START, name.as_bytes());
    Stream(Pcg64Mcg::seed_from_u64(seed.rotate_left(32) ^ hash))
}

/// Initial value of a [`fnv_1a`] chain (the authors' offset for 64 bits).
pub const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// Returns the FNV-1a hash of these bytes, chained to the hash of earlier ones.
pub fn fnv_1a(before: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(before, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Returns the hash of a number of 64 bits, chained to the hash of earlier ones: the output of SplitMix64 (Steele et al. 2014) for
/// both. No bit is lost, as each of its steps can be undone. It hashes the numbers of each tick, for which [`fnv_1a`] takes three times as
/// long.
#[inline]
pub fn chained(before: u64, number: u64) -> u64 {
    let mut mixed = before ^ number;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Random stream of one name.
#[derive(Clone, Debug)]
pub struct Stream(Pcg64Mcg);

impl Stream {
    /// Draws from the normal distribution with mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Draws uniformly from `[low, high)`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        use rand::Rng;
        let unit = (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

    /// Draws uniformly from `low` to `high` in single precision.
    pub fn uniform_f32(&mut self, low: f32, high: f32) -> f32 {
        self.uniform(f64::from(low), f64::from(high)) as f32
    }

    /// Draws a whole number from `0..n`; 0 if `n` is 0.
    pub fn index(&mut self, n: usize) -> usize {
        (self.uniform(0.0, n as f64) as usize).min(n.saturating_sub(1))
    }

    /// Draws a uniformly random permutation of `0..n` (Fisher and Yates).
    pub fn permutation(&mut self, n: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        for place in (1..n).rev() {
            order.swap(place, self.index(place + 1));
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_depends_on_seed_and_name_only() {
        let draw = |seed, name| {
            let mut s = stream(seed, name);
            (0..8).map(|_| s.normal().to_bits()).collect::<Vec<_>>()
        };
        assert_eq!(draw(1, "traffic"), draw(1, "traffic"));
        assert_ne!(draw(1, "traffic"), draw(2, "traffic"));
        assert_ne!(draw(1, "traffic"), draw(1, "trees"));
    }

    #[test]
    fn the_first_numbers_never_change() {
        let mut s = stream(7, "traffic");
        assert_eq!(format!("{:.6} {:.6}", s.uniform(0.0, 1.0), s.normal()), "0.725541 0.235657");
    }

    #[test]
    fn normal_numbers_have_mean_0_and_variance_1() {
        let mut s = stream(3, "normal");
        let draws: Vec<f64> = (0..100_000).map(|_| s.normal()).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / draws.len() as f64;
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((variance - 1.0).abs() < 0.02, "{variance}");
    }
}
