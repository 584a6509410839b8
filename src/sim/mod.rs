//! The simulation. In: a [`Scenario`] and [`Controls`](crate::controls::Controls) once a tick. Out: events, and a
//! [`Snapshot`] of all there is to see, record or hash.

pub mod colour;
mod error;
mod event;
mod ground;
mod load;
mod scenario;
mod settings;
mod snapshot;
pub mod sound;
mod summary;
mod world;

pub use error::WorldError;
pub use event::{EndReason, Event, EventKind};
pub use load::{ScenarioError, Settings, settings_changed, settings_from_file, settings_from_toml, settings_with};
pub use scenario::{CockpitView, DialPalette, FlashPatch, OnContact, QualityLevel, Scenario, StartLayout};
pub use settings::{Field, Kind, fields_of, settings};
pub use snapshot::{HASH_START, Leader, Pitch, Snapshot, VehicleSnapshot, is_in_lane};
pub use sound::SoundLevels;
pub use summary::{ContactRecord, Summary, SummaryAccumulator};
pub use world::{ExpectedSpeeds, NotPutBack, World};
