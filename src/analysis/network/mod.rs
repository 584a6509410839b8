//! Drives on road networks, where vehicles come and go. In: a [`RecordedTrial`](super::RecordedTrial) and its vehicles by their numbers.
//! Out: travel times, who passes a line, what the ego did against the rules of the road, and all that drives on its path over time. SI units.
//!
//! Vehicles far from the ego have a row each second. So what is told of all vehicles is taken at full seconds, at which all have one, or from
//! row to row of each; of the ego, at every step.
//!
//! * `trips`: who came and went, and how long that took; `cross_section`: lines across a road, and who passes them.
//! * `totals`: one drive in sums; `measures`: what is measured on networks alone; `road_events`: red lights, speeding and the like.
//! * `path_traces`: positions along the ego's path over time, and what its signals showed; `figure`: drawn.
//! * `tables`: `trips.csv` and `lines.csv`; `words`: what the report says of such drives.

mod cross_section;
mod figure;
pub(super) mod measures;
mod path_traces;
mod road_events;
pub mod tables;
mod totals;
mod trips;
pub(super) mod words;

pub use cross_section::{CrossSection, LineCount, LinePlace};
pub use figure::{space_time, speeds};
pub use path_traces::PathTraces;
pub use road_events::RoadEvents;
pub use totals::NetworkTotals;
pub use trips::{Trip, TripEnd, TripTable};
