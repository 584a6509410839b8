//! Power as a preregistration states it. In: a study with its `[analysis]`, and the spread of its primary outcomes, from a rehearsal or
//! unknown. Out: Markdown, one table for each primary outcome.

use super::{
    Study,
    bids::markdown,
    preregistration::{PreregistrationError, planned},
};
use crate::{
    analysis::{
        AnalysedRecording, MEASURES, StudyParticipants,
        models::{
            mixed_design::ModelFault,
            normality::NormalityTest,
            plan::{AnalysisPlan, PlanHistory},
            planned::{PlannedAnalysis, PlannedOutcome},
            power::SimulatedDesign,
        },
    },
    plot::minus,
};
use std::fmt::Write;

/// Level of p below which the text reports non-normal residuals; t tests tolerate smaller departures.
const FAR_FROM_NORMAL: f64 = 0.001;
/// Smallest effects in residual standard deviations, if no rehearsal is given (Cohen 1988).
const CONVENTIONAL: [f64; 3] = [0.2, 0.5, 0.8];
/// Maximum number of steps of the power curve; each step is one or more whole squares of orders.
const MOST_SQUARES: usize = 8;
const MOST_PARTICIPANTS: usize = 96;

/// Known spread of the primary outcomes.
#[derive(Clone, Debug, PartialEq)]
pub enum OutcomeSpread {
    /// Unknown: the power is given for effects in residual standard deviations.
    Unknown,
    /// Estimated from a data set.
    Rehearsed {
        /// Title of the data set.
        title: String,
        /// True if all participants were simulated.
        is_simulated: bool,
        /// Spread of each primary outcome, in the order of the plan.
        outcomes: Vec<RehearsedOutcome>,
    },
}

/// Spread of an outcome in a data set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RehearsedOutcome {
    /// Numbers of participants and trials in the model.
    pub counts: [usize; 2],
    /// Standard deviations between and within participants, in the unit of the outcome.
    pub deviations: [f64; 2],
    /// Change from one place to the next, in the unit of the outcome.
    pub per_place: f64,
    /// Normality test of the residuals.
    pub residuals: Option<NormalityTest>,
}

impl OutcomeSpread {
    /// Estimates the spread from the drives of a rehearsal or pilot, by the model that the study plans.
    ///
    /// # Errors
    /// There is no plan, or no model can be fitted.
    pub fn rehearsed(
        study: &Study,
        title: &str,
        drives: &[AnalysedRecording],
        people: &StudyParticipants,
    ) -> Result<Self, PreregistrationError> {
        let plan = planned(study)?;
        let now = Some(plan.clone());
        let history = PlanHistory { begun: now.clone(), now };
        let analysed = PlannedAnalysis::of(&history, drives, people).map_or(Vec::new(), |all| all.outcomes);
        let outcomes =
            plan.primary.all().iter().map(|name| RehearsedOutcome::of(name, &analysed)).collect::<Result<_, _>>();
        Ok(Self::Rehearsed { title: title.into(), is_simulated: people.is_rehearsal(), outcomes: outcomes? })
    }
}

impl RehearsedOutcome {
    fn of(name: &str, analysed: &[PlannedOutcome]) -> Result<Self, PreregistrationError> {
        let found = analysed.iter().find(|outcome| MEASURES[outcome.measure].name == name);
        let fitted = match found.map(|outcome| &outcome.fitted) {
            Some(Ok(fitted)) => Ok(fitted),
            Some(Err(why)) => Err(why.clone()),
            None => Err(ModelFault::TooFew { rows: 0, participants: 0 }),
        };
        let fitted = fitted.map_err(|why| PreregistrationError::NoSpread { measure: name.into(), why })?;
        Ok(Self {
            counts: [fitted.participants.len(), fitted.observations.len()],
            deviations: [fitted.model.sd_participant, fitted.model.sd_residual],
            per_place: fitted.place.map_or(0.0, |place| place.estimate),
            residuals: fitted.normality[0],
        })
    }
}

/// Returns the unit of a measure after a space; empty without a unit.
pub(super) fn unit(name: &str) -> String {
    let unit = MEASURES.iter().find(|measure| measure.name == name).map_or("", |measure| measure.unit);
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// Effects and spread of one table of powers.
struct PowerTable<'a> {
    study: &'a Study,
    plan: &'a AnalysisPlan,
    /// Number of participants of the study.
    participants: usize,
    /// Effects, and the words after each of them.
    effects: Vec<f64>,
    unit: String,
    deviations: [f64; 2],
    per_place: f64,
    /// Number of simulated studies for each row.
    studies: usize,
}

/// Writes the section on power: a table for each primary outcome, or one for all of them if their spread is unknown.
pub(super) fn power(
    out: &mut String,
    study: &Study,
    participants: usize,
    spread: &OutcomeSpread,
    studies: usize,
    row_done: &dyn Fn(u64),
) {
    let Some(plan) = &study.file.analysis else { return };
    out.push_str("## Power\n\n");
    let rows = numbers(study, participants).len();
    match spread {
        OutcomeSpread::Unknown => {
            let _ = writeln!(
                out,
                "No rehearsal was given, so the standard deviation within participants is not known. The effect is \
                 given in residual standard deviations, at the conventional 0.2 (small), 0.5 (medium) and 0.8 (large) \
                 of Cohen (1988). The standard deviation between participants equals the residual one, and position \
                 has no effect; neither affects a contrast within participants."
            );
            let table = PowerTable {
                study,
                plan,
                participants,
                effects: CONVENTIONAL.to_vec(),
                unit: " residual SD".into(),
                deviations: [1.0, 1.0],
                per_place: 0.0,
                studies,
            };
            table.write(out, &|| row_done((rows * CONVENTIONAL.len()) as u64));
        }
        OutcomeSpread::Rehearsed { title, is_simulated, outcomes } => {
            for (i, (name, outcome)) in plan.primary.all().iter().zip(outcomes).enumerate() {
                if outcomes.len() > 1 {
                    let _ = writeln!(out, "### Power for `{name}`\n");
                }
                let unit = unit(name);
                source_of_spread(out, title, *is_simulated, outcome, &unit);
                let table = PowerTable {
                    study,
                    plan,
                    participants,
                    effects: vec![plan.effect(i)],
                    unit,
                    deviations: outcome.deviations,
                    per_place: outcome.per_place,
                    studies,
                };
                table.write(out, &|| row_done((rows * outcomes.len()) as u64));
                if i + 1 < outcomes.len() {
                    out.push('\n');
                }
            }
        }
    }
}

/// Writes where the standard deviations come from, and whether their residuals are far from normal.
fn source_of_spread(out: &mut String, title: &str, is_simulated: bool, outcome: &RehearsedOutcome, unit: &str) {
    let RehearsedOutcome { counts: [people, trials], deviations, per_place, residuals } = outcome;
    let kind = if is_simulated {
        "simulated participants; their standard deviations differ from those of people"
    } else {
        "participants"
    };
    let _ = writeln!(
        out,
        "Standard deviations come from the data set \"{}\" ({people} {kind}; {trials} trials): {}{unit} \
         between and {}{unit} within participants, and {}{unit} from position to position.",
        markdown(title),
        figures(deviations[0]),
        figures(deviations[1]),
        figures(*per_place)
    );
    if let Some(test) = residuals.filter(|test| test.p < FAR_FROM_NORMAL) {
        let _ = writeln!(
            out,
            "**The residuals there are far from normal** (Shapiro and Wilk's W = {:.3}, p < \
             {FAR_FROM_NORMAL}), but the simulated ones below are normal, so the power may differ. Look at the \
             quantile-quantile plot of the report, and consider another primary outcome or its logarithm.\n",
            test.w
        );
    }
}

impl PowerTable<'_> {
    /// Writes the table; `row_done` is called after each row.
    fn write(&self, out: &mut String, row_done: &dyn Fn()) {
        let Self { study, plan, participants, studies, .. } = *self;
        let first = &plan.contrasts[0];
        let strict = plan.alpha / plan.tests(&study.expected.kinds)[0].len().max(1) as f64;
        let _ = writeln!(
            out,
            "Share of {studies} simulated studies in which the contrast {} has p below the level, with its 95 % interval \
             (Clopper and Pearson). Each study has newly drawn participants. Levels: {} for a single test, and {strict:.4} \
             for the strictest step of Holm's correction.\n",
            first.label(),
            plan.alpha
        );
        let _ = writeln!(
            out,
            "| participants | effect | power at {} | power at {strict:.4} |\n|---|---|---|---|",
            plan.alpha
        );
        let place =
            |name: &str| study.conditions.iter().position(|condition| condition.name == name).unwrap_or_default();
        for n in numbers(study, participants) {
            for effect in &self.effects {
                let design = SimulatedDesign {
                    orders: (0..n)
                        .map(|i| study.file.order.order(study.conditions.len(), i, study.file.seed))
                        .collect(),
                    contrast: [place(&first.condition), place(&first.reference)],
                    effect: *effect,
                    per_place: self.per_place,
                    sd_participant: self.deviations[0],
                    sd_residual: self.deviations[1],
                };
                let cells = design.simulate(studies, [plan.alpha, strict], study.file.seed).map(|found| {
                    let (share, [low, high]) = found.power();
                    format!("{:.0} % [{:.0}, {:.0}]", 100.0 * share, 100.0 * low, 100.0 * high)
                });
                let mark = if n == participants { "**" } else { "" };
                let _ = writeln!(out, "| {mark}{n}{mark} | {effect}{} | {} | {} |", self.unit, cells[0], cells[1]);
                row_done();
            }
        }
    }
}

/// Returns the numbers of participants on the power curve: whole squares of orders, and the planned number.
fn numbers(study: &Study, participants: usize) -> Vec<usize> {
    let period = study.file.order.period(study.conditions.len());
    let step = period.max(6usize.next_multiple_of(period.max(1)));
    let mut all: Vec<usize> =
        (1..=MOST_SQUARES).map(|k| k * step).filter(|n| *n == step || *n <= MOST_PARTICIPANTS).collect();
    all.retain(|n| *n >= 2);
    all.push(participants.max(2));
    all.sort_unstable();
    all.dedup();
    all
}

/// Formats a number with three decimals and a typographic minus.
fn figures(value: f64) -> String {
    minus(&format!("{value:.3}"))
}
