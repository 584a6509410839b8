//! A vehicle that is simulated whole, the participant's or another that is advised: its body, who drives it, its advice, and the world
//! as it is seen from it. In: once a step the policy's question, once a tick controls and the vehicles around. Out: its [`Snapshot`],
//! its events, and how others see it. Metres, m/s.
//!
//! All agents move at once from one state: in a tick each meets the others where they are predicted to be at its end. Two that
//! touch are walls to each other, as vehicles of the traffic are.

use super::{
    WorldError,
    advice::AdviceSource,
    contacts::ContactTracker,
    derived_state::{self, LaneMonitor},
    hand_over::STANDS_MPS,
    network_view::NetworkView,
    road_rules::RoadRules,
    traffic_coupling::StartPlace,
};
use crate::{
    controls::{Controls, Indicator},
    driver::{DriverParams, SimulatedDriver},
    ego::{CarParams, EgoCar, GroundModel, GroundSurface, Obstacle},
    map::RoadMap,
    rng,
    scenario::Scenario,
    sim::{Event, EventKind, Snapshot, VehicleSnapshot, ground::RoadGround},
    space::{CAR_LENGTH_M, Pose},
    time::{TICK_S, Tick},
    traffic::{EGO, ExternalVehicleState, VehicleBody, VehicleId, is_on_lane},
};
use glam::DVec2;
use std::{collections::VecDeque, sync::Arc};

/// Seeds of drivers stay below this, as those of scenarios do.
const MOST_SEED: usize = 1 << 53;
/// So far beyond the road's corner to the south west nothing is, metres: there stands the vehicle of a participant who is not there.
const AWAY_M: f64 = 1000.0;

/// A vehicle with physics of its own.
pub struct Agent {
    id: VehicleId,
    /// The road along its path.
    pub(super) map: Arc<RoadMap>,
    pub(super) car: EgoCar,
    pub(super) advice: AdviceSource,
    contacts: ContactTracker,
    contact_count: u32,
    pub(super) lane: LaneMonitor,
    /// Only on a network.
    rules: RoadRules,
    /// What there is of the road beside the route; `None` on a closed route with a fixed number of cars.
    pub(super) network: Option<NetworkView>,
    /// Controls on their way to the car, oldest first; as many as the scenario's extra delay has ticks.
    control_delay: VecDeque<Controls>,
    /// `None` of the participant's, whose controls come from outside.
    driver: Option<SimulatedDriver>,
    controls: Controls,
    /// The next tick has it on its lane.
    pub(super) wants_back: bool,
    /// The world as it is seen from here: this vehicle is its ego.
    pub(super) view: Snapshot,
    /// This vehicle as others see it.
    pub(super) image: VehicleSnapshot,
    /// What happened to it in the last tick.
    pub(super) events: Vec<Event>,
}

impl Agent {
    /// The participant's vehicle on a road; the others are not in its view yet. `bodies` others are made ready for its physics. Where
    /// there is no participant it stands beside all roads and is no more than a view of all others.
    pub(super) fn participant(
        scenario: &Scenario,
        map: &Arc<RoadMap>,
        advice: AdviceSource,
        start: StartPlace,
        bodies: usize,
    ) -> Result<Self, WorldError> {
        if scenario.participant {
            return Self::on_road(scenario, map, advice, start, bodies);
        }
        let beside = map.network.bounds().0.truncate() - DVec2::splat(AWAY_M);
        let mut away = Self::at(Pose { position: beside, ..Pose::default() }, scenario, map, advice, (start, bodies))?;
        away.view.is_without_ego = true;
        Ok(away)
    }

    /// A vehicle at its start on the road.
    fn on_road(
        scenario: &Scenario,
        map: &Arc<RoadMap>,
        advice: AdviceSource,
        start: StartPlace,
        bodies: usize,
    ) -> Result<Self, WorldError> {
        let pose = map.route.pose_of_front(start.s_m, CAR_LENGTH_M);
        let mut agent = Self::at(pose, scenario, map, advice, (start, bodies))?;
        if let Some(network) = &agent.network {
            agent.car.stand_on(network.ground_at(map, start.s_m).shape(pose.position));
            agent.view = derived_state::first_snapshot(agent.car.state(), start.s_m);
        }
        Ok(agent)
    }

    /// A vehicle at a pose.
    fn at(
        pose: Pose,
        scenario: &Scenario,
        map: &Arc<RoadMap>,
        advice: AdviceSource,
        (start, bodies): (StartPlace, usize),
    ) -> Result<Self, WorldError> {
        let car = EgoCar::new(&car_params(scenario), pose, start.speed_mps, bodies)?;
        let network = scenario.is_on_network().then(|| NetworkView::new(map));
        let view = derived_state::first_snapshot(car.state(), start.s_m);
        let image = VehicleSnapshot { id: EGO, pose, pose_before: pose, ..VehicleSnapshot::default() };
        Ok(Self {
            id: EGO,
            map: Arc::clone(map),
            car,
            advice,
            contacts: ContactTracker::default(),
            contact_count: 0,
            lane: LaneMonitor::new(),
            rules: RoadRules::default(),
            network,
            control_delay: vec![Controls::default(); scenario.extra_delay_ticks()].into(),
            driver: None,
            controls: Controls::default(),
            wants_back: false,
            view,
            image,
            events: Vec::new(),
        })
    }

    /// Another vehicle, advised as the participant's is, on a road of its own, driven by this simulated driver. What is random about him
    /// comes from a stream of this vehicle's own.
    pub(super) fn advised(
        scenario: &Scenario,
        participant: &Self,
        new: &NewAgent,
        (driver, bodies): (&DriverParams, usize),
    ) -> Result<Self, WorldError> {
        let NewAgent { id, map, start } = new;
        let mut agent = Self::on_road(scenario, map, participant.advice.another(scenario), *start, bodies)?;
        agent.view.tick = participant.view.tick;
        let seed = rng::stream(scenario.seed, &format!("vehicle/{}/driver", id.0)).index(MOST_SEED) as u64;
        let driver = SimulatedDriver::new(driver, agent.car.params(), seed)?;
        // Who stands in a jam has a foot on the brake.
        let driver = if start.speed_mps < STANDS_MPS { driver.with_foot_on_brake() } else { driver };
        Ok(Self { id: *id, driver: Some(driver), ..agent })
    }

    /// Which vehicle.
    pub fn id(&self) -> VehicleId {
        self.id
    }

    /// The world at the present tick as it is seen from this vehicle: it is the ego there.
    pub fn snapshot(&self) -> &Snapshot {
        &self.view
    }

    /// What its driver asked for in the last tick.
    pub fn controls(&self) -> &Controls {
        &self.controls
    }

    /// How often it has begun to touch another vehicle.
    pub fn contact_count(&self) -> u32 {
        self.contact_count
    }

    /// What happened to it in the last tick.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Where it is and where it will be when `step_s` have passed, as traffic is told. Engines know no reverse gear: a car that rolls
    /// backwards stands for them.
    pub(super) fn report(&self, step_s: f64) -> ExternalVehicleState {
        let (pose, speed_mps) = self.car.predict(0.0);
        let (next_pose, next_speed_mps) = self.car.predict(step_s);
        ExternalVehicleState { pose, speed_mps: speed_mps.max(0.0), next_pose, next_speed_mps: next_speed_mps.max(0.0) }
    }

    /// Asks the policy for the step that begins now.
    pub(super) fn ask_policy(&mut self, scenario: &Scenario) {
        let limit_mps = self.map.route.speed_limit_mps(self.view.ego_s_m);
        self.advice.ask(self.view.tick, &self.observe(scenario.vehicles), limit_mps);
    }

    /// One step begins, as it was asked for.
    pub(super) fn begin_step(&mut self) {
        let tick = self.view.tick;
        if let Some(advice) = self.advice.issue() {
            self.view.advice = Some(advice);
            self.events.push(Event { tick, kind: EventKind::Advice(advice) });
        } else if self.view.advice.is_some() && !self.advice.stands() {
            self.view.advice = None;
            self.events.push(Event { tick, kind: EventKind::AdviceWithheld });
        }
    }

    /// A tick begins: nothing has happened yet, and whoever drives says what he does, by what he sees. `outside` is what the
    /// participant does.
    pub(super) fn begin_tick(&mut self, outside: &Controls) {
        self.events.clear();
        let Some(mut driver) = self.driver.take() else {
            self.controls = *outside;
            return;
        };
        self.controls = driver.controls(&self.perceived_by(&driver));
        self.driver = Some(driver);
    }

    /// One tick of its body among these others. True if it has begun to touch one.
    pub(super) fn drive(&mut self, obstacles: &[Obstacle]) -> bool {
        self.control_delay.push_back(self.controls);
        let controls = self.control_delay.pop_front().unwrap_or(self.controls);
        self.indicate(controls.indicator);
        let on_route = RoadGround { route: &self.map.route, near_s_m: self.view.ego_s_m };
        let on_network = self.network.as_ref().map(|network| network.ground(&self.map, &self.view));
        let ground: &dyn GroundModel = on_network.as_ref().map_or(&on_route, |ground| ground);
        self.view.ego_before = *self.car.state();
        let touches = self.car.tick(&controls, ground, obstacles);
        let known = self.events.len();
        self.events.extend(self.contacts.begun(touches, Tick(self.view.tick.0 + 1)));
        self.view.ego = *self.car.state();
        let begun = self.events.len() - known;
        self.contact_count += begun as u32;
        begun > 0
    }

    fn indicate(&mut self, side: Indicator) {
        if std::mem::replace(&mut self.view.ego_indicator, side) != side {
            self.events.push(Event { tick: Tick(self.view.tick.0 + 1), kind: EventKind::Indicator(side) });
        }
    }

    /// Where it is on its route, and how others see it, after it was moved.
    pub(super) fn locate(&mut self) {
        if self.view.is_without_ego {
            return;
        }
        let pose = self.car.predict(0.0).0;
        derived_state::locate(&mut self.view, &self.map.route, &pose);
        if let Some(network) = &mut self.network {
            network.locate(&mut self.view, &self.map, &pose);
        }
        let (ego, before, place) = (&self.view.ego, &self.image, derived_state::own_place(&self.view));
        self.image = VehicleSnapshot {
            id: self.id,
            pose,
            pose_before: before.pose,
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

    /// Where it will be at the end of this tick, for those that it could touch.
    pub(super) fn obstacle(&self) -> Obstacle {
        let (pose, speed_mps) = self.car.predict(TICK_S);
        Obstacle { id: self.id.0, pose, speed_mps, height_m: self.view.ego.position.z, ..Obstacle::default() }
    }

    /// Another agent is where its image is.
    pub(super) fn sees(&mut self, other: &VehicleSnapshot) {
        if let Ok(at) = self.view.cars.binary_search_by_key(&other.id, |car| car.id) {
            self.view.cars[at] = VehicleSnapshot { s_m: self.s_of(other), ..*other };
        }
    }

    /// Where a vehicle's front is along this one's route. On a closed route that is the same for all.
    fn s_of(&self, other: &VehicleSnapshot) -> Option<f64> {
        match &self.network {
            Some(network) => network.s_of(&self.map, other, self.view.ego_s_m),
            None => other.s_m,
        }
    }

    /// All others are where the participant sees them, whose own vehicle is one of them if it is there.
    pub(super) fn sees_as(&mut self, participant: &Self) {
        let mut cars = std::mem::take(&mut self.view.cars);
        cars.clear();
        let others = participant.view.cars.iter().filter(|car| car.id != self.id);
        let all = std::iter::once(&participant.image).filter(|_| !participant.view.is_without_ego).chain(others);
        cars.extend(all.map(|car| VehicleSnapshot { s_m: self.s_of(car), ..*car }));
        self.view.cars = cars;
        self.view.signals.clone_from(&participant.view.signals);
    }

    /// What follows from where all vehicles are: its leader, its lane, what of it breaks a rule.
    pub(super) fn look_around(&mut self) {
        if self.view.is_without_ego {
            derived_state::look_at_all(&mut self.view);
            return;
        }
        let ego = self.image.pose;
        derived_state::look_around(&mut self.view, &self.map.route);
        let Some(network) = &mut self.network else {
            self.events.extend(self.lane.watch(&self.view, &self.map.route));
            return;
        };
        network.look_around(&mut self.view, &self.map);
        let under = network.ground(&self.map, &self.view).surface(ego.position);
        self.events.extend(self.lane.watch_network(&self.view, under == GroundSurface::Asphalt));
        // What is beyond the end of its path is no matter of the drive.
        if !network.is_at_end(&self.view, &self.map) {
            self.rules.watch(&self.view, &self.map, &ego, &mut self.events);
        }
    }

    /// True once it has come to the end of its path.
    pub(super) fn is_at_end(&self) -> bool {
        self.network.as_ref().is_some_and(|network| network.is_at_end(&self.view, &self.map))
    }
}

/// A vehicle that becomes an agent.
pub(super) struct NewAgent {
    pub id: VehicleId,
    /// The road along its path.
    pub map: Arc<RoadMap>,
    pub start: StartPlace,
}

/// The car with the scenario's settings.
pub(super) fn car_params(scenario: &Scenario) -> CarParams {
    let mut params = CarParams::default();
    params.gearbox.creep = scenario.creep;
    params
}
