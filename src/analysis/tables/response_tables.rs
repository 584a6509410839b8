//! Tables of responses. In: analysed drives. Out: `advice.csv` (a row per change of the advice or sham) and `reactions.csv`
//! (perception-reaction, movement and compliance times of each participant in each condition as censored distributions, and
//! the chance responses to shams), with their columns.

use super::key::{key, key_columns};
use crate::analysis::{
    columns::{ColumnTexts, TableColumns, cell, columns, line},
    drives::AnalysedRecording,
    responses::{
        AdviceResponse, ResponseTime, TimeFit,
        latency_fit::{ExGaussianFit, Latency},
        response_time_model::chance_per_s,
    },
};

const ADVICE: [ColumnTexts; 14] = [
    (
        "kind",
        "Kind",
        "",
        "request: a change that requires a new speed, as the speed is outside the new acceptable range, and inside the \
         old range or beyond its other side; change: any other change; sham: a request of the drive, all shifted by the \
         same time to moments without a pending request, to find responses by chance",
    ),
    (
        "onset_s",
        "Onset",
        "s",
        "time from the start of the drive to the first frame that showed the change, or to its issue without a screen",
    ),
    ("from_mps", "Target before", "m/s", "advised speed before the change"),
    ("to_mps", "Target after", "m/s", "advised speed after the change"),
    ("speed_mps", "Speed at the onset", "m/s", "speed of the ego vehicle at the onset"),
    (
        "asked",
        "Demand",
        "",
        "faster or slower: direction of the new range; empty for a change that requires no new speed",
    ),
    (
        "reaction_s",
        "Reaction time",
        "s",
        "perception-reaction time (reaction time, SAE J2944, 6.5.2): from the onset to the start of the first movement \
         of the pedals in the required direction that is larger than the person's idle movements; empty if there was \
         none before the end of watching (censored there) or if a movement was under way",
    ),
    (
        "under_way",
        "Movement under way",
        "",
        "true if such a movement started before 0.15 s: it is not a response, and the reaction time is unknown",
    ),
    (
        "movement_s",
        "Movement time",
        "s",
        "time from the start of the response to pedals 5 % of travel beyond the idle movements; empty if not reached \
         before the end of watching",
    ),
    (
        "enter_range_s",
        "Time to enter the range",
        "s",
        "compliance time: from the onset until the speed is in the new range; empty if not reached before the end of \
         watching",
    ),
    ("enter_range_steps", "Steps to enter the range", "steps", "time to enter the range, in steps of the traffic"),
    (
        "watched_s",
        "Time watched",
        "s",
        "time from the onset to the next change of the advice (for a sham, also to the next sham) or to the end of the \
         drive; empty times are censored there",
    ),
    (
        "idle_movement",
        "Idle movement of the pedals",
        "",
        "95th percentile of the movements of the pedals within 1 s while no request is pending, as a share of travel, at least 0.01",
    ),
    (
        "idle_from",
        "Basis of the idle movement",
        "",
        "practice: the participant's first drive without a condition and with 20 s of idle pedals; drive: this drive; \
         least: 0.01, because neither drive has 20 s",
    ),
];

const REACTIONS: [ColumnTexts; 19] = [
    ("participant", "Participant", "", "code of the participant; empty outside of a study"),
    ("condition", "Condition", "", "condition of the drives; empty for drives that are the same for everyone"),
    (
        "time",
        "Time",
        "",
        "reaction: perception-reaction time; movement: movement time; compliance: time to enter the range; chance: \
         reaction time to shams",
    ),
    ("onsets", "Onsets", "", "number of requests, or shams, of these drives"),
    ("seen", "Times seen", "", "number of times that were not censored"),
    ("censored", "Times censored", "", "number of times that were longer than the time watched"),
    ("under_way", "Movements under way", "", "number of onsets left out because a movement was under way"),
    (
        "answered",
        "Share with a response",
        "",
        "share of times within 3 s, of the times that were seen or watched that long; the share of the shams occurs by \
         chance",
    ),
    (
        "chance_per_s",
        "Chance movements",
        "1/s",
        "movements found after shams, over the seconds watched; empty for other times",
    ),
    (
        "answering",
        "Share of requests with a response",
        "",
        "share of the requests with a response at all, by the fit of the median; the other requests have a movement by \
         chance or none; for reaction times only",
    ),
    (
        "median_s",
        "Median",
        "s",
        "median of the lognormal distribution of greatest likelihood, with censored times; for reaction times the \
         median of the responses: the fit allows for requests without a response and for movements by chance at the rate \
         of the shams",
    ),
    (
        "low_s",
        "Median, lower end",
        "s",
        "lower end of the 95 % interval of the median (Student's t on the logarithm, from the observed information; \
         for reaction times by the profile of the likelihood)",
    ),
    ("high_s", "Median, upper end", "s", "upper end of the 95 % interval of the median"),
    ("log_mean", "Mean of the logarithm", "", "mu of the lognormal distribution of the time in seconds"),
    ("log_sd", "Standard deviation of the logarithm", "", "sigma of the lognormal distribution"),
    (
        "normal_mean_s",
        "Ex-Gaussian mu",
        "s",
        "mean of the normal part of the ex-Gaussian distribution; given with at least 30 times seen",
    ),
    ("normal_sd_s", "Ex-Gaussian sigma", "s", "standard deviation of the normal part of the ex-Gaussian distribution"),
    ("exponential_mean_s", "Ex-Gaussian tau", "s", "mean of the exponential part of the ex-Gaussian distribution"),
    (
        "idle_from",
        "Basis of the idle movement",
        "",
        "source of the size of idle movements of the pedals: practice, drive or least",
    ),
];

/// Returns the columns of `advice.csv`.
pub(crate) fn advice_columns(drives: &[AnalysedRecording]) -> TableColumns {
    let columns = key_columns(drives).into_iter().chain(columns(&ADVICE)).collect();
    TableColumns { file: "advice.csv", row: "a change of the advice, or a sham", columns }
}

/// Returns `advice.csv`: a row per change of the advice or sham.
pub fn advice(drives: &[AnalysedRecording]) -> String {
    let mut text = advice_columns(drives).head();
    for drive in drives {
        for r in drive.responses() {
            let own = [
                r.kind.to_string(),
                cell(Some(r.onset_s)),
                cell(Some(r.from_mps)),
                cell(Some(r.to_mps)),
                cell(Some(r.speed_mps)),
                ["slower", "", "faster"][(r.direction + 1) as usize].into(),
                cell(r.reaction_s),
                r.is_under_way.to_string(),
                cell(r.movement_s),
                cell(r.enter_s),
                cell(r.enter_steps.map(|n| n as f64)),
                cell(Some(r.watched_s)),
                cell(Some(r.threshold)),
                r.noise_from.to_string(),
            ];
            text += &line(key(drive).into_iter().chain(own));
        }
    }
    text
}

/// Responses of a participant in a condition.
struct Group<'a> {
    participant: &'a str,
    condition: &'a str,
    rank: usize,
    responses: Vec<AdviceResponse>,
}

/// Returns the columns of `reactions.csv`.
pub(crate) fn response_times_columns() -> TableColumns {
    TableColumns {
        file: "reactions.csv",
        row: "a kind of time of a participant in a condition",
        columns: columns(&REACTIONS),
    }
}

/// Returns `reactions.csv`: a row per participant, condition and kind of time.
pub fn response_times(drives: &[AnalysedRecording]) -> String {
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
    let mut text = response_times_columns().head();
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
