//! The other vehicles of a drive between two steps of their engine. In: once a step, the agents' present and predicted poses; once a tick,
//! the elapsed share of the step. Out: all vehicles at that tick, matched by id, the states of signals, and the vehicles that the ego can
//! touch. Metres, m/s; the engine runs one step ahead (docs/decisions.md: 3).
//!
//! A vehicle that departs in a step appears at the step's end. One that arrives goes on until the step's end and disappears there. At a
//! step's end the vehicles are exactly the engine's.

use super::{
    WorldError,
    advised_selection::AdvisedSelection,
    agent::{Agent, NewAgent},
    hand_over::HandOver,
    step_way::{PlacedVehicle, StepWay},
    traffic_start::{self, StartPlace, StartedTraffic},
};
use crate::{
    ego::Obstacle,
    map::{
        MapError, PathLanes, RoadMap, is_against,
        network::{LaneId, SignalStates},
    },
    scenario::{AdvisedBody, PlanError, PlannedDrive},
    sim::{Leader, Snapshot, VehicleSnapshot},
    space::CAR_LENGTH_M,
    time::TICK_S,
    traffic::{
        Demand, EGO, ExternalVehicleState, LaneMotion, Traffic, TrafficError, TrafficOrder, TrafficStart, VehicleId,
        VehicleKind, VehicleReport, VehicleState,
    },
};
use std::sync::Arc;

/// Largest distance from an agent at which another vehicle is a body in the agent's physics, metres. No vehicle covers it within a step.
pub(super) const TOUCHABLE_M: f64 = 100.0;

/// Distance within which the driver of a light agent on a network sees a leader, metres.
pub(super) const LEADER_REACH_M: f64 = 200.0;

/// A traffic engine, and the two steps around the present tick.
pub(super) struct TrafficCoupling {
    /// Engine; `None` after [`TrafficCoupling::stop`].
    engine: Option<Box<dyn Traffic>>,
    /// Name and version of the engine.
    engine_name: String,
    map: Arc<RoadMap>,
    lanes: PathLanes,
    step_s: f64,
    start: StartPlace,
    /// True if [`EGO`] is the participant's vehicle, which is not one of the others.
    has_participant: bool,
    /// Number of vehicles, the ego included, where it is fixed.
    fixed: Option<usize>,
    /// Ways of all other vehicles from the last step to the next, by ascending id.
    ways: Vec<StepWay>,
    /// Ways of the step before; a buffer.
    ways_before: Vec<StepWay>,
    /// States of the signals at the next step.
    signals: SignalStates,
    /// The other vehicles in the last tick.
    before: Vec<VehicleSnapshot>,
    obstacles: Vec<Obstacle>,
    /// Agents that have arrived in SUMO; they are no longer reported.
    arrived: Vec<VehicleId>,
    reports: Vec<VehicleReport>,
    motions: Vec<LaneMotion>,
    advised: AdvisedSelection,
    /// Vehicles that have entered and may become agents; at the start all that are present.
    new: Vec<VehicleId>,
    /// State of traffic at the hand-over to the driver.
    pub hand_over: HandOver,
}

fn stopped() -> TrafficError {
    TrafficError::Setup("this drive was stopped".into())
}

/// Returns the error of an order for a vehicle that is on no lane now.
fn no_vehicle(id: VehicleId) -> TrafficError {
    TrafficError::Setup(format!("vehicle {} is on no lane now", id.0))
}

/// Adds a vehicle to the obstacles if the ego of a snapshot can touch it.
fn note_obstacle(obstacles: &mut Vec<Obstacle>, car: &VehicleSnapshot, snapshot: &Snapshot) {
    let ego = snapshot.ego.position;
    if car.pose.position.distance(ego.truncate()) < TOUCHABLE_M {
        obstacles.extend(car.obstacles().filter(|obstacle| obstacle.is_at_height(ego.z)));
    }
}

impl TrafficCoupling {
    /// Starts the traffic of a scenario and runs it until the ego is put in.
    pub fn start(drive: &PlannedDrive) -> Result<Self, WorldError> {
        let _starting = TrafficStart::begin();
        let (scenario, map) = (drive.scenario(), drive.map());
        let lanes = PathLanes::new(map);
        let StartedTraffic { engine, ego, hand_over } = traffic_start::start(drive, &lanes)?;
        let mut coupling = Self {
            engine_name: engine.name_and_version(),
            engine: Some(engine),
            map: Arc::clone(map),
            lanes,
            step_s: scenario.step_s,
            start: ego,
            has_participant: scenario.participant,
            fixed: drive.fixed_vehicles().map(|vehicles| vehicles as usize),
            ways: Vec::new(),
            ways_before: Vec::new(),
            signals: SignalStates::default(),
            before: Vec::new(),
            obstacles: Vec::new(),
            arrived: Vec::new(),
            reports: Vec::new(),
            motions: Vec::new(),
            advised: AdvisedSelection::new(drive),
            new: Vec::new(),
            hand_over,
        };
        coupling.take(ego.s_m);
        if coupling.advised.can_be_others() {
            coupling.new.extend(coupling.ways.iter().map(|way| way.id));
        }
        Ok(coupling)
    }

    /// Returns the number of other vehicles whose bodies the ego's physics makes ready; 0 where vehicles come and go.
    pub fn bodies(&self) -> usize {
        self.fixed.map_or(0, |vehicles| vehicles - 1)
    }

    /// Returns a full agent's present and predicted state for the engine. On a fixed number of vehicles' closed route it is the plain pose;
    /// among vehicles that come and go it is in a lane.
    fn report(&self, agent: &Agent) -> Option<VehicleReport> {
        let (snapshot, state) = (agent.snapshot(), agent.report(self.step_s)?);
        if self.fixed.is_some() {
            return Some(VehicleReport::on_route(agent.id(), state));
        }
        let (lane, next_pose) = agent.network.reported_place(snapshot, &agent.map, &state.next_pose);
        Some(VehicleReport {
            id: agent.id(),
            state: ExternalVehicleState { next_pose, ..state },
            lane: lane.map(|at| at.lane),
            is_wrong_way: lane.is_some_and(|at| is_against(&agent.map.network, at, &state.next_pose)),
            lamps: snapshot.ego_lamps(),
        })
    }

    /// Returns the demand with the files that SUMO reads.
    pub fn demand(&self) -> Option<&Demand> {
        self.engine.as_ref().and_then(|engine| engine.demand())
    }

    /// Returns the start of the ego.
    pub fn ego_start(&self) -> StartPlace {
        self.start
    }

    /// Puts all vehicles and the states of signals into the snapshot of the first tick.
    pub fn first_view(&mut self, snapshot: &mut Snapshot) {
        self.move_vehicles(snapshot, 1.0, TICK_S);
    }

    /// Runs the engine's next step with the full agents' present and predicted states, the light agents' motions and those of events.
    pub fn ask<'a>(
        &mut self,
        agents: impl Iterator<Item = &'a Agent>,
        by_events: &[LaneMotion],
    ) -> Result<(), TrafficError> {
        let mut reports = std::mem::take(&mut self.reports);
        reports.clear();
        self.motions.clear();
        for agent in agents.filter(|agent| !self.arrived.contains(&agent.id())) {
            reports.extend(self.report(agent));
            self.motions.extend(agent.motion());
        }
        self.reports = reports;
        self.motions.extend_from_slice(by_events);
        self.motions.sort_by_key(|motion| motion.id);
        let engine = self.engine.as_mut().ok_or_else(stopped)?;
        engine.drive(&self.motions)?;
        engine.step(&self.reports)?;
        let is_agent = |id: VehicleId| {
            self.reports.iter().any(|report| report.id == id) || self.motions.iter().any(|motion| motion.id == id)
        };
        self.arrived.extend(engine.changes().arrived.iter().filter(|id| is_agent(**id)));
        if self.advised.can_be_others() {
            self.new.extend(engine.changes().departed.iter().map(|departure| departure.id));
        }
        Ok(())
    }

    /// Returns true if a vehicle has arrived in SUMO.
    pub fn has_arrived(&self, id: VehicleId) -> bool {
        self.arrived.contains(&id)
    }

    /// Returns the advised vehicles that become agents, out of those that have entered. Only cars can be agents. A vehicle stays the
    /// engine's if its path cannot be driven from its position, as inside a junction.
    pub fn new_agents(&mut self, body: AdvisedBody) -> Result<Vec<NewAgent>, TrafficError> {
        let mut agents = Vec::new();
        for id in std::mem::take(&mut self.new) {
            if self.advised.has(id) {
                agents.extend(self.take_over(id, body)?);
            }
        }
        Ok(agents)
    }

    /// Takes over a vehicle as an agent if it is a car of the ego's length and its path can be driven.
    fn take_over(&mut self, id: VehicleId, body: AdvisedBody) -> Result<Option<NewAgent>, TrafficError> {
        let at = self.ways.iter().find(|way| way.id == id).and_then(|way| way.to);
        let (Some(engine), Some(at)) = (&mut self.engine, at) else { return Ok(None) };
        let vehicle = &at.vehicle;
        let is_like_ego = vehicle.body.kind == VehicleKind::Car && (vehicle.body.length_m - CAR_LENGTH_M).abs() < 0.01;
        let Some(lane) = vehicle.lane.filter(|_| is_like_ego) else { return Ok(None) };
        if let (Some(_), Some(s_m)) = (self.fixed, at.s_m) {
            let start = StartPlace { s_m, speed_mps: vehicle.speed_mps };
            return Ok(Some(NewAgent { id, map: Arc::clone(&self.map), start }));
        }
        let edges = match body {
            AdvisedBody::Full => engine.take_over(id)?,
            AdvisedBody::Light => engine.take_pedals(id)?,
        };
        let Ok((map, s_m)) = self.path(vehicle, lane, &edges) else { return Ok(None) };
        let start = StartPlace { s_m, speed_mps: vehicle.speed_mps };
        Ok(Some(NewAgent { id, map, start }))
    }

    /// Returns the road with the rest of these edges as the path of a vehicle in this lane, and the vehicle's place on it, metres.
    fn path(&self, vehicle: &VehicleState, lane: LaneId, edges: &[String]) -> Result<(Arc<RoadMap>, f64), MapError> {
        let here = &self.map.network.edge_of(lane).id;
        let ahead: Vec<&str> = edges.iter().map(String::as_str).skip_while(|edge| edge != here).collect();
        let map = self.map.along(&ahead, lane)?;
        let s_m = map.route.project(vehicle.pose.front(CAR_LENGTH_M), Some(vehicle.s_m)).s_m;
        Ok((Arc::new(map), s_m))
    }

    /// Gives the engine an order. Returns the new path of the vehicle, and its place on it, for the order of a route.
    ///
    /// # Errors
    /// The vehicle is not there, the route does not go on from it, or the engine refuses; nothing has changed.
    pub fn order(&mut self, order: &TrafficOrder) -> Result<Option<(Arc<RoadMap>, f64)>, WorldError> {
        let path = match order {
            TrafficOrder::Route { id, edges } => {
                let at = self.ways.iter().find(|way| way.id == *id).and_then(|way| way.to);
                let vehicle = at.map(|at| at.vehicle).ok_or_else(|| no_vehicle(*id))?;
                let lane = vehicle.lane.ok_or_else(|| no_vehicle(*id))?;
                Some(self.path(&vehicle, lane, edges).map_err(PlanError::from)?)
            }
            _ => None,
        };
        self.engine.as_mut().ok_or_else(stopped)?.order(order)?;
        Ok(path)
    }

    /// Returns the leader of a vehicle on a network at the end of the last step; `None` without one, or where the engine has gone on.
    pub fn leader(&self, id: VehicleId, reach_m: f64) -> Result<Option<Leader>, TrafficError> {
        let Some(engine) = self.engine.as_ref().filter(|_| !self.arrived.contains(&id)) else { return Ok(None) };
        engine.leader(id, reach_m)
    }

    /// Returns the name of a vehicle in the demand, and that of its type.
    pub fn names(&self, id: VehicleId) -> Result<[String; 2], WorldError> {
        Ok(self.engine.as_ref().ok_or_else(stopped)?.names(id)?)
    }

    /// Begins the step that was asked for: takes the engine's present state as the next step.
    pub fn begin_step(&mut self, snapshot: &Snapshot) {
        self.take(snapshot.ego_s_m);
    }

    fn take(&mut self, ego_s_m: f64) {
        let Some(engine) = &mut self.engine else { return };
        std::mem::swap(&mut self.ways, &mut self.ways_before);
        self.ways.clear();
        let (lanes, map, fixed, step_s) = (&self.lanes, &self.map, self.fixed, self.step_s);
        let s_of = |vehicle: &VehicleState| match fixed {
            Some(_) => map.route.s_on(vehicle.lane?, vehicle.s_m),
            None => vehicle.s_on(map, lanes, ego_s_m),
        };
        // Both lists are sorted by id, so that one pass over them suffices.
        let mut before = self.ways_before.iter().filter_map(|way| way.to.as_ref()).peekable();
        let is_of_participant = |id: VehicleId| self.has_participant && id == EGO;
        for vehicle in engine.vehicles().iter().filter(|vehicle| !is_of_participant(vehicle.id)) {
            while let Some(arrived) = before.next_if(|before| before.vehicle.id < vehicle.id) {
                self.ways.push(StepWay::of(Some(*arrived), None, &map.route, step_s));
            }
            let from = before.next_if(|before| before.vehicle.id == vehicle.id).copied();
            let to = PlacedVehicle { vehicle: *vehicle, s_m: s_of(vehicle) };
            self.ways.push(StepWay::of(from, Some(to), &map.route, step_s));
        }
        self.ways.extend(before.map(|arrived| StepWay::of(Some(*arrived), None, &map.route, step_s)));
        let (letters, starts) = engine.signals();
        self.signals.set(letters, starts);
    }

    /// Moves all other vehicles to their poses at `fraction` of the step, `dt_s` after the present ones; signals change at the step's end.
    pub fn move_vehicles(&mut self, snapshot: &mut Snapshot, fraction: f64, dt_s: f64) {
        let is_end = fraction >= 1.0;
        if is_end {
            snapshot.signals.clone_from(&self.signals);
        }
        std::mem::swap(&mut self.before, &mut snapshot.cars);
        snapshot.cars.clear();
        self.obstacles.clear();
        let mut before = self.before.iter().peekable();
        for way in &self.ways {
            let id = way.id;
            let Some(here) = (if is_end { &way.to } else { &way.from }) else { continue };
            let (from, to) = (way.from.as_ref().unwrap_or(here), way.to.as_ref().unwrap_or(here));
            while before.next_if(|other| other.id < id).is_some() {}
            let before = before.next_if(|other| other.id == id);
            let mut at = way.between(from, to, &self.map.route, fraction);
            if way.to.is_none() {
                // A vehicle that has arrived goes on until the step's end.
                at.pose.position += at.pose.forward() * (from.vehicle.speed_mps * fraction * self.step_s);
            }
            let accel_mps2 = to.vehicle.accel_mps2;
            let pose_before = before.map_or(at.pose, |before| before.pose);
            let car = VehicleSnapshot {
                id,
                pose: at.pose,
                pose_before,
                articulation: at.articulation,
                articulation_before: before.map_or(at.articulation, |before| before.articulation),
                s_m: at.s_m,
                lane: at.lane,
                speed_mps: at.speed_mps,
                accel_mps2,
                odometer_m: before.map_or(0.0, |before| before.odometer_m)
                    + pose_before.position.distance(at.pose.position),
                body: here.vehicle.body,
                height_m: at.height_m,
                lamps: to.vehicle.lamps,
                pitch: before.map(|before| before.pitch).unwrap_or_default().step(accel_mps2, dt_s),
            };
            note_obstacle(&mut self.obstacles, &car, snapshot);
            snapshot.cars.push(car);
        }
    }

    /// Adds a person of an event or a road user, whose id is above all others in the snapshot, at the tick of the last call of [`TrafficCoupling::move_vehicles`].
    pub fn add(&mut self, snapshot: &mut Snapshot, user: VehicleSnapshot) {
        note_obstacle(&mut self.obstacles, &user, snapshot);
        snapshot.cars.push(user);
    }

    /// Returns where a vehicle's front is along the drive's route, metres; `None` off the route.
    pub fn s_of(&self, car: &VehicleSnapshot) -> Option<f64> {
        self.lanes.s_at(&self.map, car.lane?, car.pose.front(car.body.length_m), 0.0)
    }

    /// Returns the other vehicles near the ego at the poses set by [`TrafficCoupling::move_vehicles`].
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Releases the engine; no further step is possible.
    pub fn stop(&mut self) {
        self.engine = None;
    }

    /// Returns the other vehicles' speeds at the last step and at the next, m/s.
    #[cfg(test)]
    pub fn speeds_mps(&self) -> (Vec<f64>, Vec<f64>) {
        let of = |placed: Option<PlacedVehicle>| placed.map(|placed| placed.vehicle.speed_mps);
        let (from, to) =
            (self.ways.iter().filter_map(|way| of(way.from)), self.ways.iter().filter_map(|way| of(way.to)));
        (from.collect(), to.collect())
    }

    /// Returns true after a call of [`TrafficCoupling::stop`].
    pub fn is_stopped(&self) -> bool {
        self.engine.is_none()
    }

    /// Returns the engine's name and version.
    pub fn engine_name(&self) -> String {
        self.engine_name.clone()
    }
}
