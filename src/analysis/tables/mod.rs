//! Results as CSV. In: analysed drives, participants and drivers. Out: text of each table. Each table declares its columns
//! (name, quantity, unit, definition) beside the function that writes it; the data dictionary of the report collects them.

mod condition_table;
mod drive_tables;
mod driver_table;
mod event_table;
mod key;
mod network_tables;
mod participant_tables;
mod response_tables;

pub use condition_table::by_condition;
pub(super) use condition_table::by_condition_columns;
pub use drive_tables::{speed, trials};
pub(super) use drive_tables::{speed_columns, trials_columns};
pub use driver_table::drivers;
pub(super) use driver_table::{DRIVER_NUMBERS, drivers_columns};
pub(super) use event_table::event_columns;
pub use event_table::{EVENTS_FILE, events, have_events};
pub use network_tables::{LINES_FILE, TRIPS_FILE, lines, trips};
pub(super) use network_tables::{lines_columns, trips_columns};
pub use participant_tables::{scores, sickness};
pub(super) use participant_tables::{scores_columns, sickness_columns};
pub use response_tables::{advice, response_times};
pub(super) use response_tables::{advice_columns, response_times_columns};
