//! Buildings as meshes. In: their places, the ground. Out: one mesh in world axes, and parked cars. Metres.
//!
//! `houses` builds those on plots and `blocks` those of any outline, both from the parts of `shell`; `garden_ways` adds paths and drives.
//! Windows, doors, bricks and tiles are drawn by `building.wgsl`, from the numbers of `facade` in each vertex.

mod blocks;
mod facade;
mod garden_ways;
mod houses;
mod shell;

use super::{
    CarInstance, Mesh,
    car::{self, number_plate},
    options::ordinary_paint,
    traffic_parts::style,
    vehicles,
};
use crate::{
    roadside::{buildings::Buildings, parked_cars::ParkedCar, plots::Plot, relief::Relief},
    traffic::{VehicleBody, VehicleId},
};
use glam::{Mat2, Quat, Vec3};
use rayon::prelude::*;

/// Returns parked cars as they are drawn.
pub(super) fn parked_cars(cars: &[ParkedCar]) -> Vec<CarInstance> {
    let shape = vehicles::shape(&VehicleBody::CAR, 0, VehicleBody::CAR.length_m, &car::hubs());
    let parked = |&ParkedCar { position, yaw_rad, number }: &ParkedCar| CarInstance {
        position,
        rotation: Quat::from_rotation_z(yaw_rad),
        colour: ordinary_paint(VehicleId(number)),
        brake: 0.0,
        scale: shape.scale,
        hubs: shape.hubs,
        wheel_scale: shape.wheel_scale,
        steer_rad: 0.0,
        spin_rad: 0.0,
        style: style(VehicleId(number)),
        plate: number_plate::number(number),
        is_parked: true,
        is_ego: false,
    };
    cars.iter().map(parked).collect()
}

/// Returns the mesh of all buildings, in world axes.
pub(super) fn mesh(buildings: &Buildings, relief: &Relief) -> Mesh {
    let mut models: Vec<(Mesh, Quat, Vec3)> = buildings.plots.par_iter().map(|plot| placed(plot, relief)).collect();
    models.par_extend(buildings.blocks.par_iter().map(|block| {
        let heights = block.outline.iter().map(|corner| relief.height_m(*corner));
        let ground_m = heights.fold(f32::NEG_INFINITY, f32::max) + houses::PLINTH_M;
        (blocks::model(block), Quat::IDENTITY, block.outline[0].extend(ground_m))
    }));
    let mut mesh = Mesh::default();
    models.iter().for_each(|(model, turn, at)| mesh.append_placed(model, *turn, *at));
    mesh.append(&garden_ways::mesh(&buildings.plots, relief));
    mesh
}

/// Returns a building's mesh with its rotation and place.
fn placed(plot: &Plot, relief: &Relief) -> (Mesh, Quat, Vec3) {
    let turn = Mat2::from_cols(plot.along(), plot.inwards);
    let yaw_rad = turn.x_axis.y.atan2(turn.x_axis.x);
    (houses::model(plot), Quat::from_rotation_z(yaw_rad), plot.front.extend(plot.ground_m(relief) + houses::PLINTH_M))
}

#[cfg(test)]
mod tests;
