//! The other vehicles of a drive between two steps of their engine, on a closed route with a fixed number of cars (`ring_coupling`) or
//! on a network where they come and go (`network_coupling`). In: once a step, where the agents are and where they will be; once a tick,
//! how much of the step has passed. Out: the other vehicles in the participant's snapshot of that tick, and those that can be touched.
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
use std::{path::PathBuf, sync::Arc};

/// Where a vehicle is put on the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StartPlace {
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
}

/// Traffic, of either kind.
pub(super) enum TrafficCoupling {
    /// A fixed number of cars on a closed route.
    Ring(Box<RingCoupling>),
    /// Vehicles that come and go on a network.
    Network(Box<NetworkCoupling>),
}

impl TrafficCoupling {
    /// Starts the traffic of a scenario and lets it run until the ego is put in.
    pub fn start(scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Self, WorldError> {
        let _starting = TrafficStart::begin();
        Ok(if scenario.is_on_network() {
            Self::Network(Box::new(NetworkCoupling::start(scenario, map)?))
        } else {
            Self::Ring(Box::new(RingCoupling::start(scenario, map)?))
        })
    }

    /// Where the ego is put; of no meaning without a participant.
    pub fn ego_start(&self) -> StartPlace {
        match self {
            Self::Ring(ring) => {
                let (ego, _) = ring.at_next_step();
                StartPlace { s_m: ego.s_m, speed_mps: ego.speed_mps }
            }
            Self::Network(network) => network.ego_start(),
        }
    }

    /// Vehicles that become agents beside the ego: on a closed route once, before the drive, on a network as they come.
    pub fn new_agents(&mut self, scenario: &Scenario, map: &Arc<RoadMap>) -> Result<Vec<NewAgent>, TrafficError> {
        match self {
            Self::Ring(ring) => Ok(ring.new_agents(scenario, map)),
            Self::Network(network) => network.new_agents(scenario),
        }
    }

    /// True if an agent's way is over for the engine.
    pub fn has_arrived(&self, id: VehicleId) -> bool {
        match self {
            Self::Ring(_) => false,
            Self::Network(network) => network.has_arrived(id),
        }
    }

    /// How many bodies of other vehicles the ego's physics makes ready.
    pub fn bodies(&self) -> usize {
        match self {
            Self::Ring(ring) => ring.at_next_step().1.len(),
            Self::Network(_) => 0,
        }
    }

    /// Puts all vehicles, and what signals show, into a snapshot of the first tick.
    pub fn first_view(&mut self, snapshot: &mut Snapshot, route: &Route) {
        match self {
            Self::Ring(ring) => {
                let cars = ring.at_next_step().1.iter();
                snapshot.cars = cars.map(|car| VehicleSnapshot::at_start(car, car.pose(route))).collect();
            }
            Self::Network(network) => network.first_view(snapshot),
        }
    }

    /// Has the engine make the next step, and tells it where the agents are and where they will be at its end.
    pub fn ask(&mut self, agents: &[Agent], step_s: f64) -> Result<(), TrafficError> {
        match self {
            Self::Ring(ring) => ring.ask(agents, step_s),
            Self::Network(network) => network.ask(agents),
        }
    }

    /// The step that was asked for begins.
    pub fn begin_step(&mut self, snapshot: &Snapshot) {
        match self {
            Self::Ring(ring) => ring.begin_step(),
            Self::Network(network) => network.begin_step(snapshot),
        }
    }

    /// All vehicles that are no agents go to the place that they have `fraction` of the way through the step.
    pub fn move_cars(&mut self, snapshot: &mut Snapshot, map: &RoadMap, fraction: f64) {
        match self {
            Self::Ring(ring) => ring.move_cars(snapshot, &map.route, fraction),
            Self::Network(network) => network.move_vehicles(snapshot, fraction),
        }
    }

    /// The vehicles near the ego where [`TrafficCoupling::move_cars`] has put them.
    pub fn obstacles(&self) -> &[Obstacle] {
        match self {
            Self::Ring(ring) => ring.obstacles(),
            Self::Network(network) => network.obstacles(),
        }
    }

    /// How traffic was when the driver took over.
    pub fn hand_over(&self) -> HandOver {
        match self {
            Self::Ring(ring) => ring.hand_over,
            Self::Network(network) => network.hand_over,
        }
    }

    /// Lets go of the engine; no step follows.
    pub fn stop(&mut self) {
        match self {
            Self::Ring(ring) => ring.stop(),
            Self::Network(network) => network.stop(),
        }
    }

    /// True once [`TrafficCoupling::stop`] was called.
    pub fn is_stopped(&self) -> bool {
        match self {
            Self::Ring(ring) => ring.is_stopped(),
            Self::Network(network) => network.is_stopped(),
        }
    }

    /// The engine's name and version.
    pub fn describe(&self) -> String {
        match self {
            Self::Ring(ring) => ring.describe(),
            Self::Network(network) => network.describe(),
        }
    }

    /// The files of demand that SUMO reads.
    pub fn demand_files(&self) -> &[PathBuf] {
        match self {
            Self::Ring(_) => &[],
            Self::Network(network) => network.demand_files(),
        }
    }

    /// The coupling of a closed route.
    #[cfg(test)]
    pub fn ring(&mut self) -> &mut RingCoupling {
        match self {
            Self::Ring(ring) => ring,
            Self::Network(_) => panic!("this drive is on a network"),
        }
    }
}
