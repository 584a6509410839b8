//! Charts as SVG text. In: lines, bands, shapes and marks in the units of their axes. Out: a picture without fonts or scripts
//! of its own, as wide as a journal's column or page, which prints and scales. The room of every text is measured before
//! anything is drawn. Colours by Okabe and Ito (2008), which colour-blind readers can distinguish.

use super::{
    axis::{Axis, AxisScale, AxisSide, AxisTick},
    legend,
    shape::{ColourKey, PlotShape},
    text::{LINE, SIZE, escaped, width, wrapped},
};
use std::fmt::Write;

/// Colours of lines, in order of use.
pub const COLOURS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8c6d1f", "#444444"];

/// Style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStyle {
    /// Colour as in SVG, such as `#0072b2`.
    pub colour: &'static str,
    /// Width in units of the picture.
    pub width: f64,
    /// Dash pattern as in SVG; empty for a solid line.
    pub dash: &'static str,
    /// True for a dot at each point.
    pub dots: bool,
}

impl LineStyle {
    /// Creates a solid line of 1.8 units.
    pub fn solid(colour: &'static str) -> Self {
        Self { colour, width: 1.8, dash: "", dots: false }
    }
}

/// A line through points, with an optional interval around it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotLine {
    /// Name in the legend; empty for no entry.
    pub name: String,
    pub style: LineStyle,
    /// Points in the units of the axes.
    pub points: Vec<[f64; 2]>,
    /// Ends of the interval at each point; empty without intervals.
    pub band: Vec<[f64; 2]>,
}

/// A warning at a point: a red cross with a text beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotMark {
    /// Position in the units of the axes.
    pub at: [f64; 2],
    /// Text beside the cross.
    pub text: String,
}

/// A chart. Sizes are in the picture's own units, about a quarter of a millimetre.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading; empty for none.
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// Height of the field between the axes, units of the picture.
    pub height: f64,
    /// Lines, drawn in order.
    pub lines: Vec<PlotLine>,
    /// Shapes drawn below the lines.
    pub shapes: Vec<PlotShape>,
    /// Warnings, drawn above all else.
    pub marks: Vec<PlotMark>,
}

impl Chart {
    /// Creates a chart without lines.
    pub fn new(title: &str, x: Axis, y: Axis, height: f64) -> Self {
        Self { title: title.into(), x, y, height, lines: Vec::new(), shapes: Vec::new(), marks: Vec::new() }
    }

    /// Exchanges the axes of a chart of shapes: names below move to the left, from top to bottom. The height is set by the
    /// names, and lines and marks are dropped.
    pub fn transposed(self) -> Self {
        let (mut y, x) = (self.x, self.y);
        y.range.reverse();
        let rows = y.ticks(0.0, AxisSide::Left { names: NAMES });
        let tallest = rows.iter().map(|tick| tick.lines.len()).max().unwrap_or(1).max(3) as f64;
        Self {
            height: rows.len() as f64 * (tallest * LINE + 8.0),
            shapes: self.shapes.into_iter().map(PlotShape::transposed).collect(),
            ..Self::new(&self.title, x, y, 0.0)
        }
    }
}

/// Room for a name beside a vertical axis, units of the picture.
const NAMES: f64 = 230.0;

/// Width of a picture in print.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrintWidth {
    /// A column of a journal: 89 mm.
    Column,
    /// A page of a journal: 183 mm.
    Page,
}

impl PrintWidth {
    /// Returns the width in millimetres.
    pub fn mm(self) -> f64 {
        match self {
            Self::Column => 89.0,
            Self::Page => 183.0,
        }
    }

    /// Returns the width in units of a picture: text of 12 units is 8 points high.
    pub fn units(self) -> f64 {
        (self.mm() * UNITS_PER_MM).round()
    }
}

const UNITS_PER_MM: f64 = 4.24;

/// Charts one above the other, with a key to colours and a note under them.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartSheet<'a> {
    /// Charts from top to bottom.
    pub charts: &'a [Chart],
    /// Width of the sheet in print.
    pub width: PrintWidth,
    /// Key to colours, drawn below the charts.
    pub key: Option<&'a ColourKey>,
    /// Note below the charts, line by line.
    pub note: &'a str,
}

/// Draws charts one above the other, as wide as a page, with a note under them.
pub fn picture(charts: &[Chart], note: &str) -> String {
    ChartSheet { charts, width: PrintWidth::Page, key: None, note }.svg()
}

impl ChartSheet<'_> {
    /// Draws the sheet as SVG.
    pub fn svg(&self) -> String {
        let total = self.width.units();
        let left = self.charts.iter().map(left_of).fold(0.0, f64::max);
        let layouts: Vec<ChartLayout> = self.charts.iter().map(|chart| ChartLayout::of(chart, left, total)).collect();
        let key_height = self.key.map_or(0.0, |key| legend::key_height(key, total - left - 8.0));
        let notes: Vec<String> = self.note.lines().flat_map(|line| wrapped(line, total - left - 8.0, NOTE)).collect();
        let height =
            layouts.iter().map(ChartLayout::height).sum::<f64>() + key_height + LINE * notes.len() as f64 + 6.0;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {total:.0} {height:.0}\" width=\"{}mm\" \
             height=\"{:.1}mm\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"{SIZE:.0}\" fill=\"#222\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            self.width.mm(),
            height / total * self.width.mm(),
        );
        let mut y = 0.0;
        for (i, layout) in layouts.iter().enumerate() {
            layout.draw(&mut out, y, i);
            y += layout.height();
        }
        if let Some(key) = self.key {
            legend::key(&mut out, key, [left, y], total - left - 8.0);
        }
        for (i, line) in notes.iter().enumerate() {
            let at = y + key_height + 10.0 + LINE * i as f64;
            let _ = writeln!(
                out,
                "<text x=\"{left:.0}\" y=\"{at:.1}\" font-size=\"{NOTE:.0}\" fill=\"#444\">{}</text>",
                escaped(line)
            );
        }
        out.push_str("</svg>\n");
        out
    }
}

/// Font size of notes, units of the picture.
const NOTE: f64 = 11.0;

/// Returns the room that a chart needs left of its field, for the label and the ticks.
fn left_of(chart: &Chart) -> f64 {
    let ticks = chart.y.ticks(chart.height, AxisSide::Left { names: NAMES });
    label_room(&wrapped(&chart.y.label, chart.height, SIZE)) + widest(&ticks) + 10.0
}

fn label_room(lines: &[String]) -> f64 {
    if lines.iter().all(String::is_empty) { 2.0 } else { 8.0 + LINE * lines.len() as f64 }
}

fn widest(ticks: &[AxisTick]) -> f64 {
    ticks.iter().flat_map(|tick| &tick.lines).map(|line| width(line, SIZE)).fold(0.0, f64::max)
}

/// Layout of a chart.
struct ChartLayout<'a> {
    chart: &'a Chart,
    /// Upper left corner of the field in the chart, and its size.
    at: [f64; 2],
    field: [f64; 2],
    title: Vec<String>,
    x_ticks: Vec<AxisTick>,
    y_ticks: Vec<AxisTick>,
    x_label: Vec<String>,
    y_label: Vec<String>,
    /// Distance from the field to the legend.
    below: f64,
    legend: legend::Legend<'a>,
}

impl<'a> ChartLayout<'a> {
    fn of(chart: &'a Chart, left: f64, total: f64) -> Self {
        let named = chart.lines.iter().filter(|line| !line.name.is_empty());
        // The label of the last tick extends beyond the axis.
        let mut right = 8.0;
        for _ in 0..3 {
            let length = total - left - right;
            let reach = |tick: &AxisTick| {
                let half = tick.lines.iter().map(|line| width(line, SIZE)).fold(0.0, f64::max) / 2.0;
                chart.x.share(tick.at) * length + half - length
            };
            let over = chart.x.ticks(length, AxisSide::Bottom).iter().map(reach).fold(0.0, f64::max);
            right = over.max(6.0) + 2.0;
        }
        let field = [total - left - right, chart.height];
        let x_ticks = chart.x.ticks(field[0], AxisSide::Bottom);
        let tick_lines = x_ticks.iter().map(|tick| tick.lines.len()).max().unwrap_or(0) as f64;
        let x_label: Vec<String> =
            wrapped(&chart.x.label, field[0], SIZE).into_iter().filter(|line| !line.is_empty()).collect();
        let title: Vec<String> =
            wrapped(&chart.title, field[0], SIZE + 1.0).into_iter().filter(|line| !line.is_empty()).collect();
        let top = if title.is_empty() { 9.0 } else { 12.0 + 16.0 * title.len() as f64 };
        Self {
            chart,
            at: [left, top],
            field,
            title,
            below: 8.0 + LINE * tick_lines + (LINE + 1.0) * x_label.len() as f64 + 6.0,
            x_ticks,
            y_ticks: chart.y.ticks(chart.height, AxisSide::Left { names: NAMES }),
            x_label,
            y_label: wrapped(&chart.y.label, chart.height, SIZE),
            legend: legend::Legend::of(named.collect(), field[0]),
        }
    }

    fn height(&self) -> f64 {
        self.at[1] + self.field[1] + self.below + self.legend.height()
    }

    /// Returns the position of a point, from the upper left corner of the field.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.chart.x.share(x) * self.field[0], (1.0 - self.chart.y.share(y)) * self.field[1]]
    }

    /// Draws the chart at this height of the picture.
    fn draw(&self, out: &mut String, from_top: f64, index: usize) {
        let ([w, h], chart) = (self.field, self.chart);
        let _ = writeln!(out, "<g transform=\"translate({:.1} {:.1})\">", self.at[0], from_top + self.at[1]);
        for (i, line) in self.title.iter().enumerate() {
            let y = 16.0 * (i as f64 - self.title.len() as f64) + 7.0;
            let _ = writeln!(out, "<text y=\"{y:.1}\" font-size=\"{:.0}\">{}</text>", SIZE + 1.0, escaped(line));
        }
        self.grid(out);
        let _ = writeln!(out, "<clipPath id=\"f{index}\"><rect width=\"{w:.1}\" height=\"{h:.1}\"/></clipPath>");
        let _ = writeln!(out, "<g clip-path=\"url(#f{index})\">");
        chart.shapes.iter().for_each(|shape| shape.draw(out, |at| self.place(at)));
        chart.lines.iter().for_each(|line| self.band(out, line));
        chart.lines.iter().for_each(|line| self.line(out, line));
        let _ = writeln!(out, "</g>\n<path d=\"M0 0V{h:.1}H{w:.1}\" fill=\"none\" stroke=\"#333\"/>");
        self.marks(out);
        self.legend.draw(out, h + self.below);
        out.push_str("</g>\n");
    }

    fn marks(&self, out: &mut String) {
        let mut taken: Vec<[f64; 4]> = Vec::new();
        for mark in &self.chart.marks {
            let [x, y] = self.place(mark.at);
            let wide = width(&mark.text, SIZE);
            // Beside the cross, on the side that has room, and within the field; above or below earlier texts.
            let is_left = x + 10.0 + wide > self.field[0];
            let from = (if is_left { x - 10.0 - wide } else { x + 10.0 }).clamp(0.0, (self.field[0] - wide).max(0.0));
            let box_at = |base: f64| [from, base - SIZE, from + wide, base + 4.0];
            let is_free = |base: &f64| {
                let [l, t, r, b] = box_at(*base);
                (t >= 0.0 && b <= self.field[1])
                    && taken.iter().all(|[l2, t2, r2, b2]| r < *l2 || l > *r2 || b < *t2 || t > *b2)
            };
            let wanted = (y - 6.0).clamp(SIZE, (self.field[1] - 4.0).max(SIZE));
            let candidates =
                (0..40).map(|i| wanted + LINE * f64::from(i / 2 + i % 2) * if i % 2 == 0 { 1.0 } else { -1.0 });
            let base = candidates.into_iter().find(is_free).unwrap_or(wanted);
            taken.push(box_at(base));
            let _ = writeln!(
                out,
                "<path d=\"M{:.1} {:.1}l12 12m0 -12l-12 12\" stroke=\"#c00000\" stroke-width=\"2.6\"/>\
                 <text x=\"{from:.1}\" y=\"{base:.1}\" fill=\"#c00000\">{}</text>",
                x - 6.0,
                y - 6.0,
                escaped(&mark.text)
            );
        }
    }

    fn grid(&self, out: &mut String) {
        let [w, h] = self.field;
        let is_named = |axis: &Axis| matches!(axis.scale, AxisScale::Names(_));
        for tick in &self.x_ticks {
            let x = self.chart.x.share(tick.at) * w;
            // Names have a tick, numbers a line of the grid.
            let line =
                if is_named(&self.chart.x) { format!("M{x:.1} {h:.1}v4") } else { format!("M{x:.1} 0V{:.1}", h + 4.0) };
            let _ = writeln!(out, "<path d=\"{line}\" stroke=\"#ddd\"/>");
            for (i, words) in tick.lines.iter().enumerate() {
                let y = h + 17.0 + LINE * i as f64;
                let _ =
                    writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>", escaped(words));
            }
        }
        for tick in &self.y_ticks {
            let y = (1.0 - self.chart.y.share(tick.at)) * h;
            let line = if is_named(&self.chart.y) { format!("M-4 {y:.1}h4") } else { format!("M-4 {y:.1}H{w:.1}") };
            let _ = writeln!(out, "<path d=\"{line}\" stroke=\"#ddd\"/>");
            let first = y + 4.0 - LINE * (tick.lines.len() - 1) as f64 / 2.0;
            for (i, words) in tick.lines.iter().enumerate() {
                let y = first + LINE * i as f64;
                let _ = writeln!(out, "<text x=\"-7\" y=\"{y:.1}\" text-anchor=\"end\">{}</text>", escaped(words));
            }
        }
        let label_from = h + 8.0 + LINE * self.x_ticks.iter().map(|tick| tick.lines.len()).max().unwrap_or(0) as f64;
        for (i, line) in self.x_label.iter().enumerate() {
            let y = label_from + (LINE + 1.0) * (i as f64 + 0.85);
            let _ = writeln!(
                out,
                "<text x=\"{:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>",
                w / 2.0,
                escaped(line)
            );
        }
        for (i, line) in self.y_label.iter().enumerate().filter(|(_, line)| !line.is_empty()) {
            let x = 2.0 + SIZE - self.at[0] + LINE * i as f64;
            let _ = writeln!(
                out,
                "<text transform=\"translate({x:.1} {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
                h / 2.0,
                escaped(line)
            );
        }
    }

    fn band(&self, out: &mut String, line: &PlotLine) {
        if line.band.is_empty() {
            return;
        }
        let edge = |k: usize| line.points.iter().zip(&line.band).map(move |(p, b)| [p[0], b[k]]);
        let around: Vec<[f64; 2]> = edge(1).chain(edge(0).collect::<Vec<_>>().into_iter().rev()).collect();
        let colour = line.style.colour;
        let around = self.points(&around);
        if has_length(&around) {
            let _ = writeln!(out, "<polygon points=\"{around}\" fill=\"{colour}\" opacity=\"{}\"/>", legend::BAND);
        }
    }

    fn line(&self, out: &mut String, line: &PlotLine) {
        let LineStyle { colour, width, dash, dots } = line.style;
        let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
        let points = self.points(&line.points);
        if has_length(&points) {
            let _ = writeln!(
                out,
                "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
                 stroke-linejoin=\"round\"{dash}/>"
            );
        }
        for point in line.points.iter().filter(|_| dots) {
            let [x, y] = self.place(*point);
            let _ = write!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.8\" fill=\"{colour}\"/>");
        }
    }

    fn points(&self, points: &[[f64; 2]]) -> String {
        let place = |p: &[f64; 2]| {
            let [x, y] = self.place(*p);
            format!("{x:.1},{y:.1}")
        };
        points.iter().map(place).collect::<Vec<_>>().join(" ")
    }
}

/// Checks whether the points differ after rounding: readers of SVG complain of a line without length.
fn has_length(points: &str) -> bool {
    let mut places = points.split(' ');
    let first = places.next();
    places.any(|place| Some(place) != first)
}

// The positions of texts come from the PNG renderer.
#[cfg(all(test, feature = "desktop"))]
#[path = "chart_tests.rs"]
mod tests;
