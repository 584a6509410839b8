//! Responses of drivers to the advice. In: changes of the advice, and the ego's rows in order. Out: the response to each change
//! (SAE J2944), and distributions of response times.
//!
//! * [`advice_onsets`]: changes of the advice that need a response; [`pedal_noise`]: pedal movements without one;
//!   [`response_detection`]: the driver's response to each change.
//! * [`response_time`]: kinds of times; [`latency_fit`]: distributions of censored times; [`response_time_model`]: responses
//!   with chance movements beside them; `simplex`: the search for the greatest likelihood.
//! * [`scripted_responses`]: responses to the events of a scenario.

pub mod advice_onsets;
pub mod latency_fit;
pub mod pedal_noise;
pub mod response_detection;
pub mod response_time;
pub mod response_time_model;
pub mod scripted_responses;
mod simplex;

pub use advice_onsets::{DriveOnsets, OnsetFinder, OnsetKind};
pub use pedal_noise::PedalNoise;
pub use response_detection::{AdviceResponse, ResponseWatch};
pub use response_time::{ResponseTime, TimeFit};
pub use scripted_responses::{ScriptedResponse, ScriptedResponses};
