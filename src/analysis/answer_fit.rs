//! How soon somebody answers, where not everything is answered and feet move anyway. In: [`Latency`]s to events, how often the same detector
//! finds something by chance. Out: an [`AnswerFit`]: the share that is answered, the lognormal of those answers, the 95 % interval of
//! its median. Seconds.
//!
//! A driver who is held up by the car ahead does not press the accelerator, whatever is advised: to a lognormal alone such an event is an
//! answer of ten seconds. And in traffic pedals move without advice. So:
//!
//! * a share p of the events is answered, at a lognormal time; the rest never is (a "cure model", Boag 1949);
//! * beside that there is a chance movement, at a constant rate c a second, as the shams have it: movements over seconds watched;
//! * what is seen is the earlier of the two, or nothing until the watching ends. With the survival Q of the lognormal and its
//!   density q: S(t) = e^(-c t) (1 - p + p Q(t)), f(t) = e^(-c t) (c (1 - p + p Q(t)) + p q(t)).
//!
//! The interval of the median holds those whose greatest likelihood is within t^2 / 2 of the best, Student's t of n-1 with n times seen. Sigma
//! is [`LEAST_SIGMA`] at the least: nobody's answers differ less, and of a few equal times the likelihood has no end.

use super::{
    latency_fit::{ENOUGH, LN_ROOT_TAU, Latency, ln_upper_tail, student_975},
    simplex,
};

/// Smallest standard deviation of ln t: answers of one person differ by a tenth at the least.
pub const LEAST_SIGMA: f64 = 0.1;
/// An interval ends this far from ln of the median, whatever the likelihood says.
const FURTHEST: f64 = 4.0;

/// Answers to events.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AnswerFit {
    /// Mean of ln t of the answers.
    pub mu: f64,
    /// Standard deviation of ln t.
    pub sigma: f64,
    /// Share of the events that is answered, 0 to 1.
    pub share: f64,
    /// 95 % interval of the median, seconds.
    pub interval_s: [f64; 2],
}

impl AnswerFit {
    /// Of these times, with so many movements by chance a second; `None` if fewer than [`ENOUGH`] were seen.
    pub fn of(times: &[Latency], chance_per_s: f64) -> Option<Self> {
        let times: Vec<(f64, bool)> = times.iter().map(|time| time.parts()).collect();
        let mut seen: Vec<f64> = times.iter().filter(|time| time.1).map(|time| time.0.ln()).collect();
        if seen.len() < ENOUGH {
            return None;
        }
        seen.sort_by(f64::total_cmp);
        let rows = Rows { times, chance_per_s };
        // The likelihood has more than one hill: from each quarter of the times, narrow and wide, few and most answered.
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

    /// Median of the answers, seconds.
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

/// What the likelihood is of.
struct Rows {
    times: Vec<(f64, bool)>,
    chance_per_s: f64,
}

impl Rows {
    /// Less the logarithm of the likelihood, at mu, ln (sigma - [`LEAST_SIGMA`]) and the logit of the share.
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

    /// How far from the best mu the cost stays below `most` with the best spread and share for each.
    fn reach(&self, best: [f64; 3], way: f64, most: f64) -> f64 {
        let is_within = |far: f64| {
            let mu = best[0] + way * far;
            let cost = |at: &[f64; 2]| self.cost(&[mu, at[0], at[1]]);
            // From the best and from a wide one: far from the best mu the spread has to grow.
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

/// Movements by chance a second: those that were seen over the time watched; 0 of nothing watched.
pub fn chance_per_s(times: &[Latency]) -> f64 {
    let parts = times.iter().map(|time| time.parts());
    let (seen, watched_s) =
        parts.fold((0.0, 0.0), |(n, sum), (s, is_seen)| (n + f64::from(u8::from(is_seen)), sum + s));
    if watched_s > 0.0 { seen / watched_s } else { 0.0 }
}

#[cfg(test)]
#[path = "answer_fit_tests.rs"]
mod tests;
