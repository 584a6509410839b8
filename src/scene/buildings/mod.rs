//! Buildings as meshes. In: their places, the ground. Out: one mesh in world axes, and the cars on drives. Metres.
//!
//! `houses` builds those on plots and `blocks` those of any outline, both from the parts of `shell`. Windows, doors, bricks and tiles are drawn
//! by `building.wgsl`, from the numbers of `facade` in each vertex.

mod blocks;
mod facade;
mod houses;
mod shell;

use super::{
    CarInstance, Mesh,
    car::{self, number_plate},
    land::Relief,
    options::ordinary_paint,
    traffic_parts::style,
    vehicles,
};
use crate::{
    roadside::{
        buildings::Buildings,
        plots::{DRIVE_M, Plot},
    },
    traffic::{VehicleBody, VehicleId},
};
use glam::{Mat2, Quat, Vec3};
use rayon::prelude::*;

/// Number of drives of ten with a car.
const OF_TEN_PARKED: u64 = 7;
/// Largest height of a drive with a car over the ground, metres.
const LEVEL_M: f32 = 0.3;

/// Returns the cars that stand on drives.
pub(super) fn parked_cars(buildings: &Buildings, relief: &Relief) -> Vec<CarInstance> {
    let hubs = car::hubs();
    let parked = |plot: &Plot| {
        let middle = plot.drive_point(DRIVE_M / 2.0).filter(|_| plot.seed % 10 < OF_TEN_PARKED)?;
        let ground_m = ground_m(plot, relief);
        // On a slope the drive would be above the ground.
        (ground_m - relief.height_m(middle) < LEVEL_M).then_some(())?;
        let number = (plot.seed % 9000) as u32;
        let is_backwards = (plot.seed / 10).is_multiple_of(2);
        let yaw_rad = plot.inwards.to_angle() + if is_backwards { std::f32::consts::PI } else { 0.0 };
        let shape = vehicles::shape(&VehicleBody::CAR, 0, VehicleBody::CAR.length_m, &hubs);
        Some(CarInstance {
            position: middle.extend(ground_m + houses::DRIVE_UP_M),
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
            is_ego: false,
        })
    };
    buildings.plots.iter().filter_map(parked).collect()
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
    mesh
}

/// Returns the height of the ground around a building where it is highest, metres.
fn ground_m(plot: &Plot, relief: &Relief) -> f32 {
    let half_m = plot.width_m / 2.0;
    let corners =
        [(-half_m, 0.0), (half_m, 0.0), (half_m, plot.depth_m), (-half_m, plot.depth_m), (0.0, -plot.garden_m)];
    let heights = corners.map(|(right_m, behind_m)| relief.height_m(plot.point(right_m, behind_m)));
    heights.into_iter().fold(f32::NEG_INFINITY, f32::max)
}

/// Returns a building's mesh with its rotation and place.
fn placed(plot: &Plot, relief: &Relief) -> (Mesh, Quat, Vec3) {
    let turn = Mat2::from_cols(plot.along(), plot.inwards);
    let yaw_rad = turn.x_axis.y.atan2(turn.x_axis.x);
    (houses::model(plot), Quat::from_rotation_z(yaw_rad), plot.front.extend(ground_m(plot, relief) + houses::PLINTH_M))
}

#[cfg(test)]
mod tests;
