//! Charts as SVG text. In: lines, bands and marks in the units of their axes. Out: a picture without fonts or scripts of
//! its own, which prints and scales. Colours are those of Okabe and Ito (2008), told apart by colour-blind readers too.

use std::fmt::Write;

/// Colours of lines, in order of use.
pub const COLOURS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8c6d1f", "#444444"];

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// First and last value shown.
    pub range: [f64; 2],
    /// Where it has ticks.
    pub ticks: Vec<f64>,
    /// Even ratios instead of even differences.
    pub is_log: bool,
}

impl Axis {
    /// An axis with about five round ticks.
    pub fn even(label: &str, range: [f64; 2]) -> Self {
        let [low, high] = widened(range);
        Self { label: label.into(), range: [low, high], ticks: round_ticks(low, high), is_log: false }
    }

    /// An axis of even ratios with these ticks, the first and last of which lie at its ends but for a margin.
    pub fn ratios(label: &str, ticks: &[f64]) -> Self {
        let (low, high) = (ticks[0], ticks[ticks.len() - 1]);
        let margin = (high / low).powf(0.03);
        Self { label: label.into(), range: [low / margin, high * margin], ticks: ticks.to_vec(), is_log: true }
    }

    fn share(&self, x: f64) -> f64 {
        let of = |x: f64| if self.is_log { x.max(1e-12).ln() } else { x };
        let [low, high] = self.range.map(of);
        (of(x) - low) / (high - low)
    }
}

/// A range that has a width.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    if !(low.is_finite() && high.is_finite()) {
        [0.0, 1.0]
    } else if high - low < 1e-9 {
        [low - 0.5, low + 0.5]
    } else {
        [low, high]
    }
}

/// Multiples of 1, 2 or 5 times a power of ten, three to eight of them.
fn round_ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= rough * 0.999).unwrap_or(rough);
    let first = (low / step - 1e-6).ceil() as i64;
    (first..).map(|i| i as f64 * step).take_while(|x| *x <= high + step * 1e-6).collect()
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Colour.
    pub colour: &'static str,
    /// Width.
    pub width: f64,
    /// Dashes as SVG has them; empty is solid.
    pub dash: &'static str,
    /// A dot at each point.
    pub dots: bool,
}

impl Style {
    /// A solid line.
    pub fn solid(colour: &'static str) -> Self {
        Self { colour, width: 1.8, dash: "", dots: false }
    }
}

/// A line through points, with an interval around it where there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name in the legend; empty has none.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// Points.
    pub points: Vec<[f64; 2]>,
    /// For each point the ends of its interval; empty if there are none.
    pub band: Vec<[f64; 2]>,
}

/// A warning at a point: a red cross with words beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where, in the units of the axes.
    pub at: [f64; 2],
    /// What it says.
    pub text: String,
}

/// A chart. Sizes are in the picture's own units, about a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Width and height of the field between the axes.
    pub field: [f64; 2],
    /// Lines, drawn in order.
    pub lines: Vec<Line>,
    /// SVG below the lines, in the units of [`Chart::place`].
    pub below: String,
    /// Warnings, above all else.
    pub marks: Vec<Mark>,
}

/// Room around the field: left, top, right, bottom.
const MARGIN: [f64; 4] = [58.0, 34.0, 18.0, 46.0];
/// Height of a line of the legend.
const LEGEND: f64 = 17.0;

impl Chart {
    /// A chart without lines.
    pub fn new(title: &str, x: Axis, y: Axis, field: [f64; 2]) -> Self {
        Self { title: title.into(), x, y, field, lines: Vec::new(), below: String::new(), marks: Vec::new() }
    }

    /// Where a point lies, from the upper left corner of the field.
    pub fn place(&self, x: f64, y: f64) -> [f64; 2] {
        [self.x.share(x) * self.field[0], (1.0 - self.y.share(y)) * self.field[1]]
    }

    /// Width and height with everything around the field.
    pub fn size(&self) -> [f64; 2] {
        let legend = self.legend_columns().len() as f64 * LEGEND;
        [MARGIN[0] + self.field[0] + MARGIN[2], MARGIN[1] + self.field[1] + MARGIN[3] + legend]
    }

    /// Names of the legend, so many in a row as fit.
    fn legend_columns(&self) -> Vec<Vec<&Line>> {
        let named: Vec<&Line> = self.lines.iter().filter(|line| !line.name.is_empty()).collect();
        let longest = named.iter().map(|line| line.name.chars().count()).max().unwrap_or(0) as f64;
        let columns = ((self.field[0] / (longest * 6.2 + 40.0)) as usize).max(1);
        named.chunks(columns).map(<[&Line]>::to_vec).collect()
    }

    /// The chart with its upper left corner at this place of a picture.
    fn draw(&self, out: &mut String, at: [f64; 2], index: usize) {
        let [w, h] = self.field;
        let _ = writeln!(out, "<g transform=\"translate({:.1} {:.1})\">", at[0] + MARGIN[0], at[1] + MARGIN[1]);
        let _ = writeln!(out, "<text y=\"-12\" font-size=\"14\" font-weight=\"bold\">{}</text>", escaped(&self.title));
        self.grid(out);
        let _ = writeln!(out, "<clipPath id=\"f{index}\"><rect width=\"{w}\" height=\"{h}\"/></clipPath>");
        let _ = writeln!(out, "<g clip-path=\"url(#f{index})\">\n{}", self.below);
        self.lines.iter().for_each(|line| self.band(out, line));
        self.lines.iter().for_each(|line| self.line(out, line));
        let _ = writeln!(out, "</g>\n<path d=\"M0 0V{h}H{w}\" fill=\"none\" stroke=\"#333\"/>");
        self.marks.iter().for_each(|mark| self.mark(out, mark));
        self.legend(out);
        out.push_str("</g>\n");
    }

    fn mark(&self, out: &mut String, mark: &Mark) {
        let [x, y] = self.place(mark.at[0], mark.at[1]);
        // Beside the cross, on the side that has room, and within the field.
        let is_left = x > 0.6 * self.field[0];
        let (anchor, aside) = if is_left { ("end", -10.0) } else { ("start", 10.0) };
        let _ = writeln!(
            out,
            "<path d=\"M{:.1} {:.1}l12 12m0 -12l-12 12\" stroke=\"#c00000\" stroke-width=\"2.6\"/><text x=\"{:.1}\" y=\"{:.1}\" \
             fill=\"#c00000\" font-weight=\"bold\" text-anchor=\"{anchor}\">{}</text>",
            x - 6.0,
            y - 6.0,
            x + aside,
            (y - 6.0).clamp(12.0, self.field[1] - 4.0),
            escaped(&mark.text)
        );
    }

    fn grid(&self, out: &mut String) {
        let [w, h] = self.field;
        for tick in &self.x.ticks {
            let x = self.place(*tick, self.y.range[0])[0];
            let _ = writeln!(
                out,
                "<path d=\"M{x:.1} 0V{h}\" stroke=\"#e6e6e6\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
                 text-anchor=\"middle\">{}</text>",
                h + 16.0,
                number(*tick)
            );
        }
        for tick in &self.y.ticks {
            let y = self.place(self.x.range[0], *tick)[1];
            let _ = writeln!(
                out,
                "<path d=\"M0 {y:.1}H{w}\" stroke=\"#e6e6e6\"/><text x=\"-7\" y=\"{:.1}\" \
                 text-anchor=\"end\">{}</text>",
                y + 4.0,
                number(*tick)
            );
        }
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
             <text transform=\"translate(-42 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            w / 2.0,
            h + 34.0,
            escaped(&self.x.label),
            h / 2.0,
            escaped(&self.y.label)
        );
    }

    fn band(&self, out: &mut String, line: &Line) {
        if line.band.is_empty() {
            return;
        }
        let edge = |k: usize| line.points.iter().zip(&line.band).map(move |(p, b)| [p[0], b[k]]);
        let around: Vec<[f64; 2]> = edge(1).chain(edge(0).collect::<Vec<_>>().into_iter().rev()).collect();
        let colour = line.style.colour;
        let around = self.points(&around);
        if has_length(&around) {
            let _ = writeln!(out, "<polygon points=\"{around}\" fill=\"{colour}\" opacity=\"0.18\"/>");
        }
    }

    fn line(&self, out: &mut String, line: &Line) {
        let Style { colour, width, dash, dots } = line.style;
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
            let [x, y] = self.place(point[0], point[1]);
            let _ = write!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.8\" fill=\"{colour}\"/>");
        }
    }

    fn points(&self, points: &[[f64; 2]]) -> String {
        let place = |p: &[f64; 2]| {
            let [x, y] = self.place(p[0], p[1]);
            format!("{x:.1},{y:.1}")
        };
        points.iter().map(place).collect::<Vec<_>>().join(" ")
    }

    fn legend(&self, out: &mut String) {
        let rows = self.legend_columns();
        let columns = rows.first().map_or(1, Vec::len) as f64;
        for (i, row) in rows.iter().enumerate() {
            let y = self.field[1] + MARGIN[3] + 8.0 + i as f64 * LEGEND;
            for (k, line) in row.iter().enumerate() {
                let x = k as f64 * self.field[0] / columns;
                let mark = Line { name: String::new(), points: Vec::new(), band: Vec::new(), ..(*line).clone() };
                let Style { colour, width, dash, dots } = mark.style;
                let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
                let _ =
                    write!(out, "<path d=\"M{x:.1} {y:.1}h26\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>");
                if dots {
                    let _ = write!(out, "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"2.8\" fill=\"{colour}\"/>", x + 13.0);
                }
                let _ =
                    writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\">{}</text>", x + 32.0, y + 4.0, escaped(&line.name));
            }
        }
    }
}

/// False of points that all lie on one place once they are rounded: what reads the picture complains of such a line.
fn has_length(points: &str) -> bool {
    let mut places = points.split(' ');
    let first = places.next();
    places.any(|place| Some(place) != first)
}

/// Charts one above the other, and a note under them.
pub fn picture(charts: &[Chart], note: &str) -> String {
    let sizes: Vec<[f64; 2]> = charts.iter().map(Chart::size).collect();
    let width = sizes.iter().map(|s| s[0]).fold(0.0, f64::max);
    let notes: Vec<&str> = note.lines().collect();
    let height = sizes.iter().map(|s| s[1]).sum::<f64>() + 14.0 * notes.len() as f64 + 12.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#222\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let mut y = 0.0;
    for (i, (chart, size)) in charts.iter().zip(&sizes).enumerate() {
        chart.draw(&mut out, [0.0, y], i);
        y += size[1];
    }
    for (i, line) in notes.iter().enumerate() {
        let at = y + 10.0 + 14.0 * i as f64;
        let _ = writeln!(
            out,
            "<text x=\"{:.0}\" y=\"{at:.0}\" font-size=\"11\" fill=\"#555\">{}</text>",
            MARGIN[0],
            escaped(line)
        );
    }
    out.push_str("</svg>\n");
    out
}

/// A number of an axis, without digits that say nothing.
fn number(x: f64) -> String {
    let text = format!("{:.4}", if x.abs() < 1e-9 { 0.0 } else { x });
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(round_ticks(0.0, 10.0), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(Axis::even("", [3.0, 3.0]).range, [2.5, 3.5]);
        assert_eq!(number(0.30000000000000004), "0.3");
    }

    #[test]
    fn a_line_or_a_band_without_length_is_not_drawn() {
        let chart = |points: Vec<[f64; 2]>, band: Vec<[f64; 2]>| {
            let mut chart = Chart::new("", Axis::even("", [0.0, 1.0]), Axis::even("", [0.0, 1.0]), [100.0, 100.0]);
            chart.lines.push(Line { name: String::new(), style: Style::solid(COLOURS[0]), points, band });
            let text = picture(&[chart], "");
            (text.contains("<polyline"), text.contains("<polygon"))
        };
        assert_eq!(chart(vec![[0.1, 0.5], [0.9, 0.5]], vec![[0.4, 0.6]; 2]), (true, true));
        assert_eq!(chart(vec![[0.1, 0.5]], vec![[0.5, 0.5]]), (false, false));
        assert_eq!(chart(vec![[0.5, 0.5], [0.500_01, 0.5]], vec![]), (false, false), "a hair's breadth");
        assert_eq!(chart(vec![[0.5, 0.5]], vec![[0.2, 0.7]]), (false, true), "an interval alone is one");
        assert_eq!(chart(vec![], vec![]), (false, false));
    }

    #[test]
    fn a_picture_is_well_formed_and_points_lie_where_they_should() {
        let mut chart =
            Chart::new("a < b", Axis::ratios("s", &[0.1, 1.0, 10.0]), Axis::even("y", [0.0, 1.0]), [200.0, 100.0]);
        let points = vec![[0.1, 0.0], [10.0, 1.0]];
        let band = vec![[0.0, 0.1], [0.9, 1.0]];
        chart.lines.push(Line { name: "one & two".into(), style: Style::solid(COLOURS[0]), points, band });
        assert_eq!(chart.place(1.0, 0.5), [100.0, 50.0]);
        let text = picture(&[chart.clone(), chart], "a note\nof two lines");
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.descendants().filter(|n| n.has_tag_name("polyline")).count(), 2);
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }
}
