//! The vehicles of a closed route between two steps of their engine; all are present from the start. In: once a step, the agents' present
//! and predicted states; once a tick, the elapsed share of the step. Out: the poses of all vehicles that are not agents at that tick, and
//! whether the engine's next step is complete. Metres, m/s. The engine runs one step ahead (docs/decisions.md: 3).

use super::{
    agent::{Agent, NewAgent},
    hand_over::{HandOver, HandOverGate},
    traffic_coupling::StartPlace,
};
use crate::{
    ego::Obstacle,
    map::{RoadMap, Route},
    scenario::{Scenario, StartLayout},
    sim::Snapshot,
    space::CAR_LENGTH_M,
    time::TICK_S,
    traffic::{
        self, CarState, EGO, InitialVehicle, ModelMixture, Traffic, TrafficError, TrafficSetup, VehicleId,
        VehicleReport,
    },
};
use std::{sync::Arc, time::Duration};

/// A traffic engine and the two steps around the present tick.
pub(super) struct RingCoupling {
    engine: Box<dyn Traffic>,
    /// All vehicles at the last step and at the next, the ego first.
    pub from: Vec<CarState>,
    pub to: Vec<CarState>,
    /// Progress of the next step, once the engine has been asked for it.
    asked: Option<Answer>,
    /// Vehicles that are not agents at this tick, as obstacles.
    obstacles: Vec<Obstacle>,
    /// Indexed by id: true for agents, which move by their own physics.
    is_agent: Vec<bool>,
    reports: Vec<VehicleReport>,
    is_stopped: bool,
    /// State of traffic at the hand-over to the driver.
    pub hand_over: HandOver,
}

/// Progress of a step that an engine has been asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Answer {
    Awaited,
    Here,
}

impl RingCoupling {
    /// Starts the engine with the scenario's layout, then runs the warm-up and waits until traffic meets the scenario's conditions for the
    /// hand-over.
    pub fn start(scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Self, TrafficError> {
        let setup = TrafficSetup {
            cars: start_cars(scenario, &map.route)?,
            map: Arc::clone(map),
            idm: scenario.idm,
            mixture: ModelMixture { model: scenario.other_model, share: scenario.other_model_share },
            step_s: scenario.step_s,
            seed: scenario.seed,
            noise_streams: scenario.noise_streams,
            timeout_s: scenario.traffic_timeout_s,
            lateral_accel_mps2: scenario.lateral_accel_bound_mps2(&map.route),
        };
        let mut engine = traffic::start(&scenario.traffic, setup)?;
        for _ in 0..(scenario.warm_up_s / scenario.step_s).round() as u64 {
            traffic::go_on()?;
            engine.step(&[])?;
        }
        let mut gate = HandOverGate::new(scenario);
        let hand_over = loop {
            if let Some(hand_over) = gate.look(engine.cars()) {
                break hand_over;
            }
            traffic::go_on()?;
            engine.step(&[])?;
        };
        let to = engine.cars().to_vec();
        let obstacles = Vec::with_capacity(to.len() - 1);
        let mut is_agent = vec![false; to.len()];
        is_agent[EGO.0 as usize] = true;
        let (from, reports) = (to.clone(), Vec::with_capacity(to.len()));
        Ok(Self { engine, from, to, asked: None, obstacles, is_agent, reports, is_stopped: false, hand_over })
    }

    /// Returns the engine, for traffic without agents.
    pub fn into_engine(self) -> Box<dyn Traffic> {
        self.engine
    }

    /// Returns the advised vehicles other than the ego as new agents, once.
    pub fn new_agents(&mut self, scenario: &Scenario, map: &Arc<RoadMap>) -> Vec<NewAgent> {
        let (cars, is_agent) = (&self.to, &mut self.is_agent);
        let take = |k: u32| {
            let car = &cars[k as usize];
            let start = StartPlace { s_m: car.s_m, speed_mps: car.speed_mps };
            let is_new = !std::mem::replace(&mut is_agent[k as usize], true);
            is_new.then(|| NewAgent { id: VehicleId(k), map: Arc::clone(map), start })
        };
        scenario.advised.others(scenario.vehicles).filter_map(take).collect()
    }

    /// Returns the ego and all others at the next step.
    pub fn at_next_step(&self) -> (&CarState, &[CarState]) {
        self.to.split_first().expect("traffic has the ego")
    }

    /// Returns true if the engine has been asked for the next step.
    pub fn is_asked(&self) -> bool {
        self.asked.is_some()
    }

    /// Asks the engine for the next step, with the agents' present states and their predictions for its end.
    pub fn ask(&mut self, agents: &[Agent], step_s: f64) -> Result<(), TrafficError> {
        self.reports.clear();
        self.reports.extend(agents.iter().map(|agent| VehicleReport { id: agent.id(), state: agent.report(step_s) }));
        self.engine.begin_step(&self.reports)?;
        self.asked = Some(Answer::Awaited);
        Ok(())
    }

    /// Returns true once the step that was asked for is complete; waits for at most `patience`.
    pub fn wait(&mut self, patience: Duration) -> Result<bool, TrafficError> {
        if self.asked == Some(Answer::Awaited) && self.engine.finish_step(patience)? {
            self.asked = Some(Answer::Here);
        }
        Ok(self.asked != Some(Answer::Awaited))
    }

    /// Begins the step that was asked for.
    pub fn begin_step(&mut self) {
        self.asked = None;
        std::mem::swap(&mut self.from, &mut self.to);
        self.to.clear();
        self.to.extend_from_slice(self.engine.cars());
    }

    /// Moves all vehicles that are not agents to their poses at `fraction` of the step.
    pub fn move_cars(&mut self, snapshot: &mut Snapshot, route: &Route, fraction: f64) {
        self.obstacles.clear();
        for ((view, from), to) in snapshot.cars.iter_mut().zip(&self.from[1..]).zip(&self.to[1..]) {
            if self.is_agent[view.id.0 as usize] {
                continue;
            }
            let s_m = route.wrap(from.s_m + route.difference(from.s_m, to.s_m) * fraction);
            view.odometer_m += route.difference(view.s_m.unwrap_or(s_m), s_m);
            view.s_m = Some(s_m);
            view.pose_before = view.pose;
            view.pose = route.pose_of_front(s_m, CAR_LENGTH_M);
            view.speed_mps = from.speed_mps + (to.speed_mps - from.speed_mps) * fraction;
            view.accel_mps2 = to.accel_mps2;
            view.lamps.brake = to.braking;
            view.pitch = view.pitch.step(view.accel_mps2, TICK_S);
            let (id, pose, speed_mps) = (view.id.0, view.pose, view.speed_mps);
            self.obstacles.push(Obstacle { id, pose, speed_mps, ..Obstacle::default() });
        }
    }

    /// Returns the vehicles at the poses set by [`RingCoupling::move_cars`].
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Releases the engine; no further step is possible.
    pub fn stop(&mut self) {
        self.engine = Box::new(StoppedEngine { cars: self.to.clone(), description: self.engine.describe() });
        self.is_stopped = true;
    }

    /// Returns true after a call of [`RingCoupling::stop`].
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// Returns the engine's name and version.
    pub fn describe(&self) -> String {
        self.engine.describe()
    }

    /// Replaces the engine from the next step on.
    #[cfg(test)]
    pub fn set_engine(&mut self, engine: Box<dyn Traffic>) {
        self.engine = engine;
    }

    /// Returns all vehicles as the engine has them.
    #[cfg(test)]
    pub fn cars(&self) -> &[CarState] {
        self.engine.cars()
    }
}

/// Returns all vehicles in the scenario's start layout.
fn start_cars(scenario: &Scenario, route: &Route) -> Result<Vec<InitialVehicle>, TrafficError> {
    let layout = match scenario.start {
        StartLayout::Even => traffic::start::even,
        StartLayout::Bunched => traffic::start::bunched,
    };
    layout(scenario.vehicles as usize, route.length_m(), scenario.idm.s0, 0.0)
}

/// Placeholder for an engine that was released.
struct StoppedEngine {
    cars: Vec<CarState>,
    description: String,
}

impl Traffic for StoppedEngine {
    fn step(&mut self, _reports: &[VehicleReport]) -> Result<(), TrafficError> {
        Err(TrafficError::Setup("this drive was stopped".into()))
    }

    fn cars(&self) -> &[CarState] {
        &self.cars
    }

    fn describe(&self) -> String {
        self.description.clone()
    }
}
