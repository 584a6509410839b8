//! Report on how like measured people traffic is. In: trajectories of one or several runs, and the measured traffic. Out: one HTML page that
//! opens off-line, with its figures.

use super::{
    page::{ReportFigure, ReportPage, short},
    validation_figures as figures,
    words::NONE,
};
use crate::{
    metrics::{
        registry::unit_text,
        traffic_moments::{Judgement, MeasuredTraffic, VehicleTrajectories, judge, moments, persons},
    },
    plot::escaped,
};

/// Page of a validation, and file names and SVG texts of its figures.
pub struct ValidationReport {
    pub html: String,
    pub figures: Vec<(String, String)>,
}

/// Returns the moments of some runs beside those of measured people.
pub fn judged(people: &MeasuredTraffic, runs: &[VehicleTrajectories]) -> Vec<Judgement> {
    judge(people, &runs.iter().map(moments).collect::<Vec<_>>())
}

/// Makes the page. `title` names the traffic; figures are of the first run.
pub fn validation_report(
    title: &str,
    people: &MeasuredTraffic,
    runs: &[VehicleTrajectories],
    judgements: &[Judgement],
) -> ValidationReport {
    let mut page = ReportPage::titled(&format!("How like people: {title}"));
    page.paragraph("note", &escaped(&lead(people, runs)));
    let head = ["moment", "people", "their two halves", "like people", "model", "runs", "within"];
    let rows: Vec<_> = judgements.iter().map(|judgement| cells(judgement).to_vec()).collect();
    let caption = format!(
        "Moments of the traffic (model) beside those of people ({}). {NONE}: no criterion or no value.",
        people.title
    );
    page.table(&caption, &head.map(String::from).to_vec(), &rows, &[2, 3, 5, 6]);
    let Some(first) = runs.first() else { return ValidationReport { html: page.html, figures: page.figures } };
    let mut figure = |name: &str, svg: String, caption: &str| {
        page.figure(ReportFigure { name: name.into(), svg, caption: caption.into() });
    };
    if let Some(svg) = figures::space_time(first) {
        figure(
            "space-time",
            svg,
            "Positions of all vehicles along the ring, by speed. A wave is a slow band that moves back.",
        );
    }
    figure(
        "distributions",
        figures::distributions(first),
        "Distributions of gaps and speeds; people: gaps of experiment A.",
    );
    let band = "Gain from a leader's speed to its follower's by frequency; the band counts as like people.";
    figure("gains", figures::gains(&first.waves(), people), band);
    let range = "Time gaps and lags of persons in order of size; people: shortest, median and longest.";
    figure("persons", figures::persons(&persons(first), people), range);
    page.put("</body></html>");
    ValidationReport { html: page.html, figures: page.figures }
}

/// Returns the paragraph below the title.
fn lead(people: &MeasuredTraffic, runs: &[VehicleTrajectories]) -> String {
    let first = runs.first();
    let minutes = first.map_or(0.0, |run| run.steps() as f64 * run.step_s / 60.0);
    format!(
        "{} of {} vehicles, {minutes:.1} min, compared with codrive {}. Measured people: {}, {} vehicles on {} m. Definitions and sources: \
         docs/measures.md, docs/references.md (people). One ring and few people stand for people in general.",
        if runs.len() == 1 { "One run".into() } else { format!("{} runs", runs.len()) },
        first.map_or(0, |run| run.vehicles.len()),
        env!("CARGO_PKG_VERSION"),
        people.title,
        people.vehicles,
        people.ring_m,
    )
}

/// Formats a number; small shares keep their digits.
fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.005 { format!("{value:.4}") } else { short(value) }
}

/// Returns the cells of a moment: title with unit, people, their halves, band, model, runs, and whether it is within.
pub fn cells(judgement: &Judgement) -> [String; 7] {
    let title = match judgement.unit {
        "" => judgement.title.into(),
        unit => format!("{}, {}", judgement.title, unit_text(unit)),
    };
    let pair = |[a, b]: [f64; 2]| format!("{} to {}", number(a), number(b));
    let band = |band: [Option<f64>; 2]| match band {
        [Some(low), Some(high)] => pair([low, high]),
        [Some(low), None] => format!("at least {}", number(low)),
        [None, Some(high)] => format!("at most {}", number(high)),
        [None, None] => NONE.into(),
    };
    let runs = judgement.model_runs.filter(|[low, high]| low < high);
    [
        title,
        number(judgement.people),
        judgement.people_halves.map_or(NONE.into(), |[a, b]| format!("{}, {}", number(a), number(b))),
        judgement.band.map_or(NONE.into(), band),
        judgement.model.map_or(NONE.into(), number),
        runs.map_or(NONE.into(), pair),
        judgement.within.map_or(NONE, |within| if within { "yes" } else { "no" }).into(),
    ]
}
