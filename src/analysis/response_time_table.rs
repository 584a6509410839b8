//! Response times of each participant in each condition. In: analysed drives. Out: `response_time_table.csv`: perception-reaction,
//! movement and compliance times as censored distributions, and the chance responses to shams. [`glossary`](super::glossary)
//! defines the columns.

use super::{
    AnalysedRecording,
    events::OnsetKind,
    glossary::names,
    latency_fit::{ExGaussianFit, Latency, LognormalFit},
    response_detection::AdviceResponse,
    response_time_model::{ResponseFit, chance_per_s},
    tables::{cell, line},
};

/// Longest time of a response in shares of responses, for events and shams alike, seconds: with more time to watch, any pedal
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

    /// Returns the onsets that this time is measured from: shams for chance, else events.
    pub fn onsets(self, responses: &[AdviceResponse]) -> impl Iterator<Item = &AdviceResponse> {
        let kind = if self == Self::Chance { OnsetKind::Sham } else { OnsetKind::Event };
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
    /// Share of the events with a response at all; `None` for kinds other than reactions.
    pub share_responding: Option<f64>,
}

/// Responses of a participant in a condition.
struct Group<'a> {
    participant: &'a str,
    condition: &'a str,
    rank: usize,
    responses: Vec<AdviceResponse>,
}

/// Returns `response_time_table.csv`: a row per participant, condition and kind of time.
pub fn table(drives: &[AnalysedRecording]) -> String {
    let mut groups: Vec<Group> = Vec::new();
    for drive in drives {
        let (participant, condition) = (drive.found.participant.as_str(), drive.found.condition.as_str());
        let known = groups.iter_mut().find(|g| (g.participant, g.condition) == (participant, condition));
        match known {
            Some(group) => group.responses.extend(drive.responses()),
            None => {
                let responses = drive.responses().to_vec();
                groups.push(Group { participant, condition, rank: drive.found.rank, responses });
            }
        }
    }
    groups.sort_by_key(|group| (group.participant, group.rank));
    let mut text = line(names(drives, "reactions.csv"));
    for group in &groups {
        for time in ResponseTime::ALL {
            text += &row(group, time);
        }
    }
    text
}

fn row(group: &Group, time: ResponseTime) -> String {
    let responses = &group.responses;
    let times = time.latencies(responses);
    let seen = times.iter().filter(|time| matches!(time, Latency::Seen(_))).count();
    let left_out = match time {
        ResponseTime::Compliance => 0,
        _ => time.onsets(responses).filter(|response| response.is_under_way).count(),
    };
    let whole = |n: usize| n.to_string();
    let fit = time.fit(responses);
    let numbers = |of: fn(&TimeFit) -> f64| cell(fit.as_ref().map(of));
    let chance = (time == ResponseTime::Chance && !times.is_empty()).then(|| chance_per_s(&times));
    let ex_gaussian = ExGaussianFit::of(&times);
    line([
        group.participant.into(),
        group.condition.into(),
        time.to_string(),
        whole(time.onsets(responses).count()),
        whole(seen),
        whole(times.len() - seen),
        whole(left_out),
        cell(time.share_with_response(responses)),
        cell(chance),
        cell(fit.and_then(|fit| fit.share_responding)),
        numbers(|fit| fit.median_s),
        numbers(|fit| fit.interval_s[0]),
        numbers(|fit| fit.interval_s[1]),
        numbers(|fit| fit.mu),
        numbers(|fit| fit.sigma),
        cell(ex_gaussian.map(|fit| fit.mu_s)),
        cell(ex_gaussian.map(|fit| fit.sigma_s)),
        cell(ex_gaussian.map(|fit| fit.tau_s)),
        time.onsets(responses).next().map_or(String::new(), |response| response.noise_from.to_string()),
    ])
}
