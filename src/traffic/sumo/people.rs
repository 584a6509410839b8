//! Persons at the wheels of vehicles that come and go. In: departures, then the vehicles before each step. Out: the persons' own numbers in
//! SUMO's models, and commands. A person keeps their traits from departure to arrival. Metres, m/s.
//!
//! SUMO's model drives with a person's time gap, accelerations and gap at a standstill; their noise changes the speed from which it starts.
//! A speed by the optimal velocity model is computed here and wanted of SUMO, which takes it as far as its own safe speed, right of way and
//! signals allow.

use super::{
    options::idm_of,
    shim::Shim,
    shim_data::{Command, RawCommand},
};
use crate::{
    map::network::Network,
    traffic::{
        CarFollowing, Departure, HARDEST_MPS2, LaneMotion, Leader, TrafficDriver, TrafficDrivers, TrafficError,
        VehicleId, VehicleKind, VehicleReport, VehicleState, motion::chosen_mps, noise::DriverNoise,
    },
};

/// Distance within which a driver sees a leader, m: the optimal velocity is the highest long before.
const REACH_M: f64 = 200.0;

/// Persons of a drive.
pub(super) struct People {
    drivers: TrafficDrivers,
    seed: u64,
    step_s: f64,
    /// Speed limits by number of the lane, m/s.
    limits_mps: Vec<f64>,
    /// Persons who are there, by ascending number.
    persons: Vec<Person>,
}

struct Person {
    id: VehicleId,
    driver: TrafficDriver,
    noise: DriverNoise,
}

impl People {
    /// Returns the persons of these drivers; `None` if they are alike.
    pub fn of(drivers: &TrafficDrivers, network: &Network, step_s: f64, seed: u64) -> Option<Self> {
        let limits_mps = network.lanes().iter().map(|lane| lane.speed_limit_mps).collect();
        let people = Self { drivers: drivers.clone(), seed, step_s, limits_mps, persons: Vec::new() };
        (!drivers.are_alike()).then_some(people)
    }

    /// Takes the vehicles that have come and gone: a person is at the wheel of every car.
    pub fn come_and_go(
        &mut self,
        shim: &mut Shim,
        departed: &[Departure],
        arrived: &[VehicleId],
    ) -> Result<(), TrafficError> {
        if !arrived.is_empty() {
            self.persons.retain(|person| !arrived.contains(&person.id));
        }
        let cars = departed.iter().filter(|departure| departure.body.kind == VehicleKind::Car);
        for id in cars.map(|departure| departure.id).filter(|id| !arrived.contains(id)) {
            let driver = self.drivers.driver(self.seed, id.0);
            shim.set_driver(id, &idm_of(&driver))?;
            let noise = DriverNoise::new(&driver, id, self.step_s, self.seed);
            self.persons.push(Person { id, driver, noise });
        }
        Ok(())
    }

    /// Removes the person at the wheel of a vehicle.
    pub fn leave(&mut self, id: VehicleId) {
        self.persons.retain(|person| person.id != id);
    }

    /// Adds the commands for the next step of all cars that are neither reported nor moved from outside.
    pub fn command(
        &mut self,
        shim: &Shim,
        vehicles: &[VehicleState],
        (reports, motions): (&[VehicleReport], &[LaneMotion]),
        commands: &mut Vec<RawCommand>,
    ) -> Result<(), TrafficError> {
        let mut vehicles = vehicles.iter().peekable();
        for Person { id, driver, noise } in &mut self.persons {
            while vehicles.next_if(|vehicle| vehicle.id < *id).is_some() {}
            let Some(vehicle) = vehicles.next_if(|vehicle| vehicle.id == *id) else { continue };
            let from_mps = noise.push(vehicle.speed_mps);
            let is_moved = motions.binary_search_by_key(id, |motion| motion.id).is_ok();
            if is_moved || reports.binary_search_by_key(id, |report| report.id).is_ok() {
                continue;
            }
            if from_mps != vehicle.speed_mps {
                commands.push(Command::PreviousSpeed(from_mps).encode(*id));
            }
            if let (CarFollowing::OptimalVelocity(model), Some(lane)) = (&driver.model, vehicle.lane) {
                let leader = shim.leader(*id, REACH_M)?;
                let (gap_m, leader_mps) =
                    leader.map_or((REACH_M, from_mps), |Leader { gap_m, speed_mps, .. }| (gap_m, speed_mps));
                let limit_mps = self.limits_mps[lane.index()];
                let accel =
                    model.acceleration(from_mps, leader_mps, gap_m, limit_mps).clamp(-HARDEST_MPS2, HARDEST_MPS2);
                let wanted_mps = chosen_mps(from_mps, accel, self.step_s);
                commands.push(Command::WantedSpeed(Some(wanted_mps)).encode(*id));
            }
        }
        Ok(())
    }
}
