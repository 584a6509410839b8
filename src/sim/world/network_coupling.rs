//! The other vehicles on a network between two steps of SUMO. In: once a step, where the ego is and where it will be; once a tick, how
//! much of the step has passed. Out: all vehicles at that tick, matched by their ids, and what signals show. Metres, m/s.
//!
//! A vehicle that departs in a step appears at its end, one that arrives is gone there; until then it drives on. What is at a step's
//! end is what SUMO has.

use super::{
    TOUCHABLE_M, WorldError,
    agent::{Agent, NewAgent},
    ego_insertion::{self, Insertion},
    hand_over::HandOver,
    path_lanes::{PathLanes, is_against},
    traffic_coupling::StartPlace,
};
use crate::{
    ego::Obstacle,
    map::{
        MapError, RoadMap, Route,
        network::{LanePosition, SignalStates},
    },
    rng,
    scenario::Scenario,
    sim::{Snapshot, snapshot::VehicleSnapshot},
    space::{CAR_LENGTH_M, Pose},
    time::TICK_S,
    traffic::{
        Demand, EGO, EngineChoice, ExternalVehicleState, NetworkVehicle, TrafficError, VehicleId, VehicleKind,
        sumo::{EgoReport, EgoStart, NetworkSetup, SumoNetwork},
    },
};
use std::{path::PathBuf, sync::Arc};

/// A way within a step that no vehicle drives, metres beyond twice what its speeds explain (a lane may be drawn longer than it is
/// declared), or to the side of where it heads: it was set there. Spread over the step's ticks it would hit whoever is in the way, faster
/// than anything drives.
const JUMP_M: f64 = 1.0;
/// What a bend, or a change of lanes in a long step, explains of a way to the side, as a share of the way.
const SIDEWAYS: f64 = 0.25;

/// SUMO on a network, and the two steps that the present tick lies between.
pub(super) struct NetworkCoupling {
    /// `None` once it was let go.
    engine: Option<SumoNetwork>,
    description: String,
    map: Arc<RoadMap>,
    lanes: PathLanes,
    step_s: f64,
    start: StartPlace,
    /// All others at the last step and at the next, by ascending id.
    from: Vec<PlacedVehicle>,
    to: Vec<PlacedVehicle>,
    /// What signals show at the next step.
    signals: SignalStates,
    /// The others as they were seen in the last tick.
    before: Vec<VehicleSnapshot>,
    obstacles: Vec<Obstacle>,
    /// Egos whose way is over for SUMO: they are reported no more.
    arrived: Vec<VehicleId>,
    reports: Vec<EgoReport>,
    /// The share of vehicles that is advised of those that come.
    advised_share: f64,
    /// Those that have come, of which some are to be advised; at the start all that are there.
    new: Vec<VehicleId>,
    /// How traffic was when the driver took over.
    pub hand_over: HandOver,
}

/// Start of the ego: front bumper along its path, metres, and as SUMO is told.
fn ego_place(scenario: &Scenario, map: &RoadMap, lanes: &PathLanes) -> Result<(f64, EgoStart), WorldError> {
    let route = &map.route;
    let s_m = scenario.path_start_m.max(CAR_LENGTH_M);
    if s_m >= route.length_m() {
        let (file, start_m) = (map.net_file.clone(), scenario.path_start_m);
        return Err(MapError::PathStart { file, start_m, length_m: route.length_m() }.into());
    }
    let pose = route.pose_of_front(s_m, CAR_LENGTH_M);
    let lane = lanes.ego_lane(map, &pose, route.height_m(s_m), s_m, None);
    let lane = lane.ok_or_else(|| TrafficError::Setup("the ego's path begins on no lane of the network".into()))?;
    let streets = route.lanes().iter().filter(|lane| !lane.edge.starts_with(':'));
    let route = streets.map(|lane| lane.edge.clone()).collect();
    Ok((s_m, EgoStart { lane: lane.lane, s_m: lane.s_m, speed_mps: 0.0, route }))
}

/// Where an agent is and will be, as SUMO is told.
fn report(agent: &Agent, step_s: f64) -> EgoReport {
    let (snapshot, state) = (agent.snapshot(), agent.report(step_s));
    let told = agent.network.as_ref().map(|network| network.told(snapshot, &agent.map, &state.next_pose));
    let (lane, next_pose) = told.unwrap_or((None, state.next_pose));
    EgoReport {
        id: agent.id(),
        state: ExternalVehicleState { next_pose, ..state },
        lane: lane.map(|at| at.lane),
        is_wrong_way: lane.is_some_and(|at| is_against(&agent.map.network, at, &state.next_pose)),
        lamps: snapshot.ego_lamps(),
    }
}

/// A vehicle, and where it is on the ego's route.
#[derive(Clone, Copy, Debug)]
struct PlacedVehicle {
    vehicle: NetworkVehicle,
    s_m: Option<f64>,
}

/// A vehicle within a step.
struct Shown {
    pose: Pose,
    height_m: f64,
    s_m: Option<f64>,
    lane: Option<LanePosition>,
    speed_mps: f64,
}

impl NetworkCoupling {
    /// Starts SUMO, lets it run for the scenario's warm-up without the ego, and until there is room for it where it starts. Without a
    /// participant there is no ego in SUMO, and the path is of no matter.
    pub fn start(scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Self, WorldError> {
        if scenario.traffic != EngineChoice::Sumo {
            return Err(TrafficError::NotOnNetworks(scenario.traffic.to_string()).into());
        }
        let lanes = PathLanes::new(map);
        let ego = if scenario.participant { Some(ego_place(scenario, map, &lanes)?) } else { None };
        let before_s = scenario.warm_up_s + if ego.is_some() { scenario.wave_wait_s } else { 0.0 };
        let setup = NetworkSetup {
            network: Arc::clone(&map.network),
            net_file: map.net_file.clone(),
            demand: scenario.demand.clone(),
            egos: ego.iter().map(|(_, ego)| ego.clone()).collect(),
            first_number: u32::from(ego.is_none()),
            idm: scenario.idm,
            step_s: scenario.step_s,
            until_s: Demand::horizon_s(scenario.duration_s, before_s),
            seed: scenario.seed,
        };
        let mut engine = SumoNetwork::start(&setup)?;
        let (mut start, mut waited_s) = (StartPlace { s_m: 0.0, speed_mps: 0.0 }, 0.0);
        if let Some((s_m, ego)) = ego {
            let is_moving = scenario.warm_up_s > 0.0 && !scenario.standing_start;
            let spot = Insertion { map, lanes: &lanes, scenario, s_m, is_moving };
            let (speed_mps, so_long_s) = spot.warm_up(&mut engine, ego.lane)?;
            (start, waited_s) = (StartPlace { s_m, speed_mps }, so_long_s);
        } else {
            ego_insertion::warm_up_alone(scenario, &mut engine)?;
        }
        let hand_over = ego_insertion::hand_over(engine.vehicles(), start.speed_mps, waited_s);
        let mut coupling = Self {
            description: engine.describe().to_owned(),
            engine: Some(engine),
            map: Arc::clone(map),
            lanes,
            step_s: scenario.step_s,
            start,
            from: Vec::new(),
            to: Vec::new(),
            signals: SignalStates::default(),
            before: Vec::new(),
            obstacles: Vec::new(),
            arrived: Vec::new(),
            reports: Vec::new(),
            advised_share: scenario.advised.of_those_that_come(),
            new: Vec::new(),
            hand_over,
        };
        coupling.take(start.s_m);
        if coupling.advised_share > 0.0 {
            coupling.new.extend(coupling.to.iter().map(|placed| placed.vehicle.id));
        }
        Ok(coupling)
    }

    /// The files of demand that SUMO reads.
    pub fn demand_files(&self) -> &[PathBuf] {
        self.engine.as_ref().map_or(&[], SumoNetwork::demand_files)
    }

    /// Where the ego is put.
    pub fn ego_start(&self) -> StartPlace {
        self.start
    }

    /// Puts all vehicles, and what signals show, into a snapshot of the first tick.
    pub fn first_view(&mut self, snapshot: &mut Snapshot) {
        self.move_vehicles(snapshot, 1.0);
    }

    /// SUMO's next step, with where the agents are and where they will be at its end.
    pub fn ask(&mut self, agents: &[Agent]) -> Result<(), TrafficError> {
        let Some(engine) = &mut self.engine else {
            return Err(TrafficError::Setup("this drive was stopped".into()));
        };
        let (step_s, arrived) = (self.step_s, &self.arrived);
        // SUMO knows of no participant who is not there.
        let is_there = |agent: &&Agent| !agent.snapshot().is_without_ego && !arrived.contains(&agent.id());
        let here = agents.iter().filter(is_there);
        self.reports.clear();
        self.reports.extend(here.map(|agent| report(agent, step_s)));
        engine.step(&self.reports)?;
        let gone = engine.changes().arrived.iter().filter(|id| self.reports.iter().any(|report| report.id == **id));
        self.arrived.extend(gone);
        if self.advised_share > 0.0 {
            self.new.extend(engine.changes().departed.iter().map(|departure| departure.id));
        }
        Ok(())
    }

    /// True if a vehicle's way is over for SUMO.
    pub fn has_arrived(&self, id: VehicleId) -> bool {
        self.arrived.contains(&id)
    }

    /// Of the vehicles that have come those that become agents: of the cars, each by chance from a stream of its own. One whose path cannot
    /// be driven from where it is, as inside a junction, stays SUMO's.
    pub fn new_agents(&mut self, scenario: &Scenario) -> Result<Vec<NewAgent>, TrafficError> {
        let mut agents = Vec::new();
        for id in std::mem::take(&mut self.new) {
            if rng::stream(scenario.seed, &format!("vehicle/{}/advised", id.0)).uniform(0.0, 1.0) < self.advised_share {
                agents.extend(self.take_over(id)?);
            }
        }
        Ok(agents)
    }

    /// A vehicle as an agent, if it is a car like the ego and its path can be driven.
    fn take_over(&mut self, id: VehicleId) -> Result<Option<NewAgent>, TrafficError> {
        let (Some(engine), Some(at)) = (&mut self.engine, self.to.iter().find(|placed| placed.vehicle.id == id)) else {
            return Ok(None);
        };
        let vehicle = &at.vehicle;
        let is_like_ego = vehicle.body.kind == VehicleKind::Car && (vehicle.body.length_m - CAR_LENGTH_M).abs() < 0.01;
        let Some(lane) = vehicle.lane.filter(|_| is_like_ego) else { return Ok(None) };
        let here = self.map.network.edge_of(lane).id.clone();
        let edges = engine.take_over(id)?;
        let ahead: Vec<&str> = edges.iter().map(String::as_str).skip_while(|edge| *edge != here).collect();
        let Ok(map) = self.map.along(&ahead, lane) else { return Ok(None) };
        let front = vehicle.pose.front(CAR_LENGTH_M);
        let start = StartPlace { s_m: map.route.project(front, Some(vehicle.s_m)).s_m, speed_mps: vehicle.speed_mps };
        Ok(Some(NewAgent { id, map: Arc::new(map), start }))
    }

    /// The step that was asked for begins.
    pub fn begin_step(&mut self, snapshot: &Snapshot) {
        std::mem::swap(&mut self.from, &mut self.to);
        self.take(snapshot.ego_s_m);
    }

    /// What SUMO has now is the next step.
    fn take(&mut self, ego_s_m: f64) {
        let Some(engine) = &self.engine else { return };
        self.to.clear();
        let others = engine.vehicles().iter().filter(|vehicle| vehicle.id != EGO);
        let (lanes, map) = (&self.lanes, &self.map);
        let placed = others.map(|vehicle| PlacedVehicle { vehicle: *vehicle, s_m: lanes.s_of(map, vehicle, ego_s_m) });
        self.to.extend(placed);
        let (letters, starts) = engine.signals();
        self.signals.set(letters, starts);
    }

    /// All other vehicles go to the place that they have `fraction` of the way through the step; signals change at its end.
    pub fn move_vehicles(&mut self, snapshot: &mut Snapshot, fraction: f64) {
        let is_end = fraction >= 1.0;
        if is_end {
            snapshot.signals.clone_from(&self.signals);
        }
        std::mem::swap(&mut self.before, &mut snapshot.cars);
        snapshot.cars.clear();
        self.obstacles.clear();
        let (shown, others) = if is_end { (&self.to, &self.from) } else { (&self.from, &self.to) };
        // All lists are by ascending id: one walk along them.
        let (mut others, mut before) = (others.iter().peekable(), self.before.iter().peekable());
        for here in shown {
            let id = here.vehicle.id;
            while others.next_if(|other| other.vehicle.id < id).is_some() {}
            while before.next_if(|other| other.id < id).is_some() {}
            let other = others.next_if(|other| other.vehicle.id == id);
            let before = before.next_if(|other| other.id == id);
            let (from, to) = if is_end { (other.unwrap_or(here), here) } else { (here, other.unwrap_or(here)) };
            let mut at = self.between(from, to, fraction);
            if other.is_none() && !is_end {
                // It has arrived and drives on until the step's end.
                at.pose.position += at.pose.forward() * (from.vehicle.speed_mps * fraction * self.step_s);
            }
            let accel_mps2 = to.vehicle.accel_mps2;
            let pose_before = before.map_or(at.pose, |before| before.pose);
            snapshot.cars.push(VehicleSnapshot {
                id,
                pose: at.pose,
                pose_before,
                s_m: at.s_m,
                lane: at.lane,
                speed_mps: at.speed_mps,
                accel_mps2,
                odometer_m: before.map_or(0.0, |before| before.odometer_m)
                    + pose_before.position.distance(at.pose.position),
                body: here.vehicle.body,
                height_m: at.height_m,
                lamps: to.vehicle.lamps,
                pitch: before.map(|before| before.pitch).unwrap_or_default().step(accel_mps2, TICK_S),
            });
            let body = here.vehicle.body;
            let obstacle = Obstacle {
                id: id.0,
                pose: at.pose,
                speed_mps: at.speed_mps,
                length_m: body.length_m,
                width_m: body.width_m,
                height_m: at.height_m,
            };
            let ego = snapshot.ego.position;
            if at.pose.position.distance(ego.truncate()) < TOUCHABLE_M && obstacle.is_at_height(ego.z) {
                self.obstacles.push(obstacle);
            }
        }
    }

    fn between(&self, from: &PlacedVehicle, to: &PlacedVehicle, fraction: f64) -> Shown {
        let (a, b) = (&from.vehicle, &to.vehicle);
        let farthest_m = 2.0 * a.speed_mps.max(b.speed_mps) * self.step_s + JUMP_M;
        let fronts = [a, b].map(|at| Pose::new(at.pose.front(at.body.length_m), at.pose.yaw_rad));
        let jumps = is_jump(&fronts[0], &fronts[1], farthest_m);
        let mix = |a: f64, b: f64| a + (b - a) * fraction;
        let nearer = if fraction < 0.5 { from } else { to };
        let place = |vehicle: &NetworkVehicle| {
            vehicle.lane.map(|lane| LanePosition { lane, s_m: vehicle.s_m, offset_m: vehicle.offset_m })
        };
        let lane = match (place(a), place(b)) {
            (Some(from), Some(to)) if from.lane == to.lane && !jumps => Some(LanePosition {
                lane: to.lane,
                s_m: mix(from.s_m, to.s_m),
                offset_m: mix(from.offset_m, to.offset_m),
            }),
            _ => place(&nearer.vehicle),
        };
        let on_route = from.s_m.zip(to.s_m).filter(|_| !jumps);
        let s_m = on_route.and_then(|ends| s_between(&self.map.route, ends, farthest_m, fraction)).or(nearer.s_m);
        Shown {
            pose: if jumps { nearer.vehicle.pose } else { a.pose.lerp(&b.pose, fraction) },
            height_m: if jumps { nearer.vehicle.height_m } else { mix(a.height_m, b.height_m) },
            s_m,
            lane,
            speed_mps: mix(a.speed_mps, b.speed_mps),
        }
    }

    /// The other vehicles near the ego where [`NetworkCoupling::move_vehicles`] has put them.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Lets go of SUMO; no step follows.
    pub fn stop(&mut self) {
        self.engine = None;
    }

    /// True once [`NetworkCoupling::stop`] was called.
    pub fn is_stopped(&self) -> bool {
        self.engine.is_none()
    }

    /// SUMO's name and version.
    pub fn describe(&self) -> String {
        self.description.clone()
    }
}

/// True if a front bumper has not driven from one place to the other: it is farther than it can have come, or beside where it was heading.
/// The chord of an arc points midway between the headings at its ends. (Of SUMO's vehicles, the front is what drives: the rear of a long
/// one swings aside where it begins to change lanes behind a bend.)
fn is_jump(from: &Pose, to: &Pose, farthest_m: f64) -> bool {
    let way = to.position - from.position;
    let sideways_m = way.dot(from.lerp(to, 0.5).left()).abs();
    way.length() > farthest_m || sideways_m > JUMP_M.max(SIDEWAYS * way.length())
}

/// Where a vehicle is along the route between two steps, metres. `None` where that is farther than it can have driven: a route that comes by
/// twice has two places for it.
fn s_between(route: &Route, (from_s_m, to_s_m): (f64, f64), farthest_m: f64, fraction: f64) -> Option<f64> {
    let way_m = route.difference(from_s_m, to_s_m);
    (way_m.abs() <= farthest_m).then(|| route.wrap(from_s_m + way_m * fraction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_vehicle_that_is_set_beside_itself_or_ahead_has_jumped_and_one_that_turns_has_not() {
        let at = |x: f64, y: f64, yaw_rad: f64| Pose::new(dvec2(x, y), yaw_rad);
        let here = at(0.0, 0.0, 0.0);
        // 10 m/s for 0.1 s: at most 2 m and 1 m.
        assert!(!is_jump(&here, &at(1.0, 0.1, 0.0), 3.0));
        // A lane of 3.2 m aside, standing or driving.
        assert!(is_jump(&here, &at(0.0, 3.2, 0.0), 1.0) && is_jump(&here, &at(1.0, 2.8, 0.0), 3.0));
        // Across a junction of 12 m that has no insides.
        assert!(is_jump(&here, &at(12.0, 0.0, 0.0), 3.0));
        // A quarter of a circle of 6 m in a step of 1 s: 9.4 m.
        assert!(!is_jump(&here, &at(6.0, 6.0, FRAC_PI_2), 20.0));
    }

    #[test]
    fn between_two_places_that_are_farther_apart_than_it_drives_a_vehicle_is_at_neither_of_them_by_halves() {
        // Round a block and over its first edge again: B0B1 begins at 0 and at four blocks of 90 m (69.2 m and 20.8 m, or 9.03 m of a turn).
        let edges = ["B0B1", "B1C1", "C1C0", "C0B0", "B0B1"];
        let map = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &edges).expect("a path");
        let again_m = map.route.lanes().iter().rfind(|lane| lane.edge == "B0B1").expect("twice").start_s_m;
        assert!(again_m > 300.0);
        assert_eq!(s_between(&map.route, (10.0, 12.0), 7.0, 0.5), Some(11.0));
        assert_eq!(s_between(&map.route, (10.0, again_m + 12.0), 7.0, 0.5), None);
    }
}
