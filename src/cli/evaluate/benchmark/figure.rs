//! Figures of a benchmark. In: a [`BenchmarkResult`]. Out: SVG, one for each road and hold, with the mean speed of each row and
//! an interval for each driver.

use super::{BenchmarkResult, Cell, Road};
use crate::{
    plot::{Axis, COLOURS, Chart, ChartSheet, LineStyle, PlotLine, PlotMark, PlotShape, PrintWidth},
    train::RingConfig,
};

/// Height of a driver's dot and of the gap between two rows, in units of the figure.
const DOT: f64 = 8.0;
const BETWEEN: f64 = 12.0;
/// Share of a row's height taken by its dots.
const DOTS: f64 = 0.72;

/// Returns each figure with its file name.
pub fn figures(result: &BenchmarkResult<'_>) -> Vec<(String, String)> {
    let mut figures = Vec::new();
    for (road, state) in result.benchmark.roads.iter().zip(&result.roads) {
        for hold_s in result.benchmark.all_holds_s() {
            let is_here = |cell: &&Cell<'_>| std::ptr::eq(cell.condition.road, road) && cell.condition.hold_s == hold_s;
            let cells: Vec<&Cell<'_>> = result.cells.iter().filter(is_here).collect();
            // A row may name its roads and holds, so that a figure may be empty.
            if cells.is_empty() {
                continue;
            }
            let name = format!("mean-speed-{}-hold-{hold_s}.svg", road.key());
            figures.push((name, figure(result, road, state.equilibrium_mps, hold_s, &cells)));
        }
    }
    figures
}

fn figure(result: &BenchmarkResult<'_>, road: &Road, equilibrium_mps: f64, hold_s: f64, cells: &[&Cell<'_>]) -> String {
    let benchmark = result.benchmark;
    let rows: Vec<usize> = (0..benchmark.rows.len()).filter(|row| cells.iter().any(|cell| cell.row == *row)).collect();
    let drivers: Vec<&str> = benchmark
        .drivers
        .iter()
        .map(|driver| driver.name.as_str())
        .filter(|name| cells.iter().any(|cell| cell.condition.driver.name == *name))
        .collect();
    let ends = [0.5, rows.len() as f64 + 0.5];
    let even = PlotLine {
        name: format!("even flow: {equilibrium_mps:.2} m/s"),
        style: LineStyle { width: 1.2, dash: "7 3", ..LineStyle::solid("#555555") },
        points: ends.map(|end| [equilibrium_mps, end]).to_vec(),
        band: Vec::new(),
    };
    // Lines separate the rows.
    let parting = |row: usize, span: [f64; 2]| [[span[0], row as f64 + 0.5], [span[1], row as f64 + 0.5]];
    let (mut low, mut high) = (equilibrium_mps, equilibrium_mps);
    let (mut lines, mut intervals, mut marks) = (vec![even], Vec::new(), Vec::new());
    for (k, driver) in drivers.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let beside = DOTS * ((k as f64 + 0.5) / drivers.len() as f64 - 0.5);
        let (mut points, mut pieces) = (Vec::new(), Vec::new());
        for cell in cells.iter().filter(|cell| cell.condition.driver.name == *driver) {
            let Some(row) = rows.iter().position(|row| *row == cell.row) else { continue };
            let (at, speed) = (row as f64 + 1.0 + beside, cell.speed());
            (low, high) = (low.min(speed.low), high.max(speed.high));
            points.push([speed.mean, at]);
            pieces.push([[speed.low, at], [speed.high, at]]);
            let [crashed, driven] = cell.crashes();
            if crashed > 0 {
                marks.push(PlotMark { at: [speed.mean, at], text: format!("{crashed} of {driven} crashed") });
            }
        }
        intervals.push(PlotShape::Pieces { pieces, colour: colour.into(), width: 1.8 });
        // Dots without a line: the rows have no order.
        let style = LineStyle { width: 0.0, dots: true, ..LineStyle::solid(colour) };
        lines.push(PlotLine { name: (*driver).into(), style, points, band: Vec::new() });
    }
    let room = (0.04 * (high - low)).max(0.02);
    let span = [(low - room).max(0.0), high + room];
    let partings = (1..rows.len()).map(|row| parting(row, span)).collect();
    let mut shapes = vec![PlotShape::Pieces { pieces: partings, colour: "#e4e4e4".into(), width: 1.0 }];
    shapes.extend(intervals);
    let x = Axis::even("mean speed of all vehicles, m/s", span);
    let mut y = Axis::names(rows.iter().map(|row| benchmark.rows[*row].name.clone()).collect());
    // The first row is at the top.
    y.range.reverse();
    let height = rows.len() as f64 * (DOT * drivers.len() as f64 + BETWEEN);
    let title = format!("{}, hold {hold_s} s", road.name);
    let chart = Chart { lines, shapes, marks, ..Chart::new(&title, x, y, height) };
    let ring = RingConfig::default();
    let note = format!(
        "dot: mean of {} rings, seed {}; {} s after {} s of warm-up from a bunched start, transients included; line: \
         95 % interval over rings and training seeds",
        benchmark.rings, benchmark.seed, ring.horizon_s, ring.warm_up_s
    );
    ChartSheet { charts: &[chart], width: PrintWidth::Page, key: None, note: &note }.svg()
}
