//! The world of one drive. In: [`Controls`] once a tick. Out: [`Event`]s and the [`Snapshot`] of that tick.
//!
//! Traffic runs one step ahead (docs/decisions.md: 3): at the first tick of step k the engine is asked for k+1, told
//! where the ego is and where it will be; until then the other cars move evenly from where they were to where they will
//! be. The ego is simulated tick by tick in between.

mod put_back;

pub use put_back::NotPutBack;

use super::{
    Event, EventKind, OnContact, Scenario, Snapshot, StartLayout, WorldError,
    event::EndReason,
    ground::RoadGround,
    snapshot::{Leader, VehicleSnapshot},
};
use crate::{
    driver::{Perception, SeenLeader, SimulatedDriver},
    ego::{CarParams, Controls, Ego, Obstacle},
    input::LaneHint,
    map::{RoadMap, Route},
    policy::{self, Advice, Advisor, Observation, PolicySettings},
    space::{CAR_LENGTH_M, wrap_angle},
    time::{TICK_S, TICKS_PER_S, Tick},
    traffic::{
        self, CarState, EngineChoice, ExternalVehicleState, InitialVehicle, Traffic, TrafficError, TrafficSetup,
    },
};
use std::{collections::VecDeque, sync::Arc, time::Duration};

/// A contact that begins again sooner than this after the last one with the same car is the same contact, ticks.
const SAME_CONTACT_TICKS: u64 = TICKS_PER_S as u64 / 2;
/// How far inside the lane's edge the ego is back on the road, metres: no flicker of events at the edge.
const BACK_INSIDE_M: f64 = 0.2;
/// How far ahead lane help reads the bend, seconds: about what steering takes to act; and over which length, metres.
const LANE_HINT_AHEAD_S: f64 = 0.2;
const LANE_HINT_SPAN_M: f64 = 4.0;

/// Speeds that this drive is about, m/s: the speedometer's scale follows from them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedSpeeds {
    /// Speed at which an even ring of these cars flows.
    pub equilibrium_mps: f64,
    /// Upper edge of the range around the policy's aim.
    pub advised_mps: f64,
    /// Highest speed limit of the route.
    pub limit_mps: f64,
}

/// One drive, running.
pub struct World {
    scenario: Scenario,
    policy: policy::Resolved,
    map: Arc<RoadMap>,
    ego: Ego,
    traffic: Box<dyn Traffic>,
    advisor: Advisor,
    /// All cars at the last step and at the next, the ego first.
    from: Vec<CarState>,
    to: Vec<CarState>,
    obstacles: Vec<Obstacle>,
    last_contact: Vec<Option<u64>>,
    on_road: bool,
    /// The next tick has the ego on its lane.
    wants_back: bool,
    ended: Option<EndReason>,
    is_stopped: bool,
    expected: ExpectedSpeeds,
    snapshot: Snapshot,
    events: Vec<Event>,
    /// The step that the next tick begins, once the engine was asked for it.
    asked: Option<AskedStep>,
    /// Controls on their way to the car, oldest first; as many as the scenario's extra delay has ticks.
    control_delay: VecDeque<Controls>,
}

/// A step that the traffic engine was asked for.
struct AskedStep {
    /// What the driver is to be advised when it begins.
    advice: Option<Advice>,
    /// True once the engine has answered.
    is_done: bool,
}

impl World {
    /// Loads the map, starts traffic, runs the warm-up and puts the ego on the road.
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn new(scenario: &Scenario) -> Result<Self, WorldError> {
        let map = Arc::new(RoadMap::load(&scenario.map)?);
        let engine: EngineChoice = scenario.traffic.parse()?;
        let settings = policy_settings(scenario, &map.route);
        let resolved = policy::resolve(&scenario.policy, &map);
        let policy = policy::build(&resolved.name, &settings)?;
        let expected = ExpectedSpeeds {
            equilibrium_mps: settings.equilibrium_mps,
            advised_mps: settings.aim_or_automatic_mps() + scenario.range_mps(),
            limit_mps: map.route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(0.0, f64::max),
        };
        let setup = TrafficSetup {
            cars: start_cars(scenario, &map.route)?,
            map: Arc::clone(&map),
            idm: scenario.idm,
            step_s: scenario.step_s,
            seed: scenario.seed,
            timeout_s: scenario.traffic_timeout_s,
            lateral_accel_mps2: scenario.lateral_accel_bound_mps2(&map.route),
        };
        let mut traffic = traffic::start(&engine, setup)?;
        for _ in 0..(scenario.warm_up_s / scenario.step_s).round() as u64 {
            traffic.step(None)?;
        }
        let to = traffic.cars().to_vec();
        let start = map.route.pose_of_front(to[0].s_m, CAR_LENGTH_M);
        let params = car_params(scenario);
        let ego = Ego::new(&params, start, to[0].speed_mps, to.len() - 1)?;
        let advisor = Advisor::new(policy, scenario.step_s, scenario.hold_steps(), scenario.range_mps());
        let snapshot = Snapshot {
            tick: Tick(0),
            ego: *ego.state(),
            ego_before: *ego.state(),
            ego_s_m: to[0].s_m,
            lane_offset_m: 0.0,
            cars: to[1..].iter().map(VehicleSnapshot::at_start).collect(),
            leader: None,
            advice: None,
            mean_speed_mps: 0.0,
        };
        let others = to.len() - 1;
        let mut world = Self {
            scenario: scenario.clone(),
            policy: resolved,
            map,
            ego,
            traffic,
            advisor,
            from: to.clone(),
            to,
            obstacles: Vec::with_capacity(others),
            last_contact: vec![None; others],
            on_road: true,
            wants_back: false,
            ended: None,
            is_stopped: false,
            expected,
            snapshot,
            events: Vec::new(),
            asked: None,
            control_delay: vec![Controls::default(); scenario.extra_delay_ticks()].into(),
        };
        world.update_derived_state();
        Ok(world)
    }

    /// One tick with these controls, which reach the car after the scenario's extra delay. After the end of the drive nothing moves any more.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn tick(&mut self, controls: &Controls) -> Result<(), WorldError> {
        self.events.clear();
        if self.ended.is_some() {
            return Ok(());
        }
        let step_ticks = self.scenario.step_ticks();
        let within = self.snapshot.tick.0 % step_ticks;
        if within == 0 {
            while !self.prepare(Duration::MAX)? {}
            self.step();
        }
        self.move_traffic((within + 1) as f64 / step_ticks as f64);
        self.stand_on_lane()?;
        self.control_delay.push_back(*controls);
        let arrived = self.control_delay.pop_front().unwrap_or(*controls);
        self.move_ego(&arrived);
        self.snapshot.tick.0 += 1;
        self.update_derived_state();
        let duration_s = self.scenario.duration_s;
        if duration_s > 0.0 && self.snapshot.tick >= Tick::at_seconds(duration_s) {
            self.end(EndReason::Duration);
        }
        Ok(())
    }

    /// Readies the next tick: asks for the step that it begins, if it begins one. True once the tick will not wait for the
    /// traffic engine; this waits for that for `patience` at most. Nothing is to be seen of it before the tick.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn prepare(&mut self, patience: Duration) -> Result<bool, WorldError> {
        if self.ended.is_some() || !self.snapshot.tick.0.is_multiple_of(self.scenario.step_ticks()) {
            return Ok(true);
        }
        if self.asked.is_none() {
            self.ask()?;
        }
        let Some(asked) = &mut self.asked else { return Ok(true) };
        asked.is_done = asked.is_done || self.traffic.finish_step(patience)?;
        Ok(asked.is_done)
    }

    /// Advice for the driver, and the question for the traffic one step ahead.
    fn ask(&mut self) -> Result<(), WorldError> {
        let limit_mps = self.map.route.speed_limit_mps(self.snapshot.ego_s_m);
        let advice = self.advisor.step(self.snapshot.tick, &self.observe(), limit_mps);
        let (pose, speed_mps) = self.ego.predict(0.0);
        let (next_pose, next_speed_mps) = self.ego.predict(self.scenario.step_s);
        // Engines know no reverse gear: a car that rolls backwards stands for them.
        let report = ExternalVehicleState {
            pose,
            speed_mps: speed_mps.max(0.0),
            next_pose,
            next_speed_mps: next_speed_mps.max(0.0),
        };
        self.traffic.begin_step(Some(&report))?;
        self.asked = Some(AskedStep { advice, is_done: false });
        Ok(())
    }

    /// One step begins, as it was asked for.
    fn step(&mut self) {
        if let Some(advice) = self.asked.take().and_then(|asked| asked.advice) {
            self.snapshot.advice = Some(advice);
            self.events.push(Event { tick: self.snapshot.tick, kind: EventKind::Advice(advice) });
        }
        std::mem::swap(&mut self.from, &mut self.to);
        self.to.clear();
        self.to.extend_from_slice(self.traffic.cars());
    }

    /// All other cars go to the place that they have `fraction` of the way through the step.
    fn move_traffic(&mut self, fraction: f64) {
        let route = &self.map.route;
        self.obstacles.clear();
        for ((view, from), to) in self.snapshot.cars.iter_mut().zip(&self.from[1..]).zip(&self.to[1..]) {
            let s_m = route.wrap(from.s_m + route.difference(from.s_m, to.s_m) * fraction);
            view.odometer_m += route.difference(view.s_m, s_m);
            view.s_m = s_m;
            view.pose_before = view.pose;
            view.pose = route.pose_of_front(s_m, CAR_LENGTH_M);
            view.speed_mps = from.speed_mps + (to.speed_mps - from.speed_mps) * fraction;
            view.accel_mps2 = to.accel_mps2;
            view.braking = to.braking;
            view.pitch = view.pitch.step(view.accel_mps2, crate::time::TICK_S);
            self.obstacles.push(Obstacle { pose: view.pose, speed_mps: view.speed_mps });
        }
    }

    fn move_ego(&mut self, controls: &Controls) {
        let ground = RoadGround { route: &self.map.route, near_s_m: self.snapshot.ego_s_m };
        self.snapshot.ego_before = *self.ego.state();
        let contacts = self.ego.tick(controls, &ground, &self.obstacles);
        let tick = self.snapshot.tick.0 + 1;
        let mut new = false;
        for contact in contacts {
            let before = self.last_contact[contact.car].replace(tick);
            if before.is_some_and(|t| tick - t <= SAME_CONTACT_TICKS) {
                continue;
            }
            new = true;
            let kind = EventKind::Contact {
                car: self.snapshot.cars[contact.car].id,
                ego_speed_mps: contact.ego_speed_mps,
                car_speed_mps: contact.car_speed_mps,
                closing_mps: contact.closing_mps,
            };
            self.events.push(Event { tick: Tick(tick), kind });
        }
        self.snapshot.ego = *self.ego.state();
        if new && self.scenario.contact == OnContact::End {
            self.end(EndReason::Contact);
        }
    }

    /// Where the ego is on the road, who leads, how fast all are.
    fn update_derived_state(&mut self) {
        let route = &self.map.route;
        let pose = self.ego.predict(0.0).0;
        let place = route.project(pose.front(CAR_LENGTH_M), Some(self.snapshot.ego_s_m));
        let middle = route.project(pose.position, Some(place.s_m));
        let half_m = route.width_m(place.s_m) / 2.0;
        let snapshot = &mut self.snapshot;
        snapshot.ego_s_m = place.s_m;
        snapshot.lane_offset_m = middle.offset_m;
        snapshot.leader = snapshot
            .cars
            .iter()
            .map(|car| (route.ahead(place.s_m, car.s_m), car))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(headway_m, car)| Leader { id: car.id, gap_m: headway_m - CAR_LENGTH_M, speed_mps: car.speed_mps });
        let sum: f64 = snapshot.cars.iter().map(|car| car.speed_mps).sum();
        snapshot.mean_speed_mps = (sum + snapshot.ego.speed_mps) / (snapshot.cars.len() + 1) as f64;

        let off = middle.offset_m.abs();
        let kind = if self.on_road && off > half_m {
            EventKind::LeftRoad { s_m: place.s_m, offset_m: middle.offset_m }
        } else if !self.on_road && off < half_m - BACK_INSIDE_M {
            EventKind::BackOnRoad
        } else {
            return;
        };
        self.on_road = !self.on_road;
        self.events.push(Event { tick: snapshot.tick, kind });
    }

    fn end(&mut self, reason: EndReason) {
        self.ended = Some(reason);
        self.events.push(Event { tick: self.snapshot.tick, kind: EventKind::Ended(reason) });
    }

    fn observe(&self) -> Observation {
        let (gap_m, leader_speed_mps) =
            self.snapshot.leader.map_or((self.map.route.length_m(), 0.0), |l| (l.gap_m, l.speed_mps));
        Observation {
            speed_mps: self.snapshot.ego.speed_mps,
            leader_speed_mps,
            gap_m,
            circumference_m: self.map.route.length_m(),
            vehicles: self.scenario.vehicles,
            ..Observation::default()
        }
    }

    /// What a simulated driver in the ego perceives now.
    pub fn perceived_by(&self, driver: &SimulatedDriver) -> Perception {
        let snapshot = &self.snapshot;
        Perception {
            speed_mps: snapshot.ego.speed_mps,
            lane: driver.look(&self.map.route, &snapshot.ego, Some(snapshot.ego_s_m)),
            leader: snapshot.leader.map(|leader| SeenLeader { gap_m: leader.gap_m, speed_mps: leader.speed_mps }),
            advice: snapshot.advice,
            speed_limit_mps: self.map.route.speed_limit_mps(snapshot.ego_s_m),
        }
    }

    /// The lane as lane help needs it: at the ego's middle, its curvature `LANE_HINT_AHEAD_S` ahead.
    pub fn lane_hint(&self) -> LaneHint {
        let (route, snapshot) = (&self.map.route, &self.snapshot);
        let middle_s_m = snapshot.ego_s_m - CAR_LENGTH_M / 2.0;
        let ahead_m = snapshot.ego.speed_mps.max(0.0) * LANE_HINT_AHEAD_S;
        LaneHint {
            curvature: route.curvature_at(middle_s_m + ahead_m, LANE_HINT_SPAN_M),
            offset_m: snapshot.lane_offset_m,
            heading_error_rad: wrap_angle(snapshot.ego.pose().yaw_rad - route.yaw_at(middle_s_m)),
        }
    }

    /// The drive lasts so many seconds longer than its scenario said; without an end it has none still.
    pub fn extend(&mut self, seconds: f64) {
        if self.scenario.duration_s > 0.0 {
            self.scenario.duration_s += seconds;
        }
    }

    /// Lets go of the traffic engine, so that another drive can have it (SUMO runs once a process). This drive is over.
    pub fn stop_traffic(&mut self) {
        self.traffic = Box::new(Stopped { cars: self.to.clone(), was: self.traffic.describe() });
        self.is_stopped = true;
    }

    /// Another engine from the next step on: to test what waits for one.
    #[cfg(test)]
    pub(crate) fn set_traffic(&mut self, traffic: Box<dyn Traffic>) {
        self.traffic = traffic;
    }

    /// True once [`World::stop_traffic`] was called.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// What happened in the last tick.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Everything at the present tick.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// The policy that drives; the scenario says which was asked for.
    pub fn policy(&self) -> &policy::Resolved {
        &self.policy
    }

    /// The road.
    pub fn map(&self) -> &Arc<RoadMap> {
        &self.map
    }

    /// The scenario that is being driven.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Speeds that this drive is about.
    pub fn expected_speeds(&self) -> ExpectedSpeeds {
        self.expected
    }

    /// The ego's car.
    pub fn ego_params(&self) -> &CarParams {
        self.ego.params()
    }

    /// Name and version of the traffic engine.
    pub fn traffic_engine(&self) -> String {
        self.traffic.describe()
    }

    /// Why the drive is over, once it is.
    pub fn ended(&self) -> Option<EndReason> {
        self.ended
    }

    /// Present seconds since the start of the drive.
    pub fn time_s(&self) -> f64 {
        self.snapshot.tick.0 as f64 * TICK_S
    }
}

/// The speed at which an even ring of this scenario's cars flows, m/s, and what else a policy is built from.
fn policy_settings(scenario: &Scenario, route: &Route) -> PolicySettings {
    let gap_m = route.length_m() / f64::from(scenario.vehicles) - CAR_LENGTH_M;
    PolicySettings {
        aim_mps: scenario.policy_speed_mps,
        equilibrium_mps: limited_idm(scenario, route).equilibrium_speed_mps(gap_m),
        step_s: scenario.step_s,
    }
}

/// The scenario's IDM with the desired speed capped by the road's lowest speed limit, as the engines cap it lane by lane.
fn limited_idm(scenario: &Scenario, route: &Route) -> crate::idm::IdmParams {
    let limit_mps = route.lanes().iter().map(|lane| lane.speed_limit_mps).fold(f64::INFINITY, f64::min);
    crate::idm::IdmParams { v0: scenario.idm.v0.min(limit_mps), ..scenario.idm }
}

/// Where all cars stand at the start.
fn start_cars(scenario: &Scenario, route: &Route) -> Result<Vec<InitialVehicle>, TrafficError> {
    let layout = match scenario.start {
        StartLayout::Even => traffic::start::even,
        StartLayout::Bunched => traffic::start::bunched,
    };
    layout(scenario.vehicles as usize, route.length_m(), scenario.idm.s0, 0.0)
}

/// The ego with the scenario's settings.
fn car_params(scenario: &Scenario) -> CarParams {
    let mut params = CarParams::default();
    params.gearbox.creep = scenario.creep;
    params
}

/// What is left of an engine that was let go.
struct Stopped {
    cars: Vec<CarState>,
    /// Its name and version.
    was: String,
}

impl Traffic for Stopped {
    fn step(&mut self, _ego: Option<&ExternalVehicleState>) -> Result<(), TrafficError> {
        Err(TrafficError::Setup("this drive was stopped".into()))
    }

    fn cars(&self) -> &[CarState] {
        &self.cars
    }

    fn describe(&self) -> String {
        self.was.clone()
    }
}

#[cfg(test)]
#[path = "world_tests.rs"]
mod tests;
