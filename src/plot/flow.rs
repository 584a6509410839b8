//! Flow diagram: boxes from top to bottom, and beside each the box of those who leave after it. In: texts, line by line. Out: SVG, as
//! wide as a page, as reports of trials have it (CONSORT; Schulz et al. 2010).

use super::{
    chart::PrintWidth,
    text::{LINE, SIZE, escaped, wrapped},
};
use std::fmt::Write;

/// Box of a flow diagram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlowBox {
    /// First line, in bold.
    pub title: String,
    /// Lines below it; a longer one is broken.
    pub lines: Vec<String>,
}

/// Boxes of the main column, each with the box of those who leave before the next one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlowChart {
    /// Boxes from top to bottom, with the box to the right of the arrow below.
    pub steps: Vec<(FlowBox, Option<FlowBox>)>,
}

/// Widths of the boxes and the room between the two columns, units of the picture.
const MAIN: f64 = 330.0;
const GAP: f64 = 60.0;
/// Distance from a box's edge to its text, and shortest arrow between two boxes.
const PAD: f64 = 8.0;
const ARROW: f64 = 26.0;

impl FlowBox {
    /// Returns the lines that fit into a box of this width; the number of those that are bold comes first.
    fn broken(&self, box_width: f64) -> (usize, Vec<String>) {
        let room = box_width - 2.0 * PAD;
        // Bold letters are up to a tenth wider.
        let title = wrapped(&self.title, room / 1.1, SIZE);
        let rest = self.lines.iter().flat_map(|line| wrapped(line, room, SIZE));
        (title.len(), title.iter().cloned().chain(rest).collect())
    }

    fn height(&self, box_width: f64) -> f64 {
        2.0 * PAD + LINE * self.broken(box_width).1.len() as f64 - (LINE - SIZE)
    }

    fn draw(&self, out: &mut String, [x, y]: [f64; 2], box_width: f64) {
        let (bold, lines) = self.broken(box_width);
        let height = self.height(box_width);
        let _ = writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{box_width:.1}\" height=\"{height:.1}\" fill=\"#f6f6f6\" stroke=\"#555\"/>"
        );
        for (i, line) in lines.iter().enumerate() {
            let weight = if i < bold { " font-weight=\"bold\"" } else { "" };
            let at = y + PAD + SIZE * 0.85 + LINE * i as f64;
            let _ = writeln!(out, "<text x=\"{:.1}\" y=\"{at:.1}\"{weight}>{}</text>", x + PAD, escaped(line));
        }
    }
}

impl FlowChart {
    /// Draws the diagram as SVG.
    pub fn svg(&self) -> String {
        let total = PrintWidth::Page.units();
        let side = total - MAIN - GAP - 4.0;
        let (mut body, mut y) = (String::new(), 4.0);
        for (i, (step, exit)) in self.steps.iter().enumerate() {
            step.draw(&mut body, [2.0, y], MAIN);
            y += step.height(MAIN);
            let is_last = i + 1 == self.steps.len();
            let exit_height = exit.as_ref().map_or(0.0, |exit| exit.height(side));
            let below = if is_last && exit.is_none() { 0.0 } else { ARROW.max(exit_height + 2.0 * PAD) };
            let middle = 2.0 + MAIN / 2.0;
            if !is_last {
                arrow(&mut body, [middle, y], [middle, y + below]);
            }
            if let Some(exit) = exit {
                let centre = y + below / 2.0;
                arrow(&mut body, [middle, centre], [2.0 + MAIN + GAP, centre]);
                exit.draw(&mut body, [2.0 + MAIN + GAP, centre - exit_height / 2.0], side);
            }
            y += below;
        }
        let height = y + 4.0;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {total:.0} {height:.0}\" width=\"{}mm\" \
             height=\"{:.1}mm\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"{SIZE:.0}\" fill=\"#222\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n",
            PrintWidth::Page.mm(),
            height / total * PrintWidth::Page.mm(),
        )
    }
}

/// Draws an arrow, down or to the right.
fn arrow(out: &mut String, [x, y]: [f64; 2], [to_x, to_y]: [f64; 2]) {
    const TIP: f64 = 4.0;
    let tip = if to_x > x {
        [[to_x - 2.0 * TIP, to_y - TIP], [to_x - 2.0 * TIP, to_y + TIP]]
    } else {
        [[to_x - TIP, to_y - 2.0 * TIP], [to_x + TIP, to_y - 2.0 * TIP]]
    };
    let _ = writeln!(
        out,
        "<path d=\"M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}\" stroke=\"#555\"/>\n<path d=\"M{to_x:.1} {to_y:.1}L{:.1} {:.1}L{:.1} {:.1}Z\" \
         fill=\"#555\"/>",
        tip[0][0], tip[0][1], tip[1][0], tip[1][1]
    );
}

#[cfg(test)]
mod tests {
    use super::{super::text::width, *};

    /// Boxes of a column do not touch, no text is wider than its box, and an arrow leads to each box but the first.
    #[test]
    fn boxes_are_apart_and_hold_their_text() {
        let one = |title: &str, lines: &[&str]| FlowBox {
            title: title.into(),
            lines: lines.iter().map(|line| (*line).to_owned()).collect(),
        };
        let long = "ended before the first trial was finished, for a reason that takes more than one line to tell: 1";
        let chart = FlowChart {
            steps: vec![
                (one("Sessions begun: 24", &[]), Some(one("Not continued: 3", &[long, "declined & left: 2"]))),
                (one("Allocated: 21", &["none, sham, advice: 11", "sham, advice, none: 10"]), None),
                (one("Analysed: 21", &[]), None),
            ],
        };
        let svg = chart.svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let number = |node: &roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
        let boxes: Vec<[f64; 4]> = document
            .descendants()
            .filter(|node| node.has_tag_name("rect") && node.attribute("x").is_some())
            .map(|node| ["x", "y", "width", "height"].map(|name| number(&node, name)))
            .collect();
        assert_eq!(boxes.len(), 4);
        for (i, a) in boxes.iter().enumerate() {
            for b in &boxes[i + 1..] {
                let is_apart = |k: usize| a[k] + a[k + 2] < b[k] || b[k] + b[k + 2] < a[k];
                assert!(is_apart(0) || is_apart(1), "{a:?} and {b:?}");
            }
        }
        for node in document.descendants().filter(|node| node.has_tag_name("text")) {
            let (x, y) = (number(&node, "x"), number(&node, "y"));
            let right = x + width(node.text().unwrap(), SIZE);
            let holds = |b: &[f64; 4]| b[0] < x && right < b[0] + b[2] && b[1] < y && y < b[1] + b[3];
            assert!(boxes.iter().any(holds), "{:?}", node.text());
        }
        assert_eq!(svg.matches("stroke=\"#555\"/>\n<path").count(), 3, "two arrows down, one to the side: {svg}");
        assert!(svg.contains("declined &amp; left: 2"));
    }
}
