//! Figures of an evaluation. In: measured results, or one ring step by step. Out: SVG. The published series is from
//! docs/references.md: holds.

use super::{Estimate, SpeedTrace, Trajectories};
use crate::plot::{
    Axis, COLOURS, Chart, ChartSheet, ColourKey, LineStyle, PlotLine, PlotMark, PlotShape, PrintWidth, picture,
};

/// Published mean speed by hold, for acceleration advice, as listed in a notebook of SW21's group (docs/references.md: holds):
/// hold in seconds, speed in m/s.
pub const PUBLISHED: [[f64; 2]; 19] = [
    [0.1, 4.249],
    [1.0, 4.331],
    [2.0, 4.327],
    [5.0, 4.316],
    [8.0, 4.303],
    [10.0, 4.311],
    [13.0, 4.296],
    [14.0, 4.127],
    [15.0, 4.006],
    [17.0, 4.178],
    [20.0, 4.053],
    [22.0, 4.215],
    [24.0, 3.977],
    [25.0, 3.330],
    [26.0, 1.810],
    [27.0, 4.197],
    [28.0, 2.848],
    [29.0, 1.233],
    [30.0, 3.319],
];
/// Hand-designed optimum of SW21 on its ring, m/s.
const BY_HAND_MPS: f64 = 4.43;

/// A measured line: a name, and an estimate at each place of the horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Index of its colour, and of its dash pattern.
    pub look: [usize; 2],
    /// Points from left to right.
    pub points: Vec<Point>,
}

/// A point of a measured line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position on the horizontal axis.
    pub at: f64,
    /// Mean measured at this position.
    pub mean: Estimate,
    /// Number of drives that ended in a crash, and number of all drives.
    pub crashes: [usize; 2],
}

/// Draws mean speed against the hold, with the equilibrium speed of an even ring; on the paper's ring also with the published
/// series and the hand-designed optimum.
pub fn against_hold(series: &[Series], equilibrium_mps: f64, is_paper_ring: bool, note: &str) -> String {
    let holds: Vec<f64> = series.iter().flat_map(|s| s.points.iter().map(|p| p.at)).collect();
    let (low, high) = ends(holds.into_iter());
    let x = if high > low {
        Axis::ratios("hold, s (logarithmic)", [low, high])
    } else {
        Axis::even("hold, s", [low - 0.5, high + 0.5])
    };
    // The published series falls to 1.2 m/s: the axis follows the measured values.
    let y =
        Axis::even("mean speed of all vehicles, m/s", around_with(&measured(series), [equilibrium_mps, BY_HAND_MPS]));
    let mut lines = vec![level("even ring (equilibrium)", equilibrium_mps, [low, high], "7 3")];
    if is_paper_ring {
        lines.push(level("optimum by hand (Sridhar, Wu 2021)", BY_HAND_MPS, [low, high], "2 3"));
        lines.push(PlotLine {
            name: "published series, acceleration advice".into(),
            style: LineStyle { dots: true, dash: "4 3", width: 1.2, ..LineStyle::solid("#999999") },
            points: PUBLISHED.to_vec(),
            band: Vec::new(),
        });
    }
    lines.extend(measured(series));
    let below =
        PUBLISHED.iter().filter(|p| is_paper_ring && p[1] < y.range[0]).map(|p| format!("{} s: {}", p[0], p[1]));
    let below: Vec<String> = below.collect();
    let mut note = note.to_owned();
    if !below.is_empty() {
        note.push_str(&format!("\npublished values below the axis, m/s: {}", below.join(", ")));
    }
    let marks = crash_marks(series);
    picture(&[Chart { lines, marks, ..Chart::new("Mean speed against the hold", x, y, 350.0) }], &note)
}

/// Draws mean speed against the share of advised vehicles, in percent; on a ring with the equilibrium speed of an even ring.
pub fn against_share(series: &[Series], equilibrium_mps: Option<f64>, note: &str) -> String {
    let (_, most) = ends(series.iter().flat_map(|s| s.points.iter().map(|p| p.at)));
    let x = Axis::even("advised vehicles, % of all", [0.0, most.max(1.0)]);
    let lines = measured(series);
    let around = equilibrium_mps.map_or_else(|| around(&lines), |even_mps| around_with(&lines, [even_mps; 2]));
    let y = Axis::even("mean speed of all vehicles, m/s", around);
    let even = equilibrium_mps.map(|even_mps| level("even ring (equilibrium)", even_mps, x.range, "7 3"));
    let lines = even.into_iter().chain(lines).collect();
    let chart = Chart::new("Mean speed against the share of advised vehicles", x, y, 350.0);
    picture(&[Chart { lines, marks: crash_marks(series), ..chart }], note)
}

/// Draws mean speed against traits of the driver, one chart for each.
pub fn adherence(charts: &[(&str, Vec<Series>)], note: &str) -> String {
    let chart = |(i, (label, series)): (usize, &(&str, Vec<Series>))| {
        let mut lines = measured(series);
        // One legend for all charts, under the last.
        if i + 1 < charts.len() {
            lines.iter_mut().for_each(|line| line.name.clear());
        }
        let (x, y) = (Axis::even(label, ends_of(&lines, 0)), Axis::even("mean speed, m/s", around(&lines)));
        Chart { lines, marks: crash_marks(series), ..Chart::new("", x, y, 220.0) }
    };
    picture(&charts.iter().enumerate().map(chart).collect::<Vec<_>>(), note)
}

/// Label of the time axis of a ring.
pub const SINCE_ADVICE: &str = "time since the first advice, s";

/// Draws the positions of all vehicles, coloured by speed, for each of these rings. `time` labels the axis.
pub fn space_time(traces: &[(&str, &Trajectories)], top_mps: f64, time: &str, note: &str) -> String {
    let key = ColourKey::up_to("speed, m/s; ego vehicle outlined", top_mps);
    // One time axis for all charts, so that equal times are above each other.
    let spans = || traces.iter().map(|(_, trace)| trace.span_s());
    let (low, high) = (ends(spans().map(|span| span[0])).0, ends(spans().map(|span| span[1])).1);
    let chart = |(i, (title, trace)): (usize, &(&str, &Trajectories))| {
        // The axis is labelled once, below the last chart.
        let time = if i + 1 < traces.len() { "" } else { time };
        let y = Axis::even("position along the road, m", [0.0, trace.circumference_m]);
        let place_m = trace.way_m.last().map_or(0.0, |cars| f64::from(cars[0]).rem_euclid(trace.circumference_m));
        Chart {
            shapes: ways(trace, &key),
            marks: crash_mark(trace.crash_s, place_m),
            ..Chart::new(title, Axis::even(time, [low, high]), y, 200.0)
        }
    };
    let charts: Vec<Chart> = traces.iter().enumerate().map(chart).collect();
    ChartSheet { charts: &charts, width: PrintWidth::Page, key: Some(&key), note }.svg()
}

/// Returns the mark of a crash that ended a trace; nothing is drawn after it.
fn crash_mark(crash_s: Option<f64>, y: f64) -> Vec<PlotMark> {
    let mark = |time_s: f64| PlotMark { at: [time_s, y], text: format!("CRASH at {time_s:.1} s") };
    crash_s.map(mark).into_iter().collect()
}

/// Returns the pieces of the vehicles' positions, grouped by colour; the ego's are above the others, with a dark edge.
fn ways(trace: &Trajectories, key: &ColourKey) -> Vec<PlotShape> {
    /// Steps per piece: at 0.1 s, the wave's period of 34 s has 23 pieces.
    const STRIDE: usize = 15;
    let length_m = trace.circumference_m;
    let classes = key.colours.len();
    let mut pieces = vec![Vec::new(); 2 * classes];
    let cars = trace.way_m.first().map_or(0, Vec::len);
    let last = trace.time_s.len().saturating_sub(1);
    for i in (0..last).step_by(STRIDE) {
        // The last piece is as long as the rest.
        let next = (i + STRIDE).min(last);
        for k in 0..cars {
            let (from_m, to_m) = (f64::from(trace.way_m[i][k]), f64::from(trace.way_m[next][k]));
            let class = key.class(f64::from(trace.speed_mps[i][k])) + if k == 0 { classes } else { 0 };
            let start_m = from_m.rem_euclid(length_m);
            let mut piece = |a: f64, b: f64| pieces[class].push([[trace.time_s[i], a], [trace.time_s[next], b]]);
            piece(start_m, start_m + to_m - from_m);
            // A piece over the end of the road is repeated from its start.
            if start_m + to_m - from_m > length_m {
                piece(start_m - length_m, start_m + to_m - from_m - length_m);
            }
        }
    }
    let ego = pieces.split_off(classes);
    let edge = PlotShape::Pieces { pieces: ego.concat(), colour: "#111".into(), width: 5.4 };
    let coloured = |pieces: Vec<Vec<_>>, width: f64| {
        let shape =
            move |(pieces, colour): (Vec<_>, &String)| PlotShape::Pieces { pieces, colour: colour.clone(), width };
        pieces.into_iter().zip(&key.colours).map(shape).collect::<Vec<_>>()
    };
    [coloured(pieces, 1.0), vec![edge], coloured(ego, 3.2)].concat()
}

/// Draws the advised speed, the ego's speed, and mean and extremes of all vehicles, with the lines `more`. `time` labels the
/// axis.
pub fn speeds(title: &str, trace: &SpeedTrace, range_mps: f64, time: &str, note: &str, more: Vec<PlotLine>) -> String {
    let every = (trace.time_s.len() / 1200).max(1);
    let last = trace.time_s.len().checked_sub(1).filter(|last| !last.is_multiple_of(every));
    let steps = || (0..trace.time_s.len()).step_by(every).chain(last);
    let line = |name: &str, style: LineStyle, of: &dyn Fn(usize) -> Option<f64>| PlotLine {
        name: name.into(),
        style,
        points: steps().filter_map(|i| of(i).map(|y| [trace.time_s[i], y])).collect(),
        band: Vec::new(),
    };
    let mut shown =
        line("advised speed and its range", LineStyle { width: 1.4, ..LineStyle::solid(COLOURS[2]) }, &|i| {
            trace.shown_mps[i]
        });
    shown.band = shown.points.iter().map(|p| [(p[1] - range_mps).max(0.0), p[1] + range_mps]).collect();
    let has_extremes = !trace.extremes_mps.is_empty();
    let all = if has_extremes { "all vehicles: mean and extremes" } else { "all vehicles: mean" };
    let mean = LineStyle { width: 1.4, ..LineStyle::solid(COLOURS[7]) };
    let mut spread = line(all, mean, &|i| trace.mean_mps.get(i).copied());
    spread.band = if has_extremes { steps().map(|i| trace.extremes_mps[i]).collect() } else { Vec::new() };
    let ego = line("ego vehicle", LineStyle { width: 1.2, ..LineStyle::solid(COLOURS[1]) }, &|i| {
        trace.ego_mps.get(i).copied()
    });
    let drawn = [&spread, &shown, &ego].into_iter();
    let tops = drawn.flat_map(|l| l.band.iter().map(|b| b[1]).chain(l.points.iter().map(|p| p[1])));
    let high = tops.fold(1.0, f64::max);
    let mut lines = vec![spread, shown, ego];
    // Without extremes, lines without points have no entry in the legend.
    lines.retain(|line| has_extremes || !line.points.is_empty());
    lines.extend(more);
    let x = Axis::even(time, trace.span_s());
    let marks = crash_mark(trace.crash_s, trace.ego_mps.last().copied().unwrap_or_default());
    let chart = Chart { lines, marks, ..Chart::new(title, x, Axis::even("speed, m/s", [0.0, high]), 200.0) };
    picture(&[chart], note)
}

fn measured(series: &[Series]) -> Vec<PlotLine> {
    const DASHES: [&str; 4] = ["", "7 3", "2 3", "9 3 2 3"];
    let line = |s: &Series| PlotLine {
        name: s.name.clone(),
        style: LineStyle {
            dots: true,
            dash: DASHES[s.look[1] % DASHES.len()],
            ..LineStyle::solid(COLOURS[s.look[0] % COLOURS.len()])
        },
        points: s.points.iter().map(|p| [p.at, p.mean.mean]).collect(),
        band: s.points.iter().map(|p| [p.mean.low, p.mean.high]).collect(),
    };
    series.iter().map(line).collect()
}

/// Returns the marks of estimates with crashes.
fn crash_marks(series: &[Series]) -> Vec<PlotMark> {
    let points = series.iter().flat_map(|s| &s.points).filter(|p| p.crashes[0] > 0);
    points
        .map(|p| PlotMark { at: [p.at, p.mean.mean], text: format!("{} of {} crashed", p.crashes[0], p.crashes[1]) })
        .collect()
}

fn level(name: &str, y: f64, [low, high]: [f64; 2], dash: &'static str) -> PlotLine {
    let style = LineStyle { width: 1.2, dash, ..LineStyle::solid("#555555") };
    PlotLine { name: name.into(), style, points: vec![[low * 0.5, y], [high * 2.0, y]], band: Vec::new() }
}

fn ends(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
}

fn ends_of(lines: &[PlotLine], k: usize) -> [f64; 2] {
    let (low, high) = ends(lines.iter().flat_map(|l| l.points.iter().map(move |p| p[k])));
    [low, high]
}

/// Returns the range of all values with a margin above and below.
fn around(lines: &[PlotLine]) -> [f64; 2] {
    around_with(lines, [f64::INFINITY, f64::NEG_INFINITY])
}

fn around_with(lines: &[PlotLine], [from, to]: [f64; 2]) -> [f64; 2] {
    let [low, high] = ends_of(lines, 1);
    let (low, high) = (low.min(from), high.max(to));
    let bands = lines.iter().flat_map(|l| l.band.iter());
    let (low, high) = bands.fold((low, high), |(low, high), b| (low.min(b[0]), high.max(b[1])));
    let room = ((high - low) * 0.06).max(0.02);
    [(low - room).max(0.0), high + room]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(mean: f64) -> Estimate {
        Estimate { mean, low: mean - 0.1, high: mean + 0.1 }
    }

    fn trace() -> Trajectories {
        let rows = 0..200;
        Trajectories {
            circumference_m: 100.0,
            time_s: rows.clone().map(|i| f64::from(i) * 0.1 - 5.0).collect(),
            way_m: rows.clone().map(|i| vec![i as f32, i as f32 - 20.0]).collect(),
            speed_mps: rows.clone().map(|i| vec![4.0, i as f32 * 0.02]).collect(),
            shown_mps: rows.map(|i| (i > 50).then_some(4.2)).collect(),
            ..Trajectories::default()
        }
    }

    #[test]
    fn a_crash_is_marked_and_nothing_is_drawn_after_it() {
        let whole = trace();
        let cut = Trajectories { crash_s: Some(3.0), span_s: Some([-5.0, 15.0]), ..trace() };
        let cut = Trajectories { time_s: cut.time_s[..80].to_vec(), way_m: cut.way_m[..80].to_vec(), ..cut };
        let cut =
            Trajectories { speed_mps: cut.speed_mps[..80].to_vec(), shown_mps: cut.shown_mps[..80].to_vec(), ..cut };
        assert_eq!(cut.span_s(), [-5.0, 15.0], "the axis is that of a whole drive");
        let of = |trace: &Trajectories| speeds("", &SpeedTrace::of(trace), 0.4, "", "", Vec::new());
        for (whole, cut) in
            [(space_time(&[("", &whole)], 9.0, "", ""), space_time(&[("", &cut)], 9.0, "", "")), (of(&whole), of(&cut))]
        {
            assert!(cut.contains(">CRASH at 3.0 s<") && !whole.contains("CRASH"));
            // 8 of 20 s are driven: of about 700 units the last point lies before 290.
            let most = |text: &str| {
                let points =
                    text.split(['"', ' ', 'L', 'M']).filter_map(|p| p.split_once(',').map_or(p, |p| p.0).parse().ok());
                points.filter(|x: &f64| *x > 290.0 && *x < 680.0).count()
            };
            assert!(most(&cut) < most(&whole), "{cut}");
        }
        let point = |crashes| Point { at: 1.0, mean: estimate(0.1), crashes };
        let series = |crashes| [Series { name: "pi".into(), look: [0, 0], points: vec![point(crashes)] }];
        assert!(against_hold(&series([19, 20]), 4.362, true, "").contains(">19 of 20 crashed<"));
        assert!(!against_hold(&series([0, 20]), 4.362, true, "").contains("crashed"));
        assert!(adherence(&[("error, m/s", series([2, 20]).to_vec())], "").contains(">2 of 20 crashed<"));
    }

    #[test]
    fn every_figure_is_well_formed() {
        let series = |n: usize| {
            vec![Series {
                name: "a & b".into(),
                look: [0, 9],
                points: (1..=n).map(|i| Point { at: i as f64, mean: estimate(4.0), crashes: [0, 3] }).collect(),
            }]
        };
        for text in [
            against_hold(&series(3), 4.362, true, "20 rings"),
            against_hold(&series(1), 4.362, false, ""),
            adherence(&[("reaction, s", series(4)), ("error, m/s", series(2))], "two lines\nof notes"),
            space_time(&[("before", &trace()), ("after", &trace())], 9.0, SINCE_ADVICE, "a note"),
            speeds("one ring", &SpeedTrace::of(&trace()), 0.447, SINCE_ADVICE, "", Vec::new()),
        ] {
            roxmltree::Document::parse(&text).unwrap();
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }

    #[test]
    fn a_way_over_the_end_of_the_road_comes_in_at_its_beginning() {
        let trace = trace();
        // 14 pieces each. The first vehicle crosses the end within a piece, at step 100; the second, which starts at -20 m, at
        // step 20.
        let count = |shape: &PlotShape| if let PlotShape::Pieces { pieces, .. } = shape { pieces.len() } else { 0 };
        let pieces: usize = ways(&trace, &ColourKey::up_to("", 9.0)).iter().map(count).sum();
        // The ego's pieces are drawn twice: an edge and its colour.
        assert_eq!(pieces, 3 * 14 + 3);
    }

    #[test]
    fn ways_and_speeds_go_to_the_last_step_and_the_axis_ends_there() {
        // 60 s of 0.1 s steps are 40 pieces of 1.5 s, less one step; the other lengths leave a rest.
        for (steps, last_s) in [(600, 60.0), (1234, 123.4), (21, 2.1), (4001, 400.1)] {
            let rows = 1..=steps;
            let trace = Trajectories {
                circumference_m: 100.0,
                time_s: rows.clone().map(|i| f64::from(i) * 0.1).collect(),
                way_m: rows.clone().map(|i| vec![i as f32 * 0.4, i as f32 * 0.4 - 20.0]).collect(),
                speed_mps: rows.clone().map(|_| vec![4.0, 4.0]).collect(),
                shown_mps: rows.map(|_| Some(4.2)).collect(),
                ..Trajectories::default()
            };
            assert_eq!(trace.span_s()[0], 0.0);
            assert!((trace.span_s()[1] - last_s).abs() < 1e-9, "{:?}", trace.span_s());
            for shape in ways(&trace, &ColourKey::up_to("", 9.0)) {
                let PlotShape::Pieces { pieces, width, .. } = shape else { panic!("a dot") };
                let end_s = pieces.iter().map(|piece| piece[1][0]).fold(0.0, f64::max);
                assert!(pieces.is_empty() || (end_s - last_s).abs() < 1e-9, "{steps}, {width}: {end_s}");
            }
            let svg = speeds("", &SpeedTrace::of(&trace), 0.4, "", "", Vec::new());
            let document = roxmltree::Document::parse(&svg).unwrap();
            let number = |text: &str| text.parse::<f64>().unwrap();
            let field = document.descendants().find(|node| node.has_tag_name("clipPath")).unwrap();
            let right = number(field.first_element_child().unwrap().attribute("width").unwrap());
            for line in document.descendants().filter(|node| node.has_tag_name("polyline")) {
                let last = line.attribute("points").unwrap().rsplit(' ').next().unwrap();
                assert!((number(last.split_once(',').unwrap().0) - right).abs() < 0.11, "{steps}: {last}, {right}");
            }
        }
    }
}
