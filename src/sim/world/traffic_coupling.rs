//! The other vehicles of a drive between two steps of their engine, on a closed route with a fixed number of vehicles (`ring_coupling`) or
//! on a network where they enter and leave (`network_coupling`). In: once a step, the agents' present and predicted states; once a tick,
//! the elapsed share of the step. Out: the other vehicles in the participant's snapshot of that tick, and those near the ego as obstacles.
//! Metres, m/s.

use super::{
    WorldError,
    agent::{Agent, NewAgent},
    hand_over::HandOver,
    network_coupling::NetworkCoupling,
    ring_coupling::RingCoupling,
};
use crate::{
    ego::Obstacle,
    map::{RoadMap, Route},
    scenario::Scenario,
    sim::{Snapshot, snapshot::VehicleSnapshot},
    traffic::{TrafficError, TrafficStart, VehicleId},
};
use std::{path::PathBuf, sync::Arc, time::Duration};

/// Start of a vehicle on the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StartPlace {
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Speed at the start, m/s.
    pub speed_mps: f64,
}

/// Coupling to traffic of either kind.
pub(super) enum TrafficCoupling {
    /// A fixed number of vehicles on a closed route.
    Ring(Box<RingCoupling>),
    /// Vehicles that enter and leave on a network.
    Network(Box<NetworkCoupling>),
}

impl TrafficCoupling {
    /// Starts the traffic of a scenario and runs it until the ego is inserted.
    pub fn start(scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Self, WorldError> {
        let _starting = TrafficStart::begin();
        Ok(if scenario.is_on_network() {
            Self::Network(Box::new(NetworkCoupling::start(scenario, map)?))
        } else {
            Self::Ring(Box::new(RingCoupling::start(scenario, map)?))
        })
    }

    /// Returns the start of the ego; without meaning if there is no participant.
    pub fn ego_start(&self) -> StartPlace {
        match self {
            Self::Ring(ring) => {
                let (ego, _) = ring.at_next_step();
                StartPlace { s_m: ego.s_m, speed_mps: ego.speed_mps }
            }
            Self::Network(network) => network.ego_start(),
        }
    }

    /// Returns the vehicles that become agents in addition to the ego: on a closed route once, before the drive; on a network as they
    /// enter.
    pub fn new_agents(&mut self, scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Vec<NewAgent>, TrafficError> {
        match self {
            Self::Ring(ring) => Ok(ring.new_agents(scenario, map)),
            Self::Network(network) => network.new_agents(scenario),
        }
    }

    /// Returns true if an agent has arrived in the engine.
    pub fn has_arrived(&self, id: VehicleId) -> bool {
        match self {
            Self::Ring(_) => false,
            Self::Network(network) => network.has_arrived(id),
        }
    }

    /// Returns the number of other vehicles to prepare bodies for in the ego's physics.
    pub fn bodies(&self) -> usize {
        match self {
            Self::Ring(ring) => ring.at_next_step().1.len(),
            Self::Network(_) => 0,
        }
    }

    /// Puts all vehicles and the states of signals into the snapshot of the first tick.
    pub fn first_view(&mut self, snapshot: &mut Snapshot, route: &Route) {
        match self {
            Self::Ring(ring) => {
                let cars = ring.at_next_step().1.iter();
                snapshot.cars = cars.map(|car| VehicleSnapshot::at_start(car, car.pose(route))).collect();
            }
            Self::Network(network) => network.first_view(snapshot),
        }
    }

    /// Returns true if the engine has been asked for the next step.
    pub fn is_asked(&self) -> bool {
        match self {
            Self::Ring(ring) => ring.is_asked(),
            Self::Network(network) => network.is_asked(),
        }
    }

    /// Asks the engine for the next step, with the agents' present states and their predictions for its end.
    pub fn ask(&mut self, agents: &[Agent], step_s: f64) -> Result<(), TrafficError> {
        match self {
            Self::Ring(ring) => ring.ask(agents, step_s),
            Self::Network(network) => network.ask(agents),
        }
    }

    /// Returns true once the step that was asked for is complete; waits for at most `patience`.
    pub fn wait(&mut self, patience: Duration) -> Result<bool, TrafficError> {
        match self {
            Self::Ring(ring) => ring.wait(patience),
            Self::Network(_) => Ok(true),
        }
    }

    /// Begins the step that was asked for.
    pub fn begin_step(&mut self, snapshot: &Snapshot) {
        match self {
            Self::Ring(ring) => ring.begin_step(),
            Self::Network(network) => network.begin_step(snapshot),
        }
    }

    /// Moves all vehicles that are not agents to their poses at `fraction` of the step.
    pub fn move_cars(&mut self, snapshot: &mut Snapshot, map: &RoadMap, fraction: f64) {
        match self {
            Self::Ring(ring) => ring.move_cars(snapshot, &map.route, fraction),
            Self::Network(network) => network.move_vehicles(snapshot, fraction),
        }
    }

    /// Returns the vehicles near the ego at the poses set by [`TrafficCoupling::move_cars`].
    pub fn obstacles(&self) -> &[Obstacle] {
        match self {
            Self::Ring(ring) => ring.obstacles(),
            Self::Network(network) => network.obstacles(),
        }
    }

    /// Returns the state of traffic at the hand-over to the driver.
    pub fn hand_over(&self) -> HandOver {
        match self {
            Self::Ring(ring) => ring.hand_over,
            Self::Network(network) => network.hand_over,
        }
    }

    /// Releases the engine; no further step is possible.
    pub fn stop(&mut self) {
        match self {
            Self::Ring(ring) => ring.stop(),
            Self::Network(network) => network.stop(),
        }
    }

    /// Returns true after a call of [`TrafficCoupling::stop`].
    pub fn is_stopped(&self) -> bool {
        match self {
            Self::Ring(ring) => ring.is_stopped(),
            Self::Network(network) => network.is_stopped(),
        }
    }

    /// Returns the engine's name and version.
    pub fn describe(&self) -> String {
        match self {
            Self::Ring(ring) => ring.describe(),
            Self::Network(network) => network.describe(),
        }
    }

    /// Returns the demand files that SUMO reads.
    pub fn demand_files(&self) -> &[PathBuf] {
        match self {
            Self::Ring(_) => &[],
            Self::Network(network) => network.demand_files(),
        }
    }

    /// Returns the coupling of a closed route.
    #[cfg(test)]
    pub fn ring(&mut self) -> &mut RingCoupling {
        match self {
            Self::Ring(ring) => ring,
            Self::Network(_) => panic!("this drive is on a network"),
        }
    }
}
