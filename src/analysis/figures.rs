//! The figures of an analysis, as SVG. In: what a figure of one drive can show, or analysed drives. Out: pictures without fonts
//! or scripts of their own. They take no more room for a drive of days than for one of hours.

use super::{
    Analysed, MEASURES, Trial,
    tables::{conditions, values},
    traces::DriveTraces,
};
use crate::{
    chart::{Axis, COLOURS, Chart, Line, Style, picture},
    train::{Estimate, figures},
};
use std::fmt::Write;

/// What the time of a drive counts from.
const TIME: &str = "time since the start of the drive, s";
/// Higher than any field: what reaches to it crosses the whole field.
const TOP_MPS: f64 = 1e3;
/// Seconds that are averaged for lines over time, at the least.
const SMOOTH_S: usize = 5;
/// Points of a line over time, at the most: two for each unit of its width. They stand 5 s apart up to two hours.
const MOST_POINTS: usize = 1440;

/// Way of all cars, the ego thick: with advice, and without. Of a long drive its beginning, and the title says so.
pub fn space_time(title: &str, drive: &DriveTraces, baseline: Option<&DriveTraces>) -> String {
    let named = |title: &str, drive: &DriveTraces| match drive.ways_end_s {
        Some(end_s) => format!("{title}, the first {:.0} min", end_s / 60.0),
        None => title.to_owned(),
    };
    let titles = [named(title, drive), baseline.map_or(String::new(), |of| named("The same without advice", of))];
    let drawn = [Some(drive), baseline];
    let rings: Vec<_> = titles.iter().zip(drawn).filter_map(|(title, of)| Some((title.as_str(), &of?.ways))).collect();
    // So that standing and flowing differ in colour: somewhat above what most cars drive.
    let top_mps = (2.0 * drive.median_speed_mps.unwrap_or(5.0)).max(4.0);
    figures::space_time(&rings, top_mps, TIME, "")
}

/// Speed of the ego, advice with its range, and the spread of all cars over time; contacts and marks where they were.
pub fn speeds(title: &str, drive: &DriveTraces, trial: &Trial) -> String {
    let upright = |name: &str, style: Style, times_s: Vec<f64>| {
        let line = move |(i, at_s): (usize, f64)| Line {
            // The legend names them once.
            name: if i == 0 { name.into() } else { String::new() },
            style,
            points: vec![[at_s, 0.0], [at_s, TOP_MPS]],
            band: Vec::new(),
        };
        times_s.into_iter().enumerate().map(line).collect::<Vec<_>>()
    };
    let contacts = trial.contacts_at.iter().map(|contact| contact[0]).collect();
    let mut more = upright("contact", Style { width: 1.6, ..Style::solid("#cc0000") }, contacts);
    let marks = Style { width: 1.0, dash: "4 3", ..Style::solid("#555555") };
    more.extend(upright("mark", marks, trial.marks_at.clone()));
    figures::speeds(title, &drive.speeds, drive.range_mps, TIME, "", more)
}

/// Mean speed of all cars over time, with advice and without.
pub fn gain(title: &str, drive: &Analysed) -> String {
    let smooth_s = smooth_s([drive.per_second_mps.len(), drive.baseline_per_second_mps.len()]);
    let line = |name: &str, style: Style, values: &[f64]| Line {
        name: name.into(),
        style,
        points: smooth(values, smooth_s),
        band: Vec::new(),
    };
    let mut lines = vec![line("with advice", Style::solid(COLOURS[0]), &drive.per_second_mps)];
    if !drive.baseline_per_second_mps.is_empty() {
        let style = Style { dash: "5 3", ..Style::solid("#777777") };
        lines.push(line("without", style, &drive.baseline_per_second_mps));
    }
    let chart =
        Chart { lines: lines.clone(), ..Chart::new(title, time_axis(&lines), speed_axis(&lines), [700.0, 180.0]) };
    picture(&[chart], "")
}

/// Means of so many seconds, at their middle.
fn smooth(values: &[f64], seconds: usize) -> Vec<[f64; 2]> {
    let mean = |(i, part): (usize, &[f64])| {
        [(i * seconds) as f64 + part.len() as f64 / 2.0, part.iter().sum::<f64>() / part.len() as f64]
    };
    values.chunks(seconds).enumerate().map(mean).collect()
}

/// Seconds that are averaged where the longest drive has so many.
fn smooth_s(seconds: impl IntoIterator<Item = usize>) -> usize {
    let longest = seconds.into_iter().max().unwrap_or_default();
    longest.div_ceil(MOST_POINTS).max(SMOOTH_S)
}

fn time_axis(lines: &[Line]) -> Axis {
    let last = lines.iter().filter_map(|line| line.points.last()).map(|p| p[0]).fold(1.0, f64::max);
    Axis::even(TIME, [0.0, last + SMOOTH_S as f64 / 2.0])
}

fn speed_axis(lines: &[Line]) -> Axis {
    let points = lines.iter().flat_map(|l| l.points.iter().map(|p| p[1]).chain(l.band.iter().flatten().copied()));
    let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    let room = 0.06 * (high - low).max(0.1);
    Axis::even("mean speed of all cars, m/s", [(low - room).max(0.0), high + room])
}

/// Mean speed of all cars over time by condition: mean over participants and its 95 % interval; without advice dashed.
pub fn over_time(drives: &[Analysed]) -> Option<String> {
    let conditions = conditions(drives);
    let line = |name: String, style: Style, of: &[Vec<[f64; 2]>]| {
        let n = of.iter().map(Vec::len).min().unwrap_or(0);
        let estimates: Vec<([f64; 2], Estimate)> = (0..n)
            .filter_map(|i| {
                let values: Vec<f64> = of.iter().map(|values| values[i][1]).collect();
                let estimate = Estimate::of(&values)?;
                Some(([of[0][i][0], estimate.mean], estimate))
            })
            .collect();
        Line {
            name,
            style,
            points: estimates.iter().map(|e| e.0).collect(),
            band: estimates.iter().map(|e| [e.1.low, e.1.high]).collect(),
        }
    };
    let lengths = drives.iter().flat_map(|drive| [drive.per_second_mps.len(), drive.baseline_per_second_mps.len()]);
    let smooth_s = smooth_s(lengths);
    let without: Vec<Vec<[f64; 2]>> = conditions
        .iter()
        .flat_map(|(_, of)| of.iter().map(|drive| smooth(&drive.baseline_per_second_mps, smooth_s)))
        .filter(|values| !values.is_empty())
        .collect();
    let mut lines = Vec::new();
    if !without.is_empty() {
        let style = Style { dash: "5 3", ..Style::solid("#777777") };
        lines.push(line("without advice".into(), style, &without));
    }
    for (i, (name, of)) in conditions.iter().enumerate() {
        let of: Vec<Vec<[f64; 2]>> = of.iter().map(|drive| smooth(&drive.per_second_mps, smooth_s)).collect();
        lines.push(line(name.clone(), Style::solid(COLOURS[i % COLOURS.len()]), &of));
    }
    if lines.iter().all(|line| line.points.is_empty()) {
        return None;
    }
    let chart = Chart::new("", time_axis(&lines), speed_axis(&lines), [700.0, 260.0]);
    Some(picture(&[Chart { lines, ..chart }], "mean over participants; bands: its 95 % interval by bootstrap"))
}

/// A measure by condition: each participant a dot, joined by a line; beside them mean and 95 % interval.
pub fn distribution(drives: &[Analysed], measure: usize) -> Option<String> {
    let conditions = conditions(drives);
    let all: Vec<f64> = conditions.iter().flat_map(|(_, of)| values(of, measure)).collect();
    let (low, high) = all.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if all.len() < 2 || conditions.is_empty() {
        return None;
    }
    let what = &MEASURES[measure];
    let label = if what.unit.is_empty() { what.title.to_owned() } else { format!("{}, {}", what.title, what.unit) };
    let span = (high - low).max(if high.abs() > 0.0 { 0.02 * high.abs() } else { 1.0 });
    // Room above for the names of the conditions.
    let mut y = Axis::even(&label, [low - 0.08 * span, high + 0.24 * span]);
    y.ticks.retain(|tick| *tick <= high + 0.08 * span);
    let width = (110.0 * conditions.len() as f64).clamp(220.0, 700.0);
    let x =
        Axis { label: String::new(), range: [0.5, conditions.len() as f64 + 0.5], ticks: Vec::new(), is_log: false };
    let mut chart = Chart::new("", x, y, [width, 210.0]);
    chart.below = marks(&chart, &conditions, measure);
    Some(picture(&[chart], ""))
}

fn marks(chart: &Chart, conditions: &[(String, Vec<&Analysed>)], measure: usize) -> String {
    let mut out = String::new();
    let value = |of: &[&Analysed], who: &str| {
        of.iter().find(|drive| drive.found.participant == who).and_then(|drive| drive.measures.values[measure])
    };
    let mut people: Vec<&str> =
        conditions.iter().flat_map(|(_, of)| of.iter().map(|drive| drive.found.participant.as_str())).collect();
    people.sort_unstable();
    people.dedup();
    // Dots a little to the left of the middle, mean and interval to the right.
    let place = |i: usize, y: f64| chart.place(i as f64 + 0.9, y);
    for who in &people {
        let points: Vec<String> = conditions
            .iter()
            .enumerate()
            .filter_map(|(i, (_, of))| {
                let [x, y] = place(i, value(of, who)?);
                Some(format!("{x:.1},{y:.1}"))
            })
            .collect();
        // What reads the picture complains of a line without length, here and below.
        if points.len() > 1 {
            let _ = writeln!(
                out,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"#999\" stroke-width=\"0.7\" opacity=\"0.55\"/>",
                points.join(" ")
            );
        }
    }
    for (i, (name, of)) in conditions.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        for who in &people {
            let Some(v) = value(of, who) else { continue };
            let [x, y] = place(i, v);
            let _ = writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\" opacity=\"0.65\"/>");
        }
        if let Some(e) = Estimate::of(&values(of, measure)) {
            let [x, y] = chart.place(i as f64 + 1.14, e.mean);
            let [low, high] = [e.low, e.high].map(|v| chart.place(0.0, v)[1]);
            if low - high > 0.1 {
                let _ = writeln!(out, "<path d=\"M{x:.1} {low:.1}V{high:.1}\" stroke=\"#222\" stroke-width=\"2\"/>");
            }
            let _ = writeln!(
                out,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.2\" fill=\"{colour}\" stroke=\"#222\" stroke-width=\"1.4\"/>"
            );
        }
        let [x, _] = chart.place(i as f64 + 1.0, 0.0);
        let name = name.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"15\" text-anchor=\"middle\" font-weight=\"bold\">{name}</text>");
    }
    out
}
