//! Evaluations by whole drives, as in `codrive evaluate --traffic`. In: settings, and a policy by name or as a Python function. Out: the
//! result of each drive as JSON, in which numbers keep their bits.

use crate::{
    drive_configuration::DriveConfiguration,
    evaluation::{ASKED, row},
    rings::scale_rows,
    threads,
};
use codrive::{
    drive_loop::evaluation_drive::evaluate_planned,
    policy::{self, Action, Hold, NetworkInput, Observation, Policy, PolicySource},
    scenario::{AdvisedVehicles, PlannedDrive, Scenario},
    sim::policy_of,
    train::{TrainConfig, rollout::action},
};
use numpy::{PyArray2, PyArrayMethods};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicU32, Ordering},
};

/// Drives of one evaluation, which differ by their seed.
#[pyclass(frozen, module = "codrive_sim._codrive")]
pub struct EvaluationDrive {
    drive: PlannedDrive,
    learning: TrainConfig,
    inputs: Vec<NetworkInput>,
    policy: String,
    warning: Option<String>,
}

#[pymethods]
impl EvaluationDrive {
    /// Checks an evaluation: a policy by its name or file, or `None` for one that is asked; the target speed of built-in policies, m/s;
    /// and the advised vehicles as text, `None` for the participant's.
    #[new]
    fn new(
        py: Python<'_>,
        configuration: &DriveConfiguration,
        policy: Option<&str>,
        policy_speed_mps: f64,
        advised: Option<&str>,
    ) -> PyResult<Self> {
        threads::interruptible(py, || Self::checked(configuration, policy, policy_speed_mps, advised))?
            .map_err(PyValueError::new_err)
    }

    /// Returns the policy's name, with which `auto` was resolved.
    #[getter]
    fn policy(&self) -> &str {
        &self.policy
    }

    /// Returns a warning if the policy was not trained for this hold.
    #[getter]
    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Drives the drive of this seed. `ask` gets the number of a policy, one for each advised vehicle, and its observation, float32,
    /// `(1, inputs)`; it returns the action, -1 to 1 or the number of a level.
    fn evaluate(&self, py: Python<'_>, seed: u64, ask: Option<Py<PyAny>>) -> PyResult<String> {
        let asked = ask.map(|ask| {
            Arc::new(AskedPolicies {
                learning: self.learning.clone(),
                inputs: self.inputs.clone(),
                hold: self.drive.scenario().hold(),
                ask,
                engaged: AtomicU32::new(0),
                fault: Mutex::new(None),
            })
        });
        let source = asked.clone().map(AskedPolicies::source);
        let result = threads::interruptible(py, || {
            let scenario = Scenario { seed, ..self.drive.scenario().clone() };
            let drive = PlannedDrive::on(&scenario, Arc::clone(self.drive.map())).map_err(|why| why.to_string())?;
            evaluate_planned(drive.advised_by(source)).map_err(|why| why.to_string())
        })?;
        if let Some(fault) = asked.and_then(|asked| asked.fault.lock().unwrap_or_else(PoisonError::into_inner).take()) {
            return Err(fault);
        }
        let result = result.map_err(PyRuntimeError::new_err)?;
        let scenario = self.drive.scenario();
        Ok(row(&result, scenario.advised, &scenario.policy, scenario.vehicles).to_string())
    }
}

impl EvaluationDrive {
    fn checked(
        configuration: &DriveConfiguration,
        policy: Option<&str>,
        policy_speed_mps: f64,
        advised: Option<&str>,
    ) -> Result<Self, String> {
        let config = &configuration.config;
        if config.draws_drivers {
            return Err(
                "driver is drawn for each vehicle; allowed in evaluations by whole drives: one driver for all\n  \
                        remedy: driver='follow' or another name, or traffic='ring'"
                    .into(),
            );
        }
        let map = Arc::clone(config.drive(0).map_err(|why| why.to_string())?.map());
        let scenario = Scenario {
            policy: policy.unwrap_or(ASKED).into(),
            policy_speed_mps,
            advised: match advised {
                Some(text) => text.parse().map_err(|why: codrive::scenario::UnknownShare| why.to_string())?,
                None => AdvisedVehicles::default(),
            },
            duration_s: config.learning.ring.horizon_s,
            ..config.scenario.clone()
        };
        let drive = PlannedDrive::on(&scenario, map).map_err(|why| why.to_string())?;
        check_advised(&drive, advised, policy)?;
        let drive = match policy {
            Some(_) => drive,
            None => drive.advised_by(Some(AskedPolicies::looked_at(config.inputs()))),
        };
        let (resolved, source) = policy_of(&drive).map_err(|why| why.to_string())?;
        let vehicles = drive.fixed_vehicles();
        let warning = source.engage().and_then(|policy| {
            let share = drive.advised().share_of(vehicles.unwrap_or(1));
            let share = policy::untrained_share(policy.as_ref(), share, vehicles);
            let hold = policy::untrained_hold(policy.as_ref(), drive.scenario().hold());
            [hold, share].into_iter().flatten().reduce(|one, other| format!("{one}\n{other}"))
        });
        // A curve over shares names the policy of its other points where no vehicle is advised.
        let name = if drive.scenario().advises_no_vehicle() { scenario.policy } else { resolved.name };
        Ok(Self { drive, learning: config.learning.clone(), inputs: config.inputs(), policy: name, warning })
    }
}

/// Refuses vehicles that this road cannot advise, as `codrive evaluate` does.
fn check_advised(drive: &PlannedDrive, asked: Option<&str>, policy: Option<&str>) -> Result<(), String> {
    let (map, advised) = (&drive.scenario().map, drive.scenario().advised);
    match (drive.advisable(), advised) {
        (Some(vehicles), AdvisedVehicles::Count(count)) if count > vehicles => Err(format!(
            "advised is {count}; allowed: 0 to {vehicles}, as many as there are vehicles, or a share such as '25%'"
        )),
        (None, AdvisedVehicles::Count(count)) if count > 0 => {
            let why = match asked {
                Some(_) => format!("advised is {count}; allowed: a share of the vehicles that enter"),
                None => "the advised vehicles are a share of those that enter".into(),
            };
            Err(format!("name is {map:?}, a network that vehicles enter and leave: {why}\n  remedy: advised='25%'"))
        }
        (None, _) if policy == Some(policy::AUTO) => Err(format!(
            "name is {map:?}, a network that vehicles enter and leave: policy 'auto' has no policy there\n  remedy: \
             policy='pi', or 'constant', 'follower-stopper' or 'linear-feedback' with policy_speed, or a file"
        )),
        _ => Ok(()),
    }
}

/// Policies of the advised vehicles of one drive, which ask a Python function.
struct AskedPolicies {
    learning: TrainConfig,
    inputs: Vec<NetworkInput>,
    hold: Hold,
    ask: Py<PyAny>,
    /// Number of policies so far.
    engaged: AtomicU32,
    /// First exception of the function.
    fault: Mutex<Option<PyErr>>,
}

impl AskedPolicies {
    /// Returns the source of these policies; each has a number of its own.
    fn source(self: Arc<Self>) -> PolicySource {
        PolicySource::engaged_by(move || {
            let number = self.engaged.fetch_add(1, Ordering::Relaxed);
            Box::new(AskedPolicy { number, all: Arc::clone(&self) })
        })
    }

    /// Returns the source of policies with these inputs, which are looked at and not asked.
    fn looked_at(inputs: Vec<NetworkInput>) -> PolicySource {
        PolicySource::engaged_by(move || Box::new(UnaskedPolicy(inputs.clone())))
    }

    /// Returns the function's action for an observation.
    fn answer(&self, number: u32, seen: &Observation) -> PyResult<f32> {
        Python::attach(|py| {
            let table = PyArray2::zeros(py, [1, self.inputs.len()], false);
            // SAFETY: the array is new and has no other user.
            scale_rows(&self.inputs, std::slice::from_ref(seen), unsafe { table.as_slice_mut() }?);
            self.ask.call1(py, (number, table))?.extract(py)
        })
    }
}

/// Policy of one advised vehicle, which asks a Python function.
struct AskedPolicy {
    number: u32,
    all: Arc<AskedPolicies>,
}

impl Policy for AskedPolicy {
    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        match self.all.answer(self.number, observation) {
            Ok(drawn) => action(&self.all.learning, drawn, self.all.hold),
            Err(fault) => {
                self.all.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
                // The advice before remains; the result of this drive is not used.
                Action::Speed(f64::NAN)
            }
        }
    }

    fn inputs(&self) -> &[NetworkInput] {
        &self.all.inputs
    }
}

/// Policy whose inputs are checked before a drive.
struct UnaskedPolicy(Vec<NetworkInput>);

impl Policy for UnaskedPolicy {
    fn act(&mut self, _time_s: f64, _observation: &Observation) -> Action {
        Action::Speed(f64::NAN)
    }

    fn inputs(&self) -> &[NetworkInput] {
        &self.0
    }
}
