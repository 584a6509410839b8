//! Sham advice: the advice of another drive with the same settings, another seed and a simulated driver. In: a scenario. Out: its target of
//! each hold. Timing and size are those of the policy; they are unrelated to the traffic of this drive.
//!
//! Another seed alone is not enough: from a bunched start the wave returns at nearly the same time in every drive. Therefore the advice
//! starts at a random point in the middle half of the other drive and wraps around at its end.

use super::{World, WorldError};
use crate::{
    driver::DriverParams,
    policy::ReplayedAdvice,
    rng,
    scenario::{PlannedDrive, Scenario},
    traffic::{EngineChoice, FollowingModel},
};
use std::sync::Arc;

/// Length of the other drive for a drive without an end, seconds; its advice then repeats.
const ENDLESS_S: f64 = 600.0;

/// Upper limit of seeds, so that all readers keep them exactly.
const MOST_SEED: usize = 1 << 53;

/// Runs the other drive and returns its advice.
pub(super) fn advice(drive: &PlannedDrive) -> Result<ReplayedAdvice, WorldError> {
    let scenario = drive.scenario();
    let other = other_drive(scenario);
    let mut world = World::of(PlannedDrive::on(&other, Arc::clone(drive.map()))?)?;
    let driver = world.simulated_driver(&DriverParams::default(), other.seed)?;
    let mut driver = if other.standing_start { driver.with_foot_on_brake() } else { driver };
    let hold_ticks = u64::from(other.hold().steps()) * other.step_ticks();
    let mut targets_mps = Vec::new();
    while world.ended().is_none() {
        let is_first = world.snapshot().tick.0.is_multiple_of(hold_ticks);
        let controls = driver.controls(&world.perceived_by(&driver));
        world.tick(&controls)?;
        if is_first {
            targets_mps.push(world.snapshot().advice.map(|advice| advice.target_mps));
        }
    }
    let later = rng::stream(scenario.seed, "sham advice begins").uniform(0.25, 0.75) * targets_mps.len() as f64;
    targets_mps.rotate_left(later.round() as usize);
    Ok(ReplayedAdvice::new(targets_mps, other.hold().seconds()))
}

/// Returns the scenario of the other drive. Its engine is the native one, as SUMO runs once a process.
pub(super) fn other_drive(scenario: &Scenario) -> Scenario {
    let duration_s = if scenario.duration_s > 0.0 { scenario.duration_s } else { ENDLESS_S };
    Scenario {
        sham_advice: false,
        seed: rng::stream(scenario.seed, "sham advice").index(MOST_SEED) as u64,
        traffic: EngineChoice::Native,
        other_model: FollowingModel::Idm,
        duration_s,
        ..scenario.clone()
    }
}
