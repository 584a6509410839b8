//! The world of one drive. In: [`Controls`] once a tick. Out: [`Event`]s and the [`Snapshot`] of that tick.
//!
//! Traffic runs one step ahead (docs/decisions.md: 3): at the first tick of step k the engine is asked for k+1, told
//! where the ego is and where it will be; until then the other cars move evenly from where they were to where they will
//! be (`traffic_coupling`: on a closed route `ring_coupling`, on a network `network_coupling`). The ego is simulated tick by
//! tick in between. What it touches is in `contacts`, where it is on the road in `derived_state`, what policies and drivers
//! know in `advice` and `perception`, whom it has to let go first in `give_way`.

mod advice;
mod contacts;
mod derived_state;
mod ego_insertion;
mod give_way;
mod hand_over;
mod network_coupling;
mod network_view;
mod path_lanes;
mod perception;
mod put_back;
mod ring_coupling;
mod road_rules;
mod sham;
mod time_to_collision;
mod traffic_coupling;
mod yield_lines;

pub use advice::ExpectedSpeeds;
pub use hand_over::HandOver;
pub use put_back::NotPutBack;

use super::{Event, EventKind, Snapshot, WorldError, event::EndReason, ground::RoadGround};
use crate::{
    controls::Controls,
    ego::{CarParams, EgoCar, GroundModel, GroundSurface},
    map::RoadMap,
    policy,
    scenario::{OnContact, Scenario},
    space::CAR_LENGTH_M,
    time::{TICK_S, Tick},
};
use advice::AdviceSource;
use contacts::ContactTracker;
use derived_state::LaneMonitor;
use network_view::NetworkView;
use road_rules::RoadRules;
use std::{collections::VecDeque, sync::Arc, time::Duration};
use traffic_coupling::TrafficCoupling;

/// One drive, running.
pub struct World {
    scenario: Scenario,
    map: Arc<RoadMap>,
    ego: EgoCar,
    traffic: TrafficCoupling,
    advice: AdviceSource,
    contacts: ContactTracker,
    lane: LaneMonitor,
    /// Only on a network.
    rules: RoadRules,
    /// What there is of the road beside the route; `None` on a closed route with a fixed number of cars.
    network: Option<NetworkView>,
    /// The next tick has the ego on its lane.
    wants_back: bool,
    /// Controls on their way to the car, oldest first; as many as the scenario's extra delay has ticks.
    control_delay: VecDeque<Controls>,
    snapshot: Snapshot,
    events: Vec<Event>,
    ended: Option<EndReason>,
}

impl World {
    /// Loads the map, starts traffic, runs the warm-up and puts the ego on the road.
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn new(scenario: &Scenario) -> Result<Self, WorldError> {
        let map = Arc::new(scenario.load_map()?);
        let scenario = &scenario.on(&map);
        let advice = AdviceSource::new(scenario, &map)?;
        let mut traffic = TrafficCoupling::start(scenario, &map)?;
        let start = traffic.ego_start();
        let pose = map.route.pose_of_front(start.s_m, CAR_LENGTH_M);
        let mut ego = EgoCar::new(&car_params(scenario), pose, start.speed_mps, traffic.bodies())?;
        let network = scenario.is_on_network().then(|| NetworkView::new(&map));
        if let Some(network) = &network {
            ego.stand_on(network.ground_at(&map, start.s_m).shape(pose.position));
        }
        let mut snapshot = derived_state::first_snapshot(ego.state(), start.s_m);
        traffic.first_view(&mut snapshot);
        let mut world = Self {
            scenario: scenario.clone(),
            contacts: ContactTracker::default(),
            map,
            ego,
            traffic,
            advice,
            lane: LaneMonitor::new(),
            rules: RoadRules::default(),
            network,
            wants_back: false,
            control_delay: vec![Controls::default(); scenario.extra_delay_ticks()].into(),
            snapshot,
            events: Vec::new(),
            ended: None,
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
            self.begin_step();
        }
        let fraction = (within + 1) as f64 / step_ticks as f64;
        self.traffic.move_cars(&mut self.snapshot, &self.map, fraction);
        self.stand_on_lane()?;
        self.control_delay.push_back(*controls);
        let arrived = self.control_delay.pop_front().unwrap_or(*controls);
        self.move_ego(&arrived);
        self.snapshot.tick.0 += 1;
        self.update_derived_state();
        if self.network.as_ref().is_some_and(|network| network.is_at_end(&self.snapshot, &self.map)) {
            self.end(EndReason::PathEnd);
        }
        let duration_s = self.scenario.duration_s;
        if self.ended.is_none() && duration_s > 0.0 && self.snapshot.tick >= Tick::at_seconds(duration_s) {
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
        if !self.traffic.is_asked() {
            let limit_mps = self.map.route.speed_limit_mps(self.snapshot.ego_s_m);
            self.advice.ask(self.snapshot.tick, &self.observe(), limit_mps);
            self.traffic.ask(&self.ego, &self.snapshot, self.scenario.step_s)?;
        }
        Ok(self.traffic.wait(patience)?)
    }

    /// One step begins, as it was asked for.
    fn begin_step(&mut self) {
        if let Some(advice) = self.advice.issue() {
            self.snapshot.advice = Some(advice);
            self.events.push(Event { tick: self.snapshot.tick, kind: EventKind::Advice(advice) });
        } else if self.snapshot.advice.is_some() && !self.advice.stands() {
            self.snapshot.advice = None;
            self.events.push(Event { tick: self.snapshot.tick, kind: EventKind::AdviceWithheld });
        }
        self.traffic.begin_step(&self.snapshot);
    }

    fn move_ego(&mut self, controls: &Controls) {
        let on_route = RoadGround { route: &self.map.route, near_s_m: self.snapshot.ego_s_m };
        let on_network = self.network.as_ref().map(|network| network.ground(&self.map, &self.snapshot));
        let ground: &dyn GroundModel = on_network.as_ref().map_or(&on_route, |ground| ground);
        self.snapshot.ego_before = *self.ego.state();
        let touches = self.ego.tick(controls, ground, self.traffic.obstacles());
        let known = self.events.len();
        self.events.extend(self.contacts.begun(touches, Tick(self.snapshot.tick.0 + 1)));
        self.snapshot.ego = *self.ego.state();
        if self.events.len() > known && self.scenario.contact == OnContact::End {
            self.end(EndReason::Contact);
        }
    }

    fn update_derived_state(&mut self) {
        let ego = self.ego.predict(0.0).0;
        derived_state::update(&mut self.snapshot, &self.map.route, &ego);
        let Some(network) = &mut self.network else {
            self.events.extend(self.lane.watch(&self.snapshot, &self.map.route));
            return;
        };
        network.update(&mut self.snapshot, &self.map, &ego);
        let under = network.ground(&self.map, &self.snapshot).surface(ego.position);
        self.events.extend(self.lane.watch_network(&self.snapshot, under == GroundSurface::Asphalt));
        // What is beyond the end of its path is no matter of the drive.
        if !network.is_at_end(&self.snapshot, &self.map) {
            self.rules.watch(&self.snapshot, &self.map, &ego, &mut self.events);
        }
    }

    fn end(&mut self, reason: EndReason) {
        self.ended = Some(reason);
        self.events.push(Event { tick: self.snapshot.tick, kind: EventKind::Ended(reason) });
    }

    /// The drive lasts so many seconds longer than its scenario said; without an end it has none still.
    pub fn extend(&mut self, seconds: f64) {
        if self.scenario.duration_s > 0.0 {
            self.scenario.duration_s += seconds;
        }
    }

    /// Lets go of the traffic engine, so that another drive can have it (SUMO runs once a process). This drive is over.
    pub fn stop_traffic(&mut self) {
        self.traffic.stop();
    }

    /// Another engine from the next step on: to test what waits for one.
    #[cfg(test)]
    pub(crate) fn set_traffic(&mut self, traffic: Box<dyn crate::traffic::Traffic>) {
        self.traffic.ring().set_engine(traffic);
    }

    /// True once [`World::stop_traffic`] was called.
    pub fn is_stopped(&self) -> bool {
        self.traffic.is_stopped()
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
    pub fn policy(&self) -> &policy::ResolvedPolicy {
        &self.advice.policy
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
        self.advice.expected
    }

    /// How traffic was when the driver took over.
    pub fn hand_over(&self) -> HandOver {
        self.traffic.hand_over()
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

/// The ego with the scenario's settings.
fn car_params(scenario: &Scenario) -> CarParams {
    let mut params = CarParams::default();
    params.gearbox.creep = scenario.creep;
    params
}

#[cfg(test)]
#[path = "world_tests.rs"]
mod tests;
