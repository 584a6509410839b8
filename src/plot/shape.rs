//! Shapes of a chart other than lines through points: pieces, dots, and the key to colours that encode a number. Positions are
//! in the units of the axes, sizes in units of the picture.

use super::axis::{decimals, number, round_step};
use std::fmt::Write;

/// A shape drawn under the lines of a chart.
#[derive(Clone, Debug, PartialEq)]
pub enum PlotShape {
    /// Straight pieces in one colour.
    Pieces {
        /// Start and end of each piece.
        pieces: Vec<[[f64; 2]; 2]>,
        /// Colour as in SVG.
        colour: String,
        /// Width in units of the picture.
        width: f64,
    },
    /// Filled circle in one colour.
    Dot {
        at: [f64; 2],
        /// Radius in units of the picture.
        radius: f64,
        /// Colour as in SVG.
        colour: String,
        /// True for a dark edge, false for a translucent circle without one.
        has_edge: bool,
    },
}

impl PlotShape {
    /// Draws the shape as SVG; `place` maps a point of the axes to the picture.
    pub(super) fn draw(&self, out: &mut String, place: impl Fn([f64; 2]) -> [f64; 2]) {
        match self {
            Self::Pieces { pieces, colour, width } => {
                let mut path = String::new();
                for [from, to] in pieces {
                    let [x1, y1] = place(*from).map(|x| format!("{x:.1}"));
                    let [x2, y2] = place(*to).map(|x| format!("{x:.1}"));
                    // Readers of SVG complain of a line without length.
                    if (&x1, &y1) != (&x2, &y2) {
                        let _ = write!(path, "M{x1} {y1}L{x2} {y2}");
                    }
                }
                if !path.is_empty() {
                    let _ = writeln!(
                        out,
                        "<path d=\"{path}\" stroke=\"{colour}\" stroke-width=\"{width}\" fill=\"none\"/>"
                    );
                }
            }
            Self::Dot { at, radius, colour, has_edge } => {
                let [x, y] = place(*at);
                let edge = if *has_edge { " stroke=\"#222\" stroke-width=\"1.4\"" } else { " opacity=\"0.65\"" };
                let _ = writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{colour}\"{edge}/>");
            }
        }
    }

    /// Returns the shape with the axes exchanged.
    pub(super) fn transposed(self) -> Self {
        let turned = |[x, y]: [f64; 2]| [y, x];
        match self {
            Self::Pieces { pieces, colour, width } => {
                Self::Pieces { pieces: pieces.into_iter().map(|ends| ends.map(turned)).collect(), colour, width }
            }
            Self::Dot { at, radius, colour, has_edge } => Self::Dot { at: turned(at), radius, colour, has_edge },
        }
    }
}

/// Viridis (Smith, van der Walt 2015) without its palest end: lightness grows throughout, so that colour-blind people and grey
/// prints keep the order.
const VIRIDIS: [[u8; 3]; 9] = [
    [0x44, 0x01, 0x54],
    [0x47, 0x2a, 0x7a],
    [0x3d, 0x4a, 0x89],
    [0x30, 0x68, 0x8e],
    [0x26, 0x82, 0x8e],
    [0x1f, 0x9e, 0x89],
    [0x35, 0xb7, 0x79],
    [0x6d, 0xcd, 0x59],
    [0xb4, 0xde, 0x2c],
];

/// Colours that encode a number: classes of equal width from 0 on; the last has no upper end.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourKey {
    /// Quantity and unit, and any further explanation.
    pub label: String,
    /// Width of a class, in the unit of the quantity.
    pub step: f64,
    /// Colours, one for each class.
    pub colours: Vec<String>,
}

impl ColourKey {
    /// Creates at most ten classes, up to about `top`.
    pub fn up_to(label: &str, top: f64) -> Self {
        let step = round_step(top / 10.0);
        let classes = (top / step).ceil().max(2.0) as usize;
        let colour = |i: usize| {
            let at = i as f64 / (classes - 1) as f64 * (VIRIDIS.len() - 1) as f64;
            let low = (at as usize).min(VIRIDIS.len() - 2);
            let mixed = |k: usize| {
                let [a, b] = [VIRIDIS[low][k], VIRIDIS[low + 1][k]].map(f64::from);
                (a + (b - a) * (at - low as f64)).round() as u8
            };
            format!("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2))
        };
        Self { label: label.into(), step, colours: (0..classes).map(colour).collect() }
    }

    /// Returns the class of a number; numbers below 0 are in the first.
    pub fn class(&self, value: f64) -> usize {
        ((value / self.step).max(0.0) as usize).min(self.colours.len() - 1)
    }

    /// Returns the text at the lower edge of each class.
    pub(super) fn edges(&self) -> Vec<String> {
        let edges: Vec<f64> = (0..self.colours.len()).map(|i| i as f64 * self.step).collect();
        let decimals = decimals(&edges);
        edges.iter().map(|edge| number(*edge, decimals)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the lightness by ITU-R BT.709, 0 to 1.
    fn lightness(colour: &str) -> f64 {
        let part = |k: usize| f64::from(u8::from_str_radix(&colour[1 + 2 * k..3 + 2 * k], 16).unwrap()) / 255.0;
        0.2126 * part(0).powf(2.2) + 0.7152 * part(1).powf(2.2) + 0.0722 * part(2).powf(2.2)
    }

    #[test]
    fn classes_have_round_edges_and_grow_lighter() {
        for (top, step, edges) in [(8.7, 1.0, 9), (4.0, 0.5, 8), (12.0, 2.0, 6), (40.0, 5.0, 8)] {
            let key = ColourKey::up_to("speed, m/s", top);
            assert_eq!((key.step, key.colours.len(), key.edges().len()), (step, edges, edges), "{top}");
            for pair in key.colours.windows(2) {
                assert!(lightness(&pair[1]) > lightness(&pair[0]), "{pair:?}");
            }
            // The lightest colour is visible on white, with a contrast above 1.5 (WCAG asks 3 of a graphic that is not
            // redundant).
            assert!(1.05 / (lightness(key.colours.last().unwrap()) + 0.05) > 1.5);
            assert_eq!((key.class(-1.0), key.class(0.0), key.class(step), key.class(1e9)), (0, 0, 1, edges - 1));
        }
        assert_eq!(ColourKey::up_to("", 4.0).edges()[..3], ["0.0", "0.5", "1.0"]);
    }
}
