//! Evaluations as `codrive evaluate` makes them. In: settings and a policy, by name or as something that answers. Out: the result of
//! each ring as JSON, in which numbers keep their bits.

use crate::{configuration::Configuration, rings::scale_rows, threads};
use codrive::{
    data_folders,
    map::RoadMap,
    metrics::EvaluationResult,
    policy::{self, Action, Hold, Observation, PolicySource},
    train::{evaluate_jointly, evaluate_part, rollout::action},
};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use std::{
    sync::{Mutex, PoisonError, mpsc},
    thread,
};

/// Random numbers of the rings: those of `codrive evaluate`.
const STREAM: &str = "evaluate";

/// Rings that are driven between two calls of `done`, in which Python hears of Ctrl-C.
const PART: usize = 64;

/// Built-in policies that drive where none is named, as in `codrive evaluate`; and the shipped ones.
#[pyfunction]
pub fn policy_names() -> (Vec<&'static str>, Vec<String>) {
    (policy::NAMES.to_vec(), policy::shipped())
}

/// Drives a policy by name or by its file. Returns its own name, what is to be warned of, and the results as JSON.
#[pyfunction]
pub fn evaluate_policy(
    py: Python<'_>,
    configuration: &Configuration,
    name: &str,
    map: &str,
    aim_mps: f64,
    rings: usize,
    done: &Bound<'_, PyAny>,
) -> PyResult<(String, Option<String>, String)> {
    let config = &configuration.config;
    data_folders::require().map_err(|why| PyValueError::new_err(why.to_string()))?;
    let name = match name {
        policy::AUTO => policy::resolve(name, &RoadMap::load(map).map_err(refused)?).name,
        other => other.to_owned(),
    };
    let source = PolicySource::for_rings(&name, &config.policy_settings(aim_mps)).map_err(refused)?;
    let hold = Hold::nearest(config.advice.hold_s, config.ring.step_s);
    let warning = source.engage().and_then(|policy| policy::untrained_hold(policy.as_ref(), hold));
    let mut results: Vec<EvaluationResult> = Vec::new();
    while results.len() < rings {
        let part = results.len()..(results.len() + PART).min(rings);
        results.extend(threads::on_all_cores(py, || evaluate_part(config, STREAM, part, rings, || source.engage()))?);
        done.call1((results.len(),))?;
    }
    Ok((name, warning, json(&results)))
}

/// Drives whoever answers: `ask` is shown what the policies of all rings see, float32, `(rings, inputs)`, and gives their actions,
/// float32, `(rings,)`, -1 to 1 or numbers of levels. Returns the results as JSON.
#[pyfunction]
pub fn evaluate_answers(
    py: Python<'_>,
    configuration: &Configuration,
    rings: usize,
    ask: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let config = &configuration.config;
    let (hold, inputs) = (config.hold(), config.inputs());
    let answer = |seen: &[Observation]| {
        py.check_signals()?;
        let table = PyArray2::zeros(py, [rings, inputs.len()], false);
        // SAFETY: the array has just been made and nobody else has it.
        scale_rows(&inputs, seen, unsafe { table.as_slice_mut() }?);
        let answers: PyReadonlyArray1<'_, f32> = ask.call1((table,))?.extract()?;
        let answers = answers.as_slice()?;
        if answers.len() != rings {
            return Err(PyValueError::new_err(format!("the policy gave {} actions for {rings} rings", answers.len())));
        }
        Ok(answers.iter().map(|answer| action(config, *answer, hold)).collect::<Vec<_>>())
    };
    // The rings are driven on threads of their own; Python is asked on this one, where Ctrl-C arrives.
    let (question, questions) = mpsc::channel::<Vec<Observation>>();
    let (reply, replies) = mpsc::channel::<Vec<Action>>();
    // Without Python's lock only what other threads may see, too, is looked at.
    let questions = Mutex::new(questions);
    let next = || questions.lock().unwrap_or_else(PoisonError::into_inner).recv();
    let pool = threads::pool()?;
    thread::scope(|scope| {
        let driving = scope.spawn(move || {
            pool.install(move || {
                evaluate_jointly(config, STREAM, rings, |seen| {
                    question.send(seen.to_vec()).map_err(|_| Unanswered)?;
                    replies.recv().map_err(|_| Unanswered)
                })
            })
        });
        let mut asked = Ok(());
        while let Ok(seen) = py.detach(next) {
            match answer(&seen) {
                Ok(actions) => drop(reply.send(actions)),
                Err(error) => {
                    asked = Err(error);
                    break;
                }
            }
        }
        // Whoever still waits for an answer is told that there is none.
        drop(reply);
        let driven = threads::here(py, || driving.join())?;
        asked?;
        match driven {
            Ok(Ok(results)) => Ok(json(&results)),
            Ok(Err(Unanswered)) | Err(_) => {
                Err(PyRuntimeError::new_err("a bug of codrive: the rings stopped on their way"))
            }
        }
    })
}

/// Nobody answers any more.
struct Unanswered;

fn json(results: &[EvaluationResult]) -> String {
    serde_json::to_string(results).unwrap_or_default()
}

fn refused(why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}
