//! An agent: a vehicle with its own physics, driver, advice and view of the world, the participant's or another advised one. In:
//! observations for the policy once a step, controls and obstacles once a tick. Out: its [`Snapshot`], its events, and its image in the
//! views of others. Metres, m/s.
//!
//! The body of an agent is full or light (`light_agent`). What follows is of full ones.
//! All agents move simultaneously from one state: in each tick, an agent meets the others at their predicted poses of the end of the tick.
//! Two agents in contact are immovable to each other, as vehicles of the traffic are.

use super::{
    WorldError,
    advice::VehicleAdvice,
    contacts::ContactTracker,
    derived_state::{self, LaneMonitor},
    hand_over::STANDS_MPS,
    light_body::LightBody,
    network_view::NetworkView,
    objects_beside::ObjectsBeside,
    road_rules::RoadRules,
    traffic_start::StartPlace,
};
use crate::{
    controls::{Controls, Indicator},
    driver::{DriverError, DriverParams, Perception, SimulatedDriver},
    ego::{CarParams, Disturbance, EgoCar, GroundModel, GroundSurface, Obstacle, ObstacleId, water_mm},
    map::RoadMap,
    policy::Advice,
    rng,
    scenario::{AdvisedBody, PlannedDrive, Scenario},
    sim::{
        Event, EventKind, Snapshot, VehicleSnapshot,
        automation::{AutomationOrder, AutomationRun},
    },
    space::CAR_LENGTH_M,
    time::{TICK_S, Tick},
    traffic::{EGO, ExternalVehicleState, VehicleBody, VehicleId, is_on_lane},
};
use std::{collections::VecDeque, sync::Arc};

/// Distance inside the road's edge at which the ego counts as back on the road, metres: no repeated events at the edge.
const BACK_INSIDE_M: f64 = 0.2;
/// Upper limit of drivers' seeds, as of scenarios' seeds.
const MOST_SEED: usize = 1 << 53;

/// A vehicle with its own physics.
pub struct Agent {
    pub(super) id: VehicleId,
    /// Road with this vehicle's path as its route.
    pub(super) map: Arc<RoadMap>,
    pub(super) body: AgentBody,
    pub(super) advice: VehicleAdvice,
    pub(super) contacts: ContactTracker,
    /// Fixed objects beside the road, for a full body.
    objects: ObjectsBeside,
    pub(super) contact_count: u32,
    pub(super) lane: LaneMonitor,
    rules: RoadRules,
    /// View of the road: the route and the network around it.
    pub(super) network: NetworkView,
    /// Delayed controls, oldest first; the length is the scenario's extra delay in ticks.
    pub(super) control_delay: VecDeque<Controls>,
    /// `None` for the participant's vehicle, which is controlled from outside.
    pub(super) driver: Option<SimulatedDriver>,
    pub(super) controls: Controls,
    /// Automation of the participant's vehicle, if it has one.
    pub(super) automation: Option<AutomationRun>,
    /// True while an event of the scenario hides the advice.
    pub(super) hides_advice: bool,
    /// True if the next tick puts the vehicle back on its lane.
    pub(super) wants_back: bool,
    /// World seen from this vehicle, which is its ego.
    pub(super) view: Snapshot,
    /// Image of this vehicle in the views of others.
    pub(super) image: VehicleSnapshot,
    /// Events of this vehicle in the last tick.
    pub(super) events: Vec<Event>,
}

/// Body of an agent.
pub(super) enum AgentBody {
    /// Car with all its physics: it moves tick by tick, and the traffic engine gets its reports.
    Full(Box<EgoCar>),
    /// Car along its lane: it moves step by step, and the traffic engine steers it.
    Light(Box<LightBody>),
}

impl AgentBody {
    /// Returns a full body at its start. Its physics has room for `bodies` other vehicles.
    pub fn full(scenario: &Scenario, map: &RoadMap, start: StartPlace, bodies: usize) -> Result<Self, WorldError> {
        let pose = map.route.pose_of_front(start.s_m, CAR_LENGTH_M);
        let mut car = EgoCar::new(&car_params(scenario), pose, start.speed_mps, bodies)?;
        car.stand_on(NetworkView::ground_at(map, start.s_m).shape(pose.position));
        Ok(Self::Full(Box::new(car)))
    }
}

impl Agent {
    /// Returns a vehicle at its start on the road; its view has no other vehicles yet. The physics of a full body has room for `bodies`
    /// others.
    pub(super) fn new(
        (drive, map): (&PlannedDrive, &Arc<RoadMap>),
        advice: VehicleAdvice,
        start: StartPlace,
        kind: AdvisedBody,
        bodies: usize,
    ) -> Result<Self, WorldError> {
        let scenario = drive.scenario();
        let network = NetworkView::new(map);
        let body = match kind {
            AdvisedBody::Full => AgentBody::full(scenario, map, start, bodies)?,
            AdvisedBody::Light => AgentBody::Light(Box::new(LightBody::new(&car_params(scenario), start)?)),
        };
        let pose = map.route.pose_of_front(start.s_m, CAR_LENGTH_M);
        let state = match &body {
            AgentBody::Full(car) => *car.state(),
            AgentBody::Light(light) => light.state(pose, map.route.height_m(start.s_m)),
        };
        let view = derived_state::first_snapshot(&state, start.s_m);
        let image = VehicleSnapshot { id: EGO, pose, pose_before: pose, ..VehicleSnapshot::default() };
        Ok(Self {
            id: EGO,
            map: Arc::clone(map),
            body,
            advice,
            contacts: ContactTracker::default(),
            objects: ObjectsBeside::new(drive.roadside()),
            contact_count: 0,
            lane: LaneMonitor::new(),
            rules: RoadRules::default(),
            network,
            control_delay: vec![Controls::default(); scenario.extra_delay_ticks()].into(),
            driver: None,
            controls: Controls::default(),
            automation: None,
            hides_advice: false,
            wants_back: false,
            view,
            image,
            events: Vec::new(),
        })
    }

    /// Gives the vehicle the automation of its scenario.
    pub(super) fn automated(self, scenario: &Scenario) -> Result<Self, DriverError> {
        let automation = AutomationRun::new(&scenario.automation, &car_params(scenario))?;
        let mut view = self.view;
        view.automation = automation.as_ref().map(|automation| automation.state(view.tick)).unwrap_or_default();
        Ok(Self { automation, view, ..self })
    }

    /// Gives the vehicle to a simulated driver, whose randomness has a random stream of this vehicle.
    pub(super) fn driven_by(
        self,
        driver: &DriverParams,
        id: VehicleId,
        drive: &PlannedDrive,
    ) -> Result<Self, WorldError> {
        let seed = rng::stream(drive.scenario().seed, &format!("vehicle/{}/driver", id.0)).index(MOST_SEED) as u64;
        let car = car_params(drive.scenario());
        let driver = SimulatedDriver::new(driver, &car, seed)?.among(drive.traffic_drivers());
        // A driver who is stopped in a jam starts with a foot on the brake.
        let driver = if self.view.ego.speed_mps < STANDS_MPS { driver.with_foot_on_brake() } else { driver };
        Ok(Self { id, driver: Some(driver), ..self })
    }

    pub fn id(&self) -> VehicleId {
        self.id
    }

    /// Returns the world at the present tick seen from this vehicle, which is the ego there.
    pub fn snapshot(&self) -> &Snapshot {
        &self.view
    }

    /// Returns the driver's controls of the last tick, before the extra delay.
    pub fn controls(&self) -> &Controls {
        &self.controls
    }

    /// Returns the number of contacts that have begun.
    pub fn contact_count(&self) -> u32 {
        self.contact_count
    }

    /// Returns the events of this vehicle in the last tick.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Returns the car of a full body.
    fn car(&self) -> Option<&EgoCar> {
        match &self.body {
            AgentBody::Full(car) => Some(car),
            AgentBody::Light(_) => None,
        }
    }

    /// Returns true if the body is full.
    pub(super) fn is_full(&self) -> bool {
        self.car().is_some()
    }

    /// Returns the present state of a full body and the state predicted for `step_s` later, for the traffic engine. Engines have no reverse
    /// gear: a vehicle that rolls backwards has speed 0 there.
    pub(super) fn report(&self, step_s: f64) -> Option<ExternalVehicleState> {
        let car = self.car()?;
        let (pose, speed_mps) = car.predict(0.0);
        let (next_pose, next_speed_mps) = car.predict(step_s);
        let (speed_mps, next_speed_mps) = (speed_mps.max(0.0), next_speed_mps.max(0.0));
        Some(ExternalVehicleState { pose, speed_mps, next_pose, next_speed_mps })
    }

    /// Asks the policy for the step that begins at this tick.
    pub(super) fn ask_policy(&mut self, drive: &PlannedDrive) {
        let limit_mps = self.network.limit_mps(&self.view, &self.map);
        // Advice from outside needs the history of an observation only.
        let observation = if self.advice.is_from_outside() { self.observe_traffic(drive) } else { self.observe(drive) };
        self.advice.ask(self.view.tick, &observation, limit_mps);
    }

    /// Begins a step: shows or withdraws advice as the policy decided.
    pub(super) fn begin_step(&mut self) {
        let tick = self.view.tick;
        let issued = self.advice.issue();
        let is_hidden = self.hides_advice || self.automation.as_ref().is_some_and(AutomationRun::hides_advice);
        let standing = self.advice.standing().filter(|_| !is_hidden);
        // Advice that was hidden appears anew.
        let again = standing.filter(|_| self.view.advice.is_none()).map(|advice| Advice { issued: tick, ..advice });
        if let Some(advice) = issued.filter(|_| !is_hidden).or(again) {
            self.view.advice = Some(advice);
            self.events.push(Event { tick, kind: EventKind::Advice(advice) });
        } else if self.view.advice.is_some() && standing.is_none() {
            self.view.advice = None;
            self.events.push(Event { tick, kind: EventKind::AdviceWithheld });
        }
    }

    /// Disturbs a full body from the next tick on.
    pub(super) fn disturb(&mut self, disturbance: Disturbance) {
        if let AgentBody::Full(car) = &mut self.body {
            car.disturb(disturbance);
        }
    }

    /// Begins a tick: clears the events and takes the driver's controls from what the driver perceives. `outside` are the participant's
    /// controls. The driver of a light body has driven the whole step.
    pub(super) fn begin_tick(&mut self, outside: &Controls) {
        self.events.clear();
        if !self.is_full() {
            return;
        }
        let Some(mut driver) = self.driver.take() else {
            self.controls = *outside;
            return;
        };
        self.controls = driver.controls(&self.perceived_by(&driver));
        self.driver = Some(driver);
    }

    /// Moves a full body by one tick among these obstacles and the fixed objects beside the road. Returns true if it has begun to touch one.
    pub(super) fn drive(&mut self, obstacles: &[Obstacle]) -> bool {
        self.control_delay.push_back(self.controls);
        let given = self.control_delay.pop_front().unwrap_or(self.controls);
        let controls = self.automate(&given);
        self.indicate(controls.indicator);
        self.switch_main_beam(controls.main_beam);
        let AgentBody::Full(car) = &mut self.body else { return false };
        let ground = self.network.ground(&self.map, &self.view);
        self.view.ego_before = *car.state();
        let obstacles = self.objects.add_to(obstacles, car.state(), &ground);
        let touches = car.tick(&controls, &ground, obstacles);
        let known = self.events.len();
        let kind = |number| self.objects.kind(number);
        let view = &self.view;
        let vehicle_kind = |id: VehicleId| view.vehicle(id).map(|car| car.body.kind).unwrap_or_default();
        self.events.extend(self.contacts.begun(touches, Tick(view.tick.0 + 1), &kind, &vehicle_kind));
        self.view.ego = *car.state();
        let begun = self.events.len() - known;
        self.contact_count += begun as u32;
        begun > 0
    }

    /// Gives the automation an order, which it carries out in the next tick.
    pub(super) fn order_automation(&mut self, order: AutomationOrder) {
        if let Some(automation) = &mut self.automation {
            automation.order(order);
        }
    }

    /// Returns the controls that move the vehicle: the given ones, or those of the automation while it drives.
    fn automate(&mut self, given: &Controls) -> Controls {
        let Some(mut automation) = self.automation.take() else { return *given };
        // The policy's advice may be hidden from the participant.
        let now = Perception { advice: self.advice.standing(), ..self.perceived_by(automation.eyes()) };
        let tick = Tick(self.view.tick.0 + 1);
        let controls = automation.tick(tick, given, &now, &mut self.events);
        self.view.automation = automation.state(tick);
        self.automation = Some(automation);
        controls
    }

    fn switch_main_beam(&mut self, is_on: bool) {
        if std::mem::replace(&mut self.view.ego_main_beam, is_on) != is_on {
            self.events.push(Event { tick: Tick(self.view.tick.0 + 1), kind: EventKind::MainBeam(is_on) });
        }
    }

    fn indicate(&mut self, side: Indicator) {
        if std::mem::replace(&mut self.view.ego_indicator, side) != side {
            self.events.push(Event { tick: Tick(self.view.tick.0 + 1), kind: EventKind::Indicator(side) });
        }
    }

    /// Updates the position on the route and the image for others, after a full body was moved.
    pub(super) fn locate(&mut self) {
        let Some((pose, _)) = self.car().map(|car| car.predict(0.0)) else { return };
        derived_state::locate(&mut self.view, &self.map.route, &pose);
        let tick = self.view.tick;
        self.events.extend(self.network.locate(&mut self.view, &self.map, &pose).map(|kind| Event { tick, kind }));
        let (ego, before, place) = (&self.view.ego, &self.image, derived_state::own_place(&self.view));
        self.image = VehicleSnapshot {
            id: self.id,
            pose,
            pose_before: before.pose,
            articulation: None,
            articulation_before: None,
            s_m: is_on_lane(&self.map.route, place).then_some(place.s_m),
            lane: self.view.ego_lane,
            speed_mps: ego.speed_mps,
            accel_mps2: ego.accel_mps2,
            odometer_m: before.odometer_m + ego.speed_mps * TICK_S,
            body: VehicleBody::CAR,
            height_m: ego.position.z,
            lamps: self.view.ego_lamps(),
            pitch: before.pitch.step(ego.accel_mps2, TICK_S),
        };
    }

    /// Returns a full body at its predicted pose of the end of this tick, as an obstacle for others.
    pub(super) fn obstacle(&self) -> Option<Obstacle> {
        let (pose, speed_mps) = self.car()?.predict(TICK_S);
        Some(Obstacle {
            id: ObstacleId::Vehicle(self.id.0),
            pose,
            speed_mps,
            height_m: self.view.ego.position.z,
            ..Obstacle::default()
        })
    }

    /// Returns where a vehicle's front is along this one's route; `None` off the route. `seen_on` has the route of its present position: on a
    /// closed route all share one.
    pub(super) fn s_of(&self, other: &VehicleSnapshot, seen_on: &Arc<RoadMap>) -> Option<f64> {
        match Arc::ptr_eq(&self.map, seen_on) {
            true => other.s_m,
            false => self.network.s_of(&self.map, other, self.view.ego_s_m),
        }
    }

    /// Copies the view of a drive on this map, plus the observer's own vehicle if there is one.
    pub(super) fn copy_view(&mut self, view: &Snapshot, own: Option<&VehicleSnapshot>, map: &Arc<RoadMap>) {
        let mut cars = std::mem::take(&mut self.view.cars);
        cars.clear();
        let others = view.cars.iter().filter(|car| car.id != self.id);
        let all = own.into_iter().chain(others);
        cars.extend(all.map(|car| VehicleSnapshot { s_m: self.s_of(car, map), ..*car }));
        self.view.cars = cars;
        self.view.signals.clone_from(&view.signals);
    }

    /// Updates the state of a full body that follows from all vehicles' poses: leader, lane and violations of rules.
    pub(super) fn update_derived(&mut self) {
        let ego = self.image.pose;
        derived_state::update_derived(&mut self.view, &self.map.route);
        let network = &mut self.network;
        network.update_derived(&mut self.view, &self.map);
        let ground = network.ground(&self.map, &self.view);
        let is_asphalt = |aside_m: f64| ground.surface(ego.position + ego.left() * aside_m) == GroundSurface::Asphalt;
        let is_on_road = match self.lane.is_in_lane() {
            true => is_asphalt(0.0),
            false => is_asphalt(BACK_INSIDE_M) && is_asphalt(-BACK_INSIDE_M),
        };
        self.events.extend(self.lane.watch(&self.view, is_on_road));
        // Rules are not watched beyond the end of the path.
        if !network.is_at_end(&self.view, &self.map) {
            self.rules.watch(&self.view, &self.map, &ego, &mut self.events);
        }
    }

    /// Returns true if the vehicle is at the end of its path.
    pub(super) fn is_at_end(&self) -> bool {
        self.network.is_at_end(&self.view, &self.map)
    }
}

/// A vehicle that is to become an agent.
pub(super) struct NewAgent {
    pub id: VehicleId,
    /// Road with the vehicle's path as its route.
    pub map: Arc<RoadMap>,
    pub start: StartPlace,
}

/// Returns the car's parameters with the scenario's settings.
pub(super) fn car_params(scenario: &Scenario) -> CarParams {
    let mut params = CarParams::default();
    params.gearbox.creep = scenario.creep;
    params.tyres.water_mm = water_mm(scenario.rain_mmph);
    params
}
