//! Participants as simulated drivers. In: stretches of their drives. Out: the numbers of the simulated driver that explain them
//! best ([`driver_fit`]), for each participant ([`participants`]).

pub mod driver_fit;
pub mod participants;

pub use driver_fit::{FoundDriver, FoundNumber};
pub use participants::ParticipantDriver;
