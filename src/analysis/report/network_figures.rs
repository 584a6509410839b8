//! Figures of a drive on a network, as SVG. In: [`PathTraces`]. Out: positions along the ego's path over time, and speeds over time.

use super::figures as of_drives;
use crate::analysis::{
    data::RecordedTrial,
    network::{PathTraces, SignalBar, TracePiece},
};
use crate::{
    map::network::SignalLight,
    metrics::figures,
    plot::{Axis, Chart, ChartSheet, ColourKey, LineStyle, PlotLine, PlotShape, PrintWidth},
};

/// Bars of signals by light, which differ in width as well as colour: name, colour and width.
const LIGHTS: [(&str, &str, f64); 3] =
    [("signal red", "#d7191c", 3.4), ("signal yellow", "#f2b705", 2.4), ("signal green", "#1a9850", 1.4)];
/// Height of a field, units of the picture.
const HEIGHT: f64 = 300.0;

/// Draws the positions of all vehicles along the ego's path and the signals at its lines: as driven, and without advice.
pub fn space_time(title: &str, drive: &PathTraces, baseline: Option<&PathTraces>) -> String {
    let top_mps = baseline.map_or(0.0, |baseline| baseline.top_speed_mps).max(drive.top_speed_mps);
    let key = ColourKey::up_to("speed, m/s; ego vehicle outlined", top_mps.max(4.0));
    let named = |title: &str, traces: &PathTraces| match traces.ends_s {
        Some(end_s) => format!("{title}, the first {:.0} min", end_s / 60.0),
        None => title.to_owned(),
    };
    let drawn = [(title, Some(drive)), ("Without advice", baseline)];
    let drawn: Vec<(String, &PathTraces)> =
        drawn.into_iter().filter_map(|(title, of)| Some((named(title, of?), of?))).collect();
    // One time axis for all charts, so that equal times are above each other.
    let end_s = drawn.iter().map(|(_, of)| of.ends_s.unwrap_or(of.span_s[1])).fold(0.0, f64::max);
    let shown = |k: usize, least: fn(f64, f64) -> f64| {
        drawn.iter().map(|(_, of)| of.shown_m[k]).reduce(least).unwrap_or_default()
    };
    let shown_m = [shown(0, f64::min), shown(1, f64::max)];
    let chart = |(i, (title, traces)): (usize, &(String, &PathTraces))| {
        let is_last = i + 1 == drawn.len();
        let x = Axis::even(if is_last { of_drives::TIME } else { "" }, [0.0, end_s]);
        let y = Axis::even("position along the ego vehicle's path, m", shown_m);
        let (shapes, lines) = (shapes(traces, &key), legend(&traces.signals, is_last));
        Chart { shapes, lines, ..Chart::new(title, x, y, HEIGHT) }
    };
    let charts: Vec<Chart> = drawn.iter().enumerate().map(chart).collect();
    ChartSheet { charts: &charts, width: PrintWidth::Page, key: Some(&key), note: "" }.svg()
}

/// Returns the shapes in drawing order: signals, other vehicles, ego.
fn shapes(traces: &PathTraces, key: &ColourKey) -> Vec<PlotShape> {
    let coloured = |pieces: &[TracePiece], width: f64| {
        let mut classes = vec![Vec::new(); key.colours.len()];
        pieces.iter().for_each(|piece| classes[key.class(piece.speed_mps)].push(piece.ends));
        let shape =
            move |(pieces, colour): (Vec<_>, &String)| PlotShape::Pieces { pieces, colour: colour.clone(), width };
        classes.into_iter().zip(&key.colours).map(shape).collect::<Vec<_>>()
    };
    let bars = LIGHTS.iter().enumerate().map(|(k, (_, colour, width))| {
        let of_bar = |bar: &SignalBar| {
            let s_m = bar.s_m;
            let shown = bar.spans.iter().filter(|span| kind(span.1) == Some(k));
            shown.map(|([from_s, to_s], _)| [[*from_s, s_m], [*to_s, s_m]]).collect::<Vec<_>>()
        };
        let pieces = traces.signals.iter().flat_map(of_bar).collect();
        PlotShape::Pieces { pieces, colour: (*colour).into(), width: *width }
    });
    let ego: Vec<[[f64; 2]; 2]> = traces.ego.iter().map(|piece| piece.ends).collect();
    let edge = PlotShape::Pieces { pieces: ego, colour: "#111".into(), width: 5.4 };
    [bars.collect(), coloured(&traces.others, 1.2), vec![edge], coloured(&traces.ego, 3.0)].concat()
}

/// Returns the index of a light in [`LIGHTS`]; `None` for a signal that is off.
fn kind(light: SignalLight) -> Option<usize> {
    match light {
        SignalLight::Red | SignalLight::RedYellow => Some(0),
        SignalLight::Yellow => Some(1),
        SignalLight::GreenMinor | SignalLight::GreenMajor | SignalLight::GreenArrow => Some(2),
        SignalLight::OffBlinking | SignalLight::Off => None,
    }
}

/// Returns the legend of the lights that are drawn, below the last chart only.
fn legend(signals: &[SignalBar], is_last: bool) -> Vec<PlotLine> {
    let is_shown = |k: &usize| signals.iter().flat_map(|bar| &bar.spans).any(|span| kind(span.1) == Some(*k));
    let line = |k: usize| PlotLine {
        name: LIGHTS[k].0.into(),
        style: LineStyle { width: LIGHTS[k].2, ..LineStyle::solid(LIGHTS[k].1) },
        points: Vec::new(),
        band: Vec::new(),
    };
    (0..LIGHTS.len()).filter(|_| is_last).filter(is_shown).map(line).collect()
}

/// Draws the ego's speed, the advice with its range and the mean of all vehicles over time, with contacts, red lights and
/// marks.
pub fn speeds(title: &str, drive: &PathTraces, trial: &RecordedTrial) -> String {
    let range_mps = trial.first_advice.map_or(0.0, |advice| advice.range_mps[1] - advice.target_mps);
    figures::speeds(title, &drive.speeds, range_mps, of_drives::TIME, "", of_drives::moments(trial))
}

#[cfg(test)]
#[path = "network_figures_tests.rs"]
mod tests;
