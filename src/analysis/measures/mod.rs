//! Measures of one drive. In: its rows and steps in order, and optionally the same drive without advice. Out: numbers with
//! their definitions. SI units.
//!
//! * [`totals`]: sums of the drive; `inputs`: what the measures are computed from.
//! * `definition`: name, unit and definition of a measure; `every_drive`, `on_networks`: the lists of measures;
//!   [`MEASURES`]: both lists as one, and the values of a drive.

mod definition;
mod drive_measures;
mod every_drive;
mod inputs;
mod on_networks;
pub mod totals;

pub use definition::{MeasureDefinition, MeasuredOn, RoadKinds};
pub(super) use drive_measures::index;
pub use drive_measures::{DriveMeasures, MEASURES};
pub use totals::DriveTotals;
