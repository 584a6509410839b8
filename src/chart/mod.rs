//! Figures: charts as SVG, and any such SVG as PNG. In: lines, bands and marks in the units of their axes. Out: pictures
//! for a report, a paper, a slide. What a figure is of is for others to know ([`train::figures`](crate::train::figures),
//! [`analysis`](crate::analysis)).

mod plot;
mod png;

pub use plot::{Axis, COLOURS, Chart, Line, Mark, Style, picture};
pub use png::{PNG_SCALE, is_font, png};
