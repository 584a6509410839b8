//! Distributions of partly censored times. In: [`Latency`]s: times seen, and times watched without one. Out: the
//! maximum-likelihood lognormal with the 95 % interval of its median ([`LognormalFit`]), and the ex-Gaussian
//! ([`ExGaussianFit`]). Seconds.
//!
//! * **Lognormal**: ln t is normal with mu and sigma; a censored time adds the probability of a longer one. The median is e^mu.
//!   The interval is mu +- t SE(mu): SE from the observed information of mu and sigma, with n/(n-1) for the variance; t is
//!   Student's with n-1 degrees of freedom, n the number of times seen. Without censored times this is the exact interval of a
//!   normal mean.
//! * **Ex-Gaussian**: the sum of a normal and an exponential time (mean mu + tau), by the simplex of Nelder and Mead, from
//!   [`ENOUGH_FOR_EX_GAUSSIAN`] times seen.

use super::simplex;

/// Minimum number of times seen for a lognormal: with two, the interval of the median is too wide to be useful.
pub const ENOUGH: usize = 3;
/// Minimum number of times seen for an ex-Gaussian.
pub const ENOUGH_FOR_EX_GAUSSIAN: usize = 30;
/// Lower bound of a time, s: one tick, so that the logarithm is finite.
const LEAST_S: f64 = 0.01;

/// A time, exact or censored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Latency {
    /// Exact time in seconds.
    Seen(f64),
    /// Censored time: longer than this, s.
    LongerThan(f64),
}

impl Latency {
    /// Returns the time seen, or the time watched without one; `None` if nothing was watched.
    pub fn of(seen_s: Option<f64>, watched_s: f64) -> Option<Self> {
        seen_s.map(Self::Seen).or((watched_s > 0.0).then_some(Self::LongerThan(watched_s)))
    }

    /// Returns the time, at least [`LEAST_S`], and true if it was seen.
    pub(super) fn parts(self) -> (f64, bool) {
        match self {
            Self::Seen(s) => (s.max(LEAST_S), true),
            Self::LongerThan(s) => (s.max(LEAST_S), false),
        }
    }
}

/// A lognormal distribution of times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LognormalFit {
    /// Mean of ln t.
    pub mu: f64,
    /// Standard deviation of ln t.
    pub sigma: f64,
    /// 95 % interval of the median, seconds.
    pub interval_s: [f64; 2],
    /// Number of times seen.
    pub seen: usize,
    /// Number of censored times.
    pub censored: usize,
}

impl LognormalFit {
    /// Fits these times; `None` if fewer than [`ENOUGH`] were seen or all of those are equal.
    pub fn of(times: &[Latency]) -> Option<Self> {
        let logs: Vec<(f64, bool)> =
            times.iter().map(|time| time.parts()).map(|(s, is_seen)| (s.ln(), is_seen)).collect();
        let seen: Vec<f64> = logs.iter().filter(|log| log.1).map(|log| log.0).collect();
        let n = seen.len();
        let mean = seen.iter().sum::<f64>() / n as f64;
        let variance = seen.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / n as f64;
        if n < ENOUGH || variance < 1e-12 {
            return None;
        }
        // Olsen 1978: in mu / sigma and 1 / sigma the likelihood is concave and has one maximum.
        let (mut at, mut value) = ([mean / variance.sqrt(), 1.0 / variance.sqrt()], f64::NEG_INFINITY);
        for _ in 0..100 {
            let (now, slope, curve) = olsen(&logs, at);
            value = value.max(now);
            let det = curve[0] * curve[2] - curve[1] * curve[1];
            let step =
                [(curve[1] * slope[1] - curve[2] * slope[0]) / det, (curve[1] * slope[0] - curve[0] * slope[1]) / det];
            let halved = (0..40).map(|k| 0.5_f64.powi(k)).find_map(|part| {
                let next = [at[0] + part * step[0], at[1] + part * step[1]];
                (next[1] > 0.0 && olsen(&logs, next).0 >= value - 1e-13 * value.abs()).then_some(next)
            });
            let Some(next) = halved else { break };
            let moved = (next[0] - at[0]).abs() + (next[1] - at[1]).abs();
            at = next;
            if moved < 1e-12 * (1.0 + at[0].abs() + at[1]) {
                break;
            }
        }
        let (mu, sigma) = (at[0] / at[1], 1.0 / at[1]);
        // Variance of mu = gamma / theta, by the delta method.
        let (_, _, curve) = olsen(&logs, at);
        let det = curve[0] * curve[2] - curve[1] * curve[1];
        let [gg, gt, tt] = [-curve[2] / det, curve[1] / det, -curve[0] / det];
        let variance = sigma * sigma * (gg - 2.0 * mu * gt + mu * mu * tt);
        let error = (variance * n as f64 / (n - 1) as f64).sqrt() * student_975(n - 1);
        let interval_s = [(mu - error).exp(), (mu + error).exp()];
        Some(Self { mu, sigma, interval_s, seen: n, censored: logs.len() - n })
    }

    /// Returns the median time, seconds.
    pub fn median_s(&self) -> f64 {
        self.mu.exp()
    }
}

/// Returns the log-likelihood at gamma = mu / sigma and theta = 1 / sigma, its gradient, and its second derivatives (gg, gt,
/// tt).
fn olsen(logs: &[(f64, bool)], [gamma, theta]: [f64; 2]) -> (f64, [f64; 2], [f64; 3]) {
    let (mut value, mut slope, mut curve) = (0.0, [0.0; 2], [0.0; 3]);
    for (y, is_seen) in logs {
        let z = theta * y - gamma;
        if *is_seen {
            value += theta.ln() - 0.5 * z * z - LN_ROOT_TAU;
            slope = [slope[0] + z, slope[1] + 1.0 / theta - z * y];
            curve = [curve[0] - 1.0, curve[1] + y, curve[2] - 1.0 / (theta * theta) - y * y];
        } else {
            // The hazard h of a normal: d ln Q / dz = -h, dh/dz = h (h - z).
            let tail = ln_upper_tail(z);
            let h = (-0.5 * z * z - LN_ROOT_TAU - tail).exp();
            let bend = h * (h - z);
            value += tail;
            slope = [slope[0] + h, slope[1] - h * y];
            curve = [curve[0] - bend, curve[1] + bend * y, curve[2] - bend * y * y];
        }
    }
    (value, slope, curve)
}

/// Logarithm of sqrt(2 pi).
pub(super) const LN_ROOT_TAU: f64 = 0.918_938_533_204_672_7;

/// Returns the logarithm of the probability that a standard normal variable exceeds z.
pub(super) fn ln_upper_tail(z: f64) -> f64 {
    let ln_density = -0.5 * z * z - LN_ROOT_TAU;
    if z > 3.0 {
        // Laplace's continued fraction, from its end.
        let fraction = (1..=60).rev().fold(z, |below, k| z + f64::from(k) / below);
        return ln_density - fraction.ln();
    }
    if z < -8.0 {
        return -(ln_density - (-z).ln()).exp();
    }
    // Series of the distribution function around 0: all terms have one sign.
    let mut term = z;
    let mut sum = z;
    for k in 1..200 {
        term *= z * z / f64::from(2 * k + 1);
        sum += term;
        if term.abs() < 1e-17 * sum.abs() {
            break;
        }
    }
    (0.5 - sum * ln_density.exp()).max(f64::MIN_POSITIVE).ln()
}

/// Returns the 97.5 % quantile of Student's t: exact for one to four degrees of freedom, else by the expansion in their inverse
/// (Abramowitz and Stegun 26.7.5), within 0.001 of the tables.
pub fn student_975(freedom: usize) -> f64 {
    match freedom {
        0 => f64::INFINITY,
        1 => 12.706_204_736,
        2 => 4.302_652_73,
        3 => 3.182_446_305,
        4 => 2.776_445_105,
        _ => {
            let z: f64 = 1.959_963_984_540_054;
            let power = |k: i32| z.powi(k);
            let n = freedom as f64;
            z + (power(3) + z) / (4.0 * n)
                + (5.0 * power(5) + 16.0 * power(3) + 3.0 * z) / (96.0 * n.powi(2))
                + (3.0 * power(7) + 19.0 * power(5) + 17.0 * power(3) - 15.0 * z) / (384.0 * n.powi(3))
                + (79.0 * power(9) + 776.0 * power(7) + 1482.0 * power(5) - 1920.0 * power(3) - 945.0 * z)
                    / (92160.0 * n.powi(4))
        }
    }
}

/// An ex-Gaussian distribution of times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExGaussianFit {
    /// Mean of the normal part, seconds.
    pub mu_s: f64,
    /// Standard deviation of the normal part, seconds.
    pub sigma_s: f64,
    /// Mean of the exponential part, seconds.
    pub tau_s: f64,
}

impl ExGaussianFit {
    /// Fits these times; `None` if fewer than [`ENOUGH_FOR_EX_GAUSSIAN`] were seen or all of those are equal.
    pub fn of(times: &[Latency]) -> Option<Self> {
        let times: Vec<(f64, bool)> = times.iter().map(|time| time.parts()).collect();
        let seen: Vec<f64> = times.iter().filter(|time| time.1).map(|time| time.0).collect();
        let n = seen.len() as f64;
        let mean = seen.iter().sum::<f64>() / n;
        let sd = (seen.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / n).sqrt();
        if seen.len() < ENOUGH_FOR_EX_GAUSSIAN || sd < 1e-9 {
            return None;
        }
        let cost = |at: &[f64; 3]| -Self::at(at).ln_likelihood(&times);
        // Two starts, skewed and nearly normal; the better result counts.
        let starts = [0.8_f64, 0.2].map(|share| {
            let sigma = sd * (1.0 - share * share).sqrt();
            simplex::least(cost, [mean - share * sd, sigma.ln(), (share * sd).ln()], [0.5 * sd, 0.5, 0.5]).0
        });
        let best = if cost(&starts[0]) <= cost(&starts[1]) { starts[0] } else { starts[1] };
        Some(Self::at(&best))
    }

    fn at([mu_s, ln_sigma, ln_tau]: &[f64; 3]) -> Self {
        Self { mu_s: *mu_s, sigma_s: ln_sigma.exp(), tau_s: ln_tau.exp() }
    }

    /// Mean of the whole distribution, seconds.
    pub fn mean_s(&self) -> f64 {
        self.mu_s + self.tau_s
    }

    fn ln_likelihood(&self, times: &[(f64, bool)]) -> f64 {
        let Self { mu_s, sigma_s, tau_s } = *self;
        let of = |(t, is_seen): &(f64, bool)| {
            let (z, ratio) = ((t - mu_s) / sigma_s, sigma_s / tau_s);
            let exponential = 0.5 * ratio * ratio - (t - mu_s) / tau_s + ln_upper_tail(ratio - z);
            if *is_seen {
                return exponential - tau_s.ln();
            }
            let normal = ln_upper_tail(z);
            let most = normal.max(exponential);
            most + ((normal - most).exp() + (exponential - most).exp()).ln()
        };
        times.iter().map(of).sum()
    }
}

#[cfg(test)]
#[path = "latency_fit_tests.rs"]
mod tests;
