//! Places of parked cars: on the drives of houses. In: buildings, the ground. Out: [`ParkedCar`]s, metres.

use super::{
    buildings::Buildings,
    plots::{DRIVE_M, DRIVE_UP_M, Plot},
    relief::Relief,
};
use glam::Vec3;

/// Number of drives of ten with a car.
const OF_TEN_PARKED: u64 = 7;
/// Largest height of a drive with a car over the ground, metres.
const LEVEL_M: f32 = 0.3;

/// Car that stands parked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParkedCar {
    /// Middle, on the ground.
    pub position: Vec3,
    pub yaw_rad: f32,
    /// Number for the choice of paint, body and plate.
    pub number: u32,
}

/// Returns the cars that stand on drives.
pub fn on_drives(buildings: &Buildings, relief: &Relief) -> Vec<ParkedCar> {
    let parked = |plot: &Plot| {
        let middle = plot.drive_point(DRIVE_M / 2.0).filter(|_| plot.seed % 10 < OF_TEN_PARKED)?;
        let ground_m = plot.ground_m(relief);
        // On a slope the drive would be above the ground.
        (ground_m - relief.height_m(middle) < LEVEL_M).then_some(())?;
        let is_backwards = (plot.seed / 10).is_multiple_of(2);
        let yaw_rad = plot.inwards.to_angle() + if is_backwards { std::f32::consts::PI } else { 0.0 };
        Some(ParkedCar { position: middle.extend(ground_m + DRIVE_UP_M), yaw_rad, number: (plot.seed % 9000) as u32 })
    };
    buildings.plots.iter().filter_map(parked).collect()
}
