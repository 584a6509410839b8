//! Arithmetic on many rings at once. In: a seed per ring. Out: [`SimdLanes`] arrays of uniform and normal numbers.
//!
//! A lane is one ring. All arithmetic is on arrays of [`LANES`] `f32`, written as plain loops that the compiler turns into vector
//! instructions. A vector register holds twice as many `f32` as `f64`, and the rounding error (1e-7 of a speed) is far below the noise of
//! the model (6e-3 m/s per step). Only IEEE operations with the same rounding on every machine are used, so that the bits do not depend
//! on the instruction set detected at run time.

use serde::{Deserialize, Serialize};

/// Rings per block: two registers of AVX2, so that the latency of one is hidden behind the other.
pub const LANES: usize = 16;

/// One number for each ring of a block.
pub type SimdLanes = [f32; LANES];

/// Returns a lane of equal numbers.
pub fn splat(x: f32) -> SimdLanes {
    [x; LANES]
}

/// Returns a lane computed ring by ring.
#[inline(always)]
pub fn lane(mut f: impl FnMut(usize) -> f32) -> SimdLanes {
    let mut out = [0.0; LANES];
    for (l, x) in out.iter_mut().enumerate() {
        *x = f(l);
    }
    out
}

/// Work on many numbers that is worth compiling for the machine's widest vectors.
pub trait VectorWork {
    /// Result of the work.
    type Output;

    /// Does the work. Mark it and everything it calls `#[inline(always)]`: code that is not inlined is compiled for narrow vectors. It is
    /// a trait because the compiler may not inline a closure, depending on the division into codegen units (six times slower training,
    /// measured).
    fn run(self) -> Self::Output;
}

/// Runs `work` compiled for the machine's widest vectors. The bits are the same on all machines: no operation is fused or reordered.
#[inline]
pub fn in_wide_vectors<W: VectorWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        fn avx2<W: VectorWork>(work: W) -> W::Output {
            work.run()
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: AVX2 has just been detected.
            return unsafe { avx2(work) };
        }
    }
    work.run()
}

/// A random stream for each lane: xoshiro128++ (Blackman and Vigna 2019), whose steps are 32-bit additions, shifts and exclusive ors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaneRng {
    state: [[u32; LANES]; 4],
}

impl LaneRng {
    /// Returns streams that must be seeded lane by lane before use.
    pub fn new() -> Self {
        Self { state: [[1; LANES]; 4] }
    }

    /// Seeds the stream of one lane.
    pub fn seed(&mut self, lane: usize, seed: u64) {
        // SplitMix64 spreads the seed, so that similar seeds give unrelated streams.
        let mut x = seed;
        for word in &mut self.state {
            x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = x;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            word[lane] = ((z ^ (z >> 31)) >> 16) as u32;
        }
        if self.state.iter().all(|word| word[lane] == 0) {
            self.state[0][lane] = 1;
        }
    }

    /// Copies the stream of `from_lane` of another generator into `lane`.
    pub fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        for (to, from) in self.state.iter_mut().zip(&from.state) {
            to[lane] = from[from_lane];
        }
    }

    #[inline(always)]
    fn next(&mut self) -> [u32; LANES] {
        let [s0, s1, s2, s3] = &mut self.state;
        let mut out = [0; LANES];
        for l in 0..LANES {
            out[l] = s0[l].wrapping_add(s3[l]).rotate_left(7).wrapping_add(s0[l]);
            let t = s1[l] << 9;
            s2[l] ^= s0[l];
            s3[l] ^= s1[l];
            s1[l] ^= s2[l];
            s0[l] ^= s3[l];
            s2[l] ^= t;
            s3[l] = s3[l].rotate_left(11);
        }
        out
    }

    /// Returns uniform numbers in `[0, 1)`.
    #[inline(always)]
    pub fn uniform(&mut self) -> SimdLanes {
        let bits = self.next();
        lane(|l| (bits[l] >> 8) as f32 * (1.0 / 16_777_216.0))
    }

    /// Returns two independent lanes of normal numbers with mean 0 and standard deviation 1 (Box and Muller 1958).
    #[inline(always)]
    pub fn normal_pair(&mut self) -> (SimdLanes, SimdLanes) {
        let (a, b) = (self.next(), self.next());
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            // In (0, 1], so that the logarithm is finite.
            let u = ((a[l] >> 8) + 1) as f32 * (1.0 / 16_777_216.0);
            let radius = (-2.0 * ln(u)).max(0.0).sqrt();
            // An angle within 45 degrees of an axis; three more bits choose axis and signs.
            let theta = ((b[l] >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0) * std::f32::consts::FRAC_PI_4;
            let (sin, cos) = sin_cos(theta);
            let swap = b[l] & 1 != 0;
            let (p, q) = if swap { (sin, cos) } else { (cos, sin) };
            x[l] = f32::from_bits((radius * p).to_bits() ^ ((b[l] & 2) << 30));
            y[l] = f32::from_bits((radius * q).to_bits() ^ ((b[l] & 4) << 29));
        }
        (x, y)
    }
}

impl Default for LaneRng {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the hyperbolic tangent, with an absolute error below 1e-6.
#[inline(always)]
pub fn tanh(x: f32) -> f32 {
    // From 10 on it is 1 in single precision.
    let x = x.clamp(-10.0, 10.0);
    1.0 - 2.0 / (exp(2.0 * x) + 1.0)
}

/// Returns e to the power of a number within ±80, with a relative error below 1e-6.
#[inline(always)]
fn exp(x: f32) -> f32 {
    let halvings = (x * std::f32::consts::LOG2_E + 0.5).floor();
    // ln 2 in two parts, so that the difference loses no digits; then Taylor's series to the sixth power within ±ln 2 / 2.
    let r = (x - halvings * 0.693_359_4) + halvings * 2.121_944_4e-4;
    let series = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r / 720.0)))));
    series * f32::from_bits(((halvings as i32 + 127) << 23) as u32)
}

/// Returns the natural logarithm of a positive normal number, with an absolute error below 1e-6.
#[inline(always)]
fn ln(x: f32) -> f32 {
    // Mantissa in [1/sqrt2, sqrt2): then ln m = 2 artanh((m-1)/(m+1)), four terms.
    let shifted = x.to_bits().wrapping_sub(0x3f35_04f3);
    let exponent = (shifted as i32) >> 23;
    let m = f32::from_bits((shifted & 0x007f_ffff).wrapping_add(0x3f35_04f3));
    let t = (m - 1.0) / (m + 1.0);
    let t2 = t * t;
    let series = t * (2.0 + t2 * (2.0 / 3.0 + t2 * (2.0 / 5.0 + t2 * (2.0 / 7.0))));
    exponent as f32 * std::f32::consts::LN_2 + series
}

/// Returns sine and cosine of an angle within 45 degrees of 0 by their series, with an error below 4e-7.
#[inline(always)]
fn sin_cos(x: f32) -> (f32, f32) {
    let x2 = x * x;
    let sin = x * (1.0 - x2 / 6.0 * (1.0 - x2 / 20.0 * (1.0 - x2 / 42.0)));
    let cos = 1.0 - x2 / 2.0 * (1.0 - x2 / 12.0 * (1.0 - x2 / 30.0 * (1.0 - x2 / 56.0)));
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seeded() -> LaneRng {
        let mut rng = LaneRng::new();
        (0..LANES).for_each(|l| rng.seed(l, l as u64));
        rng
    }

    #[test]
    fn the_hyperbolic_tangent_equals_that_of_the_library() {
        for k in -30_000..=30_000 {
            let x = k as f32 * 0.0007;
            assert!((f64::from(tanh(x)) - f64::from(x).tanh()).abs() < 1e-6, "{x}");
        }
        assert!(tanh(0.0) == 0.0 && tanh(300.0) == 1.0 && tanh(-300.0) == -1.0);
    }

    #[test]
    fn logarithm_sine_and_cosine_equal_those_of_the_library() {
        for i in 1..=4096 {
            let x = i as f32 / 4096.0;
            assert!((ln(x) - x.ln()).abs() < 1e-6, "{x}");
            let angle = (x - 0.5) * std::f32::consts::FRAC_PI_2;
            let (sin, cos) = sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 4e-7 && (cos - angle.cos()).abs() < 4e-7, "{angle}");
        }
        assert!((ln(1.0 / 16_777_216.0) - (1.0_f32 / 16_777_216.0).ln()).abs() < 2e-6);
    }

    #[test]
    fn normal_numbers_have_the_moments_and_tails_of_the_normal_distribution() {
        let mut rng = seeded();
        let mut draws = Vec::new();
        for _ in 0..20_000 {
            let (a, b) = rng.normal_pair();
            draws.extend(a.into_iter().chain(b).map(f64::from));
        }
        let n = draws.len() as f64;
        let moment = |k: i32| draws.iter().map(|x| x.powi(k)).sum::<f64>() / n;
        // 640,000 draws: standard errors 0.00125, 0.0018, 0.0048, 0.012.
        assert!(moment(1).abs() < 0.005, "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < 0.007, "{}", moment(2));
        assert!(moment(3).abs() < 0.02, "{}", moment(3));
        assert!((moment(4) - 3.0).abs() < 0.05, "{}", moment(4));
        let beyond = |z: f64| draws.iter().filter(|x| x.abs() > z).count() as f64 / n;
        assert!((beyond(1.96) - 0.05).abs() < 0.001, "{}", beyond(1.96));
        assert!((beyond(3.0) - 0.0027).abs() < 0.0003, "{}", beyond(3.0));
    }

    #[test]
    fn the_two_numbers_of_a_pair_and_neighbouring_lanes_are_unrelated() {
        let mut rng = seeded();
        let (mut pair, mut lanes, mut steps) = (0.0, 0.0, 0.0);
        let mut before = [0.0; LANES];
        for _ in 0..20_000 {
            let (a, b) = rng.normal_pair();
            for l in 0..LANES {
                pair += f64::from(a[l] * b[l]);
                lanes += f64::from(a[l] * a[(l + 1) % LANES]);
                steps += f64::from(a[l] * before[l]);
            }
            before = a;
        }
        for sum in [pair, lanes, steps] {
            assert!((sum / 320_000.0).abs() < 0.007, "{}", sum / 320_000.0);
        }
    }

    #[test]
    fn a_lane_depends_on_its_own_seed_only() {
        let (mut a, mut b) = (seeded(), LaneRng::new());
        (0..LANES).for_each(|l| b.seed(l, 99 + l as u64));
        b.seed(3, 3);
        for _ in 0..10 {
            assert_eq!(a.normal_pair().0[3].to_bits(), b.normal_pair().0[3].to_bits());
        }
    }
}
