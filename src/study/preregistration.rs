//! Preregistration text of a study, to register before the first participant. In: a study with its `[analysis]`, the number of
//! participants, and the spread of the primary outcomes, from a rehearsal or unknown. Out: Markdown. The same input gives the same text.

pub use super::preregistered_power::{OutcomeSpread, RehearsedOutcome};

use super::{
    PlanItem, PlannedItem, Study, bids::markdown, order::OrderDesign, preregistered_power, preregistered_questions,
    preregistered_settings, source,
};
use crate::{
    analysis::{
        AnalysisError, MEASURES,
        models::{
            mixed_design::ModelFault,
            plan::{AnalysisPlan, PlannedTest},
        },
    },
    metrics::registry::unit_text,
    record::{inputs, sha256},
};
use std::fmt::Write;

/// Simulated studies for each number of participants; at a power of 80 % the standard error is 1.3 percentage points.
const STUDIES: usize = 1000;

/// Reason why there is no text.
#[derive(Debug, thiserror::Error)]
pub enum PreregistrationError {
    /// The study file has no plan of the analysis.
    #[error(
        "the study \"{0}\" has no [analysis]\n  remedy: write one into its file: primary, smallest_effect and contrasts (docs/studies.md)"
    )]
    NoPlan(String),
    /// The data of the rehearsal cannot be read.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// The rehearsal gives no estimate of the spread.
    #[error(
        "the rehearsal has no usable data on {measure}: {why}\n  remedy: rehearse with more participants (codrive \
         study rehearse FILE --out DIR)"
    )]
    NoSpread {
        /// Name of a primary outcome.
        measure: String,
        /// Fault of the model that was fitted.
        why: ModelFault,
    },
}

pub(super) fn planned(study: &Study) -> Result<&AnalysisPlan, PreregistrationError> {
    study.file.analysis.as_ref().ok_or_else(|| PreregistrationError::NoPlan(study.file.title.clone()))
}

/// Returns the text for this number of participants. `row_done` is called after each row of the table of powers, the longest part, with the
/// number of all rows.
///
/// # Errors
/// The study has no plan of its analysis.
pub fn text(
    study: &Study,
    participants: usize,
    spread: &OutcomeSpread,
    row_done: &dyn Fn(u64),
) -> Result<String, PreregistrationError> {
    written(study, participants, spread, STUDIES, row_done)
}

fn written(
    study: &Study,
    participants: usize,
    spread: &OutcomeSpread,
    studies: usize,
    row_done: &dyn Fn(u64),
) -> Result<String, PreregistrationError> {
    let plan = planned(study)?;
    let mut out = format!("# Preregistration: {}\n\n", markdown(&study.file.title));
    let _ = writeln!(
        out,
        "Written by codrive {} from the study's file.{}\n\nSHA-256 of the study's file, as the data set keeps it (`study.toml`): `{}`.\n",
        env!("CARGO_PKG_VERSION"),
        who_leads(study),
        sha256(source::portable(&study.source).as_bytes())
    );
    design(&mut out, study, participants);
    preregistered_settings::statements(&mut out, study);
    preregistered_settings::hypotheses(&mut out, plan);
    preregistered_settings::settings(&mut out, study);
    conditions(&mut out, study);
    orders(&mut out, study, participants);
    exclusion(&mut out, plan);
    preregistered_questions::early_ends(&mut out, study);
    preregistered_questions::questionnaires(&mut out, study);
    outcomes(&mut out, plan);
    model(&mut out, study, plan);
    preregistered_power::power(&mut out, study, participants, spread, studies, row_done);
    Ok(out)
}

fn who_leads(study: &Study) -> String {
    let authors =
        (!study.file.authors.is_empty()).then(|| format!("Led by {}.", markdown(&study.file.authors.join(", "))));
    let place = study.file.institution.as_ref().map(|place| format!("At {}.", markdown(place)));
    authors.into_iter().chain(place).map(|words| format!(" {words}")).collect()
}

fn design(out: &mut String, study: &Study, participants: usize) {
    let plan = study.plan(0);
    let is_trial = |planned: &&PlannedItem| planned.run.is_some() && matches!(planned.item, PlanItem::Drive { .. });
    let trials = plan.items.iter().filter(is_trial).count();
    let _ = writeln!(
        out,
        "## Design\n\nWithin participants: {participants} participants, each with {trials} trials, one in each of {} conditions per \
         segment of trials. A session takes about {:.0} min. The parts of the first participant's session; those after trials depend on \
         the order of conditions where a questionnaire is asked after drives with advice only:\n",
        study.conditions.len(),
        plan.minutes()
    );
    for (i, planned) in plan.items.iter().enumerate() {
        let _ = writeln!(out, "{}. `{}`: {}", i + 1, planned.segment, item_text(&planned.item, planned.run));
    }
    out.push('\n');
}

/// Describes an item without the parts that differ between participants.
fn item_text(item: &PlanItem, run: Option<usize>) -> String {
    match (item, run) {
        (PlanItem::Drive { scenario, .. }, Some(place)) => {
            format!("trial at position {place}, {} s on {}", scenario.duration_s, markdown(inputs::last(&scenario.map)))
        }
        (PlanItem::Drive { scenario, .. }, None) => {
            markdown(&item.to_string()) + &preregistered_settings::constant_speed(scenario)
        }
        _ => markdown(&item.to_string()),
    }
}

fn conditions(out: &mut String, study: &Study) {
    out.push_str("## Factors and conditions\n\n");
    for (factor, levels) in &study.file.factors {
        let names: Vec<&str> = levels.iter().map(|level| level.name.as_str()).collect();
        let _ = writeln!(out, "* Factor {}: {}", markdown(factor), names.join(", "));
    }
    let listed =
        study.file.factors.iter().flat_map(|(name, levels)| levels.iter().map(move |level| (Some(name), level)));
    for (factor, level) in listed.chain(study.file.condition.iter().map(|level| (None, level))) {
        let set: Vec<String> =
            level.set.iter().map(|(key, value)| preregistered_settings::changed(key, value)).collect();
        let set = if set.is_empty() { "as in the base of the study".into() } else { set.join(", ") };
        let of = factor.map_or(String::new(), |factor| format!(" of {}", markdown(factor)));
        let about = preregistered_settings::about_level(study, level);
        let stop = if about.is_empty() { "" } else { "." };
        let _ = writeln!(out, "* `{}`{of}: {set}{stop}{about}", level.name);
    }
    out.push_str(
        "\nThe participant's screen does not name the condition; the experimenter's window does, so that the experimenter is not blind.\n\n",
    );
}

fn orders(out: &mut String, study: &Study, participants: usize) {
    let n = study.conditions.len();
    let period = study.file.order.period(n);
    let design = match study.file.order {
        OrderDesign::Williams => {
            "balanced Latin squares (Williams 1949): every condition occurs equally often at every position, and \
             equally often right after every other condition"
        }
        OrderDesign::Full => "all orders in turn (full counterbalance)",
        OrderDesign::Block => {
            "blocks in which every condition occurs once at every position, drawn anew for each block"
        }
        OrderDesign::Fixed => {
            "the same order for all participants: effects of conditions cannot be separated from effects of position"
        }
    };
    let _ = writeln!(
        out,
        "## Order\n\nOrders are {design}. The seed is {}. They repeat after {period} participants. Participants get them in turn, as their \
         sessions begin.\n",
        study.file.seed
    );
    for index in 0..period.min(24).min(participants) {
        let _ = writeln!(out, "{}. {}", index + 1, study.plan(index).order.join(", "));
    }
    out.push('\n');
    if participants.is_multiple_of(period) {
        let _ = writeln!(out, "With {participants} participants every order is used {} times.", participants / period);
    } else {
        let _ = writeln!(
            out,
            "**With {participants} participants some orders are more frequent than others; with {} all are equally \
             frequent.**",
            participants.next_multiple_of(period)
        );
    }
    out.push_str(
        "A participant with the same order replaces each excluded or withdrawn participant, so that the orders stay \
         balanced. The study's file plans no analysis before the last participant.\n\n",
    );
}

fn exclusion(out: &mut String, plan: &AnalysisPlan) {
    out.push_str("## Exclusion\n\n");
    let rules = plan.exclude.sentences();
    if rules.is_empty() {
        out.push_str("* No rule excludes data.\n");
    }
    rules.iter().for_each(|rule| {
        let _ = writeln!(out, "* {rule}");
    });
    out.push_str(
        "* The experimenter may exclude a participant; the data set keeps the reason, and the report names the \
         excluded participants.\n\n",
    );
}

fn outcomes(out: &mut String, plan: &AnalysisPlan) {
    out.push_str("## Outcomes\n\n");
    for name in plan.outcomes() {
        let Some(measure) = MEASURES.iter().find(|measure| measure.name == name) else { continue };
        let role = if plan.is_primary(name) { "Primary" } else { "Secondary" };
        let _ = writeln!(out, "* {role}: {} (`{name}`): {}.", measure.label(), unit_text(measure.about));
    }
    out.push('\n');
}

fn model(out: &mut String, study: &Study, plan: &AnalysisPlan) {
    let [tests, impossible] = plan.tests(&study.expected.kinds);
    let without = match PlannedTest::list(&impossible) {
        none if none.is_empty() => String::new(),
        list => format!(" No test, because one of the conditions has no trial with the measure: {list}."),
    };
    let contrasts: Vec<String> = plan.contrasts.iter().map(|contrast| contrast.label()).collect();
    let effects: Vec<String> = plan.primary.all().iter().enumerate().map(|(i, name)| effect(plan, i, name)).collect();
    let _ = writeln!(
        out,
        "## Model and tests\n\n\
         One linear mixed model per outcome, fitted by restricted maximum likelihood:\n\n    \
         {}\n\n\
         The condition is a factor, the position among the trials (from 1) is a number, and the participant is a \
         random intercept.{} Contrasts: {}. Each has its estimate, a 95 % interval and a two-sided p by \
         Satterthwaite's degrees of freedom. A trial without a value of the outcome or of a covariate is left out of that outcome's \
         model; no value is imputed.\n\n\
         * Level: alpha = {} over all {} tests of the plan (outcomes times contrasts), by Holm's correction.{without}\n\
         * Smallest effect of interest: {}.\n\
         * Quantile-quantile plots and Shapiro and Wilk's test show the normality of residuals and of participants' \
         intercepts; no decision depends on it.\n",
        plan.formula(),
        covariates(plan),
        contrasts.join("; "),
        plan.alpha,
        tests.len(),
        effects.join("; "),
    );
    test_list(out, &tests);
}

/// Describes the smallest effect of interest on a primary outcome.
fn effect(plan: &AnalysisPlan, primary: usize, name: &str) -> String {
    let of = if plan.primary.all().len() == 1 { "the primary outcome".into() } else { format!("`{name}`") };
    format!("{}{} of {of}", plan.effect(primary), preregistered_power::unit(name))
}

/// Writes a row for each test, in the order of the table that the analysis writes (`models.csv`).
fn test_list(out: &mut String, tests: &[PlannedTest]) {
    out.push_str("The tests, in the order of the table of the analysis (`models.csv`):\n\n");
    out.push_str("| test | role | outcome | condition | reference |\n|---|---|---|---|---|\n");
    for (i, PlannedTest { outcome, is_primary, contrast }) in tests.iter().enumerate() {
        let role = if *is_primary { "primary" } else { "secondary" };
        let (condition, reference) = (&contrast.condition, &contrast.reference);
        let _ = writeln!(out, "| {} | {role} | `{outcome}` | `{condition}` | `{reference}` |", i + 1);
    }
    out.push('\n');
}

/// Returns sentences that define the covariates.
fn covariates(plan: &AnalysisPlan) -> String {
    let measure = |name: &String| MEASURES.iter().find(|measure| measure.name == name);
    let note_on = |name: &String| measure(name).map(|measure| format!(" `{name}` is a number: {}.", measure.about));
    let all: String = plan.covariates.iter().filter_map(note_on).collect();
    if all.is_empty() { all } else { all + " A covariate with the same value in all trials is left out." }
}

#[cfg(test)]
#[path = "preregistration_tests.rs"]
mod tests;
