//! Tests of normality. In: residuals, or the deviations of persons. Out: Shapiro and Wilk's W with its p value, and the points
//! of a quantile-quantile plot. With few numbers the test detects only gross departures, with many also harmless ones: it is
//! shown beside the plot and decides nothing.

use super::distributions::{normal_above, normal_quantile};

/// Result of Shapiro and Wilk's test of normality.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalityTest {
    /// Squared correlation of the sorted numbers with the expected values of a normal sample: 1 where they agree.
    pub w: f64,
    /// Probability of a smaller W in normal samples.
    pub p: f64,
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Computes Shapiro and Wilk's test with Royston's approximation and coefficients (Royston 1995). `None` for fewer than 3
/// numbers, more than 5000, or equal ones.
pub fn shapiro_wilk(numbers: &[f64]) -> Option<NormalityTest> {
    let n = numbers.len();
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    if !(3..=5000).contains(&n) || sorted[n - 1] - sorted[0] <= 1e-12 * sorted[n - 1].abs().max(sorted[0].abs()) {
        return None;
    }
    let size = n as f64;
    let weights = weights(n);
    let mean = sorted.iter().sum::<f64>() / size;
    let squares: f64 = sorted.iter().map(|x| (x - mean).powi(2)).sum();
    let product: f64 = sorted.iter().zip(&weights).map(|(x, weight)| x * weight).sum();
    let w = (product * product / squares).min(1.0);
    let unlike = (1.0 - w).max(1e-19);
    if n == 3 {
        let p = 6.0 / std::f64::consts::PI * (w.sqrt().asin() - 0.75_f64.sqrt().asin());
        return Some(NormalityTest { w, p: p.clamp(0.0, 1.0) });
    }
    let log_n = size.ln();
    let (y, mean, deviation) = if n <= 11 {
        let gamma = polynomial(&[-2.273, 0.459], size);
        if unlike.ln() >= gamma {
            return Some(NormalityTest { w, p: 1e-99 });
        }
        (
            -(gamma - unlike.ln()).ln(),
            polynomial(&[0.544, -0.399_78, 0.025_054, -6.714e-4], size),
            polynomial(&[1.382_2, -0.778_57, 0.062_767, -0.002_032_2], size).exp(),
        )
    } else {
        (
            unlike.ln(),
            polynomial(&[-1.586_1, -0.310_82, -0.083_751, 0.003_891_5], log_n),
            polynomial(&[-0.480_3, -0.082_676, 0.003_030_2], log_n).exp(),
        )
    };
    Some(NormalityTest { w, p: normal_above((y - mean) / deviation) })
}

/// Returns the weights of the sorted numbers: expected values of a normal sample, with Royston's correction at the ends.
fn weights(n: usize) -> Vec<f64> {
    if n == 3 {
        return vec![-0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt()];
    }
    let expected: Vec<f64> = (1..=n).map(|i| normal_quantile((i as f64 - 0.375) / (n as f64 + 0.25))).collect();
    let sum: f64 = expected.iter().map(|m| m * m).sum();
    let root = 1.0 / (n as f64).sqrt();
    let last = polynomial(&[0.0, 0.221_157, -0.147_981, -2.071_19, 4.434_685, -2.706_056], root)
        + expected[n - 1] / sum.sqrt();
    let next = polynomial(&[0.0, 0.042_981, -0.293_762, -1.752_461, 5.682_633, -3.582_633], root)
        + expected[n - 2] / sum.sqrt();
    let ends: &[f64] = if n > 5 { &[last, next] } else { &[last] };
    let at = |k: usize| expected[n - 1 - k];
    let left = sum - 2.0 * (0..ends.len()).map(|k| at(k) * at(k)).sum::<f64>();
    let share = 1.0 - 2.0 * ends.iter().map(|a| a * a).sum::<f64>();
    let scale = (left / share).sqrt();
    let mut weights: Vec<f64> = expected.iter().map(|m| m / scale).collect();
    for (k, a) in ends.iter().enumerate() {
        (weights[k], weights[n - 1 - k]) = (-a, *a);
    }
    weights
}

/// Returns the points of a quantile-quantile plot: the normal quantile, and the sorted number in standard deviations from the
/// mean. Empty if all numbers are equal.
pub fn quantiles(numbers: &[f64]) -> Vec<[f64; 2]> {
    let n = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / n;
    let deviation = (numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    if deviation.is_nan() || deviation <= 0.0 {
        return Vec::new();
    }
    let mut sorted: Vec<f64> = numbers.iter().map(|x| (x - mean) / deviation).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.into_iter().zip(1..).map(|(x, i)| [normal_quantile((f64::from(i) - 0.5) / n), x]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected: R's shapiro.test for the same numbers.
    #[test]
    fn the_test_matches_r() {
        let few = [2.1, 3.4, 1.9];
        let eight = [2.1, 3.4, 1.9, 5.5, 2.8, 3.1, 2.2, 9.7];
        // Squares of 1 to 20: skewed.
        let twenty: Vec<f64> = (1..=20).map(|i| f64::from(i * i)).collect();
        for (numbers, w, p) in [
            (&few[..], 0.847_989_949_7, 0.235_089_234_2),
            (&eight[..5], 0.874_937_450_1, 0.286_996_141_6),
            (&eight[..], 0.749_280_863_5, 0.008_020_148_22),
            (&twenty[..], 0.906_130_628_5, 0.053_809_588_83),
        ] {
            let found = shapiro_wilk(numbers).unwrap();
            assert!((found.w / w - 1.0).abs() < 1e-6 && (found.p / p - 1.0).abs() < 1e-4, "{found:?} {w} {p}");
        }
        assert_eq!((shapiro_wilk(&[1.0, 2.0]), shapiro_wilk(&[3.0; 9])), (None, None));
    }

    #[test]
    fn quantiles_of_a_straight_line_rise_and_have_their_middle_at_0() {
        let points = quantiles(&[3.0, 1.0, 2.0]);
        // Three numbers have the shares 1/6, 1/2, 5/6, with normal quantiles of -0.9674, 0, 0.9674 by table.
        let known = [[-0.967_421_566, -1.0], [0.0, 0.0], [0.967_421_566, 1.0]];
        for (found, known) in points.iter().zip(known) {
            assert!((found[0] - known[0]).abs() < 1e-8 && (found[1] - known[1]).abs() < 1e-12, "{points:?}");
        }
        assert!(quantiles(&[1.0; 4]).is_empty());
    }
}
