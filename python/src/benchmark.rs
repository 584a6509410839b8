//! Speed of rings without Python: the same rings, observations and random actions in a Rust loop.

use crate::{
    configuration::Configuration,
    rings::{RingBatch, StepBuffers},
    threads::{self, Signals},
};
use codrive::rng;
use pyo3::{exceptions::PyValueError, prelude::*};
use std::time::Instant;

/// Returns the duration of `steps` steps of `num_envs` environments under random actions, without resets, s.
#[pyfunction]
#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
pub fn random_steps(py: Python<'_>, configuration: &Configuration, num_envs: usize, steps: usize) -> PyResult<f64> {
    if num_envs == 0 {
        return Err(PyValueError::new_err("num_envs is 0; allowed: at least 1"));
    }
    let mut batch = RingBatch::new(configuration, num_envs);
    let (rows, signals) = (batch.rows(), Signals::new());
    let seconds = threads::here(py, || {
        batch.reset(1, &signals)?;
        let mut stream = rng::stream(1, "benchmark/actions");
        let mut table = [(); 2].map(|()| vec![0.0; rows * batch.inputs()]);
        let mut numbers = [(); 2].map(|()| vec![0.0; rows]);
        let mut marks = [(); 2].map(|()| vec![false; rows]);
        let mut actions = vec![0.0; rows];
        let begun = Instant::now();
        for _ in 0..steps {
            actions.iter_mut().for_each(|action| *action = stream.uniform(-1.0, 1.0) as f32);
            let ([observations, final_observations], [rewards, mean_speeds_mps]) = (&mut table, &mut numbers);
            let [terminations, truncations] = &mut marks;
            batch.step(
                &actions,
                StepBuffers { observations, final_observations, rewards, mean_speeds_mps, terminations, truncations },
                &signals,
            )?;
        }
        Ok(begun.elapsed().as_secs_f64())
    })?;
    signals.raised().and(seconds)
}
