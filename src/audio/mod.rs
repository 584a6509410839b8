//! Sound. In: the world after a tick, as [`Hear`], what there is to be heard. Out: stereo samples, to a device ([`Speaker`]) or
//! to a file ([`SoundFile`]), by one [`Mixer`].
//!
//! [`Listener`] makes a [`Hear`] of snapshot and events. Engine: pitch by engine speed (speed times the gear's ratio), timbre by
//! load. Tyres: by speed, on asphalt or grass. Wind: by speed. Other cars: by distance, side and speed. Horn, contact, and a
//! tone at another advice. Every number glides to where it is told to be, so that nothing clicks; a soft limiter keeps all
//! samples below full scale. Samples are shares of full scale, time is in seconds, levels are in decibels.

mod engine;
mod file;
mod glide;
mod hear;
mod hiss;
mod mixer;
mod others;
mod signal;
mod speaker;

pub use file::{RATE_HZ, SoundFile};
pub use hear::{Hear, Listener, NEAR, Near};
pub use mixer::Mixer;
pub use speaker::{Speaker, output};

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
