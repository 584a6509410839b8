//! One participant's session, step by step. In: a study and the participant's number. Out: a [`SessionPlan`] in which each drive is a
//! complete scenario with a seed of its own.

use super::{
    Study,
    conditions::{Condition, conditions},
    practice::PracticeGoals,
    reckoning,
    segment::{SegmentKind, StudySegment, short_name},
};
use crate::{policy::ResolvedPolicy, record::inputs, scenario::Scenario, traffic::RING_STUDY};
use std::{collections::BTreeMap, fmt::Write};

/// Content of one item of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanItem {
    /// Page to read, Markdown.
    Text(String),
    /// Drive with or without advice.
    Drive {
        /// Scenario that is driven.
        scenario: Box<Scenario>,
        /// Resolved policy, which the scenario may leave open (`auto`).
        policy: ResolvedPolicy,
        /// Level of each factor; empty for a drive that is the same for every participant.
        levels: BTreeMap<String, String>,
        /// Goals of a drive for practice.
        practice: PracticeGoals,
    },
    /// Questionnaire, by its name in the study file.
    Questions(String),
    /// Rest of this many seconds.
    Break(f64),
}

/// One item of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedItem {
    /// Name, unique in the plan: `familiarisation`, `trial-2-wide`.
    pub name: String,
    /// Name of the segment: `familiarisation`, `trial`.
    pub segment: String,
    /// Place among the trials of the segment, from 1; `None` if the item is not about a trial.
    pub run: Option<usize>,
    /// Name of the condition, if the item has one.
    pub condition: Option<String>,
    /// Drive that a questionnaire asks about; `None` for other items.
    pub after: Option<AskedAfter>,
    /// Markdown that is shown before the item; may be empty.
    pub text: String,
    /// Content of the item.
    pub item: PlanItem,
    /// Expected duration, including reading the text before it, s.
    pub seconds: f64,
}

/// Link from a questionnaire to the drive before it.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedAfter {
    /// Name of the drive in the plan: `trial-2-wide`.
    pub drive: String,
    /// Name of the questionnaire in the data: `trust`.
    pub questionnaire: String,
}

/// Plan of a whole session.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionPlan {
    /// Number of the participant in the study, from 0.
    pub index: usize,
    /// Names of the conditions in the participant's order.
    pub order: Vec<String>,
    /// Items in the order of the session.
    pub items: Vec<PlannedItem>,
}

impl Study {
    /// Returns the session plan of participant number `index`, from 0. The same file and number give the same plan.
    pub fn plan(&self, index: usize) -> SessionPlan {
        let order = self.file.order.order(self.conditions.len(), index, self.file.seed);
        let mut seeds = (1..).map(|drive| self.seed_of(index, drive));
        let segments = self.file.segment.iter().enumerate();
        let items = segments
            .flat_map(|(number, segment)| SegmentPlanner { study: self, number, segment }.items(&order, &mut seeds))
            .collect();
        let order = order.into_iter().map(|which| self.conditions[which].name.clone()).collect();
        SessionPlan { index, order, items }
    }

    /// Returns the expected duration of an item, including the text before it, s. The text of a break is read during the break.
    fn seconds(&self, item: &PlanItem, text: &str) -> f64 {
        let read_s = reckoning::page_s(text);
        match item {
            PlanItem::Text(page) => reckoning::page_s(page),
            PlanItem::Questions(word) => read_s + self.questionnaires.get(word).map_or(0.0, reckoning::questionnaire_s),
            PlanItem::Break(seconds) => *seconds,
            PlanItem::Drive { scenario, .. } => read_s + scenario.duration_s,
        }
    }

    /// Checks that no two items of a plan, and no two tables of the data set, can have the same name.
    pub(super) fn check_item_names(&self) -> Result<(), (String, String)> {
        let segments = &self.file.segment;
        let conditions = conditions(&self.file);
        for (i, segment) in segments.iter().enumerate() {
            let short = segment.after_drive(true).map(|word| short_name(word));
            let mut made: Vec<String> = short.map(|word| format!("{}-{word}", segment.name)).collect();
            let mut tables: Vec<String> = Vec::new();
            if segment.kind == SegmentKind::Trials {
                let rests = segment.rest_s.is_some_and(|s| s > 0.0);
                for place in 1..=conditions.len() {
                    let words = segment.after_drive(true).map(|word| short_name(word));
                    tables.extend(words.map(|word| format!("{}-{place}-{word}", segment.name)));
                    made.extend(rests.then(|| format!("{}-rest-{place}", segment.name)));
                    for condition in &conditions {
                        let drive = format!("{}-{place}-{}", segment.name, condition.name);
                        made.extend(segment.after_drive(true).map(|word| format!("{drive}-{}", short_name(word))));
                        made.push(drive);
                    }
                }
                let mut names = made.clone();
                names.sort();
                if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
                    let message = format!(
                        "the name \"{}\" belongs to a drive and to a questionnaire after a drive; give the condition \
                         or the questionnaire another name",
                        pair[0]
                    );
                    return Err((format!("segment.{i}.after"), message));
                }
            }
            made.extend(tables);
            let other = segments.iter().enumerate().find(|(k, other)| *k != i && made.contains(&other.name));
            if let Some((k, other)) = other {
                let message = format!(
                    "the name \"{}\" belongs to an item of the segment \"{}\"; use another name",
                    other.name, segment.name
                );
                return Err((format!("segment.{k}.name"), message));
            }
        }
        Ok(())
    }

    /// Returns the seed of one drive of one participant, below 2^53 so that every JSON reader keeps it exactly.
    fn seed_of(&self, index: usize, drive: u64) -> u64 {
        (self.file.seed % 1_000_000) * 1_000_000 + (index as u64 % 10_000) * 100 + drive
    }

    /// Returns the plan for `participants` people as text: items with expected minutes, and the order of conditions of each participant.
    pub fn table(&self, participants: usize) -> String {
        let mut out = format!("{}\n", self.file.title);
        let period = self.file.order.period(self.conditions.len());
        let _ = writeln!(
            out,
            "{} participants, {} conditions, order {}: balanced after every {period}",
            participants,
            self.conditions.len(),
            serde_json::to_value(self.file.order).unwrap_or_default().as_str().unwrap_or_default()
        );
        let first = self.plan(0);
        let _ = writeln!(out, "\nA session, about {:.0} min:", first.minutes());
        for (i, planned) in first.items.iter().enumerate() {
            let (minutes, words) = (planned.seconds / 60.0, planned.item.to_string());
            let _ = writeln!(out, "  {:>2}  {:<32} {minutes:>4.1} min  {words}", i + 1, planned.name);
        }
        for segment in &self.file.segment {
            let Some(spoken) = self.spoken.get(&segment.name) else { continue };
            let read_s = reckoning::page_s(&segment.text);
            let _ =
                writeln!(out, "\nSpoken in {}: {}; its text, about {read_s:.0} s of reading:", segment.name, spoken);
            for line in segment.text.trim().lines() {
                let _ = writeln!(out, "  | {line}");
            }
        }
        if self.file.record_room {
            let _ = writeln!(
                out,
                "\n\
                 The room is recorded during every drive (room.wav beside its tables): the text of the consent must \
                 mention it."
            );
        }
        let _ = writeln!(out, "\nparticipant   order of conditions");
        for index in 0..participants {
            let _ = writeln!(out, "{:>11}   {}", index + 1, self.plan(index).order.join(", "));
        }
        if !participants.is_multiple_of(period) {
            let next = participants.next_multiple_of(period);
            let _ = writeln!(
                out,
                "\n\
                 With {participants} participants some orders are more frequent than others; with {next} all are \
                 equally frequent."
            );
        }
        out
    }
}

/// Segment of a study, from which the items of a session are planned.
struct SegmentPlanner<'a> {
    study: &'a Study,
    /// Number of the segment in the file, from 0.
    number: usize,
    segment: &'a StudySegment,
}

impl SegmentPlanner<'_> {
    /// Returns the items of the segment, with trials in this order. Each drive takes the next seed.
    fn items(&self, order: &[usize], seeds: &mut impl Iterator<Item = u64>) -> Vec<PlannedItem> {
        let StudySegment { kind, text, rest_s, .. } = self.segment;
        match kind {
            SegmentKind::Text => vec![self.item("", PlanItem::Text(text.clone()))],
            SegmentKind::Break => vec![self.item(text, PlanItem::Break(rest_s.unwrap_or(0.0)))],
            SegmentKind::Questions | SegmentKind::Consent => {
                let questionnaire = self.segment.own_questionnaire().unwrap_or_default().to_owned();
                vec![self.item(text, PlanItem::Questions(questionnaire))]
            }
            SegmentKind::Drive => self.with_questionnaires(self.item(text, self.drive(None, seeds))),
            SegmentKind::Trials => {
                let conditions = order.iter().map(|&which| &self.study.conditions[which]).enumerate();
                conditions.flat_map(|(place, condition)| self.trial(place, condition, seeds)).collect()
            }
        }
    }

    /// Returns an item that has the name of the segment and is not about a trial.
    fn item(&self, text: &str, item: PlanItem) -> PlannedItem {
        PlannedItem {
            name: self.segment.name.clone(),
            segment: self.segment.name.clone(),
            run: None,
            condition: None,
            after: None,
            text: text.into(),
            seconds: self.study.seconds(&item, text),
            item,
        }
    }

    /// Returns the items of the trial at a place, from 0: the rest before it, its drive and the questionnaires about it.
    fn trial(&self, place: usize, condition: &Condition, seeds: &mut impl Iterator<Item = u64>) -> Vec<PlannedItem> {
        let StudySegment { name, text, rest_s, .. } = self.segment;
        let rest = rest_s.filter(|rest_s| place > 0 && *rest_s > 0.0).map(|rest_s| PlannedItem {
            name: format!("{name}-rest-{place}"),
            ..self.item("", PlanItem::Break(rest_s))
        });
        let number = place + 1;
        let drive = PlannedItem {
            name: format!("{name}-{number}-{}", condition.name),
            run: Some(number),
            condition: Some(condition.name.clone()),
            ..self.item(if place == 0 { text } else { "" }, self.drive(Some(condition), seeds))
        };
        rest.into_iter().chain(self.with_questionnaires(drive)).collect()
    }

    fn drive(&self, condition: Option<&Condition>, seeds: &mut impl Iterator<Item = u64>) -> PlanItem {
        let scenario = self.study.drive(self.number, condition).expect("checked when the study was read");
        let scenario = if condition.is_some() { self.study.with_dial(scenario) } else { scenario };
        let names = [scenario.map.clone(), scenario.policy.clone()];
        let scenario = self.with_own_traffic(scenario);
        PlanItem::Drive {
            policy: self.study.expected.policies[&names].clone(),
            scenario: Box::new(Scenario { seed: seeds.next().unwrap_or_default(), ..scenario }),
            levels: condition.map(|c| c.levels.clone()).unwrap_or_default(),
            practice: PracticeGoals {
                until_in_range_s: self.segment.until_in_range_s,
                skills: self.segment.skills.clone(),
            },
        }
    }

    /// Returns a scenario with the path and the traffic that its road itself has, as recordings have it.
    fn with_own_traffic(&self, scenario: Scenario) -> Scenario {
        match self.study.expected.networks.get(&[scenario.map.clone(), scenario.path.clone()]) {
            Some(checked) if scenario.has_path_or_demand() => Scenario { path: checked.path.clone(), ..scenario },
            Some(checked) => Scenario { path: checked.path.clone(), demand: checked.demand.clone(), ..scenario },
            None => scenario,
        }
    }

    /// Returns a drive, followed by the questionnaires about it.
    fn with_questionnaires(&self, drive: PlannedItem) -> Vec<PlannedItem> {
        let has_advice = matches!(&drive.item, PlanItem::Drive { policy, .. } if policy.gives_advice());
        let about = self.segment.after_drive(has_advice).map(|word| {
            let after = AskedAfter { drive: drive.name.clone(), questionnaire: short_name(word) };
            PlannedItem {
                name: format!("{}-{}", drive.name, after.questionnaire),
                run: drive.run,
                condition: drive.condition.clone(),
                after: Some(after),
                ..self.item("", PlanItem::Questions(word.clone()))
            }
        });
        let about: Vec<PlannedItem> = about.collect();
        std::iter::once(drive).chain(about).collect()
    }
}

impl SessionPlan {
    /// Returns the expected duration of the session, minutes.
    pub fn minutes(&self) -> f64 {
        self.items.iter().map(|planned| planned.seconds).sum::<f64>() / 60.0
    }
}

impl std::fmt::Display for PlanItem {
    /// Describes the item in a few words.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Text(_) => f.write_str("a page to read"),
            Self::Questions(word) => write!(f, "questions: {word}"),
            Self::Break(seconds) => write!(f, "rest, {seconds} s"),
            Self::Drive { scenario, policy, practice, .. } => {
                let vehicles = if scenario.has_path_or_demand() {
                    String::new()
                } else {
                    format!(", {} vehicles", scenario.vehicles)
                };
                let sooner = practice.until_in_range_s;
                let sooner = sooner.map_or(String::new(), |s| format!(", or until {s} s in range without a break"));
                let skills: Vec<&str> = practice.skills.iter().map(|skill| skill.name()).collect();
                let events = match scenario.events.len() {
                    0 => String::new(),
                    1 => ", 1 event".into(),
                    count => format!(", {count} events"),
                };
                let shown = if skills.is_empty() { String::new() } else { format!(", skills: {}", skills.join(" ")) };
                write!(
                    f,
                    "{} s on {}{vehicles}{}, {}{events}{sooner}{shown}",
                    scenario.duration_s,
                    scenario.map,
                    drivers_text(scenario),
                    advice_text(scenario, policy)
                )
            }
        }
    }
}

/// Names the population that drives the other vehicles; empty for the drivers of the ring study.
fn drivers_text(scenario: &Scenario) -> String {
    let drivers = &scenario.traffic_drivers;
    if *drivers == RING_STUDY { String::new() } else { format!(" driven by {}", inputs::last(drivers)) }
}

/// Describes the advice of a drive.
fn advice_text(scenario: &Scenario, policy: &ResolvedPolicy) -> String {
    if !policy.gives_advice() {
        return "no advice".into();
    }
    let of = if scenario.sham_advice { "sham advice of" } else { "policy" };
    format!("{of} {}, hold {} s, range ±{} mph", policy, scenario.hold_s, scenario.range_mph)
}

#[cfg(test)]
#[path = "plan_tests.rs"]
mod tests;
