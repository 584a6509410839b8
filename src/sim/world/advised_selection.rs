//! Choice of the vehicles that are advised beside the participant's. In: a planned drive. Out: for each vehicle that enters, whether it is one.

use crate::{
    rng,
    scenario::{AdvisedVehicles, PlannedDrive},
    traffic::VehicleId,
};

pub(super) enum AdvisedSelection {
    /// Vehicle numbers, ascending: spread evenly over a fixed number of vehicles.
    Numbers(Vec<u32>),
    /// Each vehicle by chance, from a random stream of its own.
    Share {
        /// Probability that a vehicle is advised, 0 to 1.
        share: f64,
        /// Seed of the drive.
        seed: u64,
    },
}

impl AdvisedSelection {
    /// Returns the choice of a drive, out of a fixed number of vehicles or of those that enter.
    pub fn new(drive: &PlannedDrive) -> Self {
        match drive.advised() {
            AdvisedVehicles::Count(_) => Self::Numbers(drive.advised_others()),
            AdvisedVehicles::Share(share) => Self::Share { share, seed: drive.scenario().seed },
        }
    }

    /// Returns true if any vehicle can be chosen.
    pub fn can_be_others(&self) -> bool {
        match self {
            Self::Numbers(numbers) => !numbers.is_empty(),
            Self::Share { share, .. } => *share > 0.0,
        }
    }

    /// Returns true if this vehicle is advised.
    pub fn has(&self, id: VehicleId) -> bool {
        match self {
            Self::Numbers(numbers) => numbers.binary_search(&id.0).is_ok(),
            Self::Share { share, seed } => {
                rng::stream(*seed, &format!("vehicle/{}/advised", id.0)).uniform(0.0, 1.0) < *share
            }
        }
    }
}
