//! Means with intervals. In: one number for each ring. Out: the mean and its 95 % interval by the bootstrap (Efron 1979,
//! percentiles of resampled means), seeded, so that a table is the same whenever it is made.

use crate::rng;
use serde::Serialize;

/// A mean and its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Estimate {
    /// Resamples of a bootstrap: its own error in the interval's ends is then 2 % of the interval.
    pub const RESAMPLES: usize = 2000;

    /// Of some numbers; `None` of none.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_normal_numbers_is_that_of_the_field() {
        let mut stream = rng::stream(3, "stats");
        let numbers: Vec<f64> = (0..100).map(|_| 5.0 + 2.0 * stream.normal()).collect();
        let estimate = Estimate::of(&numbers).unwrap();
        // 1.96 standard errors of 0.2 on either side; the sample's own deviation is within 15 % of 2.
        assert!((estimate.high - estimate.low - 0.784).abs() < 0.15, "{estimate:?}");
        assert!(estimate.low < estimate.mean && estimate.mean < estimate.high);
    }

    #[test]
    fn equal_numbers_leave_no_doubt_and_none_leave_no_mean() {
        assert_eq!(Estimate::of(&[3.0; 5]), Some(Estimate { mean: 3.0, low: 3.0, high: 3.0 }));
        assert_eq!(Estimate::of(&[]), None);
    }
}
