//! Check of a drive before it begins, and its first moment, as quick as they can be. In: a scenario. Out: the drive as planned with its policy
//! and expected speeds, or why it cannot start.
//!
//! A closed route starts by the native engine. On a network only SUMO moves vehicles, which need not be on a computer that reads
//! the data of a study, and of which a process has one at a time: there the demand is read, and no vehicle moves.

use super::{ExpectedSpeeds, World, WorldError, advice::DriveAdvice, traffic_start};
use crate::{
    map::PathLanes,
    policy::ResolvedPolicy,
    scenario::{PlanError, PlannedDrive, Scenario},
};

/// A drive that can start.
pub struct CheckedDrive {
    pub drive: PlannedDrive,
    pub policy: ResolvedPolicy,
    pub expected_speeds: ExpectedSpeeds,
}

impl CheckedDrive {
    /// Plans a drive and checks that it can start.
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn new(scenario: &Scenario) -> Result<Self, WorldError> {
        // Leaves out settings that take long and cannot fail if the others are valid.
        let scenario = Scenario {
            warm_up_s: 0.0,
            wave_sd_mps: 0.0,
            standing_start: false,
            sham_advice: false,
            ..scenario.clone()
        };
        let drive = PlannedDrive::new(&scenario)?;
        if drive.is_open() {
            let advice = DriveAdvice::new(&drive)?;
            traffic_start::check_demand(&drive, &PathLanes::new(drive.map()))?;
            return Ok(Self { drive, policy: advice.policy, expected_speeds: advice.expected });
        }
        let native = Scenario { traffic: scenario.traffic.without_sumo(), ..scenario };
        let world = World::of(PlannedDrive::on(&native, drive.map().clone())?)?;
        Ok(Self { policy: world.policy().clone(), expected_speeds: world.expected_speeds(), drive })
    }
}

impl World {
    /// Plans a drive and starts it by the native engine, which takes no time to load, or by the scenario's own engine on a network, where
    /// the native engine moves nothing.
    ///
    /// # Errors
    /// See [`WorldError`]; the messages name the remedy.
    pub fn without_sumo(scenario: &Scenario) -> Result<Self, WorldError> {
        let native = Scenario { traffic: scenario.traffic.without_sumo(), ..scenario.clone() };
        match Self::new(&native) {
            Err(WorldError::Plan(PlanError::Setting { key: "traffic", .. })) => Self::new(scenario),
            other => other,
        }
    }
}
