//! Distributions of some numbers. In: values. Out: mean, deviation, quantiles, kurtosis and distances, or `None` where there are too few.

/// Returns the mean; `None` without values.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Returns the mean of a power of the deviations from the mean.
fn central(values: &[f64], power: i32) -> Option<f64> {
    let middle = mean(values)?;
    Some(values.iter().map(|value| (value - middle).powi(power)).sum::<f64>() / values.len() as f64)
}

/// Returns the standard deviation (N); `None` without values.
pub(super) fn deviation(values: &[f64]) -> Option<f64> {
    Some(central(values, 2)?.sqrt())
}

/// Returns the standard deviation of the logarithms (N-1), as of a sample of persons; `None` below two values.
pub(super) fn deviation_of_logs(values: &[f64]) -> Option<f64> {
    let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
    let n = logs.len() as f64;
    (logs.len() > 1).then(|| (central(&logs, 2).unwrap_or_default() * n / (n - 1.0)).sqrt())
}

/// Returns the kurtosis, 3 for a normal distribution; `None` without variation.
pub(super) fn kurtosis(values: &[f64]) -> Option<f64> {
    let variance = central(values, 2)?;
    (variance > 0.0).then(|| central(values, 4).unwrap_or_default() / (variance * variance))
}

/// Returns the value below which a share of the sorted values lies, interpolated between the nearest two; `None` without values.
pub(super) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let at = share * sorted.len().checked_sub(1)? as f64;
    let below = sorted[at.floor() as usize];
    Some(below + (at - at.floor()) * (sorted[at.ceil() as usize] - below))
}

/// Returns the median of some values.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    quantile(&values, 0.5)
}

/// Returns the largest difference of the distribution of sorted values to one given by its quantiles at even shares from 0 to 1
/// (Kolmogorov and Smirnov), 0 to 1; between the quantiles the distribution is linear.
pub(super) fn distance_to_quantiles(sorted: &[f64], quantiles: &[f64]) -> Option<f64> {
    let steps = quantiles.len().checked_sub(1)? as f64;
    let share_below = |value: f64| {
        let above = quantiles.partition_point(|quantile| *quantile <= value);
        if above == 0 || above == quantiles.len() {
            return if above == 0 { 0.0 } else { 1.0 };
        }
        let [low, high] = [quantiles[above - 1], quantiles[above]];
        (above as f64 - 1.0 + (value - low) / (high - low)) / steps
    };
    let n = sorted.len() as f64;
    let distance = |(i, value): (usize, &f64)| {
        let expected = share_below(*value);
        (expected - i as f64 / n).abs().max((expected - (i + 1) as f64 / n).abs())
    };
    sorted.iter().enumerate().map(distance).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_and_moments_match_a_hand_calculation() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quantile(&sorted, 0.5), Some(3.0));
        assert!((quantile(&sorted, 0.9).unwrap() - 6.8).abs() < 1e-12);
        assert_eq!((quantile(&sorted, 1.0), quantile(&[], 0.5)), (Some(8.0), None));
        // Deviations -1, -1, 1, 1: variance 1, fourth moment 1.
        assert_eq!((deviation(&[1.0, 1.0, 3.0, 3.0]), kurtosis(&[1.0, 1.0, 3.0, 3.0])), (Some(1.0), Some(1.0)));
        assert_eq!(kurtosis(&[2.0, 2.0]), None);
        // Logarithms 0 and 1: SD of a sample 1/sqrt(2).
        assert!((deviation_of_logs(&[1.0, 1f64.exp()]).unwrap() - 0.5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_distance_of_a_shifted_even_distribution_is_its_shift() {
        let quantiles: Vec<f64> = (0..=40).map(|i| f64::from(i) / 4.0).collect();
        let values = |shift: f64| (0..1000).map(|i| (f64::from(i) + 0.5) / 100.0 + shift).collect::<Vec<f64>>();
        assert!(distance_to_quantiles(&values(0.0), &quantiles).unwrap() < 0.001);
        assert!((distance_to_quantiles(&values(2.0), &quantiles).unwrap() - 0.2).abs() < 0.001);
        assert_eq!(distance_to_quantiles(&[], &quantiles), None);
    }
}
