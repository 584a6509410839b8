//! Choice of the vehicles that are advised beside the participant's. In: a planned drive. Out: for each vehicle that enters, whether it is one.

use crate::{
    rng,
    scenario::{AdvisedVehicles, PlannedDrive, Scenario},
    traffic::{EGO, VehicleId},
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
        let Scenario { vehicles, seed, participant, .. } = *drive.scenario();
        match drive.advised() {
            advised @ AdvisedVehicles::Count(_) => {
                // Without a participant the first advised vehicle is one of the traffic, too.
                let first = (!participant && !advised.is_no_vehicle()).then_some(EGO.0);
                Self::Numbers(first.into_iter().chain(advised.others(vehicles)).collect())
            }
            AdvisedVehicles::Share(share) => Self::Share { share, seed },
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
