//! Sound. In: the audible state of the world after a tick, as a [`SoundScene`]. Out: stereo samples, to a device
//! ([`Speaker`]) or to a file ([`SoundFile`]), by one [`Mixer`]. Spoken instructions and guidance go to the device separately
//! ([`Voice`]), the latter by the program espeak-ng (`speech`); the room is recorded if a study asks for it ([`RoomRecording`]).
//!
//! [`Listener`] makes a [`SoundScene`] of snapshot and events. Engine: pitch by engine speed (speed times the gear's
//! ratio), timbre by load. Tyres: by speed, on asphalt or grass. Wind: by speed. Other vehicles: by distance, side and
//! speed; people: footsteps and bicycle tyres. Horn, contact, and a tone at a change of advice. Every number glides to its new value, so that nothing
//! clicks; a soft limiter keeps all samples below full scale. Samples are shares of full scale, time is in seconds,
//! levels are in decibels.

mod engine;
mod file;
mod filtered_noise;
mod microphone;
mod mixer;
mod one_shot;
mod smoothing;
mod sound_scene;
mod speaker;
mod speech;
mod traffic;
mod voice;

pub use file::{RATE_HZ, SoundFile};
pub use microphone::{RoomRecording, RoomStatus};
pub use mixer::Mixer;
pub use sound_scene::{Listener, NEAR, NearbyVehicle, SoundScene, SoundSource};
pub use speaker::{Speaker, SpeakerFault, output};
pub use speech::{SpeechFault, speech_program, spoken};
pub use voice::{Voice, VoiceStatus};

#[cfg(test)]
#[path = "people_tests.rs"]
mod people_tests;
#[cfg(test)]
#[path = "tests.rs"]
mod tests;
