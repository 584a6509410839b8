//! Drivers of the other vehicles. In: the model of the ring study, or a population of measured people. Out: a [`TrafficDriver`] for each
//! vehicle: the car-following model with their own parameters and the noise of their acceleration. SI units.

mod following;
mod population;

pub use following::{AccelNoise, CarFollowing, TrafficDriver};
pub use population::{
    PersonCorrelation, PersonParameter, PopulationError, PopulationModel, RING_STUDY, TrafficPopulation, is_path, names,
};

use crate::{idm::IdmParams, rng};
use std::sync::Arc;

/// Drivers of a drive's traffic.
#[derive(Clone, Debug, PartialEq)]
pub enum TrafficDrivers {
    /// All alike, with this model and Flow's noise.
    Alike(IdmParams),
    /// Each a person of a population.
    People(Arc<TrafficPopulation>),
}

impl TrafficDrivers {
    /// Returns the drivers of this name or file; `idm` is the model of [`RING_STUDY`].
    ///
    /// # Errors
    /// The name is unknown, or the file cannot be read or is invalid.
    pub fn named(name: &str, idm: IdmParams) -> Result<Self, PopulationError> {
        if name == RING_STUDY {
            return Ok(Self::Alike(idm));
        }
        Ok(Self::People(Arc::new(TrafficPopulation::named(name)?)))
    }

    /// Returns the driver of vehicle `id`: the same seed and number give the same person.
    pub fn driver(&self, seed: u64, id: u32) -> TrafficDriver {
        match self {
            Self::Alike(idm) => TrafficDriver::of_ring_study(*idm),
            Self::People(population) => population.draw(&mut rng::stream(seed, &format!("person/{id}"))),
        }
    }

    /// Returns the drivers of `count` vehicles from number 0.
    pub fn drivers(&self, seed: u64, count: usize) -> Vec<TrafficDriver> {
        (0..count as u32).map(|id| self.driver(seed, id)).collect()
    }

    /// Returns the driver with the mean of every parameter.
    pub fn typical(&self) -> TrafficDriver {
        match self {
            Self::Alike(idm) => TrafficDriver::of_ring_study(*idm),
            Self::People(population) => population.typical(),
        }
    }

    /// Returns true if no vehicle's driver differs from another's.
    pub fn are_alike(&self) -> bool {
        matches!(self, Self::Alike(_))
    }
}
