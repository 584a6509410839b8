//! The simulation. In: a [`Scenario`] and [`Controls`](crate::ego::Controls) once a tick. Out: events, and a
//! [`Snapshot`] of all there is to see, record or hash.

pub mod colour;
mod error;
mod event;
mod fields;
mod ground;
mod load;
mod scenario;
mod snapshot;
pub mod sound;
mod summary;
mod world;

pub use error::WorldError;
pub use event::{EndReason, Event, EventKind};
pub use fields::{Field, Kind, fields, fields_of};
pub use load::{ScenarioError, Settings, settings_changed, settings_from_file, settings_from_toml, settings_with};
pub use scenario::{CockpitView, DialPalette, FlashPatch, OnContact, QualityLevel, Scenario, StartLayout};
pub use snapshot::{CarView, HASH_START, Leader, Pitch, Snapshot, is_in_lane};
pub use sound::SoundLevels;
pub use summary::{ContactRecord, Summary, Tally};
pub use world::{ExpectedSpeeds, NotPutBack, World};
