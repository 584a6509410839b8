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
        "event: the change asks something new, as the speed is outside of the new acceptable range and was in the range before or on its \
         other side; change: any other; sham: the events of the drive shifted all by the same time to where none is pending, to \
         see what is found by chance",
    ),
    (
        "onset_s",
        "Onset",
        "s",
        "when the change was seen, from the start of the drive: the first frame that showed it, or its issue where there was no screen",
    ),
    ("from_mps", "Target before", "m/s", "advised speed before the change"),
    ("to_mps", "Target after", "m/s", "advised speed after the change"),
    ("speed_mps", "Speed at the onset", "m/s", "speed of the ego vehicle at the onset"),
    ("asked", "Demand", "", "faster or slower: where the new range is; empty for a change that asks nothing new"),
    (
        "reaction_s",
        "Reaction time",
        "s",
        "perception-reaction time (reaction time, SAE J2944, 6.5.2): from the onset to the start of the first movement of the pedals in \
         the direction asked that is larger than the person's idle movements; empty if there was none until the end of watching \
         (censored there) or one was under way",
    ),
    (
        "under_way",
        "Movement under way",
        "",
        "such a movement started before 0.15 s: it is no response, and the reaction time is not known",
    ),
    (
        "movement_s",
        "Movement time",
        "s",
        "from the reaction to pedals that are 5 % of travel beyond the idle movements; empty if that was not reached until the end \
         of watching",
    ),
    (
        "enter_range_s",
        "Time to enter the range",
        "s",
        "compliance time: from the onset to the speed being in the new range; empty if it was not until the end of watching",
    ),
    ("enter_range_steps", "Steps to enter the range", "steps", "the time to enter the range in steps of the traffic"),
    (
        "watched_s",
        "Time watched",
        "s",
        "from the onset to the next change of the advice (of a sham: or the next sham) or the end of the drive; what is empty is censored \
         there",
    ),
    (
        "idle_movement",
        "Idle movement of the pedals",
        "",
        "95th percentile of the movements of the pedals within 1 s while no event is pending, as a share of travel, at least 0.01",
    ),
    (
        "idle_from",
        "Basis of the idle movement",
        "",
        "practice: the participant's first drive without a condition that has 20 s of idle pedals; drive: this drive; least: neither has \
         20 s, so that 0.01 is taken",
    ),
];

const REACTIONS: [ColumnTexts; 19] = [
    ("participant", "Participant", "", "code of the participant; empty outside of a study"),
    ("condition", "Condition", "", "condition of the drives; empty for drives that are the same for everyone"),
    (
        "time",
        "Time",
        "",
        "reaction: perception-reaction time; movement; compliance: time to enter the range; chance: reaction time to shams",
    ),
    ("onsets", "Onsets", "", "events, or shams, of these drives"),
    ("seen", "Times seen", "", "times that were not censored"),
    ("censored", "Times censored", "", "times that were longer than the time watched"),
    ("under_way", "Movements under way", "", "onsets that were left out as a movement was under way"),
    (
        "answered",
        "Share answered",
        "",
        "share within 3 s, of those that came or were watched that long: what chance has is no response to advice",
    ),
    ("chance_per_s", "Chance movements", "1/s", "of shams: movements that were found, over the seconds watched"),
    (
        "answering",
        "Share of events answered",
        "",
        "of reactions: share of the events that the driver answers at all, by the fit of the median; the others get a movement by chance or \
         none",
    ),
    (
        "median_s",
        "Median",
        "s",
        "median of the lognormal distribution of greatest likelihood, which takes account of censored times; of reactions that of the \
         answers, beside events that are never answered and movements by chance at the rate of the shams",
    ),
    (
        "low_s",
        "Median, lower end",
        "s",
        "lower end of its 95 % interval (Student's t on the logarithm, from the observed information; of reactions by the profile of the \
         likelihood)",
    ),
    ("high_s", "Median, upper end", "s", "upper end of the same interval"),
    ("log_mean", "Mean of the logarithm", "", "mu of the lognormal distribution of the time in seconds"),
    ("log_sd", "Standard deviation of the logarithm", "", "sigma of the same"),
    (
        "normal_mean_s",
        "Ex-Gaussian mu",
        "s",
        "mean of the normal part of the ex-Gaussian distribution; from 30 times seen on",
    ),
    ("normal_sd_s", "Ex-Gaussian sigma", "s", "standard deviation of the same part"),
    ("exponential_mean_s", "Ex-Gaussian tau", "s", "mean of the exponential part of the same distribution"),
    (
        "idle_from",
        "Basis of the idle movement",
        "",
        "where the size of idle movements of the pedals is from: practice, drive or least",
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
