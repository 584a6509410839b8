//! Motion of the agents of a world among each other. In: their states, the traffic's vehicles. Out: one tick of physics for each, which meets
//! all others as obstacles.

use super::{World, agent::Agent, agents_mut, observer::Observer, traffic_coupling::TOUCHABLE_M};
use crate::{
    ego::{Obstacle, ObstacleId},
    sim::VehicleSnapshot,
    traffic::{EGO, VehicleId},
};

/// Obstacles for the physics of several agents; buffers that are refilled each tick.
#[derive(Default)]
pub(super) struct Touchable {
    agents: Vec<Obstacle>,
    cars: Vec<Obstacle>,
    /// Agents and vehicles near one agent.
    near: Vec<Obstacle>,
}

impl World {
    /// Moves all agents by one tick. Returns true if the participant's vehicle has begun to touch another or a fixed object.
    pub(super) fn move_agents(&mut self) -> bool {
        match &mut self.observer {
            Observer::Participant(participant) if !self.others.iter().any(Agent::is_full) => {
                participant.drive(self.traffic.obstacles())
            }
            _ => self.move_several(),
        }
    }

    /// Does the same as `move_agents` for several agents, each an obstacle to the others.
    fn move_several(&mut self) -> bool {
        let Touchable { agents, cars, near } = &mut self.touchable;
        agents.clear();
        agents.extend(self.observer.participant().into_iter().chain(&self.others).filter_map(Agent::obstacle));
        if agents.is_empty() {
            return false;
        }
        // The observer's view has all vehicles that are not full agents, at their poses of the end of this tick.
        let is_agent =
            |id: VehicleId| agents.binary_search_by_key(&ObstacleId::Vehicle(id.0), |agent| agent.id).is_ok();
        let others = self.observer.view().cars.iter().filter(|car| !is_agent(car.id));
        cars.clear();
        cars.extend(others.flat_map(VehicleSnapshot::obstacles));
        let mut has_touched = false;
        let full = agents_mut(&mut self.observer, &mut self.others).filter(|agent| agent.is_full());
        for (agent, own) in full.zip(&*agents) {
            let is_near = |other: &&Obstacle| {
                other.pose.position.distance(own.pose.position) < TOUCHABLE_M && other.is_at_height(own.height_m)
            };
            near.clear();
            near.extend(cars.iter().filter(is_near));
            near.extend(agents.iter().filter(|other| other.id != own.id).filter(is_near));
            has_touched |= agent.drive(near) && own.id == ObstacleId::Vehicle(EGO.0);
        }
        has_touched
    }
}
