//! One SUMO simulation, wherever it runs. In: the same calls for both. Out: the same records.

use super::{
    remote::Remote,
    shim::{Command, Record, Shim, VehicleType},
};
use crate::{space::SumoPose, traffic::TrafficError};
use std::time::Duration;

/// Where it runs.
pub(super) enum Simulation {
    /// In this process.
    Here(Shim),
    /// Behind a socket.
    Elsewhere(Box<Remote>),
}

impl Simulation {
    /// Numbers the lanes.
    pub fn set_lanes(&mut self, ids: &[String]) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.set_lanes(ids),
            Self::Elsewhere(remote) => {
                remote.set_lanes(ids);
                Ok(())
            }
        }
    }

    /// Length, metres, and speed limit, m/s, of a lane by its number.
    pub fn lane(&mut self, lane: usize) -> Result<(f64, f64), TrafficError> {
        match self {
            Self::Here(shim) => shim.lane(lane),
            Self::Elsewhere(remote) => remote.lane(lane),
        }
    }

    /// Closes lanes to passenger cars in this simulation.
    pub fn close_lanes(&mut self, ids: &[String]) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.close_lanes(ids),
            Self::Elsewhere(remote) => remote.close_lanes(ids),
        }
    }

    /// Makes a vehicle type.
    pub fn add_type(&mut self, base: &str, name: &str, values: &VehicleType) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.add_type(base, name, values),
            Self::Elsewhere(remote) => remote.add_type(base, name, values),
        }
    }

    /// Makes a route of edges.
    pub fn add_route(&mut self, id: &str, edges: &[String]) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.add_route(id, edges),
            Self::Elsewhere(remote) => remote.add_route(id, edges),
        }
    }

    /// Puts the next car (its name, its route, its type) on the road: lane by number, position in metres, speed in m/s.
    pub fn add_car(
        &mut self,
        names: (&str, &str, &str),
        lane: usize,
        position_m: f64,
        speed_mps: f64,
    ) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.add_car(names, lane, position_m, speed_mps),
            Self::Elsewhere(remote) => remote.add_car(names, lane, position_m, speed_mps),
        }
    }

    /// All cars as they were put on the road.
    pub fn read(&mut self, records: &mut [Record]) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.read(records),
            Self::Elsewhere(remote) => {
                remote.read(records);
                Ok(())
            }
        }
    }

    /// Begins a step after these commands; in this process that is the whole step.
    pub fn begin(&mut self, commands: &[Command], step_s: f64, records: &mut [Record]) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.frame(commands, step_s, records),
            Self::Elsewhere(remote) => remote.begin(commands),
        }
    }

    /// True once the step is over, with all cars in the order in which they were added; waits `patience` at most.
    pub fn finish(&mut self, patience: Duration, records: &mut [Record]) -> Result<bool, TrafficError> {
        match self {
            Self::Here(_) => Ok(true),
            Self::Elsewhere(remote) => remote.finish(patience, records),
        }
    }

    /// A step and nothing else, where SUMO is in this process.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        match self {
            Self::Here(shim) => shim.bare_step(),
            Self::Elsewhere(_) => Err(TrafficError::Setup("a bare step is for SUMO in this process".into())),
        }
    }

    /// Where SUMO itself draws a car.
    pub fn pose(&mut self, car: u32) -> Result<SumoPose, TrafficError> {
        match self {
            Self::Here(shim) => shim.pose(car),
            Self::Elsewhere(remote) => remote.pose(car),
        }
    }
}
