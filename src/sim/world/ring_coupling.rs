//! The cars of a closed route between two steps of their engine: all there from the start. In: once a step, where the agents are and
//! where they will be; once a tick, how much of the step has passed. Out: the places of all that are no agents at that tick.
//! Metres, m/s; the engine runs one step ahead (docs/decisions.md: 3).

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
use std::sync::Arc;

/// A traffic engine and the two steps that the present tick lies between.
pub(super) struct RingCoupling {
    engine: Box<dyn Traffic>,
    /// All cars at the last step and at the next, the ego first.
    pub from: Vec<CarState>,
    pub to: Vec<CarState>,
    /// The cars at this tick that are no agents, as those can touch them.
    obstacles: Vec<Obstacle>,
    /// By number: true of agents, which are where their bodies are.
    is_agent: Vec<bool>,
    reports: Vec<VehicleReport>,
    is_stopped: bool,
    /// How traffic was when the driver took over.
    pub hand_over: HandOver,
}

impl RingCoupling {
    /// Starts the engine with all cars where the scenario has them, and lets it run for the scenario's warm-up and until traffic
    /// is as the scenario wants it at the hand-over.
    pub fn start(scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Self, TrafficError> {
        let setup = TrafficSetup {
            cars: start_cars(scenario, &map.route)?,
            map: Arc::clone(map),
            idm: scenario.idm,
            mixture: ModelMixture { model: scenario.other_model, share: scenario.other_model_share },
            step_s: scenario.step_s,
            seed: scenario.seed,
            lateral_accel_mps2: scenario.lateral_accel_bound_mps2(&map.route),
        };
        let mut engine = traffic::start(scenario.traffic, setup)?;
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
        Ok(Self { engine, from, to, obstacles, is_agent, reports, is_stopped: false, hand_over })
    }

    /// The engine, where nobody but it drives.
    pub fn into_engine(self) -> Box<dyn Traffic> {
        self.engine
    }

    /// The cars that are advised beside the ego become agents, once.
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

    /// The ego's car and all others at the next step.
    pub fn at_next_step(&self) -> (&CarState, &[CarState]) {
        self.to.split_first().expect("traffic has the ego")
    }

    /// Has the engine make the next step, and tells it where the agents are and where they will be at its end.
    pub fn ask(&mut self, agents: &[Agent], step_s: f64) -> Result<(), TrafficError> {
        self.reports.clear();
        self.reports.extend(agents.iter().map(|agent| VehicleReport { id: agent.id(), state: agent.report(step_s) }));
        self.engine.step(&self.reports)
    }

    /// The step that was asked for begins.
    pub fn begin_step(&mut self) {
        std::mem::swap(&mut self.from, &mut self.to);
        self.to.clear();
        self.to.extend_from_slice(self.engine.cars());
    }

    /// All cars but the agents go to the place that they have `fraction` of the way through the step.
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

    /// The cars where [`RingCoupling::move_cars`] has put them.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Lets go of the engine; no step follows.
    pub fn stop(&mut self) {
        self.engine = Box::new(StoppedEngine { cars: self.to.clone(), description: self.engine.describe() });
        self.is_stopped = true;
    }

    /// True once [`RingCoupling::stop`] was called.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// The engine's name and version.
    pub fn describe(&self) -> String {
        self.engine.describe()
    }

    /// All cars as the engine has them.
    #[cfg(test)]
    pub fn cars(&self) -> &[CarState] {
        self.engine.cars()
    }
}

/// Where all cars stand at the start.
fn start_cars(scenario: &Scenario, route: &Route) -> Result<Vec<InitialVehicle>, TrafficError> {
    let layout = match scenario.start {
        StartLayout::Even => traffic::start::even,
        StartLayout::Bunched => traffic::start::bunched,
    };
    layout(scenario.vehicles as usize, route.length_m(), scenario.idm.s0, 0.0)
}

/// What is left of an engine that was let go.
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
