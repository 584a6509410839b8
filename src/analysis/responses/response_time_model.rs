//! Response times where some requests get no response and the feet move anyway. In: [`Latency`]s to requests, and the rate of
//! chance movements. Out: an [`ResponseFit`]: the share of requests with a response, the lognormal of the response times, the 95 %
//! interval of its median. Seconds.
//!
//! A driver held up by the vehicle ahead does not press the accelerator, whatever is advised: a plain lognormal takes such an
//! request for a response of ten seconds. In traffic, pedals also move without advice. The model:
//!
//! * A share p of the requests gets a response, at a lognormal time. The rest never does (a "cure model", Boag 1949).
//! * Chance movements occur in addition, at a constant rate c per second, estimated from the shams: movements over seconds
//!   watched.
//! * The earlier of the two is seen, or nothing until the watching ends. With the survival Q of the lognormal and its density
//!   q: S(t) = e^(-c t) (1 - p + p Q(t)), f(t) = e^(-c t) (c (1 - p + p Q(t)) + p q(t)).
//!
//! The interval of the median contains the medians with a profile log-likelihood within t^2 / 2 of the maximum; t is Student's
//! with n - 1 degrees of freedom, n the number of times seen. Sigma is at least [`LEAST_SIGMA`]: response times of one person
//! differ by more, and the likelihood of a few equal times is unbounded.

use super::{
    latency_fit::{ENOUGH, LN_ROOT_TAU, Latency, ln_upper_tail, student_975},
    simplex,
};

/// Lower bound of the standard deviation of ln t: response times of one person differ by at least a tenth.
pub const LEAST_SIGMA: f64 = 0.1;
/// Largest distance of an end of the interval from ln of the median, whatever the likelihood says.
const FURTHEST: f64 = 4.0;

/// Fitted response times to requests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResponseFit {
    /// Mean of ln t of the responses.
    pub mu: f64,
    /// Standard deviation of ln t.
    pub sigma: f64,
    /// Share of the requests with a response, 0 to 1.
    pub share: f64,
    /// 95 % interval of the median, seconds.
    pub interval_s: [f64; 2],
}

impl ResponseFit {
    /// Fits these times, with `chance_per_s` chance movements per second; `None` if fewer than [`ENOUGH`] were seen.
    pub fn of(times: &[Latency], chance_per_s: f64) -> Option<Self> {
        let times: Vec<(f64, bool)> = times.iter().map(|time| time.parts()).collect();
        let mut seen: Vec<f64> = times.iter().filter(|time| time.1).map(|time| time.0.ln()).collect();
        if seen.len() < ENOUGH {
            return None;
        }
        seen.sort_by(f64::total_cmp);
        let rows = Rows { times, chance_per_s };
        // The likelihood has several maxima: start at each quartile of the times, with a narrow and a wide spread, a half and
        // most of them responses.
        let quarter = |k: usize| seen[k * (seen.len() - 1) / 4];
        let starts = [1, 2, 3].into_iter().flat_map(|k| [-2.0, -0.7].map(|ln_spread| (quarter(k), ln_spread)));
        let starts = starts.flat_map(|(mu, ln_spread)| [0.0, 2.0].map(|logit| [mu, ln_spread, logit]));
        let found = starts.map(|start| simplex::least(|at| rows.cost(at), start, [0.2, 0.5, 0.5]));
        let (best, cost) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let most = cost + student_975(seen.len() - 1).powi(2) / 2.0;
        let end = |way: f64| (best[0] + way * rows.reach(best, way, most)).exp();
        let [mu, ln_spread, logit] = best;
        Some(Self { mu, sigma: sigma(ln_spread), share: share(logit), interval_s: [end(-1.0), end(1.0)] })
    }

    /// Median of the response times, seconds.
    pub fn median_s(&self) -> f64 {
        self.mu.exp()
    }
}

fn sigma(ln_spread: f64) -> f64 {
    LEAST_SIGMA + ln_spread.exp()
}

fn share(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// Data of the likelihood.
struct Rows {
    times: Vec<(f64, bool)>,
    chance_per_s: f64,
}

impl Rows {
    /// Returns the negative log-likelihood at mu, ln (sigma - [`LEAST_SIGMA`]) and the logit of the share.
    fn cost(&self, &[mu, ln_spread, logit]: &[f64; 3]) -> f64 {
        let (sigma, share, chance) = (sigma(ln_spread), share(logit), self.chance_per_s);
        let of = |(t, is_seen): &(f64, bool)| {
            let z = (t.ln() - mu) / sigma;
            let open = 1.0 - share + share * ln_upper_tail(z).exp();
            let density = (-0.5 * z * z - LN_ROOT_TAU).exp() / (sigma * t);
            let part = if *is_seen { chance * open + share * density } else { open };
            chance * t - part.max(f64::MIN_POSITIVE).ln()
        };
        self.times.iter().map(of).sum()
    }

    /// Returns the distance from the best mu up to which the profile cost stays at or below `most`; at most [`FURTHEST`].
    fn reach(&self, best: [f64; 3], way: f64, most: f64) -> f64 {
        let is_within = |far: f64| {
            let mu = best[0] + way * far;
            let cost = |at: &[f64; 2]| self.cost(&[mu, at[0], at[1]]);
            // Start at the best spread and at a wide one: far from the best mu the spread has to grow.
            [[best[1], best[2]], [-0.5, best[2]]]
                .into_iter()
                .any(|start| simplex::least(cost, start, [0.5, 0.5]).1 <= most)
        };
        let (mut within, mut beyond) = (0.0, 0.02);
        while is_within(beyond) {
            within = beyond;
            beyond *= 2.0;
            if beyond > FURTHEST {
                return FURTHEST;
            }
        }
        for _ in 0..20 {
            let middle = 0.5 * (within + beyond);
            if is_within(middle) { within = middle } else { beyond = middle }
        }
        within
    }
}

/// Returns the chance movements per second: the number seen over the time watched, 0 if nothing was watched.
pub fn chance_per_s(times: &[Latency]) -> f64 {
    let parts = times.iter().map(|time| time.parts());
    let (seen, watched_s) =
        parts.fold((0.0, 0.0), |(n, sum), (s, is_seen)| (n + f64::from(u8::from(is_seen)), sum + s));
    if watched_s > 0.0 { seen / watched_s } else { 0.0 }
}

#[cfg(test)]
#[path = "response_time_model_tests.rs"]
mod tests;
