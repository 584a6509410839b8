//! Moments of traffic: numbers that say how people, or a model of people, follow each other in one lane. In: speed and gap of each
//! vehicle at each step. Out: [`TrafficMoments`], with names and definitions of [`crate::metrics::registry`]. SI units.
//!
//! * `trajectories`: the vehicles, each with its leader; `trajectory_file`: the same from a file of a lab; `log_file`: with
//!   positions, to be driven again.
//! * `persons`: numbers of one person; `moments`: the list of moments.
//! * `criteria`: values of measured people, and how near to them a model has to be.
//!
//! The definitions reproduce the values of experiment A of the Arizona ring (docs/references.md: people).

mod criteria;
mod log_file;
mod moments;
mod persons;
mod trajectories;
mod trajectory_columns;
mod trajectory_file;

pub use criteria::{
    Criterion, EXPERIMENT_A, EXPERIMENT_G, GAP_QUANTILES_M, Judgement, MEASURED, MeasuredTraffic, OPENACC_SPEED_SD_MPS,
    judge,
};
pub use log_file::read_log;
pub use moments::{MOMENTS, TrafficMoments, moments, moments_of_persons, platoon_speed_sd_mps};
pub use persons::{PersonMoments, persons};
pub use trajectories::{VehicleTrajectories, VehicleTrajectory};
pub use trajectory_file::{COLUMNS, MOST_ROWS, TrajectoryFault, read_trajectories};

#[cfg(test)]
pub(crate) mod measured_people_tests;
#[cfg(test)]
mod tests;
