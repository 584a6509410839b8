//! Ground around the roads: meadow, flat near a road and rolling further out, hills on the horizon, water below its banks. In: paved surfaces,
//! kinds of land, a seed. Out: heights, metres.

use super::{
    land_use_map::{BORDER_M, LandUseMap},
    noise,
    road_surfaces::RoadSurfaces,
    verge_shape::VergeShape,
};
use crate::{map::surroundings::LandUse, space::smoothstep};
use glam::{Vec2, Vec3};

/// Distance from the centre line up to which the land is flat, metres.
const FLAT_M: f32 = 15.0;

/// Kinds of land with a paved ground, beside and between which grass may grow.
const PAVED: [LandUse; 2] = [LandUse::Paved, LandUse::Commercial];
/// Depth of water below the meadow, metres, and distances from a road over which its bank falls.
const WATER_M: f32 = 0.7;
const BANK_M: [f32; 2] = [3.0, 9.0];
/// Largest distance from the nearest road at which a map's own kinds of land are drawn, metres.
const STATED_M: f32 = 400.0;

/// Heights of the ground, and kinds of land on it.
#[derive(Clone, Copy, Debug)]
pub struct Relief<'a> {
    pub roads: &'a RoadSurfaces,
    pub land_use: &'a LandUseMap,
    pub seed: u64,
    /// Height of the meadow relative to the road beside it, metres.
    beside_m: f32,
}

impl<'a> Relief<'a> {
    /// Creates the ground around the roads.
    pub fn new(roads: &'a RoadSurfaces, land_use: &'a LandUseMap, seed: u64) -> Self {
        let beside_m = VergeShape::of(roads).meadow_m;
        Self { roads, land_use, seed, beside_m }
    }

    /// Returns the height of the ground in the local frame, metres.
    pub fn height_m(&self, point: Vec2) -> f32 {
        let distance = self.roads.middle_m(point);
        let rolling = smoothstep(FLAT_M, 75.0, distance);
        let waves = 0.9 * noise::value(self.seed ^ 1, point / 48.0) + 0.35 * noise::value(self.seed ^ 2, point / 19.0);
        // Hills begin outside the network, so that a large network has none in its middle.
        let beyond = (point.distance(self.roads.centre()) - self.roads.radius_m()).min(distance);
        let hills = smoothstep(110.0, 620.0, beyond);
        let ridge = 0.5 + 0.5 * noise::fractal(self.seed ^ 3, point / 420.0);
        // Ranges on the horizon, some kilometres away, rising with distance.
        let range = 0.5 + 0.5 * noise::fractal(self.seed ^ 9, point / 2300.0);
        let ranges = smoothstep(1000.0, 4400.0, beyond) * (60.0 + 560.0 * range * range);
        let base_m = self.beside_m + self.roads.height_m(point);
        let water = smoothstep(0.0, 0.5 * BORDER_M, self.land_use.depth_m(point, &[LandUse::Water]));
        let lake_m = WATER_M * water * smoothstep(BANK_M[0], BANK_M[1], distance);
        let above_m = ranges + rolling * (waves + 0.2) + hills * (9.0 + 38.0 * ridge * ridge);
        base_m + above_m * (1.0 - water) - lake_m
    }

    /// Returns how deep a point lies within paved ground and within water, metres, for the shader (`land.wgsl`).
    pub fn paved_and_water_m(&self, point: Vec2) -> Vec2 {
        if !self.land_use.is_stated() || self.roads.middle_m(point) > STATED_M {
            return Vec2::splat(-BORDER_M);
        }
        Vec2::new(self.land_use.depth_m(point, &PAVED), self.land_use.depth_m(point, &[LandUse::Water]))
    }

    /// Checks whether a point lies in water or on paved ground, where nothing grows.
    pub fn is_bare(&self, point: Vec2) -> bool {
        self.paved_and_water_m(point).max_element() > -0.3
    }

    /// Returns the unit normal, from heights at the distance `span_m` on either side.
    pub fn normal(&self, point: Vec2, span_m: f32) -> Vec3 {
        let rise = |d: Vec2| (self.height_m(point + d) - self.height_m(point - d)) / (2.0 * span_m);
        Vec3::new(-rise(Vec2::X * span_m), -rise(Vec2::Y * span_m), 1.0).normalize()
    }
}
