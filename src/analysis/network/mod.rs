//! Drives on road networks, where vehicles enter and leave. In: a [`RecordedTrial`](super::RecordedTrial) and its vehicles by
//! their numbers. Out: travel times, counts at lines, violations of traffic rules by the ego, and all vehicles on its path over
//! time. SI units.
//!
//! Vehicles far from the ego have a row each second. Values of all vehicles are therefore taken at full seconds, at which all
//! have a row, or from row to row of each; values of the ego at every step.
//!
//! * `trips`: departures, arrivals and travel times; `cross_section`: lines across a road, and the vehicles that cross them.
//! * `totals`: sums of one drive; `measures`: measures of networks only; `road_events`: red lights, speeding and the like.
//! * `path_traces`: positions along the ego's path over time, and its signals; `figure`: their pictures.
//! * `tables`: `trips.csv` and `lines.csv`; `methods_text`: sentences of the report about such drives.

mod cross_section;
mod figure;
pub(super) mod measures;
pub(super) mod methods_text;
mod path_traces;
mod road_events;
pub mod tables;
mod totals;
mod trips;

pub use cross_section::{CrossSection, LineCount, LinePlace};
pub use figure::{space_time, speeds};
pub use path_traces::PathTraces;
pub use road_events::RoadEvents;
pub use totals::NetworkDriveTotals;
pub use trips::{Trip, TripEnd, TripTable};
