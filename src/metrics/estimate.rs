//! Means with intervals. In: one number for each ring. Out: the mean and its 95 % interval by the bootstrap (Efron 1979,
//! percentiles of resampled means). The random stream is seeded, so that the same numbers give the same interval.

use crate::rng;
use serde::Serialize;

/// A mean and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    pub mean: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Estimate {
    /// Number of resamples of a bootstrap: the error of the interval's ends is then 2 % of the interval.
    pub const RESAMPLES: usize = 2000;

    /// Estimates the mean of some numbers; `None` without numbers.
    pub fn of(numbers: &[f64]) -> Option<Self> {
        let n = numbers.len();
        if n == 0 {
            return None;
        }
        let mean = numbers.iter().sum::<f64>() / n as f64;
        let mut stream = rng::stream(n as u64, "bootstrap");
        let mut resample = || (0..n).map(|_| numbers[stream.index(n)]).sum::<f64>() / n as f64;
        let mut means: Vec<f64> = (0..Self::RESAMPLES).map(|_| resample()).collect();
        means.sort_by(f64::total_cmp);
        let at = |share: f64| means[(share * (Self::RESAMPLES - 1) as f64).round() as usize];
        Some(Self { mean, low: at(0.025), high: at(0.975) })
    }
}

impl Estimate {
    /// Estimates the mean over the same rings for several training seeds, `numbers[seed][ring]`, with an interval that
    /// resamples seeds and rings. With one seed only the rings count. `None` without numbers.
    pub fn of_seeds(numbers: &[Vec<f64>]) -> Option<Self> {
        let rings = numbers.iter().map(Vec::len).min().filter(|rings| *rings > 0)?;
        let seeds = numbers.len();
        let sum: f64 = numbers.iter().map(|of_seed| of_seed[..rings].iter().sum::<f64>()).sum();
        let mut stream = rng::stream((seeds * rings) as u64, "bootstrap/seeds");
        let mut resample = || {
            let drawn: Vec<usize> = (0..rings).map(|_| stream.index(rings)).collect();
            let of_seed = |seed: usize| drawn.iter().map(|ring| numbers[seed][*ring]).sum::<f64>();
            (0..seeds).map(|_| stream.index(seeds)).map(of_seed).sum::<f64>() / (seeds * rings) as f64
        };
        let mut means: Vec<f64> = (0..Self::RESAMPLES).map(|_| resample()).collect();
        means.sort_by(f64::total_cmp);
        let at = |share: f64| means[(share * (Self::RESAMPLES - 1) as f64).round() as usize];
        Some(Self { mean: sum / (seeds * rings) as f64, low: at(0.025), high: at(0.975) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_normal_numbers_is_1_96_standard_errors() {
        let mut stream = rng::stream(3, "stats");
        let numbers: Vec<f64> = (0..100).map(|_| 5.0 + 2.0 * stream.normal()).collect();
        let estimate = Estimate::of(&numbers).unwrap();
        // 1.96 standard errors of 0.2 on either side; the sample's own deviation is within 15 % of 2.
        assert!((estimate.high - estimate.low - 0.784).abs() < 0.15, "{estimate:?}");
        assert!(estimate.low < estimate.mean && estimate.mean < estimate.high);
    }

    #[test]
    fn the_interval_over_training_seeds_covers_their_differences() {
        // Five seeds with means 1 to 5, and rings that do not differ: the mean of five draws from 1..5 has a standard error of
        // sqrt(2 / 5) = 0.632 (the variance of 1..5 is 2).
        let numbers: Vec<Vec<f64>> = (1..=5).map(|mean| vec![f64::from(mean); 100]).collect();
        let estimate = Estimate::of_seeds(&numbers).unwrap();
        assert_eq!(estimate.mean, 3.0);
        assert!((estimate.high - estimate.low - 2.0 * 1.96 * 0.632).abs() < 0.35, "{estimate:?}");
        // One seed: the interval is that over the rings.
        let mut stream = rng::stream(3, "stats");
        let one: Vec<f64> = (0..100).map(|_| 5.0 + 2.0 * stream.normal()).collect();
        let [of, of_seeds] = [Estimate::of(&one).unwrap(), Estimate::of_seeds(&[one]).unwrap()];
        assert!((of.high - of_seeds.high).abs() < 0.08 && (of.low - of_seeds.low).abs() < 0.08);
        assert_eq!(Estimate::of_seeds(&[]), None);
    }

    #[test]
    fn equal_numbers_have_an_interval_of_width_0_and_no_numbers_no_mean() {
        assert_eq!(Estimate::of(&[3.0; 5]), Some(Estimate { mean: 3.0, low: 3.0, high: 3.0 }));
        assert_eq!(Estimate::of(&[]), None);
    }
}
