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
    traffic_start::{self, StartPlace, StartedTraffic},
};
use crate::{
    ego::Obstacle,
    map::{
        MapError, PathLanes, RoadMap, Route, is_against,
        network::{LaneId, LanePosition, SignalStates},
    },
    scenario::{AdvisedBody, PlanError, PlannedDrive},
    sim::{Leader, Snapshot, VehicleSnapshot},
    space::{CAR_LENGTH_M, Pose, wrap_angle},
    time::TICK_S,
    traffic::{
        Articulation, Demand, EGO, ExternalVehicleState, LaneMotion, Traffic, TrafficError, TrafficOrder, TrafficStart,
        VehicleId, VehicleKind, VehicleReport, VehicleState,
    },
};
use std::sync::Arc;

/// Distance in a step that counts as a jump, metres: beyond twice what the speeds explain (a lane may be drawn longer than its declared
/// length), or sideways. SUMO moved the vehicle there at once. Interpolated over the step, it would hit vehicles in between at an
/// impossible speed.
const JUMP_M: f64 = 1.0;
/// Lateral share of the distance in a step that a bend, or a lane change in a long step, explains.
const SIDEWAYS: f64 = 0.25;

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
    ways: Vec<Way>,
    /// Ways of the step before; a buffer.
    ways_before: Vec<Way>,
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

/// A vehicle with its position on the ego's route.
#[derive(Clone, Copy, Debug)]
struct PlacedVehicle {
    vehicle: VehicleState,
    s_m: Option<f64>,
}

/// Way of a vehicle from the last step to the next.
#[derive(Clone, Copy, Debug)]
struct Way {
    id: VehicleId,
    /// The vehicle at the last step; `None` if it departs in this one.
    from: Option<PlacedVehicle>,
    /// The vehicle at the next step; `None` if it arrives in this one.
    to: Option<PlacedVehicle>,
    /// True if the engine moves the vehicle at once.
    jumps: bool,
    /// Distance along the ego's route, metres; `None` if it cannot have been driven.
    route_way_m: Option<f64>,
}

/// A vehicle interpolated within a step.
struct Shown {
    pose: Pose,
    articulation: Option<Articulation>,
    height_m: f64,
    s_m: Option<f64>,
    lane: Option<LanePosition>,
    speed_mps: f64,
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

    /// Runs the engine's next step with the full agents' present and predicted states and the light agents' motions.
    pub fn ask<'a>(&mut self, agents: impl Iterator<Item = &'a Agent>) -> Result<(), TrafficError> {
        let mut reports = std::mem::take(&mut self.reports);
        reports.clear();
        self.motions.clear();
        for agent in agents.filter(|agent| !self.arrived.contains(&agent.id())) {
            reports.extend(self.report(agent));
            self.motions.extend(agent.motion());
        }
        self.reports = reports;
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
                self.ways.push(Way::of(Some(*arrived), None, &map.route, step_s));
            }
            let from = before.next_if(|before| before.vehicle.id == vehicle.id).copied();
            let to = PlacedVehicle { vehicle: *vehicle, s_m: s_of(vehicle) };
            self.ways.push(Way::of(from, Some(to), &map.route, step_s));
        }
        self.ways.extend(before.map(|arrived| Way::of(Some(*arrived), None, &map.route, step_s)));
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
            let ego = snapshot.ego.position;
            if at.pose.position.distance(ego.truncate()) < TOUCHABLE_M {
                self.obstacles.extend(car.obstacles().filter(|obstacle| obstacle.is_at_height(ego.z)));
            }
            snapshot.cars.push(car);
        }
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

impl Way {
    /// Returns the way between two steps of `step_s` seconds; at least one of both ends is known.
    fn of(from: Option<PlacedVehicle>, to: Option<PlacedVehicle>, route: &Route, step_s: f64) -> Self {
        let id = from.or(to).map_or(EGO, |placed| placed.vehicle.id);
        let Some((a, b)) = from.zip(to) else { return Self { id, from, to, jumps: false, route_way_m: None } };
        let farthest_m = 2.0 * a.vehicle.speed_mps.max(b.vehicle.speed_mps) * step_s + JUMP_M;
        let jumps = !is_short(&a.vehicle, &b.vehicle) && {
            let [begin, end] =
                [&a.vehicle, &b.vehicle].map(|at| Pose::new(at.pose.front(at.body.length_m), at.pose.yaw_rad));
            is_jump(&begin, &end, farthest_m)
        };
        let ends = a.s_m.zip(b.s_m).filter(|_| !jumps);
        Self { id, from, to, jumps, route_way_m: ends.and_then(|ends| driven_m(route, ends, farthest_m)) }
    }

    /// Returns the vehicle at `fraction` of the step.
    fn between(&self, from: &PlacedVehicle, to: &PlacedVehicle, route: &Route, fraction: f64) -> Shown {
        let (a, b, jumps) = (&from.vehicle, &to.vehicle, self.jumps);
        let mix = |a: f64, b: f64| a + (b - a) * fraction;
        let nearer = if fraction < 0.5 { from } else { to };
        let lane = match (a.lane_position(), b.lane_position()) {
            (Some(from), Some(to)) if from.lane == to.lane && !jumps => Some(LanePosition {
                lane: to.lane,
                s_m: mix(from.s_m, to.s_m),
                offset_m: mix(from.offset_m, to.offset_m),
            }),
            _ => nearer.vehicle.lane_position(),
        };
        let on_route = from.s_m.zip(self.route_way_m);
        Shown {
            pose: if jumps { nearer.vehicle.pose } else { a.pose.lerp(&b.pose, fraction) },
            articulation: match (a.articulation, b.articulation) {
                (Some(from), Some(to)) if !jumps => Some(from.lerp(&to, fraction)),
                _ => nearer.vehicle.articulation,
            },
            height_m: if jumps { nearer.vehicle.height_m } else { mix(a.height_m, b.height_m) },
            s_m: on_route.map(|(from_s_m, way_m)| route.wrap(from_s_m + way_m * fraction)).or(nearer.s_m),
            lane,
            speed_mps: mix(a.speed_mps, b.speed_mps),
        }
    }
}

/// Returns true if the front has moved by less than [`JUMP_M`] less rounding: no jump in any direction, and found without sines.
fn is_short(from: &VehicleState, to: &VehicleState) -> bool {
    let turn_rad = wrap_angle(to.pose.yaw_rad - from.pose.yaw_rad).abs();
    from.pose.position.distance(to.pose.position) + to.body.length_m / 2.0 * turn_rad < 0.99 * JUMP_M
}

/// Returns true if a front bumper cannot have driven from one pose to the other: the distance is too long, or too far sideways of its
/// heading. The chord of an arc points midway between the headings at its ends. (In SUMO the front drives: the rear of a long vehicle
/// swings out when it begins a lane change after a bend.)
fn is_jump(from: &Pose, to: &Pose, farthest_m: f64) -> bool {
    let way = to.position - from.position;
    let sideways_m = way.dot(from.lerp(to, 0.5).left()).abs();
    way.length() > farthest_m || sideways_m > JUMP_M.max(SIDEWAYS * way.length())
}

/// Returns the distance along the route between two steps, metres. `None` if it is too long to have been driven: where a route passes
/// twice, a vehicle has two positions.
fn driven_m(route: &Route, (from_s_m, to_s_m): (f64, f64), farthest_m: f64) -> Option<f64> {
    Some(route.difference(from_s_m, to_s_m)).filter(|way_m| way_m.abs() <= farthest_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_vehicle_moved_sideways_or_far_ahead_has_jumped_and_a_turning_one_not() {
        let at = |x: f64, y: f64, yaw_rad: f64| Pose::new(dvec2(x, y), yaw_rad);
        let here = at(0.0, 0.0, 0.0);
        // 10 m/s for 0.1 s: at most 2 m plus 1 m.
        assert!(!is_jump(&here, &at(1.0, 0.1, 0.0), 3.0));
        // A lane of 3.2 m sideways, stopped or moving.
        assert!(is_jump(&here, &at(0.0, 3.2, 0.0), 1.0) && is_jump(&here, &at(1.0, 2.8, 0.0), 3.0));
        // Across a junction of 12 m without internal lanes.
        assert!(is_jump(&here, &at(12.0, 0.0, 0.0), 3.0));
        // A quarter circle with a radius of 6 m in a step of 1 s: 9.4 m.
        assert!(!is_jump(&here, &at(6.0, 6.0, FRAC_PI_2), 20.0));
    }

    #[test]
    fn positions_too_far_apart_to_be_driven_are_not_interpolated() {
        // Round a block and along its first edge again: B0B1 begins at 0 and after four blocks of 90 m (69.2 m and 20.8 m, or 9.03 m in a
        // turn).
        let edges = ["B0B1", "B1C1", "C1C0", "C0B0", "B0B1"];
        let map = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &edges).expect("a path");
        let again_m =
            map.route.lanes().iter().rfind(|lane| lane.edge_id(&map.network) == "B0B1").expect("twice").start_s_m;
        assert!(again_m > 300.0);
        assert_eq!(driven_m(&map.route, (10.0, 12.0), 7.0), Some(2.0));
        assert_eq!(driven_m(&map.route, (10.0, again_m + 12.0), 7.0), None);
    }
}
