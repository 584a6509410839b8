//! A world whose advice is said from outside, as by a learner. In: a scenario, who drives; at each hold what is advised to whom. Out: who
//! can be advised, and what each of them knows when its advice is due. No policy is chosen or asked.
//!
//! It is driven as any other, by [`World::tick`]. Whoever advises calls [`World::meet_agents`] where a step begins; [`World::told`] says what
//! each of [`World::agents`] knows, and [`World::advise`] takes what is advised from this step on.

use super::{Agent, World, WorldError, advice::AdviceSource, present};
use crate::{
    driver::{DriverError, DriverParams},
    policy::{Action, Observation},
    scenario::Scenario,
    traffic::VehicleId,
};
use std::sync::Arc;

/// Who drives an advised vehicle that is not the participant's.
pub type AgentDrivers = Arc<dyn Fn(VehicleId) -> Result<DriverParams, DriverError> + Send + Sync>;

/// What a world is told of whoever advises from outside.
#[derive(Clone, Default)]
pub struct OutsideSettings {
    /// He sees who drives in the lanes beside. Looking for them takes memory, which a drive does without.
    pub sees_lanes_beside: bool,
    /// Who drives the other advised vehicles; `None`: the scenario's driver.
    pub drivers: Option<AgentDrivers>,
}

impl World {
    /// As [`World::new`], with advice from outside.
    ///
    /// # Errors
    /// See [`WorldError`].
    pub fn advised_from_outside(scenario: &Scenario, outside: OutsideSettings) -> Result<Self, WorldError> {
        let OutsideSettings { sees_lanes_beside, drivers } = outside;
        Self::advised_by(scenario, drivers, |scenario, map| {
            Ok(AdviceSource::from_outside(scenario, map, sees_lanes_beside))
        })
    }

    /// Where a step begins: vehicles whose way is over leave, and those that are to be advised become agents, so that they can be advised
    /// from this step on. Without effect within a step.
    ///
    /// # Errors
    /// The traffic engine failed; the drive cannot go on.
    pub fn meet_agents(&mut self) -> Result<(), WorldError> {
        if self.ended.is_some() || self.is_prepared || !self.begins_step() {
            return Ok(());
        }
        self.renew_agents()
    }

    /// All that are advised now: the participant's vehicle first, if it is there, then the others by ascending id.
    pub fn agents(&self) -> &[Agent] {
        &self.agents[usize::from(self.snapshot().is_without_ego)..]
    }

    /// Says what is advised to the `index`th of [`World::agents`] from the step on that begins next; without effect beyond the last.
    pub fn advise(&mut self, index: usize, action: Action) {
        if let Some(agent) = present(&mut self.agents).get_mut(index) {
            agent.advice.say(action);
        }
    }

    /// What whoever advises this agent of the world is told where a step begins.
    pub fn told(&self, agent: &Agent) -> Observation {
        agent.advice.told(&agent.observe(self.scenario.vehicles))
    }
}
