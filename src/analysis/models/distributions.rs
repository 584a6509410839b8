//! Distributions for tests and intervals: normal, Student's t, beta. In: a number. Out: a probability, or a quantile. Pure
//! functions of `f64`, with at least ten digits where a probability is above 1e-100.

use std::f64::consts::PI;

/// Coefficients of Lanczos' approximation with g = 7 and nine terms (Lanczos 1964).
const LANCZOS: [f64; 9] = [
    0.999_999_999_999_809_9,
    676.520_368_121_885_1,
    -1_259.139_216_722_402_8,
    771.323_428_777_653_1,
    -176.615_029_162_140_6,
    12.507_343_278_686_905,
    -0.138_571_095_265_720_12,
    9.984_369_578_019_572e-6,
    1.505_632_735_149_311_6e-7,
];

/// Returns the logarithm of the gamma function of a positive number.
pub fn ln_gamma(x: f64) -> f64 {
    if x < 0.5 {
        return (PI / (PI * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let sum = LANCZOS[1..].iter().zip(1..).fold(LANCZOS[0], |sum, (c, i)| sum + c / (x + f64::from(i)));
    let t = x + 7.5;
    0.5 * (2.0 * PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// Returns the share of a beta distribution with shapes `a` and `b` below `x` (0 to 1): the regularised incomplete beta
/// function, by its continued fraction.
pub fn beta_cdf(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    // The fraction converges fast on this side of the mean.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_cdf(1.0 - x, b, a);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    let tiny = |v: f64| if v.abs() < 1e-300 { 1e-300 } else { v };
    let (mut c, mut d) = (1.0, 1.0 / tiny(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in 1..500 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = fraction;
        for term in [even, odd] {
            d = 1.0 / tiny(1.0 + term * d);
            c = tiny(1.0 + term / c);
            fraction *= c * d;
        }
        if (fraction / before - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * fraction
}

/// Solves `of(x) = level` by bisection, for a function that rises from below `level` at `low` to above it at `high`.
fn solved(mut low: f64, mut high: f64, level: f64, of: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if of(middle) < level { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns the 95 % interval of a proportion with `hits` of `n` (Clopper 1934).
pub fn share_interval(hits: usize, n: usize) -> [f64; 2] {
    let (k, n) = (hits as f64, n as f64);
    let low = if hits == 0 { 0.0 } else { solved(0.0, 1.0, 0.025, |x| beta_cdf(x, k, n - k + 1.0)) };
    let high = if k >= n { 1.0 } else { solved(0.0, 1.0, 0.975, |x| beta_cdf(x, k + 1.0, n - k)) };
    [low, high]
}

/// Returns the two-sided p value of `t` with `df` degrees of freedom.
pub fn student_p(t: f64, df: f64) -> f64 {
    beta_cdf(df / (df + t * t), 0.5 * df, 0.5)
}

/// Returns the two-sided critical value of Student's t for `p` (0 to 1): 2.228 for 0.05 and 10 degrees of freedom.
pub fn student_bound(p: f64, df: f64) -> f64 {
    let mut high = 2.0;
    while student_p(high, df) > p && high < 1e12 {
        high *= 2.0;
    }
    solved(0.0, high, -p, |t| -student_p(t, df))
}

/// Returns the probability that a standard normal variable exceeds `x`.
pub fn normal_above(x: f64) -> f64 {
    if x < 0.0 {
        return 1.0 - normal_above(-x);
    }
    let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
    if x < 3.0 {
        let (mut term, mut sum, mut k) = (x, x, 1.0);
        while term > 1e-17 * sum {
            k += 2.0;
            term *= x * x / k;
            sum += term;
        }
        return 0.5 - density * sum;
    }
    density / (1..200).rev().fold(x, |below, k| x + f64::from(k) / below)
}

/// Returns the quantile of the standard normal distribution at `p` (0 to 1).
pub fn normal_quantile(p: f64) -> f64 {
    if p < 0.5 { -normal_quantile(1.0 - p) } else { solved(0.0, 40.0, p - 1.0, |x| -normal_above(x)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of R 4.2, printed with 12 digits: pt, qt, pnorm, qnorm, pbeta, lgamma, binom.test.
    #[test]
    fn probabilities_and_bounds_are_those_of_tables() {
        for (found, known) in [
            (ln_gamma(0.5), 0.572_364_942_924_7),
            (ln_gamma(10.0), 12.801_827_480_1),
            (beta_cdf(0.3, 2.0, 5.0), 0.579_825),
            (beta_cdf(0.9, 0.5, 12.0), 0.999_999_999_999_830_8),
            // Two-sided 5 % bounds, as in textbook tables.
            (student_bound(0.05, 10.0), 2.228_138_851_97),
            (student_bound(0.05, 1.0), 12.706_204_736_4),
            (student_bound(0.01, 30.0), 2.749_995_653_57),
            (student_p(2.0, 5.0), 0.101_939_478_829_858),
            (student_p(12.706_204_736_4, 1.0), 0.05),
            (normal_above(1.0), 0.158_655_253_931),
            (normal_above(-1.0), 0.841_344_746_069),
            (normal_above(3.5), 0.000_232_629_079_036),
            (normal_above(3.0), 0.001_349_898_031_63),
            (normal_quantile(0.975), 1.959_963_984_54),
            (normal_quantile(0.01), -2.326_347_874_04),
            // binom.test(20, 400) and the rule of three's exact form, 1 - 0.025^(1/10).
            (share_interval(0, 10)[1], 1.0 - 0.025_f64.powf(0.1)),
        ] {
            assert!((found / known - 1.0).abs() < 1e-9, "{found} {known}");
        }
        assert_eq!((share_interval(0, 10)[0], share_interval(10, 10)[1]), (0.0, 1.0));
        let [low, high] = share_interval(20, 400);
        assert!((low - 0.030_805_241_143).abs() < 1e-10 && (high - 0.076_166_972_755).abs() < 1e-10, "{low} {high}");
    }

    #[test]
    fn a_share_of_a_t_distribution_with_many_degrees_is_normal() {
        assert!((student_bound(0.05, 1e7) - normal_quantile(0.975)).abs() < 1e-6);
        assert_eq!(student_p(0.0, 4.0), 1.0);
    }
}
