//! The simulation. In: a [`Scenario`](crate::scenario::Scenario), then [`Controls`](crate::controls::Controls) once a tick. Out: events,
//! and a [`Snapshot`] of everything that can be shown, recorded or hashed.

mod automation;
mod error;
mod event;
mod ground;
mod secondary_task;
mod summary;
mod world;

pub use crate::snapshot::{HASH_START, Leader, Pitch, Snapshot, VehicleSnapshot, is_in_lane};
pub use error::WorldError;
pub use event::{EndReason, Event, EventKind, EventStage, NotDone, PERSON_TOUCHED, ScriptedState};
pub use summary::{ContactRecord, Summary, SummaryAccumulator};
pub use world::{
    Agent, AgentDrivers, CheckedDrive, CostlyInputs, ExpectedSpeeds, HandOver, NotPutBack, OutsideSettings,
    WAVE_STANDS_S, World, policy_of, policy_settings, road_kind,
};
