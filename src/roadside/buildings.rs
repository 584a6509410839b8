//! Places of buildings, by the footprints of a map or along the streets of a town by the program's own rules. In: a network, its paved
//! surfaces, a seed. Out: plots and blocks, metres.

use super::{
    footprint_places::{self, Block},
    land_use_map::LandUseMap,
    plots::{Plot, PlotSquares, plots},
    road_surfaces::{RoadSurfaces, SurfaceCollector},
    town::{PAVEMENT_M, Town},
};
use crate::map::{
    SHOULDER_M,
    network::{EdgeId, Network},
    surroundings::LandUse,
};
use glam::{Vec2, Vec3};

/// Width of bare ground beside walls and pavements, metres.
const BARE_M: f32 = 0.3;

/// Least distance of a building from those that a map states, metres: near them it states the others, too.
const UNSTATED_M: f32 = 35.0;
/// Types of streets that lead to homes (OpenStreetMap's key `highway`).
const HOMES: [&str; 2] = ["highway.residential", "highway.living_street"];

/// Buildings of a network.
#[derive(Debug, Default)]
pub struct Buildings {
    /// Buildings that are rectangles.
    pub plots: Vec<Plot>,
    squares: PlotSquares,
    /// Buildings of any outline.
    pub blocks: Vec<Block>,
    /// Outlines of the blocks; `None` without any.
    block_outlines: Option<RoadSurfaces>,
    /// Lanes of the town's streets and junctions; `None` without a town.
    streets: Option<RoadSurfaces>,
}

impl Buildings {
    /// Places the buildings of a network: those that its map states, and others along streets where it states none but may have left them
    /// out.
    pub fn of(net: &Network, town: &Town, land_use: &LandUseMap, roads: &RoadSurfaces, seed: u64) -> Self {
        let (stated, blocks) = footprint_places::built(&net.surroundings().buildings, roads, seed);
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
        let is_paved = |streets: &RoadSurfaces| streets.border_m(point) < SHOULDER_M as f32 + PAVEMENT_M + BARE_M;
        self.distance_m(point) < BARE_M || self.streets.as_ref().is_some_and(is_paved)
    }

    /// Returns the distance of a point from the nearest building, metres; not exact if none is within 20 m. Inside a building it is 0.
    pub fn distance_m(&self, point: Vec2) -> f32 {
        let near = self.squares.near(point).iter().map(|plot| plot.distance_m(point));
        near.chain(self.block_outlines.iter().map(|blocks| blocks.border_m(point))).fold(f32::INFINITY, f32::min)
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

#[cfg(test)]
#[path = "building_tests.rs"]
mod tests;
