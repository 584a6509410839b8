//! Participants as simulated drivers. In: analysed drives. Out: a [`ParticipantDriver`] for each participant; `drivers.toml`,
//! with which a rehearsal drives as these participants did.

use super::driver_fit::{FoundDriver, FoundNumber, fit};
use crate::analysis::{data::DriverStretches, drives::AnalysedRecording};
use crate::driver::{DRIVERS_FORMAT, DriversFile, FittedDriver};
use rayon::prelude::*;

/// A participant, described by the numbers of the simulated driver.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticipantDriver {
    /// `sub-P03`; empty outside of a study.
    pub participant: String,
    /// Numbers fitted to the drives.
    pub found: FoundDriver,
}

impl FoundDriver {
    /// Returns the numbers in the order of the table: reaction, bias, error, time gap.
    pub fn numbers(&self) -> [Option<FoundNumber>; 4] {
        [self.reaction_s, self.speed_bias_mps, self.error_mps, self.time_gap_factor]
    }
}

/// Fits each participant of these drives, in the order of their first drives.
pub fn drivers(drives: &[AnalysedRecording]) -> Vec<ParticipantDriver> {
    let mut each: Vec<(&str, Vec<&DriverStretches>)> = Vec::new();
    for drive in drives {
        let participant = drive.found.participant.as_str();
        match each.iter_mut().find(|(other, _)| *other == participant) {
            Some((_, of)) => of.push(&drive.stretches),
            None => each.push((participant, vec![&drive.stretches])),
        }
    }
    let one = |(participant, of): (&str, Vec<&DriverStretches>)| ParticipantDriver {
        participant: participant.into(),
        found: fit(&of),
    };
    each.into_par_iter().map(one).collect()
}

/// Returns the file of the participants with at least one number, as `codrive study rehearse --drivers` reads it.
pub fn drivers_toml(study: &str, drivers: &[ParticipantDriver]) -> String {
    let one = |driver: &ParticipantDriver| {
        let value = |number: Option<FoundNumber>| number.map(|number| number.value);
        FittedDriver {
            participant: Some(driver.participant.clone()).filter(|code| !code.is_empty()),
            reaction_s: value(driver.found.reaction_s),
            error_mps: value(driver.found.error_mps),
            speed_bias_mps: value(driver.found.speed_bias_mps),
            time_gap_factor: value(driver.found.time_gap_factor),
        }
    };
    let driver = drivers.iter().filter(|driver| driver.found != FoundDriver::default()).map(one).collect();
    DriversFile { format: DRIVERS_FORMAT.into(), study: study.into(), driver }.text()
}
