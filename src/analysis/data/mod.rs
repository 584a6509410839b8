//! Contents of recordings and data sets. In: a folder. Out: the recordings in it, the rows of each from front to back, and the
//! participants of a study. Nothing here reads a whole table, so that a drive of days fits into memory. SI units.
//!
//! * [`found`]: the recordings in a folder, each with its condition.
//! * [`trial`]: one recorded drive; [`ego_samples`], [`advice`], [`road_events`], [`traffic_steps`], [`trips`],
//!   [`frame_times`]: its tables; [`setup`]: its manifest and scenario.
//! * [`trajectories`]: data for the figures of a drive; [`driver_moments`]: data for the fit of its driver; `thinned_values`:
//!   evenly spaced values out of many; [`recorded_log`]: a file of trajectories of a drive.
//! * [`people`]: participants; [`person_answers`]: age, gender and driving; [`session_ends`]: reasons of early ends and exclusions;
//!   [`statements`]: recruitment, ethics, apparatus; [`sickness_ratings`]: ratings of sickness while driving; `tsv`: tables of a data set.

pub mod advice;
pub mod driver_moments;
pub mod ego_samples;
pub mod found;
pub mod frame_times;
mod gaze;
pub mod people;
pub mod person_answers;
pub mod recorded_log;
pub mod road_events;
pub mod scripted_moments;
pub mod session_ends;
pub mod setup;
pub mod sickness_ratings;
pub mod statements;
mod thinned_values;
pub mod traffic_steps;
pub mod trajectories;
pub mod trial;
pub mod trips;
mod tsv;

pub use advice::{AdviceChange, ChangeFinder, IssuedAdvice};
pub use driver_moments::DriverStretches;
pub use ego_samples::EgoSample;
pub use found::{FolderContents, FoundRecording, find};
pub use frame_times::FrameTimes;
pub use people::{StudyParticipant, StudyParticipants};
pub use recorded_log::write_log;
pub use road_events::RoadEvents;
pub use session_ends::EndReasons;
pub use setup::DriveSetup;
pub use sickness_ratings::SicknessRating;
pub use statements::MethodsStatements;
pub(super) use thinned_values::ThinnedValues;
pub use traffic_steps::{StepVehicle, TrafficStep};
pub use trajectories::DriveTrajectories;
pub use trial::RecordedTrial;
pub use trips::{Trip, TripEnd, TripTable};
