//! Drives on road networks, where vehicles enter and leave. In: a recording and its vehicles by their numbers. Out: travel
//! times, counts at lines, and all vehicles on the ego's path over time. SI units.
//!
//! Vehicles far from the ego have a row each second. Values of all vehicles are therefore taken at full seconds, at which all
//! have a row, or from row to row of each; values of the ego at every step.
//!
//! * `cross_section`: lines across a road, and the vehicles that cross them; `totals`: sums of one drive.
//! * `path_traces`: positions along the ego's path over time, and its signals.

mod cross_section;
mod path_traces;
mod totals;

pub use cross_section::{CrossSection, LineCount, LinePlace};
pub use path_traces::{PathTraces, SignalBar, TracePiece};
pub use totals::NetworkDriveTotals;
