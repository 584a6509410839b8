//! Planned analysis on the report's page. In: a [`PlannedAnalysis`]. Out: the plan and its changes, exclusions with reasons,
//! models with their contrasts, and figures: each person over conditions with the model's means, and quantile-quantile plots.

use super::{
    page::{ReportFigure, ReportPage, TableCells, short},
    words::NONE,
};
use crate::analysis::{
    measures::MEASURES,
    models::{
        mixed_model::ContrastEstimate,
        normality::{NormalityTest, quantiles},
        plan::PlannedContrast,
        planned::{FittedOutcome, PlannedAnalysis, PlannedOutcome},
    },
};
use crate::metrics::Measure;
use crate::plot::{Axis, COLOURS, Chart, ChartSheet, PlotShape, PrintWidth, escaped, lines_needed};

/// Adds the section of the planned analysis to the page.
pub(super) fn section(page: &mut ReportPage, planned: &PlannedAnalysis) {
    page.put("<section id=\"planned-analysis\">\n<h2>Planned analysis</h2>");
    plan(page, planned);
    left_out(page, planned);
    let fitted: Vec<(&PlannedOutcome, &FittedOutcome)> =
        planned.outcomes.iter().filter_map(|outcome| Some((outcome, outcome.fitted.as_ref().ok()?))).collect();
    for outcome in &planned.outcomes {
        if let Err(why) = &outcome.fitted {
            let text = format!("No model was fitted for {}: {why}.", MEASURES[outcome.measure].title);
            page.paragraph("warning", &escaped(&text));
        }
    }
    if !fitted.is_empty() {
        contrasts(page, planned, &fitted);
        checks(page, &planned.plan.covariates, &fitted);
        for (outcome, of) in fitted {
            if let Some(figure) = persons(outcome, of) {
                page.figure(figure);
            }
            page.figure(normal(outcome, of));
        }
    }
    page.put("</section>");
}

fn plan(page: &mut ReportPage, planned: &PlannedAnalysis) {
    let plan = &planned.plan;
    let title =
        |name: &str| MEASURES.iter().find(|measure| measure.name == name).map_or(name.to_owned(), Measure::label);
    let secondary: Vec<String> = plan.secondary.iter().map(|name| title(name)).collect();
    let secondary = if secondary.is_empty() { "none".into() } else { secondary.join("; ") };
    let primary: Vec<String> = plan.primary.all().iter().map(|name| title(name)).collect();
    let effects: Vec<String> = plan.smallest_effect.all().iter().map(f64::to_string).collect();
    let s = if primary.len() == 1 { "" } else { "s" };
    let contrasts: Vec<String> = plan.contrasts.iter().map(PlannedContrast::label).collect();
    let text = format!(
        "Planned in the study's file: primary outcome{s} {}; secondary outcomes: {secondary}; contrasts: {}; two-sided level {} over all {} \
         tests by Holm's correction; smallest effect{s} of interest {}.",
        primary.join("; "),
        contrasts.join("; "),
        plan.alpha,
        planned.tests,
        effects.join("; ")
    );
    page.paragraph("", &escaped(&text));
    if !planned.impossible.is_empty() {
        let text =
            format!("Not tested, because one of the conditions has no trial with the measure: {}.", planned.impossible);
        page.paragraph("", &escaped(&text));
    }
    if planned.changes.is_empty() {
        page.paragraph("", "The plan has not changed since the first session.");
        return;
    }
    page.put("<p class=\"warning\"><b>The plan was changed after the first session:</b></p><ul>");
    planned.changes.iter().for_each(|what| page.put(&format!("<li>{}</li>", escaped(what))));
    page.put("</ul>");
}

fn left_out(page: &mut ReportPage, planned: &PlannedAnalysis) {
    let rules = planned.plan.exclude.sentences();
    let rules = if rules.is_empty() { "No rule of exclusion was planned.".into() } else { rules.join(" ") };
    if planned.left_out.is_empty() {
        page.paragraph("", &escaped(&format!("{rules} No participant or trial was left out of the models.")));
        return;
    }
    page.paragraph(
        "lead",
        &format!("{} {} lists the participants and trials left out.", escaped(&rules), page.table_links(1)),
    );
    let or_all = |text: &String, all: &str| if text.is_empty() { all.to_owned() } else { text.clone() };
    let rows: Vec<TableCells> = planned
        .left_out
        .iter()
        .map(|one| {
            let trial = if one.segment.is_empty() { String::new() } else { format!("{} {}", one.segment, one.place) };
            vec![one.participant.clone(), or_all(&trial, "all"), or_all(&one.condition, "all"), one.reason.clone()]
        })
        .collect();
    let head = ["Participant", "Trial", "Condition", "Reason"].map(str::to_owned).to_vec();
    page.table("Participants and trials left out of the models, with the reason.", &head, &rows, &[1, 2, 3]);
}

fn contrasts(page: &mut ReportPage, planned: &PlannedAnalysis, fitted: &[(&PlannedOutcome, &FittedOutcome)]) {
    page.paragraph("lead", &format!("{} gives the planned contrasts.", page.table_links(1)));
    let head = ["Outcome", "Contrast", "Estimate [95 %]", "SE", "df", "t", "p", "p (Holm)", "N (trials)"];
    let mut rows = Vec::new();
    for (outcome, of) in fitted {
        let label = MEASURES[outcome.measure].label();
        let counts = format!("{} ({})", of.participants.len(), of.observations.len());
        for tested in &of.contrasts {
            let mut row = vec![label.clone(), tested.contrast.label()];
            match &tested.found {
                Some(found) => {
                    let [low, high] = found.interval(0.05);
                    let estimate = format!("{} [{}, {}]", short(found.estimate), short(low), short(high));
                    let mark = if tested.p_holm < planned.plan.alpha { " *" } else { "" };
                    row.push(estimate);
                    row.extend([short(found.se), short(found.df), short(found.t), probability(found.p)]);
                    row.push(probability(tested.p_holm) + mark);
                }
                None => row.extend((0..6).map(|_| NONE.to_owned())),
            }
            row.push(counts.clone());
            rows.push(row);
        }
    }
    page.table(
        &format!(
            "Planned contrasts (condition minus reference) by one linear mixed model per outcome, {}, by restricted \
             maximum likelihood: estimate with its 95 % confidence interval (not corrected), standard error, \
             Satterthwaite's degrees of freedom, two-sided p, and p by Holm's correction over all planned tests. {} *: \
             below the planned level of {}. N is the number of participants.",
            planned.plan.formula(),
            match planned.plan.primary.all().len() {
                1 => "The first outcome is the primary one.".to_owned(),
                n => format!("The first {n} outcomes are the primary ones."),
            },
            planned.plan.alpha
        ),
        &head.map(str::to_owned).to_vec(),
        &rows,
        &[1],
    );
}

/// Formats a p value with three decimals, as journals do.
fn probability(p: f64) -> String {
    if p < 0.001 { "<0.001".into() } else { format!("{p:.3}") }
}

/// Returns the title of a measure; empty for an unknown name.
fn measure_title(name: &str) -> &'static str {
    MEASURES.iter().find(|measure| measure.name == name).map_or("", |measure| measure.title)
}

fn checks(page: &mut ReportPage, covariates: &[String], fitted: &[(&PlannedOutcome, &FittedOutcome)]) {
    page.paragraph("lead", &format!("{} gives the variances and checks of the models.", page.table_links(1)));
    let p_text =
        |test: Option<NormalityTest>| test.map_or(NONE.into(), |t| format!("{:.3} (p {})", t.w, probability(t.p)));
    let change = |of: &Option<ContrastEstimate>| {
        of.map_or(NONE.into(), |found| format!("{} (p {})", short(found.estimate), probability(found.p)))
    };
    let row = |(outcome, of): &(&PlannedOutcome, &FittedOutcome)| {
        let label = MEASURES[outcome.measure].label();
        let mut row = vec![label, short(of.model.sd_participant), short(of.model.sd_residual), change(&of.place)];
        row.extend(of.covariates.iter().map(|covariate| change(&covariate.1)));
        row.extend(of.normality.map(p_text));
        row
    };
    let of_covariates = covariates.iter().map(|name| format!("With {}", measure_title(name).to_lowercase()));
    let head: Vec<String> = ["Outcome", "SD between", "SD within", "From place to place"]
        .map(str::to_owned)
        .into_iter()
        .chain(of_covariates)
        .chain(["W of residuals", "W of intercepts"].map(str::to_owned))
        .collect();
    page.table(
        "Standard deviations between and within participants; change from one place among the trials to the next and \
         per unit of each covariate (empty if it cannot be separated from the other terms); Shapiro and Wilk's W of \
         the residuals and of the participants' intercepts. With few values this test finds only gross departures from \
         normality, with many values also harmless ones: look at the quantile-quantile plots. No result depends on the \
         test.",
        &head,
        &fitted.iter().map(row).collect::<Vec<_>>(),
        &[],
    );
}

/// Returns a participant's mean in a condition; `None` without observations.
fn own_mean(of: &FittedOutcome, person: usize, condition: usize) -> Option<f64> {
    let rows = of.observations.iter().filter(|row| row.0 == person && row.1 == condition);
    let values: Vec<f64> = rows.map(|row| row.2).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Draws the participants as lines over conditions, with the model's means and their intervals beside them.
fn persons(outcome: &PlannedOutcome, of: &FittedOutcome) -> Option<ReportFigure> {
    let measure = &MEASURES[outcome.measure];
    let (own, mean) = (|i: usize| i as f64 + 0.92, |i: usize| i as f64 + 1.16);
    let conditions = of.conditions.len();
    let mut pieces = Vec::new();
    let mut dots = Vec::new();
    let mut ends: Vec<f64> = Vec::new();
    for person in 0..of.participants.len() {
        let points: Vec<[f64; 2]> = (0..conditions).filter_map(|i| Some([own(i), own_mean(of, person, i)?])).collect();
        pieces.extend(points.windows(2).map(|pair| [pair[0], pair[1]]));
        ends.extend(points.iter().map(|point| point[1]));
        dots.extend(points);
    }
    let mut shapes = vec![PlotShape::Pieces { pieces, colour: "#b4b4b4".into(), width: 1.0 }];
    let dot = |at, radius, colour: &str, has_edge| PlotShape::Dot { at, radius, colour: colour.into(), has_edge };
    shapes.extend(dots.into_iter().map(|at| dot(at, 2.4, "#777777", false)));
    let means: Vec<[f64; 2]> = of.means.iter().enumerate().map(|(i, e)| [mean(i), e.estimate]).collect();
    let joined = means.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    shapes.push(PlotShape::Pieces { pieces: joined, colour: COLOURS[0].into(), width: 1.6 });
    for (i, estimate) in of.means.iter().enumerate() {
        let [low, high] = estimate.interval(0.05);
        ends.extend([low, high]);
        shapes.push(PlotShape::Pieces {
            pieces: vec![[[mean(i), low], [mean(i), high]]],
            colour: "#222".into(),
            width: 2.0,
        });
        shapes.push(dot([mean(i), estimate.estimate], 4.2, COLOURS[0], true));
    }
    let (low, high) = ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if !low.is_finite() || !high.is_finite() {
        return None;
    }
    let room = 0.06 * (high - low).max(1e-9);
    let chart = Chart {
        shapes,
        ..Chart::new(
            "",
            Axis::names(of.conditions.clone()),
            Axis::even(&measure.label(), [low - room, high + room]),
            210.0,
        )
    };
    let slot = |width: PrintWidth| (width.units() - 90.0) / conditions as f64 - 6.0;
    let stands =
        |width: &PrintWidth| of.conditions.iter().all(|name| lines_needed(name, slot(*width)).is_some_and(|n| n <= 3));
    let (chart, width) = match [PrintWidth::Column, PrintWidth::Page].into_iter().find(stands) {
        Some(width) => (chart, width),
        None => (chart.transposed(), PrintWidth::Page),
    };
    Some(ReportFigure {
        name: format!("model-{}", measure.name.replace('_', "-")),
        svg: ChartSheet { charts: &[chart], width, key: None, note: "" }.svg(),
        caption: format!(
            "{} of each participant over conditions (grey; the mean of several trials in a condition), and the means \
             of the mixed model at the mean place with their 95 % confidence intervals (blue). N = {} participants, {} \
             trials.",
            measure.title,
            of.participants.len(),
            of.observations.len()
        ),
    })
}

/// Draws the quantile-quantile plots of residuals and of the participants' intercepts.
fn normal(outcome: &PlannedOutcome, of: &FittedOutcome) -> ReportFigure {
    let measure = &MEASURES[outcome.measure];
    let chart = |title: &str, numbers: &[f64]| {
        let points = quantiles(numbers);
        let reach = |k: usize| points.iter().fold(2.0_f64, |far, point| far.max(point[k].abs())) * 1.08;
        let (wide, high) = (reach(0), reach(1));
        let line =
            PlotShape::Pieces { pieces: vec![[[-wide, -wide], [wide, wide]]], colour: "#999999".into(), width: 1.2 };
        let dots =
            points.into_iter().map(|at| PlotShape::Dot { at, radius: 2.4, colour: COLOURS[0].into(), has_edge: false });
        let (x, y) = (
            Axis::even("expected for a normal sample, SD", [-wide, wide]),
            Axis::even("found, SD", [-high.max(wide), high.max(wide)]),
        );
        Chart { shapes: [line].into_iter().chain(dots).collect(), ..Chart::new(title, x, y, 150.0) }
    };
    let mut charts = vec![chart("Residuals", &of.model.residuals)];
    // With a variance of 0 between participants there are no intercepts to check.
    if of.model.sd_participant > 0.0 {
        charts.push(chart("Participants' intercepts", &of.model.intercepts));
    }
    ReportFigure {
        name: format!("normal-{}", measure.name.replace('_', "-")),
        svg: ChartSheet { charts: &charts, width: PrintWidth::Column, key: None, note: "" }.svg(),
        caption: format!(
            "{}: quantile-quantile plots of the mixed model, in standard deviations of the values shown; grey: line of \
             normal values. N = {} residuals, {} participants.",
            measure.title,
            of.observations.len(),
            of.participants.len()
        ),
    }
}

/// Returns the paragraph of the methods on the planned analysis.
pub(super) fn paragraph(planned: &PlannedAnalysis) -> String {
    let plan = &planned.plan;
    let changed = if planned.changes.is_empty() {
        "The analysis was planned in the study's file before the first session.".to_owned()
    } else {
        format!("The plan of the analysis was changed after the first session. {}", planned.changes.join(" "))
    };
    let primary: Vec<String> = plan.primary.all().iter().map(|name| measure_title(name).to_owned()).collect();
    let primary = match &primary[..] {
        [one] => format!("The primary outcome was: {one}."),
        all => format!("The primary outcomes were: {}.", all.join("; ")),
    };
    let contrasts: Vec<String> = plan.contrasts.iter().map(PlannedContrast::label).collect();
    let covariates = plan.covariates.iter().map(|name| measure_title(name).to_lowercase());
    let covariates: Vec<String> = std::iter::once("place among the trials".to_owned()).chain(covariates).collect();
    let rules = plan.exclude.sentences();
    let rules = if rules.is_empty() { String::new() } else { format!(" {}", rules.join(" ")) };
    format!(
        "{changed} {primary} Each outcome was fitted by a linear mixed model with the condition as a factor, the \
         {} as covariates and the participant as a random intercept (restricted maximum likelihood). Contrasts ({}) \
         have t tests with Satterthwaite's degrees of freedom; the two-sided level was {} over all {} tests by Holm's correction.{rules} {} \
         left out.",
        covariates.join(" and the "),
        contrasts.join("; "),
        plan.alpha,
        planned.tests,
        match planned.left_out.len() {
            0 => "Nothing was".to_owned(),
            1 => "One participant or trial was".to_owned(),
            n => format!("{n} participants or trials were"),
        }
    )
}

#[cfg(test)]
#[path = "models_section_tests.rs"]
mod tests;
