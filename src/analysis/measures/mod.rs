//! Measures of one drive. In: its rows and steps in order, and optionally the same drive without advice. Out: numbers with
//! their definitions. SI units.
//!
//! * [`totals`]: sums of the drive; `inputs`: what the measures are computed from.
//! * `every_drive`, `on_networks`: the lists of measures, which [`crate::metrics::registry`] defines; [`MEASURES`]: both lists
//!   as one, and the values of a drive.

mod drive_measures;
mod every_drive;
mod inputs;
mod on_networks;
pub mod totals;

pub(super) use drive_measures::index;
pub use drive_measures::{DriveMeasures, MEASURES};
pub use totals::DriveTotals;

use crate::metrics::Measure;
use inputs::MeasureInputs;

/// Definition of a measure, and its value in a drive.
type MeasuredValue = (Measure, fn(&MeasureInputs) -> Option<f64>);
