//! Native part of codrive for Python: `codrive_sim._codrive`. In: settings and actions of Python. Out: observations and rewards in numpy's
//! memory, tables of evaluations. The Python files beside it turn these into environments; docs/python.md describes their use.
//!
//! * [`configuration`] reads settings.
//! * [`rings`] moves many environments at once.
//! * [`drive_configuration`] reads settings of whole drives, [`drive`] runs them; [`traffic_columns`] has their vehicles; `picture` draws
//!   them if the build can.
//! * [`evaluation`] evaluates policies on rings, [`evaluation_drive`] by whole drives, [`policy_file`] writes them.
//! * [`folders`] reads recordings.
//! * [`benchmark`] measures the speed of rings without Python.
//! * [`sweep`] makes the runs of plans.
//! * [`threads`] releases Python's lock during computations.

mod benchmark;
mod configuration;
mod drive;
mod drive_configuration;
mod evaluation;
mod evaluation_drive;
mod folders;
#[cfg(feature = "desktop")]
mod picture;
mod policy_file;
mod rings;
mod sweep;
mod threads;
mod traffic_columns;

use pyo3::prelude::*;

/// Native part of codrive. Use the package `codrive_sim`.
#[pymodule]
mod _codrive {
    #[pymodule_export]
    use super::{
        benchmark::random_steps,
        configuration::{Configuration, data_folder},
        drive::{Drive, sumo_home, try_network},
        drive_configuration::DriveConfiguration,
        evaluation::{evaluate_actions, evaluate_policy, measure_names, policy_names},
        evaluation_drive::EvaluationDrive,
        folders::{find_drives, measures, recorded_settings, space_time},
        policy_file::{network_description, write_network},
        rings::Rings,
        sweep::Plan,
    };

    #[pymodule_export]
    const HAS_DESKTOP: bool = super::drive::HAS_DESKTOP;

    #[pymodule_export]
    const VEHICLE_COLUMNS: [&str; super::traffic_columns::VEHICLE_COLUMNS.len()] =
        super::traffic_columns::VEHICLE_COLUMNS;

    #[pymodule_export]
    const HOLD_MEASURES: [&str; super::traffic_columns::HOLD_MEASURES.len()] = super::traffic_columns::HOLD_MEASURES;

    #[pymodule_export]
    const CAR_SIZE_M: (f64, f64) = (codrive::space::CAR_LENGTH_M, codrive::space::CAR_WIDTH_M);

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        super::drive::try_networks_apart(module)
    }
}
