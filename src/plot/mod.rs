//! Figures: charts and flow diagrams as SVG, and any such SVG as PNG. In: lines, bands, shapes and marks in the units of their axes. Out:
//! pictures for a report, a paper, a slide, as wide as a journal's column or page. The content of figures is defined in
//! [`metrics::figures`](crate::metrics::figures) and `analysis`.

mod axis;
mod chart;
mod flow;
mod legend;
#[cfg(feature = "desktop")]
mod png;
mod shape;
mod text;

pub use axis::{Axis, AxisScale};
pub use chart::{COLOURS, Chart, ChartSheet, LineStyle, PlotLine, PlotMark, PrintWidth, picture};
pub use flow::{FlowBox, FlowChart};
#[cfg(feature = "desktop")]
pub use png::{PNG_SCALE, PngError, png};
pub use shape::{ColourKey, PlotShape};
pub use text::{escaped, is_font, lines_needed, minus};

#[cfg(all(test, feature = "desktop"))]
pub use png::texts;
