//! Facades as data for `building.wgsl`: width of the bays, number and use of storeys, kind of windows. In: a [`Facade`]. Out: bits above the
//! material's number in a vertex. Metres.

use crate::{
    roadside::{
        footprint_places::STOREY_M,
        house_plans::{BAY_STEP_M, GroundFloor, WindowKind, bays},
    },
    scene::Material,
};

/// Height of a ground floor with shops, metres.
pub(super) const SHOP_M: f32 = 3.6;

/// Openings of a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facade {
    /// Width of a bay, which has one window in each storey, metres.
    pub bay_m: f32,
    /// Number of storeys with windows, at most 7.
    pub storeys: u32,
    pub windows: WindowKind,
    /// True for brick, false for plaster.
    pub is_brick: bool,
    pub ground: GroundFloor,
    /// Number from which the shader draws curtains, shutters and lit windows.
    pub seed: u8,
}

impl Facade {
    /// Returns the facade with bays of nearly `wanted_m` along a wall of length `length_m`, and the wall's length in its bays.
    pub fn along(self, length_m: f32, wanted_m: f32) -> (Self, f32) {
        let (bay_m, along_m) = bays(length_m, wanted_m);
        (Self { bay_m, ..self }, along_m)
    }

    /// Returns the facade without openings.
    pub fn blank(self) -> Self {
        Self { ground: GroundFloor::Blank, ..self }
    }

    /// Returns the height of the wall's top over its ground floor, metres.
    pub fn height_m(&self) -> f32 {
        let first_m = if self.ground == GroundFloor::Shops { SHOP_M } else { STOREY_M };
        first_m + (self.storeys as f32 - 1.0) * STOREY_M
    }

    /// Returns the number for a vertex's material.
    pub fn material(&self) -> u32 {
        let bay = (self.bay_m / BAY_STEP_M).round() as u32;
        let look = self.windows as u32 | u32::from(self.is_brick) << 2;
        Material::Wall as u32
            | bay << 8
            | self.storeys << 14
            | look << 17
            | (self.ground as u32) << 20
            | u32::from(self.seed) << 22
    }
}
