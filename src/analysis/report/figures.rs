//! Figures of an analysis, as SVG. In: the traces of one drive, or analysed drives. Out: pictures without fonts or scripts of
//! their own. Their size does not grow from drives of hours to drives of days.

use crate::analysis::{
    data::{DriveTrajectories, RecordedTrial},
    drives::{AnalysedRecording, conditions, per_participant},
    measures::MEASURES,
};
use crate::{
    metrics::{Estimate, SpeedTrace, figures},
    plot::{Axis, COLOURS, Chart, ChartSheet, LineStyle, PlotLine, PlotShape, PrintWidth, lines_needed, picture},
};

/// Label of the time axis of a drive.
pub(super) const TIME: &str = "time since the start of the drive, s";
/// Upper end of marker lines, m/s: above any field, so that they cross it.
const TOP_MPS: f64 = 1e3;
/// Minimum averaging time of lines over time, s.
const SMOOTH_S: usize = 5;
/// Dash patterns of the lines: one for each round through the colours.
const DASHES: [&str; 4] = ["", "7 3", "2 3", "9 3 2 3"];
/// Largest number of points of a line over time: two for each unit of its width. Up to two hours they are 5 s apart.
const MOST_POINTS: usize = 1440;

/// Draws the positions of all vehicles, the ego thick: with advice, and without. Of a long drive only the beginning; the title
/// says so.
pub fn space_time(title: &str, drive: &DriveTrajectories, baseline: Option<&DriveTrajectories>) -> String {
    let named = |title: &str, drive: &DriveTrajectories| match drive.ways_end_s {
        Some(end_s) => format!("{title}, the first {:.0} min", end_s / 60.0),
        None => title.to_owned(),
    };
    let titles = [named(title, drive), baseline.map_or(String::new(), |of| named("Without advice", of))];
    let drawn = [Some(drive), baseline];
    let rings: Vec<_> = titles.iter().zip(drawn).filter_map(|(title, of)| Some((title.as_str(), &of?.ways))).collect();
    // A top of the colour scale somewhat above most speeds, so that standing and flowing differ in colour.
    let top_mps = (2.0 * drive.median_speed_mps.unwrap_or(5.0)).max(4.0);
    figures::space_time(&rings, top_mps, TIME, "")
}

/// Draws the ego's speed, the advice with its range, and the spread of all vehicles over time, with contacts and marks.
pub fn speeds(title: &str, drive: &DriveTrajectories, trial: &RecordedTrial) -> String {
    figures::speeds(title, &SpeedTrace::of(&drive.speeds), drive.range_mps, TIME, "", moments(trial))
}

/// Returns vertical lines at contacts, red lights and marks.
pub(super) fn moments(trial: &RecordedTrial) -> Vec<PlotLine> {
    let upright = |name: &str, style: LineStyle, times_s: Vec<f64>| {
        let line = move |(i, at_s): (usize, f64)| PlotLine {
            // One entry in the legend for all of them.
            name: if i == 0 { name.into() } else { String::new() },
            style,
            points: vec![[at_s, 0.0], [at_s, TOP_MPS]],
            band: Vec::new(),
        };
        times_s.into_iter().enumerate().map(line).collect::<Vec<_>>()
    };
    let contacts = trial.contacts_at.iter().map(|contact| contact[0]).collect();
    let mut more = upright("contact", LineStyle { width: 1.6, ..LineStyle::solid("#cc0000") }, contacts);
    let red = LineStyle { width: 1.2, dash: "2 2", ..LineStyle::solid("#cc0000") };
    more.extend(upright("red light", red, trial.red_lights_at.clone()));
    let marks = LineStyle { width: 1.0, dash: "4 3", ..LineStyle::solid("#555555") };
    more.extend(upright("mark", marks, trial.marks_at.clone()));
    more
}

/// Draws the mean speed of all vehicles over time, as driven (a trial may be without advice) and in the same drive without
/// advice.
pub fn gain(title: &str, drive: &AnalysedRecording) -> String {
    let smooth_s = smooth_s([drive.per_second_mps.len(), drive.baseline_per_second_mps.len()]);
    let line = |name: &str, style: LineStyle, values: &[f64]| PlotLine {
        name: name.into(),
        style,
        points: smooth(values, smooth_s),
        band: Vec::new(),
    };
    let mut lines = vec![line("as driven", LineStyle::solid(COLOURS[0]), &drive.per_second_mps)];
    if !drive.baseline_per_second_mps.is_empty() {
        let style = LineStyle { dash: "5 3", ..LineStyle::solid("#777777") };
        lines.push(line("without advice", style, &drive.baseline_per_second_mps));
    }
    let seconds = drive.per_second_mps.len().max(drive.baseline_per_second_mps.len());
    let chart = Chart::new(title, time_axis(seconds), speed_axis(&lines), 180.0);
    picture(&[Chart { lines, ..chart }], "")
}

/// Returns means over so many seconds, at the middle of each.
fn smooth(values: &[f64], seconds: usize) -> Vec<[f64; 2]> {
    let mean = |(i, part): (usize, &[f64])| {
        [(i * seconds) as f64 + part.len() as f64 / 2.0, part.iter().sum::<f64>() / part.len() as f64]
    };
    values.chunks(seconds).enumerate().map(mean).collect()
}

/// Returns the averaging time for the longest of these drives, s.
fn smooth_s(seconds: impl IntoIterator<Item = usize>) -> usize {
    let longest = seconds.into_iter().max().unwrap_or_default();
    longest.div_ceil(MOST_POINTS).max(SMOOTH_S)
}

fn time_axis(seconds: usize) -> Axis {
    Axis::even(TIME, [0.0, seconds.max(1) as f64])
}

fn speed_axis(lines: &[PlotLine]) -> Axis {
    let points = lines.iter().flat_map(|l| l.points.iter().map(|p| p[1]).chain(l.band.iter().flatten().copied()));
    let (low, high) = points.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
    let room = 0.06 * (high - low).max(0.1);
    Axis::even("mean speed of all vehicles, m/s", [(low - room).max(0.0), high + room])
}

/// Draws the mean speed of all vehicles over time by condition: mean over participants with its 95 % interval; without advice
/// dashed.
pub fn over_time(drives: &[AnalysedRecording]) -> Option<String> {
    let conditions = conditions(drives);
    let line = |name: String, style: LineStyle, of: &[Vec<[f64; 2]>]| {
        let n = of.iter().map(Vec::len).min().unwrap_or(0);
        let estimates: Vec<([f64; 2], Estimate)> = (0..n)
            .filter_map(|i| {
                let values: Vec<f64> = of.iter().map(|values| values[i][1]).collect();
                let estimate = Estimate::of(&values)?;
                Some(([of[0][i][0], estimate.mean], estimate))
            })
            .collect();
        PlotLine {
            name,
            style,
            points: estimates.iter().map(|e| e.0).collect(),
            band: estimates.iter().map(|e| [e.1.low, e.1.high]).collect(),
        }
    };
    // Practice has no condition: the axis ends with the trials.
    let drawn = conditions.iter().flat_map(|(_, of)| of.iter());
    let lengths = drawn.flat_map(|drive| [drive.per_second_mps.len(), drive.baseline_per_second_mps.len()]);
    let seconds = lengths.clone().max().unwrap_or_default();
    let smooth_s = smooth_s(lengths);
    let without: Vec<Vec<[f64; 2]>> = conditions
        .iter()
        .flat_map(|(_, of)| of.iter().map(|drive| smooth(&drive.baseline_per_second_mps, smooth_s)))
        .filter(|values| !values.is_empty())
        .collect();
    let mut lines = Vec::new();
    if !without.is_empty() {
        let style = LineStyle { dash: "5 3", ..LineStyle::solid("#777777") };
        lines.push(line("without advice".into(), style, &without));
    }
    for (i, (name, of)) in conditions.iter().enumerate() {
        let of: Vec<Vec<[f64; 2]>> = of.iter().map(|drive| smooth(&drive.per_second_mps, smooth_s)).collect();
        lines.push(line(
            name.clone(),
            LineStyle {
                dash: DASHES[i / COLOURS.len() % DASHES.len()],
                ..LineStyle::solid(COLOURS[i % COLOURS.len()])
            },
            &of,
        ));
    }
    if lines.iter().all(|line| line.points.is_empty()) {
        return None;
    }
    let chart = Chart::new("", time_axis(seconds), speed_axis(&lines), 250.0);
    Some(picture(&[Chart { lines, ..chart }], ""))
}

/// Draws a measure by condition: a dot for each participant, joined by lines, and mean and 95 % interval beside them; `None`
/// for fewer than two values. The picture has column width where names fit, else page width; with longer names its axes are
/// exchanged.
pub fn distribution(drives: &[AnalysedRecording], measure: usize) -> Option<String> {
    let conditions = conditions(drives);
    let groups: Vec<(&str, Vec<(&str, f64)>)> =
        conditions.iter().map(|(name, of)| (name.as_str(), per_participant(of, measure))).collect();
    let all = || groups.iter().flat_map(|(_, values)| values.iter().map(|(_, value)| *value));
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if all().count() < 2 {
        return None;
    }
    let span = (high - low).max(if high.abs() > 0.0 { 0.02 * high.abs() } else { 1.0 });
    let y = Axis::even(&MEASURES[measure].label(), [low - 0.08 * span, high + 0.08 * span]);
    let x = Axis::names(groups.iter().map(|(name, _)| (*name).to_owned()).collect());
    let chart = Chart { shapes: dots(&groups), ..Chart::new("", x, y, 190.0) };
    // The field is narrower than the picture by the ticks and the label on the left.
    let slot = |width: PrintWidth| (width.units() - 90.0) / groups.len() as f64 - 6.0;
    let stands = |width: &PrintWidth| {
        groups.iter().all(|(name, _)| lines_needed(name, slot(*width)).is_some_and(|lines| lines <= 3))
    };
    let (chart, width) = match [PrintWidth::Column, PrintWidth::Page].into_iter().find(stands) {
        Some(width) => (chart, width),
        None => (chart.transposed(), PrintWidth::Page),
    };
    Some(ChartSheet { charts: &[chart], width, key: None, note: "" }.svg())
}

/// Returns the lines that join a participant's dots, the dots, and means with their intervals.
fn dots(groups: &[(&str, Vec<(&str, f64)>)]) -> Vec<PlotShape> {
    // Dots a little left of the middle, mean and interval right of it.
    let (own, mean) = (|i: usize| i as f64 + 0.9, |i: usize| i as f64 + 1.14);
    let value = |i: usize, person: &str| {
        groups[i].1.iter().find(|(participant, _)| *participant == person).map(|found| found.1)
    };
    let mut people: Vec<&str> =
        groups.iter().flat_map(|(_, values)| values.iter().map(|(person, _)| *person)).collect();
    people.sort_unstable();
    people.dedup();
    let way = |person: &&str| {
        let points: Vec<[f64; 2]> = (0..groups.len()).filter_map(|i| Some([own(i), value(i, person)?])).collect();
        points.windows(2).map(|ends| [ends[0], ends[1]]).collect::<Vec<_>>()
    };
    let pieces = people.iter().flat_map(way).collect();
    let mut shapes = vec![PlotShape::Pieces { pieces, colour: "#c4c4c4".into(), width: 0.8 }];
    for (i, (_, values)) in groups.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()].to_owned();
        let dot = |at, radius, has_edge| PlotShape::Dot { at, radius, colour: colour.clone(), has_edge };
        shapes.extend(values.iter().map(|(_, value)| dot([own(i), *value], 3.0, false)));
        let numbers: Vec<f64> = values.iter().map(|(_, value)| *value).collect();
        if let Some(e) = Estimate::of(&numbers) {
            let pieces = vec![[[mean(i), e.low], [mean(i), e.high]]];
            shapes.push(PlotShape::Pieces { pieces, colour: "#222".into(), width: 2.0 });
            shapes.push(dot([mean(i), e.mean], 4.2, true));
        }
    }
    shapes
}
