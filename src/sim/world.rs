//! The world of one drive. In: [`Controls`] once a tick. Out: [`Event`]s and the [`Snapshot`] of that tick.
//!
//! Traffic runs one step ahead (docs/decisions.md: 3). At the first tick of step k the engine gets the agents' present and predicted poses
//! and computes step k+1. In between, the other vehicles are interpolated linearly (`traffic_coupling`; `traffic_start` starts them).
//! Agents (`agent`) are the participant's vehicle and every other advised vehicle. Full ones are simulated tick by tick, light ones
//! (`light_agent`) step by step, before the engine makes the step (`touchable`). The `observer` has the view that is recorded and drawn.
//! `contacts` finds contacts, `derived_state` the position on the road, `advice` and `perception` the input of policies and drivers.

mod advice;
mod advised_selection;
mod agent;
mod checked_drive;
mod contacts;
mod cut_in;
mod derived_state;
mod detour;
mod driving_order;
mod ego_insertion;
mod event_effects;
mod event_script;
mod event_triggers;
mod event_vehicles;
mod event_view;
mod hand_over;
mod light_agent;
mod light_body;
mod network_view;
mod objects_beside;
mod observer;
mod outside;
mod perception;
mod persons_ahead;
mod put_back;
mod questions;
mod road_people;
mod road_rules;
mod road_user;
mod road_users;
mod sham;
mod speed_control;
mod step_way;
mod time_to_collision;
mod touchable;
mod traffic_coupling;
mod traffic_start;
mod user_speed;
mod user_way;
mod vehicles_across;
mod yielding;

pub use advice::{CostlyInputs, ExpectedSpeeds, policy_of, policy_settings, road_kind};
pub use agent::Agent;
pub use checked_drive::CheckedDrive;
pub use hand_over::{HandOver, WAVE_STANDS_S};
pub use outside::{AgentDrivers, OutsideSettings};
pub use put_back::NotPutBack;

use super::{Event, EventKind, Snapshot, WorldError, event::EndReason, secondary_task::TaskRun};
use crate::{
    controls::Controls,
    driver::{self, DriverError, DriverParams, SimulatedDriver},
    ego::CarParams,
    map::RoadMap,
    policy,
    scenario::{AdvisedBody, AdvisedVehicles, PlannedDrive, Scenario},
    time::{TICK_S, Tick},
    traffic::{Demand, Traffic, VehicleId},
};
use advice::DriveAdvice;
use driving_order::DrivingOrder;
use event_script::EventScript;
use event_view::ScriptView;
use observer::Observer;
use std::{
    collections::BTreeSet,
    sync::{Arc, Mutex},
};
use touchable::Touchable;
use traffic_coupling::{LEADER_REACH_M, TrafficCoupling};

/// A drive in progress.
pub struct World {
    drive: PlannedDrive,
    traffic: TrafficCoupling,
    advice: DriveAdvice,
    /// The participant's vehicle, or the view of a drive without a participant.
    observer: Observer,
    /// The other advised vehicles, by ascending id.
    others: Vec<Agent>,
    /// Others that have left since the last step began.
    left: Vec<Agent>,
    /// Ids of all vehicles other than the participant's that have been agents, ascending.
    agents: Vec<VehicleId>,
    /// Contacts of agents that have left.
    contacts_before: u32,
    /// Source of drivers for the other agents; `None` uses the scenario's driver.
    drivers: Option<AgentDrivers>,
    ego_params: CarParams,
    touchable: Touchable,
    /// Order of the vehicles of a closed route, in which light agents find their leaders.
    order: DrivingOrder,
    script: EventScript,
    /// The engine has made the step that the next tick begins.
    is_prepared: bool,
    /// Secondary task of the participant.
    task: Option<TaskRun>,
    ended: Option<EndReason>,
}

impl World {
    /// Plans the drive of a scenario and starts it ([`World::of`]).
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn new(scenario: &Scenario) -> Result<Self, WorldError> {
        Self::of(PlannedDrive::new(scenario)?)
    }

    /// Starts traffic, runs the warm-up and places the agents.
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn of(drive: PlannedDrive) -> Result<Self, WorldError> {
        let mut advice = DriveAdvice::new(&drive)?;
        if drive.scenario().sham_advice && advice.advises() {
            advice.sham = Some(sham::advice(&drive)?);
        }
        Self::advised_by(drive, advice, None)
    }

    /// Does the same as [`World::of`] with this advice and these drivers of the other agents.
    fn advised_by(
        drive: PlannedDrive,
        mut advice: DriveAdvice,
        drivers: Option<AgentDrivers>,
    ) -> Result<Self, WorldError> {
        // Each sentence once, as a study begins hundreds of drives.
        static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
        for sentence in drive.settings_without_effect() {
            if SAID.lock().is_ok_and(|mut said| said.insert(sentence.clone())) {
                log::warn!("{sentence}");
            }
        }
        let (scenario, map) = (drive.scenario(), drive.map());
        let mut traffic = TrafficCoupling::start(&drive)?;
        let mut observer = match scenario.participant {
            true => {
                let (advice, start, bodies) = (advice.of_participant(scenario), traffic.ego_start(), traffic.bodies());
                let agent = Agent::new((&drive, map), advice, start, AdvisedBody::Full, bodies)?;
                Observer::Participant(Box::new(agent.automated(scenario)?))
            }
            false => Observer::spectator(map),
        };
        traffic.first_view(observer.view_mut());
        let mut world = Self {
            script: EventScript::new(&drive),
            ego_params: agent::car_params(scenario),
            task: TaskRun::new(scenario).filter(|_| scenario.participant),
            drive,
            traffic,
            advice,
            observer,
            others: Vec::new(),
            left: Vec::new(),
            agents: Vec::new(),
            contacts_before: 0,
            drivers,
            touchable: Touchable::default(),
            order: DrivingOrder::default(),
            is_prepared: false,
            ended: None,
        };
        world.show_moved_by_events(0);
        world.update_derived()?;
        world.sync_agents()?;
        Ok(world)
    }

    /// Returns the traffic of a closed route after its warm-up, without agents; the traffic's own model drives every vehicle.
    ///
    /// # Errors
    /// See [`WorldError`]; also fails where vehicles enter and leave.
    pub fn traffic_alone(drive: &PlannedDrive) -> Result<Box<dyn Traffic>, WorldError> {
        Ok(traffic_start::fixed(drive)?.engine)
    }

    /// Advances by one tick with the participant's controls, which reach the car after the scenario's extra delay. After the end of the
    /// drive it only clears the events.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn tick(&mut self, controls: &Controls) -> Result<(), WorldError> {
        self.advance(controls, 1)
    }

    /// Advances a drive without a participant from one step of the traffic engine to the next. It does so at once where no vehicle has a full
    /// body: the others move from step to step, and what is drawn within a step is left out.
    ///
    /// # Errors
    /// As [`World::tick`].
    pub fn step(&mut self) -> Result<(), WorldError> {
        let step_ticks = self.scenario().step_ticks();
        let moves_within = self.observer.participant().is_some() || self.others.iter().any(Agent::is_full);
        if self.begins_step() && !moves_within && self.scenario().advised_body == AdvisedBody::Light {
            return self.advance(&Controls::default(), step_ticks);
        }
        (0..step_ticks).try_for_each(|_| self.tick(&Controls::default()))
    }

    /// Advances by one tick, or by all ticks of a step.
    fn advance(&mut self, controls: &Controls, ticks: u64) -> Result<(), WorldError> {
        if self.ended.is_some() {
            self.observer.events_mut().clear();
            self.others.iter_mut().for_each(|agent| agent.events.clear());
            return Ok(());
        }
        let step_ticks = self.scenario().step_ticks();
        let within = self.snapshot().tick.0 % step_ticks;
        self.prepare()?;
        self.observer.events_mut().clear();
        agents_mut(&mut self.observer, &mut self.others).for_each(|agent| agent.begin_tick(controls));
        if within == 0 {
            self.is_prepared = false;
            self.apply_events();
            agents_mut(&mut self.observer, &mut self.others).for_each(Agent::begin_step);
            self.observer.events_mut().extend(self.script.take_events());
            self.traffic.begin_step(self.observer.view());
        }
        let fraction = (within + ticks) as f64 / step_ticks as f64;
        self.traffic.move_vehicles(self.observer.view_mut(), fraction, ticks as f64 * TICK_S);
        self.show_moved_by_events(ticks);
        self.script.watch(controls);
        let participant = self.observer.participant_mut();
        participant.map_or(Ok(()), |participant| participant.place_on_lane(self.drive.scenario()))?;
        if self.move_to_contact() {
            self.end(EndReason::Contact);
        }
        self.observer.view_mut().tick.0 += ticks;
        self.others.iter_mut().for_each(|agent| agent.view.tick.0 += ticks);
        self.ask_participant(controls.task_button);
        self.update_derived()?;
        if self.script.ends_drive() {
            self.end(EndReason::Event);
        } else if self.observer.participant().is_some_and(Agent::is_at_end) {
            self.end(EndReason::PathEnd);
        }
        let duration_s = self.scenario().duration_s;
        if self.ended.is_none() && duration_s > 0.0 && self.snapshot().tick >= Tick::at_seconds(duration_s) {
            self.end(EndReason::Duration);
        }
        Ok(())
    }

    /// Prepares the step that the next tick begins, if it begins one: agents come and go, policies are asked, and the engine makes its
    /// step. A tick does this by itself. Call it before where controls are chosen by what is seen at the tick's beginning.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn prepare(&mut self) -> Result<(), WorldError> {
        if self.ended.is_some() || self.is_prepared || !self.begins_step() {
            return Ok(());
        }
        self.left.clear();
        self.sync_agents()?;
        agents_mut(&mut self.observer, &mut self.others).for_each(|agent| agent.ask_policy(&self.drive));
        let (all, step_ticks) = (self.observer.view(), self.drive.scenario().step_ticks());
        self.others.iter_mut().for_each(|agent| agent.choose_motion(all, step_ticks));
        let others = &self.others;
        let seen = ScriptView {
            view: all,
            map: self.drive.map(),
            participant: self.observer.participant(),
            agents: &|id| others.iter().any(|agent| agent.id() == id),
        };
        self.script.step(&seen, &mut self.traffic);
        self.observer.order_automation(self.script.take_order_to_automation());
        self.traffic.ask(self.observer.participant().into_iter().chain(&self.others), self.script.motions())?;
        self.is_prepared = true;
        Ok(())
    }

    /// Returns true if the next tick begins a step of the traffic engine.
    fn begins_step(&self) -> bool {
        self.snapshot().tick.0.is_multiple_of(self.scenario().step_ticks())
    }

    /// Removes agents that have finished their path, and makes agents of vehicles that are to be advised. Called at the beginning of a
    /// step.
    fn sync_agents(&mut self) -> Result<(), WorldError> {
        self.remove_others(|agent, traffic| agent.is_at_end() || traffic.has_arrived(agent.id()));
        let (scenario, bodies, known) = (self.drive.scenario(), self.traffic.bodies(), self.others.len());
        let body = scenario.advised_body;
        for new in self.traffic.new_agents(body)? {
            let driver = match &self.drivers {
                Some(drivers) => drivers(new.id)?,
                None => driver::named(&scenario.driver)?.params,
            };
            let advice = self.advice.of_vehicle(scenario);
            let agent = Agent::new((&self.drive, &new.map), advice, new.start, body, bodies)?;
            let mut agent = agent.driven_by(&driver, new.id, &self.drive)?;
            agent.view.tick = self.observer.view().tick;
            self.agents.push(new.id);
            self.others.push(agent);
        }
        let new = &mut self.others[known..];
        for agent in new.iter_mut().filter(|agent| agent.is_full()) {
            agent.locate();
            self.observer.insert_image(agent, &self.traffic);
        }
        for agent in new.iter_mut().filter(|agent| agent.is_full()) {
            self.observer.copy_view_to(agent, self.drive.map());
            agent.update_derived();
        }
        self.follow_traffic(known)
    }

    /// Removes the others for which `is_gone` holds.
    fn remove_others(&mut self, is_gone: impl Fn(&Agent, &TrafficCoupling) -> bool) {
        let gone = self.others.extract_if(.., |agent| is_gone(agent, &self.traffic));
        self.left.extend(gone.inspect(|agent| self.contacts_before += agent.contact_count()));
    }

    /// Takes the light agents from the `first` of the others on to where the traffic has them at the beginning of a step.
    fn follow_traffic(&mut self, first: usize) -> Result<(), WorldError> {
        if self.others[first..].iter().all(Agent::is_full) {
            return Ok(());
        }
        if !self.drive.is_open() {
            self.order.take(self.observer.view(), self.observer.participant().map(|participant| &participant.image));
        }
        let (all, map) = (self.observer.view(), self.drive.map());
        for agent in self.others[first..].iter_mut().filter(|agent| !agent.is_full()) {
            let Some(now) = all.vehicle(agent.id()) else { continue };
            let leader = match self.drive.is_open() {
                true => self.traffic.leader(agent.id(), LEADER_REACH_M)?,
                false => self.order.leader(agent.id(), &map.route),
            };
            agent.follow_traffic(now, leader, all);
            if agent.advice.sees.has_others() {
                self.observer.copy_view_to(agent, map);
            }
        }
        Ok(())
    }

    /// Updates the position and the image of every full agent, then their view of the others and the state derived from it; that of light
    /// agents at a step's end.
    fn update_derived(&mut self) -> Result<(), WorldError> {
        agents_mut(&mut self.observer, &mut self.others).for_each(Agent::locate);
        for other in self.others.iter().filter(|agent| agent.is_full()) {
            self.observer.insert_image(other, &self.traffic);
        }
        for other in self.others.iter_mut().filter(|agent| agent.is_full()) {
            self.observer.copy_view_to(other, self.drive.map());
        }
        self.observer.update_derived();
        self.others.iter_mut().filter(|agent| agent.is_full()).for_each(Agent::update_derived);
        if !self.begins_step() {
            return Ok(());
        }
        // A light agent is where the traffic has it, and has gone with the vehicle.
        self.remove_others(|agent, traffic| !agent.is_full() && traffic.has_arrived(agent.id()));
        self.follow_traffic(0)
    }

    fn end(&mut self, reason: EndReason) {
        self.ended = Some(reason);
        let tick = self.snapshot().tick;
        self.observer.events_mut().push(Event { tick, kind: EventKind::Ended(reason) });
    }

    /// Extends the drive by `seconds`; no effect on a drive without an end.
    pub fn extend(&mut self, seconds: f64) {
        self.drive.extend(seconds);
    }

    /// Releases the traffic engine for another drive, as SUMO runs once a process. This drive cannot go on.
    pub fn stop_traffic(&mut self) {
        self.traffic.stop();
    }

    /// Returns true after a call of [`World::stop_traffic`].
    pub fn is_stopped(&self) -> bool {
        self.traffic.is_stopped()
    }

    /// Returns the events of the last tick: the participant's, and the end of the drive.
    pub fn events(&self) -> &[Event] {
        self.observer.events()
    }

    /// Returns the participant's view at the present tick; without a participant, that of all vehicles.
    pub fn snapshot(&self) -> &Snapshot {
        self.observer.view()
    }

    /// Returns the advised vehicles other than the participant's that are present, by ascending id.
    pub fn advised_others(&self) -> &[Agent] {
        &self.others
    }

    /// Returns those of them that have left since the last step began, as they were at their last step.
    pub fn left_others(&self) -> &[Agent] {
        &self.left
    }

    /// Returns the ids of all vehicles other than the participant's that have been advised, ascending; none without a policy.
    pub fn ever_advised(&self) -> &[VehicleId] {
        if self.advice.advises() { &self.agents } else { &[] }
    }

    /// Returns the number of contacts of all of these vehicles so far.
    pub fn contacts_of_others(&self) -> u32 {
        self.contacts_before + self.advised_others().iter().map(Agent::contact_count).sum::<u32>()
    }

    /// Returns true if vehicles other than the participant's are or can become agents: those that are advised, or that a policy `none` leaves to
    /// the same drivers without advice.
    pub fn has_other_agents(&self) -> bool {
        let can_come = matches!(self.drive.advised(), AdvisedVehicles::Share(share) if share > 0.0);
        can_come || !self.agents.is_empty()
    }

    /// Returns the policy in use; the scenario has the policy that was requested.
    pub fn policy(&self) -> &policy::ResolvedPolicy {
        &self.advice.policy
    }

    /// Returns the drive as it was planned.
    pub fn drive(&self) -> &PlannedDrive {
        &self.drive
    }

    pub fn map(&self) -> &Arc<RoadMap> {
        self.drive.map()
    }

    /// Returns the scenario, with the settings that follow from its road.
    pub fn scenario(&self) -> &Scenario {
        self.drive.scenario()
    }

    /// Returns the speeds that the speedometer must cover.
    pub fn expected_speeds(&self) -> ExpectedSpeeds {
        self.advice.expected
    }

    /// Returns the state of traffic at the hand-over to the driver.
    pub fn hand_over(&self) -> HandOver {
        self.traffic.hand_over
    }

    /// Returns a simulated driver of the ego with these parameters, among the drivers of this traffic.
    ///
    /// # Errors
    /// A number of the driver is outside the range that can be simulated.
    pub fn simulated_driver(&self, params: &DriverParams, seed: u64) -> Result<SimulatedDriver, DriverError> {
        Ok(SimulatedDriver::new(params, &self.ego_params, seed)?.among(self.drive.traffic_drivers()))
    }

    /// Returns the parameters of the ego's car.
    pub fn ego_params(&self) -> &CarParams {
        &self.ego_params
    }

    /// Returns the name and version of the traffic engine.
    pub fn traffic_engine(&self) -> String {
        self.traffic.engine_name()
    }

    /// Returns the demand with the canonical copies that SUMO reads in place of its files; `None` after [`World::stop_traffic`].
    pub fn demand(&self) -> Option<&Demand> {
        self.traffic.demand()
    }

    /// Returns the reason for the end of the drive, once it has ended.
    pub fn ended(&self) -> Option<EndReason> {
        self.ended
    }

    /// Returns the time since the start of the drive, seconds.
    pub fn time_s(&self) -> f64 {
        self.snapshot().tick.0 as f64 * TICK_S
    }
}

/// Returns all agents: the participant's vehicle first, if present, then the others by ascending id.
fn agents_mut<'a>(observer: &'a mut Observer, others: &'a mut [Agent]) -> impl Iterator<Item = &'a mut Agent> {
    observer.participant_mut().into_iter().chain(others)
}

#[cfg(test)]
#[path = "world_tests.rs"]
mod tests;
