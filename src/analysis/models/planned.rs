//! Planned analysis of the drives of a study. In: a plan, analysed drives, participants. Out: one mixed model per outcome with
//! its contrasts, corrected by Holm over all tests; the exclusions with reasons; the table `models.csv`.
//!
//! Model: measure = intercept + condition + place + covariates + participant's intercept + residual. Place, from 1, is a
//! number. Place and covariates are dropped where they depend on the other terms (a fixed order, a wave that is always the
//! same).

use super::{
    mixed_design::ModelFault,
    mixed_model::{ContrastEstimate, MixedModel, holm},
    normality::{NormalityTest, shapiro_wilk},
    plan::{AnalysisPlan, ConditionKind, PlanHistory, PlannedContrast, PlannedTest},
};
use crate::analysis::{
    columns::{ColumnDefinition, ColumnTexts, cell, columns, line},
    data::StudyParticipants,
    drives::AnalysedRecording,
    measures::MEASURES,
};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Participant or trial that a rule left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Participant's id, such as `sub-P03`.
    pub participant: String,
    /// Segment of the trial; empty for a whole participant.
    pub segment: String,
    /// Place among the trials; empty for a whole participant.
    pub place: String,
    /// Condition of the trial; empty for a whole participant.
    pub condition: String,
    /// Rule in words without numbers, to count by.
    pub rule: &'static str,
    /// Reason, with the number found.
    pub reason: String,
}

/// Result of a planned difference.
#[derive(Clone, Debug, PartialEq)]
pub struct TestedContrast {
    /// Difference that was tested.
    pub contrast: PlannedContrast,
    /// Estimate; `None` if one of the conditions has no observation.
    pub found: Option<ContrastEstimate>,
    /// Value of p by Holm's correction over all tests of the plan.
    pub p_holm: f64,
}

/// Fitted model of an outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedOutcome {
    /// Model with the terms: intercept, conditions after the first, then place and covariates that were not dropped.
    pub model: MixedModel,
    /// Conditions with observations, in the study's order.
    pub conditions: Vec<String>,
    /// Participants, in the order of the model's intercepts.
    pub participants: Vec<String>,
    /// Observations: participant, condition (both from 0), value.
    pub observations: Vec<(usize, usize, f64)>,
    /// Model means of the conditions, at the mean place and the means of the covariates.
    pub means: Vec<ContrastEstimate>,
    /// Change from one place to the next; `None` if the term was dropped.
    pub place: Option<ContrastEstimate>,
    /// Change per unit of each planned covariate, with its name; `None` if the term was dropped.
    pub covariates: Vec<(String, Option<ContrastEstimate>)>,
    /// Results of the planned differences.
    pub contrasts: Vec<TestedContrast>,
    /// Normality of residuals, and of participants' intercepts.
    pub normality: [Option<NormalityTest>; 2],
}

/// An outcome of the plan with its model.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedOutcome {
    /// Index of the measure in [`MEASURES`].
    pub measure: usize,
    /// True for a primary outcome.
    pub is_primary: bool,
    /// Model, or the reason why there is none.
    pub fitted: Result<FittedOutcome, ModelFault>,
}

/// Result of a planned analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedAnalysis {
    /// Plan that was carried out: the current one.
    pub plan: AnalysisPlan,
    /// Sentences on changes after the first session.
    pub changes: Vec<String>,
    /// Participants and trials that the rules left out.
    pub left_out: Vec<LeftOut>,
    /// Participant of each trial that the rules kept.
    pub kept: Vec<String>,
    /// Primary outcomes, then the others.
    pub outcomes: Vec<PlannedOutcome>,
    /// Number of tests of the plan: the family that Holm's correction counts.
    pub tests: usize,
    /// Outcomes and contrasts of the plan that cannot be tested, in words: no trial of one of the conditions can have the
    /// measure.
    pub impossible: String,
}

impl PlannedAnalysis {
    /// Carries out the current plan; `None` without one.
    pub fn of(history: &PlanHistory, drives: &[AnalysedRecording], people: &StudyParticipants) -> Option<Self> {
        let plan = history.now.clone()?;
        let (kept, left_out) = sorted_out(&plan, drives, people);
        let participants = kept.iter().map(|drive| drive.found.participant.clone()).collect();
        let place = |name: &str| MEASURES.iter().position(|measure| measure.name == name);
        let [tests, impossible] = plan.tests(&kinds(drives));
        let covariates: Vec<usize> = plan.covariates.iter().filter_map(|name| place(name)).collect();
        let mut outcomes: Vec<PlannedOutcome> = plan
            .outcomes()
            .into_iter()
            .filter_map(|name| {
                let measure = place(name)?;
                let tested = tests.iter().filter(|test| test.outcome == name).map(|test| test.contrast).collect();
                let fitted = OutcomeFit { measure, tested, covariates: &covariates }.fit(&plan, &kept);
                Some(PlannedOutcome { measure, is_primary: plan.is_primary(name), fitted })
            })
            .collect();
        let (tests, impossible) = (tests.len(), PlannedTest::list(&impossible));
        correct(&mut outcomes, tests);
        Some(Self { plan, changes: history.changes(), left_out, kept: participants, outcomes, tests, impossible })
    }

    /// Returns `models.csv`: for each outcome a row per contrast, one for the place, and one per covariate.
    pub fn models_csv(&self) -> String {
        let mut text = line(COLUMNS.map(|column| column.0.to_owned()));
        for outcome in &self.outcomes {
            let Ok(fitted) = &outcome.fitted else { continue };
            let model = &fitted.model;
            let mut row = |kind: &str, term: [&str; 2], found: &ContrastEstimate, p_holm: Option<f64>| {
                let [low, high] = found.interval(0.05);
                let words =
                    [MEASURES[outcome.measure].name, if outcome.is_primary { "primary" } else { "secondary" }, kind];
                let counts = [fitted.participants.len(), fitted.observations.len()].map(|n| n.to_string());
                let [residuals, intercepts] = fitted.normality;
                let numbers = [
                    Some(found.estimate),
                    Some(found.se),
                    Some(found.df),
                    Some(found.t),
                    Some(found.p),
                    p_holm,
                    p_holm.map(|_| self.tests as f64),
                    Some(low),
                    Some(high),
                    Some(model.sd_participant),
                    Some(model.sd_residual),
                    residuals.map(|test| test.w),
                    residuals.map(|test| test.p),
                    intercepts.map(|test| test.w),
                    intercepts.map(|test| test.p),
                ];
                text += &line(words.into_iter().chain(term).map(str::to_owned).chain(counts).chain(numbers.map(cell)));
            };
            for tested in &fitted.contrasts {
                let Some(found) = &tested.found else { continue };
                row("contrast", [&tested.contrast.condition, &tested.contrast.reference], found, Some(tested.p_holm));
            }
            if let Some(place) = &fitted.place {
                row("place", ["", ""], place, None);
            }
            for (name, found) in &fitted.covariates {
                let Some(found) = found else { continue };
                row("covariate", [name, ""], found, None);
            }
        }
        text
    }

    /// Returns the table of exclusions: a row for each trial or participant that a rule left out.
    pub fn left_out_csv(&self) -> String {
        let head = ["participant", "segment", "place", "condition", "reason"].map(str::to_owned);
        let row = |one: &LeftOut| {
            line([&one.participant, &one.segment, &one.place, &one.condition, &one.reason].map(String::clone))
        };
        line(head) + &self.left_out.iter().map(row).collect::<String>()
    }
}

/// Columns of `models.csv`: name, quantity, unit, definition.
const COLUMNS: [ColumnTexts; 22] = [
    ("outcome", "Outcome", "", "name of the measure, as the column of the table of trials"),
    ("role", "Role", "", "primary or secondary, as planned"),
    (
        "kind",
        "Kind of row",
        "",
        "contrast: a planned difference; place: the change from one place among the trials to the next; covariate: the \
         change per unit of a planned covariate",
    ),
    ("condition", "Condition", "", "condition of the contrast, or name of the covariate"),
    ("reference", "Reference", "", "condition that the first one is compared with"),
    ("participants", "Participants", "", "participants in the model"),
    ("trials", "Trials", "", "trials in the model"),
    ("estimate", "Estimate", "", "condition minus reference, in the unit of the measure"),
    ("se", "Standard error", "", "standard error of the estimate"),
    ("df", "Degrees of freedom", "", "Satterthwaite's degrees of freedom"),
    ("t", "t", "", "estimate over standard error"),
    ("p", "p", "", "two-sided probability of such a t if there is no difference"),
    ("p_holm", "p by Holm", "", "p by Holm's correction over all tests of the plan; empty without a test"),
    (
        "holm_tests",
        "Tests of Holm's correction",
        "",
        "number of planned tests, which the correction counts; empty without a test",
    ),
    ("low", "Interval, lower end", "", "lower end of the 95 % confidence interval (t), not corrected"),
    ("high", "Interval, upper end", "", "upper end of the 95 % confidence interval (t), not corrected"),
    (
        "sd_participant",
        "Deviation between participants",
        "",
        "standard deviation of the random intercepts, in the unit of the measure",
    ),
    ("sd_residual", "Deviation within participants", "", "residual standard deviation, in the unit of the measure"),
    ("residual_w", "W of residuals", "", "Shapiro and Wilk's W of the residuals"),
    ("residual_w_p", "p of W of residuals", "", "probability of such a W in normal samples"),
    ("participant_w", "W of intercepts", "", "Shapiro and Wilk's W of the participants' predicted intercepts"),
    ("participant_w_p", "p of W of intercepts", "", "probability of such a W in normal samples"),
];

/// Applies the rules: returns the trials that are kept, and the exclusions.
fn sorted_out<'a>(
    plan: &AnalysisPlan,
    drives: &'a [AnalysedRecording],
    people: &StudyParticipants,
) -> (Vec<&'a AnalysedRecording>, Vec<LeftOut>) {
    let rules = &plan.exclude;
    let mut left_out: Vec<LeftOut> = Vec::new();
    let participant = |id: &str, rule: &'static str, reason: String| LeftOut {
        participant: id.into(),
        segment: String::new(),
        place: String::new(),
        condition: String::new(),
        rule,
        reason,
    };
    for person in people.all.iter().filter(|person| person.is_excluded()) {
        let why = person.ends.excluded.as_ref().map_or(String::new(), |why| format!(": {why}"));
        let rule = "excluded by the experimenter";
        left_out.push(participant(&person.id, rule, format!("{rule}{why}")));
    }
    let unfinished = |id: &str| people.all.iter().find(|person| person.id == id && person.state != "complete");
    let mut kept: Vec<&AnalysedRecording> = Vec::new();
    for drive in drives.iter().filter(|drive| !drive.found.condition.is_empty()) {
        let found = &drive.found;
        if rules.only_complete_sessions
            && let Some(person) = unfinished(&found.participant)
        {
            let reason = format!("the session is {}", person.state);
            let one = participant(&person.id, "the session was not completed", reason);
            if !left_out.contains(&one) {
                left_out.push(one);
            }
            continue;
        }
        let share = drive.duration_s / drive.setup.scenario.duration_s;
        let contacts = drive.measures.get("contact_count").unwrap_or(0.0);
        let dropped = drive.dropped_share();
        // A missing step by rounding is not a shorter drive.
        let (rule, reason) = if rules.least_recorded_share.is_some_and(|least| share < least - 1e-6) {
            (
                "too little of the planned length was recorded",
                format!("{:.1} % of the planned length was recorded", 100.0 * share),
            )
        } else if rules.most_contacts.is_some_and(|most| contacts > f64::from(most)) {
            let s = if contacts == 1.0 { "" } else { "s" };
            ("contacts with other vehicles", format!("{contacts:.0} contact{s} with other vehicles"))
        } else if rules.most_dropped_share.is_some_and(|most| dropped > most) {
            ("too much of its length was given up", format!("{:.1} % of its length was given up", 100.0 * dropped))
        } else {
            kept.push(drive);
            continue;
        };
        left_out.push(LeftOut {
            segment: found.segment.clone(),
            place: found.place.clone(),
            condition: found.condition.clone(),
            ..participant(&found.participant, rule, reason)
        });
    }
    let Some(least) = rules.least_trials.map(|least| least as usize) else { return (kept, left_out) };
    let mut ids: Vec<&str> = drives.iter().map(|drive| drive.found.participant.as_str()).collect();
    ids.dedup();
    for id in ids {
        let n = kept.iter().filter(|drive| drive.found.participant == id).count();
        if n < least && !left_out.iter().any(|one| one.participant == id && one.segment.is_empty()) {
            kept.retain(|drive| drive.found.participant != id);
            left_out.push(participant(
                id,
                "too few trials remained",
                if n == 1 { "1 trial remains".into() } else { format!("{n} trials remain") },
            ));
        }
    }
    (kept, left_out)
}

/// Returns the kinds of the conditions of these drives, by name.
fn kinds(drives: &[AnalysedRecording]) -> BTreeMap<String, ConditionKind> {
    let mut kinds: BTreeMap<String, ConditionKind> = BTreeMap::new();
    for drive in drives.iter().filter(|drive| !drive.found.condition.is_empty()) {
        let kind = ConditionKind::of(&drive.setup.manifest.policy.name, &drive.setup.scenario);
        let known = kinds.entry(drive.found.condition.clone()).or_default();
        *known = known.and(kind);
    }
    kinds
}

/// Inputs of the fit of one outcome.
struct OutcomeFit<'a> {
    measure: usize,
    tested: Vec<&'a PlannedContrast>,
    covariates: &'a [usize],
}

impl OutcomeFit<'_> {
    /// Fits the outcome to the trials that have it and every covariate.
    fn fit(&self, plan: &AnalysisPlan, kept: &[&AnalysedRecording]) -> Result<FittedOutcome, ModelFault> {
        let Self { measure, covariates, .. } = *self;
        let has = |drive: &AnalysedRecording, one: usize| drive.measures.values[one].is_some_and(f64::is_finite);
        let is_whole =
            |drive: &&&AnalysedRecording| has(drive, measure) && covariates.iter().all(|one| has(drive, *one));
        let owned: Vec<&AnalysedRecording> = kept.iter().filter(is_whole).copied().collect();
        let mut names: Vec<(usize, &str)> =
            owned.iter().map(|drive| (drive.found.rank, drive.found.condition.as_str())).collect();
        names.sort_unstable();
        names.dedup();
        let names: Vec<String> = names.into_iter().map(|(_, name)| name.to_owned()).collect();
        let mut participants: Vec<String> = owned.iter().map(|drive| drive.found.participant.clone()).collect();
        participants.sort();
        participants.dedup();
        let at = |list: &[String], name: &str| list.iter().position(|one| one == name).unwrap_or_default();
        let observations: Vec<(usize, usize, f64)> = owned
            .iter()
            .map(|drive| {
                let value = drive.measures.values[measure].unwrap_or_default();
                (at(&participants, &drive.found.participant), at(&names, &drive.found.condition), value)
            })
            .collect();
        if names.len() < 2 {
            return Err(ModelFault::TooFew { rows: observations.len(), participants: participants.len() });
        }
        let participant_of_row: Vec<usize> = observations.iter().map(|row| row.0).collect();
        let response: Vec<f64> = observations.iter().map(|row| row.2).collect();
        let mut terms: Vec<Vec<f64>> = (1..names.len())
            .map(|k| observations.iter().map(|row| f64::from(u8::from(row.1 == k))).collect())
            .collect();
        terms.push(owned.iter().map(|drive| drive.found.place.parse().unwrap_or(1.0)).collect());
        for one in covariates {
            terms.push(owned.iter().map(|drive| drive.measures.values[*one].unwrap_or_default()).collect());
        }
        // Terms after the conditions that the model still has: place is 0, then the covariates.
        let mut beside: Vec<usize> = (0..=covariates.len()).collect();
        let model = loop {
            match MixedModel::fit(&participant_of_row, &terms, &response) {
                Err(ModelFault::Aliased { term }) if term + 1 >= names.len() => {
                    terms.remove(term);
                    beside.remove(term + 1 - names.len());
                }
                found => break found?,
            }
        };
        let beside_means: Vec<f64> =
            terms[names.len() - 1..].iter().map(|term| term.iter().sum::<f64>() / term.len() as f64).collect();
        let change = |which: usize| {
            let at = beside.iter().position(|one| *one == which)?;
            Some(model.term(names.len() + at))
        };
        let weights = |condition: usize, intercept: f64| {
            let mut weights = vec![0.0; model.estimates.len()];
            weights[0] = intercept;
            if condition > 0 {
                weights[condition] = 1.0;
            }
            weights
        };
        let mean = |condition: usize| {
            let mut weights = weights(condition, 1.0);
            weights[names.len()..].copy_from_slice(&beside_means);
            model.contrast(&weights)
        };
        let tested = |contrast: &&PlannedContrast| {
            let place = |name: &str| names.iter().position(|one| one == name);
            let pair = place(&contrast.condition).zip(place(&contrast.reference));
            let found = pair.map(|(one, other)| {
                let (one, other) = (weights(one, 0.0), weights(other, 0.0));
                model.contrast(&one.iter().zip(&other).map(|(a, b)| a - b).collect::<Vec<_>>())
            });
            TestedContrast { contrast: (*contrast).clone(), found, p_holm: 1.0 }
        };
        Ok(FittedOutcome {
            means: (0..names.len()).map(mean).collect(),
            place: change(0),
            covariates: plan.covariates.iter().enumerate().map(|(i, name)| (name.clone(), change(i + 1))).collect(),
            contrasts: self.tested.iter().map(tested).collect(),
            normality: [shapiro_wilk(&model.residuals), shapiro_wilk(&model.intercepts)],
            conditions: names,
            participants,
            observations,
            model,
        })
    }
}

/// Applies Holm's correction over all planned tests. One without a result, such as that of an outcome without variation, counts as one with
/// p = 1: the level of the others does not depend on the data.
fn correct(outcomes: &mut [PlannedOutcome], planned: usize) {
    let mut tested: Vec<(&mut f64, f64)> = outcomes
        .iter_mut()
        .filter_map(|outcome| outcome.fitted.as_mut().ok())
        .flat_map(|fitted| &mut fitted.contrasts)
        .filter_map(|tested| Some((&mut tested.p_holm, tested.found?.p)))
        .collect();
    let mut p: Vec<f64> = tested.iter().map(|test| test.1).collect();
    p.resize(planned.max(p.len()), 1.0);
    let corrected = holm(&p);
    tested.iter_mut().zip(corrected).for_each(|(test, p)| *test.0 = p);
}

/// Returns the definitions of the columns of `models.csv` as JSON, with the keys of BIDS.
pub fn models_json() -> String {
    let all: Map<String, Value> = columns(&COLUMNS).into_iter().map(ColumnDefinition::entry).collect();
    format!("{:#}\n", Value::Object(all))
}

#[cfg(test)]
#[path = "planned_tests.rs"]
pub(crate) mod tests;
