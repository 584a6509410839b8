//! The simulation. In: a scenario and [`Controls`](crate::ego::Controls) once a tick. Out: events, and a [`Snapshot`]
//! of all there is to see, record or hash.

mod snapshot;

pub use snapshot::{CarView, Leader, Snapshot};
