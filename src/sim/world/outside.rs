//! A world with advice from outside, such as from a learner. In: a planned drive, the drivers, and at each hold the advice of each agent. Out:
//! the agents, and the observation of each when its advice is due. No policy is resolved or asked.
//!
//! The caller ticks it by [`World::tick`], as any other world. Where a step begins, the caller updates the agents by
//! [`World::sync_agents_now`], gets the observation of each of [`World::agents`] from [`World::complete_observation`], and sets advice from this step on by
//! [`World::advise`].

use super::{
    Agent, World, WorldError,
    advice::{CostlyInputs, DriveAdvice},
    agents_mut,
};
use crate::{
    driver::{DriverError, DriverParams},
    policy::{Action, Observation},
    scenario::PlannedDrive,
    sim::Leader,
    traffic::{TrafficError, TrafficOrder, VehicleId},
};
use std::sync::Arc;

/// Returns the driver of an advised vehicle other than the participant's.
pub type AgentDrivers = Arc<dyn Fn(VehicleId) -> Result<DriverParams, DriverError> + Send + Sync>;

/// Settings of a world with advice from outside.
#[derive(Clone, Default)]
pub struct OutsideSettings {
    pub sees: CostlyInputs,
    /// Drivers of the other advised vehicles; `None` uses the scenario's driver.
    pub drivers: Option<AgentDrivers>,
}

impl World {
    /// Does the same as [`World::of`] with advice from outside.
    ///
    /// # Errors
    /// See [`WorldError`].
    pub fn advised_from_outside(drive: PlannedDrive, outside: OutsideSettings) -> Result<Self, WorldError> {
        let advice = DriveAdvice::from_outside(&drive, outside.sees);
        Self::advised_by(drive, advice, outside.drivers)
    }

    /// Removes agents that have finished their path and makes agents of vehicles that are to be advised, so that they can be advised from
    /// this step on. Call it where a step begins; it has no effect within a step.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn sync_agents_now(&mut self) -> Result<(), WorldError> {
        if self.ended.is_some() || self.is_prepared || !self.begins_step() {
            return Ok(());
        }
        self.sync_agents()
    }

    /// Returns all agents: the participant's vehicle first, if present, then the others by ascending id.
    pub fn agents(&self) -> impl Iterator<Item = &Agent> {
        self.observer.participant().into_iter().chain(&self.others)
    }

    /// Sets the advice of the `index`th of [`World::agents`] from the next step on; no effect beyond the last.
    pub fn advise(&mut self, index: usize, action: Action) {
        if let Some(agent) = agents_mut(&mut self.observer, &mut self.others).nth(index) {
            agent.advice.set_action(action);
        }
    }

    /// Returns for each vehicle of the traffic, in the order of [`vehicles`](crate::sim::Snapshot::vehicles), the vehicle ahead of it on its way
    /// within `reach_m`.
    ///
    /// # Errors
    /// The engine has no vehicles with routes, or it failed.
    pub fn leaders(&self, reach_m: f64) -> Result<Vec<Option<Leader>>, WorldError> {
        self.snapshot().vehicles().map(|car| Ok(self.traffic.leader(car.id, reach_m)?)).collect()
    }

    /// Returns the name of a vehicle in the demand, and that of its type.
    ///
    /// # Errors
    /// The engine has no demand, or the vehicle is not there.
    pub fn names(&self, id: VehicleId) -> Result<[String; 2], WorldError> {
        self.traffic.names(id)
    }

    /// Gives the traffic an order. Call it where a step begins; it counts from that step on.
    ///
    /// # Errors
    /// The order is for a vehicle with a full body, which keeps to its own path; it is for the speed of an advised vehicle; the vehicle is
    /// not there; or the engine refuses the order.
    /// Nothing has changed.
    pub fn order(&mut self, order: &TrafficOrder) -> Result<(), WorldError> {
        let of = order.vehicle();
        if let Some(agent) = self.agents().find(|agent| Some(agent.id()) == of) {
            let why = match (agent.is_full(), order.is_for_model()) {
                (_, true) => "is advised; its driver chooses the speed",
                (true, false) => "has a full body and a driver, who keeps to the path",
                (false, false) => "",
            };
            if !why.is_empty() {
                return Err(TrafficError::Setup(format!("vehicle {} {why}", agent.id().0)).into());
            }
        }
        let path = self.traffic.order(order)?;
        if let (Some((map, s_m)), Some(agent)) = (path, self.others.iter_mut().find(|agent| Some(agent.id()) == of)) {
            agent.drive_along(map, s_m);
        }
        Ok(())
    }

    /// Returns the observation on which the advice of this agent is based; call it where a step begins.
    pub fn complete_observation(&self, agent: &Agent) -> Observation {
        agent.advice.complete_observation(&agent.observe(&self.drive))
    }
}
