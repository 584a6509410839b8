//! codrive for Python, the native part: `codrive._codrive`. In: settings and actions of Python. Out: observations and rewards in
//! numpy's memory, tables of evaluations. The Python files beside it make environments of it; docs/python.md says how it is used.
//!
//! [`configuration`] reads settings, [`rings`] moves many environments at once, [`drive`] drives whole drives (`picture` draws them where the build can), [`evaluation`] judges policies, [`policy_file`] writes
//! them, [`folders`] reads what was recorded, [`benchmark`] says how fast rings are without Python, [`sweep`] carries out runs of plans,
//! [`threads`] keeps Python out while others compute.

mod benchmark;
mod configuration;
mod drive;
mod evaluation;
mod folders;
#[cfg(feature = "desktop")]
mod picture;
mod policy_file;
mod rings;
mod sweep;
mod threads;

use pyo3::prelude::*;

/// The native part of codrive. Use the package `codrive`.
#[pymodule]
mod _codrive {
    #[pymodule_export]
    use super::{
        benchmark::random_steps,
        configuration::{Configuration, data_folder},
        drive::{Drive, DriveConfiguration, sumo_home, try_network},
        evaluation::{evaluate_answers, evaluate_policy, policy_names},
        folders::{find_drives, measures, recorded_settings, space_time},
        policy_file::{network_description, write_network},
        rings::Rings,
        sweep::Plan,
    };

    #[pymodule_export]
    const HAS_DESKTOP: bool = super::drive::HAS_DESKTOP;

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        super::drive::try_networks_apart(module)
    }
}
