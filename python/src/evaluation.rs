//! Evaluations as in `codrive evaluate`. In: settings, and a policy by name or as a Python function. Out: the result of each ring as JSON,
//! in which numbers keep their bits.

use crate::{configuration::Configuration, rings::scale_rows, threads};
use codrive::{
    data_folders,
    map::RoadMap,
    metrics::{EVALUATED, EvaluationResult},
    policy::{self, Action, Hold, Observation, PolicySource},
    scenario::AdvisedVehicles,
    train::{TrainConfig, evaluate_jointly, evaluate_part, rollout::action},
};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use serde_json::{Value, json};
use std::{
    sync::{Mutex, PoisonError, mpsc},
    thread,
};

/// Name of the rings' random stream, the same as in `codrive evaluate`.
const STREAM: &str = "evaluate";

/// Name in place of that of a policy that is a function.
pub const ASKED: &str = "outside";

/// Number of rings between two calls of `done`, in which Python notices Ctrl-C.
const PART: usize = 64;

/// Returns the names of the built-in policies, as in `codrive evaluate`, and of the shipped ones.
#[pyfunction]
pub fn policy_names() -> (Vec<&'static str>, Vec<String>) {
    (policy::NAMES.to_vec(), policy::shipped())
}

/// Evaluates a policy by its name or file. Returns its own name, warnings, and the results as JSON.
#[pyfunction]
pub fn evaluate_policy(
    py: Python<'_>,
    configuration: &Configuration,
    name: &str,
    map: &str,
    policy_speed_mps: f64,
    rings: usize,
    done: &Bound<'_, PyAny>,
) -> PyResult<(String, Option<String>, String)> {
    let config = &configuration.config;
    data_folders::require().map_err(|why| PyValueError::new_err(why.to_string()))?;
    let name = match name {
        policy::AUTO => policy::resolve(name, &RoadMap::load(map).map_err(refused)?).name,
        other => other.to_owned(),
    };
    let source = PolicySource::for_rings(&name, &config.policy_settings(policy_speed_mps)).map_err(refused)?;
    let hold = Hold::nearest(config.advice.hold_s, config.ring.step_s);
    let (share, vehicles) = (config.ring.advised.share_of(config.ring.vehicles_max), Some(config.ring.vehicles_max));
    let warning = source.engage().and_then(|policy| {
        let warnings =
            [policy::untrained_hold(policy.as_ref(), hold), policy::untrained_share(policy.as_ref(), share, vehicles)];
        warnings.into_iter().flatten().reduce(|one, other| format!("{one}\n{other}"))
    });
    let mut results: Vec<EvaluationResult> = Vec::new();
    while results.len() < rings {
        let part = results.len()..(results.len() + PART).min(rings);
        results.extend(threads::on_all_cores(py, || evaluate_part(config, STREAM, part, rings, || source.engage()))?);
        done.call1((results.len(),))?;
    }
    let results = json(config, &name, &results);
    Ok((name, warning, results))
}

/// Evaluates a Python function. `ask` gets the observations of all advised vehicles, ring after ring, float32, `(rows, inputs)`, and returns
/// their actions, float32, `(rows,)`, -1 to 1 or numbers of levels. Returns the results as JSON.
#[pyfunction]
pub fn evaluate_actions(
    py: Python<'_>,
    configuration: &Configuration,
    rings: usize,
    ask: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let config = &configuration.config;
    let (hold, inputs) = (config.hold(), config.inputs());
    let rows = rings * config.ring.advised_slots().count();
    let answer = |seen: &[Observation]| {
        py.check_signals()?;
        let table = PyArray2::zeros(py, [rows, inputs.len()], false);
        // SAFETY: the array is new and has no other user.
        scale_rows(&inputs, seen, unsafe { table.as_slice_mut() }?);
        let answers: PyReadonlyArray1<'_, f32> = ask.call1((table,))?.extract()?;
        let answers = answers.as_slice()?;
        if answers.len() != rows {
            return Err(PyValueError::new_err(format!(
                "the policy gave {} actions for {rows} vehicles",
                answers.len()
            )));
        }
        Ok(answers.iter().map(|answer| action(config, *answer, hold)).collect::<Vec<_>>())
    };
    // The rings run on threads of their own; Python is called on this one, where Ctrl-C arrives.
    let (question, questions) = mpsc::channel::<Vec<Observation>>();
    let (reply, replies) = mpsc::channel::<Vec<Action>>();
    // The closure without Python's lock may use only `Sync` values, hence the mutex.
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
        // Dropping the sender tells the rings that no more actions come.
        drop(reply);
        let driven = threads::here(py, || driving.join())?;
        asked?;
        match driven {
            Ok(Ok(results)) => Ok(json(config, ASKED, &results)),
            Ok(Err(Unanswered)) | Err(_) => Err(PyRuntimeError::new_err("a bug of codrive: the rings stopped early")),
        }
    })
}

/// Error of an evaluation whose policy has stopped responding.
struct Unanswered;

/// Returns the measures of a drive with `vehicles` vehicles as one flat table, with the number and the planned share of the vehicles that a
/// policy of this name advises.
pub fn row(result: &EvaluationResult, advised: AdvisedVehicles, policy: &str, vehicles: u32) -> Value {
    let number = advised.by_policy(policy).of(vehicles);
    let mut row = json!({ "advised_vehicles": number, "advised_share": advised.share_of(vehicles) });
    let Value::Object(mut measures) = serde_json::to_value(result).unwrap_or_default() else { return row };
    let of_network = measures.remove("network");
    for (name, value) in measures.into_iter().chain(of_network.iter().filter_map(Value::as_object).flatten().map(owned))
    {
        row[name] = value;
    }
    row
}

fn owned((name, value): (&String, &Value)) -> (String, Value) {
    (name.clone(), value.clone())
}

/// Returns the results of rings with a policy of this name.
fn json(config: &TrainConfig, policy: &str, results: &[EvaluationResult]) -> String {
    let of_one = |result| row(result, config.ring.advised, policy, config.ring.vehicles_min);
    let rows: Vec<Value> = results.iter().map(of_one).collect();
    Value::Array(rows).to_string()
}

/// Returns the names of the measures of an evaluated drive, in the order of `rings.csv`.
#[pyfunction]
pub fn measure_names() -> Vec<&'static str> {
    EVALUATED.iter().map(|(measure, _)| measure.name).collect()
}

fn refused(why: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(why.to_string())
}
