//! The world of one drive. In: [`Controls`] once a tick. Out: [`Event`]s and the [`Snapshot`] of that tick.
//!
//! Traffic runs one step ahead (docs/decisions.md: 3): at the first tick of step k the engine is asked for k+1, told
//! where the agents are and where they will be; until then the other cars move evenly from where they were to where they will
//! be (`traffic_coupling`: on a closed route `ring_coupling`, on a network `network_coupling`). Agents are the participant's vehicle,
//! the first, and every other that is advised (`agent`): they are simulated tick by tick in between. What one touches is in `contacts`,
//! where it is on the road in `derived_state`, what policies and drivers know in `advice` and `perception`, whom it has to let go
//! first in `give_way`.

mod advice;
mod agent;
mod contacts;
mod derived_state;
mod ego_insertion;
mod gap_acceptance;
mod give_way;
mod hand_over;
mod lane_beside;
mod lane_changes;
mod network_coupling;
mod network_view;
mod outside;
mod path_lanes;
mod perception;
mod put_back;
mod ring_coupling;
mod road_rules;
mod sham;
mod time_to_collision;
mod traffic_coupling;
mod turns;
mod yield_lines;

pub use advice::ExpectedSpeeds;
pub use agent::Agent;
pub use hand_over::{HandOver, WAVE_STANDS_S};
pub use lane_beside::lanes_beside;
pub use outside::{AgentDrivers, OutsideSettings};
pub use put_back::NotPutBack;

use super::{Event, EventKind, Snapshot, VehicleSnapshot, WorldError, event::EndReason};
use crate::{
    controls::Controls,
    driver,
    ego::{CarParams, Obstacle},
    map::RoadMap,
    policy,
    scenario::{OnContact, Scenario},
    time::{TICK_S, Tick},
    traffic::{EGO, Traffic, TrafficError, VehicleId},
};
use advice::AdviceSource;
use std::{path::PathBuf, sync::Arc};
use traffic_coupling::TrafficCoupling;

/// Vehicles farther from an agent are no bodies of its physics, metres: none is there within a step.
const TOUCHABLE_M: f64 = 100.0;

/// One drive, running.
pub struct World {
    scenario: Scenario,
    map: Arc<RoadMap>,
    traffic: TrafficCoupling,
    /// The participant's vehicle first, then the others that are advised, by ascending id. Where there is no participant the first is
    /// no more than a view of all others.
    agents: Vec<Agent>,
    /// Numbers of all that were agents at any time beside the participant's vehicle, ascending.
    advised: Vec<VehicleId>,
    /// Contacts of those that have left.
    contacts_before: u32,
    /// Who drives those beside the participant, where the scenario does not say it.
    drivers: Option<AgentDrivers>,
    touchable: Touchable,
    /// The engine has made the step that the next tick begins.
    is_prepared: bool,
    ended: Option<EndReason>,
}

/// What several agents could touch, as obstacles of their physics. Lists that are filled in each tick.
#[derive(Default)]
struct Touchable {
    agents: Vec<Obstacle>,
    cars: Vec<Obstacle>,
    /// Of both those near one agent.
    near: Vec<Obstacle>,
}

impl World {
    /// Loads the map, starts traffic, runs the warm-up and puts the agents on the road.
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn new(scenario: &Scenario) -> Result<Self, WorldError> {
        Self::advised_by(scenario, None, AdviceSource::new)
    }

    /// The same with this advice and these drivers of others.
    fn advised_by(
        scenario: &Scenario,
        drivers: Option<AgentDrivers>,
        advice: impl FnOnce(&Scenario, &RoadMap) -> Result<AdviceSource, WorldError>,
    ) -> Result<Self, WorldError> {
        let map = Arc::new(scenario.load_map()?);
        let scenario = &scenario.on(&map);
        scenario.check_on_road().map_err(|(key, message)| WorldError::Setting { key, message })?;
        let advice = advice(scenario, &map)?;
        let mut traffic = TrafficCoupling::start(scenario, &map)?;
        let bodies = traffic.bodies();
        let mut participant = Agent::participant(scenario, &map, advice, traffic.ego_start(), bodies)?;
        traffic.first_view(&mut participant.view, &map.route);
        let mut world = Self {
            scenario: scenario.clone(),
            map,
            traffic,
            agents: vec![participant],
            advised: Vec::new(),
            contacts_before: 0,
            drivers,
            touchable: Touchable::default(),
            is_prepared: false,
            ended: None,
        };
        world.look_around();
        world.renew_agents()?;
        Ok(world)
    }

    /// The traffic of a scenario after its warm-up, without any agent: every car on the closed route goes on by the traffic's own model.
    ///
    /// # Errors
    /// See [`WorldError`].
    pub fn traffic_alone(scenario: &Scenario) -> Result<(Arc<RoadMap>, Box<dyn Traffic>), WorldError> {
        let map = Arc::new(scenario.load_map()?);
        match TrafficCoupling::start(&scenario.on(&map), &map)? {
            TrafficCoupling::Ring(ring) => Ok((map, ring.into_engine())),
            TrafficCoupling::Network(_) => Err(WorldError::Traffic(TrafficError::Setup(
                "traffic alone is that of a closed route with a fixed number of cars; this drive is on a network"
                    .into(),
            ))),
        }
    }

    /// One tick with these controls of the participant, which reach the car after the scenario's extra delay. After the end of the drive
    /// nothing moves any more.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn tick(&mut self, controls: &Controls) -> Result<(), WorldError> {
        if self.ended.is_some() {
            self.agents.iter_mut().for_each(|agent| agent.events.clear());
            return Ok(());
        }
        let step_ticks = self.scenario.step_ticks();
        let within = self.snapshot().tick.0 % step_ticks;
        self.prepare()?;
        self.agents.iter_mut().for_each(|agent| agent.begin_tick(controls));
        if within == 0 {
            self.is_prepared = false;
            self.agents.iter_mut().for_each(Agent::begin_step);
            self.traffic.begin_step(&self.agents[0].view);
        }
        let fraction = (within + 1) as f64 / step_ticks as f64;
        self.traffic.move_cars(&mut self.agents[0].view, &self.map, fraction);
        self.agents[0].stand_on_lane(&self.scenario)?;
        if self.drive() && self.scenario.contact == OnContact::End {
            self.end(EndReason::Contact);
        }
        self.agents.iter_mut().for_each(|agent| agent.view.tick.0 += 1);
        self.look_around();
        if self.agents[0].is_at_end() {
            self.end(EndReason::PathEnd);
        }
        let duration_s = self.scenario.duration_s;
        if self.ended.is_none() && duration_s > 0.0 && self.snapshot().tick >= Tick::at_seconds(duration_s) {
            self.end(EndReason::Duration);
        }
        Ok(())
    }

    /// Prepares the step that the next tick begins, if it begins one: agents come and go, policies are asked, and the engine makes its
    /// step. A tick does this by itself; whoever chooses controls by what is seen at its beginning calls it before that.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn prepare(&mut self) -> Result<(), WorldError> {
        if self.ended.is_some() || self.is_prepared || !self.begins_step() {
            return Ok(());
        }
        self.renew_agents()?;
        present(&mut self.agents).iter_mut().for_each(|agent| agent.ask_policy(&self.scenario));
        self.traffic.ask(&self.agents, self.scenario.step_s)?;
        self.is_prepared = true;
        Ok(())
    }

    /// True if the next tick begins a step of the traffic engine.
    fn begins_step(&self) -> bool {
        self.snapshot().tick.0.is_multiple_of(self.scenario.step_ticks())
    }

    /// At the beginning of a step agents whose way is over leave, and vehicles that are to be advised become agents where they are.
    fn renew_agents(&mut self) -> Result<(), WorldError> {
        let (traffic, contacts) = (&self.traffic, &mut self.contacts_before);
        self.agents.retain(|agent| {
            let stays = agent.id() == EGO || !(agent.is_at_end() || traffic.has_arrived(agent.id()));
            *contacts += if stays { 0 } else { agent.contact_count() };
            stays
        });
        if !self.agents[0].advice.advises() {
            return Ok(());
        }
        let (bodies, known) = (self.traffic.bodies(), self.agents.len());
        for new in self.traffic.new_agents(&self.scenario, &self.map)? {
            let driver = match &self.drivers {
                Some(drivers) => drivers(new.id)?,
                None => driver::named(&self.scenario.driver)?.params,
            };
            let agent = Agent::advised(&self.scenario, &self.agents[0], &new, (&driver, bodies))?;
            self.advised.push(new.id);
            self.agents.push(agent);
        }
        let (before, new) = self.agents.split_at_mut(known);
        for agent in &mut *new {
            agent.locate();
            before[0].sees(&agent.image);
        }
        for agent in new {
            agent.sees_as(&before[0]);
            agent.look_around();
        }
        Ok(())
    }

    /// All agents go on by a tick. True if the participant's vehicle has begun to touch another.
    fn drive(&mut self) -> bool {
        match self.agents.as_mut_slice() {
            [participant] if self.scenario.participant => participant.drive(self.traffic.obstacles()),
            _ => self.drive_several(),
        }
    }

    /// The same where there are several, each an obstacle to the others.
    fn drive_several(&mut self) -> bool {
        let Touchable { agents, cars, near } = &mut self.touchable;
        agents.clear();
        agents.extend(present(&mut self.agents).iter().map(|agent| agent.obstacle()));
        // All that are no agents are in the participant's view, at the end of this tick already.
        let is_agent = |id: VehicleId| agents.binary_search_by_key(&id.0, |agent| agent.id).is_ok();
        let others = self.agents[0].view.cars.iter().filter(|car| !is_agent(car.id));
        cars.clear();
        cars.extend(others.map(VehicleSnapshot::obstacle));
        let mut has_touched = false;
        for (agent, own) in present(&mut self.agents).iter_mut().zip(&*agents) {
            let is_near = |other: &&Obstacle| {
                other.pose.position.distance(own.pose.position) < TOUCHABLE_M && other.is_at_height(own.height_m)
            };
            near.clear();
            near.extend(cars.iter().filter(is_near));
            near.extend(agents.iter().filter(|other| other.id != own.id).filter(is_near));
            has_touched |= agent.drive(near) && own.id == EGO.0;
        }
        has_touched
    }

    /// Every agent notes where it is, sees all others there, and what follows from that.
    fn look_around(&mut self) {
        self.agents.iter_mut().for_each(Agent::locate);
        if let [participant, others @ ..] = self.agents.as_mut_slice() {
            for other in &*others {
                participant.sees(&other.image);
            }
            for other in others {
                other.sees_as(participant);
            }
        }
        self.agents.iter_mut().for_each(Agent::look_around);
    }

    fn end(&mut self, reason: EndReason) {
        self.ended = Some(reason);
        let tick = self.snapshot().tick;
        self.agents[0].events.push(Event { tick, kind: EventKind::Ended(reason) });
    }

    fn participant(&self) -> &Agent {
        &self.agents[0]
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

    /// True once [`World::stop_traffic`] was called.
    pub fn is_stopped(&self) -> bool {
        self.traffic.is_stopped()
    }

    /// What happened in the last tick.
    pub fn events(&self) -> &[Event] {
        &self.participant().events
    }

    /// Everything at the present tick.
    pub fn snapshot(&self) -> &Snapshot {
        &self.participant().view
    }

    /// The vehicles that are advised beside the participant's now, by ascending id.
    pub fn advised_others(&self) -> &[Agent] {
        &self.agents[1..]
    }

    /// Numbers of all that were so at any time, ascending.
    pub fn ever_advised(&self) -> &[VehicleId] {
        &self.advised
    }

    /// How often any of them has begun to touch another vehicle.
    pub fn contacts_of_others(&self) -> u32 {
        self.contacts_before + self.advised_others().iter().map(Agent::contact_count).sum::<u32>()
    }

    /// True if there can be such vehicles.
    pub fn advises_others(&self) -> bool {
        let can_come = self.scenario.is_on_network() && self.scenario.advised.of_those_that_come() > 0.0;
        self.participant().advice.advises() && (can_come || !self.advised.is_empty())
    }

    /// The policy that drives; the scenario says which was asked for.
    pub fn policy(&self) -> &policy::ResolvedPolicy {
        &self.participant().advice.policy
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
        self.participant().advice.expected
    }

    /// How traffic was when the driver took over.
    pub fn hand_over(&self) -> HandOver {
        self.traffic.hand_over()
    }

    /// The ego's car.
    pub fn ego_params(&self) -> &CarParams {
        self.participant().car.params()
    }

    /// Name and version of the traffic engine.
    pub fn traffic_engine(&self) -> String {
        self.traffic.describe()
    }

    /// The canonical copies of the demand's files that SUMO reads, in the order of the scenario's; none once traffic was let go.
    pub fn demand_files(&self) -> &[PathBuf] {
        self.traffic.demand_files()
    }

    /// Why the drive is over, once it is.
    pub fn ended(&self) -> Option<EndReason> {
        self.ended
    }

    /// Present seconds since the start of the drive.
    pub fn time_s(&self) -> f64 {
        self.snapshot().tick.0 as f64 * TICK_S
    }
}

/// Those of the agents that are there: all but the first where there is no participant.
fn present(agents: &mut [Agent]) -> &mut [Agent] {
    let first = usize::from(agents[0].view.is_without_ego);
    &mut agents[first..]
}

#[cfg(test)]
#[path = "world_tests.rs"]
mod tests;
