//! Kinds of response times: perception-reaction, movement and compliance, and the chance responses to shams. In: responses of a
//! drive, or of a participant in a condition. Out: their times, censored or seen, and the distributions fitted to them.

use super::{
    advice_onsets::OnsetKind,
    latency_fit::{Latency, LognormalFit},
    response_detection::AdviceResponse,
    response_time_model::{ResponseFit, chance_per_s},
};

/// Longest time of a response in shares of responses, for requests and shams alike, seconds: with more time to watch, any pedal
/// moves.
pub const WITHIN_S: f64 = 3.0;

/// Kinds of response times, in the order of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResponseTime {
    /// Perception-reaction time, from the onset to the first movement.
    Reaction,
    /// Time from the reaction to a deliberate position of the pedals.
    Movement,
    /// Time from the onset until the speed is in the range.
    Compliance,
    /// Reaction time to shams.
    Chance,
}

impl std::fmt::Display for ResponseTime {
    /// Writes the word in the table.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Reaction => "reaction",
            Self::Movement => "movement",
            Self::Compliance => "compliance",
            Self::Chance => "chance",
        })
    }
}

impl ResponseTime {
    /// All kinds, in order.
    pub const ALL: [Self; 4] = [Self::Reaction, Self::Movement, Self::Compliance, Self::Chance];

    /// Returns the onsets that this time is measured from: shams for chance, else requests.
    pub fn onsets(self, responses: &[AdviceResponse]) -> impl Iterator<Item = &AdviceResponse> {
        let kind = if self == Self::Chance { OnsetKind::Sham } else { OnsetKind::Request };
        responses.iter().filter(move |response| response.kind == kind)
    }

    /// Returns the time of one onset; `None` if nothing is known, as for a movement under way.
    fn of(self, response: &AdviceResponse) -> Option<Latency> {
        let watched_s = response.watched_s;
        match self {
            Self::Compliance => Latency::of(response.enter_s, watched_s),
            _ if response.is_under_way => None,
            Self::Movement => Latency::of(response.movement_s, watched_s - response.reaction_s?),
            Self::Reaction | Self::Chance => Latency::of(response.reaction_s, watched_s),
        }
    }

    /// Returns the times of these responses.
    pub fn latencies(self, responses: &[AdviceResponse]) -> Vec<Latency> {
        self.onsets(responses).filter_map(|response| self.of(response)).collect()
    }

    /// Returns the fitted distribution; `None` with too few times, and for chance. Reactions are fitted as responses with
    /// chance movements beside them.
    pub fn fit(self, responses: &[AdviceResponse]) -> Option<TimeFit> {
        let times = self.latencies(responses);
        if self == Self::Reaction {
            let chance_per_s = chance_per_s(&Self::Chance.latencies(responses));
            let fit = ResponseFit::of(&times, chance_per_s)?;
            let ResponseFit { mu, sigma, share, interval_s } = fit;
            return Some(TimeFit { median_s: fit.median_s(), mu, sigma, interval_s, share_responding: Some(share) });
        }
        let fit = LognormalFit::of(&times).filter(|_| self != Self::Chance)?;
        let LognormalFit { mu, sigma, interval_s, .. } = fit;
        Some(TimeFit { median_s: fit.median_s(), mu, sigma, interval_s, share_responding: None })
    }

    /// Returns the share of responses within [`WITHIN_S`], among those seen or watched that long.
    pub fn share_with_response(self, responses: &[AdviceResponse]) -> Option<f64> {
        let responded: Vec<bool> = self
            .latencies(responses)
            .into_iter()
            .filter_map(|time| match time {
                Latency::Seen(s) => Some(s <= WITHIN_S),
                Latency::LongerThan(s) => (s >= WITHIN_S).then_some(false),
            })
            .collect();
        let count = responded.iter().filter(|is_seen| **is_seen).count();
        (!responded.is_empty()).then(|| count as f64 / responded.len() as f64)
    }
}

/// Fitted distribution of a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeFit {
    /// Median time, in seconds.
    pub median_s: f64,
    /// Mean of the logarithm of the time in seconds.
    pub mu: f64,
    /// Standard deviation of that logarithm.
    pub sigma: f64,
    /// 95 % interval of the median, seconds.
    pub interval_s: [f64; 2],
    /// Share of the requests with a response at all; `None` for kinds other than reactions.
    pub share_responding: Option<f64>,
}
