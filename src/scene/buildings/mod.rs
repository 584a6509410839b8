//! Buildings by the footprints of a map, or along the streets of a town by the program's own rules. In: a network, its paved surfaces, the
//! ground, a seed. Out: plots and blocks, and one mesh in world axes. Metres.
//!
//! `plots` says where buildings stand in a town, `ground_plans` where by footprints, `houses` how each is built from the parts of `shell`.
//! Windows, doors, bricks and tiles are drawn by `building.wgsl`, from the numbers of `facade` in each vertex.

mod facade;
mod ground_plans;
mod houses;
pub(super) mod plots;
mod shell;

use self::{
    ground_plans::Block,
    plots::{DRIVE_M, Plot, PlotSquares, plots},
};
use super::{
    CarInstance, Mesh,
    car::{self, number_plate},
    land::{Relief, land_use_map::LandUseMap},
    network::{
        layer::SHOULDER_M,
        road_surfaces::{RoadSurfaces, SurfaceCollector},
        town::{PAVEMENT_M, Town},
    },
    options::ordinary_paint,
    traffic_parts::style,
    vehicles,
};
use crate::{
    map::{
        network::{EdgeId, Network},
        surroundings::LandUse,
    },
    traffic::{VehicleBody, VehicleId},
};
use glam::{Mat2, Quat, Vec2, Vec3};
use rayon::prelude::*;

/// Width of bare ground beside walls and pavements, metres.
const BARE_M: f32 = 0.3;
/// Number of drives of ten with a car.
const OF_TEN_PARKED: u64 = 7;
/// Largest height of a drive with a car over the ground, metres.
const LEVEL_M: f32 = 0.3;

/// Least distance of a building from those that a map states, metres: near them it states the others, too.
const UNSTATED_M: f32 = 35.0;
/// Types of streets that lead to homes (OpenStreetMap's key `highway`).
const HOMES: [&str; 2] = ["highway.residential", "highway.living_street"];

/// Buildings of a network.
#[derive(Debug, Default)]
pub(super) struct Buildings {
    plots: Vec<Plot>,
    squares: PlotSquares,
    blocks: Vec<Block>,
    /// Outlines of the blocks; `None` without any.
    block_outlines: Option<RoadSurfaces>,
    /// Lanes of the town's streets and junctions; `None` without a town.
    streets: Option<RoadSurfaces>,
}

impl Buildings {
    /// Places the buildings of a network: those that its map states, and others along streets where it states none but may have left them
    /// out.
    pub fn of(net: &Network, town: &Town, land_use: &LandUseMap, roads: &RoadSurfaces, seed: u64) -> Self {
        let (stated, blocks) = ground_plans::built(&net.surroundings().buildings, roads, seed);
        let mut outlines = SurfaceCollector::default();
        for block in &blocks {
            outlines.area(&block.outline.iter().map(|corner| corner.extend(0.0)).collect::<Vec<Vec3>>());
        }
        let block_outlines = (!blocks.is_empty()).then(|| RoadSurfaces::new(outlines));
        let streets = town.surfaces(net).map(RoadSurfaces::new);
        let mut buildings = Self { blocks, block_outlines, streets, ..Self::default() };
        buildings.add(stated);
        let may_stand = |edge: EdgeId, plot: &Plot| {
            let is_apart = || buildings.distance_m(plot.middle()) > UNSTATED_M;
            !land_use.is_stated() || may_be_built_up(net, edge, land_use, plot.middle()) && is_apart()
        };
        let grown = plots(net, town, roads, seed, &may_stand);
        buildings.add(grown);
        buildings
    }

    fn add(&mut self, plots: Vec<Plot>) {
        plots.iter().for_each(|plot| self.squares.add(*plot));
        self.plots.extend(plots);
    }

    /// Checks whether the ground at a point is built on or paved, so that nothing grows there.
    pub fn is_built_on(&self, point: Vec2) -> bool {
        let is_paved = |streets: &RoadSurfaces| streets.border_m(point) < SHOULDER_M + PAVEMENT_M + BARE_M;
        self.distance_m(point) < BARE_M || self.streets.as_ref().is_some_and(is_paved)
    }

    /// Returns the distance of a point from the nearest building, metres; not exact if none is within 20 m. Inside a building it is 0.
    pub fn distance_m(&self, point: Vec2) -> f32 {
        let near = self.squares.near(point).iter().map(|plot| plot.distance_m(point));
        near.chain(self.block_outlines.iter().map(|blocks| blocks.border_m(point))).fold(f32::INFINITY, f32::min)
    }

    /// Returns the cars that stand on drives.
    pub fn parked_cars(&self, relief: &Relief) -> Vec<CarInstance> {
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
        self.plots.iter().filter_map(parked).collect()
    }

    /// Returns the mesh of all buildings, in world axes.
    pub fn mesh(&self, relief: &Relief) -> Mesh {
        let mut models: Vec<(Mesh, Quat, Vec3)> = self.plots.par_iter().map(|plot| placed(plot, relief)).collect();
        models.par_extend(self.blocks.par_iter().map(|block| {
            let heights = block.outline.iter().map(|corner| relief.height_m(*corner));
            let ground_m = heights.fold(f32::NEG_INFINITY, f32::max) + houses::PLINTH_M;
            (ground_plans::model(block), Quat::IDENTITY, block.outline[0].extend(ground_m))
        }));
        let mut mesh = Mesh::default();
        models.iter().for_each(|(model, turn, at)| mesh.append_placed(model, *turn, *at));
        mesh
    }
}

/// Checks whether buildings may stand along a street that its map does not state: on land for houses or shops, along a residential street
/// on land of no stated kind, and outside the part of the world that the map covers.
fn may_be_built_up(net: &Network, edge: EdgeId, land_use: &LandUseMap, middle: Vec2) -> bool {
    match land_use.at(middle) {
        Some(kind) => matches!(kind, LandUse::Residential | LandUse::Commercial),
        None => !land_use.covers(middle) || net.edge(edge).road_type.as_deref().is_some_and(|of| HOMES.contains(&of)),
    }
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
