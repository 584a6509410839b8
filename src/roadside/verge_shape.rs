//! Width and depth of the verges of a network. In: its paved surfaces. Out: a [`VergeShape`], which the roadside and the land around it
//! share. Metres.

use super::road_surfaces::RoadSurfaces;

/// Height of the meadow beside a road at height 0, metres: below the asphalt, above the foot of the verge.
pub const BESIDE_ROAD_M: f32 = -0.045;

/// Width and depth of a verge.
#[derive(Clone, Copy, Debug)]
pub struct VergeShape {
    pub width_m: f64,
    pub foot_m: f32,
    /// Height of the meadow beside roads relative to them, metres.
    pub meadow_m: f32,
}

impl VergeShape {
    /// Returns the shape of the verges of a network. On networks that are not level, the land follows the roads in cells of some metres. It
    /// lies lower there, so that it does not cover the asphalt, and the verge reaches further down.
    pub fn of(surfaces: &RoadSurfaces) -> Self {
        if surfaces.level_m().is_some() {
            Self { width_m: 1.7, foot_m: -0.14, meadow_m: BESIDE_ROAD_M }
        } else {
            Self { width_m: 2.4, foot_m: -0.8, meadow_m: -0.25 }
        }
    }
}
