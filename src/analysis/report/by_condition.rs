//! Report section by condition. In: analysed drives. Out: means of all measures, figures over time and by condition, and the
//! differences that such a study detects.

use super::{
    figures,
    page::{ReportFigure, ReportPage, TableCells, short},
    words::{BESIDE, NONE, estimate, interval, verb},
};
use crate::analysis::{
    drives::{
        AnalysedRecording, StatisticalPower, conditions, participants, per_participant, power, road_kinds, values,
    },
    measures::{MEASURES, index},
    text::{count, joined_with_and, people},
};

/// Measures with a figure by condition.
const DRAWN: [&str; 11] = [
    "speed_gain_mps",
    "mean_speed_mps",
    "time_in_range",
    "speed_error_mps",
    "reaction_s",
    "enter_range_s",
    "min_gap_m",
    "reversals_per_min",
    "fuel_saved_l_100km",
    "ego_time_loss_s",
    "travel_time_s",
];

/// Measures with a power calculation.
const POWERED: [&str; 4] = ["mean_speed_mps", "time_in_range", "speed_error_mps", "reaction_s"];

/// Adds the section by condition: means, figures, power.
pub(super) fn study(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    let conditions = conditions(drives);
    let trials: usize = conditions.iter().map(|(_, of)| of.len()).sum();
    page.put("<h2>By condition</h2>");
    let over_time = figures::over_time(drives);
    let drawn: Vec<ReportFigure> = DRAWN.into_iter().filter_map(|name| distribution(drives, name)).collect();
    let powered: Vec<TableCells> = POWERED.into_iter().flat_map(|name| powers(drives, index(name))).collect();
    let parts = conditions.chunks(BESIDE).count();
    let (lines, dots) = (usize::from(over_time.is_some()), drawn.len());
    let mut text = format!("{} the measures of each condition.", verb(&page.table_links(parts), parts, "give"));
    if lines > 0 {
        text += &format!(" {} shows the mean speed over time.", page.figure_links(0, 1));
    }
    if dots > 0 {
        // These figures follow the one of speed over time.
        text +=
            &format!(" {} the distribution of one measure each.", verb(&page.figure_links(lines, dots), dots, "show"));
    }
    page.paragraph("lead", &text);
    means(page, &conditions);
    if let Some(svg) = over_time {
        page.figure(ReportFigure {
            name: "speed-over-time".into(),
            svg,
            caption: format!(
                "Mean speed of all vehicles over time by condition. Lines: mean over participants of means over at \
                 least 5 s, drawn at their middle; bands: {}; dashed grey: the same drives without advice, if there \
                 are any. {}, {} in all.",
                interval(),
                numbers(&conditions, participants),
                count(trials)
            ),
        });
    }
    drawn.into_iter().for_each(|figure| page.figure(figure));
    if powered.is_empty() {
        return;
    }
    page.put("<h3>Detectable differences (power)</h3>");
    page.paragraph(
        "lead",
        &format!("{} gives the differences that a study of this size would detect.", page.table_links(1)),
    );
    let head = ["Measure", "Conditions", "N", "Difference", "SD", "with this N", "with 10", "with 25", "with 50"];
    let head: TableCells = head.into_iter().map(str::to_owned).chain(["N for this difference".into()]).collect();
    page.table(
        "Differences within participants (second condition minus first). SD: standard deviation (N−1). With this N, \
         10, 25 or 50: smallest difference detected by so many participants with a power of 80 % at a two-sided level \
         of 5 % (2.80 standard errors of the difference; normal approximation, no correction for several comparisons). \
         N for this difference: number of participants for which the smallest detected difference is the one found. N: \
         number of participants with both conditions.",
        &head,
        &powered,
        &[1],
    );
}

/// Adds tables of the means of all measures, with at most [`BESIDE`] conditions in each.
fn means(page: &mut ReportPage, conditions: &[(String, Vec<&AnalysedRecording>)]) {
    let has_value = |k: &usize| conditions.iter().any(|(_, of)| !values(of, *k).is_empty());
    let measured: Vec<usize> = (0..MEASURES.len()).filter(has_value).collect();
    let roads = road_kinds(conditions.iter().flat_map(|(_, of)| of.iter().copied()));
    let is_missing = |k: &usize| MEASURES[*k].is_on(roads) && !has_value(k);
    let without: Vec<String> = (0..MEASURES.len()).filter(is_missing).map(|k| MEASURES[k].title.to_owned()).collect();
    let parts = conditions.chunks(BESIDE).len();
    for (i, part) in conditions.chunks(BESIDE).enumerate() {
        let head = ["Measure".to_owned()].into_iter();
        let head = head.chain(part.iter().map(|(name, of)| format!("{name} (N = {})", participants(of)))).collect();
        let row = |k: &usize| {
            let cell = |(_, of): &(String, Vec<&AnalysedRecording>)| {
                let found = values(of, *k);
                // N of the measure, if some participants lack it.
                let n = if found.len() < participants(of) { format!(" (N = {})", found.len()) } else { String::new() };
                estimate(&found).map_or(NONE.into(), |text| text + &n)
            };
            [MEASURES[*k].label()].into_iter().chain(part.iter().map(cell)).collect()
        };
        let of = if parts > 1 { format!(", part {} of {parts}", i + 1) } else { String::new() };
        let missing = if i > 0 || without.is_empty() {
            String::new()
        } else {
            format!(" Without any value: {}.", joined_with_and(&without))
        };
        page.table(
            &format!(
                "Measures by condition{of}: mean over participants [{}]. N is the number of participants.{missing}",
                interval()
            ),
            &head,
            &measured.iter().map(row).collect::<Vec<_>>(),
            &[],
        );
    }
}

/// Returns the number of participants by condition; a single number if all are equal.
fn numbers(conditions: &[(String, Vec<&AnalysedRecording>)], of: impl Fn(&[&AnalysedRecording]) -> usize) -> String {
    let each: Vec<usize> = conditions.iter().map(|(_, drives)| of(drives)).collect();
    let (least, most) = (each.iter().min().copied().unwrap_or(0), each.iter().max().copied().unwrap_or(0));
    if least == most {
        format!("N = {} in each condition", people(least))
    } else if each.len() <= 6 {
        let counts: Vec<String> = conditions.iter().zip(&each).map(|((name, _), n)| format!("{n} ({name})")).collect();
        format!("N = {} participants", joined_with_and(&counts))
    } else {
        format!("N = {least} to {most} participants in a condition")
    }
}

fn distribution(drives: &[AnalysedRecording], name: &str) -> Option<ReportFigure> {
    let k = index(name);
    let n = numbers(&conditions(drives), |of| per_participant(of, k).len());
    Some(ReportFigure {
        name: format!("by-condition-{}", name.replace('_', "-")),
        svg: figures::distribution(drives, k)?,
        caption: format!(
            "{} by condition. Small dots: participants, joined by a line; large dots with bars: mean and its {}. {n}.",
            MEASURES[k].title,
            interval()
        ),
    })
}

fn powers(drives: &[AnalysedRecording], measure: usize) -> Vec<TableCells> {
    let row = |p: StatisticalPower| {
        let needed = p.needed().filter(|n| *n < 10_000.0).map_or(NONE.into(), |n| n.to_string());
        let words = [MEASURES[p.measure].label(), format!("{} → {}", p.pair[0], p.pair[1]), p.n.to_string()];
        let numbers = [p.mean, p.sd, p.detectable(p.n), p.detectable(10), p.detectable(25), p.detectable(50)];
        words.into_iter().chain(numbers.map(short)).chain([needed]).collect()
    };
    power(drives, measure).into_iter().map(row).collect()
}
