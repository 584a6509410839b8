//! The simulation. In: a [`Scenario`] and [`Controls`](crate::ego::Controls) once a tick. Out: events, and a
//! [`Snapshot`] of all there is to see, record or hash.

mod fields;
mod scenario;
mod snapshot;

pub use fields::{Field, Kind, fields};
pub use scenario::{OnContact, QualityLevel, Scenario, StartLayout};
pub use snapshot::{CarView, Leader, Snapshot};
