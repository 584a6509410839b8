//! Start of a drive's traffic: a fixed number of vehicles, on a closed route or behind those of a file, or vehicles that come and go by a
//! demand. In: a planned drive. Out: an engine after the warm-up, and where and how fast the ego is put in. Metres, m/s.

use super::{
    WorldError,
    ego_insertion::{self, Insertion},
    hand_over::{HandOver, HandOverGate},
};
use crate::{
    map::{PathLanes, RoadMap},
    scenario::{PlannedDrive, Scenario, StartLayout},
    space::CAR_LENGTH_M,
    traffic::{
        self, Demand, DemandSetup, EgoStart, FixedSetup, InitialVehicle, ModelMixture, NativeTraffic, Traffic,
        TrafficError, sumo::SumoTraffic,
    },
};
use std::sync::Arc;

/// Initial position and speed of an agent on its route.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StartPlace {
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Initial speed, m/s.
    pub speed_mps: f64,
}

/// Traffic at the hand-over to the driver.
pub(super) struct StartedTraffic {
    pub engine: Box<dyn Traffic>,
    /// Start of the ego; of no meaning without a participant.
    pub ego: StartPlace,
    pub hand_over: HandOver,
}

/// Starts the traffic of a drive and runs it until the ego is put in.
pub(super) fn start(drive: &PlannedDrive, lanes: &PathLanes) -> Result<StartedTraffic, WorldError> {
    match drive.fixed_vehicles() {
        Some(_) => Ok(fixed(drive)?),
        None => with_demand(drive, lanes),
    }
}

/// Starts a fixed number of vehicles in the scenario's layout, runs the warm-up and waits until traffic meets the scenario's conditions for
/// the hand-over. With traffic of a file, its time begins with the warm-up.
pub(super) fn fixed(drive: &PlannedDrive) -> Result<StartedTraffic, TrafficError> {
    let (scenario, map) = (drive.scenario(), drive.map());
    let Some(vehicles) = drive.fixed_vehicles() else {
        let text = "traffic alone is that of a closed route with a fixed number of cars; this drive is on a network";
        return Err(TrafficError::Setup(text.into()));
    };
    let setup = FixedSetup {
        cars: match drive.logged() {
            Some(logged) => logged.starts.clone(),
            None => start_cars(vehicles, scenario, map)?,
        },
        map: Arc::clone(map),
        drivers: drive.traffic_drivers().clone(),
        mixture: ModelMixture { model: scenario.other_model, share: scenario.other_model_share },
        step_s: scenario.step_s,
        seed: scenario.seed,
        lateral_accel_mps2: scenario.lateral_accel_bound_mps2(&map.route),
    };
    let mut engine: Box<dyn Traffic> = match drive.logged() {
        Some(logged) => Box::new(NativeTraffic::behind(Arc::clone(&logged.log), setup)?),
        None => traffic::start(&scenario.traffic, setup)?,
    };
    for _ in 0..ego_insertion::warm_up_steps(scenario) {
        traffic::go_on()?;
        engine.step(&[])?;
    }
    let mut gate = HandOverGate::new(scenario);
    let hand_over = loop {
        if let Some(hand_over) = gate.look(engine.vehicles()) {
            break hand_over;
        }
        traffic::go_on()?;
        engine.step(&[])?;
    };
    let ego = engine.vehicles()[0];
    let s_m = ego.lane.and_then(|lane| map.route.s_on(lane, ego.s_m)).unwrap_or_default();
    Ok(StartedTraffic { engine, ego: StartPlace { s_m, speed_mps: ego.speed_mps }, hand_over })
}

/// Checks that the traffic of a drive with a demand can start, without SUMO in this process.
pub(super) fn check_demand(drive: &PlannedDrive, lanes: &PathLanes) -> Result<(), WorldError> {
    let ego = if drive.scenario().participant { Some(ego_place(drive, lanes)?) } else { None };
    Ok(SumoTraffic::check_demand(&demand_setup(drive, ego.map(|(_, ego)| ego)))?)
}

/// Returns what SUMO needs for the scenario's demand, with the ego if there is a participant.
fn demand_setup(drive: &PlannedDrive, ego: Option<EgoStart>) -> DemandSetup {
    let (scenario, map) = (drive.scenario(), drive.map());
    let before_s = scenario.warm_up_s + if ego.is_some() { scenario.wave_wait_s } else { 0.0 };
    DemandSetup {
        network: Arc::clone(&map.network),
        net_file: map.net_file.clone(),
        demand: scenario.demand.clone(),
        first_number: u32::from(ego.is_none()),
        egos: ego.into_iter().collect(),
        drivers: drive.traffic_drivers().clone(),
        step_s: scenario.step_s,
        until_s: Demand::horizon_s(scenario.duration_s, before_s),
        seed: scenario.seed,
    }
}

/// Starts SUMO with the scenario's demand, runs the warm-up without the ego, and waits until there is room for it at its start. Without a
/// participant SUMO has no ego, and the path does not matter.
fn with_demand(drive: &PlannedDrive, lanes: &PathLanes) -> Result<StartedTraffic, WorldError> {
    let (scenario, map) = (drive.scenario(), drive.map());
    let ego = if scenario.participant { Some(ego_place(drive, lanes)?) } else { None };
    let setup = demand_setup(drive, ego.as_ref().map(|(_, ego)| ego.clone()));
    let mut engine = SumoTraffic::start_with_demand(&setup)?;
    let (mut start, mut waited_s) = (StartPlace { s_m: 0.0, speed_mps: 0.0 }, 0.0);
    if let Some((s_m, ego)) = ego {
        let is_moving = scenario.warm_up_s > 0.0 && !scenario.standing_start;
        let spot = Insertion { map, lanes, scenario, s_m, is_moving };
        let (fits_mps, so_long_s) = spot.warm_up(&mut engine, ego.lane)?;
        let speed_mps = if scenario.start_speed_mps > 0.0 { scenario.start_speed_mps } else { fits_mps };
        (start, waited_s) = (StartPlace { s_m, speed_mps }, so_long_s);
    } else {
        ego_insertion::warm_up_alone(scenario, &mut engine)?;
    }
    let hand_over = ego_insertion::hand_over(engine.vehicles(), start.speed_mps, waited_s);
    Ok(StartedTraffic { engine: Box::new(engine), ego: start, hand_over })
}

/// Returns the ego's start: its front bumper along the path, metres, and the start as reported to SUMO.
fn ego_place(drive: &PlannedDrive, lanes: &PathLanes) -> Result<(f64, EgoStart), WorldError> {
    let map = drive.map();
    let route = &map.route;
    let s_m = drive.scenario().path_start_m();
    let pose = route.pose_of_front(s_m, CAR_LENGTH_M);
    let lane = lanes.ego_lane(map, &pose, route.height_m(s_m), s_m, None);
    let lane =
        lane.ok_or_else(|| TrafficError::Setup("the ego's path does not begin on a lane of the network".into()))?;
    let streets = route.lanes().iter().filter(|lane| lane.is_street(&map.network));
    let route = streets.map(|lane| lane.edge_id(&map.network).to_owned()).collect();
    Ok((s_m, EgoStart { lane: lane.lane, s_m: lane.s_m, speed_mps: 0.0, route }))
}

/// Returns the initial places of all vehicles of a fixed number.
fn start_cars(vehicles: u32, scenario: &Scenario, map: &RoadMap) -> Result<Vec<InitialVehicle>, TrafficError> {
    let layout = match scenario.start {
        StartLayout::Even => traffic::start::even,
        StartLayout::Bunched => traffic::start::bunched,
    };
    layout(vehicles as usize, map.route.length_m(), scenario.idm.s0, 0.0)
}
