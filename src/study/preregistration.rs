//! Preregistration text of a study, to register before the first participant. In: a study with its `[analysis]`, the number of
//! participants, and the spread of the primary outcome, from a rehearsal or unknown. Out: Markdown. The same input gives the same text.

use super::{
    PlanItem, PlannedItem, Study, bids::markdown, order::OrderDesign, preregistered_questions, preregistered_settings,
    source,
};
use crate::{
    analysis::{
        AnalysedRecording, AnalysisError, MEASURES, StudyParticipants,
        models::{
            mixed_design::ModelFault,
            normality::NormalityTest,
            plan::{AnalysisPlan, PlanHistory, PlannedTest},
            planned::PlannedAnalysis,
            power::SimulatedDesign,
        },
    },
    metrics::registry::unit_text,
    plot::minus,
    record::{inputs, sha256},
};
use std::fmt::Write;

/// Simulated studies for each number of participants; at a power of 80 % the standard error is 1.3 percentage points.
const STUDIES: usize = 1000;
/// Level of p below which the text reports non-normal residuals; t tests tolerate smaller departures.
const FAR_FROM_NORMAL: f64 = 0.001;
/// Smallest effects in residual standard deviations, if no rehearsal is given (Cohen 1988).
const CONVENTIONAL: [f64; 3] = [0.2, 0.5, 0.8];
/// Maximum number of steps of the power curve; each step is one or more whole squares of orders.
const MOST_SQUARES: usize = 8;
const MOST_PARTICIPANTS: usize = 96;

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
        /// Name of the primary outcome.
        measure: String,
        /// Fault of the model that was fitted.
        why: ModelFault,
    },
}

/// Known spread of the primary outcome.
#[derive(Clone, Debug, PartialEq)]
pub enum OutcomeSpread {
    /// Unknown: the power is given for effects in residual standard deviations.
    Unknown,
    /// Estimated from a data set.
    Rehearsed {
        /// Title of the data set.
        title: String,
        /// Numbers of participants and trials in the model.
        counts: [usize; 2],
        /// True if all participants were simulated.
        is_simulated: bool,
        /// Standard deviations between and within participants, in the unit of the outcome.
        deviations: [f64; 2],
        /// Change from one place to the next, in the unit of the outcome.
        per_place: f64,
        /// Normality test of the residuals.
        residuals: Option<NormalityTest>,
    },
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
        let no_spread = |why| PreregistrationError::NoSpread { measure: plan.primary.clone(), why };
        let history = PlanHistory { begun: now.clone(), now };
        let carried_out = PlannedAnalysis::of(&history, drives, people);
        let primary = carried_out.and_then(|all| all.outcomes.into_iter().next());
        let fitted = match primary.map(|outcome| outcome.fitted) {
            Some(Ok(fitted)) => fitted,
            Some(Err(why)) => return Err(no_spread(why)),
            None => return Err(no_spread(ModelFault::TooFew { rows: 0, participants: 0 })),
        };
        Ok(Self::Rehearsed {
            title: title.into(),
            counts: [fitted.participants.len(), fitted.observations.len()],
            is_simulated: people.is_rehearsal(),
            deviations: [fitted.model.sd_participant, fitted.model.sd_residual],
            per_place: fitted.place.map_or(0.0, |place| place.estimate),
            residuals: fitted.normality[0],
        })
    }
}

fn planned(study: &Study) -> Result<&AnalysisPlan, PreregistrationError> {
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
    power(&mut out, study, participants, spread, studies, row_done);
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
        let value = |value: &serde_json::Value| match value.as_str() {
            Some(text) => markdown(inputs::last(text)),
            None => markdown(&value.to_string()),
        };
        let set: Vec<String> = level.set.iter().map(|(key, set)| setting(key, &value(set))).collect();
        let set = if set.is_empty() { "as in the base of the study".into() } else { set.join(", ") };
        let of = factor.map_or(String::new(), |factor| format!(" of {}", markdown(factor)));
        let _ = writeln!(out, "* `{}`{of}: {set}", level.name);
    }
    out.push_str(
        "\nThe participant's screen does not name the condition; the experimenter's window does, so that the experimenter is not blind.\n\n",
    );
}

/// Describes a setting of a condition, sham advice in words.
fn setting(key: &str, value: &str) -> String {
    match (key, value) {
        ("sham_advice", "true") => {
            "sham advice (`sham_advice` = true): the advice that the policy gave to a simulated driver in another drive, which does not \
             answer this participant's traffic; the speedometer looks as with other advice"
                .into()
        }
        ("policy", "none") => format!("`{key}` = {value}: no speed is advised, and the speedometer shows neither line nor range"),
        _ => format!("`{key}` = {value}"),
    }
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
    for (i, name) in plan.outcomes().into_iter().enumerate() {
        let Some(measure) = MEASURES.iter().find(|measure| measure.name == name) else { continue };
        let role = if i == 0 { "Primary" } else { "Secondary" };
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
    let unit = unit(plan);
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
         * Smallest effect of interest: {}{unit} of the primary outcome.\n\
         * Quantile-quantile plots and Shapiro and Wilk's test show the normality of residuals and of participants' \
         intercepts; no decision depends on it.\n",
        plan.formula(),
        covariates(plan),
        contrasts.join("; "),
        plan.alpha,
        tests.len(),
        plan.smallest_effect,
    );
}

/// Returns sentences that define the covariates.
fn covariates(plan: &AnalysisPlan) -> String {
    let measure = |name: &String| MEASURES.iter().find(|measure| measure.name == name);
    let note_on = |name: &String| measure(name).map(|measure| format!(" `{name}` is a number: {}.", measure.about));
    let all: String = plan.covariates.iter().filter_map(note_on).collect();
    if all.is_empty() { all } else { all + " A covariate with the same value in all trials is left out." }
}

fn unit(plan: &AnalysisPlan) -> String {
    let unit = MEASURES.iter().find(|measure| measure.name == plan.primary).map_or("", |measure| measure.unit);
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

fn power(
    out: &mut String,
    study: &Study,
    participants: usize,
    spread: &OutcomeSpread,
    studies: usize,
    row_done: &dyn Fn(u64),
) {
    let Some(plan) = &study.file.analysis else { return };
    out.push_str("## Power\n\n");
    let unit = unit(plan);
    let first = &plan.contrasts[0];
    let strict = plan.alpha / plan.tests(&study.expected.kinds)[0].len().max(1) as f64;
    let (effects, deviations, per_place) = match spread {
        OutcomeSpread::Unknown => {
            let _ = writeln!(
                out,
                "No rehearsal was given, so the standard deviation within participants is not known. The effect is \
                 given in residual standard deviations, at the conventional 0.2 (small), 0.5 (medium) and 0.8 (large) \
                 of Cohen (1988). The standard deviation between participants equals the residual one, and position \
                 has no effect; neither affects a contrast within participants."
            );
            (CONVENTIONAL.to_vec(), [1.0, 1.0], 0.0)
        }
        OutcomeSpread::Rehearsed {
            title,
            counts: [people, trials],
            is_simulated,
            deviations,
            per_place,
            residuals,
        } => {
            let kind = if *is_simulated {
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
            (vec![plan.smallest_effect], *deviations, *per_place)
        }
    };
    let _ = writeln!(
        out,
        "Share of {studies} simulated studies in which the contrast {} has p below the level, with its 95 % interval \
         (Clopper and Pearson). Each study has newly drawn participants. Levels: {} for a single test, and {strict:.4} \
         for the strictest step of Holm's correction.\n",
        first.label(),
        plan.alpha
    );
    let shown = |effect: f64| match spread {
        OutcomeSpread::Unknown => format!("{effect} residual SD"),
        OutcomeSpread::Rehearsed { .. } => format!("{effect}{unit}"),
    };
    let _ =
        writeln!(out, "| participants | effect | power at {} | power at {strict:.4} |\n|---|---|---|---|", plan.alpha);
    let place = |name: &str| study.conditions.iter().position(|condition| condition.name == name).unwrap_or_default();
    let numbers = numbers(study, participants);
    let rows = (numbers.len() * effects.len()) as u64;
    for n in numbers {
        for effect in &effects {
            let design = SimulatedDesign {
                orders: (0..n).map(|i| study.file.order.order(study.conditions.len(), i, study.file.seed)).collect(),
                contrast: [place(&first.condition), place(&first.reference)],
                effect: *effect,
                per_place,
                sd_participant: deviations[0],
                sd_residual: deviations[1],
            };
            let cells = design.simulate(studies, [plan.alpha, strict], study.file.seed).map(|found| {
                let (share, [low, high]) = found.power();
                format!("{:.0} % [{:.0}, {:.0}]", 100.0 * share, 100.0 * low, 100.0 * high)
            });
            let mark = if n == participants { "**" } else { "" };
            let _ = writeln!(out, "| {mark}{n}{mark} | {} | {} | {} |", shown(*effect), cells[0], cells[1]);
            row_done(rows);
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

#[cfg(test)]
#[path = "preregistration_tests.rs"]
mod tests;
