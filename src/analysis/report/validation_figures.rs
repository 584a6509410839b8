//! Figures of traffic beside measured people. In: trajectories, their persons and gains, and the values of people. Out: SVG.

use crate::{
    metrics::traffic_moments::{GAP_QUANTILES_M, MeasuredTraffic, PersonMoments, VehicleTrajectories},
    metrics::waves::{GAIN_HZ, WaveTotals},
    plot::{Axis, COLOURS, Chart, ChartSheet, ColourKey, LineStyle, PlotLine, PlotShape, PrintWidth},
};

/// Names of the two lines of a figure.
const MODEL: &str = "model";
const PEOPLE: &str = "people";
/// Gains of the table of criteria: frequency in Hz and name of the moment.
const PEOPLES_GAINS: [(f64, &str); 4] =
    [(0.03, "gain_at_0_03_hz"), (0.06, "gain_at_0_06_hz"), (0.1, "gain_at_0_1_hz"), (0.15, "gain_at_0_15_hz")];

/// Draws the positions of all vehicles, coloured by speed; `None` off a ring of known length.
pub(super) fn space_time(all: &VehicleTrajectories) -> Option<String> {
    /// Time of a piece of one colour, s.
    const PIECE_S: f64 = 1.0;
    let (ring_m, rows) = (all.ring_m?, all.positions_m()?);
    let top_mps = all.vehicles.iter().flat_map(|vehicle| &vehicle.speed_mps).copied().fold(1.0, f64::max);
    let key = ColourKey::up_to("speed, m/s", top_mps);
    let mut pieces = vec![Vec::new(); key.colours.len()];
    let stride = (PIECE_S / all.step_s).round().max(1.0) as usize;
    for from in (0..rows.len().saturating_sub(stride)).step_by(stride) {
        let time_s = [from, from + stride].map(|step| step as f64 * all.step_s);
        for (vehicle, trajectory) in all.vehicles.iter().enumerate() {
            let start_m = rows[from][vehicle].rem_euclid(ring_m);
            let end_m = start_m + rows[from + stride][vehicle] - rows[from][vehicle];
            let class = key.class(trajectory.speed_mps[from]);
            pieces[class].push([[time_s[0], start_m], [time_s[1], end_m]]);
            // A piece over the end of the ring is repeated from its start.
            if end_m > ring_m {
                pieces[class].push([[time_s[0], start_m - ring_m], [time_s[1], end_m - ring_m]]);
            }
        }
    }
    let shape = |(pieces, colour): (Vec<_>, &String)| PlotShape::Pieces { pieces, colour: colour.clone(), width: 1.0 };
    let [x, y] = [
        Axis::even("time, s", [0.0, all.steps() as f64 * all.step_s]),
        Axis::even("position along the ring, m", [0.0, ring_m]),
    ];
    let shapes = pieces.into_iter().zip(&key.colours).map(shape).collect();
    let chart = Chart { shapes, ..Chart::new("", x, y, 220.0) };
    Some(ChartSheet { charts: &[chart], width: PrintWidth::Page, key: Some(&key), note: "" }.svg())
}

/// Draws the distribution of speeds, and that of gaps beside people's.
pub(super) fn distributions(all: &VehicleTrajectories) -> String {
    let sorted = |of: fn(&crate::metrics::traffic_moments::VehicleTrajectory) -> &Vec<f64>| {
        let mut values: Vec<f64> = all.vehicles.iter().flat_map(of).copied().collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let gaps = [line(MODEL, shares(&sorted(|vehicle| &vehicle.gap_m))), people(shares(&GAP_QUANTILES_M))];
    let speeds = [line(MODEL, shares(&sorted(|vehicle| &vehicle.speed_mps)))];
    column(&[chart(&gaps, "gap, m", "share of gaps below"), chart(&speeds, "speed, m/s", "share of speeds below")])
}

/// Draws the gain from leader to follower by frequency.
pub(super) fn gains(waves: &WaveTotals, measured: &MeasuredTraffic) -> String {
    let model = GAIN_HZ.iter().filter_map(|hz| Some([*hz, waves.gain(*hz)?])).collect();
    let known = PEOPLES_GAINS.iter().filter_map(|(hz, name)| Some((*hz, measured.criterion(name)?)));
    let known: Vec<_> = known.collect();
    let people = PlotLine {
        band: known.iter().filter_map(|(_, criterion)| criterion.band).collect(),
        ..people(known.iter().map(|(hz, criterion)| [*hz, criterion.people]).collect())
    };
    column(&[chart(&[line(MODEL, model), people], "frequency, Hz", "gain from leader to follower")])
}

/// Draws the persons' time gaps and lags in order of size.
pub(super) fn persons(persons: &[PersonMoments], measured: &MeasuredTraffic) -> String {
    let of_people = |names: [&str; 3]| {
        let value = |(share, name): (f64, &str)| Some([measured.criterion(name)?.people, share]);
        [0.0, 0.5, 1.0].into_iter().zip(names).filter_map(value).collect()
    };
    let of_model = |of: fn(&PersonMoments) -> Option<f64>| {
        let mut values: Vec<f64> = persons.iter().filter_map(of).collect();
        values.sort_by(f64::total_cmp);
        shares(&values)
    };
    let time_gaps = [
        line(MODEL, of_model(|person| person.time_gap_s)),
        people(of_people(["shortest_person_time_gap_s", "person_time_gap_s", "longest_person_time_gap_s"])),
    ];
    let lags = [
        line(MODEL, of_model(|person| person.lag_s)),
        people(of_people(["shortest_person_lag_s", "lag_s", "longest_person_lag_s"])),
    ];
    column(&[
        chart(&time_gaps, "median time gap of a person, s", "share of persons below"),
        chart(&lags, "lag of a person to the leader's speed, s", "share of persons below"),
    ])
}

/// Returns at most 200 values of a sorted list, each with the share of the list below it.
fn shares(sorted: &[f64]) -> Vec<[f64; 2]> {
    let last = sorted.len().saturating_sub(1);
    let points = last.min(200);
    let point = |i: usize| {
        let at = i * last / points.max(1);
        [sorted[at], at as f64 / last.max(1) as f64]
    };
    if sorted.is_empty() { Vec::new() } else { (0..=points).map(point).collect() }
}

fn line(name: &str, points: Vec<[f64; 2]>) -> PlotLine {
    PlotLine { name: name.into(), style: LineStyle::solid(COLOURS[0]), points, band: Vec::new() }
}

fn people(points: Vec<[f64; 2]>) -> PlotLine {
    let style = LineStyle { dash: "5 3", dots: points.len() < 9, ..LineStyle::solid(COLOURS[1]) };
    PlotLine { style, ..line(PEOPLE, points) }
}

/// Returns a chart with axes around its lines, the vertical one from 0 on.
fn chart(lines: &[PlotLine], x: &str, y: &str) -> Chart {
    let all = || lines.iter().flat_map(|line| &line.points);
    let end = |k: usize, of: fn(f64, f64) -> f64, start: f64| all().map(|point| point[k]).fold(start, of);
    let [low, high] = [end(0, f64::min, f64::INFINITY), end(0, f64::max, f64::NEG_INFINITY)];
    let x_range = if low < high { [low, high] } else { [0.0, 1.0] };
    let [x, y] = [Axis::even(x, x_range), Axis::even(y, [0.0, end(1, f64::max, 1.0)])];
    Chart {
        lines: lines.iter().filter(|line| !line.points.is_empty()).cloned().collect(),
        ..Chart::new("", x, y, 200.0)
    }
}

fn column(charts: &[Chart]) -> String {
    ChartSheet { charts, width: PrintWidth::Column, key: None, note: "" }.svg()
}
