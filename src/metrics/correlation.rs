//! Correlation of two lists of numbers. In: pairs. Out: the correlation of Bravais and Pearson.

/// Returns the correlation of pairs, -1 to 1; `None` if one side does not vary, or for fewer than two pairs.
pub fn correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let n = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
    let (mean_x, mean_y) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let [xy, xx, yy] = pairs.iter().fold([0.0; 3], |[xy, xx, yy], (x, y)| {
        let (x, y) = (x - mean_x, y - mean_y);
        [xy + x * y, xx + x * x, yy + y * y]
    });
    // Rounding errors of equal numbers are not variation.
    let varies = |sum: f64, mean: f64| sum > 1e-12 * n * (1.0 + mean * mean);
    (pairs.len() > 1 && varies(xx, mean_x) && varies(yy, mean_y)).then(|| xy / (xx * yy).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correlation_matches_a_hand_calculation() {
        // Deviations (-2, -1, 0, 1, 2) and (-1, -2, 1, 0, 2): 2 + 2 + 0 + 0 + 4 = 8 of sqrt(10 x 10).
        let pairs = [(1.0, 2.0), (2.0, 1.0), (3.0, 4.0), (4.0, 3.0), (5.0, 5.0)];
        assert!((correlation(&pairs).unwrap() - 0.8).abs() < 1e-12);
        let turned: Vec<(f64, f64)> = pairs.iter().map(|(x, y)| (*x, -y)).collect();
        assert!((correlation(&turned).unwrap() + 0.8).abs() < 1e-12);
    }

    #[test]
    fn values_without_variation_have_no_correlation() {
        assert_eq!(correlation(&[(0.1, 1.0), (0.1, 2.0), (0.1, 3.0)]), None);
        assert_eq!(correlation(&[(0.1, 1.0)]), None);
        assert_eq!(correlation(&[]), None);
    }
}
